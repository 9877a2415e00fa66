"""Data of a run, on any lattice, for pictures: frame, numerical errors, spectra, map and crest.

`placed` adds numbers of the run's scene. `with_looks` adds, to a run that has only snapshots, the
space-time map, the error over time and the track of the crest.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from longwave.reports.pictures.error_curve import ErrorCurve
from longwave.runs import scene_of_run
from longwave.runs.own_error import own_error_at, scaled_own_error
from longwave.scenes.observed.observables import amplitudes, cell_width, extremum
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.support.labelled_arrays import Labelled, LabelledArray, LabelledArrays
from longwave.support.user_files import shown

Array = NDArray[np.float64]

MIN_MAP_TIMES = 8
"""Least number of snapshots for which a space-time map or a curve over time is drawn."""

MIN_CARRIER_CELL = 8
"""Least number of sites in a map cell of a carrier wave whose envelope is unknown."""

LARGEST_POWER = 20
"""Largest accepted exponent p of the error unit eps**p."""

UNIT_ROUNDOFF = 2.0**-53
"""Half a unit in the last place of 1."""


def placed(data: Labelled) -> LabelledArrays:
    """Return a run with attributes of its scene, and the variable ``offset``, n - c t in sites.

    The attributes are ``eps``, ``speed`` of the frame, ``unit`` of the errors, the name of the
    ``wave``, and ``carried`` (1 for an envelope, else 0). Raises ValueError for a run without a
    readable scene.
    """
    data = LabelledArrays.of(data)
    check_run(data)
    try:
        scene = scene_of_run(data)
        attributes = data.attrs if "n" in data else {"frame_speed": 0.0, "power": 0.0, **data.attrs}
        speed, power = (float(attributes[name]) for name in ("frame_speed", "power"))
        if not 0.0 <= power <= LARGEST_POWER:
            raise ValueError(f"errors in units of eps^{power:g}")
    except (KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:150]
        raise ValueError(
            f"source must be a run with the scene that it was made from, got {reason} "
            "(write it with `longwave run SCENE --output run.nc`)"
        ) from None
    run = data.assign_attrs(
        eps=scene.eps,
        speed=speed,
        unit=scene.eps**power,
        wave="wave" if "sup_error" in data else "mKdV wave",
        carried=int(getattr(scene, "is_envelope", False)),
    )
    if "n" not in run:
        return run
    shift = speed * run["time"].values
    return run.assign(offset=LabelledArray(SNAPSHOT, run["n"].values - shift[:, np.newaxis]))


def snapshots(
    run: Labelled, half_width: int, places: Iterable[int] | None = None
) -> list[LabelledArrays]:
    """Return snapshots of a run, by their indices ``places`` or all, at the sites around c t.

    These are up to ``half_width`` sites to either side of the one next to c t. Each snapshot has
    the run's numerical error ``own``, NaN where it was not measured, and for a carrier the
    variables of `with_envelope`.
    """
    data = LabelledArrays.of(run)
    data = with_envelope(with_own(data if "offset" in data else placed(data)))
    nearby = within(data, half_width)
    indices = range(nearby.sizes["time"]) if places is None else places
    return [nearby.isel(time=index) for index in indices]


def within(run: LabelledArrays, half_width: int) -> LabelledArrays:
    """Return a run at the sites up to ``half_width`` to either side of the one next to c t."""
    return run.isel(site=np.flatnonzero(np.abs(run["site"].values) <= half_width))


SNAPSHOT, TIME, LOOK, CURVE = ("time", "site"), ("time",), ("look_time",), ("curve_time",)

_TIMED = ("error", "sup_error", "slow_time", "sideband_size", "sideband_theory")
DIMENSIONS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("strain", "analytic", "background", "n"), SNAPSHOT),
    **dict.fromkeys((*_TIMED, "time_step_error", "domain_error"), TIME),
    **dict.fromkeys(("error_curve", "error_curve_far_field", "own"), CURVE),
    "space_time": ("look_time", "map_site"),
    **dict.fromkeys(("crest_position", "crest_strain", "crest_law"), LOOK),
}
"""Dimensions of the variables that pictures use; strains may also have the dimension ``row``."""


def check_run(data: Labelled) -> None:
    """Raise ValueError if a variable of `DIMENSIONS` has dimensions or a type that no run has."""
    used = {name: data.variables[name] for name in DIMENSIONS if name in data.variables}
    for name, variable in used.items():
        dims = tuple(dim for dim in variable.dims if dim != "row" or name == "n")
        if dims != DIMENSIONS[name] or variable.dtype.kind not in "fiu":
            _refuse(f"{name} over {', '.join(map(str, variable.dims))}")
    for dim in {dim for variable in used.values() for dim in variable.dims}:
        axis = data.variables.get(dim)
        if axis is None or axis.dtype.kind not in "fiu" or not np.isfinite(axis.values).all():
            _refuse(f"no finite numbers of {dim}")
    for name in ("error_estimate", "frame_speed"):
        value = data.attrs.get(name, 0.0)
        if not isinstance(value, int | float | np.number) or not np.isfinite(value):
            _refuse(f"{name} = {shown(value)}")
    if "n" in used and not np.isfinite(used["n"].values).all():
        _refuse("n that is not finite")


def _refuse(what: str) -> NoReturn:
    raise ValueError(
        f"source must be a run as `longwave run SCENE --output run.nc` writes it, got {what} "
        "(write it anew)"
    )


def own_error(data: LabelledArrays) -> Array | None:
    """Return the numerical error of a placed run's strain at each snapshot; None if it has none."""
    scaled = scaled_own_error(data)
    return None if scaled is None else data.attrs["unit"] * scaled


def with_own(data: LabelledArrays) -> LabelledArrays:
    """Return a placed run with its `own_error` at each snapshot as ``own``, NaN if it has none."""
    own = own_error(data)
    values = np.full(data.sizes["time"], np.nan) if own is None else own
    return data.assign(own=LabelledArray(TIME, values))


def with_envelope(data: LabelledArrays) -> LabelledArrays:
    """Return a placed run with its envelopes, or as it is if it has no carrier or two axes.

    ``strain_envelope`` and ``analytic_envelope`` are the `envelope` of the lattice and of the wave.
    """
    if not data.attrs["carried"] or "row" in data.sizes:
        return data
    envelopes = {}
    for name in ("strain", "analytic"):
        values = data[name].values
        rows = np.array([envelope(row) for row in values]).reshape(values.shape)
        envelopes[f"{name}_envelope"] = LabelledArray(SNAPSHOT, rows)
    return data.assign(**envelopes)


def envelope(strain: Array) -> Array:
    """Return the amplitude of the carrier in a strain at consecutive sites, in theory 2 eps |A|.

    It is the modulus of the strain filtered to wavenumbers about that of the largest amplitude,
    without mean and second harmonic. At a carrier of pi a single snapshot does not determine both
    amplitude and phase; the result is the part in phase. It is NaN near the ends, and everywhere if
    the carrier is close to 0 or, without being pi, close to pi.

    >>> n = np.arange(-100, 101)
    >>> found = envelope(np.cos(1.5 * n - 0.3) / np.cosh(n / 20))
    >>> bool(np.nanmax(np.abs(found - 1 / np.cosh(n / 20))) < 1e-3)
    True
    """
    count = strain.size
    ends = np.minimum(np.arange(count) + 0.5, count - np.arange(count) - 0.5)
    taper = np.sin(np.pi / 2 * np.minimum(1.0, ends / (TAPERED_FRACTION * count))) ** 2
    spectrum = np.fft.fft(taper * np.nan_to_num(strain, posinf=0.0, neginf=0.0))
    wavenumber = 2.0 * np.pi * np.fft.fftfreq(count)
    carrier = abs(float(wavenumber[np.argmax(np.abs(spectrum))]))
    distance, sides = min(carrier, np.pi - carrier), 2.0
    if np.pi - carrier < 4.0 * np.pi / count:
        wavenumber, carrier, distance, sides = np.abs(wavenumber), np.pi, np.pi / 2, 1.0
    if count < MIN_ENVELOPE_SITES or distance < MIN_CARRIER_DISTANCE:
        return np.full(count, np.nan)
    spectrum[np.abs(wavenumber - carrier) > BAND_WIDTH * distance] = 0.0
    with np.errstate(all="ignore"):
        return np.where(taper > MIN_TAPER, sides * np.abs(np.fft.ifft(spectrum)) / taper, np.nan)


TAPERED_FRACTION, MIN_TAPER = 0.125, 0.7
"""Fraction of the sites over which a strain is tapered to zero at each end before it is filtered,
and the value of the taper, 0 to 1, above which the envelope is known."""

BAND_WIDTH = 0.7
"""Half-width of the band-pass filter around the carrier, as a fraction of the carrier's distance
from 0 or pi."""

MIN_ENVELOPE_SITES, MIN_CARRIER_DISTANCE = 48, 0.3
"""Least number of sites, and least distance of the carrier k from 0 and pi, for an envelope."""


def spectra(data: LabelledArrays, places: Sequence[int]) -> LabelledArrays:
    """Return the amplitudes of ``lattice`` and ``wave`` over the compared sites at some snapshots.

    ``rounding`` is the mean amplitude of errors from rounding the strain to doubles. ``own`` is a
    bound of the amplitudes' error: 2 e if the run's numerical error in the strain is at most e. It
    is NaN if that was not measured.
    """
    middle = _middle_row(with_own(data).isel(time=list(places)))
    strain, analytic = (
        np.asarray(middle[name].values, dtype=float) for name in ("strain", "analytic")
    )
    sites = strain.shape[1]
    largest = np.nanmax(np.abs(strain), axis=1, initial=0.0)
    rounding = UNIT_ROUNDOFF / np.sqrt(3.0) * largest
    wavenumber = 2.0 * np.pi * np.fft.rfftfreq(sites)
    with np.errstate(all="ignore"):
        lattice, wave = (np.array(list(map(amplitudes, part))) for part in (strain, analytic))
    over = ("time", "wavenumber")
    variables = {
        "time": middle["time"],
        "wavenumber": LabelledArray(("wavenumber",), wavenumber),
        "lattice": LabelledArray(over, lattice),
        "wave": LabelledArray(over, wave),
        "rounding": LabelledArray(TIME, 2.0 * rounding * np.sqrt(1.5 / sites)),
        "own": LabelledArray(TIME, 2.0 * middle["own"].values),
    }
    return LabelledArrays(variables, _kind(data))


def _kind(data: LabelledArrays) -> dict[str, Any]:
    """Return {"field_kind": name of the compared field}, empty if the run has no such attribute."""
    return {key: data.attrs[key] for key in ("field_kind",) if key in data.attrs}


CURVES = {"error_curve": "over background", "error_curve_far_field": "over far field"}
"""Variable of a run -> legend label of this error, which says what the error is relative to."""


def error_curves(data: LabelledArrays) -> dict[str, ErrorCurve]:
    """Return the error curves of a placed run by their labels, with the run's numerical errors."""
    known = data["own"].values if "own" in data else None
    return {
        label: ErrorCurve.of(data, name, _own(data, name) if known is None else known)
        for name, label in CURVES.items()
        if name in data
    }


def _own(data: LabelledArrays, name: str) -> Array:
    """Return the run's numerical error for each value of a variable, in that variable's units."""
    scene = scene_of_run(data)
    return np.array([own_error_at(data, scene, name, i) for i in range(data[name].size)])


def with_looks(data: LabelledArrays, least: int = MIN_MAP_TIMES) -> LabelledArrays:
    """Return a placed run with map, crest and errors from its snapshots.

    A run with fewer than ``least`` snapshots, or with a map, is returned as it is. On two axes map
    and crest are those of the row nearest to the middle. For a carrier they are those of its
    `envelope`; without one, the map has the largest moduli in cells of some carrier waves.
    """
    has_snapshots = {"strain", "background", "n", "error", "sup_error"} <= set(data.variables)
    is_long = data.sizes.get("time", 0) >= least and data.sizes.get("site", 0)
    if not has_snapshots or not is_long or "space_time" in data:
        return data
    line, speed, carried = _middle_row(data), data.attrs["speed"], data.attrs["carried"]
    names = ("strain", "analytic", "background", "n")
    strain, analytic, background, sites = (
        np.asarray(line[name].values if name in line else np.nan * line["n"].values, dtype=float)
        for name in names
    )
    least_width = 1
    if carried:
        background = 0.0 * background
        wide, waves = (np.array(list(map(envelope, values))) for values in (strain, analytic))
        if np.isfinite(wide).any():
            strain, analytic = wide, waves
        else:
            strain, analytic, least_width = np.abs(strain), np.abs(analytic), MIN_CARRIER_CELL
    times = data["time"].values
    width = max(cell_width((strain.shape[1] - 1) // 2), least_width)
    starts = np.arange(0, strain.shape[1], width)
    looks = {"space_time": _farthest(strain, background, starts)}
    for end, values in (("", strain), ("_wave", analytic)):
        position, looks[f"crest_strain{end}"] = _crests(values, background, sites)
        looks[f"crest_position{end}"] = position - speed * times
    if "crest_law" in data:
        looks["crest_law"] = np.interp(times, data["look_time"].values, data["crest_law"].values)
    looks |= {"look_time": times, "shift": line["offset"].values[:, 0] - data["site"].values[0]}
    attributes = {"space_time": {"carried": carried, **_kind(data)}}
    found = {
        name: LabelledArray(DIMENSIONS.get(name, LOOK), values, attributes.get(name, {}))
        for name, values in looks.items()
    }
    found["map_site"] = LabelledArray(("map_site",), data["site"].values[starts])
    if "curve_time" not in data.sizes:
        errors = np.asarray(data["error"].values, dtype=float)
        curve = {"error_curve": errors, "curve_time": times, "own": _own(data, "error")}
        found |= {name: LabelledArray(CURVE, values) for name, values in curve.items()}
    return data.without("look_time").assign(**found)


def _farthest(strain: Array, background: Array, starts: NDArray[np.intp]) -> Array:
    """Return the strain farthest from the background in each cell of sites, at each time."""
    deviation = strain - background
    high = np.maximum.reduceat(deviation, starts, axis=1)
    low = np.minimum.reduceat(deviation, starts, axis=1)
    level = np.add.reduceat(background, starts, axis=1)
    counts = np.diff([*starts, strain.shape[1]])
    with np.errstate(all="ignore"):  # a file may hold any numbers
        return np.asarray(level / counts + np.where(high + low >= 0.0, high, low))


def with_theory(data: LabelledArrays) -> LabelledArrays:
    """Return a placed run with the offset of its map and the crest of its wave.

    ``shift`` is the offset from c t of the site nearest to it, which is the middle of the map.
    ``crest_position_wave`` and ``crest_strain_wave`` are those of the wave's crest at the compared
    sites.
    """
    if "look_time" not in data.sizes or "shift" in data:
        return data
    times = data["look_time"].values
    distance = data.attrs["speed"] * times
    data = data.assign(shift=LabelledArray(LOOK, np.floor(distance + 0.5) - distance))
    scene = scene_of_run(data)
    if "crest_position" not in data or not scene.has_moving_wave:
        return data
    moving = moving_wave(scene)
    sites = np.array([moving.compared_sites(t) for t in times])
    rows = zip(sites, times, strict=True)
    strain = np.array([scene.eps * moving.wave.value_at(at, t, scene.eps) for at, t in rows])
    position, top = _crests(strain, np.full_like(strain, moving.level), sites)
    crest = {"crest_position_wave": position - distance, "crest_strain_wave": top}
    return data.assign(**{name: LabelledArray(LOOK, values) for name, values in crest.items()})


def _crests(strain: Array, background: Array, sites: Array) -> tuple[Array, Array]:
    """Return the positions and the strains of the crests at all times."""
    crests = [_crest(*row) for row in zip(strain, background, sites, strict=True)]
    position, height = np.array(crests).T
    return position, height


def _crest(strain: Array, background: Array, sites: Array) -> tuple[float, float]:
    """Return position (between sites as well) and strain of the largest deviation."""
    deviation = strain - background
    if not np.isfinite(deviation).any() or np.isinf(deviation).any():
        return np.nan, np.nan
    top = int(np.nanargmax(np.abs(deviation)))
    offset, height = 0.0, float(deviation[top])
    if 2 <= top < deviation.size - 2:
        offset, height = extremum(deviation[top - 2 : top + 3])
    return float(sites[top]) + offset, height + float(background[top])


def _middle_row(data: LabelledArrays) -> LabelledArrays:
    """Return the run at the row nearest to the middle, or as it is if it has no rows."""
    if "row" not in data.sizes:
        return data
    return data.isel(row=int(np.argmin(np.abs(data["row"].values))))

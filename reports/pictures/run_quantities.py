"""What pictures of a run show and the run itself does not hold, for both kinds of runs.

Errors of the run against the infinite lattice, in the units of what is drawn; spectra of lattice
and wave; and, of a run on any lattice, which holds its snapshots alone, what a scene's observables
are on the paper's chain: the space-time map, the error over time and the track of the crest.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from longwave.reports.pictures.run_figures import SpectrumPanel
from longwave.runs import scene_of_run
from longwave.runs.own_error import scaled_own_error, wave_size
from longwave.scenes.chain.observables import amplitudes, cell_width, extremum
from longwave.scenes.scene import Scene
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.scenes.scene import Scene

Array = NDArray[np.float64]

LEAST_LOOKS = 8
"""Fewest snapshots of which a map or a curve over time is made."""

CARRIED = 8
"""Fewest sites in a cell of an envelope's map: a few carrier waves, except very long ones."""

LARGEST_POWER = 20
"""Of eps, in units of errors."""

UNIT_ROUNDOFF = 2.0**-53
"""Half a unit in the last place of 1."""


@dataclass(frozen=True)
class RunFrame:
    """What places a run: ``eps``, the ``speed`` of its frame, and the ``unit`` of its errors."""

    scene: Scene
    eps: float
    speed: float
    unit: float


def frame_of(data: xr.Dataset) -> RunFrame:
    """What places a run, from its scene; ValueError if it has none that can be read."""
    check_run(data)
    try:
        scene = scene_of_run(data)
        if scene.is_growth:
            return RunFrame(scene, scene.eps, 0.0, 1.0)
        if not scene.has_moving_wave:
            power = int(data["sup_error"].attrs["units"].partition("^")[2] or 1)
            if not 0 <= power <= LARGEST_POWER:
                raise ValueError(f"errors in units of eps^{power}")
            return RunFrame(scene, scene.eps, float(data.attrs["frame_speed"]), scene.eps**power)
        return RunFrame(scene, scene.eps, scene.model.sound_speed(), scene.eps)
    except (KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:150]
        raise ValueError(
            f"source must be a run with the scene that it was made from, got {reason} "
            "(write it with `longwave run SCENE --output run.nc`)"
        ) from None


SNAPSHOT, TIME, LOOK, CURVE = ("time", "site"), ("time",), ("look_time",), ("curve_time",)

DIMENSIONS: Mapping[str, tuple[str, ...]] = {
    "strain": SNAPSHOT,
    "analytic": SNAPSHOT,
    "background": SNAPSHOT,
    "n": SNAPSHOT,
    "error": TIME,
    "sup_error": TIME,
    "slow_time": TIME,
    "sideband_size": TIME,
    "sideband_theory": TIME,
    "time_step_error": TIME,
    "domain_error": TIME,
    "error_curve": CURVE,
    "error_curve_far_field": CURVE,
    "space_time": ("look_time", "map_site"),
    "crest_position": LOOK,
    "crest_strain": LOOK,
}
"""Of what pictures are drawn from; strains may have the dimension ``row`` besides."""


def check_run(data: xr.Dataset) -> None:
    """Raise ValueError in one line if a data set is not as those of runs are: it may be any file's.

    Variables that pictures need not are not looked at; one that is missing is no fault.
    """
    used = [name for name in DIMENSIONS if name in data.variables]
    for name in used:
        dims = tuple(dim for dim in data[name].dims if dim != "row" or name == "n")
        if dims != DIMENSIONS[name] or data[name].dtype.kind not in "fiu":
            _refuse(f"{name} over {', '.join(map(str, data[name].dims))}")
    for dim in {dim for name in used for dim in data[name].dims}:
        axis = data[dim] if dim in data.coords else None
        if axis is None or axis.dtype.kind not in "fiu" or not np.isfinite(axis).all():
            _refuse(f"no finite numbers of {dim}")
    for name in ("error_estimate", "frame_speed"):
        value = data.attrs.get(name, 0.0)
        if not isinstance(value, int | float | np.number) or not np.isfinite(value):
            _refuse(f"{name} = {shown(value)}")
    if not np.isfinite(np.asarray(data.get("n", 0.0), dtype=float)).all():
        _refuse("n that is not finite")


def _refuse(what: str) -> NoReturn:
    raise ValueError(
        f"source must be a run as `longwave run SCENE --output run.nc` writes it, got {what} "
        "(write it anew)"
    )


def own_error(data: xr.Dataset, frame: RunFrame) -> Array | None:
    """The run's own error in the strain, at each snapshot; None if the run did not measure it."""
    found = scaled_own_error(data)
    return None if found is None else frame.unit * found


def spectrum_panel(data: xr.Dataset, frame: RunFrame, place: int) -> SpectrumPanel:
    """Amplitudes of lattice and wave over the compared sites at a snapshot, with what is below
    trust: a strain whose error is at most e has amplitudes that err by at most 2 e.
    """
    at = data.isel(time=place)
    if "row" in at.dims:
        at = at.isel(row=_middle(at["row"].values))
    strain, analytic = (np.asarray(at[name], dtype=float) for name in ("strain", "analytic"))
    own = own_error(data, frame)
    rounding = UNIT_ROUNDOFF / np.sqrt(3.0) * float(np.nanmax(np.abs(strain), initial=0.0))
    return SpectrumPanel(
        title=f"$t={float(at['time']):g}$",
        wavenumber=np.asarray(2.0 * np.pi * np.fft.rfftfreq(strain.size), dtype=float),
        lattice=_amplitudes(strain),
        wave=_amplitudes(analytic),
        rounding=2.0 * rounding * np.sqrt(1.5 / strain.size),
        own=None if own is None else 2.0 * float(own[place]),
    )


def _amplitudes(values: Array) -> Array:
    with np.errstate(all="ignore"):
        return amplitudes(values)


def own_relative_error(
    data: xr.Dataset, frame: RunFrame, times: Array, far_field: bool = False
) -> Array | None:
    """The run's own error in the units of its error curve at these times; NaN where not measured.

    The unit is the wave's largest deviation from its background, or its far field, at that time.
    """
    if "own_error_curve" in data:
        return np.asarray(data["own_error_curve"], dtype=float)
    own = own_error(data, frame)
    if own is None or not own.size:
        return None
    found = np.full(times.size, own[0] if "error_estimate" in data.attrs else np.nan)
    _, here, there = np.intersect1d(times, data["time"].values, return_indices=True)
    found[here] = own[there]
    known = np.isfinite(found)
    scene = frame.scene
    found[known] /= [wave_size(scene, float(t), far_field) for t in times[known]]
    return found


def with_looks(data: xr.Dataset, frame: RunFrame, least: int = LEAST_LOOKS) -> xr.Dataset:
    """A run on any lattice with map, crest and errors over its snapshots, if they are ``least``.

    On two axes map and crest are those of the row nearest to the middle. Of an envelope the map
    holds the largest modulus in some cells that its carrier moves through, and the crest is one.
    """
    needed = {"strain", "background", "n", "error", "sup_error"} <= set(data.variables)
    if not needed or data.sizes.get("time", 0) < least or "space_time" in data:
        return data
    line = data.isel(row=_middle(data["row"].values)) if "row" in data.dims else data
    strain, background, sites = (
        np.asarray(line[name], dtype=float) for name in ("strain", "background", "n")
    )
    carried = frame.scene.is_envelope
    background = 0.0 * background if carried else background
    crests = [_crest(*row) for row in zip(strain, background, sites, strict=True)]
    position, height = np.array(crests).T
    times = data["time"].values
    width = max(cell_width((strain.shape[1] - 1) // 2), CARRIED if carried else 1)
    starts = np.arange(0, strain.shape[1], width)
    if not carried:
        strain, background = (
            _at_offsets(values, sites - frame.speed * times[:, None], data["site"].values)
            for values in (strain, background)
        )
    space_time = _farthest(np.abs(strain) if carried else strain, background, starts)
    found = {
        "space_time": (("look_time", "map_site"), space_time, {"carried": int(carried)}),
        "crest_position": ("look_time", position - frame.speed * times),
        "crest_strain": ("look_time", np.abs(height) if carried else height),
        "error_curve": ("curve_time", np.asarray(data["error"], dtype=float)),
        "own_error_curve": ("curve_time", _own_relative(data)),
    }
    axes = {
        "look_time": times,
        "curve_time": times,
        "map_site": np.asarray(data["site"])[starts],
    }
    return data.assign(found).assign_coords(axes)


def _at_offsets(values: Array, offsets: Array, wanted: NDArray[np.integer]) -> Array:
    """Values at whole offsets from c t, between the sites, which the frame passes one by one."""
    rows = zip(offsets, values, strict=True)
    return np.array([np.interp(wanted, offset, row) for offset, row in rows])


def _own_relative(data: xr.Dataset) -> Array:
    """The estimate in units of the wave's size, which the two errors' ratio is; NaN where both
    vanish."""
    relative, apart = (np.asarray(data[name], dtype=float) for name in ("error", "sup_error"))
    with np.errstate(over="ignore"):  # a file may hold any numbers
        size = np.divide(relative, apart, out=np.full(apart.size, np.nan), where=apart > 0.0)
    return np.asarray(size * float(data.attrs.get("error_estimate", np.nan)))


def _farthest(strain: Array, background: Array, starts: NDArray[np.intp]) -> Array:
    """The strain farthest from the background in each cell of sites, at each time."""
    deviation = strain - background
    high = np.maximum.reduceat(deviation, starts, axis=1)
    low = np.minimum.reduceat(deviation, starts, axis=1)
    level = np.add.reduceat(background, starts, axis=1)
    counts = np.diff([*starts, strain.shape[1]])
    with np.errstate(all="ignore"):  # a file may hold any numbers
        return np.asarray(level / counts + np.where(high + low >= 0.0, high, low))


def _crest(strain: Array, background: Array, sites: Array) -> tuple[float, float]:
    """Site and strain of the largest deviation from the background, between the sites as well."""
    deviation = strain - background
    if not np.isfinite(deviation).all():
        return np.nan, np.nan
    top = int(np.argmax(np.abs(deviation)))
    offset, height = 0.0, float(deviation[top])
    if 2 <= top < deviation.size - 2:
        offset, height = extremum(deviation[top - 2 : top + 3])
    return float(sites[top]) + offset, height + float(background[top])


def _middle(rows: NDArray[np.integer]) -> int:
    return int(np.argmin(np.abs(rows)))

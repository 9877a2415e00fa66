"""Observables that a scene may request; each is computed only on request.

To add one, write a function of a view of the run and declare above it what it computes, when it is
measured and which variables it adds.

>>> from longwave.scenes.observed.observables import observable_named
>>> [variable.name for variable in observable_named("momentum").variables]
['mean_strain', 'mean_velocity']

The error split decomposes the error into a shift of position, a change of amplitude and a change of
shape.
With y the run's strain, w the wave, b its bare background and n the compared sites, the shift d
(sites) and the scale a minimise

    sum_n ( y_n - [ b(n - d) + a (w - b)(n - d) ] )^2

The error is then, exactly,

    y - w  =  position + amplitude + shape
    position   =  w(n - d) - w(n)
    amplitude  =  (a - 1) (w - b)(n - d)
    shape      =  y_n - b(n - d) - a (w - b)(n - d)

Each is reported as its largest modulus over max_n |w - b|, the denominator of the error figure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.trial import SAFETY
from longwave.scenes.observed.view import View
from longwave.support.known_names import one_of
from longwave.support.real_arrays import Array

if TYPE_CHECKING:
    from longwave.support.labelled_arrays import Labelled

Moment = Literal["snapshots", "curve", "looks", "refinement"]

TIME_DIMENSION: Mapping[Moment, str] = {
    "snapshots": "time",
    "curve": "curve_time",
    "looks": "look_time",
    "refinement": "time",
}
"""Name of the time dimension by the value of ``Observable.measured_at``.

``snapshots`` and ``curve`` times are exact: steps are fitted to them. ``looks`` are taken where the
run stops anyway, so they change no step. A ``refinement`` runs the scene again.
"""

Measure = Callable[[View], Mapping[str, Any]]


@dataclass(frozen=True)
class Variable:
    """Array that an observable adds to the run; ``dimensions`` come after the time dimension."""

    name: str
    dimensions: tuple[str, ...]
    units: str
    long_name: str
    optional: bool = False

    @property
    def attributes(self) -> dict[str, str]:
        """Dataset attributes of the array: units and long name."""
        return {"units": self.units, "long_name": self.long_name}


@dataclass(frozen=True)
class Observable:
    """Observable of a scene: its description, times of measurement, variables and function.

    ``measure`` maps a view to the values of ``variables`` at one time; optional variables may be
    missing from a run. ``needs_ring`` means that the sites must form a ring, ``all_sites`` that
    sites beyond the compared ones are used, ``one_axis`` that the observable is for chains only.
    """

    name: str
    summary: str
    measured_at: Moment
    variables: tuple[Variable, ...]
    measure: Measure
    needs_ring: bool = False
    all_sites: bool = False
    one_axis: bool = False

    def __reduce__(self) -> tuple[Any, ...]:
        if OBSERVABLES.get(self.name) is self:
            return observable_named, (self.name,)
        return Observable, tuple(vars(self).values())


OBSERVABLES: dict[str, Observable] = {}
"""Observables by name, in the order of their declaration."""


def observable(
    summary: str, measured_at: Moment, *variables: Variable, **needs: bool
) -> Callable[[Measure], Measure]:
    """Return a decorator that registers a function as the observable with the function's name."""

    def declare(measure: Measure) -> Measure:
        name = measure.__name__
        OBSERVABLES[name] = Observable(name, summary, measured_at, variables, measure, **needs)
        return measure

    return declare


def observable_named(name: str) -> Observable:
    """Return the observable called ``name``. Raises ValueError with the known names.

    >>> observable_named("colour")
    Traceback (most recent call last):
    ...
    ValueError: observables must be known ones, got 'colour' (one of strain, ..., domain_error)
    """
    if name not in OBSERVABLES:
        known = one_of(name, OBSERVABLES)
        raise ValueError(f"observables must be known ones, got {name!r} ({known})")
    return OBSERVABLES[name]


SITE_UNIT, RATIO_UNIT = "sites", "1"
"""Texts for the unit of lengths and for the unit of dimensionless variables."""

TIME_ATTRIBUTES = {"units": "lattice time", "long_name": "time on the lattice"}
"""Dataset attributes of every time axis."""

MAP_CELLS = 256
"""Maximum number of cells, each of several sites, along a space-time map."""


def cell_width(compared: int) -> int:
    """Return the number of sites in one cell of a space-time map.

    >>> cell_width(1500), cell_width(50)
    (12, 1)
    """
    return math.ceil((2 * compared + 1) / MAP_CELLS)


def axis_values(
    dimension: str, reach: Sequence[int]
) -> tuple[NDArray[np.generic], dict[str, str]] | None:
    """Return coordinates and attributes of a dimension; None for one without coordinates.

    ``reach`` is the number of compared cells on either side of the frame, along each axis.
    """
    compared = reach[0]
    offsets = np.arange(-compared, compared + 1)
    if dimension == "site":
        return offsets, {"units": SITE_UNIT, "long_name": "offset from the site nearest c t"}
    if dimension == "row":
        rows = np.arange(-reach[1], reach[1] + 1)
        return rows, {"units": SITE_UNIT, "long_name": "cell along the second axis"}
    if dimension == "wavenumber":
        values = 2.0 * np.pi * np.fft.rfftfreq(offsets.size)
        return values, {"units": "1/site", "long_name": "wavenumber along the compared sites"}
    if dimension == "map_site":
        name = "first site of the cell, from the site nearest c t"
        return offsets[:: cell_width(compared)], {"units": SITE_UNIT, "long_name": name}
    return None


STRAIN_UNIT, VELOCITY_UNIT = "strain (lattice units)", "strain per lattice time"
RELATIVE = "relative sup error against the bare background"
RELATIVE_FAR = "relative sup error against the true far field"


@observable(
    "strains of run, wave and background at the snapshots, and the error there",
    "snapshots",
    Variable("strain", ("site",), STRAIN_UNIT, "strain of the lattice"),
    Variable("analytic", ("site",), STRAIN_UNIT, "strain of the closed-form wave"),
    Variable("background", ("site",), STRAIN_UNIT, "strain of the bare background"),
    Variable("n", ("site",), SITE_UNIT, "site on the lattice"),
    Variable("error", (), RATIO_UNIT, RELATIVE),
    Variable("error_far_field", (), RATIO_UNIT, RELATIVE_FAR, optional=True),
    Variable("strains", ("quantity", "site"), STRAIN_UNIT, "all that is compared", optional=True),
    Variable("analytics", ("quantity", "site"), STRAIN_UNIT, "the same of the wave", optional=True),
    Variable("sup_error", (), "", "sup error", optional=True),
    Variable("slow_time", (), "slow time", "T, the wave's own time", optional=True),
)
def strain(view: View) -> Mapping[str, Any]:
    """Return strains, site numbers and errors; errors are NaN if the wave equals its background."""
    rows: dict[str, Any] = {"strain": view.numeric, "analytic": view.analytic}
    rows |= {"background": view.background, "n": view.sites}
    if not np.array_equal(view.analytics, view.backgrounds):
        return rows | _errors(view, "error") | view.extra_variables
    far = {} if view.far_field is None else {"error_far_field": np.nan}
    return rows | {"error": np.nan} | far | view.extra_variables


@observable(
    "the relative sup error against time",
    "curve",
    Variable("error_curve", (), RATIO_UNIT, RELATIVE),
    Variable("error_curve_far_field", (), RATIO_UNIT, RELATIVE_FAR, optional=True),
)
def error_curve(view: View) -> Mapping[str, Any]:
    """Return the sup errors relative to background and to far field, but not the strains."""
    return _errors(view, "error_curve")


def _errors(view: View, prefix: str) -> dict[str, float]:
    errors = {prefix: view.error}
    if view.far_field is not None:
        errors[f"{prefix}_far_field"] = view.error_far_field
    return errors


@observable(
    "kinetic and potential energy of the ring against time",
    "looks",
    Variable("energy", (), "lattice energy", "kinetic and potential energy of the ring"),
    needs_ring=True,
    all_sites=True,
)
def energy(view: View) -> Mapping[str, float]:
    """Return kinetic plus potential energy of the ring."""
    return {"energy": view.energy}


@observable(
    "mean strain and mean velocity of the ring against time",
    "looks",
    Variable("mean_strain", (), STRAIN_UNIT, "mean strain of the ring"),
    Variable("mean_velocity", (), VELOCITY_UNIT, "mean velocity, conserved by the exact flow"),
    needs_ring=True,
    all_sites=True,
)
def momentum(view: View) -> Mapping[str, float]:
    """Return mean strain and velocity of the ring; the exact flow conserves the velocity."""
    strain, velocity = view.means
    return {"mean_strain": strain, "mean_velocity": velocity}


@observable(
    "Fourier amplitudes of the compared strains at the snapshots",
    "snapshots",
    Variable("spectrum", ("wavenumber",), STRAIN_UNIT, "Fourier amplitude of the strain"),
    one_axis=True,
)
def spectrum(view: View) -> Mapping[str, Array]:
    """Return Fourier amplitudes of the strain on the compared sites, for wavenumbers 0 .. pi."""
    return {"spectrum": amplitudes(view.numeric)}


def amplitudes(values: Array) -> Array:
    """Return the Hann-windowed Fourier amplitudes of ``values`` minus their mean.

    They are scaled so that a cos(k n), with k on the grid, has amplitude a at k. The window
    suppresses the jump between the two ends, whose leakage then falls like 1/k^3.

    >>> n = np.arange(64)
    >>> float(np.round(amplitudes(3.0 * np.cos(2.0 * np.pi * 8.0 * n / 64.0))[8], 12))
    3.0
    """
    count = values.size
    window = 1.0 - np.cos(2.0 * np.pi * np.arange(count) / count)
    modes = np.fft.rfft((values - np.mean(values)) * window)
    scaled: Array = 2.0 * np.abs(modes) / count
    return scaled


NEWTON_STEPS = 4


@observable(
    "position and strain of the crest against time",
    "looks",
    Variable("crest_position", (), SITE_UNIT, "position of the crest less c t"),
    Variable("crest_strain", (), STRAIN_UNIT, "strain at the crest"),
    Variable("crest_law", (), STRAIN_UNIT, "the same by the law of the losses", optional=True),
    one_axis=True,
)
def crest_track(view: View) -> Mapping[str, float]:
    """Return the crest's position relative to c t and its strain, interpolated between sites."""
    deviation = view.numeric - view.level
    top = int(np.argmax(np.abs(deviation)))
    offset, height = 0.0, float(deviation[top])
    if 2 <= top < deviation.size - 2:
        offset, height = extremum(deviation[top - 2 : top + 3])
    crest = {
        "crest_position": float(view.sites[top]) + offset - view.travelled,
        "crest_strain": height + view.level,
    }
    return crest if view.crest_law is None else crest | {"crest_law": view.crest_law}


def extremum(f: Array) -> tuple[float, float]:
    """Return position and value of the extremum of the quartic through five values at -2 .. 2.

    The middle value must be the largest in modulus. Newton's method starts from the parabola
    through the three innermost points.

    >>> x = np.arange(-2.0, 3.0) - 0.3
    >>> position, value = extremum(5.0 - x**2 + 0.01 * x**4)
    >>> round(position, 12), round(value, 12)
    (0.3, 5.0)
    """
    c1 = (f[0] - 8.0 * f[1] + 8.0 * f[3] - f[4]) / 12.0
    c2 = (-f[0] + 16.0 * f[1] - 30.0 * f[2] + 16.0 * f[3] - f[4]) / 24.0
    c3 = (-f[0] + 2.0 * f[1] - 2.0 * f[3] + f[4]) / 12.0
    c4 = (f[0] - 4.0 * f[1] + 6.0 * f[2] - 4.0 * f[3] + f[4]) / 24.0
    second = f[1] - 2.0 * f[2] + f[3]
    x = 0.5 * (f[1] - f[3]) / second if second != 0.0 else 0.0
    for _ in range(NEWTON_STEPS):
        curvature = 2.0 * c2 + x * (6.0 * c3 + 12.0 * c4 * x)
        if curvature == 0.0:
            break
        x -= (c1 + x * (2.0 * c2 + x * (3.0 * c3 + 4.0 * c4 * x))) / curvature
    if not abs(x) <= 1.0:
        return 0.0, float(f[2])
    return float(x), float(f[2] + x * (c1 + x * (c2 + x * (c3 + c4 * x))))


@observable(
    "a map of the strain over time and cells of sites",
    "looks",
    Variable("space_time", ("map_site",), STRAIN_UNIT, "strain farthest from the background"),
    one_axis=True,
)
def space_time(view: View) -> Mapping[str, Array]:
    """Return, for each cell of sites, the strain farthest from the uniform level; crests remain."""
    starts = np.arange(0, view.numeric.size, cell_width((view.numeric.size - 1) // 2))
    high = np.maximum.reduceat(view.numeric, starts)
    low = np.minimum.reduceat(view.numeric, starts)
    return {"space_time": np.where(high + low >= 2.0 * view.level, high, low)}


@observable(
    "strain of the run less the bare background at the snapshots",
    "snapshots",
    Variable("background_difference", ("site",), STRAIN_UNIT, "strain less the bare background"),
)
def background_difference(view: View) -> Mapping[str, Any]:
    """Return the run's strain minus that of the bare background wave of the same phase."""
    return {"background_difference": view.numeric - view.background}


@observable(
    "the error at the snapshots as shift in position, amplitude and shape",
    "snapshots",
    Variable("shift", (), SITE_UNIT, "fitted shift of the run"),
    Variable("scale", (), RATIO_UNIT, "fitted amplitude over the wave's"),
    Variable("error_position", (), RATIO_UNIT, "relative sup of the shift's part"),
    Variable("error_amplitude", (), RATIO_UNIT, "relative sup of the amplitude's part"),
    Variable("error_shape", (), RATIO_UNIT, "relative sup of what is left"),
    one_axis=True,
)
def error_split(view: View) -> Mapping[str, float]:
    """Return fitted shift and scale, and the three parts of the relative error."""
    analytic = view.analytic
    height = float(np.max(np.abs(analytic - view.background)))
    shift, scale = fit(view)
    wave, background, _, _ = view.displaced(shift)
    parts = {
        "error_position": wave - analytic,
        "error_amplitude": (scale - 1.0) * (wave - background),
        "error_shape": view.numeric - background - scale * (wave - background),
    }
    errors = {name: float(np.max(np.abs(part))) / height for name, part in parts.items()}
    return {"shift": shift, "scale": scale} | errors


def fit(view: View) -> tuple[float, float]:
    """Return the shift (in sites) and the scale factor of the wave that fit the run best.

    Least-squares fits start from zero shift and from the distance between the crests of run and
    wave; the better one is returned.
    """
    from scipy.optimize import least_squares  # import takes 0.2 s, for this observable only

    run, wave = view.numeric - view.background, view.analytic - view.background
    crests = float(np.argmax(np.abs(run)) - np.argmax(np.abs(wave)))
    residual, slopes = partial(_residual, view), partial(_slopes, view)
    fits = [
        least_squares(residual, [start, 1.0], slopes, method="lm", xtol=1e-12)
        for start in sorted({0.0, crests})
    ]
    best = min(fits, key=lambda result: float(result.cost))
    return float(best.x[0]), float(best.x[1])


def _residual(view: View, unknown: Array) -> Array:
    wave, background, _, _ = view.displaced(float(unknown[0]))
    return view.numeric - background - float(unknown[1]) * (wave - background)


def _slopes(view: View, unknown: Array) -> Array:
    wave, background, wave_slope, background_slope = view.displaced(float(unknown[0]))
    by_shift = background_slope + float(unknown[1]) * (wave_slope - background_slope)
    return np.stack([by_shift, background - wave], axis=1)


@observable(
    "strains and velocities of all computed sites at the snapshots, for a restart",
    "snapshots",
    Variable("state_y", ("cell",), STRAIN_UNIT, "strain, or fields, of every computed site"),
    Variable("state_s", ("cell",), VELOCITY_UNIT, "velocity of every computed site"),
    Variable("state_left", (), SITE_UNIT, "leftmost site held"),
    all_sites=True,
    one_axis=True,
)
def state(view: View) -> Mapping[str, Any]:
    """Return strains and velocities of all computed sites, and the number of the leftmost one."""
    left, positions, velocities = view.stored
    return {"state_y": positions, "state_s": velocities, "state_left": left}


def _refinement(name: str, change: str) -> None:
    """Register an observable that compares the run with one refined by ``change``, a text."""
    summary = f"largest difference of y/eps to the run with {change}"
    variable = Variable(name, (), "strain / eps", "sup difference to the refined run")
    OBSERVABLES[name] = Observable(name, summary, "refinement", (variable,), lambda _: {})


_refinement("time_step_error", "half the step")
_refinement("domain_error", "twice the sites")

MEASURED = ("time_step_error", "domain_error")
"""Variables that hold differences to refined runs at the snapshots, in y/eps."""


def measured_error(run: Labelled) -> NDArray[np.float64] | None:
    """Return a bound of the step and domain errors of y/eps at each snapshot; None if unmeasured.

    The difference to a refined run may be only half the error, if the error is proportional to the
    step or to 1/size; hence the factor ``SAFETY``.
    """
    parts = [run.variables[name].values for name in MEASURED if name in run.variables]
    return SAFETY * sum(parts[1:], start=parts[0]) if parts else None

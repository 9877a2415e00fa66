"""The observables that a scene may ask for; each is computed only if it is asked for.

Adding one is one function here, of a view of the run: what it computes, when it looks and what it
adds stand above it.

>>> from longwave.scenes.observed.observables import observable_named
>>> [variable.name for variable in observable_named("momentum").variables]
['mean_strain', 'mean_velocity']

The error split writes the error as a shift in position, a change of amplitude and one of shape.
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
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.trial import SAFETY
from longwave.scenes.observed.view import Array, View
from longwave.support.known_names import one_of

if TYPE_CHECKING:
    from longwave.support.labelled_arrays import Labelled

Moment = Literal["snapshots", "curve", "looks", "refinement"]

TIME_DIMENSION: Mapping[Moment, str] = {
    "snapshots": "time",
    "curve": "curve_time",
    "looks": "look_time",
    "refinement": "time",
}
"""The time dimension of what is seen at each kind of moment.

``snapshots`` and ``curve`` times are hit exactly, and the steps are fitted to them. ``looks`` are
taken where the run stops anyway, so they change no step. A ``refinement`` runs the scene again.
"""

Measure = Callable[[View], Mapping[str, Any]]


@dataclass(frozen=True)
class Variable:
    """One array that an observable adds; ``dimensions`` are those after the time."""

    name: str
    dimensions: tuple[str, ...]
    units: str
    long_name: str
    optional: bool = False

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the array in the run."""
        return {"units": self.units, "long_name": self.long_name}


@dataclass(frozen=True)
class Observable:
    """One observable.

    ``measure`` maps a view to the values of ``variables`` at one moment; optional variables may be
    missing from all moments of a run. ``needs_ring`` says that the sites must form a ring,
    ``all_sites`` that others than the compared ones are looked at, ``one_axis`` that it is for
    chains alone.
    """

    name: str
    what: str
    seen: Moment
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
"""The observables by name, in the order in which they are declared."""


def observable(
    what: str, seen: Moment, *variables: Variable, **needs: bool
) -> Callable[[Measure], Measure]:
    """Declare the function below as the measurement of the observable of its name."""

    def declare(measure: Measure) -> Measure:
        name = measure.__name__
        OBSERVABLES[name] = Observable(name, what, seen, variables, measure, **needs)
        return measure

    return declare


def observable_named(name: str) -> Observable:
    """The observable of that name; ValueError lists the known ones.

    >>> observable_named("colour")
    Traceback (most recent call last):
    ...
    ValueError: observables must be known ones, got 'colour' (one of strain, ..., domain_error)
    """
    if name not in OBSERVABLES:
        known = one_of(name, OBSERVABLES)
        raise ValueError(f"observables must be known ones, got {name!r} ({known})")
    return OBSERVABLES[name]


SITES, RATIO = "sites", "1"
"""Units of lengths, and of what has none."""

TIME = {"units": "lattice time", "long_name": "time on the lattice"}
"""Attributes of every axis of times."""

MAP_CELLS = 256
"""Most cells of a space-time map."""


def cell_width(compared: int) -> int:
    """Sites in one cell of a space-time map.

    >>> cell_width(1500), cell_width(50)
    (12, 1)
    """
    return math.ceil((2 * compared + 1) / MAP_CELLS)


def axis_values(
    dimension: str, reach: Sequence[int]
) -> tuple[NDArray[np.generic], dict[str, str]] | None:
    """Values and attributes of a dimension, None for one that is only counted.

    ``reach``: so many cells are compared on either side of the frame, along each axis.
    """
    compared = reach[0]
    offsets = np.arange(-compared, compared + 1)
    if dimension == "site":
        return offsets, {"units": SITES, "long_name": "offset from the site nearest c t"}
    if dimension == "row":
        rows = np.arange(-reach[1], reach[1] + 1)
        return rows, {"units": SITES, "long_name": "cell along the second axis"}
    if dimension == "wavenumber":
        values = 2.0 * np.pi * np.fft.rfftfreq(offsets.size)
        return values, {"units": "1/site", "long_name": "wavenumber along the compared sites"}
    if dimension == "map_site":
        starts = offsets[:: cell_width(compared)]
        named = {"long_name": "first site of the cell, from the site nearest c t"}
        return starts, {"units": SITES} | named
    return None


STRAIN, PER_TIME = "strain (lattice units)", "strain per lattice time"
RELATIVE = "relative sup error against the bare background"
RELATIVE_FAR = "relative sup error against the true far field"


@observable(
    "strains of run, wave and background at the snapshots, and the error there",
    "snapshots",
    Variable("strain", ("site",), STRAIN, "strain of the lattice"),
    Variable("analytic", ("site",), STRAIN, "strain of the closed-form wave"),
    Variable("background", ("site",), STRAIN, "strain of the bare background"),
    Variable("n", ("site",), SITES, "site on the lattice"),
    Variable("error", (), RATIO, RELATIVE),
    Variable("error_far_field", (), RATIO, RELATIVE_FAR, optional=True),
    Variable("strains", ("quantity", "site"), STRAIN, "all that is compared", optional=True),
    Variable("analytics", ("quantity", "site"), STRAIN, "the same of the wave", optional=True),
    Variable("sup_error", (), "", "sup error", optional=True),
    Variable("slow_time", (), "slow time", "T, the wave's own time", optional=True),
)
def strain(view: View) -> Mapping[str, Any]:
    """Strains of run, wave and bare background, the sites' numbers, and the errors.

    Errors are NaN at a time when the wave is its own background on all compared sites.
    """
    rows = {
        "strain": view.numeric,
        "analytic": view.analytic,
        "background": view.background,
        "n": view.sites,
    }
    if not view.is_background:
        return rows | _errors(view, "error") | view.also
    far = {} if view.far_field is None else {"error_far_field": np.nan}
    return rows | {"error": np.nan} | far | view.also


@observable(
    "the relative sup error against time",
    "curve",
    Variable("error_curve", (), RATIO, RELATIVE),
    Variable("error_curve_far_field", (), RATIO, RELATIVE_FAR, optional=True),
)
def error_curve(view: View) -> Mapping[str, Any]:
    """The relative sup errors alone."""
    return _errors(view, "error_curve")


def _errors(view: View, prefix: str) -> dict[str, float]:
    found = {prefix: view.error}
    if view.far_field is not None:
        found[f"{prefix}_far_field"] = view.error_far_field
    return found


@observable(
    "kinetic and potential energy of the ring against time",
    "looks",
    Variable("energy", (), "lattice energy", "kinetic and potential energy of the ring"),
    needs_ring=True,
    all_sites=True,
)
def energy(view: View) -> Mapping[str, float]:
    """The energy of the ring."""
    return {"energy": view.energy}


@observable(
    "mean strain and mean velocity of the ring against time",
    "looks",
    Variable("mean_strain", (), STRAIN, "mean strain of the ring"),
    Variable("mean_velocity", (), PER_TIME, "mean velocity, conserved by the exact flow"),
    needs_ring=True,
    all_sites=True,
)
def momentum(view: View) -> Mapping[str, float]:
    """Mean strain and mean velocity over the ring.

    The second difference sums to zero over a ring, so the mean velocity is conserved and the mean
    strain moves linearly with it.
    """
    strain, velocity = view.means
    return {"mean_strain": strain, "mean_velocity": velocity}


@observable(
    "Fourier amplitudes of the compared strains at the snapshots",
    "snapshots",
    Variable("spectrum", ("wavenumber",), STRAIN, "Fourier amplitude of the strain"),
    one_axis=True,
)
def spectrum(view: View) -> Mapping[str, Array]:
    """Amplitudes of the strain on the compared sites, by wavenumber in 0 .. pi."""
    return {"spectrum": amplitudes(view.numeric)}


def amplitudes(values: Array) -> Array:
    """Hann-windowed Fourier amplitudes of ``values`` less their mean.

    Scaled so that a cos(k n) with k on the grid has the amplitude a there. The window keeps the
    jump between the two ends from covering the tail: its leakage falls like 1/k^3.

    >>> n = np.arange(64)
    >>> float(np.round(amplitudes(3.0 * np.cos(2.0 * np.pi * 8.0 * n / 64.0))[8], 12))
    3.0
    """
    count = values.size
    window = 1.0 - np.cos(2.0 * np.pi * np.arange(count) / count)
    modes = np.fft.rfft((values - np.mean(values)) * window)
    found: Array = 2.0 * np.abs(modes) / count
    return found


NEWTON_STEPS = 4


@observable(
    "position and strain of the crest against time",
    "looks",
    Variable("crest_position", (), SITES, "position of the crest less c t"),
    Variable("crest_strain", (), STRAIN, "strain at the crest"),
    Variable("crest_law", (), STRAIN, "the same by the law of the losses", optional=True),
    one_axis=True,
)
def crest_track(view: View) -> Mapping[str, float]:
    """Position of the crest relative to c t, and its strain, interpolated between the sites."""
    deviation = view.numeric - view.level
    top = int(np.argmax(np.abs(deviation)))
    offset, height = 0.0, float(deviation[top])
    if 2 <= top < deviation.size - 2:
        offset, height = extremum(deviation[top - 2 : top + 3])
    found = {
        "crest_position": float(view.sites[top]) + offset - view.travelled,
        "crest_strain": height + view.level,
    }
    return found if view.crest_law is None else found | {"crest_law": view.crest_law}


def extremum(f: Array) -> tuple[float, float]:
    """Place and value of the extremum of the quartic through five values at -2 .. 2.

    The middle one is the largest in modulus; Newton starts from the parabola through the three
    innermost.

    >>> x = np.arange(-2.0, 3.0) - 0.3
    >>> place, value = extremum(5.0 - x**2 + 0.01 * x**4)
    >>> round(place, 12), round(value, 12)
    (0.3, 5.0)
    """
    c1 = (f[0] - 8.0 * f[1] + 8.0 * f[3] - f[4]) / 12.0
    c2 = (-f[0] + 16.0 * f[1] - 30.0 * f[2] + 16.0 * f[3] - f[4]) / 24.0
    c3 = (-f[0] + 2.0 * f[1] - 2.0 * f[3] + f[4]) / 12.0
    c4 = (f[0] - 4.0 * f[1] + 6.0 * f[2] - 4.0 * f[3] + f[4]) / 24.0
    bend = f[1] - 2.0 * f[2] + f[3]
    x = 0.5 * (f[1] - f[3]) / bend if bend != 0.0 else 0.0
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
    Variable("space_time", ("map_site",), STRAIN, "strain farthest from the background"),
    one_axis=True,
)
def space_time(view: View) -> Mapping[str, Array]:
    """The strain farthest from the background in each cell of sites: no crest is lost."""
    starts = np.arange(0, view.numeric.size, cell_width((view.numeric.size - 1) // 2))
    high = np.maximum.reduceat(view.numeric, starts)
    low = np.minimum.reduceat(view.numeric, starts)
    return {"space_time": np.where(high + low >= 2.0 * view.level, high, low)}


@observable(
    "strain of the run less the bare background at the snapshots",
    "snapshots",
    Variable("background_difference", ("site",), STRAIN, "strain less the bare background"),
)
def background_difference(view: View) -> Mapping[str, Any]:
    """Strain of the run less the bare wave of the same phase (or the constant)."""
    return {"background_difference": view.numeric - view.background}


@observable(
    "the error at the snapshots as shift in position, amplitude and shape",
    "snapshots",
    Variable("shift", (), SITES, "fitted shift of the run"),
    Variable("scale", (), RATIO, "fitted amplitude over the wave's"),
    Variable("error_position", (), RATIO, "relative sup of the shift's part"),
    Variable("error_amplitude", (), RATIO, "relative sup of the amplitude's part"),
    Variable("error_shape", (), RATIO, "relative sup of what is left"),
    one_axis=True,
)
def error_split(view: View) -> Mapping[str, float]:
    """Shift, scale, and the three parts of the relative error."""
    analytic = view.analytic
    height = float(np.max(np.abs(analytic - view.background)))
    shift, scale = fit(view)
    wave, background, _, _ = view.displaced(shift)
    parts = {
        "error_position": wave - analytic,
        "error_amplitude": (scale - 1.0) * (wave - background),
        "error_shape": view.numeric - background - scale * (wave - background),
    }
    found = {name: float(np.max(np.abs(part))) / height for name, part in parts.items()}
    return {"shift": shift, "scale": scale} | found


def fit(view: View) -> tuple[float, float]:
    """The least-squares shift (sites) and scale, started from no shift and from the crests' one."""
    from scipy.optimize import least_squares  # 0.2 s, for one observable

    run, wave = view.numeric - view.background, view.analytic - view.background
    crests = float(np.argmax(np.abs(run)) - np.argmax(np.abs(wave)))
    fits = [
        least_squares(
            lambda unknown: _residual(view, unknown),
            [start, 1.0],
            lambda unknown: _slopes(view, unknown),
            method="lm",
            xtol=1e-12,
        )
        for start in sorted({0.0, crests})
    ]
    best = min(fits, key=lambda found: float(found.cost))
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
    Variable("state_y", ("cell",), STRAIN, "strain, or fields, of every computed site"),
    Variable("state_s", ("cell",), PER_TIME, "velocity of every computed site"),
    Variable("state_left", (), SITES, "leftmost site held"),
    all_sites=True,
    one_axis=True,
)
def state(view: View) -> Mapping[str, Any]:
    """Strains and velocities of all computed sites, in the order of storage."""
    left, positions, velocities = view.stored
    return {"state_y": positions, "state_s": velocities, "state_left": left}


def _refinement(name: str, change: str) -> None:
    """Declare what a second run measures, and no look at the first."""
    what = f"largest difference of y/eps to the run with {change}"
    added = Variable(name, (), "strain / eps", "sup difference to the refined run")
    OBSERVABLES[name] = Observable(name, what, "refinement", (added,), lambda _: {})


_refinement("time_step_error", "half the step")
_refinement("domain_error", "twice the sites")

MEASURED = ("time_step_error", "domain_error")
"""What finer runs differ by at the snapshots, in y/eps."""


def measured_error(run: Labelled) -> NDArray[np.float64] | None:
    """What y/eps may be off at each snapshot by step and domain together; None if it was not
    measured.

    A run differs from the finer one by as little as half of what it is off, where its error falls
    as slowly as the step or 1/size: hence ``SAFETY``.
    """
    parts = [run.variables[name].values for name in MEASURED if name in run.variables]
    return SAFETY * sum(parts[1:], start=parts[0]) if parts else None

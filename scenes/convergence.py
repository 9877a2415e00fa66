"""A scene at several eps: how fast its lattice comes near its wave, at fixed slow times.

In theory the error is that of the first thing that is left out: of the equation, its next order
that does not vanish; of the data, the fields that follow the wave.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longwave.derive import CarrierTerms, Envelope, Lattice, Reduction, carrier_fields, reduce
from longwave.derive.algebra.exact_numbers import Number
from longwave.lattice.refine import Announce
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import finite, positive
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.starts.lattice_derivation import derivation
from longwave.support.html_tables import html_table
from longwave.support.user_files import shown

Array = NDArray[Any]

FEWEST = 3
"""Errors that a rate with its uncertainty needs."""

MOST = 20
"""Values of eps."""

SHARE = 0.05
"""Of an error, what its run may add to it."""

USUAL = (2.0, 1.4, 1.0, 0.7)
"""Values of eps in units of the scene's, unless they are given."""


@dataclass(frozen=True)
class FittedRate:
    """The power of eps that fits errors, and an interval for its limit at small eps.

    >>> print(FittedRate(5.82, 5.81, 6.04))
    5.8 (5.8 .. 6.1)
    """

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return (
            f"{self.value:.1f} ({floor(10 * self.low) / 10:.1f} .. {ceil(10 * self.high) / 10:.1f})"
        )

    def holds(self, power: float) -> bool:
        """Whether the interval, with its ends as they are printed, holds that power."""
        return floor(10 * self.low) <= 10 * power <= ceil(10 * self.high)


@dataclass(frozen=True)
class ConvergencePoint:
    """One eps: the sup error over the cells and the times after the first, of what is compared.

    ``relative`` is the same in units of the wave's largest deviation from its background at these
    times; ``discretisation`` is what the run itself is estimated to add to the error.
    """

    eps: float
    error: float
    relative: float
    discretisation: float
    sites: int
    seconds: float


@dataclass(frozen=True, repr=False)
class SceneConvergence:
    """The errors of a scene at several eps, and the power of eps that fits them.

    Errors are of what is compared, as it stands; ``power`` is that of eps with which it is small.
    ``theory`` is the power that the expansion has for the errors, None where it names none.
    """

    scene: Scene
    equation: str
    power: int
    points: tuple[ConvergencePoint, ...]
    rate: FittedRate
    theory: int | None

    def __repr__(self) -> str:
        theory = "none known" if self.theory is None else self.theory
        return f"<{type(self).__name__} of {self.scene.name}: rate {self.rate}, theory {theory}>"

    def _repr_html_(self) -> str:
        rows = [
            (f"{p.eps:g}", f"{p.error:.3g}", f"{p.relative:.3g}", f"{p.discretisation:.1g}")
            for p in self.points
        ]
        heads = ("eps", "sup error", "of the wave's size", "runs' own error")
        return html_table(repr(self).strip("<>"), rows, heads)

    @property
    def reached(self) -> bool:
        """Whether the interval of the measured rate holds the power of theory."""
        return self.theory is not None and self.rate.holds(self.theory)

    def data(self) -> dict[str, Any]:
        """All of it as numbers, text and lists."""
        return {
            "scene": self.scene.name,
            "lattice": self.scene.lattice,
            "equation": self.equation,
            "order": self.scene.order,
            "power": self.power,
            "rate": self.rate.value,
            "interval": [self.rate.low, self.rate.high],
            "theory": self.theory,
            "points": [vars(point) for point in self.points],
        }


def scene_convergence(
    scene: Scene,
    eps: Sequence[float] = (),
    progress: Callable[[float], None] = lambda _: None,
    announce: Announce = lambda _: None,
) -> SceneConvergence:
    """Run the scene at each eps, from the largest on, and fit the rate.

    A run whose own error is not small beside what it measures is done again, to a smaller
    tolerance. Raises ValueError for values that are too few or wrong, and as `record_scene`.
    """
    values = _checked(scene, eps)
    scene = scene.with_tolerance(scene.target.tolerance).changed(observables=("strain",))
    points: list[ConvergencePoint] = []
    power = 0
    for place, value in enumerate(values):

        def share(done: float, place: int = place) -> None:
            progress((place + done) / len(values))

        run = _run(at_eps(scene, value), share, announce)
        power = run.attrs["power"]
        points.append(_point(run))
    errors, own = [p.error for p in points], [p.discretisation for p in points]
    rate, equation = fitted_rate(values, errors, own), derivation(scene).equation
    return SceneConvergence(scene, equation, power, tuple(points), rate, scene_rate(scene))


def fitted_rate(
    eps: Sequence[float], errors: Sequence[float], own: Sequence[float] = ()
) -> FittedRate:
    """The least-squares slope of ``log error`` by ``log eps``, and where its limit may lie.

    The slope drifts with eps. Between two neighbours it is told at their geometric mean, and what
    is held is the slope at all eps, that of the two least, and what lines through the slopes by eps
    and by its square have at eps = 0; beyond that, what slopes miss of these lines, and what the
    errors ``own`` of the runs may change.  Raises ValueError for fewer than three errors, and for
    what has no logarithm.

    >>> fitted_rate([0.1, 0.2, 0.4], [0.01, 0.04, 0.16]).value
    2.0
    """
    if len(eps) != len(errors) or len(errors) < FEWEST or len({*eps}) < len(eps):
        raise ValueError(
            f"errors must be at least {FEWEST}, each at its own eps, got {len(errors)} at "
            f"{len({*eps})} (take more values of eps)"
        )
    if not (min(eps) > 0.0 and 0.0 < min(errors) <= max(errors) < np.inf):
        raise ValueError(
            f"errors must be finite and > 0, got {min(errors):g} to {max(errors):g} (an error of 0 "
            "has no rate)"
        )
    places = np.argsort(eps)
    logs = np.log(np.array([eps, errors], dtype=np.float64)[:, places])
    value = round(float(np.polyfit(logs[0], logs[1], 1)[0]), 12)
    widths, heights = np.diff(logs, axis=1)
    slopes, middles = heights / widths, np.exp((logs[0, 1:] + logs[0, :-1]) / 2)
    lines = [np.polyfit(middles**power, slopes, 1) for power in (1, 2)]
    missed = min(
        float(np.max(np.abs(np.polyval(line, middles**power) - slopes)))
        for power, line in zip((1, 2), lines, strict=True)
    )
    shares = np.array(own or np.zeros(len(errors)))[places] / np.exp(logs[1])
    beyond = missed + float(np.max((shares[1:] + shares[:-1]) / widths))
    held = [value, float(slopes[0]), *(float(line[1]) for line in lines)]
    return FittedRate(value, min(held) - beyond, max(held) + beyond)


def _checked(scene: Scene, given: Sequence[float]) -> list[float]:
    values = [finite("eps", value) for value in given or [f * scene.eps for f in USUAL]]
    for value in values:
        positive("eps", value)
    if not FEWEST <= len(set(values)) == len(values) <= MOST:
        raise ValueError(
            f"eps must be {FEWEST} to {MOST} different values, got {shown(values)} (such as "
            "0.1,0.07,0.05,0.035)"
        )
    return sorted(values, reverse=True)


def at_eps(scene: Scene, eps: float) -> Scene:
    """The scene at another eps, its times and its region the same in the wave's own units."""
    slow = derivation(scene).slow
    times = tuple(t * scene.eps**slow for t in scene.lattice_times(slow))
    return scene.changed(
        eps=eps,
        slow_times=scene.slow_times or times,
        half_width=scene.half_width or scene.compared * scene.eps,
        losses=scene.losses and scene.losses.weighed(scene.eps),
    )


def _run(scene: Scene, progress: Callable[[float], None], announce: Announce) -> RunRecord:
    from longwave.scenes.engines.lattice_run import record_scene

    run = record_scene(scene, progress, announce)
    wanted = SHARE * float(np.max(_sup_errors(run)))
    if run.attrs["error_estimate"] <= wanted or wanted == 0.0:
        return run
    return record_scene(scene.changed(tolerance=wanted), progress, announce)


def _sup_errors(run: RunRecord) -> Array:
    """The sup errors at the times after the start, in the unit of what is compared."""
    pair = ("strains", "analytics") if "strains" in run.variables else ("strain", "analytic")
    numeric, analytic = (_later(run, name) for name in pair)
    axes = tuple(range(1, numeric.ndim))
    unit = run.scene.eps ** run.attrs["power"]
    return np.asarray(np.max(np.abs(numeric - analytic), axis=axes) / unit)


def _later(run: RunRecord, name: str) -> Array:
    """The values of a variable at the times after the start."""
    return run.values(name)[np.array(run.reached) > run.scene.t0]


def _point(run: RunRecord) -> ConvergencePoint:
    scene, told = run.scene, run.attrs
    errors = _sup_errors(run)
    apart = float(np.max(errors))
    with np.errstate(invalid="ignore"):
        sizes = errors / _later(run, "error")
    size = float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))
    if size == 0.0:
        raise ValueError(
            f"half_width must leave some of the wave in the region at the later times, got 0 there "
            f"with eps = {scene.eps:g} (take a wider region or earlier times)"
        )
    scale = scene.eps ** told["power"]
    return ConvergencePoint(
        scene.eps,
        apart * scale,
        apart / size,
        told["error_estimate"] * scale,
        int(told["sites"]),
        float(told["seconds"] + told["planning_seconds"]),
    )


SEEN = 4
"""Orders behind the reduced equation in which the second that does not vanish is looked for: the
even ones alone are there for cells that look alike from both sides."""

ZERO = 1e-12
"""A coefficient that small, of numbers of order one with 60 digits, is 0."""


def long_wave_rate(reduction: Reduction, lattice: Lattice, order: str) -> int | None:
    """The power of the strain's error for data of that order; None where theory names none.

    That is so for leading data of several fields, whose free waves no expansion follows, and where
    no order behind the equation is found.

    >>> from sympy import S
    >>> from longwave.derive import LATTICES
    >>> chain = LATTICES["fput_strain"].with_values({"K2": S.One, "K3": S.Zero, "K4": S.One})
    >>> found = reduce(chain)
    >>> [long_wave_rate(found, chain, order) for order in ("leading", "corrected")]
    [3, 5]
    """
    scaling = reduction.scaling
    if order == "leading" and len(lattice.fields) > 1:
        return None
    least = scaling.leading_order
    further = reduce(lattice, scaling, least + SEEN).orders
    gaps = sorted(found - least for found in further if found > least)
    place = order == "corrected"
    if len(gaps) <= place:
        return None
    strain = scaling.amplitude + scaling.space[0].exponent * reduction.is_displacement
    left = min(gaps[1], 2 * gaps[0]) if place else gaps[0]
    return strain + left


def envelope_rate(envelope: Envelope, numbers: Mapping[str, Number], order: str) -> int:
    """The power of the error of a carrier wave with data of that order.

    >>> from longwave.derive import LATTICES, envelope
    >>> found = envelope(LATTICES["fput_strain"], 1)
    >>> envelope_rate(found, {"K2": 1, "K3": 0, "K4": 1}, "slaved")
    2
    """
    fields = carrier_fields(envelope, None, None, **numbers)
    is_further = _has(fields.flow[0], 1)
    follows = any(_has(terms, 2) for terms in (*fields.parts, fields.mean))
    return 2 if order != "corrected" and (is_further or (order == "leading" and follows)) else 3


def _has(terms: CarrierTerms, power: int) -> bool:
    """Whether there is a term in eps to that power."""
    return any(term.power == power and abs(term.value) > ZERO for term in terms)


def scene_rate(scene: Scene) -> int | None:
    """The power of eps for the error of a scene; None where theory names none.

    So it is, too, where masses or springs deviate: the waves that these scatter are no part of it;
    and for a soliton that follows the law of its losses, which are not small with eps.
    """
    if scene.disorder:
        return None
    found = derivation(scene)
    if found.law is not None:
        return None
    if isinstance(found.source, Reduction):
        return long_wave_rate(found.source, found.lattice, scene.order)
    return envelope_rate(found.source, found.numbers, scene.order)

"""Convergence study of a scene: the rate at which its error falls with eps, at fixed slow times.

In theory the error is that of the first neglected term: the first nonzero correction of the reduced
equation or, in leading initial data, the fields slaved to the wave.
"""

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
from longwave.scenes.description.scene_checks import positive
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.starts.lattice_derivation import derivation
from longwave.support.html_tables import html_table
from longwave.support.user_files import shown

Array = NDArray[Any]

MIN_ERRORS = 3
"""Minimum number of errors from which a rate and its uncertainty can be fitted."""

MAX_EPS_VALUES = 20
"""Maximum number of values of eps."""

DISCRETISATION_FRACTION = 0.05
"""Largest discretisation error accepted in a run, as a fraction of the error that it measures."""

DEFAULT_FACTORS = (2.0, 1.4, 1.0, 0.7)
"""Default values of eps, in units of the scene's eps."""


@dataclass(frozen=True)
class FittedRate:
    """Power of eps fitted to errors, with an interval for its limit at small eps.

    >>> print(FittedRate(5.82, 5.81, 6.04))
    5.8 (5.8 .. 6.1)
    """

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        low, high = floor(10 * self.low) / 10, ceil(10 * self.high) / 10
        return f"{self.value:.1f} ({low:.1f} .. {high:.1f})"

    def holds(self, power: float) -> bool:
        """Return whether the interval, with its ends rounded as printed, contains ``power``."""
        return floor(10 * self.low) <= 10 * power <= ceil(10 * self.high)


@dataclass(frozen=True)
class ConvergencePoint:
    """Sup error at one eps, over the compared cells and quantities and the times after the start.

    ``relative`` is the error in units of the wave's largest deviation from its background at these
    times; ``discretisation`` is the estimated error of the run itself.
    """

    eps: float
    error: float
    relative: float
    discretisation: float
    sites: int
    seconds: float


@dataclass(frozen=True, repr=False)
class SceneConvergence:
    """Errors of a scene at several eps, and the power of eps fitted to them.

    Errors are absolute; the compared quantity itself is of size eps^``power``. ``theory`` is the
    power predicted by the expansion, or None if it predicts none.
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
        """Whether the interval of the measured rate contains the theoretical power."""
        return self.theory is not None and self.rate.holds(self.theory)

    def data(self) -> dict[str, Any]:
        """Return the study as a JSON-compatible dict."""
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
    """Run the scene at each eps, from the largest to the smallest, and fit the rate.

    A run whose discretisation error is not small compared with the measured error is repeated with
    a smaller tolerance. Raises ValueError for too few or invalid values of eps, and the errors of
    `record_scene`.
    """
    values = _eps_values(scene, eps)
    scene = scene.with_tolerance(scene.target.tolerance).changed(observables=("strain",))
    points: list[ConvergencePoint] = []
    power = 0
    for index, value in enumerate(values):

        def run_progress(done: float, index: int = index) -> None:
            progress((index + done) / len(values))

        run = _run(at_eps(scene, value), run_progress, announce)
        power = run.attrs["power"]
        points.append(_point(run))
    rate = fitted_rate(values, [p.error for p in points], [p.discretisation for p in points])
    equation = derivation(scene).equation
    return SceneConvergence(scene, equation, power, tuple(points), rate, scene_rate(scene))


def fitted_rate(
    eps: Sequence[float], errors: Sequence[float], own: Sequence[float] = ()
) -> FittedRate:
    """Fit the slope of ``log error`` against ``log eps``, with an interval for its limit.

    The slope drifts with eps.  Local slopes are taken between neighbouring eps, at their geometric
    mean.  The interval contains the overall slope, the local slope at the two smallest eps, and the
    values at eps = 0 of lines fitted to the local slopes against eps and eps^2.  It is enlarged by
    the misfit of these lines and by the effect of ``own``, the runs' discretisation errors.  Raises
    ValueError for fewer than three errors, and for eps or errors that are not positive and finite.

    >>> fitted_rate([0.1, 0.2, 0.4], [0.01, 0.04, 0.16]).value
    2.0
    """
    if len(eps) != len(errors) or len(errors) < MIN_ERRORS or len({*eps}) < len(eps):
        raise ValueError(
            f"errors must be at least {MIN_ERRORS}, each at its own eps, got {len(errors)} at "
            f"{len({*eps})} (take more values of eps)"
        )
    if not (min(eps) > 0.0 and 0.0 < min(errors) <= max(errors) < np.inf):
        raise ValueError(
            f"errors must be finite and > 0, got {min(errors):g} to {max(errors):g} (an error of 0 "
            "has no rate)"
        )
    order = np.argsort(eps)
    logs = np.log(np.array([eps, errors], dtype=np.float64)[:, order])
    value = round(float(np.polyfit(logs[0], logs[1], 1)[0]), 12)
    widths, heights = np.diff(logs, axis=1)
    slopes, middles = heights / widths, np.exp((logs[0, 1:] + logs[0, :-1]) / 2)
    lines = [np.polyfit(middles**power, slopes, 1) for power in (1, 2)]
    misfit = min(
        float(np.max(np.abs(np.polyval(line, middles**power) - slopes)))
        for power, line in zip((1, 2), lines, strict=True)
    )
    relative_errors = np.array(own or np.zeros(len(errors)))[order] / np.exp(logs[1])
    margin = misfit + float(np.max((relative_errors[1:] + relative_errors[:-1]) / widths))
    candidates = [value, float(slopes[0]), *(float(line[1]) for line in lines)]
    return FittedRate(value, min(candidates) - margin, max(candidates) + margin)


def _eps_values(scene: Scene, eps: Sequence[float]) -> list[float]:
    """Return the values of eps, largest first; ValueError if invalid, repeated, too few or many."""
    values = [positive("eps", value) for value in eps or [f * scene.eps for f in DEFAULT_FACTORS]]
    if not MIN_ERRORS <= len(set(values)) == len(values) <= MAX_EPS_VALUES:
        raise ValueError(
            f"eps must be {MIN_ERRORS} to {MAX_EPS_VALUES} different values, got {shown(values)} "
            "(such as 0.1,0.07,0.05,0.035)"
        )
    return sorted(values, reverse=True)


def at_eps(scene: Scene, eps: float) -> Scene:
    """Return the scene at another eps, with the same slow times and the same region in X."""
    slow = derivation(scene).slow
    times = tuple(t * scene.eps**slow for t in scene.lattice_times(slow))
    width = scene.half_width or scene.compared * scene.eps
    losses, times = scene.losses, scene.slow_times or times
    losses = losses and losses.as_eps_formulas(scene.eps)
    return scene.changed(eps=eps, slow_times=times, half_width=width, losses=losses)


def _run(scene: Scene, progress: Callable[[float], None], announce: Announce) -> RunRecord:
    from longwave.scenes.engines.lattice_run import record_scene

    run = record_scene(scene, progress, announce)
    allowed = DISCRETISATION_FRACTION * float(np.max(_sup_errors(run)))
    if run.attrs["error_estimate"] <= allowed or allowed == 0.0:
        return run
    return record_scene(scene.changed(tolerance=allowed), progress, announce)


def _sup_errors(run: RunRecord) -> Array:
    """Return the sup error at each snapshot after the start, in units of ``eps**power``."""
    pair = ("strains", "analytics") if "strains" in run.variables else ("strain", "analytic")
    numeric, analytic = (_later(run, name) for name in pair)
    axes = tuple(range(1, numeric.ndim))
    unit = run.scene.eps ** run.attrs["power"]
    return np.asarray(np.max(np.abs(numeric - analytic), axis=axes) / unit)


def _later(run: RunRecord, name: str) -> Array:
    """Return the values of the variable ``name`` at the snapshots after the start."""
    return run.values(name)[np.array(run.reached) > run.scene.t0]


def _point(run: RunRecord) -> ConvergencePoint:
    scene, attributes = run.scene, run.attrs
    errors = _sup_errors(run)
    error = float(np.max(errors))
    with np.errstate(invalid="ignore"):
        sizes = errors / _later(run, "error")
    size = float(np.max(sizes, where=np.isfinite(sizes), initial=0.0))
    if size == 0.0:
        raise ValueError(
            f"half_width must keep some of the wave in the region at the later times, got 0 there "
            f"with eps = {scene.eps:g} (take a wider region or earlier times)"
        )
    scale = scene.eps ** attributes["power"]
    return ConvergencePoint(
        scene.eps,
        error * scale,
        error / size,
        attributes["error_estimate"] * scale,
        int(attributes["sites"]),
        float(attributes["seconds"] + attributes["planning_seconds"]),
    )


SEARCHED_ORDERS = 4
"""Number of orders beyond the reduced equation that are searched for its next two corrections;
lattices with mirror-symmetric cells have even orders only."""

ZERO_COEFFICIENT = 1e-12
"""Magnitude below which a coefficient counts as 0; coefficients are O(1), computed to 60 digits."""


def long_wave_rate(reduction: Reduction, lattice: Lattice, order: str) -> int | None:
    """Return the theoretical power of eps of the strain's error for initial data of this ``order``.

    Returns None for leading data of several fields, which excite free waves that the expansion
    does not describe, and if no correction of the equation is found.

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
    further = reduce(lattice, scaling, least + SEARCHED_ORDERS).orders
    gaps = sorted(power - least for power in further if power > least)
    is_corrected = order == "corrected"
    if len(gaps) <= is_corrected:
        return None
    strain = scaling.amplitude + scaling.space[0].exponent * reduction.is_displacement
    neglected = min(gaps[1], 2 * gaps[0]) if is_corrected else gaps[0]
    return strain + neglected


def envelope_rate(envelope: Envelope, numbers: Mapping[str, Number], order: str) -> int:
    """Return the theoretical power of eps of an envelope's error for data of this ``order``.

    >>> from longwave.derive import LATTICES, envelope
    >>> found = envelope(LATTICES["fput_strain"], 1)
    >>> envelope_rate(found, {"K2": 1, "K3": 0, "K4": 1}, "slaved")
    2
    """
    fields = carrier_fields(envelope, None, None, **numbers)
    has_correction = _has(fields.flow[0], 1)
    has_slaved = any(_has(terms, 2) for terms in (*fields.parts, fields.mean))
    is_second = has_correction or (order == "leading" and has_slaved)
    return 2 if order != "corrected" and is_second else 3


def _has(terms: CarrierTerms, power: int) -> bool:
    """Return whether any of the terms has this power of eps and a nonzero coefficient."""
    return any(term.power == power and abs(term.value) > ZERO_COEFFICIENT for term in terms)


def scene_rate(scene: Scene) -> int | None:
    """Return the theoretical power of eps of a scene's error; None if theory predicts none.

    Also returns None for a scene with disorder, whose scattered waves are not part of the theory,
    and for a soliton with losses, which do not become small with eps.
    """
    if scene.disorder:
        return None
    derived = derivation(scene)
    if derived.law is not None:
        return None
    if isinstance(derived.source, Reduction):
        return long_wave_rate(derived.source, derived.lattice, scene.order)
    return envelope_rate(derived.source, derived.numbers, scene.order)

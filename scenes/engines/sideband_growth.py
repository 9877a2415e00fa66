"""How fast a perturbed plane wave grows on a lattice, against its envelope equation.

The lattice is run on a ring that holds the plane wave and its perturbation, from the perturbation
that grows in theory, or moves where none grows. The two waves beside the carrier are measured at
some moments, each over a period of the carrier, and a line through the logarithms of their size is
the growth rate. So a plane wave that is stable has a rate, too, and an error to judge it by.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from longwave.derive.algebra.formula_expression import exact_value
from longwave.lattice.energy_balance import EnergyBalance
from longwave.lattice.integration import CellEngine, StateComparison
from longwave.lattice.refine import Announce, refine
from longwave.lattice.schemes import stability_limit
from longwave.lattice.state import GROWTH, State
from longwave.lattice.trial import Progress
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import positive
from longwave.scenes.engines.domain_plan import (
    LIMIT_SHARE,
    SCHEME,
    check_rest,
    longest_step,
    stiffest_slopes,
)
from longwave.scenes.engines.recorders import Variables
from longwave.scenes.engines.ring_cost import search_cost
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.starts.envelope_data import EnvelopeData
from longwave.scenes.starts.lattice_derivation import scene_envelope
from longwave.scenes.starts.perturbed_plane import (
    MOST_WAVES,
    SIZE,
    PerturbedPlane,
    PlaneDomain,
    chosen_kappa,
    plane_domain,
)
from longwave.support.checkpoint import restored_seconds
from longwave.support.request_limits import ExpectedCost, OverBudgetError, check_request

if TYPE_CHECKING:
    from longwave.derive import Envelope
    from longwave.scenes.starts.initial_cells import InitialCells

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MOMENTS = 9
"""At which the two waves are measured, evenly spaced."""

SAMPLES = 8
"""Of each moment: a mean over a carrier's period, to which its harmonics add nothing."""

GROWING = (1.5, 5.0)
"""First and last moment, in units of 1/sigma: what decays has gone, and the perturbation is still
small."""

BEATS = 4
"""Of a wave that does not grow: from the first moment to the last, beats of b and c with what else
the data hold; and no less than one that grows fastest would take, or what the plane wave does
meanwhile, more slowly, is a line."""

LEVER = 2.5 / (15.0 / 16.0)
"""By how much a line through the moments may be steeper for what each is off, times their span:
``sum |x| / sum x^2`` over `MOMENTS` places x from -1/2 to 1/2."""

GROWTH_EVALUATIONS = 32.0
"""A wave that grows G-fold begins in 1/(2 ln G) of a run, a 32nd for G = 1e7: of so many roundings
one counts."""

SEEN = 3.0
"""A rate is told from 0 if it is larger than that many times its error."""


class GrowthPlan(NamedTuple):
    """The ring, the wave on it, its data, and the moments of a scene that measures growth."""

    ring: PlaneDomain
    wave: PerturbedPlane
    data: EnvelopeData
    moments: Array


@dataclass(frozen=True)
class SidebandGrowth:
    """A growth rate in T as it was measured, and in theory.

    ``sizes``: of the two waves together at the ``moments``, in units of the carrier's. ``error``:
    what the measured rate may be off, by the run's steps and rounding (``run_error``) and as the
    sizes are on no line.
    """

    scene: Scene
    plan: GrowthPlan
    sizes: Array
    run_error: float
    cost: Mapping[str, Any]

    @property
    def theory(self) -> float:
        """The growth rate in T by the envelope equation, 0 where the plane wave is stable."""
        return self.plan.wave.growth

    @cached_property
    def measured(self) -> float:
        """The growth rate in T on the lattice."""
        return float(self._line[0])

    @cached_property
    def error(self) -> float:
        """What the measured rate may be off, in T."""
        steepest = LEVER / float(np.ptp(self.slow_times))
        off = np.log(self.sizes) - np.polyval(self._line, self.slow_times)
        return self.run_error + steepest * float(np.max(np.abs(off)))

    @property
    def difference(self) -> float:
        """Measured less theory, in units of the largest growth rate ``|q| a^2``."""
        return (self.measured - self.theory) / self.plan.wave.largest_growth

    @property
    def grows(self) -> bool:
        """Whether the measured rate is told from 0."""
        return self.measured > SEEN * self.error

    @cached_property
    def _line(self) -> Array:
        return np.polyfit(self.slow_times, np.log(self.sizes), 1)

    @property
    def slow_times(self) -> Array:
        """T at the moments."""
        return self.plan.moments * self.scene.eps**2

    def verdict(self) -> str:
        """Measurement and theory in one line."""
        ring, wave = self.plan.ring, self.plan.wave
        found = (
            f"k = {float(ring.k):.6g}, kappa = {wave.kappa:.4g}: growth rate {self.measured:.4g} "
            f"+- {self.error:.1g} in T"
        )
        if self.theory == 0.0:
            why = "p q < 0" if wave.p * wave.q < 0 else "kappa beyond its band"
            seen = "grows all the same" if self.grows else "no growth is seen"
            return f"{found}, theory 0: the plane wave is stable ({why}), and {seen}"
        if not self.grows:
            return (
                f"{found}, theory {self.theory:.4g}: no growth is told from its error (what is "
                "measured is on no line: other waves may grow, too)"
            )
        percent = 100 * (self.measured / self.theory - 1)
        return f"{found}, theory {self.theory:.4g}: off by {percent:.2g} %"

    def numbers(self) -> Mapping[str, tuple[float, str, str]]:
        """What there is one number of: value, unit and long name."""
        ring, wave = self.plan.ring, self.plan.wave
        return {
            "growth_rate": (self.measured, RATE, "growth rate in T, on the lattice"),
            "growth_rate_error": (self.error, RATE, "what the measured rate may be off"),
            "growth_rate_theory": (self.theory, RATE, "growth rate in T, by the envelope equation"),
            "carrier_k": (float(ring.k), "1/site", "wavenumber of the carrier on the ring"),
            "perturbation_kappa": (wave.kappa, "1/X", "wavenumber of the perturbation, in X"),
            "p": (wave.p, "1", "p of the envelope equation"),
            "q": (wave.q, "1", "q of the envelope equation"),
        }

    @property
    def record(self) -> RunRecord:
        """The run: the sizes over time, and the rates, without dimensions."""
        T, wave = self.slow_times, self.plan.wave
        theory = self.sizes[0] * np.exp(wave.growth * (T - T[0]))
        along = {
            "sideband_size": (self.sizes, "waves beside the carrier, over the carrier"),
            "sideband_theory": (theory, "the same, growing as in theory from the first"),
            "slow_time": (T, "T, the envelope's own time"),
        }
        data: Variables = {
            name: (("time",), values, {"units": "1", "long_name": told})
            for name, (values, told) in along.items()
        }
        for name, (value, unit, told) in self.numbers().items():
            data[name] = ((), np.float64(value), {"units": unit, "long_name": told})
        attributes = {
            "equation": f"i A_T + p A_XX + q |A|^2 A = 0, p = {wave.p:.6g}, q = {wave.q:.6g}",
            "verdict": self.verdict(),
            "error": abs(self.difference),
            "own_error": self.error / wave.largest_growth,
            "error_estimate": self.run_error / wave.largest_growth,
            "tolerance": self.scene.target.tolerance,
            **self.cost,
        }
        moments = self.plan.moments.tolist()
        return RunRecord(self.scene, (0,), moments, data, attributes)


RATE = "1/slow time"


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> RunRecord:
    """The record of `measure_growth`, which has no states to begin at."""
    assert restart is None
    return measure_growth(scene, progress, announce).record


def scene_cost(scene: Scene) -> ExpectedCost:
    """What a scene is expected to cost; ValueError as `measure_growth` raises it before a run."""
    return expected_growth_cost(growth_plan(scene))


def measure_growth(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> SidebandGrowth:
    """Derive the scene's envelope equation and measure how its perturbed plane wave grows.

    ``progress`` is called with the share of the work that is done, ``announce`` with the seconds
    that are expected to pass. Raises ValueError in one line for what the envelope does not admit,
    what would take too long, and a lattice that blows up.
    """
    begun = perf_counter()
    plan = growth_plan(scene)
    runs = SidebandRuns(plan, scene)
    announce = announce or (lambda _: None)
    announce(runs.expected.seconds)
    try:
        found = refine(runs.engine, scene.target.tolerance, progress or (lambda _: None), announce)
    except OverBudgetError as dear:
        raise ValueError(runs.engine.budget_message(dear.work, scene.tolerance)) from None
    runs.engine.check_followed(found.trial)
    if math.isinf(found.error) or found.trial.values is None:
        raise ValueError(
            f"amplitude must leave a plane wave that lasts, got one on {scene.lattice} that blows "
            "up (take a smaller amplitude or eps)"
        )
    _, steps, _, _ = found.trial.payload
    whole = perf_counter() - begun + restored_seconds()
    cost = {
        "engine": "stencil",
        "scheme": SCHEME.name,
        "steps": steps,
        "sites": plan.ring.cells,
        "force_evaluations": steps * SCHEME.stages,
        "seconds": found.trial.seconds,
        "planning_seconds": whole - found.trial.seconds,
        "blow_up": "",
    }
    run_error = found.error * plan.wave.largest_growth
    return SidebandGrowth(scene, plan, np.exp(found.trial.values / runs.scale), run_error, cost)


@lru_cache(maxsize=4)
def growth_plan(scene: Scene) -> GrowthPlan:
    """What is run for a scene, all but its step; ValueError where there is no such plane wave."""
    found, constants = scene_envelope(scene)
    given = plane_wave_numbers(scene)
    a, k = given["amplitude"], exact_value("k", scene.carrier)
    p, q = _coefficients(found, k, constants)
    kappa = float(chosen_kappa(p, q, given))
    cells = 2 * math.pi / (kappa * scene.eps)
    if not cells * MOST_WAVES < MOST_CELLS:
        raise ValueError(
            f"eps must leave a perturbation of fewer than {MOST_CELLS / MOST_WAVES:.0e} cells, got "
            f"{cells:.3g} (take a larger eps, amplitude or kappa)"
        )
    ring = plane_domain(k, kappa * scene.eps)
    if ring.k != k:
        p, q = _coefficients(found, ring.k, constants)
    wave = PerturbedPlane(a, p, q, ring.perturbation / scene.eps)
    data = EnvelopeData(found, constants, wave, scene.eps, scene.order, k=ring.k, mean_square=a**2)
    period = 2 * math.pi / data.carrier.omega
    if wave.growth:
        first, last = (units / wave.growth / scene.eps**2 for units in GROWING)
    else:
        beats, fastest = BEATS * math.pi / abs(wave.rate), np.ptp(GROWING) / wave.largest_growth
        first, last = 0.0, max(beats, float(fastest)) / scene.eps**2
    moments = np.linspace(first, last, MOMENTS)
    return GrowthPlan(ring, wave, data, moments + max(0.0, period - first))


def plane_wave_numbers(scene: Scene) -> dict[str, float]:
    """The parameters of a scene's perturbed plane wave; ValueError unless they are positive."""
    found = {name: float(exact_value(name, value)) for name, value in scene.parameters}
    for name, value in found.items():
        positive(name, value)
    return found


def _coefficients(found: Envelope, k: Expr, constants: Mapping[str, Expr]) -> tuple[float, float]:
    numbers = found.coefficients(k, None, **constants)
    if numbers.q == 0:
        raise ValueError(
            f"constants must leave a nonlinearity, q != 0, got q = 0 at k = {float(k):.6g} (there "
            "the next order takes its place)"
        )
    return numbers.p, numbers.q


MOST_CELLS = 1e9
"""Of one wavelength of a perturbation; more than any machine holds."""


PLAN_SECONDS = 0.025
"""For the envelope's coefficients at a wavenumber, to 60 digits, times the cube of the fields:
0.02 s on a chain and 0.21 s on a dimer."""


def expected_growth_cost(plan: GrowthPlan, fastest: float | None = None) -> ExpectedCost:
    """What a scene is expected to cost whose ``fastest`` wave has that frequency, or that about
    the rest.
    """
    lattice = plan.data.lattice
    fastest = fastest or lattice.highest_frequency(lattice.rest_slopes())
    steps = float(plan.moments[-1]) * fastest / (LIMIT_SHARE * stability_limit(SCHEME))
    found = search_cost(lattice, float(plan.ring.cells), steps, SCHEME.stages, 0.0)
    planning = PLAN_SECONDS * len(lattice.fields) ** 3
    return replace(found, seconds=found.seconds + planning)


class SidebandRuns:
    """Runs of a plane wave's ring, and what is seen of its perturbation on them.

    What is compared are the logarithms of the sizes at the moments, times a ``scale``: what these
    are off, a growth rate is at most, in units of the largest in theory. Other waves on the ring
    may grow faster than the perturbation, from rounding: data are nudged by as much as all
    roundings add up to while these waves begin. Raises ValueError for what would take too long.
    """

    def __init__(self, plan: GrowthPlan, scene: Scene) -> None:
        self.plan = plan
        span = float(np.ptp(plan.moments)) * scene.eps**2
        self.scale = LEVER / span / plan.wave.largest_growth
        omega = plan.data.carrier.omega
        places = (np.arange(SAMPLES) - (SAMPLES - 1) / 2) / SAMPLES
        samples = np.add.outer(plan.moments, places * 2 * np.pi / omega)
        times, rows = np.unique(samples, return_inverse=True)
        self._rows = rows.reshape(samples.shape)
        self._check_cost(times)
        self.ring: InitialCells = plan.data.ring(np.arange(float(plan.ring.cells)), 0.0)
        lattice, stiffest = self.ring.lattice, stiffest_slopes(self.ring)
        rest = lattice.rest_slopes()
        check_rest(lattice, rest)
        fastest = max(lattice.highest_frequency(stiffest), lattice.highest_frequency(rest))
        self._check_cost(times, fastest)
        self._least = self._largest(self.ring.f)
        longest = longest_step(fastest, abs(omega))
        evaluations = times[-1] / longest * SCHEME.stages
        self.engine = CellEngine(
            lattice,
            State(0.0, self.ring.f, self.ring.v),
            times,
            SCHEME,
            StateComparison(self._sidebands, self._logarithms, 1.0 / self.scale / SIZE),
            stored_times=times[:0],
            tolerance=scene.target.tolerance,
            longest=longest,
            amplified=math.sqrt(max(1.0, evaluations / GROWTH_EVALUATIONS)),
        )

    def _check_cost(self, times: Array, fastest: float | None = None) -> None:
        self.expected = expected_growth_cost(self.plan, fastest)
        check_request(
            f"scene of {self.plan.ring.cells} cells until t = {times[-1]:.3g}",
            self.expected,
            "take a larger eps or amplitude, or another k or kappa, where growth is faster",
        )

    def _largest(self, f: Array) -> float:
        return float(np.max(np.abs(self.plan.data.measured(f, self.ring.mean_strain))))

    def _sidebands(self, state: State, _: EnergyBalance | None) -> Complex:
        """The two waves beside the carrier and that itself, (3, fields), of those that move as it
        does, in a frame that turns with it.

        No numbers where the lattice has left the plane wave.
        """
        ring, omega = self.plan.ring, self.plan.data.carrier.omega
        spectrum = np.fft.fft(state.f + 1j * state.v / omega)
        places = ring.turns + np.array([-ring.waves, ring.waves, 0])
        turned: Complex = spectrum[:, places % ring.cells].T * np.exp(1j * omega * state.t)
        is_left = not self._largest(state.f) <= GROWTH * self._least
        if is_left:
            turned[...] = np.nan
        return turned

    def _logarithms(self, measured: Complex) -> Array:
        means = np.mean(measured[self._rows], axis=1)
        sizes = np.sqrt(np.sum(np.abs(means) ** 2, axis=2))
        with np.errstate(all="ignore"):
            found: Array = np.log(np.hypot(sizes[:, 0], sizes[:, 1]) / sizes[:, 2])
        return self.scale * found

"""Growth rate of a perturbed plane wave on a lattice, compared with its envelope equation.

The lattice is run on a ring that fits the plane wave and its perturbation. The run starts from the
eigenmode of the envelope equation that grows, or oscillates if the plane wave is stable. The two
sidebands of the carrier are measured at `MEASUREMENTS` times, each averaged over a carrier period.
The slope of a line through the logarithms of their size is the growth rate. A stable plane wave
thus also has a measured rate, with an error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
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
    LIMIT_FRACTION,
    SCHEME,
    check_rest,
    longest_step,
    stiffest_slopes,
)
from longwave.scenes.engines.recorders import Variables
from longwave.scenes.engines.ring_cost import enlarged, search_cost
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.starts import perturbed_plane
from longwave.scenes.starts.envelope_data import EnvelopeData
from longwave.scenes.starts.lattice_derivation import scene_envelope
from longwave.support.checkpoint import restored_seconds
from longwave.support.real_arrays import Array
from longwave.support.request_limits import ExpectedCost, OverBudgetError, check_request

if TYPE_CHECKING:
    from longwave.derive import Envelope
    from longwave.scenes.starts.initial_cells import InitialCells

Complex = NDArray[np.complex128]

MEASUREMENTS = 9
"""Number of evenly spaced times at which the sidebands are measured."""

SAMPLES_PER_PERIOD = 8
"""Samples averaged at each measurement, over one carrier period, so that harmonics cancel."""

GROWTH_SPAN = (1.5, 5.0)
"""First and last measurement of a growing perturbation, in units of 1/sigma: the decaying mode has
vanished and the perturbation is still small."""

STABLE_BEATS = 4
"""Duration of the measurement of a stable wave, in beats of its sidebands with the other modes of
the data. The duration is at least that for the fastest growing perturbation; otherwise slow
changes of the plane wave would look like growth."""

SLOPE_FACTOR = 2.5 / (15.0 / 16.0)
"""Largest error of the fitted slope, times the time span, per error of the measured values:
``sum |x| / sum x^2`` over `MEASUREMENTS` points x from -1/2 to 1/2."""

GROWTH_EVALUATIONS = 32.0
"""Inverse fraction of a run in which rounding errors matter: a mode that grows G-fold amplifies
those made in the first 1/(2 ln G) of the run, a 32nd for G = 1e7."""

SIGNIFICANT_ERRORS = 3.0
"""A growth rate is significant if it exceeds this many times its error."""


class GrowthPlan(NamedTuple):
    """Ring, perturbed plane wave, initial data and measurement times of a growth scene."""

    ring: perturbed_plane.PlaneDomain
    wave: perturbed_plane.PerturbedPlane
    data: EnvelopeData
    moments: Array


@dataclass(frozen=True)
class SidebandGrowth:
    """Measured and theoretical growth rate of a perturbation, in the slow time T.

    ``sizes`` are the sizes of both sidebands together, in units of the carrier, at the plan's
    ``moments``. ``error`` bounds the error of the measured rate: that of the run's steps and
    rounding (``run_error``) plus that of the line fit.
    """

    scene: Scene
    plan: GrowthPlan
    sizes: Array
    run_error: float
    cost: Mapping[str, Any]

    @property
    def theory(self) -> float:
        """Growth rate in T from the envelope equation; 0 if the plane wave is stable."""
        return self.plan.wave.growth

    @cached_property
    def measured(self) -> float:
        """Growth rate in T measured on the lattice."""
        return float(self._line[0])

    @cached_property
    def error(self) -> float:
        """Error bound of the measured growth rate, in T."""
        steepest = SLOPE_FACTOR / float(np.ptp(self.slow_times))
        residuals = np.log(self.sizes) - np.polyval(self._line, self.slow_times)
        return self.run_error + steepest * float(np.max(np.abs(residuals)))

    @property
    def difference(self) -> float:
        """Measured minus theoretical rate, in units of the largest growth rate ``|q| a^2``."""
        return (self.measured - self.theory) / self.plan.wave.largest_growth

    @property
    def grows(self) -> bool:
        """Whether the measured growth rate is significantly above 0."""
        return self.measured > SIGNIFICANT_ERRORS * self.error

    @cached_property
    def _line(self) -> Array:
        return np.polyfit(self.slow_times, np.log(self.sizes), 1)

    @property
    def slow_times(self) -> Array:
        """Slow times T of the measurements."""
        return self.plan.moments * self.scene.eps**2

    def verdict(self) -> str:
        """Return one line of text that compares the measured with the theoretical rate."""
        ring, wave = self.plan.ring, self.plan.wave
        measurement = f"k = {float(ring.k):.6g}, kappa = {wave.kappa:.4g}: growth rate "
        measurement += f"{self.measured:.4g} +- {self.error:.1g} in T"
        if self.theory == 0.0:
            reason = "p q < 0" if wave.p * wave.q < 0 else "kappa outside the unstable band"
            growth = "but it grows" if self.grows else "and no growth is measured"
            return f"{measurement}, theory 0: the plane wave is stable ({reason}), {growth}"
        finding = f"off by {100 * (self.measured / self.theory - 1):.2g} %"
        if not self.grows:
            finding = "no significant growth (the sizes do not follow an exponential; other waves "
            finding += "may grow, too)"
        return f"{measurement}, theory {self.theory:.4g}: {finding}"

    def numbers(self) -> Mapping[str, tuple[float, str, str]]:
        """Return the scalar results by name, each as value, unit and long name."""
        ring, wave, unit = self.plan.ring, self.plan.wave, "1/slow time"
        return {
            "growth_rate": (self.measured, unit, "growth rate in T, on the lattice"),
            "growth_rate_error": (self.error, unit, "what the measured rate may be off"),
            "growth_rate_theory": (self.theory, unit, "growth rate in T, by the envelope equation"),
            "carrier_k": (float(ring.k), "1/site", "wavenumber of the carrier on the ring"),
            "perturbation_kappa": (wave.kappa, "1/X", "wavenumber of the perturbation, in X"),
            "p": (wave.p, "1", "p of the envelope equation"),
            "q": (wave.q, "1", "q of the envelope equation"),
        }

    @property
    def record(self) -> RunRecord:
        """Run record with the sideband sizes over time and the rates as scalars."""
        T, wave = self.slow_times, self.plan.wave
        theory = self.sizes[0] * np.exp(wave.growth * (T - T[0]))
        data: Variables = {
            name: (("time",), values, {"units": "1", "long_name": long_name})
            for name, values, long_name in (
                ("sideband_size", self.sizes, "waves beside the carrier, over the carrier"),
                ("sideband_theory", theory, "the same, growing as in theory from the first"),
                ("slow_time", T, "T, the envelope's own time"),
            )
        }
        for name, (value, unit, long_name) in self.numbers().items():
            data[name] = ((), np.float64(value), {"units": unit, "long_name": long_name})
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


def record_scene(
    scene: Scene, progress: Progress | None, announce: Announce | None, restart: State | None
) -> RunRecord:
    """Run a growth scene and return the record of `measure_growth`; ``restart`` must be None."""
    assert restart is None
    return measure_growth(scene, progress, announce).record


def scene_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of a growth scene; ValueError for an inadmissible wave."""
    return expected_growth_cost(growth_plan(scene))


def measure_growth(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> SidebandGrowth:
    """Derive the scene's envelope equation and measure the growth of its perturbed plane wave.

    ``progress`` is called with the completed fraction, ``announce`` with the expected seconds.
    Raises ValueError for a scene that the envelope does not admit, one that would take
    too long, and a lattice that blows up.
    """
    begun = perf_counter()
    plan = growth_plan(scene)
    runs = SidebandRuns(plan, scene)
    announce = announce or (lambda _: None)
    announce(runs.expected.seconds)
    try:
        result = refine(runs.engine, scene.target.tolerance, progress or (lambda _: None), announce)
    except OverBudgetError as error:
        raise ValueError(runs.engine.budget_message(error.work, scene.tolerance)) from None
    runs.engine.check_followed(result.trial)
    if math.isinf(result.error) or result.trial.values is None:
        raise ValueError(
            f"amplitude must be small enough for a bounded plane wave, got one on {scene.lattice} "
            "that blows up (take a smaller amplitude or eps)"
        )
    _, steps, _, _ = result.trial.payload
    whole = perf_counter() - begun + restored_seconds()
    cost = {
        "engine": "stencil",
        "scheme": SCHEME.name,
        "steps": steps,
        "sites": plan.ring.cells,
        "force_evaluations": steps * SCHEME.stages,
        "seconds": result.trial.seconds,
        "planning_seconds": whole - result.trial.seconds,
        "blow_up": "",
    }
    run_error = result.error * plan.wave.largest_growth
    return SidebandGrowth(scene, plan, np.exp(result.trial.values / runs.scale), run_error, cost)


@lru_cache(maxsize=4)
def growth_plan(scene: Scene) -> GrowthPlan:
    """Return ring, wave, data and times of a growth scene; ValueError for an inadmissible wave."""
    envelope, constants = scene_envelope(scene)
    parameters = plane_wave_numbers(scene)
    a, k = parameters["amplitude"], exact_value("k", scene.carrier)
    p, q = _coefficients(envelope, k, constants)
    kappa = float(perturbed_plane.chosen_kappa(p, q, parameters))
    cells = 2 * math.pi / (kappa * scene.eps)
    most = MAX_WAVELENGTH_CELLS / perturbed_plane.MAX_WAVES
    if not cells < most:
        raise ValueError(
            f"eps must leave a perturbation of fewer than {most:.0e} cells, got {cells:.3g} (take "
            "a larger eps, amplitude or kappa)"
        )
    ring = perturbed_plane.plane_domain(k, kappa * scene.eps)
    if ring.k != k:
        p, q = _coefficients(envelope, ring.k, constants)
    wave = perturbed_plane.PerturbedPlane(a, p, q, ring.perturbation / scene.eps)
    data = EnvelopeData(
        envelope, constants, wave, scene.eps, scene.order, k=ring.k, mean_square=a**2
    )
    period = 2 * math.pi / data.carrier.omega
    if wave.growth:
        first, last = (units / wave.growth / scene.eps**2 for units in GROWTH_SPAN)
    else:
        fastest = float(np.ptp(GROWTH_SPAN) / wave.largest_growth)
        first, last = 0.0, max(STABLE_BEATS * math.pi / abs(wave.rate), fastest) / scene.eps**2
    moments = np.linspace(first, last, MEASUREMENTS)
    return GrowthPlan(ring, wave, data, moments + max(0.0, period - first))


def plane_wave_numbers(scene: Scene) -> dict[str, float]:
    """Return the perturbed plane wave's parameters as floats; ValueError unless all positive."""
    return {name: positive(name, float(exact_value(name, v))) for name, v in scene.parameters}


def _coefficients(
    envelope: Envelope, k: Expr, constants: Mapping[str, Expr]
) -> tuple[float, float]:
    numbers = envelope.coefficients(k, None, **constants)
    if numbers.q == 0:
        raise ValueError(
            f"constants must leave a nonlinearity, q != 0, got q = 0 at k = {float(k):.6g} (the "
            "next order would dominate there; take another k)"
        )
    return numbers.p, numbers.q


MAX_WAVELENGTH_CELLS = 1e9
"""Maximum number of cells in one wavelength of a perturbation; no machine can store more."""


PLAN_SECONDS = 0.025
"""Seconds for the envelope's coefficients at a wavenumber to 60 digits, times the number of fields
cubed: 0.02 s on a chain and 0.21 s on a dimer."""


def expected_growth_cost(plan: GrowthPlan, fastest: float | None = None) -> ExpectedCost:
    """Return a plan's expected cost; ``fastest`` is the highest frequency, by default at rest."""
    lattice = plan.data.lattice
    fastest = fastest or lattice.highest_frequency(lattice.rest_slopes())
    steps = float(plan.moments[-1]) * fastest / (LIMIT_FRACTION * stability_limit(SCHEME))
    cost = search_cost(lattice, float(plan.ring.cells), steps, SCHEME.stages, 0.0)
    return enlarged(cost, PLAN_SECONDS * len(lattice.fields) ** 3)


class SidebandRuns:
    """Runs of a perturbed plane wave on its ring, with the measurement of its sidebands.

    Runs are compared by the logarithms of the sideband sizes, times a ``scale`` such that their
    error bounds that of the growth rate in units of the largest theoretical rate. Rounding errors
    may excite other modes that grow faster than the perturbation; a control run's data are changed
    by as much as the rounding errors that accumulate before these modes dominate. Raises ValueError
    for a scene that would take too long.
    """

    def __init__(self, plan: GrowthPlan, scene: Scene) -> None:
        self.plan = plan
        span = float(np.ptp(plan.moments)) * scene.eps**2
        self.scale = SLOPE_FACTOR / span / plan.wave.largest_growth
        omega = plan.data.carrier.omega
        phases = (np.arange(SAMPLES_PER_PERIOD) - (SAMPLES_PER_PERIOD - 1) / 2) / SAMPLES_PER_PERIOD
        samples = np.add.outer(plan.moments, phases * 2 * np.pi / omega)
        times, rows = np.unique(samples, return_inverse=True)
        self._rows = rows.reshape(samples.shape)
        self._check_cost(times)
        self.ring: InitialCells = plan.data.ring(np.arange(float(plan.ring.cells)), 0.0)
        lattice, stiffest = self.ring.lattice, stiffest_slopes(self.ring)
        rest = lattice.rest_slopes()
        check_rest(lattice, rest)
        fastest = max(lattice.highest_frequency(stiffest), lattice.highest_frequency(rest))
        self._check_cost(times, fastest)
        self._initial_size = self._largest(self.ring.f)
        longest = longest_step(fastest, abs(omega))
        evaluations = times[-1] / longest * SCHEME.stages
        unit = 1.0 / self.scale / perturbed_plane.PERTURBATION_SIZE
        self.engine = CellEngine(
            lattice,
            State(0.0, self.ring.f, self.ring.v),
            times,
            SCHEME,
            StateComparison(self._sidebands, self._logarithms, unit),
            stored_times=times[:0],
            tolerance=scene.target.tolerance,
            longest=longest,
            amplified=math.sqrt(max(1.0, evaluations / GROWTH_EVALUATIONS)),
        )

    def _check_cost(self, times: Array, fastest: float | None = None) -> None:
        self.expected = expected_growth_cost(self.plan, fastest)
        scene = f"scene of {self.plan.ring.cells} cells until t = {times[-1]:.3g}"
        remedy = "take a larger eps or amplitude, or another k or kappa with faster growth"
        check_request(scene, self.expected, remedy)

    def _largest(self, f: Array) -> float:
        return float(np.max(np.abs(self.plan.data.quantity_values(f, self.ring.mean_strain))))

    def _sidebands(self, state: State, _: EnergyBalance | None) -> Complex:
        """Return the amplitudes of both sidebands and the carrier, shape (3, fields).

        Only waves in the carrier's direction count; the carrier's phase rotation is removed. All
        amplitudes are NaN if the fields have grown far beyond the initial plane wave.
        """
        ring, omega = self.plan.ring, self.plan.data.carrier.omega
        spectrum = np.fft.fft(state.f + 1j * state.v / omega)
        modes = ring.turns + np.array([-ring.waves, ring.waves, 0])
        amplitudes: Complex = spectrum[:, modes % ring.cells].T * np.exp(1j * omega * state.t)
        has_left_wave = not self._largest(state.f) <= GROWTH * self._initial_size
        if has_left_wave:
            amplitudes[...] = np.nan
        return amplitudes

    def _logarithms(self, measured: Complex) -> Array:
        means = np.mean(measured[self._rows], axis=1)
        sizes = np.sqrt(np.sum(np.abs(means) ** 2, axis=2))
        with np.errstate(all="ignore"):
            logarithms: Array = np.log(np.hypot(sizes[:, 0], sizes[:, 1]) / sizes[:, 2])
        return self.scale * logarithms

"""Hard cases in which the code must stay stable. To add a case, add one function.

The periodic waves are the lattice's own travelling waves, so the seeded mode is the only
perturbation.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice import schemes
from longwave.lattice.model import Model
from longwave.lattice.state import State
from longwave.lattice.stepper import Stepper, advance
from longwave.reports.studies.doubledouble_ring import advance_doubled, doubled
from longwave.reports.studies.travelling_waves import TravellingWave, fastest_mode, travelling_wave
from longwave.scenes import resume, run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.window import Window
from longwave.scenes.starts.background_growth import UNIT_ROUNDOFF, predictability_time
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.support.processes import Job, Key

Array = NDArray[np.float64]

LINEAR, HARDENING = Model(4.0, 0.0, 0.0), Model(1.0, 0.0, 1.0)
"""The models (K2, K3, K4) of a chain with linear springs, and of one with hardening springs."""

NOISE = 1e-12
"""Amplitude of the alternating strains +-NOISE from which an instability grows."""

CN = ("wave_cn", 0.8, 20, 1, 1)
"""The unstable cn background: name of the closed form, k, period in sites, K2, K4."""

CN_WAVELENGTHS, CN_STEP = 16, 0.25
"""Ring with the unstable cn background: its length in wavelengths, and its time step."""

CN_SITES = np.arange(float(CN_WAVELENGTHS * CN[2]))
"""Site numbers of the ring with the unstable cn background."""

Reading = float | tuple[float, str]
"""Number that a hard case is judged by, alone or with the message that the case produced."""


@dataclass(frozen=True)
class HardCase:
    """A hard case: a ``setup``, and a ``criterion``, which is a number with an upper bound.

    Texts hold mathematics between dollars, as claims do. ``slow`` cases take more than about 2 s.
    A finished case has the number ``measured``, and the ``message`` to the user if there is one.
    """

    setup: str
    criterion: str
    bound: float
    measured: float = math.nan
    message: str = ""
    slow: bool = False

    @property
    def passed(self) -> bool:
        """Whether the number is within its bound; False for NaN."""
        return self.measured <= self.bound


HARD_CASES: dict[str, HardCase] = {}
MEASURES: dict[str, Callable[[], Reading]] = {}
"""Name of a hard case -> function that measures it (`HARD_CASES`: name -> the case itself)."""


def hard_case(
    setup: str, criterion: str, bound: float, slow: bool = False
) -> Callable[[Callable[[], Reading]], Callable[[], Reading]]:
    """Register the decorated function to measure a hard case, which gets the function's name."""

    def declare(measure: Callable[[], Reading]) -> Callable[[], Reading]:
        name = measure.__name__.lstrip("_")
        HARD_CASES[name] = HardCase(setup, criterion, bound, slow=slow)
        MEASURES[name] = measure
        return measure

    return declare


@hard_case(
    "each scheme with a step $10^{-6}$ past its linear stability limit",
    "relative difference of the reported limit and the observed one (infinite unless refused)",
    1e-3,
)
def _step_limit() -> Reading:
    """Return the largest relative difference between a scheme's stated and observed step limit.

    It is infinite unless steps just above all limits are refused.
    """
    worst, messages = 0.0, []
    for scheme in schemes.SCHEMES:
        limit = schemes.stability_limit(scheme) / LINEAR.highest_frequency(np.zeros(1))
        schemes.check_step(limit * (1.0 - 1e-6), scheme, LINEAR.highest_frequency(np.zeros(1)))
        try:
            schemes.check_step(limit * (1.0 + 1e-6), scheme, LINEAR.highest_frequency(np.zeros(1)))
        except ValueError as error:
            messages.append(str(error))
        worst = max(worst, abs(_observed_limit(scheme, limit) / limit - 1.0))
    return (worst if len(messages) == len(schemes.SCHEMES) else math.inf), messages[0]


def _observed_limit(scheme: schemes.Scheme, limit: float) -> float:
    """Return the step at which zone-boundary noise starts to grow in the kernels, by bisection.

    Past its limit a scheme may be unstable in a narrow resonance only, so the search ends close
    above the limit. Returns infinity if the noise does not grow there.
    """
    low, high = 0.98 * limit, 1.0002 * limit
    if not _noise_grows(scheme, high):
        return math.inf
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _noise_grows(scheme, middle) else (middle, high)
    return low


def _noise_grows(scheme: schemes.Scheme, step: float) -> bool:
    y, s = np.tile([NOISE, -NOISE], 4), np.zeros(8)
    advance(scheme, y[None], s[None], step, 40_000, LINEAR.lattice)
    return not np.max(np.abs(y)) < 1e3 * NOISE


def soft_scene() -> Scene:
    """Return a steep sn wave, 7 sites long, with strains near 1/sqrt(3), where V'' = 0."""
    wave: dict[str, Any] = {"wave": "wave_sn", "parameters": (("k", 0.9),), "eps": 0.1}
    times: dict[str, Any] = {"t0": -20.0, "snapshots": (-20.0, -10.0, 200.0), "step": 0.5}
    sites: dict[str, Any] = {"domain": "ring", "sites": 1680, "compared": 50}
    model = {"K2": 1.0, "K4": -1.0}
    scene = Scene.of(name="soft", observables=("strain",), **wave, **times, **sites, **model)
    return replace(scene, eps=float(moving_wave(scene).wave.wavelength or math.nan) / 7.0)


@hard_case(
    "a wave that crosses $V''=0$: the lattice goes soft",
    "steps between the reported time and a double-double run's",
    1.0,
)
def _soft_lattice() -> Reading:
    scene = soft_scene()
    result = run(scene)
    text = str(result.attrs["blow_up"]).partition(" (")[0]
    is_sound = result.time.values.tolist() == [-20.0, -10.0] and np.isfinite(result.strain).all()
    t, site = _first_soft_site(scene)
    expected = f"blow-up: a bond is stretched to where waves grow at t = {t:g}, site {site}"
    reported_time = float(text.split("t = ")[1].split(",")[0]) if "t = " in text else math.nan
    sound = is_sound and f"site {site}," in f"{text}," and text[:50] == expected[:50]
    steps = abs(reported_time - t) / scene.discretisation.step
    return (steps if sound else math.inf), text


def _first_soft_site(scene: Scene) -> tuple[float, int]:
    """Return the time and site at which V'' <= 0 first occurs in a double-double run."""
    from longwave.scenes.engines.lattice_run import domain_plan
    from longwave.scenes.engines.stepped_cells import SteppedCells

    ring = SteppedCells(*domain_plan(scene)).ring
    y, s = doubled(ring.f[0]), doubled(ring.v[0])
    h = scene.discretisation.step
    for step in range(1, round((scene.end - scene.t0) / h) + 1):
        advance_doubled(schemes.KAHAN_LI_8, y, s, h, 1, scene.model)
        soft = scene.model.stiffness(y[:, 0]) <= 0.0
        if soft.any():
            return scene.t0 + step * h, int(ring.cells[soft][0])
    return math.nan, 0


@hard_case(
    "noise at the zone boundary on a dn wave, 0.99 of the step limit, to $t=10^4$",
    "factor by which it grows",
    10.0,
)
def _zone_boundary_noise() -> Reading:
    wave = travelling_wave("wave_dn", 0.5, 27, 1, 1)
    n = np.arange(float(8 * wave.period))
    alternating = np.where(n % 2 == 0, 1.0, -1.0)
    growths = []
    for scheme in (scheme for scheme in schemes.SCHEMES if isinstance(scheme, schemes.Composition)):
        y, s = wave.strain(n) + NOISE * alternating, wave.velocity(n)
        h = 0.99 * schemes.stability_limit(scheme) / wave.constants.highest_frequency(y)
        for _ in range(20):
            advance(scheme, y[None], s[None], h, math.ceil(500.0 / h), wave.constants.lattice)
            growths.append(abs(float(np.mean(alternating * y))) / NOISE)
    return max(growths)


@hard_case(
    "a window fed with a far field that is wrong by 0.1 %",
    "moves of the window until the run stops",
    1.0,
)
def _wrong_feed() -> Reading:
    from longwave.scenes.engines.lattice_run import domain_plan
    from longwave.scenes.engines.window import FedWave

    scene = replace(load_scene("rational_2_eps_0.05"), t0=-400.0, snapshots=(0.0,))
    scene = scene.changed(sites=2048, compared=500)
    ends, settings = [], scene.discretisation
    for factor in (1.0, 1.001):
        _, domains = domain_plan(scene)
        window = Window(FedWave(domains, settings.sites))
        state = window.start()
        amplitude = float(np.max(np.abs(state.f)))
        domains.wave = replace(moving_wave(scene), eps=factor * scene.eps)
        run = Stepper(state, settings.table, scene.model.lattice, window, settings.step, amplitude)
        ends.append((sum(1 for _ in run.stops([0.0])), run.blow_up))
    (sound_moves, sound_end), (moves, end) = ends
    stopped = end is not None and sound_end is None and sound_moves > 1
    return (float(moves + 1) if stopped else math.inf), str(end)


def deviations(wave: TravellingWave, y: Array, s: Array, h: float, times: Array) -> Array:
    """Return sup |strain - wave| / eps at the times (multiples of h) of a run with step ``h``.

    The ring (y, s) is advanced in place.
    """
    n, t, results = np.arange(float(y.size)), 0.0, []
    for later in times:
        advance(
            schemes.KAHAN_LI_8, y[None], s[None], h, round((later - t) / h), wave.constants.lattice
        )
        t = float(later)
        results.append(float(np.max(np.abs(y - wave.strain(n - wave.speed * t)))) / wave.eps)
    return np.array(results)


@hard_case(
    "unstable cn wave, its fastest mode seeded",
    "relative difference of its growth rate and Floquet theory's",
    0.01,
)
def _cn_growth() -> Reading:
    wave, n = travelling_wave(*CN), CN_SITES
    mode = fastest_mode(wave, CN_WAVELENGTHS)
    y, s = (1e-9 * wave.eps * part for part in mode.at(n))
    times = np.linspace(25.0, 5500.0, 220)
    deviation = deviations(wave, wave.strain(n) + y, wave.velocity(n) + s, CN_STEP, times)
    window = (deviation > 1e-8) & (deviation < 1e-5)
    rate = float(np.polyfit(times[window], np.log(deviation[window]), 1)[0])
    return abs(rate / mode.rate.real - 1.0)


@hard_case(
    "unstable cn wave, rounding alone",
    "relative difference of the time at which $10^{-4}eps$ is lost and the predicted horizon",
    0.35,
    slow=True,
)
def _cn_horizon() -> Reading:
    wave, n = travelling_wave(*CN), CN_SITES
    rate = fastest_mode(wave, CN_WAVELENGTHS).rate.real
    predicted = predictability_time(rate, 1e-4, UNIT_ROUNDOFF)
    times = 50.0 * np.arange(1.0, math.ceil(1.6 * predicted / 50.0))
    deviation = deviations(wave, wave.strain(n), wave.velocity(n), CN_STEP, times)
    crossings = np.flatnonzero(deviation > 1e-4)
    crossing_time = float(times[crossings[0]]) if crossings.size else math.inf
    return abs(crossing_time / predicted - 1.0)


@hard_case(
    "stable sn wave with noise, to $t=10^4$", "factor by which it grows, shifts removed", 2.0
)
def _stable_sn() -> Reading:
    return _growth("wave_sn", -1)


@hard_case(
    "stable dn wave with noise, to $t=10^4$", "factor by which it grows, shifts removed", 2.0
)
def _stable_dn() -> Reading:
    return _growth("wave_dn", 1)


def _growth(form: str, K4: int) -> Reading:
    wave = travelling_wave(form, 0.7, 27, 1, K4)
    n = np.arange(float(8 * wave.period))
    noise = 1e-6 * wave.eps * np.random.default_rng(7).standard_normal(n.size)
    y, s = wave.strain(n) + noise - np.mean(noise), wave.velocity(n)
    first, _ = wave.shape_deviation(y, 0.0)
    worst = first
    for t in 100.0 * np.arange(1, 101):
        advance(schemes.KAHAN_LI_8, y[None], s[None], 0.5, 200, wave.constants.lattice)
        worst = max(worst, wave.shape_deviation(y, float(t))[0])
    return worst / first


def energy_errors(
    scheme: schemes.Scheme, h: float, steps: Iterable[int], model: Model, y: Array, s: Array
) -> Array:
    """Return relative energy errors of the ring (y, s), advanced in place, for each step count."""
    initial_energy, errors = model.energy(State(0.0, y[None], s[None])), []
    for count in steps:
        advance(scheme, y[None], s[None], h, int(count), model.lattice)
        errors.append(model.energy(State(0.0, y[None], s[None])) / initial_energy - 1.0)
    return np.array(errors)


def drift(scheme: schemes.Scheme, h: float, steps: int, sites: int = 32) -> float:
    """Return the rms energy error late in a run over the early one: about 1 if it is bounded.

    An error that grows linearly gives about 16.
    """
    y, s = 0.1 * np.random.default_rng(11).standard_normal((2, sites))
    s -= np.mean(s)
    squares = energy_errors(scheme, h, [steps // 1000] * 1000, HARDENING, y, s) ** 2
    return float(np.sqrt(np.mean(squares[-100:]) / np.mean(squares[:100])))


@hard_case(
    "Stoermer-Verlet, $10^6$ steps",
    "energy error of the last tenth over that of the first (16 for a drift)",
    3.0,
)
def _energy_drift_short() -> Reading:
    return drift(schemes.STOERMER_VERLET, 0.2, 1_000_000)


@hard_case(
    "every symplectic scheme, $10^6$ steps",
    "energy error of the last tenth over that of the first (4 for rounding alone, 16 for a drift)",
    6.0,
    slow=True,
)
def _energy_drift() -> Reading:
    steps = {schemes.STOERMER_VERLET: 0.2, schemes.SUZUKI_UMENO_8: 0.4, schemes.KAHAN_LI_8: 0.4}
    return max(drift(scheme, h, 1_000_000) for scheme, h in steps.items())


@hard_case(
    "rounding of the energy, 30000 steps",
    "exponent of its growth in $t$ (1/2 unbiased, 1 biased)",
    0.75,
)
def _rounding_growth() -> Reading:
    """Return the exponent p of the energy's rounding error, t^p: 1/2 if unbiased, 1 if biased.

    The error is the root mean square over 12 runs of an sn wave that differ in phase. The step is
    so small that only rounding is left.
    """
    wave = travelling_wave("wave_sn", 0.5, 27, 1, -1)
    step_counts = np.array([300, 1000, 3000, 10_000, 30_000])
    rows = []
    for phase in np.arange(12) * 0.77:
        x = np.arange(float(2 * wave.period)) + phase
        y, s = wave.strain(x), wave.velocity(x)
        s -= np.mean(s)
        steps = np.diff(step_counts, prepend=0)
        rows.append(energy_errors(schemes.KAHAN_LI_8, 0.1, steps, wave.constants, y, s))
    errors = np.sqrt(np.mean(np.square(rows), axis=0))
    return float(np.polyfit(np.log(step_counts), np.log(errors), 1)[0])


@hard_case("double against double-double, to $t=500$", "largest difference of $y/eps$", 1e-12)
def _rounding_floor() -> Reading:
    wave = travelling_wave("wave_dn", 0.7, 27, 1, 1)
    n = np.arange(float(4 * wave.period))
    y, s = wave.strain(n), wave.velocity(n)
    exact_y, exact_s = doubled(y), doubled(s)
    for _ in range(5):
        advance(schemes.KAHAN_LI_8, y[None], s[None], 0.5, 200, wave.constants.lattice)
        advance_doubled(schemes.KAHAN_LI_8, exact_y, exact_s, 0.5, 200, wave.constants)
    return float(np.max(np.abs((y - exact_y[:, 0]) - exact_y[:, 1]))) / wave.eps


@hard_case(
    "a run forwards, velocities turned, and again",
    "largest difference of $y/eps$ to the start",
    1e-12,
)
def _time_reversal() -> Reading:
    scene = load_scene("rogue_cn_k_0.5")
    measured = run(replace(scene, observables=("state",), snapshots=(0.0,)))
    y, s = measured.state_y.values[0].copy(), measured.state_s.values[0].copy()
    initial_strain = y.copy()
    for _ in range(2):
        advance(schemes.KAHAN_LI_8, y[None], s[None], 0.5, 400, scene.model.lattice)
        s *= -1.0
    return float(np.max(np.abs(y - initial_strain))) / scene.eps


@hard_case("a restart from a snapshot", "values that differ by a bit", 0.0)
def _restart() -> Reading:
    ring = replace(load_scene("soliton_dn_k_0.7"), snapshots=(-33.3, 33.3))
    window = replace(load_scene("rational_2_eps_0.05"), t0=-300.0, snapshots=(-123.4, 0.0))
    differing, compared = 0, 0
    for scene in (ring, window):
        scene = replace(scene, observables=("state", "strain"))
        full = run(scene)
        resumed = resume(full, at=scene.snapshots[0])
        for name in ("state_y", "state_s", "strain"):
            unequal = resumed[name].values[-1] != full[name].values[-1]
            differing += int(np.sum(unequal))
            compared += unequal.size
    return float(differing) if compared else math.inf


def run_hard_case(name: str) -> HardCase:
    """Run the case of that name and return it with its measured number and message."""
    reading = MEASURES[name]()
    measured, message = reading if isinstance(reading, tuple) else (reading, "")
    return replace(HARD_CASES[name], measured=measured, message=message)


def hard_case_jobs(full: bool) -> dict[Key, Job]:
    """Return the jobs of the cases; the slow ones only if ``full``."""
    return {
        ("hard", name): Job(run_hard_case, (name,), 2.0 if case.slow else 1.0)
        for name, case in HARD_CASES.items()
        if full or not case.slow
    }

"""Hard cases: energy, rounding, time reversal and restart."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lattice.model import Model
from lattice.schemes.catalogue import KAHAN_LI_8, STOERMER_VERLET, SUZUKI_UMENO_8
from lattice.schemes.scheme import Scheme
from lattice.state import State, ring_energy
from verify.comparison import load_scene, resume, run
from verify.studies.doubledouble_ring import advance_doubled, doubled
from verify.studies.hard_case import Measurement
from verify.studies.travelling import travelling_wave

Array = NDArray[np.float64]

HARD = Model(1.0, 0.0, 1.0)


def energies(scheme: Scheme, h: float, steps: int, looks: int, sites: int) -> Array:
    """Relative energy errors of a noisy ring at ``looks`` times, ``steps`` steps in all."""
    rng = np.random.default_rng(11)
    y, s = 0.1 * rng.standard_normal((2, sites))
    s -= np.mean(s)
    initial, found = ring_energy(State(0.0, 0, y, s), HARD), []
    for _ in range(looks):
        scheme.advance(y, s, h, steps // looks, HARD)
        found.append(ring_energy(State(0.0, 0, y, s), HARD) / initial - 1.0)
    return np.array(found)


def drift(scheme: Scheme, h: float, steps: int, sites: int = 32) -> float:
    """Root mean square energy error of the last tenth of a run over that of the first.

    About 1 if the error stays bounded, about 16 if it grows linearly.
    """
    squares = energies(scheme, h, steps, 1000, sites) ** 2
    return float(np.sqrt(np.mean(squares[-100:]) / np.mean(squares[:100])))


def energy_drift_short() -> Measurement:
    """Energy of Stoermer-Verlet over 10^6 steps."""
    found = drift(STOERMER_VERLET, 0.2, 1_000_000)
    return Measurement(found, f"stoermer_verlet {found:.3g}")


def energy_drift() -> Measurement:
    """Energy of every symplectic scheme over 10^6 steps."""
    steps = {STOERMER_VERLET: 0.2, SUZUKI_UMENO_8: 0.4, KAHAN_LI_8: 0.4}
    found = {scheme.name: drift(scheme, h, 1_000_000) for scheme, h in steps.items()}
    text = ", ".join(f"{name} {value:.3g}" for name, value in found.items())
    return Measurement(max(found.values()), text)


def rounding_growth() -> Measurement:
    """Exponent p of the energy's rounding error, t^p: 1/2 if unbiased, 1 if biased.

    Root mean square over 12 runs of an sn wave that differ in phase; the step is so small that
    nothing but rounding is left.
    """
    wave = travelling_wave("wave_sn", 0.5, 27, 1, -1)
    marks = np.array([300, 1000, 3000, 10_000, 30_000])
    rows = []
    for phase in np.arange(12) * 0.77:
        x = np.arange(float(2 * wave.period)) + phase
        y, s = wave.strain(x), wave.velocity(x)
        s -= np.mean(s)
        initial, row = ring_energy(State(0.0, 0, y, s), wave.constants), []
        for steps in np.diff(marks, prepend=0):
            KAHAN_LI_8.advance(y, s, 0.1, int(steps), wave.constants)
            row.append(ring_energy(State(0.0, 0, y, s), wave.constants) / initial - 1.0)
        rows.append(row)
    size = np.sqrt(np.mean(np.square(rows), axis=0))
    exponent = float(np.polyfit(np.log(marks), np.log(size), 1)[0])
    return Measurement(exponent, f"{size[-1]:.1g} after {marks[-1]} steps of {KAHAN_LI_8.name}")


def rounding_floor() -> Measurement:
    """sup |y - y*| / eps at t = 500, y* the same scheme and step in double-double arithmetic."""
    wave = travelling_wave("wave_dn", 0.7, 27, 1, 1)
    n = np.arange(float(4 * wave.period))
    y, s = wave.strain(n), wave.velocity(n)
    exact_y, exact_s = doubled(y), doubled(s)
    floors = []
    for _ in range(5):
        KAHAN_LI_8.advance(y, s, 0.5, 200, wave.constants)
        advance_doubled(KAHAN_LI_8, exact_y, exact_s, 0.5, 200, wave.constants)
        floors.append(float(np.max(np.abs((y - exact_y[:, 0]) - exact_y[:, 1]))) / wave.eps)
    text = ", ".join(f"{floor:.1e}" for floor in floors)
    return Measurement(floors[-1], f"at t = 100, 200, .. 500: {text}")


def time_reversal() -> Measurement:
    """sup |y(back) - y| / eps after t = 200 forwards, velocities turned, and t = 200 again."""
    scene = load_scene("rogue_cn_k_0.5")
    measured = run(replace(scene, observables=("state",), snapshots=(0.0,)))
    y, s = measured.state_y.values[0].copy(), measured.state_s.values[0].copy()
    before = y.copy()
    for _ in range(2):
        KAHAN_LI_8.advance(y, s, 0.5, 400, scene.constants)
        s *= -1.0
    return Measurement(float(np.max(np.abs(y - before))) / scene.eps, "kahan_li_8, 800 steps")


def restart() -> Measurement:
    """Values that differ between a run and one resumed half-way, in a ring and in a window."""
    ring = replace(load_scene("soliton_dn_k_0.7"), snapshots=(-33.3, 33.3))
    window = replace(load_scene("rational_2_eps_0.05"), t0=-300.0, snapshots=(-123.4, 0.0))
    differing, compared = 0, 0
    for scene in (ring, window):
        scene = replace(scene, observables=("state", "strain"))
        whole = run(scene)
        resumed = resume(whole, at=scene.snapshots[0])
        for name in ("state_y", "state_s", "strain"):
            unequal = resumed[name].values[-1] != whole[name].values[-1]
            differing += int(np.sum(unequal))
            compared += unequal.size
    return Measurement(float(differing) if compared else math.inf, f"of {compared} values")

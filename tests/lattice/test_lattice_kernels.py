"""Catches: a wrong neighbour, block edge, seam or term in the kernels; absent terms computed."""

import itertools
import re

import numpy as np
import pytest
import sympy as sp
from numba import float64, njit, none
from scipy.integrate import solve_ivp

from longwave import derive
from longwave.derive import symbols
from longwave.lattice.kernels import nystroem
from longwave.lattice.model import Array, Model
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.lattice.schemes import (
    BLANES_MOAN_6,
    KAHAN_LI_8,
    RK4,
    SCHEMES,
    STOERMER_VERLET,
    Scheme,
)
from longwave.lattice.state import State
from longwave.lattice.stepper import advance
from longwave.solutions import Wave, closed_form

SIZES = (3, 4, 31, 32, 33, 1023, 1024, 2050)
PRESENT = list(itertools.product((0.0, 0.7), (0.0, -0.4)))


def laplacian(values: Array) -> Array:
    return np.roll(values, -1) - 2.0 * values + np.roll(values, 1)


def force(y: Array, constants: Model) -> Array:
    return constants.K2 * y + constants.K3 * y**2 + constants.K4 * y**3


def smooth_ring(size: int, rng: np.random.Generator) -> tuple[Array, Array]:
    return 0.3 * rng.standard_normal(size), 0.2 * rng.standard_normal(size)


@pytest.mark.parametrize(("K3", "K4"), PRESENT)
@pytest.mark.parametrize("size", SIZES)
def test_composition_equals_plain_numpy(
    size: int, K3: float, K4: float, rng: np.random.Generator
) -> None:
    constants, h = Model(1.3, K3, K4), 0.1
    y, s = smooth_ring(size, rng)
    plain_y, plain_s = y.copy(), s.copy()
    for _ in range(3):
        plain_y += 0.5 * h * plain_s
        plain_s += h * laplacian(force(plain_y, constants))
        plain_y += 0.5 * h * plain_s
    advance(STOERMER_VERLET, y[None], s[None], h, 3, constants.lattice)
    np.testing.assert_allclose(y, plain_y, rtol=0, atol=1e-14)
    np.testing.assert_allclose(s, plain_s, rtol=0, atol=1e-14)


@pytest.mark.parametrize(("K3", "K4"), PRESENT)
def test_rk4_equals_the_textbook_form(K3: float, K4: float, rng: np.random.Generator) -> None:
    """The kernel runs the Nystroem form of the table; the textbook form has four (y, s) stages."""
    constants, h = Model(1.3, K3, K4), 0.2
    y, s = smooth_ring(17, rng)

    def rate(state: Array) -> Array:
        return np.array([state[1], laplacian(force(state[0], constants))])

    state = np.array([y, s])
    for _ in range(2):
        k1 = rate(state)
        k2 = rate(state + 0.5 * h * k1)
        k3 = rate(state + 0.5 * h * k2)
        k4 = rate(state + h * k3)
        state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    advance(RK4, y[None], s[None], h, 2, constants.lattice)
    np.testing.assert_allclose(np.array([y, s]), state, rtol=0, atol=1e-14)


@pytest.mark.parametrize(("K3", "K4"), PRESENT)
def test_force_and_stiffness_are_those_of_the_derivation(K3: float, K4: float) -> None:
    """The chain is declared twice; it must be the one that the expansion starts from."""
    y = sp.Symbol("y")
    lattice = derive.LATTICES["fput_strain"]
    numbers = {symbols.K2: sp.Rational(13, 10), symbols.K3: K3, symbols.K4: K4}
    polynomial = lattice.bonds[0].force.subs(numbers).subs(symbols.x, y)
    constants = Model(1.3, K3, K4)
    assert constants.lattice == numeric_lattice(lattice, {"K2": 1.3, "K3": K3, "K4": K4 or 0.0})
    for value in (-0.9, 0.0, 0.35):
        exact = float(polynomial.subs(y, value))
        assert nystroem.force(value, 1.3, K3 or None, K4 or None) == pytest.approx(exact, abs=1e-15)
        slope = float(sp.diff(polynomial, y).subs(y, value))
        assert constants.stiffness(np.array(value)) == pytest.approx(slope, abs=1e-15)


@pytest.mark.parametrize(
    ("K3", "K4", "multiplications"),
    [(none, none, 1), (float64, none, 2), (none, float64, 3), (float64, float64, 3)],
    ids=["K2", "K2 K3", "K2 K4", "K2 K3 K4"],
)
def test_absent_terms_are_absent_from_the_machine_code(
    K3: object, K4: object, multiplications: int
) -> None:
    signature = (float64, float64, K3, K4)
    fresh = njit(signature, error_model="numpy")(nystroem.force.py_func)
    code = fresh.overloads[signature].library.get_llvm_str()
    body = code[code.index("define") : code.index("\n}", code.index("define"))]
    assert len(re.findall(r"= fmul", body)) == multiplications


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
def test_no_steps_change_nothing(scheme: Scheme, rng: np.random.Generator) -> None:
    y, s = smooth_ring(9, rng)
    before = y.copy(), s.copy()
    advance(scheme, y[None], s[None], 0.1, 0, Model(1, 0, 1).lattice)
    assert np.array_equal(y, before[0])
    assert np.array_equal(s, before[1])


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
def test_total_velocity_is_conserved(scheme: Scheme, rng: np.random.Generator) -> None:
    """The discrete Laplacian sums to zero on a ring, so a leak at the seam would show."""
    y, s = smooth_ring(50, rng)
    total = s.sum()
    advance(scheme, y[None], s[None], 0.1, 50, Model(1, 0.3, 1).lattice)
    assert s.sum() == pytest.approx(total, abs=1e-12)


def test_engine_agrees_with_dop853() -> None:
    """Y2 about its crest at eps = 0.05, to 1e-8 eps; DOP853 is an independent integrator."""
    eps, size, duration = 0.05, 512, 40.0
    wave = Wave(closed_form("rational_2"), derive.mkdv_normal_form(4, 1))
    value = wave.at(np.arange(size) - size // 2, 0.0, eps)
    y, s = eps * value.Y, eps**4 * value.Y_T - 2.0 * eps**2 * value.Y_X

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        strain, velocity = np.split(state, 2)
        return np.concatenate([velocity, laplacian(force(strain, Model(4.0, 0.0, 1.0)))])

    start = np.concatenate([y, s])
    solved = solve_ivp(rate, (0.0, duration), start, "DOP853", rtol=1e-13, atol=1e-15)
    advance(BLANES_MOAN_6, y[None], s[None], duration / 200, 200, Model(4.0, 0.0, 1.0).lattice)
    assert np.abs(y - solved.y[:size, -1]).max() < 1e-8 * eps


def test_symmetric_schemes_run_backwards(rng: np.random.Generator) -> None:
    y, s = smooth_ring(40, rng)
    before = y.copy(), s.copy()
    advance(KAHAN_LI_8, y[None], s[None], 0.3, 40, Model(1, 0, 1).lattice)
    assert np.max(np.abs(y - before[0])) > 0.1
    advance(KAHAN_LI_8, y[None], s[None], -0.3, 40, Model(1, 0, 1).lattice)
    np.testing.assert_allclose(y, before[0], rtol=0, atol=1e-11)
    np.testing.assert_allclose(s, before[1], rtol=0, atol=1e-11)


def test_energy_is_conserved_without_drift_and_only_by_symplectic_schemes(
    rng: np.random.Generator,
) -> None:
    constants = Model(1, 0.3, 1)
    drift = {}
    for scheme in SCHEMES:
        y, s = smooth_ring(64, rng)
        s -= s.mean()
        before = constants.energy(State(0.0, y[None], s[None]))
        advance(scheme, y[None], s[None], 0.25, 8000, constants.lattice)
        drift[scheme.name] = abs(constants.energy(State(0.0, y[None], s[None])) / before - 1.0)
    assert drift["kahan_li_8"] < 1e-7
    assert drift["suzuki_umeno_8"] < 1e-6
    assert drift["blanes_moan_6"] < 1e-6
    assert drift["reduced_phase_6"] < 1e-6
    assert drift["mclachlan_4"] < 1e-3
    assert drift["stoermer_verlet"] < 2e-2
    assert drift["rk4"] > 2e-2

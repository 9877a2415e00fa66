"""Catches: a scheme whose tables are right but whose use in the kernel is not, and vice versa.

Two problems, neither linear: a rough FPUT ring run by the kernels against DOP853, and the Toda
chain's exact soliton run from the tables alone.
"""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from longwave.lattice.model import Array, Model
from longwave.lattice.schemes import SCHEMES, RungeKutta, Scheme
from longwave.lattice.stepper import advance

CONSTANTS = Model(1.0, 0.4, 0.9)
DURATION = 12.0
STEPS = {
    "stoermer_verlet": (120, 240, 480),
    "rk4": (200, 400, 800),
    "mclachlan_4": (60, 90, 140),
    "blanes_moan_6": (36, 48, 64),
    "reduced_phase_6": (30, 40, 54),
    "suzuki_umeno_8": (40, 60, 90),
    "kahan_li_8": (30, 45, 70),
}


def laplacian(values: Array) -> Array:
    return np.roll(values, -1) - 2.0 * values + np.roll(values, 1)


def slopes(errors: list[float], steps: tuple[int, ...]) -> Array:
    return -np.diff(np.log(errors)) / np.diff(np.log(np.array(steps, dtype=float)))


@pytest.fixture(scope="module")
def fput() -> tuple[Array, Array, Array]:
    """Return initial strains and velocities of a ring of 24 sites, and its strains at the end."""
    n = 2.0 * np.pi * np.arange(24) / 24
    y, s = 0.4 * np.sin(n) + 0.2 * np.cos(2 * n + 1), 0.3 * np.cos(3 * n)
    K2, K3, K4 = CONSTANTS.K2, CONSTANTS.K3, CONSTANTS.K4

    def rate(_: float, state: Array) -> Array:
        strain, velocity = np.split(state, 2)
        return np.concatenate([velocity, laplacian(strain * (K2 + strain * (K3 + K4 * strain)))])

    solved = solve_ivp(
        rate, (0.0, DURATION), np.concatenate([y, s]), "DOP853", rtol=2.3e-14, atol=1e-15
    )
    return y, s, solved.y[:24, -1]


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
def test_order_on_fput_against_dop853(scheme: Scheme, fput: tuple[Array, Array, Array]) -> None:
    errors = []
    for steps in STEPS[scheme.name]:
        y, s = fput[0].copy(), fput[1].copy()
        advance(scheme, y[None], s[None], DURATION / steps, steps, CONSTANTS.lattice)
        errors.append(float(np.max(np.abs(y - fput[2]))))
    assert 1e-11 < errors[-1] < errors[0] < 1e-2
    assert slopes(errors, STEPS[scheme.name]) == pytest.approx(scheme.order, abs=0.2)


def toda_soliton(n: Array, t: float) -> tuple[Array, Array]:
    """Return strain and velocity of the Toda chain's soliton, y'' = D[exp(y) - 1], kappa = 1."""
    phase = n - np.sinh(1.0) * t
    height = np.sinh(1.0) ** 2 / np.cosh(phase) ** 2
    return np.log1p(height), 2.0 * np.sinh(1.0) * np.tanh(phase) * height / (1.0 + height)


def from_table(
    scheme: Scheme,
    g: Callable[[Array], Array],
    y: Array,
    s: Array,
    h: float,
    steps: int,
) -> Array:
    for _ in range(steps):
        if not isinstance(scheme, RungeKutta):
            for drift, kick in zip(scheme.drifts, scheme.kicks, strict=False):
                y = y + drift * h * s
                s = s + kick * h * g(y)
            y = y + scheme.drifts[-1] * h * s
        else:
            nodes, inner, outer, weights = (
                np.array(part, dtype=object).astype(float) for part in scheme.table()
            )
            rates: list[Array] = []
            for node, row in zip(nodes, inner, strict=True):
                known = sum((a * r for a, r in zip(row, rates, strict=False)), np.zeros_like(y))
                rates.append(g(y + node * h * s + h * h * known))
            y = y + h * s + h * h * np.tensordot(outer, np.array(rates), 1)
            s = s + h * np.tensordot(weights, np.array(rates), 1)
    return y


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
def test_order_on_the_toda_soliton(scheme: Scheme) -> None:
    n = np.arange(-60.0, 61.0)
    duration, errors = 6.0, []
    counts = tuple(int(steps * 0.9) for steps in STEPS[scheme.name])
    for steps in counts:
        y, s = toda_soliton(n, -duration / 2)
        g = lambda strain: laplacian(np.expm1(strain))  # noqa: E731
        end = from_table(scheme, g, y, s, duration / steps, steps)
        errors.append(float(np.max(np.abs(end - toda_soliton(n, duration / 2)[0]))))
    assert 1e-12 < errors[-1] < errors[0] < 1e-2
    assert slopes(errors, counts) == pytest.approx(scheme.order, abs=0.3)

"""phi functions against mpmath, and the integrator against exact solutions."""

import mpmath
import numpy as np
import pytest

from verify.exponential.adams import ExponentialAdams
from verify.exponential.phi import moment_weights, phi_functions


@pytest.mark.parametrize("z", [0j, 1e-9j, 1.9j, 2.0j, 2.1j, 13j, -1 + 1j, -30 + 0j])
def test_phi_against_mpmath(z: complex) -> None:
    context = mpmath.mp.clone()
    context.dps = 30
    for m, value in enumerate(phi_functions(np.array([z]), 5)):
        exact = complex(context.hyp1f1(1, m + 1, context.mpc(z)) / context.factorial(m))
        assert abs(value[0] - exact) < 1e-14 * abs(exact)


def test_weights_are_exact_for_polynomials() -> None:
    nodes = np.array([1.0, 0.0, -0.5, -2.0])
    weights = moment_weights(np.array([0.0 + 0j]), nodes)[:, 0]
    for degree in range(4):
        assert abs(weights @ nodes**degree - 1 / (degree + 1)) < 1e-13


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_tolerance_is_met(tolerance: float) -> None:
    """p' = i w p + |p|^2 p i has the solution p0 exp(i (w + |p0|^2) t)."""
    w = np.array([[0.0, 1.0, 30.0]])
    p0 = np.array([[0.5, 0.7 + 0.2j, 0.3j]])

    def norm(change: np.ndarray) -> float:
        return float(np.abs(change).max())

    solution = ExponentialAdams(1j * w, lambda p: 1j * np.abs(p[0]) ** 2 * p[0], p0, norm, 0.1)
    solution.advance(10.0, tolerance / 10.0)
    exact = p0 * np.exp(1j * (w + np.abs(p0) ** 2) * 10.0)
    assert np.abs(solution.p - exact).max() < 3 * tolerance

"""The exponential Adams method against an exact solution, and its order of convergence."""

import math

import numpy as np
import pytest

from longwave.lattice.spectral.exponential import ORDER, ExponentialAdams, ExponentialRungeKutta

W = np.array([[0.0, 1.0, 30.0]])
START = np.array([[0.5, 0.7 + 0.2j, 0.3j]])
END = 10.0
EXACT = START * np.exp(1j * (W + np.abs(START) ** 2) * END)
"""p' = i w p + i |p|^2 p has the solution p0 exp(i (w + |p0|^2) t)."""


def _turn(p: np.ndarray) -> np.ndarray:
    return np.asarray(1j * np.abs(p[0]) ** 2 * p[0])


def _solve(h: float) -> np.ndarray:
    solution = ExponentialAdams(1j * W, _turn, START, h)
    for _ in range(solution.whole_steps(END)):
        solution.step()
    return solution.solution_at(END)


def _real(h: float) -> np.ndarray:
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(_solve(h).view(np.float64))


@pytest.mark.parametrize("mode", [0, 1])
def test_order(mode: int) -> None:
    errors = [abs(_solve(h)[0, mode] - EXACT[0, mode]) for h in (0.025, 0.0125)]
    assert abs(math.log2(errors[0] / errors[1]) - ORDER) < 0.2


def test_order_of_etdrk4() -> None:
    errors = []
    for h in (0.1, 0.05):
        method, p = ExponentialRungeKutta(1j * W, _turn, h), START
        for _ in range(round(END / h)):
            p = method.step(p)
        errors.append(abs(p[0, 1] - EXACT[0, 1]))
    assert abs(math.log2(errors[0] / errors[1]) - 4) < 0.2


def test_a_part_of_a_step_is_as_exact_as_whole_ones() -> None:
    """The step 0.007 does not divide 10."""
    assert np.abs(_solve(0.007) - EXACT).max() < np.abs(_solve(0.008) - EXACT).max()

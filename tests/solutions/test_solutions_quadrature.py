"""Integrals from 0: exact between the panels' ends too, and what is too far away is refused."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from longwave.solutions.quadrature import IntegralFromZero

Array = NDArray[np.float64]


@pytest.mark.parametrize("width", [1e-9, 1e-18, 1e-300])
def test_points_that_are_too_many_panels_apart_are_refused(width: float) -> None:
    with pytest.raises(ValueError, match=r"^points must span at most"):
        IntegralFromZero(np.cos, -7.0, 15.0, width)


def sharp(x: Array) -> Array:
    """Return a pulse of width 1e-2, for which panels of width 1 are halved many times."""
    return np.asarray(1e-2 / (1e-4 + (x - 0.3) ** 2))


@pytest.mark.parametrize(
    ("function", "integral", "low", "high"),
    [
        (np.cos, np.sin, -7.3, 15.1),
        (np.cos, np.sin, 3.0, 4.0),
        (np.cos, np.sin, -4.0, -3.0),
        (np.cos, np.sin, 0.0, 0.0),
        (lambda x: np.cosh(x) ** -2, np.tanh, -300.0, 300.0),
        (sharp, lambda x: np.arctan(1e2 * (x - 0.3)) + np.arctan(30.0), -2.0, 2.0),
        (lambda x: np.exp(1j * x), lambda x: -1j * (np.exp(1j * x) - 1.0), -9.0, 9.0),
    ],
)
def test_integrals_at_many_points_within_a_panel(
    function: Callable[[Array], Array],
    integral: Callable[[Array], Array],
    low: float,
    high: float,
) -> None:
    """Catches: a panel confirmed at its ends alone, whose polynomial is wrong between them."""
    points = np.random.default_rng(5).uniform(low, high, (3, 50_000))
    found = IntegralFromZero(function, low, high, 1.0)(points)
    assert np.max(np.abs(found - integral(points))) <= 2e-13 * max(1.0, high - low) ** 0.5


def test_a_function_that_is_not_smooth_is_refused() -> None:
    with pytest.raises(ValueError, match="not smooth there"):
        IntegralFromZero(lambda x: np.sign(x - 0.3), 0.0, 1.0, 1.0)


@pytest.mark.parametrize("level", [0.0, 0.3])
def test_where_the_function_is_a_constant_panels_are_few(level: float) -> None:
    """Catches: a wide panel over one that changes, or over 0, from which integrals count."""

    def pulses(x: Array) -> Array:
        return np.asarray(level + np.cosh(np.minimum(np.abs(x - 30_000.0), 300.0)) ** -2)

    counts: list[int] = []

    def counted(x: Array) -> Array:
        counts.append(x.size)
        return pulses(x)

    points = np.linspace(-1e5, 1e5, 100_001)
    found = IntegralFromZero(counted, -1e5, 1e5, 1.0)(points)
    exact = level * points + np.tanh(points - 30_000.0) + 1.0
    assert np.max(np.abs(found - exact)) <= 1e-13 * max(1.0, level * 1e5)
    assert sum(counts) < 220_000

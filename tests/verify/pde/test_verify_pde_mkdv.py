"""The integrated mKdV equation against travelling waves; bad input."""

import math

import numpy as np
import pytest

from solutions.special.double import jacobi
from verify.pde import PeriodicMkdv, evolve

K = 1.8456939983747236  # K(m = 0.49), the period of dn is 2 K


def _dn(xi: np.ndarray) -> np.ndarray:
    return np.asarray(jacobi(xi, 0.49, 0.51)[2])


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_dn_wave_travels(tolerance: float) -> None:
    """dn(xi - (2 - m) tau) solves the focusing equation."""
    xi = 2 * K / 64 * np.arange(64)
    rows = evolve(_dn(xi), 2 * K, 1, (0.5, 2.0), tolerance)
    for row, tau in zip(rows, (0.5, 2.0), strict=True):
        assert np.abs(row - _dn(xi - 1.51 * tau)).max() < 2 * tolerance


def test_invariants_of_the_defocusing_equation() -> None:
    xi = 2 * math.pi / 128 * np.arange(128)
    solution = PeriodicMkdv(0.5 * np.sin(xi) + 0.2, 2 * math.pi, -1)
    before = solution.invariants
    solution.advance(1.0, 1e-7)
    np.testing.assert_allclose(solution.invariants, before, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"s": 0}, "s must be 1 or -1"),
        ({"period": -1.0}, "period must"),
        ({"U": [np.nan]}, "U must"),
    ],
)
def test_bad_input(change: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"U": np.ones(8), "period": 1.0, "s": 1}
    with pytest.raises(ValueError, match=message):
        PeriodicMkdv(**(good | change))  # type: ignore[arg-type]

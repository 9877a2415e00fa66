"""sn, cn, dn, epsilon, zeta and Theta in double-double against 50 digits."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mpmath import MPContext

from solutions.special import double
from solutions.special.extended import evaluate_pairs
from solutions.special.mp import theta
from solutions.special.parameter import parameter_of_modulus

ctx = MPContext()
ctx.dps = 50
Reference = Callable[[float, float, float], tuple[Any, ...]]


@pytest.mark.parametrize("k", [0.0, 1e-8, 0.3, 0.7071, 0.70711, 0.9, 1 - 1e-8, 1 - 2**-53, 1.0])
def test_thirty_digits(k: float, reference: Reference, rng: np.random.Generator) -> None:
    p = parameter_of_modulus(k)
    K = p.K[0] if k < 1 else 20.0
    u = K * np.concatenate([np.arange(-8, 69, 4) / 16, rng.uniform(-4, 4, 8)])
    u_lo = u * 1e-17
    values = evaluate_pairs(p, u, u_lo)[:5]
    for i in range(u.size):
        for pair, exact in zip(values, reference(k, float(u[i]), float(u_lo[i])), strict=True):
            error = abs(ctx.mpf(pair[0, i]) + pair[1, i] - exact)
            assert error < 1e-31 * max(1, abs(exact)) + 5e-33 * abs(u[i])


def test_high_parts_are_the_double_values(rng: np.random.Generator) -> None:
    p = parameter_of_modulus(0.8)
    u = rng.uniform(-1e6, 1e6, (4, 25))
    for pair, single in zip(evaluate_pairs(p, u)[:5], double.evaluate(p, u), strict=True):
        assert pair.shape == (2, 4, 25)
        assert np.allclose(pair[0], single, rtol=1e-15, atol=6e-16)


@pytest.mark.parametrize("k", [1e-8, 0.3, 0.70711, 0.9, 1 - 1e-8])
def test_theta_has_thirty_digits(k: float, rng: np.random.Generator) -> None:
    p = parameter_of_modulus(k)
    u = p.K[0] * np.concatenate([np.arange(-8, 9) / 4, rng.uniform(-40, 40, 8)])
    theta_pair = evaluate_pairs(p, u, theta=True).theta
    assert theta_pair is not None
    high, low = theta_pair
    for i in range(u.size):
        exact = theta(ctx, ctx.mpf(u[i]), ctx.mpf(k) ** 2)
        assert abs(ctx.mpf(high[i]) + low[i] - exact) < 1e-30 * abs(exact) + 1e-32 * abs(u[i])


def test_theta_has_no_value_at_one() -> None:
    with pytest.raises(ValueError, match="m1 must satisfy m1 > 0"):
        evaluate_pairs(parameter_of_modulus(1.0), 0.5, theta=True)

"""sn, cn, dn, epsilon, zeta and Theta in double-double against 50 digits."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from mpmath import MPContext

from solutions.functions.multiprecision import cn, dn, epsilon, sn, theta, zeta
from solutions.run.elliptic_parameter import parameter_of_modulus
from solutions.run.jacobi_pairs import evaluate_pairs

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


@pytest.mark.parametrize("k", [1e-8, 0.3, 0.70711, 0.9, 1 - 1e-8, 1 - 2**-53])
@pytest.mark.parametrize("e", [0.0, 1e-20, 1e-6])
def test_bounds_cover_every_argument_within_e(
    k: float, e: float, reference: Reference, rng: np.random.Generator
) -> None:
    p = parameter_of_modulus(k)
    u = p.K[0] * np.concatenate([np.arange(-8, 9) / 4, rng.uniform(-40, 40, 8)])
    for i in range(u.size):
        values = evaluate_pairs(p, u[i], bound=e)[:5]
        for end in (-e, e):
            exact = reference(k, float(u[i]), end)
            for (high, low, bound), wanted in zip(values, exact, strict=True):
                assert abs(ctx.mpf(float(high)) + float(low) - wanted) <= bound + 1e-45
                assert bound < 2 * e + 3e-29 * max(1, abs(u[i]))


@pytest.mark.parametrize("k", [1e-8, 0.3, 0.9, 1 - 1e-12])
@pytest.mark.parametrize("size", [1e16, 1e17, 3e18, 1e22, 1e25])
def test_arguments_of_three_floats_keep_their_place_in_the_period(
    k: float, size: float, rng: np.random.Generator
) -> None:
    """From 1e17 on the quotient by K is no double: one step of reduction gave any value at all."""
    p = parameter_of_modulus(k)
    for u in size * rng.uniform(-2, 2, 4):
        u_lo, rest = float(np.spacing(u)) / 3, float(np.spacing(np.spacing(u))) / 7
        values = evaluate_pairs(p, u, u_lo, rest)
        with ctx.workdps(80):
            exact = ctx.mpf(u) + u_lo + rest
            m = ctx.mpf(k) ** 2
            wanted = [f(ctx, exact, m) for f in (sn, cn, dn, epsilon, zeta)]
            for (high, low, bound), right in zip(values[:5], wanted, strict=True):
                found = ctx.mpf(float(high)) + float(low)
                assert abs(found - right) <= bound < 1e-18 * max(1, abs(right))


def test_arguments_beyond_the_reduction_are_said_to_be_unknown() -> None:
    for u in (1e31, 1e200):
        assert not np.isfinite(evaluate_pairs(parameter_of_modulus(0.5), u).sn[2])


@pytest.mark.parametrize("k", [1e-8, 0.3, 0.70711, 0.9, 1 - 1e-8])
def test_theta_has_thirty_digits(k: float, rng: np.random.Generator) -> None:
    p = parameter_of_modulus(k)
    u = p.K[0] * np.concatenate([np.arange(-8, 9) / 4, rng.uniform(-40, 40, 8)])
    theta_pair = evaluate_pairs(p, u, theta=True).theta
    assert theta_pair is not None
    high, low, bounds = theta_pair
    for i in range(u.size):
        exact = theta(ctx, ctx.mpf(u[i]), ctx.mpf(k) ** 2)
        error = abs(ctx.mpf(high[i]) + low[i] - exact)
        assert error < 1e-30 * abs(exact) + 1e-32 * abs(u[i])
        assert error <= bounds[i] < 1e-28 * (abs(exact) + abs(u[i]))


def test_theta_has_no_value_at_one() -> None:
    with pytest.raises(ValueError, match="m1 must satisfy m1 > 0"):
        evaluate_pairs(parameter_of_modulus(1.0), 0.5, theta=True)

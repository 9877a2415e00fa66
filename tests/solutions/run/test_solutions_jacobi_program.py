"""sn, cn, dn, zeta and Theta in double-double against 50 digits, and as doubles on a grid."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import MPContext

from longwave.solutions.functions import multiprecision as mp
from longwave.solutions.functions import numpy_values as numpy_functions
from longwave.solutions.run.doubledouble import Array
from longwave.solutions.run.program import JacobiProgram, jacobi_program

ctx = MPContext()
ctx.dps = 50
Reference = Callable[[float, float, float], tuple[Any, ...]]

MODULI = (0.0, 1e-8, 0.3, 0.7071, 0.70711, 0.9, 1 - 1e-4, 1 - 1e-8, 1 - 1e-12, 1 - 2**-53, 1.0)


def program(k: float) -> JacobiProgram:
    """Return the program of all functions for the modulus k, with Theta where it exists."""
    exact = MPContext()
    exact.prec = 2200
    modulus = exact.mpf(k)
    expected = (True, True, True, True, k < 1)
    return jacobi_program(modulus**2, (1 - modulus) * (1 + modulus), expected)


def evaluate(k: float, u: Any, u_lo: Any = 0.0, rest: Any = 0.0, bound: Any = 0.0) -> Array:
    """Return sn, cn, dn, zeta, Theta with low parts and bounds, of shape (5, 3, points)."""
    return program(k)(np.stack(np.broadcast_arrays(np.atleast_1d(u), u_lo, rest, bound)))


def quarter_period(k: float) -> float:
    return program(k).quarter[0] if k < 1 else 20.0


def worst(values: Array, u: Any, u_lo: Any, k: float, reference: Reference) -> Array:
    """Return the largest error of each row, relative to max(1, |value|)."""
    errors = np.zeros(4)
    for i in range(len(u)):
        exact = reference(k, float(u[i]), float(u_lo[i]))
        for row, e in enumerate(exact):
            errors[row] = max(errors[row], float(abs(values[row][i] - e) / max(1, abs(e))))
    return errors


@pytest.mark.parametrize("k", [0.0, 1e-8, 0.3, 0.7071, 0.70711, 0.9, 1 - 1e-8, 1 - 2**-53, 1.0])
def test_thirty_digits(k: float, reference: Reference, rng: np.random.Generator) -> None:
    u = quarter_period(k) * np.concatenate([np.arange(-8, 69, 4) / 16, rng.uniform(-4, 4, 8)])
    u_lo = u * 1e-17
    values = evaluate(k, u, u_lo)[:4]
    for i in range(u.size):
        for pair, exact in zip(values, reference(k, float(u[i]), float(u_lo[i])), strict=True):
            error = abs(ctx.mpf(pair[0, i]) + pair[1, i] - exact)
            assert error < 1e-31 * max(1, abs(exact)) + 5e-33 * abs(u[i])


@pytest.mark.parametrize("k", [1e-8, 0.3, 0.70711, 0.9, 1 - 1e-8, 1 - 2**-53])
@pytest.mark.parametrize("e", [0.0, 1e-20, 1e-6])
def test_bounds_cover_every_argument_within_e(
    k: float, e: float, reference: Reference, rng: np.random.Generator
) -> None:
    u = quarter_period(k) * np.concatenate([np.arange(-8, 9) / 4, rng.uniform(-40, 40, 8)])
    for i in range(u.size):
        values = evaluate(k, u[i], bound=e)[:4, :, 0]
        for end in (-e, e):
            exact = reference(k, float(u[i]), end)
            for (high, low, bound), expected in zip(values, exact, strict=True):
                assert abs(ctx.mpf(float(high)) + float(low) - expected) <= bound + 1e-45
                assert bound < 3.1 * e + 3e-29 * max(1, abs(u[i]))


@pytest.mark.parametrize("k", [1e-8, 0.3, 0.9, 1 - 1e-12])
@pytest.mark.parametrize("size", [1e16, 1e17, 3e18, 1e22, 1e25])
def test_arguments_of_three_floats_are_accurate_within_the_period(
    k: float, size: float, rng: np.random.Generator
) -> None:
    """From 1e17 on the quotient by K is no double: one step of reduction gave any value at all."""
    for u in size * rng.uniform(-2, 2, 4):
        u_lo, rest = float(np.spacing(u)) / 3, float(np.spacing(np.spacing(u))) / 7
        values = evaluate(k, u, u_lo, rest)[:4, :, 0]
        with ctx.workdps(80):
            exact = ctx.mpf(u) + u_lo + rest
            m = ctx.mpf(k) ** 2
            expected = [f(ctx, exact, m) for f in (mp.sn, mp.cn, mp.dn, mp.zeta)]
            for (high, low, bound), right in zip(values, expected, strict=True):
                found = ctx.mpf(float(high)) + float(low)
                assert abs(found - right) <= bound < 1e-18 * max(1, abs(right))


def test_values_beyond_the_reduction_are_reported_as_unknown() -> None:
    for u in (1e31, 1e200):
        assert not np.isfinite(evaluate(0.5, u)[0, 2, 0])


@pytest.mark.parametrize("k", [1e-8, 0.3, 0.70711, 0.9, 1 - 1e-8])
def test_theta_has_thirty_digits(k: float, rng: np.random.Generator) -> None:
    u = quarter_period(k) * np.concatenate([np.arange(-8, 9) / 4, rng.uniform(-40, 40, 8)])
    high, low, bounds = evaluate(k, u)[4]
    for i in range(u.size):
        exact = mp.theta(ctx, ctx.mpf(u[i]), ctx.mpf(k) ** 2)
        error = abs(ctx.mpf(high[i]) + low[i] - exact)
        assert error < 1e-30 * abs(exact) + 1e-32 * abs(u[i])
        assert error <= bounds[i] < 1e-28 * (abs(exact) + abs(u[i]))


def test_theta_has_no_value_at_one() -> None:
    with pytest.raises(ValueError, match="m must satisfy m < 1, got 1"):
        jacobi_program(ctx.one, ctx.zero)


@pytest.mark.parametrize("k", [0.3, 0.95])
def test_functions_not_requested_take_no_instructions(k: float) -> None:
    modulus = ctx.mpf(k)
    pair = modulus**2, (1 - modulus) * (1 + modulus)
    alone = jacobi_program(*pair, (False, True, False, False, False))
    assert len(alone.bytecode.code) < 0.8 * len(program(k).bytecode.code)
    phase = np.array([[0.7], [0.0], [0.0], [0.0]])
    assert alone(phase)[1].tolist() == program(k)(phase)[1].tolist()
    assert not np.any(alone(phase)[0, :2])


@pytest.mark.parametrize("k", MODULI)
def test_dense_grid_with_every_sixteenth_of_K(k: float, reference: Reference) -> None:
    """SciPy's ellipeinc is wrong by 0.1 .. 0.4 at some u = j K / 16."""
    u = quarter_period(k) * np.concatenate([np.arange(-5, 69) / 16, [np.sqrt(2), -np.pi, 1e-12]])
    values = evaluate(k, u)[:, 0]
    assert np.all(worst(values, u, 0 * u, k, reference) < 6e-16)


@pytest.mark.parametrize("k", MODULI[:-1])
def test_a_million_periods_cost_no_digits(
    k: float, reference: Reference, rng: np.random.Generator
) -> None:
    """u and its low part are reduced as one number; a K in double alone would lose 10 digits."""
    u = rng.uniform(-4e6, 4e6, 12) * quarter_period(k)
    u_lo = u * rng.uniform(-1e-16, 1e-16, 12)
    assert np.all(worst(evaluate(k, u, u_lo)[:, 0], u, u_lo, k, reference) < 1e-15)


@pytest.mark.parametrize("k", MODULI)
def test_cn_and_dn_keep_relative_accuracy(k: float, reference: Reference) -> None:
    """Near u = K and k = 1, cn and dn are as small as k'; they must not drown in round-off."""
    u = quarter_period(k) * np.linspace(0.4, 1.9, 30)
    _, cn, dn, *_ = evaluate(k, u)[:, 0]
    for i in range(u.size):
        _, exact_cn, exact_dn, *_ = reference(k, float(u[i]), 0.0)
        assert abs(cn[i] - exact_cn) < 8e-16 * abs(exact_cn)
        assert abs(dn[i] - exact_dn) < 8e-16 * abs(exact_dn)


def test_points_where_scipy_fails(reference: Reference) -> None:
    """Issues 8480 and 19498 of SciPy: the arguments in our own report of them."""
    for m, fraction in ((0.25, 1.25), (0.49, 0.3125), (0.25, 1.0)):
        k, u = m**0.5, fraction * quarter_period(m**0.5)
        values = evaluate(k, u)[:, 0]
        assert np.all(worst(values, [u], [0.0], k, reference) < 6e-16)
    u = float(ctx.ellipf(1.9384070927630093, 0.25))
    assert (
        abs(numpy_functions.jacobi_epsilon(u, 0.25) - ctx.ellipe(1.9384070927630093, 0.25)) < 1e-15
    )
    k = (1 - 1e-10) ** 0.5
    sn, cn, *_ = evaluate(k, np.linspace(0, 50 * quarter_period(k), 1001))[:, 0]
    assert np.max(np.abs(sn)) <= 1 + 2.3e-16
    assert np.max(np.abs(cn)) <= 1 + 2.3e-16


@pytest.mark.parametrize("m", [1e-8, 0.3, 0.7, 0.99])
def test_theta_functions(m: float) -> None:
    u = quarter_period(m**0.5) * np.array([-3.7, -1.3, 0.2, 0.5, 0.9, 1.5, 2.2, 4.1])
    for function, reference in (("jacobi_eta", mp.eta), ("jacobi_theta", mp.theta)):
        values = getattr(numpy_functions, function)(u, m)
        for i in range(u.size):
            exact = reference(ctx, u[i], m)
            assert abs(values[i] - exact) < 2e-15 * abs(exact)


def test_theta_refuses_m_equal_to_one() -> None:
    with pytest.raises(ValueError, match="m must satisfy m < 1, got 1"):
        numpy_functions.jacobi_theta(1.0, 1.0)


@settings(max_examples=100)
@given(
    k=st.one_of(st.floats(0, 1), st.floats(1e-16, 1e-3).map(lambda x: 1 - x)),
    u=st.floats(-1e7, 1e7),
    low=st.floats(-1e-16, 1e-16),
)
def test_identities_and_reference_at_random(
    k: float, u: float, low: float, reference: Reference
) -> None:
    values = evaluate(k, u, u * low)[:, 0]
    sn, cn, dn, *_ = values
    assert abs(sn**2 + cn**2 - 1) < 2e-15
    assert abs(dn**2 - (1 - k) * (1 + k) - k**2 * cn**2) < 2e-15
    assert np.all(worst(values, [u], [u * low], k, reference) < 1e-15)


@settings(max_examples=60)
@given(m=st.floats(0, 0.999999), u=st.floats(-50, 50))
def test_parity(m: float, u: float) -> None:
    plus, minus = (evaluate(m**0.5, v)[:, :2, 0] for v in (u, -u))
    assert np.all(plus == np.array([[-1], [1], [1], [-1], [1]]) * minus)


def test_infinities_give_nan_and_the_hyperbolic_limit_is_reached() -> None:
    assert np.all(np.isnan(evaluate(0.5, [np.inf, -np.inf, np.nan])[:, 0]))
    sn, cn, dn, zeta, _ = evaluate(1.0, [800.0, -1e5])[:, 0]
    assert sn.tolist() == zeta.tolist() == [1, -1]
    assert np.max(np.abs([cn, dn])) < 1e-280


def test_numpy_functions_take_any_shape_and_refuse_bad_parameters() -> None:
    assert numpy_functions.jacobi_sn(np.zeros((3, 4)), 0.3).shape == (3, 4)
    for m in (-0.1, 1.1, np.nan):
        with pytest.raises(ValueError, match="m must satisfy 0 <= m <= 1, got"):
            numpy_functions.jacobi_cn(1.0, m)


def test_zeta_is_periodic_and_epsilon_grows() -> None:
    u = np.linspace(-30, 30, 101)
    K, E = float(ctx.ellipk(0.8)), float(ctx.ellipe(0.8))
    zeta = numpy_functions.jacobi_zeta(u, 0.8)
    assert np.allclose(numpy_functions.jacobi_epsilon(u, 0.8), u * E / K + zeta, rtol=0, atol=1e-14)
    assert np.allclose(zeta, numpy_functions.jacobi_zeta(u + 2 * K, 0.8), rtol=0, atol=1e-14)

"""High parts of sn, cn, dn, epsilon, zeta against 50 digits, and the functions for NumPy."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import MPContext

from solutions import numpy_function as numpy_functions
from solutions.functions import multiprecision as mp
from solutions.run.elliptic_parameter import (
    EllipticParameter,
    elliptic_parameter,
    parameter_of_modulus,
)
from solutions.run.jacobi_pairs import evaluate_pairs

MODULI = (0.0, 1e-8, 0.3, 0.7071, 0.70711, 0.9, 1 - 1e-4, 1 - 1e-8, 1 - 1e-12, 1 - 2**-53, 1.0)
Reference = Callable[[float, float, float], tuple[Any, ...]]


def high_parts(p: EllipticParameter, u: Any, u_lo: Any = 0.0) -> np.ndarray:
    """sn, cn, dn, epsilon, zeta as doubles."""
    return np.array([values[0] for values in evaluate_pairs(p, u, u_lo)[:5]])


def worst(values: Any, u: Any, u_lo: Any, k: float, reference: Reference) -> np.ndarray:
    """Return the largest error of each row, relative to max(1, |value|)."""
    errors = np.zeros(5)
    for i in range(len(u)):
        exact = reference(k, float(u[i]), float(u_lo[i]))
        for row, e in enumerate(exact):
            errors[row] = max(errors[row], float(abs(values[row][i] - e) / max(1, abs(e))))
    return errors


@pytest.mark.parametrize("k", MODULI)
def test_dense_grid_with_every_sixteenth_of_K(k: float, reference: Reference) -> None:
    """SciPy's ellipeinc is wrong by 0.1 .. 0.4 at some u = j K / 16."""
    p = parameter_of_modulus(k)
    K = p.K[0] if k < 1 else 20.0
    u = K * np.concatenate([np.arange(-5, 69) / 16, [np.sqrt(2), -np.pi, 1e-12]])
    values = high_parts(p, u)
    assert np.all(worst(values, u, 0 * u, k, reference) < 6e-16)


@pytest.mark.parametrize("k", MODULI[:-1])
def test_a_million_periods_cost_no_digits(
    k: float, reference: Reference, rng: np.random.Generator
) -> None:
    """u and its low part are reduced as one number; a K in double alone would lose 10 digits."""
    p = parameter_of_modulus(k)
    u = rng.uniform(-4e6, 4e6, 12) * p.K[0]
    u_lo = u * rng.uniform(-1e-16, 1e-16, 12)
    errors = worst(high_parts(p, u, u_lo), u, u_lo, k, reference)
    assert np.all(errors < 1e-15)
    assert errors[3] < 1.3e-16  # epsilon is large: half an ulp, which takes E's low part


@pytest.mark.parametrize("k", MODULI)
def test_cn_and_dn_keep_relative_accuracy(k: float, reference: Reference) -> None:
    """Near u = K and k = 1, cn and dn are as small as k'; they must not drown in round-off."""
    p = parameter_of_modulus(k)
    u = (p.K[0] if k < 1 else 20.0) * np.linspace(0.4, 1.9, 30)
    _, cn, dn, *_ = high_parts(p, u)
    for i in range(u.size):
        _, exact_cn, exact_dn, *_ = reference(k, float(u[i]), 0.0)
        assert abs(cn[i] - exact_cn) < 8e-16 * abs(exact_cn)
        assert abs(dn[i] - exact_dn) < 8e-16 * abs(exact_dn)


def test_points_where_scipy_fails(reference: Reference) -> None:
    """Issues 8480 and 19498 of SciPy: the arguments in our own report of them."""
    for m, fraction in ((0.25, 1.25), (0.49, 0.3125), (0.25, 1.0)):
        k, u = m**0.5, fraction * elliptic_parameter(m, 1 - m).K[0]
        values = high_parts(parameter_of_modulus(k), [u])
        assert np.all(worst(values, [u], [0.0], k, reference) < 6e-16)
    ctx = MPContext()
    u = float(ctx.ellipf(1.9384070927630093, 0.25))
    assert (
        abs(numpy_functions.jacobi_epsilon(u, 0.25) - ctx.ellipe(1.9384070927630093, 0.25)) < 1e-15
    )
    p = elliptic_parameter(1 - 1e-10, 1e-10)
    sn, cn, *_ = high_parts(p, np.linspace(0, 50 * p.K[0], 1001))
    assert np.max(np.abs(sn)) <= 1 + 2.3e-16
    assert np.max(np.abs(cn)) <= 1 + 2.3e-16


@pytest.mark.parametrize("m", [1e-8, 0.3, 0.7, 0.99])
def test_theta_functions(m: float) -> None:
    ctx = MPContext()
    ctx.dps = 50
    u = elliptic_parameter(m, 1 - m).K[0] * np.array([-3.7, -1.3, 0.2, 0.5, 0.9, 1.5, 2.2, 4.1])
    for function, reference in (("jacobi_eta", mp.eta), ("jacobi_theta", mp.theta)):
        values = getattr(numpy_functions, function)(u, m)
        for i in range(u.size):
            exact = reference(ctx, u[i], m)
            assert abs(values[i] - exact) < 2e-15 * abs(exact)


def test_theta_refuses_m_equal_to_one() -> None:
    with pytest.raises(ValueError, match="m1 must satisfy m1 > 0, got 0"):
        numpy_functions.jacobi_theta(1.0, 1.0)


@settings(max_examples=200)
@given(
    k=st.one_of(st.floats(0, 1), st.floats(1e-16, 1e-3).map(lambda x: 1 - x)),
    u=st.floats(-1e7, 1e7),
    low=st.floats(-1e-16, 1e-16),
)
def test_identities_and_reference_at_random(
    k: float, u: float, low: float, reference: Reference
) -> None:
    p = parameter_of_modulus(k)
    values = high_parts(p, [u], [u * low])
    sn, cn, dn, *_ = values
    assert abs(sn**2 + cn**2 - 1) < 2e-15
    assert abs(dn**2 - p.m1[0] - p.m[0] * cn**2) < 2e-15
    assert np.all(worst(values, [u], [u * low], k, reference) < 1e-15)


@settings(max_examples=100)
@given(m=st.floats(0, 0.999999), u=st.floats(-50, 50))
def test_parity(m: float, u: float) -> None:
    plus, minus = (high_parts(elliptic_parameter(m, 1 - m), v) for v in (u, -u))
    signs = np.array([-1, 1, 1, -1, -1])
    assert np.all(np.abs(plus - signs * np.array(minus)) <= 4e-16 * np.maximum(1, np.abs(plus)))


def test_shapes_broadcast_and_infinities_give_nan() -> None:
    p = elliptic_parameter(0.3, 0.7)
    assert high_parts(p, np.zeros((3, 1)), np.zeros(4)).shape == (5, 3, 4)
    assert np.all(np.isnan(high_parts(p, [np.inf, -np.inf, np.nan])))
    sn, cn, dn, epsilon, _ = high_parts(elliptic_parameter(1.0, 0.0), [800.0, -1e5])
    assert sn.tolist() == epsilon.tolist() == [1, -1]
    assert cn.tolist() == dn.tolist() == [0, 0]


def test_split_of_epsilon_into_growth_and_period() -> None:
    p = elliptic_parameter(0.8, 1 - 0.8)
    u = np.linspace(-30, 30, 101)
    *_, epsilon, zeta = high_parts(p, u)
    assert np.allclose(epsilon, u * p.slope[0] + zeta, rtol=0, atol=1e-14)
    again = high_parts(p, u + 2 * p.K[0])
    assert np.allclose(zeta, again[4], rtol=0, atol=1e-14)

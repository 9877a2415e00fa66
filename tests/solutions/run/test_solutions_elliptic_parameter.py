"""The record of an elliptic parameter: both ways to make it, and what it refuses."""

import math

import pytest
from mpmath import MPContext

from solutions.run.elliptic_parameter import elliptic_parameter, parameter_of_modulus

ctx = MPContext()
ctx.dps = 60


@pytest.mark.parametrize("m", [1e-300, 1e-16, 0.2, 0.5, 0.8])
@pytest.mark.parametrize("swapped", [False, True])
def test_complete_integrals_in_double_double(m: float, swapped: bool) -> None:
    exact_m = 1 - ctx.mpf(m) if swapped else ctx.mpf(m)
    p = elliptic_parameter(1 - m, m) if swapped else elliptic_parameter(m, 1 - m)
    with ctx.workdps(400):
        exact_m = 1 - ctx.mpf(m) if swapped else ctx.mpf(m)
        expected = {"K": ctx.ellipk(exact_m), "E": ctx.ellipe(exact_m)}
        expected["slope"] = expected["E"] / expected["K"]
        for name, value in expected.items():
            high, low = getattr(p, name)[:2]
            assert abs((ctx.mpf(high) + low) / value - 1) < 1e-31


def test_modulus_and_pair_agree_where_the_square_alone_does_not() -> None:
    k = 1 - 1e-8
    p, q = parameter_of_modulus(k), elliptic_parameter(k * k, (1 - k) * (1 + k))
    assert math.isclose(p.m1[0], q.m1[0], rel_tol=4e-16)
    assert not math.isclose(p.m1[0], 1 - k * k, rel_tol=1e-10)


def test_low_parts_are_used() -> None:
    p = elliptic_parameter(0.25, 0.75, m_lo=1e-17)
    assert p.K != elliptic_parameter(0.25, 0.75).K
    assert p.m == (0.25, 1e-17)


def test_ends() -> None:
    assert elliptic_parameter(0.0, 1.0).nome == (0.0, 0.0)
    p = elliptic_parameter(1.0, 0.0)
    assert math.isinf(p.K[0])
    assert (p.E, p.slope, p.nome) == ((1.0, 0.0), (0.0, 0.0), (0.0, 0.0))


@pytest.mark.parametrize(
    ("m", "m1", "message"),
    [
        (-0.1, 1.1, r"m and m1 must lie in \[0, 1\], got m = -0.1"),
        (math.nan, 0.5, r"m and m1 must lie in \[0, 1\], got m = nan"),
        (0.3, 0.6, r"m \+ m1 must equal 1, got m = 0.3, m1 = 0.6 \(pass"),
    ],
)
def test_bad_pairs(m: float, m1: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        elliptic_parameter(m, m1)


@pytest.mark.parametrize("k", [-0.5, 1.0000001, math.nan])
def test_bad_modulus(k: float) -> None:
    with pytest.raises(ValueError, match="k must satisfy 0 <= k <= 1, got"):
        parameter_of_modulus(k)

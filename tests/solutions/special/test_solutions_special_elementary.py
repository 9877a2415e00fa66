"""Sine, cosine, exponential and phases in double-double against mpmath and fractions."""

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import MPContext

from solutions.special.doubledouble import split, two_sum
from solutions.special.elementary import decay, linear_phase, sine_cosine

ctx = MPContext()
ctx.dps = 60


def relative(pair: tuple[float, float], value: Any) -> float:
    """Return the relative error of the pair, 0 for an exact 0."""
    error = abs(ctx.mpf(pair[0]) + pair[1] - value)
    return float(error / abs(value)) if value else float(error)


@given(v=st.floats(-0.79, 0.79), low=st.floats(-1e-17, 1e-17))
def test_sine_and_cosine(v: float, low: float) -> None:
    pair = two_sum(v, v * low)
    exact = ctx.mpf(pair[0]) + pair[1]
    sine, cosine = sine_cosine(pair)
    assert abs(v) < 1e-200 or relative(sine, ctx.sin(exact)) < 1e-31
    assert relative(cosine, ctx.cos(exact)) < 1e-31


@given(w=st.one_of(st.floats(1e-200, 1), st.floats(1, 600)), low=st.floats(-1e-17, 1e-17))
def test_decay(w: float, low: float) -> None:
    """The complement 1 - exp(-w) must keep its digits for small w, and next to 1."""
    pair = two_sum(w, w * low)
    exact = ctx.mpf(pair[0]) + pair[1]
    value, complement = decay(pair)
    assert relative(value, ctx.exp(-exact)) < 1e-29
    assert relative(complement, -ctx.expm1(-exact)) < 1e-31


def test_phase_of_a_far_site_keeps_thirty_digits(rng: np.random.Generator) -> None:
    """n - c t cancels ten digits here; doubles would keep six of the phase."""
    a, b = (
        split("0.061237243569579452454932101867647"),
        split("-0.12247448713915890490986420373529"),
    )
    n = rng.integers(-(10**9), 10**9, 50).astype(float)
    t = n / 2 + rng.uniform(-1, 1, 50)
    high, low = linear_phase(n, a, t, b)
    for i in range(n.size):
        exact = sum(
            (Fraction(x) + Fraction(y)) * Fraction(z) for (x, y), z in ((a, n[i]), (b, t[i]))
        )
        assert abs(Fraction(high[i]) + Fraction(low[i]) - exact) < Fraction(1, 10**22)


def test_phase_shapes() -> None:
    high, low = linear_phase(np.zeros((2, 1)), (1.0, 0.0), np.ones(3), (0.5, 0.0))
    assert high.shape == low.shape == (2, 3)
    with pytest.raises(ValueError, match="broadcast"):
        linear_phase(np.zeros(2), (1.0, 0.0), np.ones(3), (0.5, 0.0))

"""Catches: text evaluated as code, a misread fraction, K of the parameter instead of k."""

from fractions import Fraction

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from longwave.scenes.chain.moving_wave import exact_quantity, quarter_period_multiple


@given(st.integers(1, 999), st.integers(1, 999))
def test_multiples_of_the_quarter_period(times: int, over: int) -> None:
    assert quarter_period_multiple("alpha", f" {times}*K / {over}") == Fraction(times, over)


@pytest.mark.parametrize(
    "text",
    ["", "k/2", "K/0", "K*3", "2K", "K/2/2", "-K", "0.5*K", "__import__('os')", "K/2; 1", "9" * 9],
)
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="alpha must be a number or a multiple of K"):
        quarter_period_multiple("alpha", text)


def test_K_is_taken_at_the_modulus() -> None:
    value = exact_quantity("alpha", "3*K/4", sp.Rational(7, 10))
    assert float(value) == pytest.approx(0.75 * float(mpmath.ellipk(0.49)), abs=1e-15)


def test_a_multiple_of_K_needs_a_modulus() -> None:
    with pytest.raises(ValueError, match="K needs the modulus k"):
        exact_quantity("tau_5", "K/2", None)

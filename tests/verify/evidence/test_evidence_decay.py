"""Decay of a residual with the digits: which decays pass and which fail."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from longwave.verify.evidence.residual import Decay, Sampling

DIGITS = (30, 50, 100)


@given(st.floats(0, 12), st.floats(-1.9, 1.9), st.floats(-1.9, 1.9))
def test_a_fall_with_the_digits_passes(loss: float, first: float, second: float) -> None:
    assert Decay(DIGITS, (loss - 30, loss - 50 + first, loss - 100 + second)).falls()


@given(st.floats(-30, 0))
def test_a_constant_residual_fails(level: float) -> None:
    assert not Decay(DIGITS, (level, level, level)).falls()


def test_a_residual_that_stops_at_double_precision_fails() -> None:
    assert not Decay(DIGITS, (-16.2, -16.2, -16.2)).falls()
    assert not Decay(DIGITS, (-29.0, -49.0, -60.0)).falls()


def test_a_fall_of_half_the_digits_fails() -> None:
    assert not Decay(DIGITS, (-15.0, -25.0, -50.0)).falls()


def test_exact_zeros_pass_and_do_not_raise_the_bar() -> None:
    nothing = float("-inf")
    assert Decay(DIGITS, (nothing, -50.5, nothing)).falls()


@pytest.mark.parametrize("digits", [(), (30,), (50, 30), (30, 30), (30, 34), (5, 50)])
def test_digits_that_say_nothing_are_refused(digits: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="digits must be two or more"):
        Sampling(digits)

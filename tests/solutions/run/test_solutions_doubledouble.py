"""Double-double arithmetic against exact fractions."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import MPContext, mpf
from sympy import Rational, pi

from longwave.solutions.run import doubledouble as dd

Pair = tuple[float, float]

FLOATS = st.one_of(
    st.floats(-1e100, 1e100, allow_subnormal=False).filter(lambda x: x == 0 or abs(x) > 1e-60),
    st.integers(-(2**60), 2**60).map(float),
)
PAIRS = st.tuples(FLOATS, st.floats(-1, 1)).map(lambda p: dd.two_sum(p[0], p[0] * p[1] * 2.0**-53))


def exact(pair: Pair) -> Fraction:
    """Return the number that the pair stands for."""
    return Fraction(pair[0]) + Fraction(pair[1])


def relative(pair: Pair, value: Fraction) -> float:
    """Return the relative error of the pair, 0 for an exact 0."""
    error = abs(exact(pair) - value)
    return float(error / abs(value)) if value else float(error)


@given(a=FLOATS, b=FLOATS)
def test_error_free_transformations(a: float, b: float) -> None:
    assert exact(dd.two_sum(a, b)) == Fraction(a) + Fraction(b)
    assert exact(dd.two_prod(a, b)) == Fraction(a) * Fraction(b)


@settings(max_examples=150)
@given(a=PAIRS, b=PAIRS, c=FLOATS)
def test_arithmetic(a: Pair, b: Pair, c: float) -> None:
    assert relative(dd.add(a, b), exact(a) + exact(b)) < 2.0**-103
    assert relative(dd.subtract(a, b), exact(a) - exact(b)) < 2.0**-103
    assert relative(dd.multiply(a, b), exact(a) * exact(b)) < 2.0**-101
    assert relative(dd.scale(a, c), exact(a) * Fraction(c)) < 2.0**-101
    if b[0]:
        assert relative(dd.reciprocal(b), 1 / exact(b)) < 2.0**-101


@given(a=PAIRS)
def test_near_cancellation(a: Pair) -> None:
    """A sloppy addition loses everything here."""
    b = (-a[0], a[1])
    assert relative(dd.add(a, b), exact(a) + exact(b)) < 2.0**-103


@given(a=PAIRS.filter(lambda p: p[0] >= 0))
def test_square_root(a: Pair) -> None:
    root = exact(dd.square_root(a))
    assert abs(root * root - exact(a)) <= exact(a) * Fraction(2.0**-99)


def test_split_takes_every_kind_of_exact_number() -> None:
    ctx = MPContext()
    ctx.prec = 200
    for number in ("1/3", Fraction(1, 3), Rational(1, 3), ctx.mpf(1) / 3):
        assert relative(dd.split(number), Fraction(1, 3)) < 2.0**-106
    assert dd.split(7) == (7.0, 0.0)
    assert dd.split(mpf("0.5")) == (0.5, 0.0)
    assert dd.split(float("inf")) == (float("inf"), 0.0)
    assert dd.split(pi) == (3.141592653589793, 1.2246467991473532e-16)


@pytest.mark.parametrize("n", [0, 1, 52, 1022, -1, -1022])
def test_powers_of_a_half_are_exact(n: int) -> None:
    assert dd.power_of_half(float(n)) == 0.5**n


@given(a=PAIRS, b=PAIRS)
def test_the_loose_sum_errs_relative_to_the_summands(a: Pair, b: Pair) -> None:
    missed = abs(exact(dd.add_loosely(a, b)) - (exact(a) + exact(b)))
    assert missed <= (abs(exact(a)) + abs(exact(b))) / 2**103


@given(a=PAIRS.filter(lambda a: a[0] != 0))
def test_reciprocal(a: Pair) -> None:
    assert relative(dd.reciprocal(a), 1 / exact(a)) < 2.0**-101

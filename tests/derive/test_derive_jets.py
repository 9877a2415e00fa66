"""The algebra of differential polynomials: Leibniz, antiderivatives, series."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from longwave.derive import symbols
from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries, Monomial, raised
from longwave.derive.algebra.rational_functions import RationalFunctions

CONSTANTS = RationalFunctions((symbols.K4,))
K4 = CONSTANTS(symbols.K4)

jets = st.tuples(st.integers(0, 3), st.integers(0, 1))
monomials = st.lists(jets, min_size=1, max_size=3).map(lambda m: tuple(sorted(m)))
numbers = st.integers(-5, 5).map(lambda value: CONSTANTS(value) * (K4 + 2))
polynomials = st.lists(st.tuples(monomials, numbers), max_size=4).map(
    lambda items: DifferentialPolynomial.collect(CONSTANTS, items)
)


@settings(max_examples=60, deadline=None)
@given(polynomials, polynomials)
def test_total_derivative_obeys_leibniz(
    left: DifferentialPolynomial, right: DifferentialPolynomial
) -> None:
    for axis in (0, 1):
        expected = left.derivative(axis) * right + left * right.derivative(axis)
        assert (left * right).derivative(axis) == expected


@settings(max_examples=60, deadline=None)
@given(polynomials)
def test_antiderivative_inverts_the_derivative(polynomial: DifferentialPolynomial) -> None:
    assert polynomial.derivative(0).antiderivative(0) == polynomial


@pytest.mark.parametrize(
    "monomial", [((1, 0), (1, 0)), ((0, 0),), ((0, 0), (0, 0), (2, 0)), ((0, 0), (3, 1)), ()]
)
def test_a_polynomial_that_is_no_derivative_has_no_antiderivative(monomial: Monomial) -> None:
    assert DifferentialPolynomial.monomial(CONSTANTS, monomial).antiderivative() is None


def test_cancelled_terms_are_not_stored() -> None:
    wave = DifferentialPolynomial.monomial(CONSTANTS, ((0, 0),))
    assert not (wave - wave).terms
    assert not wave.map_coefficients(lambda value: value - value).terms


def test_a_shift_of_a_product_is_the_product_of_shifts() -> None:
    """Catches a wrong factorial or a truncation that drops an order it should keep."""
    wave = EpsSeries(CONSTANTS, 8, {1: DifferentialPolynomial.monomial(CONSTANTS, ((0, 0),))})
    shift = ((0, 1, CONSTANTS.one),)
    assert (wave * wave).exponential(shift) == wave.exponential(shift) * wave.exponential(shift)


def test_opposite_shifts_undo_each_other() -> None:
    wave = EpsSeries(CONSTANTS, 8, {0: DifferentialPolynomial.monomial(CONSTANTS, ((0, 0),))})
    there = wave.exponential(((0, 1, CONSTANTS.one),))
    assert there.exponential(((0, 1, -CONSTANTS.one),)) == wave


def test_raised_touches_one_axis() -> None:
    assert raised((1, 2, 3), 1, 4) == (1, 6, 3)

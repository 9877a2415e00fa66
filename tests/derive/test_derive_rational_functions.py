"""Rational functions over FLINT against SymPy's field."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sympy import QQ, Add, Integer, Rational, Symbol, cancel, prod, sqrt
from sympy.polys.fields import FracField
from sympy.polys.orderings import lex

from longwave.derive.algebra.rational_functions import RationalFunctions

SYMBOLS = tuple(Symbol(name) for name in "xyz")
FIELD = RationalFunctions(SYMBOLS)
KNOWN = FracField(SYMBOLS, QQ, lex)
x, y, z = SYMBOLS

leaves = st.one_of(
    st.integers(-6, 6).map(Integer), st.sampled_from(SYMBOLS), st.just(Rational(2, 3))
)
expressions = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(inner, inner).map(lambda pair: pair[0] + pair[1]),
        st.tuples(inner, inner).map(lambda pair: pair[0] * pair[1]),
        st.tuples(inner, st.integers(1, 3)).map(lambda pair: pair[0] ** pair[1]),
    ),
    max_leaves=6,
)


@given(expressions, expressions)
def test_arithmetic_is_that_of_sympy(left: Any, right: Any) -> None:
    a, b = FIELD.from_expr(left), FIELD.from_expr(right)
    for found, expected in ((a + b, left + right), (a - b, left - right), (a * b, left * right)):
        assert KNOWN.from_expr(found.as_expr()) == KNOWN.from_expr(expected)
    if b:
        quotient = (a / b).as_expr()
        assert KNOWN.from_expr(quotient) == KNOWN.from_expr(left) / KNOWN.from_expr(right)
        assert cancel(quotient - left / right) == 0


@given(expressions, expressions)
def test_equal_quotients_are_equal_objects(left: Any, right: Any) -> None:
    a, b = FIELD.from_expr(left), FIELD.from_expr(right)
    if b:
        assert a * b / b == a
        assert hash(a * b / b) == hash(a)
        assert (a / b == 0) == (not a)


def test_derivatives_powers_and_values_where_it_vanishes() -> None:
    value = FIELD.from_expr((x**2 * y + 3) / (z - x))
    assert cancel(value.diff(x).as_expr() - ((x**2 * y + 3) / (z - x)).diff(x)) == 0
    assert value**-2 * value**2 == 1
    solved = value.solved_for(y)
    assert solved is not None
    assert cancel(solved.as_expr() + 3 / x**2) == 0
    assert value.solved_for(x) is None
    assert value.solved_for(z) is None


def test_images_stand_for_symbols() -> None:
    image = {y: FIELD.from_expr(1 / x)}
    assert FIELD.from_expr(x * y + z, image).as_expr() == z + 1


def test_a_function_that_is_not_rational_is_refused() -> None:
    with pytest.raises(ValueError, match="value must be a rational function, got"):
        FIELD.from_expr(sqrt(x))
    with pytest.raises(ZeroDivisionError, match="the divisor must not be 0"):
        FIELD.one / FIELD.zero


@pytest.mark.parametrize("n", [3, 10**20, 10**50])
def test_factors_of_any_size_multiply_to_the_polynomial(n: int) -> None:
    """Catches factors that python-flint cannot put in order."""
    field = RationalFunctions((x, y))
    for product in (6 * n**2 * x**2 - 6 * y**2, -4 * (x - n) ** 2 * (x + n) * (y + n)):
        (content, _), *parts = field.from_expr(product.expand()).factored_terms()
        found = content[0][1] * prod(
            Add(*(value * x**i * y**j for (i, j), value in terms)) ** times
            for terms, times in parts
        )
        assert len(parts) == (2 if product.is_Add else 3)
        assert (found - product).expand() == 0

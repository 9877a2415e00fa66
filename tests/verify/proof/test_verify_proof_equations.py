"""Equations that are polynomials in the unknown's derivatives, and equations that are not."""

from collections.abc import Callable

import pytest
import sympy as sp

from longwave.verify.proof import prove
from longwave.verify.verdict import Outcome

x = sp.Symbol("x", real=True)
u = sp.Function("u")(x)

OTHER = {
    "gamma": sp.gamma,
    "floor": sp.floor,
    "integral": lambda f: sp.Integral(f, x),
    "value at 0": lambda f: sp.Subs(f, x, 0),
    "root of another function": lambda f: sp.sqrt(sp.gamma(f)),
    "one over another function": lambda f: 1 / sp.gamma(f),
    "power": lambda f: f ** sp.Symbol("a", positive=True) * sp.gamma(f),
}


@pytest.mark.parametrize("name", OTHER)
def test_what_is_no_polynomial_in_jets_is_not_read_as_one(name: str) -> None:
    other: Callable[[sp.Expr], sp.Expr] = OTHER[name]
    verdict = prove(u.diff(x) * other(u) - x, x)
    assert verdict.outcome is Outcome.UNDECIDED
    assert "polynomials in u(x)" in verdict.detail


def test_the_derivative_of_a_product_is_written_out() -> None:
    product = sp.Derivative(x * u, x)
    assert prove(product - 2 * x, x).outcome is Outcome.PROVED
    assert prove(product - 1, x).outcome is Outcome.REFUTED


def test_the_unknown_may_be_called_as_a_parameter() -> None:
    parameter = sp.Symbol("u", positive=True)
    equation = u.diff(x) - parameter * u
    assert prove(equation, sp.exp(parameter * x)).outcome is Outcome.PROVED


def test_a_denominator_of_60_digits_is_shown_not_to_vanish() -> None:
    tiny = sp.Rational(1, 10**60)
    below = sp.exp(x) - sp.sinh(x) - sp.cosh(x) + tiny
    assert prove(u.diff(x) - 1 / tiny, x / below).outcome is Outcome.PROVED

"""Roots, logarithms and inverse tangents of the same argument in different forms."""

import pytest
import sympy as sp

from longwave.verify.proof import prove, prove_equal
from longwave.verify.proof.balls import ball_value
from longwave.verify.proof.factors import Quotients, TooLong, factored
from longwave.verify.verdict import Outcome

x, t, a = sp.symbols("x t a", real=True)
p, r = sp.symbols("p r", positive=True)
NARROW = sp.Interval.open(-sp.Rational(3, 2), sp.Rational(3, 2))
HALF = sp.Interval.open(0, 3)
root, third = sp.sqrt, sp.Rational(1, 3)

EQUAL = [
    (root(3 + 2 * root(2)), 1 + root(2)),
    ((135 + 78 * root(3)) ** third, 3 + 2 * root(3)),
    (root(p + 2 * root(p) + 1), 1 + root(p)),
    (root(t + 2 * root(t) + 1), 1 + root(t)),
    (root(2 * sp.I * root(p) - p + 1), 1 + sp.I * root(p)),
    (root(sp.expand(((x * a + 3) ** 2 + 2) ** 2)), (x * a + 3) ** 2 + 2),
    (1 / root(p**3 + 2 * p**2 + p), 1 / (root(p) * (p + 1))),
    (sp.expand((x**2 / p**2 + 4) ** 4) ** sp.Rational(1, 4), x**2 / p**2 + 4),
    (root(1 - sp.tanh(x) ** 2), sp.sech(x)),
    (root(sp.cosh(2 * x) + sp.sinh(2 * x)), sp.exp(x)),
    (root(sp.I * p), (1 + sp.I) / root(2) * root(p)),
    (sp.log(p**2 + p), sp.log(p) + sp.log(1 + p)),
    (sp.log(sp.expand((x + t) ** 2 + 1)), sp.log((x + t) ** 2 + 1)),
    (sp.log(x**2), 2 * sp.log(sp.Abs(x))),
    (sp.exp(2 * sp.I * sp.atan(x)), (1 + sp.I * x) / (1 - sp.I * x)),
    (sp.sin(sp.cancel((x**2 - t**2) / (x - t)) * a), sp.sin((x**2 - t**2) / (x - t) * a)),
]
ON_INTERVALS = [
    (root(1 - sp.sin(x) ** 2), sp.cos(x), NARROW),
    (root(1 - sp.cos(x) ** 2), sp.sin(x), HALF),
    (root(2 + 2 * sp.cos(x)), 2 * sp.cos(x / 2), HALF),
    (root(sp.exp(sp.I * x)), sp.exp(sp.I * x / 2), HALF),
    (sp.atan(sp.tan(x)), x, NARROW),
]
FALSE = [
    (root(3 - 2 * root(2)), 1 - root(2)),
    (root(sp.expand((x - 2) ** 2)), x - 2),
    (root(p - 2 * root(p) + 1), 1 - root(p)),
    (sp.log(x**2), 2 * sp.log(x)),
    (root(sp.exp(sp.I * x)), sp.exp(sp.I * x / 2)),
    (sp.atan(sp.tan(x)), x),
    (root(1 - sp.sin(x) ** 2), sp.cos(x)),
]


@pytest.mark.parametrize(("left", "right"), EQUAL, ids=str)
def test_the_same_root_or_logarithm_written_differently_is_proved(
    left: sp.Expr, right: sp.Expr
) -> None:
    assert prove_equal(left, right, [x, t]).outcome is Outcome.PROVED


@pytest.mark.parametrize(("left", "right", "interval"), ON_INTERVALS, ids=str)
def test_a_branch_is_proved_where_it_holds_and_refuted_beyond(
    left: sp.Expr, right: sp.Expr, interval: sp.Interval
) -> None:
    assert prove_equal(left, right, [x], domains={x: interval}).outcome is Outcome.PROVED
    wide = sp.Interval.open(-7, 7)
    assert prove_equal(left, right, [x], domains={x: wide}).outcome is Outcome.REFUTED


@pytest.mark.parametrize(("left", "right"), FALSE, ids=str)
def test_another_branch_is_refuted(left: sp.Expr, right: sp.Expr) -> None:
    assert prove_equal(left, right, [x, t]).outcome is Outcome.REFUTED


@pytest.mark.parametrize("digits", [12, 30])
def test_a_sliver_at_an_end_of_the_domain_is_met(digits: int) -> None:
    end = 1 + sp.Rational(1, 10**digits)
    stated = {x: sp.Interval.open(-sp.oo, end)}
    left = sp.sqrt(x**2 - 2 * x + 1)
    assert prove_equal(left, 1 - x, [x], domains=stated).outcome is Outcome.REFUTED


def test_an_equation_is_not_multiplied_out_beyond_its_unknown() -> None:
    u = sp.Function("u")(x)
    coefficient = (1 + x + t + a + p + r) ** 12 / (2 + x + t * p) ** 9
    equation = coefficient * (u.diff(x) - 2 * u) * (1 + u)
    assert prove(equation, sp.exp(2 * x)).outcome is Outcome.PROVED


def test_a_derivative_in_a_parameter_is_refused() -> None:
    u = sp.Function("u")(x)
    with pytest.raises(ValueError, match="derivatives must be in the arguments"):
        prove(u.diff(x) + sp.Derivative(u, a) - 1, x)


def test_a_high_power_is_evaluated_by_squares() -> None:
    assert ball_value(x ** (10**7), {x: sp.S.One}, 64) == 1


def test_factors_and_sums_of_squares() -> None:
    assert factored(p**3 + 2 * p**2 + p) == (1, [(p, 1), (p + 1, 2)])
    assert Quotients(x**2 + 2 * x * t + 3 * t**2).squares() == (x + t) ** 2 + 2 * t**2
    assert Quotients(x**2 - t**2).squares() is None
    with pytest.raises(TooLong):
        factored((1 + x + t + a + p) ** 30)

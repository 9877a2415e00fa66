"""Formulas: the values of SymPy expressions in any mpmath context."""

import json
from typing import Any

import mpmath
import pytest
import sympy as sp

from longwave.solutions.functions.multiprecision import MpmathFormula

x, y = sp.symbols("x y", positive=True)

EXPRESSIONS = (
    x - 2 * y + sp.Rational(1, 3),
    x**-3 * y**5,
    sp.sqrt(x) / sp.sqrt(y) ** 3,
    x**y + sp.cbrt(x),
    sp.Float("0.1", 90) * x,
    sp.pi * sp.E * sp.exp(x * sp.I) * sp.GoldenRatio * sp.EulerGamma,
    sp.Abs(sp.conjugate(x + sp.I * y)) + sp.re(x * sp.I) + sp.im(sp.sign(y) * sp.I),
    sp.sech(x) * sp.csch(y) * sp.coth(x) + sp.sec(x) * sp.cot(y) - sp.csc(x),
    sp.log(x) * sp.atan(y) * sp.acosh(x + 2) * sp.asinh(y) * sp.atan2(y, x),
    sp.elliptic_k(x / 3) / sp.elliptic_e(y / 3),
    sp.gamma(x) * sp.besselj(0, y) * sp.erf(x) * sp.airyai(y),
)


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
@pytest.mark.parametrize("digits", [15, 60])
def test_values_agree_with_sympy(expression: sp.Expr, digits: int, ctx: Any) -> None:
    point = {x: sp.Rational(7, 10), y: sp.Rational(3, 10)}
    ctx.dps = digits
    values = [ctx.mpf(value.p) / value.q for value in point.values()]
    (found,) = MpmathFormula.of([x, y], [expression])(ctx, *values)
    expected = ctx.convert(sp.N(expression.subs(point), digits + 10)._to_mpmath(4 * digits))
    assert abs(found - expected) < 100 * abs(expected) * ctx.eps


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_it_survives_being_written_down(expression: sp.Expr, ctx: Any) -> None:
    formula = MpmathFormula.of([x, y], [expression, x])
    written = json.dumps([formula.arguments, formula.code, formula.results])
    again = MpmathFormula(*json.loads(written))
    assert again(ctx, ctx.mpf(2), ctx.mpf(3)) == formula(ctx, ctx.mpf(2), ctx.mpf(3))


def test_equal_parts_are_computed_once_and_statements_are_shared() -> None:
    z = sp.Symbol("z")
    formula = MpmathFormula.of([x], [z**2 + sp.sin(x), z], [(z, sp.sin(x) + 1)])
    assert [code[0] for code in formula.code].count("sin") == 1


def test_a_function_without_a_value_is_named() -> None:
    with pytest.raises(NameError, match="must have values in mpmath, got unheard_of"):
        MpmathFormula.of([x], [sp.Function("unheard_of")(x)])(mpmath.mp, 1)
    with pytest.raises(NameError, match="symbols must have values, got y"):
        MpmathFormula.of([x], [x + y])(mpmath.mp, 1)

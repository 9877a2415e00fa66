"""The tape: same values and derivatives as SymPy's own tree."""

import mpmath
import pytest
import sympy as sp

from longwave.solutions.catalogue import closed_form
from longwave.solutions.compile.tape import Tape
from longwave.solutions.symbols import k, tau, xi

x, y = sp.symbols("x y", real=True)

EXPRESSIONS = [
    x**3 * sp.sin(x * y) / (1 + x**2 + y**4),
    sp.exp(-(x**2)) * sp.sech(x + y) * sp.sqrt(2 + x) * y * x**2 * sp.cos(y),
    sp.im((x + sp.I * y) ** 3 / (2 + sp.I * x)) + sp.re(sp.conjugate(x + sp.I * y) ** 2),
]


def _value(expression: sp.Expr, variables: list[sp.Symbol]) -> mpmath.mpf:
    context = mpmath.mp.clone()
    context.dps = 40
    tape = Tape()
    entry = tape.record(expression)
    for variable in variables:
        entry = tape.derivative(entry, variable)
    return tape.formula([x, y], [entry])(context, context.mpf("0.7"), context.mpf("-0.3"))[0]


@pytest.mark.parametrize("expression", EXPRESSIONS)
@pytest.mark.parametrize("variables", [[], [x], [y], [x, x, x], [x, y]])
def test_derivatives_agree_with_sympy(expression: sp.Expr, variables: list[sp.Symbol]) -> None:
    derivative = sp.diff(expression, *variables) if variables else expression
    expected = derivative.subs({x: sp.Rational(7, 10), y: -sp.Rational(3, 10)}).evalf(40)
    assert abs(_value(expression, variables) - mpmath.mpmathify(expected)) < 1e-36


def test_equal_subexpressions_share_a_line() -> None:
    tape = Tape()
    tape.record(sp.sin(x * y) ** 2 + sp.cos(x * y))
    assert sum(node == x * y for _, node in tape.lines) == 1


def test_third_derivatives_stay_small() -> None:
    tape = Tape()
    entry = tape.record(closed_form("soliton_dn").expression)
    for variable in (xi, xi, xi):
        entry = tape.derivative(entry, variable)
    assert len(tape.lines) < 1500


def test_a_constant_has_derivative_zero() -> None:
    tape = Tape()
    assert tape.derivative(tape.record(sp.sqrt(1 - k**2)), tau) == 0


def test_an_unknown_function_is_an_error_at_the_call() -> None:
    tape = Tape()
    formula = tape.formula([x], [tape.record(sp.Function("unheard_of")(x))])
    with pytest.raises(NameError, match="must have values in mpmath, got unheard_of"):
        formula(mpmath.mp, 1)


def test_the_global_precision_is_left_alone() -> None:
    before = mpmath.mp.prec
    _value(EXPRESSIONS[0], [x])
    assert mpmath.mp.prec == before

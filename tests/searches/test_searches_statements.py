"""The random statements: the same for the same number, and rightly labelled."""

from dataclasses import replace

import pytest
import sympy as sp

from searches.statements.library import KINDS, statement
from searches.statements.random_statement import RandomStatement, SymbolRange, Truth
from searches.statements.values import ValueMissing, Values, fails_at, label_fault

x = sp.Symbol("x", real=True)
u = sp.Function("u")(x)
ONE = {x: sp.S.One}


def test_a_statement_is_the_same_each_time() -> None:
    assert [statement(3, index) for index in range(20)] == [
        statement(3, index) for index in range(20)
    ]
    assert statement(3, 0) != statement(4, 0)


@pytest.mark.parametrize("kind", KINDS)
def test_the_labels_of_every_kind_are_right(kind: str) -> None:
    for index in range(1):
        made = statement(11, index, (kind,))
        assert label_fault(made) is None, made.script()


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, 1000, 250))
def test_many_labels_are_right(start: int) -> None:
    for index in range(start, start + 250):
        made = statement(12, index)
        assert label_fault(made, points=3) is None, made.script()


def _equation(truth: Truth, left: sp.Expr, right: sp.Expr, **rest: object) -> RandomStatement:
    made = RandomStatement("by hand", truth, left, right, (x,), (SymbolRange(x),), unknown=u)
    return replace(made, **rest)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "fault"),
    [
        (_equation(Truth.TRUE, u.diff(x) - 2 * u, sp.exp(x)), "the residual at"),
        (
            _equation(Truth.FALSE, u.diff(x) - u, sp.exp(x), counterexample={x: sp.S.One}),
            "rounding",
        ),
        (_equation(Truth.FALSE, u.diff(x) - u, sp.exp(x)), "no counterexample"),
        (_equation(Truth.VOID, u.diff(x) - u, sp.exp(x)), "there is a value"),
        (
            replace(
                _equation(Truth.FALSE, u.diff(x), sp.exp(x), counterexample={x: -sp.S.One}),
                ranges=(SymbolRange(x, sp.S.Zero),),
            ),
            "not in its range",
        ),
    ],
)
def test_a_wrong_label_is_seen(wrong: RandomStatement, fault: str) -> None:
    assert fault in (label_fault(wrong) or "")


def test_a_change_of_the_two_hundredth_digit_is_a_residual() -> None:
    left = u.diff(x) - (1 + sp.Rational(1, 10**200)) * u
    assert fails_at(_equation(Truth.FALSE, left, sp.exp(x)), {x: sp.Rational(1, 3)})


@pytest.mark.parametrize(
    ("left", "right", "fails"),
    [
        (sp.exp(x) * sp.Abs(x), sp.exp(x) * x, True),
        (sp.exp(x) * sp.Abs(x), -sp.exp(x) * x, False),
        (sp.exp(x) * (sp.sin(x) ** 2 + sp.cos(x) ** 2), sp.exp(x), False),
        (sp.tanh(x / 40), -sp.S.One, True),
        (sp.tanh(x / 4), (sp.exp(x / 2) - 1) / (sp.exp(x / 2) + 1), False),
    ],
)
def test_a_residual_of_size_exp_minus_22000_is_one_and_rounding_is_none(
    left: sp.Expr, right: sp.Expr, fails: bool
) -> None:
    point = {x: sp.Rational(-154001, 7)}
    made = RandomStatement("by hand", Truth.FALSE, left, right, (x,), (SymbolRange(x),))
    assert fails_at(made, point) is fails
    assert fails_at(replace(made, left=u - left, unknown=u), point) is fails


def test_values_are_mpmaths() -> None:
    values = Values(30)
    point = {x: sp.Rational(-1, 3)}
    assert values.value(sp.sqrt(x**2), point) == values.context.mpf(1) / 3
    slope = values.derivative(sp.Abs(x) ** 3, {x: 2}, point)
    assert abs(slope - 2) < 1e-25
    with pytest.raises(ValueMissing):
        values.value(1 / (x + sp.Rational(1, 3)), point)


def test_a_script_repeats_the_statement() -> None:
    made = statement(3, 1)
    text = made.script()
    assert sp.srepr(made.right) in text
    assert f"statement({made.seed}, {made.index})" in text

"""The random statements that SymPy builds: the same for the same number, and rightly labelled."""

import random
from fractions import Fraction

import pytest
import sympy as sp

from searches.statements.library import KINDS, statement
from searches.statements.random_statement import RandomStatement, SymbolRange, ranged
from searches.texts.ball_judge import CannotJudge, Judge
from searches.texts.text_statement import Letter, TextStatement, Truth

x = sp.Symbol("x", real=True)
u = sp.Function("u")(x)


def label_fault(made: TextStatement, points: int = 4) -> str:
    """Return what speaks against the label of a statement that the judge can read."""
    if made.kind.startswith("opaque"):
        return ""
    judge, draw = Judge(made), random.Random(made.index)
    if made.truth is Truth.FALSE:
        point = made.counterexample or {}
        return "" if made.holds_at(point) and judge.fails_at(point) else "no counterexample"
    for _ in range(points):
        point = made.point(draw)
        try:
            if judge.fails_at(point) or made.truth is Truth.VOID:
                return f"it is not {made.truth} at {point}"
        except CannotJudge:
            continue
    return ""


def test_a_statement_is_the_same_each_time() -> None:
    assert [statement(3, index) for index in range(10)] == [
        statement(3, index) for index in range(10)
    ]
    assert statement(3, 0) != statement(4, 0)


@pytest.mark.parametrize("kind", KINDS)
def test_the_labels_of_every_kind_are_right(kind: str) -> None:
    made = statement(11, 0, (kind,))
    assert not label_fault(made), made.script()


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, 1000, 250))
def test_many_labels_are_right(start: int) -> None:
    for index in range(start, start + 250):
        made = statement(12, index)
        assert not label_fault(made), made.script()


def test_an_equation_has_its_text() -> None:
    t, c = ranged("t", sp.S.Zero, None), ranged("c", None, sp.Rational(-1, 2))
    xi = sp.Symbol("xi", real=True)
    unknown = sp.Function("U")(xi, t.symbol)
    left = unknown.diff(t.symbol) - c.symbol * unknown.diff(xi, 2)
    ranges = (SymbolRange(xi), t, c, ranged("b", None, None))
    given = RandomStatement(
        "by hand", Truth.TRUE, left, xi * c.symbol, (xi, t.symbol), ranges, unknown
    )
    made = given.text()
    assert (made.equations, made.solutions) == (("-c*u_xx + u_t",), ("u = c*x",))
    assert made.letters == (
        Letter("x"), Letter("t", Fraction(0)), Letter("c", None, Fraction(-1, 2))
    )  # fmt: skip


def test_an_equality_has_its_text_and_its_counterexample() -> None:
    ranges = (ranged("x", sp.S.Zero, sp.S.One),)
    (own,) = (made.symbol for made in ranges)
    point = {own: sp.Rational(2, 3)}
    made = RandomStatement(
        "by hand", Truth.FALSE, own, own**2, (own,), ranges, counterexample=point
    ).text()
    assert (made.equations, made.solutions) == (("-x**2 + u",), ("u = x",))
    assert made.counterexample == {"x": Fraction(2, 3)}

"""Catches: a tree whose meaning differs from the text's, and a text that differs from the tree."""

from fractions import Fraction

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from longwave.derive.algebra.formula_text import FormulaError, Parser, Vocabulary, tokens
from longwave.derive.algebra.formula_tree import (
    MINUS_ONE,
    Call,
    Derivative,
    FormulaTree,
    Name,
    Number,
    Power,
    Product,
    Sum,
    Unknown,
    formula_text,
    mapped,
    rational,
)

X, T, N = sp.symbols("x t n")
WORDS = Vocabulary(
    {"abs": (sp.Abs, 1), "sqrt": (sp.sqrt, 1), "beta": (sp.beta, 2)},
    {"x": X, "t": T, "n": N},
    {"u": sp.Function("u")(X, T), "q": sp.Function("q")(N, T)},
    {"k": sp.Symbol("k")},
    site=N,
)
x, k = Name("x"), Name("k")


def number(value: int | str) -> Number:
    return Number(Fraction(value))


def tree(text: str) -> FormulaTree:
    return Parser(text, tokens(text), WORDS, "formula").whole()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-x**2", Product((MINUS_ONE, Power((x, number(2)))))),
        ("2**-x", Power((number(2), Product((MINUS_ONE, x))))),
        ("x/k/2", Product((x, Power((k, MINUS_ONE)), Power((number(2), MINUS_ONE))))),
        ("x/k*2", Product((x, Power((k, MINUS_ONE)), number(2)))),
        ("x**k**2", Power((x, Power((k, number(2)))))),
        ("x - k*x", Sum((x, Product((MINUS_ONE, Product((k, x))))))),
        ("(x + k) + 1", Sum((Sum((x, k)), number(1)))),
        ("--x", x),
        ("x/-k", Product((x, Power((Product((MINUS_ONE, k)), MINUS_ONE))))),
        ("1e-3", number("1/1000")),
        ("0**0", Power((number(0), number(0)))),
        ("abs(x)", Call((x,), "abs")),
        ("u_xt", Unknown("u", ("x", "t"))),
        ("q[2+n-1]", Unknown("q", (), "n", 1)),
        ("q_t[n-1]", Unknown("q", ("t",), "n", -1)),
        ("diff(u*x, t, x, 2)", Derivative((Product((Unknown("u"), x)),), ("t", "x", "x"))),
    ],
)
def test_a_text_is_the_tree_that_was_typed(text: str, expected: FormulaTree) -> None:
    assert tree(text) == expected


def test_every_node_knows_its_place() -> None:
    found = {formula_text(node): node.at for node in tree("x + k*abs(u_x)").nodes()}
    assert found == {"x": 0, "k": 4, "u_x": 10, "abs(u_x)": 6, "k*abs(u_x)": 4, "x + k*abs(u_x)": 0}


def test_the_value_of_an_index_is_exact_and_of_numbers_alone() -> None:
    assert rational(tree("3/4 - 2*(1 - 1/8)")) == -1
    assert rational(tree("1/0")) is rational(tree("x - x")) is rational(tree("sqrt(4)")) is None
    with pytest.raises(FormulaError, match="expected a site such as n\\+1"):
        tree("q[n+n-n]")


def test_a_formula_is_put_in_the_place_of_a_name() -> None:
    images = {"x": tree("x + 1"), "k": tree("2")}

    def image(node: FormulaTree) -> FormulaTree | None:
        return images.get(node.name) if isinstance(node, Name) else None

    assert formula_text(mapped(tree("abs(x)**k - x"), image)) == "abs(x + 1)**2 + (-1)*(x + 1)"


LEAVES = st.sampled_from([x, k, Name("t"), Name("n"), Name("I"), Unknown("u", ("x",))]) | st.builds(
    number, st.sampled_from(["0", "1", "7", "5/3", "1/8"])
)


def _larger(inner: st.SearchStrategy[FormulaTree]) -> st.SearchStrategy[FormulaTree]:
    several = st.lists(inner, min_size=2, max_size=3).map(tuple)
    pairs = st.tuples(inner, inner)
    return st.one_of(
        several.map(Sum),
        several.map(Product),
        pairs.map(Power),
        st.builds(lambda part: Call((part,), "abs"), inner),
        st.builds(lambda pair: Call(pair, "beta"), pairs),
        st.builds(lambda part: Derivative((part,), ("x", "t")), inner),
    )


@settings(max_examples=100)
@given(st.recursive(LEAVES, _larger, max_leaves=12))
def test_a_text_of_a_tree_has_its_value(formula: FormulaTree) -> None:
    """Brackets that are not needed, and fractions, are the only things that may change."""
    again = tree(formula_text(formula))
    assert _plain(again) == _plain(formula)


def _plain(formula: FormulaTree) -> FormulaTree:
    value = rational(formula)
    if value is not None:
        return Number(value)
    return formula.made_of(tuple(map(_plain, formula.inner())))

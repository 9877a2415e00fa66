"""Formulas in text: bound as in Python, exact, never evaluated, wrong ones shown with a caret."""

import math
from dataclasses import replace
from typing import Any

import pytest
import sympy as sp
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from longwave.derive.algebra.bounded_building import (
    MOST_BITS,
    TooLarge,
    applied,
    power,
    product,
    total,
    without_sizes,
)
from longwave.derive.algebra.formula_expression import read_formula
from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.derive.algebra.formula_text import (
    DEEPEST,
    LONGEST,
    FormulaError,
    Vocabulary,
    tokens,
)

x, t = sp.symbols("x t", real=True)
n = sp.Symbol("n", integer=True)
k = sp.Symbol("k", positive=True)
u = sp.Function("u")(x, t)
q = sp.Function("q")(n, t)
NAMES = (
    "exp",
    "log",
    "sqrt",
    "sin",
    "cos",
    "tanh",
    "sech",
    "atan",
    "conjugate",
    "re",
    "im",
    "sign",
)
WORDS = Vocabulary(
    {"abs": (sp.Abs, 1), "beta": (sp.beta, 2)} | {name: (getattr(sp, name), 1) for name in NAMES},
    {"x": x, "t": t, "n": n},
    {"u": u, "q": q},
    {"k": k},
    site=n,
)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-x**2", -(x**2)),
        ("2**-x", 2 ** (-x)),
        ("2**3**2", sp.Integer(512)),
        ("-2**2", sp.Integer(-4)),
        ("x/k/2", x / (2 * k)),
        ("x/k*2", 2 * x / k),
        ("x - k - 1", x - k - 1),
        ("x - (k - 1)", x - k + 1),
        ("--x", x),
        ("-x*k", -x * k),
        ("2*-x", -2 * x),
        ("0.1", sp.Rational(1, 10)),
        (".5e-2", sp.Rational(1, 200)),
        ("105/169", sp.Rational(105, 169)),
        ("x**(1/4)", x ** sp.Rational(1, 4)),
        ("sqrt(x**2)", sp.Abs(x)),
        ("sqrt(k**2)", k),
        ("pi*I", sp.pi * sp.I),
        ("abs(u)**2", sp.Abs(u) ** 2),
        ("conjugate(u)", sp.conjugate(u)),
        ("beta(x, k)", sp.beta(x, k)),
        ("u_xxt", u.diff(x, 2, t)),
        ("diff(u*u_x, x)", u.diff(x) ** 2 + u * u.diff(x, 2)),
        ("diff(x**3, x, x)", 6 * x),
        ("diff(x**3, x, 2)", 6 * x),
        ("diff(u, t, x, 2)", u.diff(t, x, 2)),
        ("q[n+1] - q[ n ]", q.subs(n, n + 1) - q),
        ("q[-1+n]", q.subs(n, n - 1)),
        ("diff(q[n], t, t)", q.diff(t, 2)),
        ("q_t[n-1]", q.subs(n, n - 1).diff(t)),
    ],
)
def test_a_formula_is_read_as_in_python_and_exactly(text: str, expected: sp.Expr) -> None:
    assert read_formula(text, WORDS) == expected


@pytest.mark.parametrize(
    ("text", "column", "words"),
    [
        ("x + * t", 5, "expected a number, a name or '(', got '*'"),
        ("x + ", 5, "got the end"),
        ("(x", 3, "expected ')' for the '(' of column 1, got the end"),
        ("x)", 2, "expected an operator or the end, got ')'"),
        ("2x", 2, "expected an operator such as *, got 'x'"),
        ("x t", 3, "expected an operator such as *, got 't'"),
        ("k(x)", 1, "(write k*(...) for a product)"),
        ("sehc(x)", 1, "'sehc' (did you mean sech?)"),
        ("Tanh(x)", 1, "(did you mean tanh?)"),
        ("x + tan(x)", 5, "(did you mean tanh?)"),
        ("y", 1, "expected a known name, got 'y'"),
        ("u_xy", 1, "expected variables of u behind _ (x t), got 'u_xy'"),
        ("x + u_", 6, "got '_'"),
        ("__x", 1, "got '_'"),
        ("x__y", 2, "got '_'"),
        ("k_x", 1, "expected a name without _, got 'k_x'"),
        ("sin", 4, "expected '(' after the function sin, got the end"),
        ("sin(x, t)", 1, "expected 1 argument of sin, got 2"),
        ("beta(x)", 1, "expected 2 arguments of beta, got 1"),
        ("diff(u)", 1, "expected a variable in diff"),
        ("diff(u, k)", 1, "expected variables behind the first argument of diff, got k"),
        ("diff(q[n], n)", 1, "got n"),
        ("q", 2, "expected '[' after the lattice field q"),
        ("q[2*n]", 3, "expected a site such as n+1"),
        ("q[n+x]", 3, "expected a site such as n+1"),
        ("q[n+1/2]", 3, "expected a site such as n+1"),
        ("x^2", 2, "write ** for a power"),
        ("x²", 2, "got '\\xb2'"),
        ("х", 1, "got '\\u0445'"),
        ("x\x00", 2, "got '\\x00'"),
        ("u'", 2, "write u_x for a derivative"),
        ("1/0", 2, "denominators must not be 0"),
        ("log(0)", 1, "values must be finite"),
        ("9**9**9**9", 5, "exponents must be at most 1000"),
        ("9**999", 2, "numbers must have at most 301 digits"),
        ("1e999999", 1, "numbers must have at most 100 digits"),
        ("x**1001", 2, "exponents must be at most 1000"),
        ("exp(10**9*log(9))", 1, "at most 1000"),
        ("abs((x+I*t+1+I)**1000)", 1, "multiplied out"),
        ("x.real", 2, "got '.'"),
        ("lambda: 0", 1, "got 'lambda'"),
    ],
)
def test_an_error_names_the_place_and_what_was_expected(text: str, column: int, words: str) -> None:
    with pytest.raises(FormulaError) as caught:
        read_formula(text, WORDS, "equation")
    error = caught.value
    assert str(error).startswith("equation: ")
    assert str(error).endswith(f"(column {column})")
    assert words in str(error)
    assert "\n" not in str(error)
    line, caret = error.picture.split("\n")
    assert caret.index("^") - 4 == column - 1
    assert len(line) == len(text) + 4


def test_the_picture_of_a_long_text_is_cut_around_the_place() -> None:
    with pytest.raises(FormulaError) as caught:
        read_formula("x + " * 500 + "? + x" + " + x" * 500, WORDS)
    line, caret = caught.value.picture.split("\n")
    assert len(line) < 80
    assert line[caret.index("^")] == "?"
    assert caught.value.__notes__ == [caught.value.picture]


@pytest.mark.parametrize("opened", ["(", "-(", "sin(", "2**(", "diff(u, ", "q["])
def test_depth_is_limited_wherever_it_grows(opened: str) -> None:
    with pytest.raises(FormulaError, match=f"at most {DEEPEST} deep"):
        read_formula(opened * (LONGEST // len(opened)), WORDS)


def test_errors_of_depth_and_of_length_differ() -> None:
    assert read_formula("(" * (DEEPEST - 1) + "x" + ")" * (DEEPEST - 1), WORDS) == x
    assert read_formula(" + ".join(["x"] * 4000), WORDS) == 4000 * x
    assert read_formula("-" * 10_000 + "x", WORDS) == x
    with pytest.raises(FormulaError, match=f"at most {LONGEST} characters"):
        tokens("x" * (LONGEST + 1))


def test_no_number_is_ever_built_that_is_larger_than_the_limit() -> None:
    """Each power below 300 digits; their products, sums and powers would not be."""
    large = sp.Integer(9) ** 300
    for build in (
        lambda: product([large, large]),
        lambda: product([large, large, x]),
        lambda: power(large, sp.Integer(2)),
        lambda: power(large * x, sp.Integer(2)),
        lambda: total([1 / large, 1 / sp.Integer(7) ** 300]),
        lambda: power(sp.sqrt(2) * large, sp.Integer(3)),
        lambda: applied(sp.exp, [1000 * sp.log(large)]),
        lambda: applied(sp.exp, [sp.exp(sp.exp(sp.Integer(9)))]),
        lambda: power(sp.Integer(2), 10**6 * sp.log(3) / sp.log(2)),
    ):
        with pytest.raises(TooLarge):
            build()
    assert (9**300).bit_length() < MOST_BITS
    assert math.log10(2) * MOST_BITS > 300


ELEMENTARY = """exp log sqrt sin cos tan cot sec csc sinh cosh tanh coth sech csch asin acos atan
asinh acosh atanh sign conjugate re im"""
GRAMMAR = replace(
    WORDS,
    functions={name: (getattr(sp, name), 1) for name in ELEMENTARY.split()} | {"abs": (sp.Abs, 1)},
)
NUMBERS = st.fractions(min_value=-9, max_value=9, max_denominator=9).map(
    lambda f: sp.Rational(f.numerator, f.denominator)
)
LEAVES = NUMBERS | st.sampled_from(
    [x, t, n, k, u, q, u.diff(x), u.diff(x, 2, t), q.subs(n, n - 2), q.diff(t), sp.pi, sp.I]
)
EXPONENTS = st.sampled_from(
    [sp.Integer(2), sp.Integer(-1), sp.Integer(3), sp.S.Half, sp.Rational(-3, 4), k, n, -x]
)


def _combined(inner: st.SearchStrategy[sp.Expr]) -> st.SearchStrategy[sp.Expr]:
    pairs = st.tuples(inner, inner)
    functions = st.sampled_from([function for function, _ in GRAMMAR.functions.values()])
    return st.one_of(
        pairs.map(lambda p: p[0] + p[1]),
        pairs.map(lambda p: p[0] * p[1]),
        pairs.map(lambda p: p[0] - p[1]),
        pairs.map(lambda p: p[0] / p[1] if p[1] != 0 else p[0]),
        st.tuples(inner, EXPONENTS).map(lambda p: p[0] ** p[1] if p[0] != 0 else p[0]),
        st.tuples(functions, inner).map(lambda p: p[0](p[1])),
    )


def test_derivatives_are_printed_in_the_order_of_the_variables() -> None:
    assert formula_as_text(u.diff(t, x, x)) == "u_xxt"
    assert formula_as_text(q.subs(n, n + 1).diff(t)) == "q_t[n+1]"


def is_settled(expression: sp.Expr) -> bool:
    """Whether SymPy makes the same object from the parts: 1/(1 - I) is a (1 + I)/2 that it does
    not make again.
    """
    nodes = sp.preorder_traversal(expression)
    return all(not node.args or node.func(*node.args) == node for node in nodes)


@settings(max_examples=150)
@given(st.recursive(LEAVES, _combined, max_leaves=10))
@example(sp.Abs(x) ** 3)
@example(sp.E * sp.exp(-x) - sp.E**2)
@example(-(x + t) * u / 3)
@example((x - 1) / (2 * sp.sqrt(k)))
@example(sp.Rational(-3, 2) * u / (x + t))
@example(sp.S.Half / (x + t))
@example((u * u.diff(x)).diff(x, t))
@example(q.subs(n, n - 3).diff(t, 2) ** -2)
def test_a_printed_expression_is_read_back_as_the_same_object(expression: sp.Expr) -> None:
    assume(
        not expression.has(sp.zoo, sp.nan, sp.oo, sp.AccumBounds, sp.atan2)
        and is_settled(expression)
    )
    text = formula_as_text(expression)
    assert read_formula(text, GRAMMAR) == expression, text


@pytest.mark.parametrize("size", [sp.Abs, sp.sign, sp.re, sp.im])
def test_sizes_by_conjugates_have_the_same_values(size: Any) -> None:
    u, value = sp.Function("u")(sp.Symbol("x", real=True)), 3 + 4 * sp.I
    found = without_sizes(size(u))
    assert not found.has(size)
    assert complex(found.subs(u, value)) == pytest.approx(complex(size(value)))

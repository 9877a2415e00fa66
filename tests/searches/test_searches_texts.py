"""Statements in text: read and differentiated right, labelled right, and judged in balls."""

import random
from fractions import Fraction

import mpmath
import pytest
from flint import acb

from searches.texts import ball_judge
from searches.texts.ball_judge import CannotJudge, Judge, precision
from searches.texts.composition_statements import COMPOSED
from searches.texts.drafts import (
    Draft,
    Known,
    letter_of,
    shown_false,
    stay_under,
    transformed,
)
from searches.texts.rewordings import reworded
from searches.texts.text_library import TEXT_KINDS, text_statement
from searches.texts.text_statement import Letter, TextStatement, Truth
from searches.texts.trees import derivative, put, read

LETTERS = ("x", "t", "k>0", "m:0:1")


def stated(equation: str, solution: str, *letters: str) -> TextStatement:
    made = tuple(letter_of(text) for text in letters or LETTERS)
    return TextStatement("by hand", Truth.TRUE, (equation,), (solution,), made)


def judged(equation: str, solution: str, **point: str) -> bool:
    values = {key: Fraction(text) for key, text in point.items()}
    return Judge(stated(equation, solution)).fails_at({"x": Fraction(1, 3), **values})


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-x**2", -9),
        ("2**-x", Fraction(1, 8)),
        ("2**x**2", 512),
        ("12/x/2", 2),
        ("12/x*2", 8),
        ("1 - 2 - x", -4),
        ("-(x - 1)*-x", 6),
        ("0.25*x", Fraction(3, 4)),
    ],
)
def test_a_text_is_read_as_it_is_meant(text: str, value: Fraction) -> None:
    found = Judge(stated(f"u - ({text})", "u = x"))
    (residual,) = found.residuals({"x": Fraction(3)}, 100)
    assert residual.contains(acb(3) - acb(value.numerator) / value.denominator)
    again = str(read(text))
    assert Judge(stated(f"{again} - ({text}) + 0*u", "u = x")).fails_at({"x": Fraction(3)}) is False


def test_what_is_no_formula_is_refused() -> None:
    for text in ("x +", "(x", "x)", "x ^ 2", "2 x", "sin(x"):
        with pytest.raises(ValueError, match=r"expected|grammar"):
            read(text)


FUNCTIONS = (
    *("exp(x)", "log(x)", "sqrt(x)", "sin(x)", "cos(x)", "tan(x)", "cot(x)", "sec(x)", "csc(x)"),
    *("sinh(x)", "cosh(x)", "tanh(x)", "coth(x)", "sech(x)", "csch(x)", "atan(x)", "asinh(x)"),
    *("asin(x)", "acos(x)", "atanh(x)", "acosh(1+x)", "x**k", "k**x", "abs(x)", "sign(x)*x"),
    *("jacobi_sn(x, m)", "jacobi_cn(x, m)", "jacobi_dn(x, m)", "1/(1+x**2)", "x**(1/3)"),
)


@pytest.mark.parametrize("text", FUNCTIONS)
def test_derivatives_of_trees_and_of_series_are_one(text: str) -> None:
    """Two ways to a second derivative that share no line."""
    tree = read(text)
    if not {"abs", "sign"} & {node.head for node in tree.nodes()}:
        slope = str(derivative(derivative(tree, "x"), "x"))
        assert not judged(f"u_xx - ({slope})", f"u = {text}", k="5/2", m="1/3")
        assert judged(f"u_xx - ({slope}) - 1/10**20", f"u = {text}", k="5/2", m="1/3")


@pytest.mark.parametrize("name", ["sn", "cn", "dn"])
def test_elliptic_values_are_mpmaths(name: str) -> None:
    value = mpmath.ellipfun(name, mpmath.mpf(1) / 3, m=mpmath.mpf(1) / 7)
    judge = Judge(stated(f"u - jacobi_{name}(x, m)", "u = 0"))
    (found,) = judge.residuals({"x": Fraction(1, 3), "m": Fraction(1, 7)}, 100)
    assert abs(float(found.real) + value) < 1e-15


@pytest.mark.parametrize(
    ("equation", "solution", "fails"),
    [
        ("u_x - 1", "u = sqrt(x**2)", False),
        ("u_x - 1", "u = -sqrt(x**2)", True),
        ("abs(u)**2 - 1", "u = exp(I*x)", False),
        ("abs(u)**2 - 1", "u = exp(x)", True),
        ("conjugate(u_x) + I*conjugate(u)", "u = exp(I*x)", False),
        ("re(u) - im(I*u)", "u = exp(2*I*x) + 3*I", False),
        ("diff(abs(u), x) - 1", "u = x*exp(I*x**2)", False),
        ("diff(u*u, x) = 2*u*u_x", "u = tan(x)", False),
        ("u - log(2)", "u = log(-2)", True),
        ("u - log(2) - I*pi", "u = log(-2)", False),
        ("u - 1", "u = tanh(1000 + x)", True),
        ("u - 1 - 1/10**700", "u = 1", True),
    ],
)
def test_a_residual_is_seen(equation: str, solution: str, fails: bool) -> None:
    assert judged(equation, solution) is fails


@pytest.mark.parametrize(
    "solution",
    [
        "u = 1/(x - 1/3)",
        "u = 1/(sin(x)**2 + cos(x)**2 - 1)",
        "u = log(sin(x)**2 + cos(x)**2 - 1)",
        "u = acosh(x)",
        "u = atanh(3 + x)",
        "u = abs(x - 1/3)",
        "u = log(exp(I*pi))",
        "u = sqrt(-x + I*(sin(x)**2 + cos(x)**2 - 1))",
        "u = jacobi_sn(x, 2)",
        "u = exp(exp(30 + x)) - exp(exp(30 + x))*cos(0*x)",
    ],
)
def test_of_what_is_not_certain_nothing_is_said(solution: str) -> None:
    with pytest.raises(CannotJudge):
        judged("u_x - u", solution)


def test_the_precision_is_put_back() -> None:
    from flint import ctx

    before = ctx.prec
    with pytest.raises(CannotJudge), precision(3 * before):
        raise CannotJudge("by hand")
    assert ctx.prec == before


# statements


@pytest.mark.parametrize("kind", TEXT_KINDS)
def test_a_text_statement_is_the_same_each_time_and_well_labelled(kind: str) -> None:
    """A true one that fails anywhere raises while it is made; a false one has its point."""
    for index in range(40):
        made = text_statement(kind, 5, index)
        assert made == text_statement(kind, 5, index)
        assert made.kind.startswith(kind)
        if made.truth is Truth.FALSE:
            point = made.counterexample
            assert point is not None
            assert all(letter.holds(point[letter.name]) for letter in made.letters)
            assert Judge(made).fails_at(point)
        if made.truth is Truth.VOID:
            with pytest.raises(CannotJudge):
                Judge(made).fails_at(made.point(random.Random(index)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", TEXT_KINDS)
def test_true_statements_hold_at_further_points(kind: str) -> None:
    for index in range(600):
        made = text_statement(kind, 6, index)
        for attempt in range(4 if made.truth is Truth.TRUE else 0):
            try:
                fails = Judge(made).fails_at(
                    made.point(random.Random(attempt)), ball_judge.BITS[:1]
                )
            except CannotJudge:
                continue
            assert not fails, made.script()


@pytest.mark.parametrize("entry", COMPOSED, ids=str)
def test_a_branch_holds_in_its_range(entry: object) -> None:
    """At both ends of the range, a little within."""
    assert isinstance(entry, type(COMPOSED[0]))
    low = -Fraction(9) if entry.low is None else entry.low
    high = Fraction(9) if entry.high is None else entry.high
    inner, value = (put(read(text), {"f": read("x")}) for text in (entry.inner, entry.value))
    outer = put(read(entry.outer, ("u",)), {"f": read("x")})
    made = stated(str(outer - value), f"u = {inner}", "x", "g")
    for x in (low + Fraction(1, 1000), (3 * low + high) / 4, high - Fraction(1, 1000)):
        assert not Judge(made).fails_at({"x": x, "g": Fraction(7, 5)}, (200,))


def test_a_known_solution_that_is_wrong_is_noticed() -> None:
    wrong = Known("u_x - u", "u = exp(2*x)", "x")
    draft = wrong.draft(random.Random(1))
    with pytest.raises(AssertionError, match="a true statement fails"):
        draft.statement("by hand", falsehood=0.0)


def test_symmetries_and_other_words_keep_the_truth() -> None:
    known = Known("u_t + 6*u*u_x + u_xxx", "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", "x t k>0")
    made = {known.draft(random.Random(seed)).statement("by hand", 0.0) for seed in range(40)}
    assert len({text.solutions for text in made if text is not None}) > 20
    formula = read("sin(2*x)**2 + exp(x + 1)*tanh(x)/cosh(x)")
    for seed in range(30):
        other = reworded(formula, random.Random(seed), 4)
        assert not judged(f"u - ({other})", f"u = {formula}")


def test_a_change_that_changes_nothing_is_dropped() -> None:
    assert shown_false(stated("u_x - 1", "u = x"), random.Random(1)) is None
    draft = Draft(random.Random(2))
    draft.letter("x")
    draft.equations, draft.solutions = [read("u_x - 1", ("u",))], {"u": read("x")}
    assert transformed(draft).solutions


def test_numbers_of_a_letter_lie_in_its_range() -> None:
    draw = random.Random(3)
    for text in ("k", "k>0", "k<0", "m:0:1", "n", "n>0", "n:-1:5"):
        letter = letter_of(text)
        numbers = [letter.number(draw) for _ in range(50)]
        assert all(letter.holds(number) for number in numbers)
        assert len(set(numbers)) > 1
    assert not Letter("n", integer=True).holds(Fraction(1, 2))


def test_a_letter_stays_under_another() -> None:
    draft = Draft(random.Random(4))
    draft.letter("x")
    draft.letter("a>0")
    difference = stay_under(draft, "a")
    draft.equations, draft.solutions = [read("u_x - 1", ("u",))], {"u": read("x") + difference}
    made = draft.statement("by hand", falsehood=0.0)
    assert made is not None
    assert made.parameters == "a1: a1>0; a: 0<a<a1"
    point = {**made.point(random.Random(5)), "a1": Fraction(1)}
    assert made.holds_at({**point, "a": Fraction(1, 2)})
    assert not made.holds_at({**point, "a": Fraction(2)})

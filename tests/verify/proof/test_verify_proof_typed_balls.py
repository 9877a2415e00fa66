"""Catches: a text that the prover evaluates differently from what was typed."""

import cmath
import itertools
import math
import random
import re
from fractions import Fraction

import pytest
from flint import acb

from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.text_prover import prove
from longwave.verify.proof.typed_balls import TypedBalls
from longwave.verify.proof.typed_values import TypedValues
from longwave.verify.verdict import Outcome
from searches.texts.ball_judge import CannotJudge, Judge
from searches.texts.text_library import TEXT_KINDS, text_statement
from searches.texts.text_statement import Truth

X, Y, A, N = Fraction(-7, 10), Fraction(13, 10), Fraction(3, 4), -3
POINT = {"x": X, "y": Y, "t": Fraction(1, 3), "a": A, "n": Fraction(N)}
x, y, a, n = float(X), float(Y), float(A), N


def ball(equation: str, formula: str, point: dict[str, Fraction] = POINT) -> acb:
    """Return the ball of the residual of an equation in u, or of u, at a point; n is a site."""
    if re.search(r"\bn\b", formula):
        equation, formula = equation.replace("u", "u[n]"), f"u[n] = {formula}"
    else:
        formula = f"u = {formula}"
    statement = read_statement(equation, formula)
    assert statement.trees is not None
    (found,) = TypedBalls(statement.trees, ()).residuals(point, 128)
    return found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-x**2", -(x**2)),
        ("2**-x", 2**-x),
        ("-2**x", -(2**x)),
        ("x**-2", x**-2),
        ("x**2**-1", cmath.sqrt(x)),
        ("2**3**2*x", 512 * x),
        ("y/x/a", y / x / a),
        ("y/x*a", y / x * a),
        ("y - x - a", y - x - a),
        ("y - (x - a)", y - x + a),
        ("--x", x),
        ("+x", x),
        ("x/-2", x / -2),
        ("1e-3*x", x / 1000),
        ("2.50*x", 2.5 * x),
        ("(I*x)**3", (1j * x) ** 3),
        ("sqrt(x)", cmath.sqrt(x)),
        ("sqrt(-2)*x", 1j * math.sqrt(2) * x),
        ("(x**2)**(1/2)", abs(x)),
        ("(x**3)**(1/3)", (complex(x) ** 3) ** (1 / 3)),
        ("(-8)**(2/3)*x", (-8 + 0j) ** (2 / 3) * x),
        ("(x*y)**a", cmath.exp(a * cmath.log(x * y))),
        ("x**a*y**a", cmath.exp(a * cmath.log(x)) * y**a),
        ("x**0", 1),
        ("0**0*x", x),
        ("log(x**2)", math.log(x**2)),
        ("log(x)", math.log(-x) + 1j * math.pi),
        ("log(exp(7*I*x))", cmath.log(cmath.exp(7j * x))),
        ("sqrt(I*I)*x", 1j * x),
        ("sign(x + I)**2", ((x + 1j) / abs(x + 1j)) ** 2),
        ("conjugate(conjugate(x + I))", x + 1j),
        ("conjugate(sqrt(x))", -1j * math.sqrt(-x)),
        ("abs(sqrt(x))", math.sqrt(-x)),
        ("re(log(x))*im(log(x))", math.log(-x) * math.pi),
        ("(-1)**n*x", -x),
        ("(-2)**(n/2)*x", cmath.exp(n / 2 * cmath.log(-2)) * x),
        ("(-2)**(2*n)", 4.0**n),
        ("(-1)**(n**2)", -1),
        ("(x - 1)**n", (x - 1) ** n),
        ("I**n", 1j**n),
        ("abs(n - 2)", 5),
        ("atan(tan(3*x))", math.atan(math.tan(3 * x))),
        ("asin(sin(3*x))", math.asin(math.sin(3 * x))),
        ("acosh(cosh(x))", abs(x)),
        ("I**x", cmath.exp(x * 0.5j * math.pi)),
    ],
)
def test_a_text_has_the_value_that_was_typed(text: str, expected: complex) -> None:
    found = ball("u", text)
    assert abs(complex(found) - expected) < 1e-12
    assert found.rad() < 1e-20


@pytest.mark.parametrize(
    ("equation", "formula", "expected"),
    [
        ("diff(abs(u), x)", "x", -1),
        ("u_xx", "abs(x**3)", -6 * x),
        ("diff(sign(u), x)", "x", 0),
        ("diff(u*u_x, x)", "x**2*y", 6 * x**2 * y**2),
        ("diff(u, x, y)", "sin(x*y)", math.cos(x * y) - x * y * math.sin(x * y)),
        ("diff(u, x, 2)", "x**a", a * (a - 1) * cmath.exp((a - 2) * cmath.log(x))),
        ("u_x", "conjugate((x + I*y)**2)", 2 * (x - 1j * y)),
        ("u_x", "abs(x + I)", x / math.sqrt(1 + x**2)),
        ("u_xxx", "tan(x)", (2 + 4 * math.sin(x) ** 2) / math.cos(x) ** 4),
    ],
)
def test_derivatives_are_those_of_what_was_typed(
    equation: str, formula: str, expected: complex
) -> None:
    assert abs(complex(ball(equation, formula)) - expected) < 1e-12


@pytest.mark.parametrize("kind", TEXT_KINDS)
@pytest.mark.parametrize("index", range(12))
def test_the_judge_of_the_searches_finds_the_same_residuals(kind: str, index: int) -> None:
    """The judge shares no code with the prover: it has its own parser, series and functions."""
    draws = (text_statement(kind, 77, number) for number in itertools.count(10 * index))
    given = next(drawn for drawn in draws if drawn.truth is not Truth.VOID)
    point = given.point(random.Random(index))
    texts = list(given.equations), list(given.solutions), given.parameters, given.domain
    stated = read_statement(*texts)
    assert stated.trees is not None
    integers = {str(s) for s, domain in stated.domains.items() if domain.integer}
    try:
        others = list(Judge(given).residuals(point, 200))
    except (CannotJudge, ArithmeticError, ValueError):
        with pytest.raises((ArithmeticError, ValueError)):
            list(TypedBalls(stated.trees, integers).residuals(point, 200))
        return
    own = TypedBalls(stated.trees, integers).residuals(point, 200)
    assert all((a - b).contains(0) for a, b in zip(own, others, strict=True))


@pytest.mark.parametrize(("shift", "expected"), [("-2", 5), ("-3", 6), ("+1", 2), ("", 3)])
def test_a_formula_is_shifted_as_it_stands(shift: str, expected: int) -> None:
    statement = read_statement(f"u[n{shift}]", "u[n] = abs(n)", "", "n > 0")
    assert statement.trees is not None
    (found,) = TypedBalls(statement.trees, ()).residuals({"n": Fraction(N)}, 128)
    assert complex(found) == expected


@pytest.mark.parametrize(
    "formula",
    [
        *("log(x)/y", "1/x", "abs(x)", "sign(x)", "x**(1/2)", "x**a", "1/(sin(x)**2)"),
        *(
            "log(-1 + I*x**3)",
            "sqrt(-1 + I*x)",
            "atan(I*(2 + x**2))",
            "acosh(x)",
            "elliptic_k(1+y)",
        ),
        *("jacobi_theta(x, y)", "jacobi_zeta(y, 1 + x**2)", "lambert_w(-1)*y"),
    ],
)
def test_nothing_is_said_at_a_point_that_is_not_smooth(formula: str) -> None:
    """The points x = 0 are poles, branch points, or may lie on a branch cut."""
    statement = read_statement("u - 5", f"u = {formula}")
    assert statement.trees is not None
    point = {**POINT, "x": Fraction(0)}
    assert TypedValues(statement.trees, {}).fails_at(point) is None


@pytest.mark.parametrize(
    ("equation", "formula", "parameters", "domain", "outcome"),
    [
        ("u + x**2", "-x**2", "", "", Outcome.PROVED),
        ("u - x**2", "-x**2", "", "", Outcome.REFUTED),
        ("u*2**x - 1", "2**-x", "", "", Outcome.PROVED),
        ("+u - x/+2", "+(x - -x**+1)/4", "", "", Outcome.PROVED),
        ("u_x - 2", "diff(x**2, x)", "", "", Outcome.PROVED),
        ("u_x + 2", "diff(x**2, x)", "", "", Outcome.REFUTED),
        ("u - x/(a*b)", "x/a/b", "a: a>0; b: b>0", "", Outcome.PROVED),
        ("u - x/(a*b)", "x/a*b", "a: a>0; b: b>0", "", Outcome.REFUTED),
        ("u - x", "(x**2)**(1/2)", "", "", Outcome.REFUTED),
        ("u - abs(x)", "(x**2)**(1/2)", "", "", Outcome.PROVED),
        ("u - 2*log(x)", "log(x**2)", "", "", Outcome.REFUTED),
        ("u - 2*log(abs(x))", "log(x**2)", "", "", Outcome.PROVED),
        ("u - x**c*y**c", "(x*y)**c", "c: real", "x > 0, y > 0", Outcome.PROVED),
        ("u - x**c*y**c", "(x*y)**c", "c: 0<c<1", "", Outcome.REFUTED),
        ("diff(abs(u), x) - 1", "x", "", "", Outcome.REFUTED),
        ("diff(abs(u), x) - 1", "x", "", "x > 0", Outcome.PROVED),
        ("sqrt(u)**2 - u", "x + I", "", "", Outcome.PROVED),
        ("u - u", "x", "", "", Outcome.PROVED),
        ("u - u + x", "x", "", "", Outcome.REFUTED),
        ("u_x - 1", "x + 0*tanh(t)", "", "", Outcome.PROVED),
        ("u - 1", "1**n", "", "", Outcome.PROVED),
        ("u_t - u", "x*exp(t) + 0**2", "", "", Outcome.PROVED),
    ],
)
def test_the_verdict_is_on_what_was_typed(
    equation: str, formula: str, parameters: str, domain: str, outcome: Outcome
) -> None:
    site = "[n]" if formula == "1**n" else ""
    text = f"u{site} = {formula}"
    equation = equation.replace("u", f"u{site}") if site else equation
    found = prove(equation, text, parameters=parameters, domain=domain)
    assert found.outcome is outcome, found.detail
    if outcome is Outcome.PROVED:
        assert found.certificate is not None
        assert found.certificate["statement"]["solutions"] == [text]
        assert found.certificate["statement"]["equations"] == [equation]


@pytest.mark.parametrize("text", ["(x - x)*log(x - x)", "x/(x - x)", "log(0)*0"])
def test_what_is_defined_nowhere_has_no_verdict_but_a_refusal(text: str) -> None:
    with pytest.raises(ValueError, match=r"finite|must not be 0"):
        prove("u", f"u = {text}")


@pytest.mark.parametrize(
    "text", ["0*log(sin(x)**2 + cos(x)**2 - 1)", "0/(cosh(x)**2 - sinh(x)**2 - 1)"]
)
def test_what_is_seen_to_be_undefined_only_by_a_proof_is_not_proved(text: str) -> None:
    assert prove("u", f"u = {text}").outcome is Outcome.UNDECIDED

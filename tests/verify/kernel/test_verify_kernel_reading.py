"""Texts of the grammar as nodes: what is read is what stands there."""

import pytest
from flint import fmpq

from verify.kernel import CertificateError
from verify.kernel.node_balls import Balls
from verify.kernel.nodes import Nodes
from verify.kernel.reading import Scope, formula, rational
from verify.kernel.statement import read_statement

POINT = {"x": fmpq(3, 7), "t": fmpq(-2, 5), "n": fmpq(3), "k": fmpq(5, 2)}


def scope_of(*unknowns: str) -> Scope:
    scope = Scope(Nodes())
    scope.variables = [scope.declare(v, "integer" if v == "n" else "real") for v in "nxt"]
    scope.unknowns = list(unknowns)
    return scope


def value(text: str) -> complex:
    scope = scope_of()
    node = formula(scope, text)
    symbols = {place: POINT[name] for name, place in scope.known.items()}
    ball = Balls(scope.nodes, symbols).ball(node)
    return complex(float(ball.real.mid()), float(ball.imag.mid()))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("-x**2", -((3 / 7) ** 2)),
        ("2**3**2", 512),
        ("2**-1", 0.5),
        ("1 - 2 - 3", -4),
        ("8/4/2", 1),
        ("8/(4/2)", 4),
        ("-x*-t", 3 / 7 * -2 / 5),
        ("x/t*t", 3 / 7),
        ("1/2*x", 3 / 14),
        ("x - t + 1", 3 / 7 + 2 / 5 + 1),
        ("x/x", 1),
        ("0.5*x", 3 / 14),
        ("2e-1", 0.2),
        ("(-1)**n", -1),
        ("(-1)**(n + 1)", 1),
        ("(-2)**n", -8),
        ("2**n", 8),
        ("x**n", (3 / 7) ** 3),
        ("sqrt(4)", 2),
        ("(-8)**(1/3)", 1 + 1j * 3**0.5),
        ("abs(-3)", 3),
        ("exp(I*pi)", -1),
        ("x**-n", (7 / 3) ** 3),
        ("conjugate(1 + I)", 1 - 1j),
    ],
)
def test_a_text_has_its_value(text: str, expected: complex) -> None:
    assert abs(value(text) - expected) < 1e-12


@pytest.mark.parametrize(
    "text",
    [
        *("", "x +", "(x", "x)", "x y", "2x", "sin x", "f(x)", "sin(x, t)", "x ^ 2", "x;t"),
        *("0**k", "x**1001", "x**(1/1001)", "9" * 2001, "(" * 61 + "x" + ")" * 61, "#0", "u_z"),
        *(
            "u[n+1/2]",
            "u[x]",
            "u[n+1001]",
            "u[n*2]",
            "u[n, 1, 2, 3]",
            "diff(u, k)",
            "exp",
            "\u0661",
        ),
        *("v[n]", "diff(u)", "u_" + "x" * 13, "1e9999", "\ud800", "x" * 61),
    ],
)
def test_what_is_not_of_the_grammar_is_refused(text: str) -> None:
    with pytest.raises(CertificateError):
        formula(scope_of("u"), text)


def test_a_formula_must_be_text() -> None:
    with pytest.raises(CertificateError, match="must be text"):
        formula(scope_of(), 3)


def test_numbers_are_exact() -> None:
    assert [rational(text) for text in ("0.1", "1.", ".5", "2e3", "10")] == [
        fmpq(1, 10),
        fmpq(1),
        fmpq(1, 2),
        fmpq(2000),
        fmpq(10),
    ]


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("u_xt", "diff(u, t, x)"),
        ("u[n+1]", "u[n+1, x, t]"),
        ("u", "u[n]"),
        ("x*t", "t*x"),
        ("x/2", "1/2*x"),
        ("u[n-1]", "u[-1+n]"),
        ("+x - +-t", "x + t"),
        ("x**+2", "x**2"),
    ],
)
def test_two_texts_of_one_node(text: str, other: str) -> None:
    scope = scope_of("u")
    assert formula(scope, text) == formula(scope, other)


@pytest.mark.parametrize(
    ("text", "other"),
    [("u[n+1]", "u[n-1]"), ("u_x", "u_t"), ("x - t", "t - x"), ("x**t", "t**x"), ("x/t", "t/x")],
)
def test_two_texts_of_two_nodes(text: str, other: str) -> None:
    scope = scope_of("u")
    assert formula(scope, text) != formula(scope, other)


def statement(**parts: list[str]) -> dict[str, list[str]]:
    kept = {"variables": ["x", "t"], "equations": ["u_t + u_x"], "solutions": ["u = x - t"]}
    return {"parameters": [], "domain": [], **kept, **parts}


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"variables": []}, "1 to 8 variables"),
        ({"variables": ["x", "x"]}, "two things"),
        ({"variables": ["x t"]}, "must be names"),
        ({"variables": ["sin"]}, "two things"),
        ({"variables": ["x", "t", "z"], "parameters": ["z: complex"]}, "real or integers"),
        ({"equations": []}, "1 to 8 equations"),
        ({"equations": ["x"]}, "does not contain the unknown"),
        ({"solutions": []}, "1 to 8|does not contain|means"),
        ({"solutions": ["u = x", "u = t"]}, "two solutions"),
        ({"solutions": ["u_x = x"]}, "name|unknown"),
        ({"solutions": ["u[x+1, t] = x"]}, "at its own variables"),
        ({"solutions": ["u = u_x"]}, "without derivatives"),
        ({"solutions": ["u = x t"]}, "the end"),
        ({"solutions": ["pi = x"]}, "means two things"),
        ({"solutions": ["x = x"]}, "means two things"),
        ({"parameters": ["k"]}, "name: domain"),
        ({"parameters": ["k: k"]}, "an inequality"),
        ({"parameters": ["k: k>0", "k: integer"]}, "two kinds"),
        ({"parameters": ["k: real, integer"]}, "one kind"),
        ({"parameters": ["k = x", "k = t"]}, "name: domain"),
        ({"parameters": ["k: k>0", "k = t"]}, "two things"),
        ({"parameters": ["k = c", "c = t"]}, "no meaning at this place"),
        ({"parameters": ["k = x y"]}, "the end"),
        ({"parameters": ["u = x"]}, "two things"),
        ({"domain": ["t"]}, "an inequality"),
        ({"domain": ["u > 0"]}, "without derivatives"),
        ({"domain": ["t > 0 x"]}, "expected ,"),
        ({"domain": 3}, "must be a list"),
        ({"more": []}, "must have the parts"),
    ],
)
def test_a_statement_that_is_none(parts: dict[str, list[str]], message: str) -> None:
    with pytest.raises(CertificateError, match=message):
        read_statement(Nodes(), statement(**parts))


def test_a_domain_is_its_inequalities() -> None:
    nodes = Nodes()
    parameters = ["k: 0 < k <= 1", "m: integer, m>0", "p: positive", "q: negative", "r: r!=0"]
    found, scope = read_statement(nodes, statement(parameters=parameters, domain=["t >= x"]))
    zero, one = nodes.rational(0), nodes.rational(1)
    k, m, p, q, x, t = (scope.known[name] for name in "kmpqxt")
    assert list(found.domain) == [
        *((False, zero, k), (True, k, one), (False, zero, m), (False, zero, p)),
        *((False, q, zero), (True, x, t)),
    ]
    assert nodes.all[m][2] == "integer"

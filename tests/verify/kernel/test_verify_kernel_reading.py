"""Texts of the grammar as nodes: what is read is what stands there."""

import pytest
from flint import fmpq

from longwave.verify.kernel import CertificateError
from longwave.verify.kernel.node_balls import Balls
from longwave.verify.kernel.nodes import Nodes
from longwave.verify.kernel.reading import Scope, formula, rational
from longwave.verify.kernel.statement import read_statement, statement_text

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
            *("diff(u, 2)", "diff(u, x, 0)", "diff(u, x, 1/2)", "diff(u, x, 12, 2)"),
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
        ("u_txxx", "diff(u, t, x, 3)"),
        ("u_tt", "diff(u, t, 2, 1)"),
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


@pytest.mark.parametrize("text", ["x/0", "1/0*x", "0/0"])
def test_a_division_by_0_stands_as_it_is(text: str) -> None:
    scope = scope_of()
    inner = scope.nodes.all[formula(scope, text)]
    assert scope.nodes.add("Pow", scope.nodes.rational(0), fmpq(-1)) in inner


def test_a_power_of_0_or_of_a_negative_number_to_a_symbol() -> None:
    assert abs(value("(1/2)**n") - 1 / 8) < 1e-12
    assert abs(value("(-1/2)**n") + 1 / 8) < 1e-12
    assert abs(value("(-1/2)**(-n)") + 8) < 1e-12
    assert abs(value("(-2)**(2*n - 1)") + 32) < 1e-12
    scope = scope_of()
    assert scope.nodes.all[formula(scope, "(-1)**n")][0] == "parity"
    assert scope.nodes.all[formula(scope, "(1/2)**n")][0] == "power"
    assert scope.nodes.all[formula(scope, "(-1/2)**n")][0] == "Mul"
    assert scope.nodes.all[formula(scope, "(-1)**x")][0] == "power"
    with pytest.raises(CertificateError, match="0 must not be raised to a symbol"):
        formula(scope, "0**n")


def test_nodes_below_are_each_there_once_arguments_first() -> None:
    scope = Scope(Nodes())
    nodes, x = scope.nodes, scope.node("x")
    exp = nodes.add("exp", x)
    both = nodes.add("Add", x, exp)
    nodes.rational(7)
    assert list(nodes.below([])) == []
    assert list(nodes.below([x])) == [x]
    assert list(nodes.below([exp])) == [x, exp]
    assert list(nodes.below([exp, both])) == [x, exp, both]


def test_gaps_multiples_and_products_of_nodes() -> None:
    scope = scope_of()
    nodes = scope.nodes
    x, t, zero, one = (formula(scope, text) for text in ("x", "t", "0", "1"))
    minus = nodes.add("Mul", nodes.rational(-1), x)
    assert nodes.gap(zero, x) == x
    assert nodes.gap(x, zero) == nodes.negative(x) == minus
    assert nodes.gap(x, t) == nodes.add("Add", t, minus)
    assert nodes.times(1, x) == x
    assert nodes.product() == one
    assert nodes.product(x) == x
    assert nodes.multiple(formula(scope, "-3*x*t/2")) == (fmpq(-3, 2), nodes.product(x, t))
    assert nodes.multiple(x) == (1, x)
    assert nodes.multiple(nodes.rational(5)) == (5, one)
    assert nodes.terms(x) == (x,)
    assert nodes.terms(formula(scope, "x + t + x")) == tuple(sorted((x, x, t)))
    constants = {"pi + I": True, "x": False, "exp(2)": True, "n": False}
    for text, constant in constants.items():
        assert nodes.is_constant(formula(scope, text)) is constant


@pytest.mark.parametrize("sort", [("real", "x"), ("integer", "n")])
def test_a_variable_called_n_is_an_integer_where_nothing_else_is_said(
    sort: tuple[str, str],
) -> None:
    kind, name = sort
    parts = {"variables": [name], "equations": ["u"], "solutions": ["u = 1"]}
    found, scope = read_statement(Nodes(), statement(**parts))
    assert scope.nodes.all[found.variables[0]] == ("symbol", name, kind)
    other = {"real": "integer", "integer": "real"}[kind]
    found, scope = read_statement(Nodes(), statement(**parts, parameters=[f"{name}: {other}"]))
    assert scope.nodes.all[found.variables[0]] == ("symbol", name, other)


def test_a_statement_is_printed_as_it_was_typed_with_its_symbols() -> None:
    parts = statement(
        variables=["x", "n"],
        equations=["u_x - k*c", "v - f(x)"],
        solutions=["u =  k*c*x", "v = f(x)"],
        parameters=["k: 0 < k", "c = 2*k", "z: complex", "f: function", "m = 3"],
        domain=["x > 0", "x < 1"],
    )
    found, _ = read_statement(Nodes(), parts)
    assert statement_text(found, parts).splitlines() == [
        "equation: u_x - k*c; v - f(x)",
        "solution: u = k*c*x; v = f(x)",
        "where c = 2*k; m = 3",
        "for all real k, x; integer n; complex z; function f with k: 0 < k; z: complex; "
        "f: function; x > 0; x < 1, wherever the formulas are smooth",
    ]
    plain = statement()
    found, _ = read_statement(Nodes(), plain)
    assert statement_text(found, plain).splitlines() == [
        "equation: u_t + u_x",
        "solution: u = x - t",
        "for all real t, x, wherever the formulas are smooth",
    ]


def test_an_equation_is_its_left_side_less_its_right_side() -> None:
    nodes = Nodes()
    sides = ["u_t = -u_x", "u_t + u_x = 0", "u_t + u_x", "0 = u_t"]
    found, scope = read_statement(nodes, statement(equations=sides))
    whole, minus = formula(scope, "u_t + u_x"), formula(scope, "-u_t")
    assert found.equations[1:] == (whole, whole, minus)
    assert nodes.all[found.equations[0]][0] == "Add"
    with pytest.raises(CertificateError, match="expected the end"):
        read_statement(nodes, statement(equations=["u_t = u = x"]))


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("u[n+2]", (2, 0, 0)),
        ("u[n+2, x-1, t]", (2, -1, 0)),
        ("u[n, x, 3+t]", (0, 0, 3)),
        ("u[n]", (0, 0, 0)),
        ("u[n+1+1]", (2, 0, 0)),
        ("u[2+n-5]", (-3, 0, 0)),
    ],
)
def test_an_unknown_at_shifted_variables(text: str, parts: tuple[int, ...]) -> None:
    scope = scope_of("v", "u")
    assert scope.nodes.all[formula(scope, text)] == ("unknown", 1, parts)


@pytest.mark.parametrize("text", ["u[n+x]", "u[x, n, t]", "u[1]", "u[n+n]", "u[n+x+1]", "u[n, x]"])
def test_an_index_is_a_variable_plus_an_integer(text: str) -> None:
    with pytest.raises(CertificateError, match="an index"):
        formula(scope_of("u"), text)


@pytest.mark.parametrize(
    "name", ["u_", "u_k", "ubar", "ustar", "uconj", "udot", "uprime", "ux", "utxx", "u_bar"]
)
def test_a_name_that_reads_as_something_of_an_unknown(name: str) -> None:
    with pytest.raises(CertificateError, match=r"subscripts must be variables|reads as a"):
        formula(scope_of("u"), name)
    assert formula(scope_of("w"), name) >= 0


@pytest.mark.parametrize("name", ["uk", "u2", "uxk", "bar", "x_u", "uu"])
def test_a_name_that_reads_as_nothing_else(name: str) -> None:
    scope = scope_of("u")
    assert scope.nodes.all[formula(scope, name)] == ("symbol", name, "real")

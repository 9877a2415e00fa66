"""Statements in text: accepted forms, and errors with their position and reason."""

import pytest
import sympy as sp

from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.derive.algebra.formula_text import FormulaError
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.text_names import FUNCTIONS
from longwave.verify.proof.text_parts import RESERVED
from longwave.verify.proof.typed_statement import Statement

LINEAR, WAVE = "u_t + c*u_x", "u = sin(x - c*t)"


def domains(statement: Statement) -> dict[str, str]:
    return {str(symbol): domain.text(symbol) for symbol, domain in statement.domains.items()}


@pytest.mark.parametrize(
    ("parameters", "expected"),
    [
        ("", {}),
        ("c: real", {}),
        ("c: c>0", {"c": "0 < c"}),
        ("c: 0<c<1", {"c": "0 < c < 1"}),
        ("c: 1>c>=-1/2", {"c": "-1/2 <= c < 1"}),
        ("c: c<0", {"c": "c < 0"}),
        ("c: 0>c", {"c": "c < 0"}),
        ("c: c>-1, c<=2", {"c": "-1 < c <= 2"}),
        ("c: c!=0", {"c": "c real, c != 0"}),
        ("c: integer, c>0", {"c": "0 < c, integer"}),
        ("c: positive", {"c": "0 < c"}),
        ("c: pi < c < 4", {"c": "pi < c < 4"}),
        ("c: c + 1 > 0", {"c": "-1 < c"}),
        ("c: c + 1 > 2*c - 4", {"c": "c < 5"}),
        ("a: 0<a<1; c: a<c<2*a", {"a": "0 < a < 1", "c": "a < c < 2*a"}),
        ("a: a>0; b = a**2; c: c>b", {"a": "0 < a", "c": "a**2 < c"}),
    ],
)
def test_parameters_have_the_domains_that_are_stated(
    parameters: str, expected: dict[str, str]
) -> None:
    assert domains(read_statement(LINEAR, WAVE, parameters)) == expected


@pytest.mark.parametrize(
    ("domain", "expected"),
    [
        ("t > 0", {"t": "0 < t"}),
        ("t > 0; x < 1", {"t": "0 < t", "x": "x < 1"}),
        ("t > 0, t < 2", {"t": "0 < t < 2"}),
        ("x > 2*t; t > 1", {"t": "1 < t", "x": "2*t < x"}),
        ("-c < x < c", {"x": "-c < x < c"}),
        ("0 < t <= 1/c", {"t": "0 < t <= 1/c"}),
    ],
)
def test_variables_have_the_domains_that_are_stated(domain: str, expected: dict[str, str]) -> None:
    found = domains(read_statement(LINEAR, WAVE, "c: c>0", domain))
    assert found == expected | {"c": "0 < c"}


@pytest.mark.parametrize(
    ("domain", "expected"),
    [
        ("x + k > 0", {"x": "-k < x"}),
        ("0 >= x - k", {"x": "x <= k"}),
        ("x > 1 - k", {"x": "1 - k < x"}),
        ("k < -2*x", {"x": "x < -k/2"}),
        ("0 < x + k < 1", {"x": "-k < x < 1 - k"}),
        ("x + t > 0, t < 0", {"x": "-t < x", "t": "t < 0"}),
        ("k*x + t > 0", {"t": "-k*x < t"}),
        ("x > log(2)", {"x": "log(2) < x"}),
        ("x + log(2) > 0", {"x": "-log(2) < x"}),
        ("x > exp(k)", {"x": "exp(k) < x"}),
    ],
)
def test_inequalities_of_degree_1_are_solved_for_a_variable(
    domain: str, expected: dict[str, str]
) -> None:
    """Parameters in the inequalities need not be declared."""
    statement = read_statement(LINEAR, WAVE, "", domain)
    assert domains(statement) == expected
    assert statement.texts is not None
    assert list(statement.texts.domain) == [part.strip() for part in domain.split(",")]


def test_symbols_know_the_sign_that_their_domain_gives_them() -> None:
    signs = {"a": "a>0", "b": "b>=0", "c": "c<0", "d": "d<=0", "e1": "e1!=0", "f": "-1<f<1"}
    entries = "; ".join(f"{name}: {domain}" for name, domain in signs.items())
    formula = "u = x + " + " + ".join(signs)
    (formula,) = read_statement("u_x - 1", formula, entries).solutions.values()
    known = {str(s): s for s in formula.free_symbols}
    assert known["a"].is_positive
    assert known["b"].is_nonnegative
    assert known["b"].is_positive is None
    assert known["c"].is_negative
    assert known["d"].is_nonpositive
    assert known["e1"].is_nonzero
    assert known["f"].is_real
    assert known["f"].is_positive is None
    assert known["x"].is_real


def test_equations_and_solutions_stand_together_or_in_lists() -> None:
    together = read_statement("u_t + v_x ;; v_t = u_x", "u = x ;; v = -t")
    assert read_statement(["u_t + v_x", "v_t = u_x"], ["u = x", "v = -t"]) == together
    assert [formula_as_text(e) for e in together.equations] == ["u_t + v_x", "-u_x + v_t"]


def test_an_unknown_depends_on_every_variable_that_occurs() -> None:
    assert [str(v) for v in read_statement("u_x - 1", "u = x + t").variables] == ["x", "t"]
    assert [str(v) for v in read_statement("u_xz - 1", "u = x*z").variables] == ["x", "z"]


def test_lattice_fields_have_a_site() -> None:
    statement = read_statement("diff(q[n], t) - q[n+1]", "q[n] = exp(k*n + exp(k)*t)")
    (unknown,) = statement.solutions
    site, _ = statement.variables
    assert site.is_integer
    assert unknown.args == statement.variables
    assert read_statement("diff(q[n], t) - q[n+1]", "q = exp(k*n + exp(k)*t)") == statement


def test_every_function_of_the_grammar_is_read() -> None:
    for name, (function, arity) in FUNCTIONS.items():
        arguments = ("x", "m", "k")[:arity] if not name.startswith("elliptic") else ("m",)
        statement = read_statement("u_x", f"u = m*x*{name}({', '.join(arguments)})", "m: 0<m<1")
        (formula,) = statement.solutions.values()
        assert formula.has(function) or name in ("abs", "conjugate", "re", "im", "sqrt"), name


@pytest.mark.parametrize(
    ("texts", "column", "words"),
    [
        (
            ("u_x - integer", "u = integer*x"),
            5,
            "expected a name of its own, got 'integer' (rename",
        ),
        (("u_x - 1", "u = x", "real: real>0"), 1, "expected a name of its own, got 'real' (rename"),
        (("complex_x - 1", "complex = x"), 1, "expected an unknown such as u, got 'complex'"),
        (("u_t + ", WAVE), 7, "equation: expected a number, a name or '(', got the end"),
        (("", WAVE), 1, "equation: expected a formula, got the end"),
        (("u_t ;; ", WAVE), 8, "equation: expected a formula, got the end"),
        (("u_t = x = t", WAVE), 9, "expected an operator or the end, got '='"),
        (("c + 1", WAVE), 1, "expected an equation for u, got one without"),
        (("u_t + v_x", WAVE), 7, "expected a solution of the unknown v, got none"),
        (("u_t + q[n]", WAVE), 7, "expected a solution of the unknown q, got none"),
        (("u_t", "u"), 1, "solution: expected 'u = formula', got 'u'"),
        (("u_t", "u(x) = 1"), 2, "solution: expected '=' behind u, got '('"),
        (("y_x - y", "y = exp(x)"), 1, "unless others are named: --variables x"),
        (("u - 1", "x = 1"), 1, "unless others are named: --variables t"),
        (("u[n,m] - 1", "u[n,m] = 1"), 2, "write a row of a second one m as an unknown: v[n]"),
        (("u[n+1,m] - 1", "u = 1"), 6, "write a row of a second one m as an unknown: v[n]"),
        (("u_t", "x = 1"), 1, "expected an unknown such as u, got 'x'"),
        (("u_t", "u = x + u"), 9, "expected a formula without unknowns, got 'u'"),
        (("u_t + v_t", "u = v ;; v = x"), 5, "expected a formula without unknowns, got 'v'"),
        (("u_t", "u = x ;; u = t"), 10, "expected one solution of u, got another"),
        (("u_t", "u = x ;; v = t"), 10, "expected an unknown of the equations, got v"),
        (("u_t", "u = i*x"), 5, "'i' (write I for the imaginary unit)"),
        (("u_t", "u = E**x"), 5, "'E' (write exp(1))"),
        (("u_t", "u = K*x", "k: k>0"), 5, "'K' (did you mean k?)"),
        (("u*u_t", "u = sehc(x)"), 5, "(did you mean sech?)"),
        (("u_t", "u = k*x", "k: k>0; k: k<1"), 9, "expected each parameter once, got 'k' again"),
        (("u_t", "u = x", "k: k>0"), 1, "expected a parameter that is used, got k"),
        (("u_t", "u = x", "u: u>0"), 1, "expected an unknown, got the parameter u"),
        (("u_t", "u = k*x", "k: 1<k<0"), 4, "expected a domain with inner points, got 1 < k < 0"),
        (("u_t", "u = k*x", "k: k>1, k<1"), 9, "expected a domain with inner points"),
        (("u_t", "u = k*x", "k: 0<k>1"), 4, "got signs both ways"),
        (("u_t", "u = k*x", "k: l>1"), 4, "expected a known name, got 'l'"),
        (("u_t", "u = k*x", "k: 1>0"), 4, "expected inequalities of k, as in 0<k<1"),
        (("u_t", "u = k*x", "k: whole"), 4, "expected a known name, got 'whole'"),
        (("u_t", "u = k*x", "k: I<k"), 4, "expected real bounds, got a complex one"),
        (("u_t", "u = k*x", "k: k!=1"), 4, "expected k!=0 alone"),
        (("u_t", "u = k*x", "k: k!=0<1"), 4, "expected k!=0 alone"),
        (("u_t", "u = k*x", "k > 0"), 3, "expected ': domain' or '= expression' behind k, got '>'"),
        (("u_t", "u = k*x", "k = k"), 5, "expected a known name, got 'k'"),
        (("u_t", "u = x", "x: x>0"), 1, "got the independent variable x"),
        (("u_t", "u = sin(x)", "sin: real"), 1, "expected a name of its own, got 'sin'"),
        (("u_t", "u = k1*x", "k_1: real"), 1, "(write k1 for k_1)"),
        (("u_t", "u = x", "", "x**2 > 1"), 1, "or sums with a multiple of x by a number, as in"),
        (("u_t", "u = x*c", "", "c*x > 1"), 1, "or sums with a multiple of x by a number, as in"),
        (("u_t", "u = x", "", "x + t != 0"), 1, "expected inequalities of x, as in 0<x<1"),
        (("u_t", "u = x", "", "x > u"), 5, "expected a variable or parameter, got the unknown u"),
        (("u_t", "u = x", "", "x + I > 0"), 1, "expected real bounds"),
        (("u_t", "u = x", "", "y > 0"), 1, "expected an inequality of a variable"),
        (("u_t", "u = k*x", "", "k > 0"), 1, "expected an inequality of a variable"),
        (("u_t", "u = x", "", "t > 0; t < 0"), 8, "expected a domain with inner points"),
        (("u_t", "u = x", "", "t > x; x > t"), 1, "ends must not depend on each other"),
        (("u_t", "u = k*x", "k: real", "t > 0 x > 0"), 7, "expected an operator such as *"),
        (("u_t + u_n", "u = n"), 1, "expected a lattice field such as u[n], got n without one"),
        (("q[n+1] - q", "q = n"), 11, "expected '[' behind the lattice field 'q'"),
        (("u_t - n", "u = n"), 1, "expected a lattice field such as u[n], got n without one"),
    ],
)
def test_what_is_wrong_is_named_and_pointed_at(
    texts: tuple[str, ...], column: int, words: str
) -> None:
    with pytest.raises(FormulaError) as caught:
        read_statement(*texts)
    error = caught.value
    assert words in str(error)
    assert str(error).endswith(f"(column {column})")
    assert "\n" not in str(error)
    assert error.picture.split("\n")[1].index("^") == 4 + column - 1


def test_a_domain_without_points_is_refused_where_only_sampling_shows_it() -> None:
    with pytest.raises(FormulaError, match="must hold rational points"):
        read_statement("u_t", "u = a*b*x", "a: a>1; b: a<b<1/a")


def test_a_name_that_is_declared_may_look_like_a_product() -> None:
    assert domains(read_statement("u_t", "u = ax*x", "ax: real")) == {}
    with pytest.raises(FormulaError, match=r"write a\*x"):
        read_statement("u_t", "u = ax*x")


@pytest.mark.parametrize("word", RESERVED)
def test_words_for_domains_are_no_parameters(word: str) -> None:
    """Catches: the line "for all real positive, x" with a parameter named positive."""
    with pytest.raises(FormulaError, match="expected a name of its own"):
        read_statement(f"u_x - {word}", f"u = {word}*x")


def test_decimals_are_exact() -> None:
    (formula,) = read_statement("u_x - 0.1", "u = 0.1*x").solutions.values()
    assert formula.coeff(next(iter(formula.free_symbols))) == sp.Rational(1, 10)

"""Catches: a verdict on SymPy's form of a text instead of the typed one."""

from fractions import Fraction

import pytest

from longwave.verify.proof.conditions import ConditionalVerdict
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import StatementVerdict
from longwave.verify.proof.text_prover import prove
from longwave.verify.proof.typed_statement import StatementTexts
from longwave.verify.proof.typed_values import TypedValues
from longwave.verify.verdict import Outcome

FALSE = [
    ("u_x", "u = sign(exp(I*x))**2", "", ""),
    ("u_x", "u = re((-2)**(j/2))*x", "j: integer", ""),
    ("u[n-2] - n + 2", "u[n] = abs(n)", "", "n > 0"),
    (
        "I*u_t + u_xx + 2*abs(u)**2*u",
        "u = a*sech(a*x)*exp(I*a**2*t)*sign(exp(I*x))**2",
        "a: a>0",
        "",
    ),
]
BORDER = {
    ("u[n+1] - 2*cosh(k)*u[n] + u[n-1]", "u[n] = exp(-k*abs(n))", "k: k>0", "n >= 0"): 0,
    (
        "I*diff(u[n],t) + u[n+1] + u[n-1]",
        "u[n] = exp(-k*abs(n) + 2*I*cosh(k)*t)",
        "k: k>0",
        "n >= 0",
    ): 0,
    ("u[n] - u[n-1] - 1", "u[n] = abs(n)", "", "n >= 0"): 0,
    ("u[n] - u[n-1] - 1", "u[n] = sqrt(n**2)", "", "n >= 0"): 0,
    ("u[n] - u[n-1] - 1", "u[n] = (n**4)**(1/4)", "", "n >= 0"): 0,
    ("u[n] - u[n-1] - 2**(n-1)", "u[n] = 2**abs(n)", "", "n >= 0"): 0,
    ("u[n+1] - 2*u[n] + u[n-1]", "u[n] = abs(n)", "", "n <= 0"): 0,
    ("u[n] - u[n-5] - 5", "u[n] = abs(n)", "j: integer, j>3", "n >= j"): 4,
}
"""Statements that fail at the first site of their domain alone, and that site."""

TRUE = [
    ("u[n-1] - abs(n-1) + u[n] - abs(n)", "u[n] = abs(n)", "", "n >= 0"),
    ("u[n-1] + u[n] - 1", "u[n] = abs(n)", "", "0 <= n <= 1"),
    ("abs(u)**2*sign(u)**2 - u**2", "u = x + I", "", ""),
    ("u[n-2] - abs(n-2)", "u[n] = abs(n)", "", "n > 0"),
    ("u_x - 2*x*sign(u)", "u = sqrt(x**4)", "", "x > 0"),
]

SIMPLIFIED = [
    ("u - pi*x", "u = sqrt(pi**2*x**2)", "", "x > 0"),
    ("u - abs(x)", "u = sqrt(x**2)", "", ""),
    ("u - x**a", "u = abs(x**a)", "a: real", "x > 0"),
    ("u_x", "u = sign(x)", "", "x > 0"),
    ("u_x + u/(2*abs(x))", "u = 1/sqrt(abs(x))", "", "x > 0"),
    ("u - 1/x", "u = sqrt(1/x**2)", "", "x > 0"),
    ("u - exp(x)", "u = sqrt(exp(2*x))", "", ""),
    ("u - sech(x)", "u = sqrt(sech(x)**2)", "", ""),
    ("u - jacobi_dn(x, m)", "u = sqrt(jacobi_dn(x, m)**2)", "m: 0<m<1", ""),
    ("u - 2", "u = abs(2*exp(I*x))", "", ""),
    ("u - (1 + x**2)", "u = abs(x + I)**2", "", ""),
    ("u - x", "u = log(exp(x))", "", ""),
    ("u - 1", "u = 1 + 0*tanh(k*(x - t))", "", ""),
    ("sqrt(u**2) - u", "u = sqrt(x**2)", "", ""),
    ("u[n+1] - abs(n+1)", "u[n] = sqrt(n**2)", "", ""),
    ("u[n-1] - abs(n - 1)", "u[n] = abs(n)", "", "n > 0"),
    ("abs(u)**2*sign(u)**2 - u**2", "u = x + I", "", ""),
    ("u_x - u*log(u)", "u = exp((1/2)*(a*exp(x/2)**2))**2", "a: real", ""),
    ("u[n+1] - r*u[n]", "u[n] = r**n", "r: r>0", ""),
    ("u[n+1] - u[n]**2", "u[n] = exp((3/5)*2**n)", "", ""),
    ("u[n+1] - u[n]", "u[n] = 1**n*exp((1 - 1)*t)", "", "t < 5"),
    ("log(u) - 2*log(abs(x - t))", "u = (x - t)**2", "", ""),
    ("diff(sinh(u), x) - 1", "u = asinh(x)", "", ""),
    ("u_x - u + u**(4 + 1)", "u = (1/(1 + exp(-4*x)))**(1/4)", "", ""),
    ("sqrt(1 - u**2) - cos(x)", "u = 2*sin(x/2)*cos(x/2)", "", "-3/2 < x, x < 3/2"),
    ("u_t + 6*u*u_x + u_xxx", "u = 2*diff(log(x**3 + 12*t), x, x)", "", ""),
    ("diff(abs(u), x, x) = diff(sqrt(2 + 2*cos(x)), x, x)", "u = 1 + exp(I*x)", "", ""),
    (
        "diff(u[n+1], t) - diff(u[n], t) - 2*a*sin((u[n+1] + u[n])/2)",
        "u[n] = 4*atan((-1)**n*exp(k*n + w*t))",
        "k: k>0; a: a>0; w = a*tanh(k/2)",
        "",
    ),
]


@pytest.mark.parametrize("texts", SIMPLIFIED)
def test_the_certificate_states_what_was_typed_where_sympy_simplifies_it(
    texts: tuple[str, str, str, str],
) -> None:
    equation, solution, parameters, domain = texts
    found = prove(equation, solution, parameters=parameters, domain=domain)
    assert isinstance(found, StatementVerdict)
    assert found.outcome is Outcome.PROVED
    (certificate,) = found.certificates
    assert certificate["statement"]["solutions"] == [solution]
    assert certificate["statement"]["equations"] == [equation]


@pytest.mark.parametrize("texts", FALSE)
def test_what_sympy_reads_as_a_solution_is_refuted_as_it_was_typed(
    texts: tuple[str, str, str, str],
) -> None:
    equation, solution, parameters, domain = texts
    found = prove(equation, solution, parameters=parameters, domain=domain)
    assert found.outcome is Outcome.REFUTED
    statement = read_statement(equation, solution, parameters, domain)
    assert statement.trees is not None
    typed = TypedValues(statement.trees, statement.domains)
    point = {name: Fraction(value) for name, value in (found.witness or {}).items()}
    assert typed.fails_at(point)


@pytest.mark.parametrize("texts", BORDER)
def test_the_first_site_is_looked_at_with_its_neighbours(texts: tuple[str, str, str, str]) -> None:
    equation, solution, parameters, domain = texts
    verdict = prove(equation, solution, parameters=parameters, domain=domain)
    assert verdict.outcome is Outcome.REFUTED
    assert verdict.witness is not None
    assert verdict.witness["n"] == str(BORDER[texts])


@pytest.mark.parametrize("first", ["n >= 1", "n >= 7/2"])
def test_a_modulus_is_known_at_all_sites_of_the_domain(first: str) -> None:
    verdict = prove("u[n] - u[n-1] - 1", "u[n] = abs(n)", domain=first)
    assert verdict.outcome is Outcome.PROVED


@pytest.mark.parametrize(
    "formula",
    [
        "jacobi_sn(I*x, m)",
        "jacobi_dn(x + I*t, m)",
        "jacobi_zeta(I*x, m)",
        "tanh(x + I*t*m)",
        "sech(x + I*m)",
    ],
)
def test_poles_off_the_real_axis_are_named(formula: str) -> None:
    verdict = prove(f"u - {formula}", f"u = {formula}", parameters="m: 0<m<1")
    assert verdict.outcome is Outcome.PROVED
    assert any(line.startswith("poles of") for line in verdict.singularities)


@pytest.mark.parametrize("texts", TRUE)
def test_an_identity_is_not_refuted_at_a_point_of_something_else(
    texts: tuple[str, str, str, str],
) -> None:
    equation, solution, parameters, domain = texts
    found = prove(equation, solution, parameters=parameters, domain=domain)
    assert found.outcome is not Outcome.REFUTED


@pytest.mark.parametrize(
    ("formula", "place"),
    [
        ("x + 0/y", "pole where y = 0"),
        ("x*log(y)/log(y)", "branch point where y is not positive"),
        ("x + 0*sqrt(y)", "branch point where y is not positive"),
    ],
)
def test_what_sympy_cancels_is_named_where_it_is_not_smooth(formula: str, place: str) -> None:
    found = prove("u_x - 1", f"u = {formula}")
    assert found.outcome is Outcome.PROVED
    assert place in found.singularities


def test_a_case_of_the_constants_is_no_proof_of_what_was_not_typed() -> None:
    found = prove("u_x + (b-1)*u", "u = sign(exp(I*x))**2", solve="b")
    assert (found.outcome, found.detail) == (Outcome.REFUTED, "holds for no value of b")


def test_a_case_of_the_constants_is_certified_in_its_own_words() -> None:
    ends = prove("u_xx + 2*u - 2*u**3", "u = jacobi_sn(x, m)", parameters="m: real", solve="m")
    assert isinstance(ends, ConditionalVerdict)
    (stated,) = [c["statement"] for case in ends.cases for c in case.verdict.certificates]
    assert (stated["solutions"], stated["parameters"]) == (["u = tanh(x)"], ["m = 1"])
    kink = "u = 4*atan(exp(k*x - w*t))"
    least = prove("u_tt - u_xx + sin(u)", kink, parameters="k: k>0; w: w>0", solve="w")
    assert isinstance(least, ConditionalVerdict)
    (stated,) = [c["statement"] for case in least.cases for c in case.verdict.certificates]
    assert stated["solutions"] == [kink]
    assert stated["parameters"] == ["w = sqrt(k**2 - 1)", "k: k>0", "k: 1 < k"]


@pytest.mark.parametrize(
    ("equation", "solution"),
    [
        ("u - 2", "u = elliptic_k(1 + x**2)"),
        ("u - 2", "u = elliptic_e(2)"),
        ("u_x - 2", "u = acosh(-2 - x**2)"),
    ],
)
def test_what_cannot_be_evaluated_is_not_refuted(equation: str, solution: str) -> None:
    assert prove(equation, solution).outcome is Outcome.UNDECIDED


def test_texts_are_kept_as_they_were_typed_part_by_part() -> None:
    statement = read_statement(
        "u_t + c*u_x ;; v_x  - 1.50", "u = exp(d*(x - c*t)); ; v = 1.5*x".replace("; ;", ";;"),
        "c: c>0; d = 2*c", "t>0",
    )  # fmt: skip
    assert statement.texts == StatementTexts(
        ("x", "t"),
        ("u_t + c*u_x", "v_x  - 1.50"),
        ("u = exp(d*(x - c*t))", "v = 1.5*x"),
        ("c: c>0", "d = 2*c"),
        ("t>0",),
    )


def test_a_text_without_values_says_nothing() -> None:
    statement = read_statement("u_x", "u = log(x)/log(x)*elliptic_k(2)", "", "")
    assert statement.trees is not None
    typed = TypedValues(statement.trees, {})
    assert typed.fails_at({"x": Fraction(1, 2)}) is None
    assert typed.failure() is None


@pytest.mark.parametrize("formula", ["atan(I)", "x*atan(I) + 1"])
def test_a_function_at_its_pole_is_refused_in_one_line(formula: str) -> None:
    with pytest.raises(ValueError, match="values must be finite"):
        prove("u_x", f"u = {formula}")


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("sqrt(-m)*abs(m)", "(-m)**(1/2)*abs(m)"),
        ("sqrt(-m)*sign(m)**2", "(-m)**(1/2)*sign(m)**2"),
        ("sqrt(m)*abs(m)/m", "abs(m)/m*m**(1/2)"),
    ],
)
def test_roots_and_moduli_of_a_complex_parameter(left: str, right: str) -> None:
    """Catches a search that has no conjugates, or takes abs(m) for m at a real sample point."""
    assert prove(f"u - {left}", f"u = {right}", parameters="m: complex").outcome == "PROVED"

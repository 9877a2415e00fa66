"""True statements that are PROVED, each with a near miss that is REFUTED."""

from __future__ import annotations

import re

import pytest

from longwave.derive.algebra.formula_text import FormulaError
from longwave.verify.kernel import check_certificate
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.text_prover import prove
from longwave.verify.verdict import Outcome


def outcome(equation: str, solution: str, **parts: str) -> str:
    """Return the outcome for a statement; check that no assumption mentions SymPy's reading."""
    verdict = prove(equation, solution, **parts)
    assert not any("what SymPy reads" in line for line in verdict.assumptions)
    return str(verdict.outcome)


VARIABLES = [
    ("u_tt - u_rr - 2*u_r/r", "u_tt - u_rr - u_r/r", "u = sin(r - t)/r", "r,t", ""),
    ("s**2*u_ss + s*u_s - u", "s**2*u_ss + s*u_s + u", "u = s - 1/s", "s", "s>0"),
    ("u_pp - u_qq", "u_pp + u_qq", "u = exp(-(p - q)**2)", "p, q", ""),
    ("u_t - x*u_r", "u_t + x*u_r", "u = sin(r + x*t)", "t, r", ""),
    ("diff(u[n], s) - u[n+1]", "diff(u[n], s) - u[n-1]", "u = 2**n*exp(2*s)", "s", ""),
    ("u_rr", "u_rr - 1", "u = 2", "r, t", ""),
]


@pytest.mark.parametrize(("true", "false", "solution", "variables", "domain"), VARIABLES)
def test_variables_are_those_that_are_named(
    true: str, false: str, solution: str, variables: str, domain: str
) -> None:
    named = {"variables": variables, "domain": domain}
    assert outcome(true, solution, **named) == Outcome.PROVED
    assert outcome(false, solution, **named) == Outcome.REFUTED


def test_letters_that_are_not_named_are_parameters() -> None:
    statement = read_statement("u_r - x", "u = x*r", variables="r")
    assert list(map(str, statement.variables)) == ["r"]


@pytest.mark.parametrize(
    ("variables", "column"), [("r t", 3), ("rho", 1), ("r, r", 4), ("I", 1), ("r,", 1), ("3", 1)]
)
def test_names_of_variables_are_different_letters(variables: str, column: int) -> None:
    with pytest.raises(FormulaError, match=rf"variables: expected .* \(column {column}\)"):
        read_statement("u_r", "u = 1", variables=variables)


def test_a_variable_is_no_parameter() -> None:
    with pytest.raises(FormulaError, match="the independent variable r"):
        read_statement("u_r", "u = r", "r: r>0", variables="r")


COMPLEX = [
    ("u_t - c*u_xx", "u = exp(c*b**2*t + b*x)", "u = exp(c*b*t + b*x)"),
    ("u_xx + c*u", "u = sin(sqrt(c)*x)", "u = sinh(sqrt(c)*x)"),
    ("u_t + 6*u*u_x + u_xxx", "u = 2*c**2*sech(c*(x - 4*c**2*t))**2", "u = 2*c*sech(c*(x - t))**2"),
    ("u_x - conjugate(u_x)", "u = x**2", "u = c*x"),
    ("u_x - 2*c*u", "u = exp(2*c*x)", "u = abs(exp(c*x))**2"),
    ("u_x - c", "u = c*x", "u = re(c)*x"),
]


@pytest.mark.parametrize(("equation", "true", "false"), COMPLEX)
def test_parameters_may_be_complex(equation: str, true: str, false: str) -> None:
    assert outcome(equation, true, parameters=complex_names(equation + true)) == Outcome.PROVED
    assert outcome(equation, false, parameters=complex_names(equation + false)) == Outcome.REFUTED


def complex_names(texts: str) -> str:
    """Return the entries for b and c if they occur."""
    found = re.findall(r"(?<!\w)[bc](?!\w)", texts)
    return "; ".join(f"{name}: complex" for name in sorted({*found}))


def test_what_holds_for_real_values_alone_is_refuted_at_a_complex_one() -> None:
    real = prove("u - exp(2*c*x)", "u = abs(exp(c*x))**2")
    verdict = prove("u - exp(2*c*x)", "u = abs(exp(c*x))**2", parameters="c: complex")
    assert (real.outcome, verdict.outcome) == (Outcome.PROVED, Outcome.REFUTED)
    assert "I" in (verdict.witness or {})["c"]


def test_the_certificate_states_that_a_parameter_is_complex() -> None:
    verdict = prove("u_t - c*u_xx", "u = exp(c*t + x)", parameters="c: complex")
    assert verdict.certificate is not None
    assert "complex c" in check_certificate(verdict.certificate)
    assert verdict.assumptions[0].startswith("for all real t, x; complex c, ")
    assert any("c is not real" in line for line in verdict.singularities)


def test_a_complex_parameter_has_no_inequalities_and_is_not_solved_for() -> None:
    for parameters, solve in (("c: complex, c>0", ""), ("c: complex", "a")):
        with pytest.raises(FormulaError, match="complex"):
            read_statement("u_x - a*c", "u = a*c*x", parameters, solve=solve)


ANGLES = [
    ("u - pi", "u = 16*atan(1/5) - 4*atan(1/239)", "u = 16*atan(1/5) - 4*atan(1/238)", ""),
    ("u - pi/4", "u = atan(1/2) + atan(1/3)", "u = atan(1/2) + atan(1/4)", ""),
    ("u - pi/2", "u = asin(x) + acos(x)", "u = asin(x) - acos(x)", "-1<x<1"),
    ("u - pi/2", "u = asin(3/5) + asin(4/5)", "u = asin(3/5) + asin(3/4)", ""),
    ("u - pi/2", "u = atan(x) + atan(1/x)", "u = atan(x) + atan(2/x)", "x>0"),
    ("u + pi/2", "u = atan(x) + atan(1/x)", "u = atan(x) - atan(1/x)", "x<0"),
    ("u - 2*atan(x)", "u = asin(2*x/(1 + x**2))", "u = asin(x/(1 + x**2))", "-1<x<1"),
    ("u - 2*atan(x)", "u = acos((1 - x**2)/(1 + x**2))", "u = -acos((1 - x**2)/(1 + x**2))", "x>0"),
    ("u - atan(x)", "u = atan((1 + x)/(1 - x)) - pi/4", "u = atan((1 + x)/(1 - x))", "x<1"),
    ("u - atan(x)", "u = asin(x*(1 + x**2)**(-1/2))", "u = acos(x*(1 + x**2)**(-1/2))", ""),
    (
        "u - acos(x)",
        "u = 2*atan(sqrt((1 - x)/(1 + x)))",
        "u = atan(sqrt((1 - x)/(1 + x)))",
        "-1<x<1",
    ),
    ("u - asin(tanh(x))", "u = 2*atan(tanh(x/2))", "u = 2*atan(tanh(x))", ""),
    ("u - atan(sinh(x))", "u = 2*atan(exp(x)) - pi/2", "u = 2*atan(exp(x)) + pi/2", ""),
    ("u - x", "u = acosh(cosh(x))", "u = acosh(cosh(2*x))", "x>0"),
]


@pytest.mark.parametrize(("equation", "true", "false", "domain"), ANGLES)
def test_identities_of_inverse_functions(equation: str, true: str, false: str, domain: str) -> None:
    assert outcome(equation, true, domain=domain) == Outcome.PROVED
    assert outcome(equation, false, domain=domain) == Outcome.REFUTED


@pytest.mark.parametrize(
    ("true", "false", "formula", "domain"),
    [
        ("u - log(2) - I*pi", "u - log(2) + I*pi", "log(-2)", ""),
        ("u - log(x) - I*pi", "u - log(x) + I*pi", "log(-x)", "x>0"),
        ("u - log(x - 1) - I*pi", "u - log(x - 1)", "log(1 - x)", "x>1"),
    ],
)
def test_logarithms_of_what_is_negative(true: str, false: str, formula: str, domain: str) -> None:
    assert outcome(true, f"u = {formula}", domain=domain) == Outcome.PROVED
    assert outcome(false, f"u = {formula}", domain=domain) == Outcome.REFUTED


@pytest.mark.parametrize(
    ("formula", "domain", "wider"),
    [
        ("x + I*y", "x>0", "x>-1"),
        ("-(x + I*y)", "x<0", "x<1"),
        ("x + I", "x>0", ""),
    ],
)
def test_the_root_of_a_complex_square_has_a_positive_real_part(
    formula: str, domain: str, wider: str
) -> None:
    solution = f"u = sqrt(({formula.removeprefix('-')})**2)"
    assert outcome(f"u - ({formula})", solution, domain=domain) == Outcome.PROVED
    assert outcome(f"u - ({formula})", solution, domain=wider) == Outcome.REFUTED


def test_an_identity_of_angles_on_a_larger_domain_is_refuted() -> None:
    sums = "atan(x) + atan(y) - atan((x + y)/(1 - x*y))"
    assert outcome("u", f"u = {sums}", domain="0<x<1; 0<y<1") == Outcome.PROVED
    assert outcome("u", f"u = {sums}", domain="0<x<2; 0<y<2") == Outcome.REFUTED
    assert outcome("u", "u = asin(2*x/(1 + x**2)) - 2*atan(x)") == Outcome.REFUTED
    assert outcome("u - pi/2", "u = atan(x) + atan(1/x)") == Outcome.REFUTED


EXACT_VALUES = [
    ("u[n+2] - a**2*u[n]", "u[n+1] - a*u[n]", "u[n] = (-a)**n", "a: a>0"),
    ("u[n+1] + a*u[n]", "u[n+2] + a**2*u[n]", "u[n] = (-a)**n", "a: a>0"),
    ("u[n+2] + u[n]", "u[n+2] - u[n]", "u[n] = cos(pi*n/2)", ""),
    ("u[n+4] - u[n]", "u[n+3] - u[n]", "u[n] = sin(pi*n/2)", ""),
    ("u[n] - (-1)**n", "u[n] + (-1)**n", "u[n] = cos(pi*n)", ""),
    ("u[n] + (-1)**n", "u[n] - (-1)**n", "u[n] = cos(3*pi*(n + 1))", ""),
    ("u[n] - 1", "u[n] + 1", "u[n] = cos(2*pi*n)", ""),
    ("u[n]", "u[n] - 1", "u[n] = sin(pi*n)", ""),
    ("u[n]", "u[n] - 1", "u[n] = tan(pi*n)", ""),
    ("u[n+2] + u[n] - (-1)**n", "u[n+2] + u[n] - 1", "u[n] = cos(pi*n/2) + (-1)**n/2", ""),
    ("u - 1/2", "u - 1/3", "u = cos(pi/7) - cos(2*pi/7) + cos(3*pi/7)", ""),
    (
        "u - 1/2",
        "u + 1/2",
        "u = cos(pi/11) + cos(3*pi/11) + cos(5*pi/11) + cos(7*pi/11) + cos(9*pi/11)",
        "",
    ),
    (
        "u - jacobi_dn(x, m)",
        "u + jacobi_dn(x, m)",
        "u = sqrt(1 - m*jacobi_sn(x, m)**2)",
        "m: 0<m<1",
    ),
    (
        "u + jacobi_sn(x, m)",
        "u - jacobi_sn(x, m)",
        "u = jacobi_sn(x + 2*elliptic_k(m), m)",
        "m: 0<m<1",
    ),
    (
        "u - jacobi_cn(x, m)/jacobi_dn(x, m)",
        "u - jacobi_dn(x, m)/jacobi_cn(x, m)",
        "u = jacobi_sn(x + elliptic_k(m), m)",
        "m: 0<m<1",
    ),
]


@pytest.mark.parametrize(("true", "false", "solution", "parameters"), EXACT_VALUES)
def test_powers_of_the_negative_roots_of_unity_and_quarter_periods(
    true: str, false: str, solution: str, parameters: str
) -> None:
    assert outcome(true, solution, parameters=parameters) == Outcome.PROVED
    assert outcome(false, solution, parameters=parameters) == Outcome.REFUTED


SPECIAL = [
    ("u_x - 2*exp(-x**2)/sqrt(pi)", "u_x - exp(-x**2)/sqrt(pi)", "u = erf(x)", ""),
    ("u_t - u_xx", "u_t - 2*u_xx", "u = erf(x/(2*sqrt(t)))", "t>0"),
    ("u + erf(x)", "u - erf(x)", "u = erf(-x)", ""),
    ("abs(u) - u", "abs(u) + u", "u = 1 + erf(x)", ""),
    ("conjugate(u) - u", "conjugate(u) + u", "u = airy_ai(x) + erf(x)", ""),
    ("u_xx - x*u", "u_xx + x*u", "u = a*airy_ai(x) + b*airy_bi(x)", ""),
    ("I*u_t + u_xx + x*u", "I*u_t + u_xx - x*u", "u = airy_ai(-x)", ""),
    ("u_x - x*airy_bi(x)", "u_x - airy_bi(x)", "u = airy_bi_prime(x)", ""),
    ("u*exp(u) - x", "u*exp(2*u) - x", "u = lambert_w(x)", "x>0"),
    ("u_t + u*u_x", "u_t - u*u_x", "u = lambert_w(t*exp(x))/t", "t>0"),
]


@pytest.mark.parametrize(("true", "false", "solution", "domain"), SPECIAL)
def test_functions_that_are_known_by_their_differential_equations(
    true: str, false: str, solution: str, domain: str
) -> None:
    assert outcome(true, solution, domain=domain) == Outcome.PROVED
    assert outcome(false, solution, domain=domain) == Outcome.REFUTED


def test_the_branch_of_lamberts_function_is_named() -> None:
    verdict = prove("u_x*x*(1 + u) - u", "u = lambert_w(x)")
    assert verdict.singularities == ("branch point of lambert_w(x)",)
    assert outcome("u - x", "u = lambert_w(x*exp(x))") == Outcome.REFUTED


WAVES = {"u_tt - u_rr - u_r/r": "u_tt - u_rr - 2*u_r/r", "u_t - u_rr - u_r/r": "u_t - u_rr + u_r/r"}

BESSEL = [
    ("x**2*u_xx + x*u_x + (x**2 - a**2)*u", "u_x", "u = bessel_j(a, x) + b*bessel_y(a, x)", "x>0"),
    ("x**2*u_xx + x*u_x - (x**2 + a**2)*u", "u_x", "u = bessel_i(a, x) + b*bessel_k(a, x)", "x>0"),
    ("x*u_xx + u_x + x*u", "u_x", "u = bessel_j(0, x)", ""),
    ("u_x + bessel_j(1, x)", "bessel_j(1, x)", "u = bessel_j(0, x)", ""),
    ("u_x + bessel_k(1, x)", "u", "u = bessel_k(0, x)", "x>0"),
    ("u - 4*bessel_j(2, x)/x + bessel_j(3, x)", "bessel_j(3, x)", "u = bessel_j(1, x)", "x>0"),
    ("u - bessel_i(3/2, x) - bessel_i(1/2, x)/x", "u", "u = bessel_i(-1/2, x)", "x>0"),
    ("u + bessel_j(1, x)", "u", "u = bessel_j(-1, x)", ""),
    ("abs(u) - u", "u", "u = bessel_k(a, x)", "x>0"),
    ("conjugate(u) - u", "u", "u = bessel_j(2, x)", ""),
    ("I*u_t + u_xx + u_x/x - u/x**2", "u_x", "u = bessel_j(1, x)*exp(-I*t)", "x>0"),
]


@pytest.mark.parametrize(("equation", "change", "solution", "domain"), BESSEL)
def test_bessels_functions(equation: str, change: str, solution: str, domain: str) -> None:
    assert outcome(equation, solution, domain=domain) == Outcome.PROVED
    assert outcome(f"{equation} + {change}/10**30", solution, domain=domain) == Outcome.REFUTED


@pytest.mark.parametrize(
    ("equation", "solution"),
    [
        ("u_tt - u_rr - u_r/r", "u = bessel_j(0, k*r)*cos(k*t) + bessel_y(0, k*r)*sin(k*t)"),
        ("u_t - u_rr - u_r/r", "u = bessel_i(0, k*r)*exp(k**2*t) + bessel_k(0, k*r)*exp(k**2*t)"),
    ],
)
def test_bessels_functions_in_cylindrical_waves(equation: str, solution: str) -> None:
    parts = {"parameters": "k: k>0", "domain": "r>0", "variables": "r,t"}
    assert outcome(equation, solution, **parts) == Outcome.PROVED
    assert outcome(WAVES[equation], solution, **parts) == Outcome.REFUTED
    moved = outcome(equation, solution.replace("(0, k*r)", "(1, k*r)"), **parts)
    assert moved == Outcome.REFUTED


LATTICE = [
    ("diff(u[n], t) - (u[n-1] - u[n+1])/2", "u[n] = bessel_j(n, t)"),
    ("diff(u[n], t, t) - u[n-1] - u[n+1] + 2*u[n]", "u[n] = bessel_j(2*n, 2*t)"),
    ("diff(u[n], t) - u[n-1] - u[n+1] + 2*u[n]", "u[n] = exp(-2*t)*bessel_i(n, 2*t)"),
    ("I*diff(u[n], t) + u[n-1] + u[n+1]", "u[n] = I**n*bessel_j(n, 2*t)"),
]


@pytest.mark.parametrize(("equation", "solution"), LATTICE)
def test_bessels_functions_on_a_lattice(equation: str, solution: str) -> None:
    assert outcome(equation, solution) == Outcome.PROVED
    assert outcome(equation.replace("u[n-1]", "2*u[n-1]"), solution) == Outcome.REFUTED


WEIERSTRASS = [
    ("u_x**2 - 4*u**3 + g*u + h", "u", "u = weierstrass_p(x, g, h)"),
    ("u_xx - 6*u**2 + g/2", "u", "u = weierstrass_p(x, g, h)"),
    ("u_xx - 6*u**2", "u", "u = weierstrass_p(x - 3, 0, h)"),
    ("u_t + 6*u*u_x + u_xxx", "u_x", "u = c/6 - 2*weierstrass_p(x - c*t, g, h)"),
    ("u_x - weierstrass_p_prime(x, g, h)", "u", "u = weierstrass_p(x, g, h)"),
    ("u + weierstrass_p_prime(x, g, h)", "u", "u = weierstrass_p_prime(-x, g, h)"),
]  # fmt: skip


@pytest.mark.parametrize(("equation", "change", "solution"), WEIERSTRASS)
def test_weierstrass_function(equation: str, change: str, solution: str) -> None:
    assert outcome(equation, solution) == Outcome.PROVED
    assert outcome(f"{equation} + {change}/10**30", solution) == Outcome.REFUTED


def test_the_poles_of_weierstrass_function_are_named() -> None:
    verdict = prove("u_xx - 6*u**2 + g/2", "u = weierstrass_p(x, g, h)")
    assert verdict.singularities == ("poles of weierstrass_p(x, g, h)",)


THETA = [
    ("u_t - u_xx", "u_xx", "u = jacobi_theta_3(x, exp(-4*t))", "t>0"),
    ("u_t - u_xx", "u", "u = jacobi_theta_1(x, exp(-4*t)) + a*jacobi_theta_2(x, exp(-4*t))", "t>0"),
    ("u_t - u_xx", "u", "u = 2*jacobi_theta_4(x, exp(-4*t))", "t>0"),
    ("u + jacobi_theta_1(x, q)", "u", "u = jacobi_theta_1(-x, q)", ""),
    ("conjugate(u) - u", "u", "u = jacobi_theta_4(x, q)", ""),
    ("4*q*t*u_t + q*u_xx", "u", "u = jacobi_theta_2(x, t)*q", "0<t<1"),
]


@pytest.mark.parametrize(("equation", "change", "solution", "domain"), THETA)
def test_theta_functions(equation: str, change: str, solution: str, domain: str) -> None:
    parts = {"parameters": "q: 0<q<1", "domain": domain}
    if "q" not in equation + solution:
        del parts["parameters"]
    assert outcome(equation, solution, **parts) == Outcome.PROVED
    assert outcome(f"{equation} + {change}/10**30", solution, **parts) == Outcome.REFUTED


def test_a_nome_that_may_be_no_nome_is_left_undecided() -> None:
    verdict = prove("u_t - u_xx", "u = jacobi_theta_3(x, exp(-4*t))")
    assert verdict.outcome == Outcome.UNDECIDED
    assert "which is not shown on the domain" in verdict.detail


ARBITRARY = [
    ("u_t + c*u_x", "u_x", "u = f(x - c*t)", ""),
    ("u_tt - c**2*u_xx", "u_xx", "u = f(x - c*t) + g(x + c*t)", ""),
    ("u_tt - u_xx - 2*u_x/x", "u_x/x", "u = (f(x - t) + g(x + t))/x", "x>0"),
    ("u_t + c*u_x + a*u", "u", "u = exp(-a*t)*f(x - c*t)", ""),
    ("u_x - t*diff(f(x), x) + 0*g(x)", "u", "u = t*f(x)", ""),
    ("u_x*u_xt - u_t*u_xx", "u", "u = f(x + g(t))", ""),
    ("abs(u)**2 - f(x)**2", "u", "u = f(x)*exp(I*g(t))", ""),
    ("u_xx + u_yy", "u", "u = f(x + I*y) + g(x - I*y)", ""),
    ("u*u_xt - u_x*u_t", "u", "u = f(x)*g(t)", ""),
    ("u[n+1] - u[n] - f(t) + 0*g(t)", "u[n]", "u[n] = n*f(t)", ""),
]


@pytest.mark.parametrize(("equation", "change", "solution", "domain"), ARBITRARY)
def test_arbitrary_functions(equation: str, change: str, solution: str, domain: str) -> None:
    names = [f"{name}: function" for name in "fg" if f"{name}(" in equation + solution]
    parts = {"parameters": "; ".join(names), "domain": domain}
    assert outcome(equation, solution, **parts) == Outcome.PROVED
    verdict = prove(f"{equation} + {change}/10**30", solution, **parts)
    assert verdict.outcome == Outcome.REFUTED
    assert verdict.witness is not None
    assert verdict.witness["f"] == "1/gamma(z + 13/97)"


@pytest.mark.parametrize(
    ("equation", "solution"),
    [
        ("u_xx - u", "u = f(x)"),
        ("u_xx + u", "u = f(x)"),
        ("u*u_xx - u_x**2", "u = f(x)"),
        ("abs(u) + u", "u = f(0)"),
        ("u - f(x)", "u = f(-x)"),
        ("u + f(x)", "u = f(-x)"),
        ("u - f(x)", "u = f(x + 1)"),
        ("u - f(x)", "u = f(abs(x))"),
    ],
)
def test_what_holds_for_some_functions_alone_is_refuted(equation: str, solution: str) -> None:
    assert outcome(equation, solution, parameters="f: function") == Outcome.REFUTED


def test_what_holds_for_the_function_that_is_tried_is_not_proved_of_all() -> None:
    assert outcome("abs(u) - u", "u = f(0)", parameters="f: function") == Outcome.UNDECIDED


@pytest.mark.parametrize(
    ("solution", "parts", "words"),
    [
        ("u = f(x) + f", {}, "expected '(' after the function f"),
        ("u = f(x, t)", {}, "expected 1 argument of f, got 2"),
        ("u = c*f(x)", {"solve": "c"}, "expected real parameters beside solve, got a function one"),
        ("u = x", {}, "expected a parameter that is used, got f"),
        ("f = x", {}, "expected an unknown, got the parameter f"),
    ],
)
def test_a_function_is_called_with_one_argument(
    solution: str, parts: dict[str, str], words: str
) -> None:
    with pytest.raises(FormulaError, match=re.escape(words)):
        prove("u_x - 1", solution, parameters="f: function", **parts)


def test_a_name_that_means_a_function_and_a_number_is_refused() -> None:
    with pytest.raises(FormulaError, match="expected each parameter once"):
        prove("u_x - 1", "u = f(x)", parameters="f: function; f: real")

"""Verdicts on statements in text: correct, for all symbols, with a witness and a hint."""

import re
from dataclasses import replace
from fractions import Fraction
from unittest.mock import ANY

import mpmath
import pytest
import sympy as sp

import longwave
from longwave.verify.proof import check_certificate
from longwave.verify.proof.near_misses import near_misses, with_hint
from longwave.verify.proof.prover import prove as prove_expression
from longwave.verify.proof.statement_latex import statement_latex
from longwave.verify.proof.statement_problem import residual_of
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import (
    StatementVerdict,
    decide_statement,
    verified_sentence,
)
from longwave.verify.proof.stored_verdict import checked_again, verdict_record
from longwave.verify.proof.text_prover import prove
from longwave.verify.published import chosen

KDV, MKDV = "u_t + 6*u*u_x + u_xxx", "u_t + 6*u**2*u_x + u_xxx"
SOLITON = "u = 2*k**2*sech(k*(x - 4*k**2*t))**2"
NLS, BRIGHT = "I*u_t + u_xx + 2*abs(u)**2*u", "u = a*sech(a*x)*exp(I*a**2*t)"
GORDON, KINK = "u_tt - u_xx + sin(u)", "u = 4*atan(exp((x - c*t)/sqrt(1 - c**2)))"
TODA = "diff(q[n],t,t) - exp(q[n-1]-q[n]) + exp(q[n]-q[n+1])"
TODA_SOLITON = "q[n] = log((1+exp(2*k*(n-1)-2*b*t))/(1+exp(2*k*n-2*b*t)))"
GENERAL = "u = (c/2)**(1/g)*sech(g*sqrt(c)/2*(x - c*t))**(2/g)"
ZERO = "(sin(x)**2 + cos(x)**2 - 1)"
ZAKHAROV = "I*u_t + u_xx - u*v ;; v_tt - v_xx - diff(abs(u)**2, x, x)"
WAVE = "b*sech(b*x)*exp(I*b**2*t)"
THETA = "u[n+2]*u[n-2]*jacobi_theta(0, m)**2 - (u[n]*jacobi_theta(2*b, m))**2"
SHIFTED, BM = "u[n] = jacobi_theta(b*n, m)", "b: real; m: 0<m<1"
VOLTERRA = (
    "u[n] = b*jacobi_theta(0,m)/(jacobi_sn(2*d,m)*jacobi_theta(2*d,m))*jacobi_theta(d*(n+2)+b*t,m)"
    "*jacobi_theta(d*(n-1)+b*t,m)/(jacobi_theta(d*(n+1)+b*t,m)*jacobi_theta(d*n+b*t,m))"
)
CM = "c: -1<c<1; m: 0<m<1"
SYSTEM = "u_t + u*u_x + v_x ;; v_t + diff(u*v, x)"

EXAMPLES = [
    (KDV, SOLITON, "k: k>0", "", "PROVED"),
    (KDV, "u = 2*k**2*sech(k*(x + 4*k**2*t))**2", "k: k>0", "", "REFUTED"),
    ("u_t - u_xx", "u = exp(-x**2/(4*t))/sqrt(t)", "", "t > 0", "PROVED"),
    ("u_x - 1", "u = sqrt(x**2)", "", "", "REFUTED"),
    ("u_x - 1", "u = sqrt(x**2)", "", "x > 0", "PROVED"),
    (NLS, BRIGHT, "a: a>0", "", "PROVED"),
    (GORDON, KINK, "c: -1<c<1", "", "PROVED"),
    (TODA, TODA_SOLITON, "k: k>0; b = sinh(k)", "", "PROVED"),
    (SYSTEM, "u = x/t ;; v = a/t", "", "t > 0", "PROVED"),
    # and what is near to them
    ("u_t - u_xx", "u = exp(-x**2/(4*t))/t", "", "t > 0", "REFUTED"),
    (NLS, "u = a*sech(a*x)*exp(-I*a**2*t)", "a: a>0", "", "REFUTED"),
    (NLS, "u = a*sech(a*x)*exp(I*a**2*t)", "a: a<0", "", "PROVED"),
    ("I*u_t + u_xx + 2*u**2*conjugate(u)", BRIGHT, "a: a>0", "", "PROVED"),
    ("I*u_t + u_xx + 2*u**3", BRIGHT, "a: a>0", "", "REFUTED"),
    (GORDON, "u = 4*atan(exp((x - c*t)/sqrt(1 + c**2)))", "c: -1<c<1", "", "REFUTED"),
    (GORDON, "u = 4*atan(sqrt(1-w**2)/w*cos(w*t)/cosh(sqrt(1-w**2)*x))", "w: 0<w<1", "", "PROVED"),
    (TODA, TODA_SOLITON, "k: k>0; b = tanh(k)", "", "REFUTED"),
    (SYSTEM, "u = x/t ;; v = a*x/t", "", "t > 0", "REFUTED"),
    ("u_x - k*u/x", "u = x**k", "", "x > 0", "PROVED"),
    ("u_x - sign(x)", "u = abs(x)", "", "", "PROVED"),
    ("u_x - u/x", "u = sqrt(a**2*x**2)", "", "", "PROVED"),
    ("u_x - a", "u = sqrt(a**2*x**2)", "", "x > 0", "REFUTED"),
    ("u_x - a", "u = sqrt(a**2*x**2)", "a: a>0", "x > 0", "PROVED"),
    ("I*u_t + abs(u)**2*u", "u = exp(I*t/x**2)/x", "", "", "PROVED"),
    ("u[n+1] - u[n-1] ;; u[n]**2 - 1", "u[n] = (-1)**n", "", "", "PROVED"),
    ("u[n+1] - u[n]", "u[n] = (-1)**n", "", "", "REFUTED"),
    ("u_t + (g+1)*(g+2)*u**g*u_x + u_xxx", GENERAL, "c: c>0; g: g>0", "", "PROVED"),
    ("u_t + (g+1)*(g+3)*u**g*u_x + u_xxx", GENERAL, "c: c>0; g: g>0", "", "REFUTED"),
    ("u_x - asinh(sinh(u))", "u = exp(x)", "", "", "PROVED"),
    (GORDON, "u = 2*acos(tanh((x - c*t)/sqrt(1 - c**2)))", "c: -1<c<1", "", "PROVED"),
    (GORDON, "u = 2*asin(tanh((x - c*t)/sqrt(1 - c**2)))", "c: -1<c<1", "", "REFUTED"),
    (GORDON, "u = 2*asin(sqrt(m)*jacobi_sn((t-c*x)/sqrt(1-c**2), m))", CM, "", "PROVED"),
    (
        "u_tt - u_xx + sinh(u)",
        "u = 4*atanh(exp((x-c*t)/sqrt(1-c**2)))",
        "c: -1<c<1",
        "x<c*t",
        "PROVED",
    ),
    ("u_x*sqrt(x**2-1) - 1", "u = acosh(x)", "", "x>1", "PROVED"),
    ("sin(3*u)*(1+x**2)**(3/2) - 3*x + x**3", "u = atan(x)", "", "", "PROVED"),
    ("u_x - 1", "u = asin(sin(x))", "", "-3/2<x<3/2", "PROVED"),
    ("u_x - 1", "u = asin(sin(x))", "", "-2<x<2", "REFUTED"),
    (ZAKHAROV, f"u = sqrt(2)*{WAVE} ;; v = -2*b**2*sech(b*x)**2", "b: b>0", "", "PROVED"),
    (ZAKHAROV, f"u = 2*{WAVE} ;; v = -2*b**2*sech(b*x)**2", "b: b>0", "", "REFUTED"),
    ("diff(abs(u), x, x) = diff(sqrt(2 + 2*cos(x)), x, x)", "u = 1 + exp(I*x)", "", "", "PROVED"),
    ("u_xx = diff(sqrt(1 + x**2), x, x)", "u = abs(1 + I*x)", "", "", "PROVED"),
    ("diff(re(u), x) = -sin(x)", "u = exp(I*x)", "", "", "PROVED"),
    ("u_x - 0.12345*u", "u = exp(0.12345*x)", "", "", "PROVED"),
    (f"{THETA}*(1 - m*jacobi_sn(b*n,m)**2*jacobi_sn(2*b,m)**2)", SHIFTED, BM, "", "PROVED"),
    (f"{THETA}*(1 - m*jacobi_sn(b*n,m)**2*jacobi_sn(b,m)**2)", SHIFTED, BM, "", "REFUTED"),
    ("diff(u[n],t) - u[n]*(u[n+1] - u[n-1])", VOLTERRA, "m: 0<m<1; d: d>0; b: real", "", "PROVED"),
    ("log(u) - I*pi/2 - log(x)", "u = I*x", "", "x > 0", "PROVED"),
    ("log(u) - I*pi/2 - log(x)", "u = I*x", "", "x < 0", "REFUTED"),
    ("log(u) - I*x", "u = exp(I*x)", "", "-3 < x < 3", "PROVED"),
    ("log(u) - I*x", "u = exp(I*x)", "", "-4 < x < 4", "REFUTED"),
    ("log(u) - log(x) + log(t)", "u = x/t", "", "t > 0", "PROVED"),
    ("log(u) - log(x) + log(t)", "u = x/t", "", "t < 0", "REFUTED"),
    ("sign(u) - exp(I*x)", "u = exp(I*x)", "", "", "PROVED"),
    ("u - abs(x - t)", "u = t - x", "", "x < t", "PROVED"),
    ("u - abs(x - t)", "u = t - x", "", "x < 2*t", "REFUTED"),
    # what cancels while it is read must be defined
    (f"u - x*{ZERO}/{ZERO}", f"u = x*{ZERO}/{ZERO}", "", "", "UNDECIDED"),
    ("u_x - 1", f"u = x + log({ZERO}) - log({ZERO})", "", "", "UNDECIDED"),
    ("u_x - 1", "u = x*exp(x)/exp(x) + log(x) - log(x)", "", "", "PROVED"),
    ("u_t = u_xx + u_yy", "u = exp(-2*a**2*t)*sin(a*x)*cos(a*y)", "", "", "PROVED"),
]


@pytest.mark.parametrize(("equation", "solution", "parameters", "domain", "expected"), EXAMPLES)
def test_the_verdict_is_right(
    equation: str, solution: str, parameters: str, domain: str, expected: str
) -> None:
    verdict = prove(equation, solution, parameters=parameters, domain=domain)
    assert verdict.outcome == expected, verdict.detail
    assert isinstance(verdict, StatementVerdict)
    for certificate in verdict.certificates:
        assert check_certificate(certificate)
    assert len(verdict.certificates) == (equation.count(";;") + 1) * (expected == "PROVED")


def test_a_proof_names_all_parameters_even_those_that_cancel() -> None:
    solution, parameters = "u = x/t ;; v = a + c", "a: real; c: c>a"
    verdict = prove("u_t + u*u_x + v_x", solution, parameters=parameters, domain="t > 0")
    assert verdict.assumptions[0].startswith("for all real a, c, t, x with ")
    assert "c > a" in verdict.assumptions[0]
    assert "t > 0" in verdict.assumptions[0]
    assert not any("SymPy" in line for line in verdict.assumptions)


def test_a_witness_of_a_system_has_values_for_all_of_its_parameters() -> None:
    verdict = prove("u_x - 1 ;; v_x - k", "u = 2*x ;; v = k*x", parameters="k: real")
    assert set(verdict.witness or {}) == {"x", "k"}


def test_a_witness_is_a_whole_point_of_the_domain_at_which_the_residual_is_not_0() -> None:
    equation, solution = "diff(u, t) + v_x ;; v_t + x", "u = x*t ;; v = a*x - t"
    statement = read_statement(equation, solution, "a: 1<a<2", "x > 3*t; t > 0")
    verdict = decide_statement(statement)
    assert verdict.outcome == "REFUTED"
    assert verdict.witness is not None
    point = {name: Fraction(value) for name, value in verdict.witness.items()}
    assert set(point) == {"a", "t", "x"}
    assert 1 < point["a"] < 2
    assert 0 < 3 * point["t"] < point["x"]


@pytest.mark.parametrize(
    ("equation", "solution", "domain", "outcome"),
    [
        ("u_x - sign(x + c)", "u = abs(x + c)", "x + c > 0", "PROVED"),
        ("u_x - 1", "u = abs(x + c)", "x > 1 - c", "PROVED"),
        ("u_x - 1", "u = abs(x + c)", "x > -1 - c", "REFUTED"),
        ("u_x - 1", "u = abs(x)", "x > log(2)", "PROVED"),
        ("u_x - 1", "u = abs(x)", "x > -log(2)", "REFUTED"),
        ("u_x + 1", "u = abs(x - c*t)", "c*t - x > 0", "PROVED"),
    ],
)
def test_a_domain_is_that_of_its_text(
    equation: str, solution: str, domain: str, outcome: str
) -> None:
    assert prove(equation, solution, domain=domain).outcome == outcome


def test_poles_jumps_and_branch_points_are_named_whichever_way_it_is_proved() -> None:
    as_it_is = prove("u_x - sign(x)", "u = abs(x)")
    assert as_it_is.sides == "on each side of x = 0, nothing said across it"
    assert as_it_is.singularities == ()
    by_residual = prove("u_t + u*u_x + v_x", "u = x/t ;; v = log(t)")
    assert by_residual.outcome == "PROVED"
    assert "pole where t = 0" in by_residual.singularities
    assert "branch point where t is not positive" in by_residual.singularities


def test_what_cannot_be_taken_is_undecided_with_a_reason() -> None:
    for equation, solution in [
        ("conjugate(u) - log(x - I)", "u = log(x + I)"),
        ("u - pi/4", "u = 5*atan(1/7) + 2*atan(3/79)"),
    ]:
        verdict = prove(equation, solution)
        assert verdict.outcome == "UNDECIDED"
        assert verdict.detail
        assert "\n" not in verdict.detail


def test_a_system_is_proved_by_all_and_refuted_by_one_of_its_equations() -> None:
    verdict = prove("u_x - 1 ;; v_x - 1", "u = x ;; v = 2*x")
    assert (verdict.outcome, verdict.certificate) == ("REFUTED", None)
    assert verdict.detail.startswith("equation 2: ")


NOWHERE = "1/(sin(x)**2 + cos(x)**2 - 1)"


@pytest.mark.parametrize(
    ("equation", "solution"),
    [
        ("u_t - v_t", f"u = {NOWHERE} ;; v = {NOWHERE}"),
        ("u_x - v_x - 1", f"u = {NOWHERE} ;; v = {NOWHERE}"),
        ("(u_x - v_x)/(u**2 + w**2 - 1)", "u = sin(x) ;; w = cos(x) ;; v = sin(x)"),
        ("u_t - v_t", "u = log(sin(x)**2 + cos(x)**2 - 1) ;; v = t - t"),
        ("u_t - v_t - 1", "u = log(sin(x)**2 + cos(x)**2 - 1) ;; v = t - t"),
        ("u_t + sin(u)*0 - v_t", f"u = {NOWHERE} ;; v = x"),
    ],
)
def test_what_is_nowhere_defined_is_neither_proved_nor_refuted(
    equation: str, solution: str
) -> None:
    assert prove(equation, solution).outcome == "UNDECIDED"


def test_the_residual_has_the_formulas_at_shifted_sites() -> None:
    statement = read_statement("q[n+1]*q[n-1] - q_t[n+2]", "q = n**2*t")
    n, t = statement.variables
    shifted = (n + 1) ** 2 * t * (n - 1) ** 2 * t - (n + 2) ** 2
    assert sp.expand(residual_of(statement, statement.equations[0]) - shifted) == 0


ZAKHAROV = "I*E_t + E_xx - m*E ;; m_tt - m_xx - diff(abs(E)**2, x, 2)"
ZAKHAROV_SOLITON = (
    "E = sqrt(2*(1-v**2))*a*sech(a*(x-v*t))*exp(I*(v*x/2 + (a**2-v**2/4)*t)) ;; "
    "m = 2*a**2*sech(a*(x-v*t))**2"
)
TODA = "diff(q[n], t, 2) - exp(q[n+1] - q[n]) + exp(q[n] - q[n+1])"
TODA_SOLITON = "q[n] = log((1+exp(2*(k*n-sinh(k)*t)))/(1+exp(2*(k*(n+1)-sinh(k)*t))))"

HINTS = [
    (KDV, "u = 2*k**2*sech(k*(x + 4*k**2*t))**2", "k: k>0", "-4*k**2*t in the place of 4*k**2*t"),
    (KDV, "u = 2*k**2*sech(k*(x - 4*k*t))**2", "k: k>0", "-4*k**2*t in the place of -4*k*t"),
    (KDV, "u = 2*k**2*sech(k*(x - k**2*t))**2", "k: k>0", "-4*k**2*t in the place of -k**2*t"),
    (KDV, "u = k**2*sech(k*(x - 4*k**2*t))**2", "k: k>0", "2*k**2*sech"),
    (MKDV, "u = jacobi_dn(x - (2-k**2)*t, k)", "k: 0<k<1", "k**2 in the place of k as the param"),
    (MKDV, "u = jacobi_dn(x - (2-m)*t, m**2)", "m: 0<m<1", "m in the place of m**2 as the param"),
    (MKDV, "u = jacobi_dn(x - (2-m**2)*t, m)", "m: 0<m<1", "m**2 in the place of m as the param"),
    ("u_t - 6*u*u_x + u_xxx", SOLITON, "k: k>0", "-2*k**2*sech"),
    ("u_t + u*u_x + u_xxx", SOLITON, "k: k>0", "12*k**2*sech"),
    ("u_t + 6*u*u_x + u_xxx + u", SOLITON, "k: k>0", ""),
    (NLS, "u = a*sech(a*x)*exp(I*a*t)", "a: a>0", "I*a**2*t in the place of I*a*t"),
    ("I*u_t + u_xx + abs(u)**2*u", BRIGHT, "a: a>0", "2*abs(u)**2*u in the place of abs(u)**2*u"),
    (
        GORDON,
        "u = 4*atan(exp((x - c*t)/sqrt(1 + c**2)))",
        "c: -1<c<1",
        "-c**2 in the place of c**2",
    ),
    (ZAKHAROV, ZAKHAROV_SOLITON, "a: a>0; v: -1<v<1", ": m = -2*a**2*sech(a*(x - v*t))**2"),
    (TODA, TODA_SOLITON, "k: k>0", "q[n-1] in the place of q[n+1] in the equation: "),
    (GORDON, "u = 4*atan(exp((x - t/c)/sqrt(1 - c**2)))", "c: 0<c<1", "-t*c in the place of -t/c"),
    (KDV, "u = 2*k**2*sech(sqrt(k)*(x - 4*k**2*t))**2", "k: k>0", "k*(x - 4*k**2*t) in the place"),
    (KDV, "u = 2*k**3*sech(k*(x - 4*k**2*t))**2", "k: k>0", "2*k**2*sech"),
    (KDV, "u = 2*k**2*sech(k*x - c*t)**2", "k: k>0; c = 4*k**2", "4*k**3 in the place of 4*k**2"),
    ("diff(q[n], t) - q[n+1] + q[n]", "q = n + 1 - t", "", "t in the place of -t: q = n + 1 + t"),
]


@pytest.mark.parametrize(("equation", "solution", "parameters", "words"), HINTS)
def test_a_refuted_statement_comes_with_what_holds(
    equation: str, solution: str, parameters: str, words: str
) -> None:
    statement = read_statement(equation, solution, parameters)
    hint = with_hint(statement, decide_statement(statement)).hint
    assert words in hint
    assert bool(hint) == bool(words)


def test_what_substitution_does_not_prove_is_proved_by_its_residual() -> None:
    """Catches: a prover without the third way of deciding an equation."""
    (text,) = chosen(["gross_neveu_soliton"])
    verdict = decide_statement(text.problem().statement)
    assert verdict.outcome == "PROVED", verdict.detail
    assert len(verdict.certificates) == 2


def test_near_misses_are_each_tried_once_and_keep_the_names() -> None:
    statement = read_statement(MKDV, "u = jacobi_dn(x - (2-m)*t, m)", "m: 0<m<1")
    misses = near_misses(statement)
    assert len({(miss.texts.equations, miss.texts.solutions) for miss in misses}) == len(misses)
    for miss in misses:
        assert miss.trees.names == {"m", "t", "x"}
        assert miss.text in (miss.texts.solutions[0], f"{miss.texts.equations[0]} = 0")


FALSE_HINTS = [
    ("u_x + 1", "u = x*sign(exp(I*x))**2"),
    ("u_x - 1 + 0*t", "u = x*sign(exp(I*t))**2"),
    ("u_x - 2*u_x + u", "u = exp(-x)"),
    ("u_x - u + 0/x", "u = exp(-abs(x)*sign(exp(I*x))**2)"),
]


@pytest.mark.parametrize(("equation", "solution"), FALSE_HINTS)
def test_a_hint_is_proved_of_the_changed_text(equation: str, solution: str) -> None:
    """Catches: hints for SymPy's form of a text, and for a trivial equation."""
    statement = read_statement(equation, solution)
    found = with_hint(statement, decide_statement(statement))
    assert found.outcome == "REFUTED"
    assert bool(found.hint) == bool(found.hint_certificates)
    assert "2*u_x - 2*u_x" not in found.hint
    for certificate in found.hint_certificates:
        text = (*certificate["statement"]["equations"], *certificate["statement"]["solutions"])
        assert found.hint.rpartition(": ")[2].removesuffix(" = 0") in text
        check_certificate(certificate)


OPEN_HINTS = [
    (
        "u_t + u_x",
        "u = abs(x + t)",
        "-t in the place of t, on each side of x = t, nothing said across it: u = abs(x - t)",
    ),
    (
        "u[n+1] + u[n]",
        "u = sign(n - 3)**2",
        "-u[n] in the place of u[n] in the equation, apart from n = 3, n = 2, nothing said of "
        "them (possibly not smooth: jump or corner at the site n = 3; possibly not smooth: jump or "
        "corner at the site n = 2): u[n+1] - u[n] = 0",
    ),
    (
        "u_x - u/m",
        "u = exp(m*x)",
        "x/m in the place of m*x (possibly not smooth: pole where m = 0): u = exp(x/m)",
    ),
    (
        "u_t + u_x",
        "u = sign(m)*(x + t)",
        "-t in the place of t (possibly not smooth: jump or corner where m = 0): "
        "u = sign(m)*(x - t)",
    ),
]


@pytest.mark.parametrize(("equation", "solution", "words"), OPEN_HINTS)
def test_a_hint_says_what_its_proof_leaves_open(equation: str, solution: str, words: str) -> None:
    """Catches: a hint without the jumps, poles and sites that its proof leaves open."""
    statement = read_statement(equation, solution)
    found = with_hint(statement, decide_statement(statement))
    assert found.hint == f"it holds with {words}"
    assert found.hint_verdict
    assert found.hint_verdict.outcome == "PROVED"
    assert checked_again(statement, verdict_record(found)) == replace(found, seconds=ANY)
    assert found.json()["hint"] == found.html_rows["what would hold"] == found.hint


def test_a_change_that_makes_a_jump_is_no_hint() -> None:
    """Catches: sign(0 + I*(n - 2))**2, which is 0 at n = 2, as a hint for all sites."""
    statement = read_statement("u[n+1] + u[n]", "u = (-1)**n*sign(1 + I*(n - 2))**2")
    found = with_hint(statement, decide_statement(statement))
    assert found.outcome == "REFUTED"
    assert "sign(0" not in found.hint
    assert not found.hint_verdict or not found.hint_verdict.restriction


def test_a_hint_leaves_a_proof_alone() -> None:
    wrong = read_statement(KDV, "u = 2*k**2*sech(k*(x + 4*k**2*t))**2", "k: k>0")
    refuted = decide_statement(wrong)
    assert with_hint(wrong, refuted).hint
    right = read_statement(KDV, SOLITON, "k: k>0")
    proved = decide_statement(right)
    assert with_hint(right, proved) is proved


def test_the_face_takes_texts_and_sympy_objects() -> None:
    assert longwave.prove(KDV, SOLITON, parameters="k: k>0", name="mine").name == "mine"
    x = sp.Symbol("x")
    equation, formula = sp.Function("u")(x).diff(x) - 1, x
    direct = prove_expression(equation, formula)
    assert longwave.prove(equation, formula).certificate == direct.certificate
    assert longwave.prove(["u_x - 1"], ["u = x"]).outcome == "PROVED"
    with pytest.raises(ValueError, match="domain, solve, variables and weak must be left out"):
        longwave.prove(equation, formula, domain="x > 0")
    with pytest.raises(TypeError, match="equation and solution must both be text or SymPy objects"):
        longwave.prove("u_x - 1", formula)
    with pytest.raises(TypeError, match="solve, variables, weak and name, got points"):
        longwave.prove("u_x - 1", "u = x", points=[])


def test_the_latex_has_jets_sites_and_domains() -> None:
    statement = read_statement("diff(q[n],t,t) - q[n+1]", "q = n*t", domain="t > 0")
    assert statement_latex(statement) == (
        r"q_{n, tt} - q_{n+1} = 0 \quad\Leftarrow\quad q_{n} = n t \qquad (t > 0)"
    )
    greek = read_statement("psi_t - psi", "psi = exp(t)")
    assert statement_latex(greek).startswith(r"\psi_{t} - \psi = 0")
    refuted = verified_sentence(statement, decide_statement(statement))
    assert refuted.startswith("We found that\n\\[ q_{n} = n t \\]\ndoes not satisfy\n")
    right = read_statement("u_xxt + diff(u**2, x)", "u = a", "a: -1<=a<1")
    proved = verified_sentence(right, decide_statement(right))
    assert "\n\\[ u_{xxt} + \\left(u^{2}\\right)_{x} = 0 \\]\n" in proved
    assert r"for all real $a, t, x$ with $-1 \le a < 1$" in proved


@pytest.mark.parametrize(
    ("formula", "domain", "outcome"),
    [("x", "x>0", "PROVED"), ("x", "x<0", "REFUTED"), ("x - 1", "x>2", "PROVED")],
)
def test_the_sign_of_what_is_declared_positive(formula: str, domain: str, outcome: str) -> None:
    """Catches: the sign of a positive symbol, whose absolute value SymPy reads as the symbol."""
    statement = read_statement("sign(u) - 1", f"u = {formula}", domain=domain)
    assert decide_statement(statement).outcome.value == outcome


def test_exponents_past_all_bounds_are_no_crash() -> None:
    """As a polynomial in a root of n, n**(1 - 1e-40) has a degree beyond a machine word."""
    off = f"{10**40 - 1}/{10**40}"
    equation = "exp(-u[n+1] - u[n]) - n*(n + 1)"
    statement = read_statement(equation, f"u[n] = -({off})*log(n)", domain="n > 0")
    assert decide_statement(statement).outcome.value != "PROVED"


SCOPES = [
    ("u - 1", "u = abs(m)/m + 0*x", "m: m>0", "", "for all real m, x with m > 0"),
    ("diff(q[n], t)", "q[n] = (-1)**n", "", "", "for all real t; integer n"),
    (
        "u_t - u_x",
        "u = f(x + t)",
        "f: function",
        "t>0",
        "for all real t, x and functions f that are real at real arguments with t > 0",
    ),
    (
        "u_x - c*k",
        "u = c*k*x",
        "c: complex; k: integer, positive",
        "",
        "for all real x; integer k; complex c with k > 0",
    ),
    (
        "u_x - k",
        "u = k*x",
        "m: 0<m<1; k: k > jacobi_dn(1, m), k < 7",
        "",
        "for all real k, m, x with 0 < m < 1, k > jacobi_dn(1, m), k < 7",
    ),
    ("u_x - b", "u = b*x", "a: 1<=a<2; b = 2*a", "", "for all real a, x with 1 <= a < 2"),
]


@pytest.mark.parametrize(("equation", "solution", "parameters", "domain", "words"), SCOPES)
def test_a_proof_is_for_the_names_that_the_checker_reads(
    equation: str, solution: str, parameters: str, domain: str, words: str
) -> None:
    """Catches: a scope without cancelled names or without conditions, or with real sites."""
    verdict = prove(equation, solution, parameters=parameters, domain=domain)
    assert verdict.outcome == "PROVED", verdict.detail
    assert verdict.assumptions[0] == f"{words}, wherever the formulas are smooth"


def test_exceptional_sites_are_named() -> None:
    verdict = prove("u[n] - 1", "u[n] = sign(n - 3)**2 + 0/(2*n - 1)")
    assert verdict.singularities == ("jump or corner at the site n = 3",)
    statement = read_statement("u[n] - 1", "u[n] = sign(n - 3)**2")
    sentence = verified_sentence(statement, decide_statement(statement))
    assert sentence.endswith(
        "for all integer $n$ at which it is smooth; nothing is said at $n = 3$."
    )


def test_the_sentence_is_of_what_was_typed() -> None:
    r"""Catches: u = sign(exp(I*x))**2 printed as u = 1."""
    statement = read_statement("u - sign(exp(I*x))**2", "u = sign(exp(I*x))**2 + 0/x")
    verdict = decide_statement(statement)
    assert verdict.outcome == "PROVED"
    formula = r"\operatorname{sign}^{2}\left(\mathrm{e}^{\mathrm{i} x}\right) + \frac{0}{x}"
    for text in (verdict.statement, verified_sentence(statement, verdict)):
        assert formula in text
    assert verdict.equation == "u - sign(exp(I*x))**2 = 0"


def test_the_residual_at_a_witness_is_that_of_what_was_typed() -> None:
    """Catches: the residual 2 of SymPy's form u = x."""
    verdict = prove("u_x + 1", "u = x*sign(exp(I*x))**2")
    assert verdict.witness is not None
    x = (
        mpmath.mpf(Fraction(verdict.witness["x"]).numerator)
        / Fraction(verdict.witness["x"]).denominator
    )
    value = mpmath.exp(2j * x) * (1 + 2j * x) + 1
    balls = re.findall(r"\[(\S+) \+/- (\S+)\]", verdict.detail)
    for (middle, error), part in zip(balls, (value.real, value.imag), strict=True):
        assert abs(mpmath.mpf(middle) - part) <= mpmath.mpf(error)

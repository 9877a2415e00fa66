"""Answers of `--solve` beyond its cases: "only if" for the typed statement, and conditions."""

from dataclasses import replace

import pytest

from longwave.verify.proof.conditions import ConditionalVerdict, solve_statement
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.text_prover import prove
from longwave.verify.verdict import Outcome

NLS = "I*u_t + u_xx + 2*abs(u)**2*u"
BURGERS = "u_t + u*u_x - u_xx"


def solved(
    equation: str, solution: str, solve: str, parameters: str = "", domain: str = ""
) -> ConditionalVerdict:
    found = prove(equation, solution, parameters=parameters, domain=domain, solve=solve)
    assert isinstance(found, ConditionalVerdict)
    return found


WAVE = "a*sech(a*(x - 4*t))*exp(I*w*t)"
SIGNS = [
    (NLS, f"u = sign(exp(I*x))**2*{WAVE}", "w", WAVE),
    ("u_x - 2*I*u/(1 + x**2)", "u = a*sign(1 + I*x)**2", "a", "a"),
    ("u_x - 4*I*u/(1 + x**2)", "u = a*sign(1 + I*x)**4", "a", "a"),
    ("u_t - 2*I*c*u", "u = sign(exp(I*t))**2", "c", "1"),
]
"""Statements with squares of complex signs, and what SymPy takes the formula for."""

ANSWERS = ("if and only if w = (a - 2)*(a + 2)", "for all", "for all", "if and only if c = 1")


@pytest.mark.parametrize("place", range(len(SIGNS)))
def test_signs_of_complex_formulas_are_quotients(place: int) -> None:
    equation, solution, solve, _ = SIGNS[place]
    assert solved(equation, solution, solve).detail.startswith(f"holds {ANSWERS[place]}")


@pytest.mark.parametrize(("equation", "solution", "solve", "misread"), SIGNS)
def test_values_are_not_excluded_where_what_was_typed_is_something_else(
    equation: str, solution: str, solve: str, misread: str
) -> None:
    """SymPy reads sign(exp(I*x))**2 as 1, which would exclude values that hold."""
    statement = read_statement(equation, solution, solve=solve)
    wrong = read_statement(equation, f"u = {misread}", solve=solve)
    verdict = solve_statement(replace(statement, solutions=wrong.solutions))
    assert not verdict.complete
    assert verdict.outcome is not Outcome.REFUTED
    assert "only if" not in verdict.detail
    assert "for no value" not in verdict.detail
    assert "not excluded (what was typed has another residual" in verdict.detail


@pytest.mark.parametrize(
    ("equation", "solution", "solve", "answer"),
    [
        ("u_t + c*u_x", "u = exp(k*x - w*t)*sign(x)", "w", "if and only if w = c*k"),
        ("u_t + c*u_x", "u = sign(x - w*t)*abs(x - w*t)", "c", "if and only if c = w"),
        (NLS, f"u = sign(exp(2*I*x))*{WAVE}", "w", "if and only if w = (a - 2)*(a + 2); or a = 0"),
    ],
)
def test_slopes_of_signs_are_0_on_each_side(
    equation: str, solution: str, solve: str, answer: str
) -> None:
    """Catches: an error for SymPy's delta functions at jumps, about which no claim is made."""
    verdict = solved(equation, solution, solve)
    assert verdict.outcome is Outcome.PROVED
    front = f"{verdict.restriction}: " if verdict.restriction else ""
    assert verdict.detail.startswith(f"{front}holds {answer}")


def test_a_polynomial_may_vanish_at_finitely_many_sites() -> None:
    """The only site is n = 1, where c = 0 holds."""
    verdict = solved("u[n-2] - u[n] + c", "u[n] = abs(n)", "c", "c: c<1", "0<n<2")
    assert verdict.outcome is Outcome.UNDECIDED
    assert verdict.detail == (
        "no value was found of c, others are not excluded (n takes finitely many values)"
    )


TEXTBOOK = {
    "oscillator": (
        "c*u_xx + m*u", "u = cos(k*x)", "c: c>0; m: m>0", "k",
        "k = sqrt(m)/sqrt(c); or k = -sqrt(m)/sqrt(c)",
    ),
    "linear shallow water": (
        "h_t + d*v_x ;; v_t + g*h_x", "h = cos(k*x - w*t) ;; v = b*cos(k*x - w*t)",
        "g: g>0; d: d>0; k: k>0; w: w>0", "b,w",
        "b = sqrt(g)/sqrt(d), w = sqrt(d)*sqrt(g)*k",
    ),
    "bright soliton": (
        "I*u_t + p*u_xx + q*abs(u)**2*u", "u = a*sech(k*x)*exp(I*w*t)",
        "p: p>0; q: q>0; k: k>0", "a,w",
        "a = sqrt(2)*k*sqrt(p)/sqrt(q), w = k**2*p; or "
        "a = -sqrt(2)*k*sqrt(p)/sqrt(q), w = k**2*p; or a = 0 (trivial)",
    ),
    "mKdV soliton": (
        "u_t + g*u**2*u_x + b*u_xxx", "u = a*sech(k*(x-v*t))", "g: g>0; b: b>0; a: a>0; k: k>0",
        "a,v", "a = sqrt(6)*sqrt(b)*k/sqrt(g), v = b*k**2",
    ),
    "KdV soliton by its height": (
        "u_t + c0*u_x + g*u*u_x + b*u_xxx", "u = a*sech(k*(x-v*t))**2",
        "g: g>0; b: b>0; c0: c0>0; a: a>0; k: k>0", "k,v",
        "k = sqrt(3)*sqrt(a)*sqrt(g)/(6*sqrt(b)), v = (a*g + 3*c0)/3",
    ),
    "Fisher": (
        "u_t - d*u_xx - r*u*(1-u)", "u = 1/(1+exp(k*(x-v*t)))**2", "d: d>0; r: r>0; k: k>0",
        "k,v", "k = sqrt(6)*sqrt(r)/(6*sqrt(d)), v = 5*sqrt(6)*sqrt(d)*sqrt(r)/6",
    ),
    "FitzHugh-Nagumo": (
        "u_t - d*u_xx + s*u*(u-1)*(u-a)", "u = 1/(1+exp(k*(x-v*t)))", "d: d>0; s: s>0; k: k>0",
        "k,v",
        "k = sqrt(2)*sqrt(s)/(2*sqrt(d)), v = -sqrt(2)*sqrt(d)*sqrt(s)*(2*a - 1)/2",
    ),
    "transition wave": (
        "u_tt + g*u_t - K*u_xx + B*u*(u-1)*(u-a)", "u = 1/(1+exp(k*(x-v*t)))",
        "g: g>0; K: K>0; B: B>0; a: 0<a<1/2; k: k>0", "v,k",
        "v = -B*K*(2*a - 1)/sqrt(4*B**2*K*a**2 - 4*B**2*K*a + B**2*K + 2*B*K*g**2), "
        "k = sqrt(4*B**2*K*a**2 - 4*B**2*K*a + B**2*K + 2*B*K*g**2)/(2*K*g)",
    ),
    "fourth-order dispersion": (
        "I*u_z - b2/2*u_tt + b4/24*u_tttt + s*abs(u)**2*u", "u = a*sech(k*t)**2*exp(I*q*z)",
        "b2: b2<0; b4: b4<0; s: s>0; a: a>0; k: k>0", "a,k,q",
        "a = -3*sqrt(5)*b2/(5*sqrt(s)*sqrt(-b4)), k = -sqrt(15)*sqrt(-b2)*sqrt(-b4)/(5*b4), "
        "q = -24*b2**2/(25*b4)",
    ),
    "waves of a Boussinesq system": (
        "h_t + d*v_x - 1/6*d**2*h_xxt ;; v_t + g*h_x - 1/6*d**2*v_xxt",
        "h = cos(k*x - w*t) ;; v = b*cos(k*x - w*t)", "g: g>0; d: d>0; k: k>0; w: w>0", "b,w",
        "b = sqrt(g)/sqrt(d), "
        "w = 6*sqrt(d)*sqrt(g)*k/(d**2*k**2 + 6)",
    ),
}  # fmt: skip
"""Constants that are declared positive, with what is in the literature."""


@pytest.mark.parametrize("name", TEXTBOOK)
def test_roots_of_positive_constants_are_values(name: str) -> None:
    equation, solution, parameters, solve, answer = TEXTBOOK[name]
    verdict = solved(equation, solution, solve, parameters)
    assert verdict.detail == f"holds if and only if {answer}"
    assert verdict.outcome is Outcome.PROVED


def test_a_bound_that_cannot_be_compared_with_a_declared_one_is_a_condition() -> None:
    verdict = solved(
        "w_tt - diff(w + w**3, x, x) - w_xxtt/12",
        "w = a*jacobi_cn(k*(x - c*t), m)",
        "a,c",
        "m: 0<m<1; a: a>0; k: k>0; c: c>0",
    )
    assert verdict.outcome is Outcome.PROVED
    assert verdict.detail == (
        "holds if and only if a = -k*sqrt(-4*k**2*m**2 + 2*k**2*m + 24*m)/(2*k**2*m - k**2 - 12), "
        "c = 2*sqrt(3)/sqrt(-2*k**2*m + k**2 + 12) where -2*k**2*m + k**2 + 12 > 0"
    )


@pytest.mark.parametrize(
    ("equation", "solution", "solve", "parameters", "answer"),
    [
        ("c*u_xx + m*u", "u = cos(k*x)", "k", "c: c<0; m: m<0; k: k>0", "-sqrt(-c)*sqrt(-m)/c"),
        ("u_xx - c*(l - k)*u", "u = exp(a*x)", "a", "c: c>0; k: k>0; l: l>k; a: a>0",
         "sqrt(-c*k + c*l)"),
        ("u_xx - (c**2 + (1 - b)*d)*u", "u = exp(a*x)", "a", "c: c>0; b: 0<b<1; d: d>0; a: a>0",
         "sqrt(-b*d + c**2 + d)"),
    ],
)  # fmt: skip
def test_what_the_declarations_say_is_no_condition(
    equation: str, solution: str, solve: str, parameters: str, answer: str
) -> None:
    verdict = solved(equation, solution, solve, parameters)
    assert verdict.detail == f"holds if and only if {solve} = {answer}"


def test_roots_are_real_at_the_zeros_of_what_stands_before_them() -> None:
    """At b = 1 the formula is u = 1, which is a solution for every c, also for c < 0."""
    verdict = solved("u_xx - c*(b - 1)**2*u", "u = exp(k*x)", "k")
    assert verdict.detail == (
        "holds if and only if k = sqrt(c)*(b - 1) where c >= 0; or "
        "k = -sqrt(c)*(b - 1) where c >= 0; or k = 0, b = 1 (trivial)"
    )


@pytest.mark.parametrize(
    ("equation", "solution", "solve", "parameters", "domain", "answer"),
    [
        ("u_x - c*exp(-x**2)", "u = a*erf(x)", "c", "", "", "and only if c = 2*a/sqrt(pi)"),
        ("u_x - exp(-b*x**2)", "u = a*erf(k*x)", "a,k", "b: b>0", "",
         "and only if a = sqrt(pi)/(2*sqrt(b)), k = sqrt(b); or "
         "a = -sqrt(pi)/(2*sqrt(b)), k = -sqrt(b)"),
        (BURGERS, "u = a*exp(-x**2/(4*t))/(sqrt(t)*(2 + erf(x/(2*sqrt(t)))))", "a", "", "t>0",
         "a = -2/sqrt(pi); or a = 0 (trivial), others are not excluded"),
    ],
)  # fmt: skip
def test_error_functions_in_python(
    equation: str, solution: str, solve: str, parameters: str, domain: str, answer: str
) -> None:
    """Catches: an uncaught SymPy error for roots of pi, which are not polynomials."""
    verdict = solved(equation, solution, solve, parameters, domain)
    assert verdict.detail.startswith(f"holds if {answer}")
    assert verdict.outcome is Outcome.PROVED
    assert repr(verdict) == f"<ConditionalVerdict PROVED: statement, {verdict.equation}: " + (
        f"{verdict.detail}>"
    )


def test_a_trivial_statement_holds_for_all_values() -> None:
    verdict = solved("u_xx + 2*x*u_x", "u = a + b*erf(k)", "k")
    assert verdict.detail == "holds for all values of k (trivial)"


@pytest.mark.parametrize(
    ("equation", "solution", "solve", "parameters", "answer"),
    [
        ("u_xxxx - 2*b*u_xx + (b**2 - c*d**2)*u", "u = exp(k*x)", "k", "b: b>0",
         "k = sqrt(b), d = 0; or k = -sqrt(b), d = 0"),
        ("u_x - c*b**2", "u = a*x", "a", "a: a>=0", "a = b**2*c where b**2*c >= 0"),
        ("u_x - c*b**2", "u = a*x", "a", "a: a>=0; c: c<0", "a = 0, b = 0 (trivial)"),
    ],
)  # fmt: skip
def test_zeros_of_squares_are_values(
    equation: str, solution: str, solve: str, parameters: str, answer: str
) -> None:
    verdict = solved(equation, solution, solve, parameters)
    assert verdict.complete
    assert verdict.detail.startswith("holds if and only if ")
    assert verdict.detail.endswith(answer)

"""Roots of roots, and several roots of one radicand as powers of one generator."""

import pytest

from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import StatementVerdict, decide_statement
from longwave.verify.verdict import Outcome

Texts = str | tuple[str, ...]

FAMILY = (
    "h = -d + c**2*r**2/(81*g) + 5*c**2*r**2/(108*g)"
    "*(2*sech(sqrt(r)/2*(x-c*t)/d)**2 - 3*sech(sqrt(r)/2*(x-c*t)/d)**4)",
    "v = c*(1-5*r/18) + 5*c*r/6*sech(sqrt(r)/2*(x-c*t)/d)**2",
)

CASES: list[tuple[Texts, Texts, str, tuple[str, str]]] = [
    ("u_xx - sqrt(g)*u", "u = exp(g**(1/4)*x)", "g: g>0", ("1/4", "1/3")),
    ("u_xx - g**(1/3)*u", "u = exp(g**(1/6)*x)", "g: g>0", ("1/6", "1/5")),
    (
        "u_t + u*u_x + u_xxx",
        "u = 3*sqrt(g)*sech(sqrt(sqrt(g))/2*(x-sqrt(g)*t))**2",
        "g: g>0",
        ("(x-", "(x+"),
    ),
    (
        "u_xx - (c/sqrt(d)-1)*u",
        "u = exp(sqrt((c-sqrt(d))/sqrt(d))*x)",
        "d: d>0; c: c>0",
        ("(c-", "(c+"),
    ),
    (
        "h_t + sqrt(g*d)*h_x + 3/2*sqrt(g/d)*h*h_x + 1/6*sqrt(g*d)*d**2*h_xxx",
        "h = A*sech(1/2*sqrt(3*A/d**3)*(x-c*t))**2",
        "g: g>0; d: d>0; c: c>0; c0 = sqrt(g*d); A = 2*d*(c-c0)/c0",
        ("x-c*t", "x+c*t"),
    ),
    (
        (
            "h_t + diff((h+d)*v,x) - 1/6*d**2*h_xxt",
            "v_t + g*h_x + diff(v**2/2,x) - 1/6*d**2*v_xxt",
        ),
        FAMILY,
        "g: g>0; d: d>0; c = 5/2; r = 18/5*sqrt(g*d)",
        ("- 3*sech", "+ 3*sech"),
    ),
    (
        "u_tt + g*u_t - K*u_xx + B*u*(u-1)*(u-a)",
        "u = 1/(1+exp(k*(x-v*t)))",
        "g: g>0; K: K>0; B: B>0; a: 0<a<1/2; "
        "v = sqrt(2*B*K)*(1/2-a)/sqrt(g**2+2*B*(1/2-a)**2); k = sqrt(B/(2*(K-v**2)))",
        ("x-v*t", "x+v*t"),
    ),
    ("u - g**(1/6)", "u = sqrt(g**(1/3)) + 0*x", "", ("sqrt", "-sqrt")),
    ("u_x - 3/(4*x)*u", "u = (-x)**(1/2)*(-x)**(1/4)", "", ("1/4", "1/8")),
]


def decided(equation: Texts, solution: Texts, parameters: str) -> StatementVerdict:
    return decide_statement(read_statement(equation, solution, parameters))


@pytest.mark.parametrize(("equation", "solution", "parameters", "_change"), CASES)
def test_a_root_of_a_root_has_a_generator(
    equation: Texts, solution: Texts, parameters: str, _change: object
) -> None:
    """Catches: independent generators for two roots of one radicand."""
    assert decided(equation, solution, parameters).outcome is Outcome.PROVED


@pytest.mark.parametrize(("equation", "solution", "parameters", "change"), CASES)
def test_another_root_or_sign_is_refuted(
    equation: Texts, solution: Texts, parameters: str, change: tuple[str, str]
) -> None:
    texts = [solution] if isinstance(solution, str) else [*solution]
    changed = tuple(text.replace(*change) for text in texts)
    assert changed != tuple(texts)
    assert decided(equation, changed, parameters).outcome is Outcome.REFUTED


def test_a_power_of_minus_one_to_an_integer_has_no_branch_point() -> None:
    """Catches: -1 to a symbol taken for a root where the symbol is an integer."""
    found = decided("diff(u[n], t, t) + w**2*u[n]", "u[n] = (-1)**n*cos(w*t)", "")
    assert found.outcome is Outcome.PROVED
    assert found.singularities == ()
    real = decided("u_x - log(x)*0*u", "u = (-2)**k + 0*x", "")
    assert real.singularities != ()

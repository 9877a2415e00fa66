"""Statements in the notation of other systems and papers: a one-line error with a correction."""

from __future__ import annotations

import re

import pytest

from longwave.__main__ import main
from longwave.derive.algebra.formula_text import FormulaError
from longwave.verify.proof.statement_text import read_statement

Texts = tuple[str, str, str]

KDV = ("u_t + 6*u*u_x + u_xxx", "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", "k: k>0")
KDV_OF_SPEED = (KDV[0], "u = c/2*sech(sqrt(c)/2*(x - c*t))**2", "c: c>0")
NLS = ("I*u_t + u_xx + 2*abs(u)**2*u", "u = a*sech(a*x)*exp(I*a**2*t)", "a: a>0")
SN = ("u_xx + (1+m)*u - 2*m*u**3", "u = jacobi_sn(x, m)", "m: 0<m<1")
KINK = ("u_tt - u_xx + sin(u)", "u = 4*atan(exp((x - c*t)/sqrt(1 - c**2)))", "c: -1<c<1")
SINE = ("u_xx + u", "u = sin(x)", "")
LOG = ("x*u_x - 1", "u = log(x)", "")
EXP = ("u_x - u", "u = exp(x)", "")
TURN = ("u_x - I*u", "u = exp(I*x)", "")
PI = ("u_x - pi*u", "u = exp(pi*x)", "")
CHAIN = ("diff(q[n], t, t) = q[n+1] - q[n]", "q[n] = 3", "")
SITES = ("u[n+1] - u[n] - 1", "u[n] = n", "")
HALF = ("u_x - 0.5", "u = 0.5*x", "")
ROOT = ("u_x - 1/(2*sqrt(x))", "u = sqrt(x)", "")
ATAN = ("u_x - 1/(1+x**2)", "u = atan(x)", "")
SQUARE = ("u_x - 2*x", "u = x**2", "")
PRODUCT = ("u_x - t", "u = x*t", "")
LINE = ("u_x - a*(b+c)", "u = a*(b+c)*x", "a: real; b: real; c: real")

EQUATIONS: dict[Texts, tuple[str, ...]] = {
    KDV: (
        "ut + 6*u*ux + uxxx",
        "u_t + 6 u u_x + u_xxx",
        "u_t + 6u*u_x + u_xxx",
        "u_t + 6*u*u_x + u_{xxx}",
        "u_t + 6*u*u_x + u_x_x_x",
        "u_t + 6*u*u_x + u_3x",
        "D[u,t] + 6*u*D[u,x] + D[u,{x,3}]",
        "D[u[x,t],t] + 6*u[x,t]*D[u[x,t],x] + D[u[x,t],{x,3}] == 0",
        "Derivative(u, t) + 6*u*Derivative(u, x) + Derivative(u, x, 3)",
        "u.diff(t) + 6*u*u.diff(x) + u.diff(x, 3)",
        "du/dt + 6*u*du/dx + d^3u/dx^3",
        r"\partial_t u + 6 u \partial_x u + \partial_x^3 u = 0",
        r"\frac{\partial u}{\partial t} + 6 u \frac{\partial u}{\partial x}"
        r" + \frac{\partial^3 u}{\partial x^3} = 0",
        "u_t + 6*u*u_x + u_xxx = 0 = 0",
        "u_t + 6*u*u_x + u_xxx =",
        "u_t + 6*u*u_x + u_xxx)",
        "u_t + 6·u·u_x + u_xxx",
        "U_t + 6*U*U_x + U_xxx",
        "u_t + 6*u*u_x + u_x,xx",
        "u_t + 6*u*u_x + u_xxx_",
        "u_t + 6*u*u_x + diff(u_x, 'x', 2) # KdV",
    ),
    ("diff(u, t) + 6*u*diff(u, x) + diff(u, x, x, x)", *KDV[1:]): (
        "diff(u,t) + 6*u*diff(u,x) + diff(u,x$3)",
        "Dt(u) + 6*u*Dx(u) + Dx(Dx(Dx(u)))",
    ),
    ("u_t + 3*diff(u**2, x) + u_xxx", *KDV[1:]): (
        "u_t + 3(u^2)_x + u_xxx = 0",
        "u_t + 3*(u**2)_x + u_xxx",
    ),
    NLS: (
        "I*u_t + u_xx + 2*|u|^2*u",
        "I*u_t + u_xx + 2*Abs(u)**2*u",
        "1j*u_t + u_xx + 2*abs(u)**2*u",
        r"i u_t + u_{xx} + 2 |u|^2 u = 0",
    ),
    (f"{NLS[0][:-11]}u**2*conjugate(u)", *NLS[1:]): (
        "I*u_t + u_xx + 2*u**2*conj(u)",
        "I*u_t + u_xx + 2*u^2*u*",
        "I*u_t + u_xx + 2*u**2*ubar",
        "I*u_t + u_xx + 2*u^2*u^*",
        r"I*u_t + u_xx + 2*u^2*\bar{u}",
    ),
    CHAIN: ("q_n'' = q_{n+1} - q_n", "q''[n] = q[n+1] - q[n]"),
    SITES: ("u_{n+1} - u_n - 1", "u(n+1) - u(n) - 1"),
    SINE: (r"\frac{d^2 u}{dx^2} + u", "u'' + u"),
}

SOLUTIONS: dict[Texts, tuple[str, ...]] = {
    KDV: (
        "u = 2*k^2*Sech[k*(x - 4*k^2*t)]^2",
        "u = 2 k^2 Sech[k (x - 4 k^2 t)]^2",
        "u = 2k**2*sech(k*(x - 4*k**2*t))**2",
        "u = 2*k**2*sech**2(k*(x - 4*k**2*t))",
        "u = 2*k**2*sech^2 (k*(x - 4*k**2*t))",
        "u(x,t) = 2*k**2*sech(k*(x - 4*k**2*t))**2",
        "u[x,t] = 2*k**2*sech(k*(x - 4*k**2*t))**2",
        "u == 2*k**2*sech(k*(x - 4*k**2*t))**2",
        "u := 2*k**2*sech(k*(x - 4*k**2*t))**2",
        "u[x_,t_] := 2*k^2*Sech[k*(x - 4*k^2*t)]^2",
        "2*k**2*sech(k*(x - 4*k**2*t))**2",
        r"u = 2 k^2 \operatorname{sech}^2\left(k (x - 4 k^2 t)\right)",
        r"u = 2 k^{2} \mathrm{sech}^{2}(k(x-4k^{2}t))",
        "u = 2·k²·sech(k·(x − 4·k²·t))²",
        "u = 2*k**2*sehc(k*(x - 4*k**2*t))**2",
        "u = 2*k**2*np.sech(k*(x - 4*k**2*t))**2",
        "u = 2*k.^2.*sech(k.*(x - 4*k.^2.*t)).^2",
        "u = 2*k**2*sech(k*(x - 4*k**2*t))**2;",
        "u = 2*k**2*sech(k*(x - 4*k**2*t))***2",
        "u = '2*k**2*sech(k*(x - 4*k**2*t))**2'",
        "u = 2 k² sech²[k(x − 4k²t)]",
    ),
    KDV_OF_SPEED: (r"u = \frac{c}{2}\operatorname{sech}^2\left(\frac{\sqrt{c}}{2}(x-ct)\right)",),
    SINE: ("u = sin x", "u = Sin[x]", "u = sin[x]", r"u = \sin x", "u = sinx(x)"),
    LOG: ("u = ln(x)", "u = ln x", "u = Log[x]", "u = logx"),
    (LOG[0], "u = log(abs(x))", ""): ("u = ln|x|", "u = ln(|x|)"),
    (SINE[0], "u = sin(x)/2 - cos(2*x)*0", ""): ("u = sinx/2 - cos2x*0",),
    EXP: ("u = e^x", "u = E^x", "u = e**x", "u = Exp[x]", "u = exp x"),
    TURN: ("u = exp(i*x)", "u = exp(ix)", "u = e^{ix}", "u = exp(1j*x)"),
    PI: ("u = exp(Pi*x)", "u = exp(π x)"),
    SN: ("u = sn(x|m)", "u = JacobiSN[x, m]", "u = sn(x, m)", "u = jacobi_sn(x | m)"),
    HALF: ("u = 0,5*x", "u = 0.5x"),
    ROOT: ("u = Sqrt[x]", "u = √x", r"u = \sqrt{x}", "u = sqrt x"),
    ATAN: ("u = arctan(x)", "u = tan^-1(x)", "u = ArcTan[x]"),
    SQUARE: ("u = x²", "u = pow(x, 2)", "u = x^2"),
    PRODUCT: ("u = xt", "u = x t"),
    LINE: ("u = a(b+c)x", "u = a (b+c) x"),
}

PARAMETERS: dict[Texts, tuple[str, ...]] = {
    KDV: (
        "k>0",
        "k > 0",
        "k: positive real",
        "k = positive",
        "k: k>0, ",
        "k: >0",
        "k: (0, oo)",
        "let k>0",
    ),
    (*KDV[:2], "k: 0<k<1"): ("0 < k < 1", "k ∈ (0, 1)", "k: 0..1"),
    SN: ("0<m<1", "m in (0,1)", "0 < m, m < 1", "m ∈ (0, 1)"),
    KINK: ("|c|<1", "c: abs(c) < 1", "c in (-1, 1)", "-1<c<1"),
    LINE: ("a, b, c", "a real; b real; c real"),
}

CASES: list[tuple[Texts, Texts]] = [
    *((right, (text, *right[1:])) for right, texts in EQUATIONS.items() for text in texts),
    *((right, (right[0], text, right[2])) for right, texts in SOLUTIONS.items() for text in texts),
    *((right, (*right[:2], text)) for right, texts in PARAMETERS.items() for text in texts),
    (SITES, ("u(n+1) - u(n) - 1", "u(n) = n", "")),
    (("u_x - 1", "u = x + a1", "a1: real"), ("u_x - 1", "u = x + x1", "x1: real")),
    (
        ("u_t + c*u_x", "u = F(x - c*t)", "c: real; F: function"),
        ("u_t + c u_x", "u(x,t) = F(x - c t)", "c real"),
    ),
    (
        ("u_tt - u_xx", "u = f(x - t) + g(x + t)", "f: function; g: function"),
        (r"\partial_t^2 u = \partial_x^2 u", "u = f(x-t) + g(x+t)", ""),
    ),
    (KINK, ("u_tt - u_xx + sin u", "u = 4*arctan(exp((x - c*t)/sqrt(1 - c**2)))", KINK[2])),
    (("u_x - 1 ;; v_t - 1", "u = x ;; v = t", ""), ("u_x - 1\nv_t - 1", "u = x\nv = t", "")),
    (("u_x - 1 ;; v_t - 1", "u = x ;; v = t", ""), ("[u_x-1, v_t-1]", "[u=x, v=t]", "")),
    (("u_x = 1 ;; v_t = 1", "u = x ;; v = t", ""), ("u_x = 1 and v_t = 1", "u = x, v = t", "")),
    (("u_x - 1 ;; v_t - 1", "u = x ;; v = t", ""), ("u_x - 1; v_t - 1", "u = x, v = t", "")),
]


def corrected(texts: Texts) -> Texts:
    """Return the statement with the correction of its error message."""
    with pytest.raises(FormulaError) as raised:
        read_statement(*texts)
    line = str(raised.value)
    assert "\n" not in line
    assert len(line) <= 700
    assert re.search(r"\(column \d+\)$", line)
    labels = ["equation", "solution", "parameters", "domain"]
    own = line.split(":")[0]
    parts = dict(zip(labels, texts, strict=False))
    found = re.findall(rf"write (?:({'|'.join(labels)}) )?'(.*?)'(?= and write| \(column)", line)
    assert found, line
    parts |= {label or own: text for label, text in found}
    return parts["equation"], parts["solution"], parts["parameters"]


def test_there_are_as_many_as_asked_for() -> None:
    assert len({mistyped for _, mistyped in CASES}) >= 65


@pytest.mark.parametrize(("right", "mistyped"), CASES)
def test_the_error_shows_the_statement_that_was_meant(right: Texts, mistyped: Texts) -> None:
    expected, found = read_statement(*right), read_statement(*corrected(mistyped))
    assert found == expected


@pytest.mark.parametrize(
    ("equation", "solution"),
    [
        ("u_x - floor(x)", "u = x"),
        ("u_x - gamma(x)", "u = x"),
        ("u_xx + u_yy", "u = arg(x + I*y)"),
        (r"\Delta u", "u = x*y"),
        ("u_x ~ 1", "u = x"),
        ("u_x - 1", "u = x + O(x^2)"),
        ("u_x - 0x10", "u = 16*x"),
        ("u_x - 1,000", "u = 1000*x"),
        ("u[t] + u[x]", "u = x - t"),
    ],
)
def test_nothing_is_shown_for_what_has_no_text_of_the_same_meaning(
    equation: str, solution: str
) -> None:
    with pytest.raises(FormulaError) as raised:
        read_statement(equation, solution)
    assert "; write" not in str(raised.value)


def test_the_command_line_shows_it(capsys: pytest.CaptureFixture[str]) -> None:
    equation, solution = KDV[0], "u = 2 k^2 Sech[k (x - 4 k^2 t)]^2"
    arguments = ["--equation", equation, "--solution", solution, "--parameters", KDV[2]]
    assert main(["prove", *arguments]) == 2
    assert KDV[1] in capsys.readouterr().err


@pytest.mark.parametrize("name", ["ut", "uxx", "ubar", "u_bar", "x1", "dx"])
def test_names_that_read_as_something_else_are_refused(name: str) -> None:
    with pytest.raises(FormulaError, match="expected"):
        read_statement(f"u_x + u_t + {name}", "u = x - t")


@pytest.mark.parametrize("name", ["x0", "t0", "u0", "c1", "kx", "theta"])
def test_names_of_constants_are_read(name: str) -> None:
    statement = read_statement("u_x + u_t", f"u = x - t + {name}", f"{name}: real")
    assert name in {symbol.name for symbol in next(iter(statement.solutions.values())).free_symbols}

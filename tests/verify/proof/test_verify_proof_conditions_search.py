"""Random ansatz problems: planted values are found, and least-squares solutions are in a case."""

import random
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import least_squares
from scipy.special import ellipj

from longwave.derive.algebra.formula_text import FormulaError
from longwave.verify.proof.conditions import ConditionalVerdict, solve_statement
from longwave.verify.proof.constant_cases import ConstantCase, symbols_of
from longwave.verify.proof.domains import settled_domains
from longwave.verify.proof.statement_problem import residual_of
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.typed_statement import Statement
from tests.families import family

ELLIPTIC = {
    "jacobi_sn": lambda z, m: ellipj(np.real(z), m)[0],
    "jacobi_cn": lambda z, m: ellipj(np.real(z), m)[1],
    "jacobi_dn": lambda z, m: ellipj(np.real(z), m)[2],
}
TANH, DN, CN = "tanh(k*(x - c*t))", "jacobi_dn(k*(x - c*t), m)", "jacobi_cn(k*(x - c*t), m)"
EXP = "exp(k*(x - c*t))"


@dataclass(frozen=True)
class Planted:
    """Equation with coefficients P, Q, an ansatz, and constants that are known to solve it."""

    equation: str
    ansatz: str
    values: dict[str, str]
    parameters: str = "k: k>0"


PLANTED = [
    Planted(
        "u_t + (P)*u*u_x + (Q)*u_xxx",
        "u = a/cosh(k*(x - c*t))**2",
        {"a": "12*Q*k**2/P", "c": "4*Q*k**2"},
    ),
    Planted(
        "u_t + (P)*u**2*u_x + (P)*u_xxx",
        f"u = a*{DN} + b*sqrt(m)*{CN}",
        {"a": "sqrt(6)*k/2", "b": "-sqrt(6)*k/2", "c": "P*k**2*(1 + m)/2"},
        "k: k>0; m: 0<m<1",
    ),
    Planted(
        "u_t + (P)*u*u_x - (Q)*u_xx",
        f"u = a + b*{TANH}",
        {"a": "c/P", "b": "-2*Q*k/P"},
    ),
    Planted(
        "u_t - (P)*u_xx - (P)*u*(1 - u)",
        f"u = 1/(1 + {EXP})**2",
        {"k": "1/sqrt(6)", "c": "5*P/sqrt(6)"},
    ),
    Planted(
        "I*u_t + (P)*u_xx + (Q)*abs(u)**2*u",
        "u = a*jacobi_sn(k*x, m)*exp(I*w*t)",
        {"a": "sqrt(-2*P*m*k**2/Q)", "w": "-P*k**2*(1 + m)"},
        "k: k>0; m: 0<m<1",
    ),
    Planted(
        "u_tt - (P)**2*u_xx + (Q)**2*sin(u)",
        "u = 4*atan(exp(k*x - w*t))",
        {"w": "sqrt(P**2*k**2 - Q**2)"},
        "k: k>0; w: w>0",
    ),
    Planted(
        "diff(u[n], t) - (P)*(1 + u[n]**2)*(u[n+1] - u[n-1])",
        "u[n] = a*jacobi_dn(k*n + w*t, m)",
        {"a": "SC", "w": "2*P*SC"},
        "k: k>0; m: 0<m<1",
    ),
    Planted(
        "u_t + (P)*u*u_x + v_x ;; v_t + diff((P)*u*v, x)",
        "u = a*x/t ;; v = b*x**2/t**2",
        {"a": "2/(3*P)", "b": "1/(9*P)"},
        "",
    ),
]

DEAR = (PLANTED[1], PLANTED[6])


def admissible(symbol: sp.Symbol, statement: Statement, draw: random.Random) -> float:
    """Return a number of moderate size in a domain."""
    domain = settled_domains(symbols_of(statement), statement.domains)[symbol]
    low = 0.3 if domain.lower == -sp.oo else float(domain.lower)
    high = low + 1.2 if domain.upper == sp.oo else float(domain.upper)
    return draw.uniform(low + 0.1 * (high - low), high - 0.1 * (high - low))


def value_of(expression: sp.Expr, numbers: dict[sp.Symbol, float]) -> complex:
    names = list(numbers)
    function = sp.lambdify(names, expression, modules=[ELLIPTIC, "numpy"])
    return complex(function(*(complex(numbers[s]) if s.name != "m" else numbers[s] for s in names)))


def holds_at(case: ConstantCase, numbers: dict[sp.Symbol, float], error: float) -> bool:
    """Return whether numbers for all constants lie in a case."""
    pairs = [(value_of(v, numbers), numbers[s]) for s, v in case.values.items()]
    pairs += [(value_of(p, numbers), 0.0) for p in case.implicit]
    return all(abs(a - b) < error * (1 + abs(b)) for a, b in pairs)


@pytest.mark.parametrize(
    "planted",
    [pytest.param(p, id=p.equation, marks=[pytest.mark.slow] * (p in DEAR)) for p in PLANTED],
)
def test_planted_constants_are_found(planted: Planted) -> None:
    draw = random.Random(planted.equation)
    P, Q = (sp.Rational(draw.randint(1, 30), draw.randint(1, 9)) for _ in range(2))
    if "abs" in planted.equation:
        Q = -Q
    equation = planted.equation.replace("P", str(P)).replace("Q", str(Q))
    names = sorted(planted.values)
    draw.shuffle(names)
    statement = read_statement(equation, planted.ansatz, planted.parameters, solve=",".join(names))
    verdict = solve_statement(statement)
    symbols = {s.name: s for s in symbols_of(statement)}
    others = [s for s in symbols.values() if s not in (*statement.solve_for, *statement.variables)]
    numbers = {s: admissible(s, statement, draw) for s in others}
    if "sin(u)" in equation:
        numbers[symbols["k"]] = float(Q / P + 1)
    scope = {s.name: sp.Float(v) for s, v in numbers.items()} | {"P": P, "Q": Q}
    if "SC" in str(planted.values):
        sn, cn = ellipj(numbers[symbols["k"]], numbers[symbols["m"]])[:2]
        scope["SC"] = sp.Float(sn / cn)
    for name, text in planted.values.items():
        expression = sp.parse_expr(text, local_dict={k: sp.Symbol(k) for k in scope})
        numbers[symbols[name]] = float(expression.subs(scope))
    assert any(holds_at(case, numbers, 1e-9) for case in verdict.cases), verdict.detail
    assert verdict.complete
    assert all(case.proved for case in verdict.cases)


ANSATZ = [
    (f"a + b*{TANH}", "a b c k", ""),
    (f"a + b*{TANH} + d*{TANH}**2", "a b c d k", ""),
    ("a*sech(k*(x - c*t))", "a c k", ""),
    (f"a/(1 + q*{EXP})", "a c k", "q: q>0"),
    ("a + b*jacobi_sn(k*(x - c*t), m)", "a b c", "m: 0<m<1"),
    (f"a + b*{CN}**2", "a b c", "m: 0<m<1"),
    (f"a + b*{DN}", "a b c", "m: 0<m<1"),
    ("a*exp(k*x - w*t)", "k w", ""),
    ("a*sin(k*x - w*t) + b*cos(k*x - w*t)", "a b w", ""),
    ("a + b/(x + d*t)", "a b d", ""),
    ("a*x**2/t + b*t**2", "a b", ""),
    ("a*tanh(k*x - w*t) + b*sech(k*x - w*t)", "a b w", ""),
    ("a*exp(k*x - w*t) + b*exp(l*x - v*t)", "w v", ""),
    ("(a + b*exp(k*x - w*t))/(1 + exp(k*x - w*t))", "a b w k", ""),
]
TERMS = ("u*u_x", "u_xx", "u_xxx", "u**2*u_x", "u", "u**2", "u**3", "u_x", "u_tt", "u_xt")


NEARLY_ZERO = 5e-2
"""Constants below, when they are not 0, are a trivial case's neighbours: the residual is tiny."""


def random_problem(draw: random.Random) -> Statement:
    """Return an equation of random terms, not all of which cancel, with an ansatz."""
    while True:
        with suppress(FormulaError):
            return drawn_problem(draw)


def drawn_problem(draw: random.Random) -> Statement:
    terms = draw.sample(TERMS, draw.choice((1, 2, 2, 3)))
    factors = [draw.choice(("1", "-1", "2", "6", "-6", "3", "1/2", "p")) for _ in terms]
    equation = draw.choice(("u_t", "u_tt", "u_t")) + "".join(
        f" + ({factor})*{term}" for factor, term in zip(factors, terms, strict=True)
    )
    ansatz, names, parameters = draw.choice(ANSATZ)
    solve_for = draw.sample(names.split(), draw.randint(1, len(names.split())))
    return read_statement(equation, f"u = {ansatz}", parameters, solve=",".join(solve_for))


def roots(
    statement: Statement, draw: random.Random, starts: int
) -> Iterator[dict[sp.Symbol, float]]:
    """Yield constants at which the residual vanishes at random points; none is nearly 0."""
    others = symbols_of(statement) - {*statement.solve_for, *statement.variables}
    numbers = {s: admissible(s, statement, draw) for s in sorted(others, key=str)}
    names = [*statement.variables, *statement.solve_for, *numbers]
    residual = residual_of(statement, statement.equations[0])
    function = sp.lambdify(names, residual, modules=[ELLIPTIC, "numpy"])
    points = np.array([[draw.uniform(-1.5, 1.5) for _ in statement.variables] for _ in range(14)])

    def values(constants: np.ndarray) -> np.ndarray:
        found = function(*points.T, *constants, *numbers.values())
        return np.clip(np.nan_to_num(np.broadcast_to(found, len(points)), nan=1e6), -1e8, 1e8)

    for _ in range(starts):
        start = [draw.uniform(-3, 3) for _ in statement.solve_for]
        with np.errstate(all="ignore"):
            found = least_squares(values, start, xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=300)
        sizes = np.abs(found.x)
        is_root = np.max(np.abs(found.fun)) < 1e-9 and np.max(sizes) < 6
        if is_root and not np.any((sizes > 1e-7) & (sizes < NEARLY_ZERO)):
            yield numbers | dict(zip(statement.solve_for, map(float, found.x), strict=True))


def check_completeness(seed: int) -> ConditionalVerdict:
    draw = random.Random(seed)
    statement = random_problem(draw)
    verdict = solve_statement(statement)
    for numbers in roots(statement, draw, 12):
        inside = any(holds_at(case, numbers, 2e-3) for case in verdict.cases)
        assert inside or not verdict.complete, (statement, numbers, verdict.detail)
    return verdict


@pytest.mark.parametrize("seed", family(range(12), slow=("0", "1", "7", "10")))
def test_what_least_squares_finds_is_in_a_case(seed: int) -> None:
    assert check_completeness(seed).complete


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 200))
def test_what_least_squares_finds_is_in_a_case_of_many(seed: int) -> None:
    check_completeness(seed)

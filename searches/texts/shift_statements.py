"""Lattice equations: shifts of the site beside derivatives."""

from __future__ import annotations

import random

from searches.texts.drafts import Draft, Known, random_parameters, random_phase
from searches.texts.system_statements import filled
from searches.texts.text_statement import TextStatement
from searches.texts.trees import Tree, name, put, read, total

TODA = "diff(q[n],t,t) - exp(q[n-1]-q[n]) + exp(q[n]-q[n+1])"
TODA_FLASCHKA = "diff(a[n],t) - a[n]*(b[n]-b[n+1]) ;; diff(b[n],t) + a[n] - a[n-1]"
VOLTERRA = "diff(u[n],t) - u[n]*(u[n+1] - u[n-1])"
AL = "I*diff(q[n],t) + (1 + abs(q[n])**2)*(q[n+1] + q[n-1]) - 2*q[n]"
MKDV = "diff(u[n],t) - (1 - u[n]**2)*(u[n+1] - u[n-1])"
FOCUSING_MKDV = "diff(u[n],t) - (1 + u[n]**2)*(u[n+1] - u[n-1])"

KNOWN = (
    Known(
        TODA,
        "q = log((1+exp(2*k*(n-1)-2*sinh(k)*t))/(1+exp(2*k*n-2*sinh(k)*t)))",
        "n t k>0",
        0.5,
    ),
    Known(TODA, "q = a*t + b*n", "n t a b", 1),
    Known(TODA_FLASCHKA, "a = k ;; b = c", "n t k c", 1),
    Known(VOLTERRA, "u = -n/(2*t)", "n t", 2),
    Known(VOLTERRA, "u = a", "n t a", 1),
    Known(VOLTERRA, "u = (a*n + b)/(c - 2*a*t)", "n t a b c", 2),
    Known(MKDV, "u = tanh(k)*tanh(k*n + 2*tanh(k)*t)", "n t k", 2),
    Known(FOCUSING_MKDV, "u = sinh(k)*sech(k*n + 2*sinh(k)*t)", "n t k", 2),
    Known(AL, "q = sinh(k)*sech(k*n)*exp(2*I*(cosh(k)-1)*t)", "n t k", 1),
    Known(AL, "q = a*exp(I*(k*n + 2*((1+a**2)*cos(k) - 1)*t))", "n t a k", 1),
    Known("diff(u[n],t) - u[n+1] + 2*u[n] - u[n-1]", "u = exp(k*n + (2*cosh(k)-2)*t)", "n t k", 3),
    Known("diff(u[n],t) - u[n+1] + 2*u[n] - u[n-1]", "u = exp(-4*t)*(-1)**n", "n t", 2),
    Known("diff(u[n],t,t) - u[n+1] + 2*u[n] - u[n-1]", "u = cos(k*n - 2*sin(k/2)*t)", "n t k", 2),
    Known("diff(u[n],t) - u[n+1] + u[n]", "u = r**n*exp((r-1)*t)", "n t r>0", 2),
    Known("u[n+1] - 2*cos(k)*u[n] + u[n-1]", "u = a*cos(k*n + b)", "n a b k", 2),
    Known("u[n+1] - 2*cosh(k)*u[n] + u[n-1]", "u = sinh(k*n)", "n k", 2),
    Known("u[n+1] - r*u[n]", "u = a*r**n", "n a r>0", 2),
    Known("u[n+1] + u[n]", "u = a*(-1)**n", "n a", 2),
    Known("u[n+2] - 3*u[n+1] + 2*u[n]", "u = a*2**n + b", "n a b", 2),
    Known("u[n+1] - u[n] - n", "u = n*(n-1)/2 + a", "n a", 2),
    Known("(n+1)*u[n+1] - n*u[n]", "u = a/n", "n>0 a", 2),
    Known("u[n+1]*(1 + tanh(k)*u[n]) - u[n] - tanh(k)", "u = tanh(k*n + a)", "n k a", 2),
    Known("u[n+1]*(1 - tan(k)*u[n]) - u[n] - tan(k)", "u = tan(k*n + a)", "n k:0:1 a", 1),
    Known("u[n+1]*(1 + u[n]) - u[n]", "u = 1/(n + a)", "n a", 2),
    Known("u[n+1] - u[n]**2", "u = exp(a*2**n)", "n a", 1),
    Known("u[n+1] - 2*u[n]**2 + 1", "u = cos(2**n*a)", "n a", 1),
    Known("u[n+1]*u[n-1] - u[n]**2*r", "u = r**(n**2/2)", "n r>0", 1),
    Known(
        "(u[n+1] + u[n-1])*(1 - m*jacobi_sn(h,m)**2*u[n]**2)"
        " - 2*jacobi_cn(h,m)*jacobi_dn(h,m)*u[n]",
        "u = jacobi_sn(h*n + a, m)",
        "n h a m:0:1",
        0.5,
    ),
    Known(
        "u[n]**2 + v[n]**2 - 1 ;; w[n]**2 + m*u[n]**2 - 1",
        "u = jacobi_sn(h*n, m) ;; v = jacobi_cn(h*n, m) ;; w = jacobi_dn(h*n, m)",
        "n h m:0:1",
        0.5,
    ),
    Known(
        MKDV,
        "u = k*jacobi_sn(h,k**2)*jacobi_sn(h*n + 2*jacobi_sn(h,k**2)*t, k**2)",
        "n t h k:0:1",
        0.5,
    ),
    Known("diff(u[n],t) - v[n] ;; v[n+1] - r*v[n]", "u = r**n*t ;; v = r**n", "n t r>0", 2),
    Known("u[n+1] - v[n] ;; v[n+1] - u[n]", "u = a + b*(-1)**n ;; v = a - b*(-1)**n", "n a b", 2),
    Known("u[n+1] - v[n] ;; v[n+1] + u[n]", "u = cos(pi*n/2) ;; v = -sin(pi*n/2)", "n", 1),
    Known("diff(u[n],x) - u[n+1]", "u = exp(a*x)*a**n", "n x a>0", 1),
    Known("u[n+1]**2 - u[n]**2 - 1", "u = sqrt(n + a)", "n>0 a>0", 1),
    Known("exp(u[n+1] - u[n]) - (n+1)/n", "u = log(n)", "n>0", 2),
    Known("exp(u[n+1] + u[n]) - n*(n+1)", "u = log(n)", "n>0", 1),
)  # fmt: skip

WEIGHTS = [known.weight for known in KNOWN]


def known_lattice(draw: random.Random) -> TextStatement | None:
    """One of `KNOWN` under symmetries."""
    return draw.choices(KNOWN, WEIGHTS)[0].draft(draw).statement("shifts: known")


SITES = (
    "exp({0})", "tanh({0})", "sin({0})", "cos({0})", "({0})**2", "{0}", "1/(1+({0})**2)",
    "sech({0})", "2**n", "(-1)**n", "(1/3)**n", "n*2**n", "exp(-n)", "log(1+exp({0}))", "n*t",
    "(-1)**n*exp({0})", "cos(pi*n)", "r**n", "t**2*n", "sinh({0})", "1/(n+1/2)", "sqrt(1+n**2)",
    "exp(I*({0}))", "(-2)**n", "4**(n/2)", "abs(n)", "atan({0})", "sin(pi*n/2)",
)  # fmt: skip

TERMS = (
    "{u}[n+1]", "{u}[n-1]", "{u}[n+1]*{u}[n]", "diff({u}[n], t)", "{u}[n+2]", "{u}[n]**2",
    "{u}[n+1]*{u}[n-1]", "n*{u}[n+1]", "diff({u}[n+1], t)", "exp({v}[n+1])", "{v}[n-1]*{u}[n]",
)  # fmt: skip


def site_formula(made: Draft, parameters: list[str]) -> Tree:
    """One or two functions of the site and the time."""
    draw = made.draw
    pieces = []
    for _ in range(draw.choice((1, 1, 2))):
        piece = read(draw.choice(SITES).format("Z"))
        if "r" in piece.names():
            made.letter("r>0")
        phase = random_phase(made, "nt", parameters)
        pieces.append(put(piece, {"Z": phase}))
    return (
        pieces[0]
        if len(pieces) == 1
        else draw.choice((pieces[0] * pieces[1], pieces[0] + made.constant(parameters) * pieces[1]))
    )


def with_sources(draw: random.Random) -> TextStatement | None:
    """Random formulas in random lattice equations, with their sources."""
    made = Draft(draw)
    made.letter(draw.choice(("n", "n", "n>0")))
    made.letter("t")
    parameters = random_parameters(made, 1)
    unknowns = draw.sample(("u", "v", "q"), draw.choice((1, 1, 2)))
    made.solutions = {u: site_formula(made, parameters) for u in unknowns}
    for mine in unknowns:
        terms = [
            made.constant(parameters)
            * read(draw.choice(TERMS).format(u=mine, v=draw.choice(unknowns)), tuple(unknowns))
            for _ in range(draw.choice((1, 2)))
        ]
        left = total(*terms)
        made.equations.append(left - filled(left, made.solutions))
    used = {node.jet[0] for e in made.equations for node in e.nodes() if node.head == "jet"}
    made.solutions = {u: f for u, f in made.solutions.items() if u in used}
    return made.statement("shifts: source")


def travelling(draw: random.Random) -> TextStatement | None:
    """A wave that moves a site in a time: a shift of the site is one of the time."""
    made = Draft(draw)
    for letter in ("n", "t"):
        made.letter(letter)
    parameters = random_parameters(made, 1)
    formula = site_formula(made, parameters)
    moved = put(formula, {"n": name("n") - 1, "t": name("t") + 1})
    made.solutions = {"u": formula, "v": moved}
    later = filled(read("u[n-1]", ("u",)), made.solutions)
    made.equations = [read("v[n] - w[n]", ("v", "w"))]
    made.solutions = {"v": moved, "w": put(later, {"t": name("t") + 1})}
    return made.statement("shifts: moved")


MAKERS = ((known_lattice, 6), (with_sources, 5), (travelling, 1))
"""The kinds of lattice statements, each with its share."""

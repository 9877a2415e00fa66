"""Ansaetze in text with values of constants that are planted: they solve the equations.

Formulas stand in two ways that are equal on the domain; SymPy reads some as something else.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

EVERYWHERE = (
    ("sign(exp(I*z))**2", "exp(2*I*z)"),
    ("sign(exp(z + 2*I*z))**2", "exp(4*I*z)"),
    ("sign(1 + I*z)**2", "(1 + I*z)/(1 - I*z)"),
    ("sign(2 + I*z)**4", "((2 + I*z)/(2 - I*z))**2"),
    ("sign(1 - I*z)**(-2)", "(1 + I*z)/(1 - I*z)"),
    ("sign(1 + I*z)*abs(1 + I*z)", "1 + I*z"),
    ("conjugate(sign(1 + I*z))*sign(1 + I*z)*z", "z"),
    ("(1 + I*z)**2/abs(1 + I*z)**2", "sign(1 + I*z)**2"),
    ("sign(I*cosh(z))**2*z", "-z"),
    ("sign(-I*exp(z))**2*z", "-z"),
    ("sign(sqrt(-1 - z**2))**2*z", "-z"),
    ("sign(log(-cosh(z)) - log(cosh(z)))**2*z", "-z"),
    ("sign(cosh(z))*z", "z"),
    ("abs(1 + I*z)**2", "1 + z**2"),
    ("abs(exp(z + I*z))**3", "exp(3*z)"),
    ("abs(I*z)**2", "z**2"),
    ("abs(z)**4", "z**4"),
    ("conjugate(exp(I*z))", "exp(-I*z)"),
    ("conjugate(1/(1 + I*z))", "1/(1 - I*z)"),
    ("re(exp(I*z))", "cos(z)"),
    ("im(exp(2*I*z))", "sin(2*z)"),
    ("re((1 + I*z)**3)", "1 - 3*z**2"),
    ("im((z + I)**2)", "2*z"),
    ("re(I*z + z)", "z"),
    ("sqrt(cosh(z)**2)", "cosh(z)"),
    ("sqrt((1 + I*z)**2)", "1 + I*z"),
    ("sqrt(-1 - z**2)", "I*sqrt(1 + z**2)"),
    ("(-1 - z**2)**(3/2)", "-I*(1 + z**2)**(3/2)"),
    ("log(-cosh(z))", "log(cosh(z)) + I*pi"),
    ("log(exp(z))", "z"),
    ("exp(2*log(cosh(z)))", "cosh(z)**2"),
    ("atanh(tanh(z))", "z"),
    ("asinh(sinh(z))", "z"),
    ("exp(I*z)**3", "cos(3*z) + I*sin(3*z)"),
    ("tanh(z)", "(exp(2*z) - 1)/(exp(2*z) + 1)"),
    ("sech(z)**2", "1 - tanh(z)**2"),
)
"""Formulas in a real z and the same in other words."""

WITHIN = (
    ("x>0", "sqrt(x**2)", "x"),
    ("x>0", "abs(x)**3", "x**3"),
    ("x>0", "sqrt(-x)", "I*sqrt(x)"),
    ("x>0", "sign(sqrt(-x))**2*x", "-x"),
    ("x>0", "sqrt(x*(x + 1))", "sqrt(x)*sqrt(x + 1)"),
    ("x>0", "(-x)**(1/3)", "x**(1/3)*(1 + sqrt(3)*I)/2"),
    ("x>0", "log(-x)", "log(x) + I*pi"),
    ("x>0", "sign(log(-x) - log(x))**2*x", "-x"),
    ("x>0", "sign(x)**3*x", "x"),
    ("x>0", "acosh(cosh(x))", "x"),
    ("x<0", "sqrt(x**2)", "-x"),
    ("x<0", "abs(x)**3", "-x**3"),
    ("x<0", "sign(sqrt(x))**2*x", "-x"),
    ("x<0", "sqrt(x)*sqrt(x - 1)", "-sqrt(x*(x - 1))"),
    ("x<0", "x**(2/3)", "(-x)**(2/3)*(sqrt(3)*I - 1)/2"),
    ("x<0", "(x**3)**(1/3)", "-x*(1 + sqrt(3)*I)/2"),
    ("x<0", "log(x**2)", "2*log(-x)"),
    ("x<0", "acosh(cosh(x))", "-x"),
    ("x<0", "sign(x)*x**2", "-x**2"),
    ("x != 0", "sign(sqrt(x))**2*x", "abs(x)"),
    ("x != 0", "sign(x)**2*x", "x"),
    ("x != 0", "sign(I*x)**2*x", "-x"),
    ("0<x<3", "sqrt(sin(x)**2)", "sin(x)"),
    ("2<x<4", "abs(cos(x))", "-cos(x)"),
    ("2<x<4", "asin(sin(x))", "pi - x"),
    ("4<x<5", "acos(cos(x))", "2*pi - x"),
    ("4<x<5", "log(exp(I*x))", "I*x - 2*pi*I"),
    ("2<x<3", "sqrt(exp(2*I*x))", "-exp(I*x)"),
    ("2<x<4", "atan(tan(x))", "x - pi"),
    ("0<x<1", "sqrt(x - 3)*sqrt(x - 5)", "-sqrt((x - 3)*(x - 5))"),
    ("0<x<1", "abs(x - 2)", "2 - x"),
    ("0<x<1", "sign(sqrt(x - 2))**2*x", "-x"),
)
"""Domains of x, formulas, and the same in other words."""

CONSTANTS = (
    ("p: p>0", "abs(p)", "p"),
    ("p: p>0", "sqrt(p**2)", "p"),
    ("p: p>0", "sqrt(-p)**2", "-p"),
    ("p: p>0", "sign(sqrt(-p))**2*p", "-p"),
    ("p: p>0", "re(p + I)", "p"),
    ("p: p<0", "abs(p)", "-p"),
    ("p: p<0", "sqrt(p**2)", "-p"),
    ("p: p<0", "sign(sqrt(p))**2*p", "-p"),
    ("p: p<0", "sqrt(p)*sqrt(p - 1)", "-sqrt(p*(p - 1))"),
    ("p: p != 0", "sign(p)**2*p", "p"),
    ("p: p != 0", "sign(sqrt(p))**2", "sign(p)"),
    ("p: p != 0", "sign(I*p)**2*p", "-p"),
    ("p: p != 0", "abs(p)/p", "sign(p)"),
    ("p: real", "sqrt(p**2)", "abs(p)"),
    ("p: real", "abs(p)**2", "p**2"),
    ("p: real", "re(sign(2 + I*p)**2)", "(4 - p**2)/(4 + p**2)"),
    ("p: real", "abs(p + I)**2", "p**2 + 1"),
    ("p: 0<p<1", "sqrt((p - 1)**2)", "1 - p"),
    ("p: 0<p<1", "sign(sqrt(p - 2))**2*p", "-p"),
    ("p: p>1", "abs(1 - p)", "p - 1"),
)
"""Declarations, formulas of a constant, and the same in other words."""

SITES = (
    ("", "(-1)**(2*n)*n", "n"),
    ("", "cos(pi*n)", "(-1)**n"),
    ("", "(-2)**n", "(-1)**n*2**n"),
    ("", "(-1)**(n**2)", "(-1)**n"),
    ("", "(-1)**n*(-1)**n*n", "n"),
    ("", "abs((-1)**n)*n", "n"),
    ("", "re((-1)**n)", "(-1)**n"),
    ("", "sign(exp(I*n))**2", "exp(2*I*n)"),
    ("", "sqrt(n**2)", "abs(n)"),
    ("", "(1 + (-1)**n)**2", "2 + 2*(-1)**n"),
    ("n>0", "abs(n)", "n"),
    ("n>0", "sqrt(n**2)", "n"),
    ("n>0", "sign(n)*n**2", "n**2"),
    ("n>1", "abs(n - 1)", "n - 1"),
    ("n<0", "abs(n)", "-n"),
)
"""Domains of sites, formulas, and the same in other words."""

PHASES = (
    (2, "sign(exp(I*x))**2"),
    (4, "sign(exp(I*x))**4"),
    (2, "sign(exp(I*x/2))**4"),
    (-2, "conjugate(exp(2*I*x))"),
    (3, "exp(I*x)**3"),
    (1, "sign(exp(x + I*x))"),
    (2, "sign(exp(2*x + I*x))**2"),
    (1, "exp(I*re(x + 3*I))"),
)
"""Wave numbers, and phases of a carrier."""

BOUNDS = {
    "p: p>0": (0.2, 2), "p: p<0": (-2, -0.2), "p: p != 0": (-2, 2), "p: real": (-2, 2),
    "p: 0<p<1": (0.05, 0.95), "p: p>1": (1.05, 3), "x>0": (0.2, 2), "x<0": (-2, -0.2),
    "x != 0": (-2, 2), "0<x<3": (0.2, 2.8), "2<x<4": (2.1, 3.9), "4<x<5": (4.05, 4.65),
    "2<x<3": (2.1, 2.9), "0<x<1": (0.1, 0.9), "n>0": (1, 6), "n>1": (2, 7), "n<0": (-7, -2),
}  # fmt: skip
"""Values that are drawn on a domain."""

POWERS = ("w", "w", "w**2", "w**3", "w**2 + w", "2*w - 1", "w**2 - w")


@dataclass(frozen=True)
class Planted:
    """Equations, an ansatz, and the ``values`` of wanted constants that solve it, as texts.

    ``bounds`` are those of variables and of constants that are not wanted.
    """

    kind: str
    equations: tuple[str, ...]
    solutions: tuple[str, ...]
    values: Mapping[str, str]
    parameters: str = ""
    domain: str = ""
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def solve(self) -> str:
        """The wanted constants."""
        return ", ".join(self.values)


def _argument(draw: random.Random) -> str:
    return draw.choice(("x", "x", "(2*x + 1)", "(x - 3*t)", "(x + t/2)", "(p*x)", "(x - p*t)"))


def _worded(draw: random.Random) -> tuple[str, str, str]:
    """A formula of x, the same in other words, and its domain; the two in either order."""
    domain, *both = draw.choice(WITHIN) if draw.random() < 0.5 else ("", *draw.choice(EVERYWHERE))
    if not domain:
        z = _argument(draw)
        both = [text.replace("exp", "E").replace("z", z).replace("E", "exp") for text in both]
    draw.shuffle(both)
    return both[0], both[1], domain


def _bounds(*texts: str, declared: str = "", domain: str = "") -> dict[str, tuple[float, float]]:
    found = dict.fromkeys("xt", (-1.5, 1.5))
    if any("p" in text.replace("exp", "").replace("pi", "") for text in texts) or declared:
        found["p"] = BOUNDS[declared or "p: real"]
    return found | ({domain.strip("0123456789<>!= ")[:1]: BOUNDS[domain]} if domain else {})


def summed(draw: random.Random) -> Planted:
    """u = a*L + b*x where L' is in the equation in other words."""
    one, other, domain = _worded(draw)
    g, h = (f"{draw.randint(1, 9)}/{draw.randint(1, 5)}" for _ in range(2))
    return Planted(
        "sum",
        (f"u_x - ({g})*diff({other}, x) - {h}",),
        (f"u = a*({one}) + b*x",),
        {"a": g, "b": h},
        domain=domain,
        bounds=_bounds(one, other, domain=domain),
    )


def multiplied(draw: random.Random) -> Planted:
    """u = a*L*exp(f(w)*x) where the slope of L is in the equation in other words."""
    one, other, domain = _worded(draw)
    power, w = draw.choice(POWERS), f"({draw.randint(1, 5)}/{draw.randint(1, 3)})"
    rate = power.replace("w", w)
    return Planted(
        "product",
        (f"({other})*u_x - (diff({other}, x) + ({rate})*({other}))*u",),
        (f"u = a*({one})*exp(({power})*x)",),
        {"w": w},
        domain=domain,
        bounds={**_bounds(one, other, domain=domain), "a": (0.5, 2)},
    )


def carried(draw: random.Random) -> Planted:
    """The bright soliton of the NLS equation on a carrier."""
    q, phase = draw.choice(PHASES)
    wanted = draw.choice(({"w": f"a**2 - {q * q}"}, {"a": "k", "w": f"k**2 - {q * q}"}))
    scale = "k" if "a" in wanted else "a"
    return Planted(
        "carrier",
        ("I*u_t + u_xx + 2*abs(u)**2*u",),
        (f"u = a*sech({scale}*(x - ({2 * q})*t))*{phase}*exp(I*w*t)",),
        wanted,
        parameters=f"{scale}: {scale}>0",
        bounds={"x": (-1, 1), "t": (-0.2, 0.2), scale: (0.4, 1.5)},
    )


def constant(draw: random.Random) -> Planted:
    """u = f(w)*C*x where the equation has C in other words."""
    declared, *both = draw.choice(CONSTANTS)
    draw.shuffle(both)
    power, w = draw.choice(POWERS), f"({draw.randint(1, 5)}/{draw.randint(1, 3)})"
    return Planted(
        "constant",
        (f"u_x - ({power.replace('w', w)})*({both[0]})",),
        (f"u = ({power})*({both[1]})*x",),
        {"w": w},
        parameters=declared,
        bounds={"x": (-1, 1), "p": BOUNDS[declared]},
    )


def root(draw: random.Random) -> Planted:
    """u = exp(w*x) where w**2 is a product of a constant and a square."""
    declared, *both = draw.choice([row for row in CONSTANTS if row[0] != "p: p<0"])
    draw.shuffle(both)
    g = draw.randint(1, 5)
    square = draw.choice(("", "*q**2", "*(q - 1)**2", "*(q + p)**2"))
    bare = square.removesuffix("**2").removeprefix("*") or "1"
    return Planted(
        "root",
        (f"u_xx - {g}*({both[0]})**2{square}*u",),
        ("u = exp(w*x)",),
        {"w": f"{draw.choice(('', '-'))}sqrt({g})*({both[1]})*({bare})"},
        parameters=declared,
        bounds={"x": (-1, 1), "p": BOUNDS[declared], **({"q": (-2, 2)} if square else {})},
    )


def vanishing(draw: random.Random) -> Planted:
    """u = exp(w*x) where w = 0 solves it at the zero of a factor, whatever a sign is."""
    g = draw.randint(1, 4)
    factor, p = draw.choice((("(p - 1)**2", "1"), ("p**2", "0"), ("(p + 2)**4", "-2")))
    return Planted(
        "vanishing",
        (f"u_xx - {g}*q*{factor}*u",),
        ("u = exp(w*x)",),
        {"w": "0", "p": p},
        bounds={"x": (-1, 1), "q": (-2, 2)},
    )


def doubled(draw: random.Random) -> Planted:
    """u = exp(w*x) where a root in w**2 is real at the zero of what stands before it."""
    g = draw.randint(1, 4)
    return Planted(
        "doubled",
        (f"u_xxxx - {2 * g}*b*u_xx + ({g * g}*b**2 - q*(p - 1)**2)*u",),
        ("u = exp(w*x)",),
        {"w": f"{draw.choice(('', '-'))}sqrt({g}*b)", "p": "1"},
        parameters="b: b>0",
        bounds={"x": (-1, 1), "q": (-2, 2), "b": (0.3, 1)},
    )


def closed(draw: random.Random) -> Planted:
    """u = a*x where a = 0 is the end of a domain, and a square times what may be negative."""
    g, end = draw.randint(1, 4), draw.choice((">=", "<="))
    return Planted(
        "closed",
        (f"u_x - {g}*q*(p - 1)**2",),
        ("u = a*x",),
        {"a": "0", "p": "1"},
        parameters=f"a: a {end} 0",
        bounds={"x": (-1, 1), "q": (-2, 2)},
    )


def finite(draw: random.Random) -> Planted:
    """u[n] = a*n**2 at two sites or one, where polynomials agree that differ elsewhere."""
    g, last = draw.randint(1, 5), draw.choice((2, 3))
    other = "*".join(f"(n - {place})" for place in range(1, last))
    return Planted(
        "finite",
        (f"u[n+1] - u[n] - {g}*(2*n + 1 + {draw.randint(1, 5)}*{other})",),
        ("u[n] = a*n**2",),
        {"a": str(g)},
        parameters=draw.choice(("", "a: a>0")),
        domain=f"0<n<{last}",
        bounds={"n": (1, last - 1)},
    )


def signed(draw: random.Random) -> Planted:
    """u = b*sign(a + I*x)**2, which is (a + I*x)/(a - I*x)."""
    m, half = draw.randint(1, 5), draw.choice((1, 2))
    declared = draw.choice(("", "a: a>0", "a: a != 0"))
    return Planted(
        "signed",
        (f"({m}**2 + x**2)*u_x - {2 * half}*I*{m}*u",),
        (f"u = b*sign(a + I*x)**{2 * half}",),
        {"a": str(m)},
        parameters=declared,
        bounds={"x": (-1, 1), "b": (0.5, 2)},
    )


ATOMS = ("x", "x", "x", "(x + 1)", "(x - 2)", "2*x", "(-x)", "(I*x)", "(1 + I*x)", "(x - I)", "3/2")
OUTER = (
    "sign",
    "abs",
    "re",
    "im",
    "conjugate",
    "sqrt",
    "exp",
    "log",
    "sin",
    "cosh",
    "tanh",
    "atan",
)
EXPONENTS = ("2", "2", "3", "4", "(-1)", "(-2)", "(1/2)", "(3/2)", "(1/3)")


def _formula(draw: random.Random, depth: int) -> str:
    """A random formula of x, in brackets where it is no atom."""
    if depth == 0:
        return draw.choice(ATOMS)
    kind, inner = draw.random(), _formula(draw, depth - 1)
    if kind < 0.5:
        return f"{draw.choice(OUTER)}({inner})"
    if kind < 0.75:
        return f"({inner})**{draw.choice(EXPONENTS)}"
    return f"({inner} {draw.choice('+-**/')} {_formula(draw, depth - 1)})"


def powered(draw: random.Random) -> Planted:
    """u = (a*R)**m with any formula R, in an equation with the slope of R and its other powers."""
    inner, m, g = _formula(draw, draw.choice((2, 3, 3))), draw.choice((1, 2, 3)), draw.randint(1, 5)
    lower = "" if m == 1 else f"*({inner})" if m == 2 else f"*({inner})**2"
    domain, bounds = draw.choice((("0<x<1", (0.1, 0.9)), ("-1<x<0", (-0.9, -0.1))))
    return Planted(
        "powered",
        (f"u_x - {m * g**m}{lower}*diff({inner}, x)",),
        (f"u = (a*({inner}))**{m}",),
        {"a": str(g)},
        parameters=draw.choice(("", "a: a>0", "a: a != 0")),
        domain=domain,
        bounds={"x": bounds},
    )


def site(draw: random.Random) -> Planted:
    """u[n] = a*L + b*n where the difference of L is in the equation in other words."""
    domain, *both = draw.choice(SITES)
    draw.shuffle(both)
    up = draw.random() < 0.7 or domain != ""
    moved = both[0].replace("sign", "S").replace("n", "(n + 1)" if up else "(n - 1)")
    moved = moved.replace("S", "sign")
    g, h = (str(draw.randint(1, 9)) for _ in range(2))
    shift = "+1" if up else "-1"
    return Planted(
        "site",
        (f"u[n{shift}] - u[n] - {g}*({moved}) + {g}*({both[0]}) - ({h if up else '-' + h})",),
        (f"u[n] = a*({both[1]}) + b*n",),
        {"a": g, "b": h},
        domain=domain,
        bounds={"n": BOUNDS[domain] if domain else (-5, 5)},
    )


TEXTBOOK = (
    ("u_t + P*u*u_x + Q*u_xxx", "u = a*sech(k*(x - c*t))**2",
     {"a": "12*Q*k**2/P", "c": "4*Q*k**2"}, "k: k>0"),
    ("u_t + P*u*u_x + Q*u_xxx", "u = a*sech(k*(x - c*t))**2",
     {"k": "sqrt(P*a/(12*Q))", "c": "P*a/3"}, "k: k>0; a: a>0"),
    ("u_t + P*u**2*u_x + Q*u_xxx", "u = a*sech(k*(x - c*t))",
     {"a": "k*sqrt(6*Q/P)", "c": "Q*k**2"}, "k: k>0"),
    ("u_t + P*u*u_x - Q*u_xx", "u = c/P + b*tanh(k*(x - c*t))", {"b": "-2*Q*k/P"}, "k: k>0"),
    ("u_t - P*u_xx - Q*u*(1 - u)", "u = 1/(1 + exp(k*(x - c*t)))**2",
     {"k": "sqrt(Q/(6*P))", "c": "5*sqrt(P*Q/6)"}, "k: k>0"),
    ("I*u_t + P*u_xx + Q*abs(u)**2*u", "u = a*sech(k*x)*exp(I*w*t)",
     {"a": "k*sqrt(2*P/Q)", "w": "P*k**2"}, "k: k>0"),
    ("I*u_t + P*u_xx - Q*abs(u)**2*u", "u = a*tanh(k*x)*exp(I*w*t)",
     {"a": "k*sqrt(2*P/Q)", "w": "-2*P*k**2"}, "k: k>0"),
    ("u_tt - P*u_xx + Q*u", "u = cos(k*x - w*t)", {"w": "sqrt(P*k**2 + Q)"}, "k: k>0; w: w>0"),
    ("P*u_xx + Q*u", "u = cos(k*x)", {"k": "sqrt(Q/P)"}, ""),
    ("u_t + P*u_x + Q*u_xxx", "u = sin(k*x - w*t)", {"w": "P*k - Q*k**3"}, "k: k>0"),
    ("u_t + P*u_x - Q*u_xxt", "u = cos(k*x - w*t)", {"w": "P*k/(1 + Q*k**2)"}, "k: k>0"),
    ("h_t + P*v_x ;; v_t + Q*h_x", "h = cos(k*x - w*t) ;; v = b*cos(k*x - w*t)",
     {"b": "sqrt(Q/P)", "w": "k*sqrt(P*Q)"}, "k: k>0"),
    ("u_tt - P*u_xx - Q*u + Q*u**3", "u = tanh(k*(x - c*t))",
     {"k": "sqrt(Q/(2*P - 2*c**2))"}, "k: k>0; c: 0<c<1/10"),
    ("u_t - P*u_xx + Q*u*(u - 1)*(u - r)", "u = 1/(1 + exp(k*(x - c*t)))",
     {"k": "sqrt(Q/(2*P))", "c": "sqrt(2*P*Q)*(1/2 - r)"}, "k: k>0; r: 0<r<1"),
)  # fmt: skip
"""Equations with coefficients P, Q > 0, ansaetze, values and declarations."""


def textbook(draw: random.Random) -> Planted:
    """A wave of a textbook; its coefficients are numbers, or declared positive, or written so."""
    equations, solutions, values, declared = draw.choice(TEXTBOOK)
    free = {name: (0.3, 1.5) for name in "kar" if f"{name}: " in declared and name not in values}
    free |= {"c": (0.01, 0.09)} if "c" not in values and "c*t" in solutions else {}
    free |= {"r": (0.1, 0.9)} if "r" in free else {}
    replaced, entries = {}, [declared] if declared else []
    for name in "PQ":
        kind = draw.random()
        if kind < 0.4:
            replaced[name] = f"({draw.randint(1, 9)}/{draw.randint(1, 4)})"
            continue
        letter = "fg"["PQ".index(name)]
        replaced[name] = draw.choice((letter, letter, f"abs({letter})", f"sqrt({letter}**2)"))
        entries.append(f"{letter}: {letter}>0")
        free[letter] = (0.3, 2)

    def put(text: str) -> str:
        return text.replace("P", replaced["P"]).replace("Q", replaced["Q"])

    return Planted(
        "textbook",
        tuple(put(equations).split(" ;; ")),
        tuple(put(solutions).split(" ;; ")),
        {name: put(text) for name, text in values.items()},
        parameters="; ".join(entries),
        bounds={"x": (-1, 1), "t": (-0.5, 0.5), **free},
    )


MAKERS: tuple[Callable[[random.Random], Planted], ...] = (
    *(summed, summed, multiplied, multiplied, carried, constant, root, site),
    *(vanishing, doubled, closed, finite, signed, textbook, textbook, textbook),
    *(powered, powered, powered),
)


def planted(seed: int, index: int) -> Planted:
    """The ansatz of a number."""
    draw = random.Random(f"{seed}/{index}")
    return MAKERS[index % len(MAKERS)](draw)

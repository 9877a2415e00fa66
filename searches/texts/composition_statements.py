"""Functions of unknowns and of inverse functions: branches, signs, powers with letters."""

from __future__ import annotations

import random
from dataclasses import dataclass, replace
from fractions import Fraction

from searches.texts.drafts import (
    Draft,
    Known,
    random_formula,
    random_parameters,
    random_phase,
    stay_under,
)
from searches.texts.text_statement import Letter, TextStatement, Truth
from searches.texts.trees import Tree, derivative, mapped, name, put, read

KNOWN = (
    Known("u_tt - u_xx + sin(u)", "u = 4*atan(exp((x - c*t)/sqrt(1 - c**2)))", "x t c:-1:1", 1),
    Known("u_xt - sin(u)", "u = 4*atan(exp(a*x + t/a))", "x t a", 1),
    Known("u_xx - sin(u)", "u = 4*atan(exp(x))", "x", 1),
    Known("u_x - sin(u)", "u = 2*atan(exp(x + a*t))", "x t a", 2),
    Known("u_x - cos(u)", "u = 2*atan(tanh(x/2))", "x", 1),
    Known("u_xt - exp(u)", "u = log(2/(x+t)**2)", "x t", 2),
    Known("u_xt - exp(u)", "u = log(2*a*b*exp(a*x+b*t)/(exp(a*x)+exp(b*t))**2)", "x t a>0 b>0", 1),
    Known("u_xx + 2*a**2*exp(u)", "u = -2*log(cosh(a*x))", "x a", 2),
    Known("u_t - u_xx - u_x**2", "u = log(1 + exp(k*x + k**2*t))", "x t k", 2),
    Known("u_t - u_xx - u_x**2", "u = log(cosh(k*x)) + k**2*t", "x t k", 2),
    Known("u_xt - sinh(u)", "u = 2*log(tanh((k*x + t/k)/2))", "x>0 t>0 k>0", 1),
    Known("u_xt - sinh(u)", "u = 4*atanh(exp(k*x + t/k))", "x<0 t<0 k>0", 1),
    Known("u_t - u_xx - u*(1 - u)", "u = (1+exp((x - 5*t/sqrt(6))/sqrt(6)))**(-2)", "x t", 1),
    Known("u_x**2 + u_y**2 - 1", "u = sqrt(x**2 + y**2)", "x y", 2),
    Known("u_t + u_x**2/2", "u = (x-a)**2/(2*t)", "x t a", 1),
    Known("u_x - sqrt(1 + u**2)", "u = sinh(x)", "x", 2),
    Known("u_x - sqrt(1 - u**2)", "u = sin(x)", "x:-3/2:3/2", 2),
    Known("u_x - sqrt(u**2 - 1)", "u = cosh(x)", "x>0", 2),
    Known("u_x - abs(u)", "u = exp(x)", "x", 1),
    Known("u_x - u*log(u)", "u = exp(a*exp(x))", "x a", 2),
    Known("u_x - tan(u)", "u = asin(exp(x))", "x<0", 1),
    Known("u_x - exp(-u)", "u = log(x)", "x>0", 1),
    Known("u_x - u**g", "u = ((1-g)*x)**(1/(1-g))", "x>0 g:0:1", 2),
    Known("u_x - g*u/x", "u = a*x**g", "x>0 g a", 2),
    Known("u_t - diff(u**g, x, x)", "u = ((g-1)/g*c*(c*t - x))**(1/(g-1))",
          "x<0 t>0 g:1:4 c>0", 1),
    Known("x*u_x + y*u_y - g*u", "u = (x**2+y**2)**(g/2)", "x>0 y g", 2),
    Known("u_x - a*u + u**(g+1)", "u = (a/(1+exp(-g*a*x)))**(1/g)", "x g>0 a>0", 2),
    Known("u*u_x - 1/2", "u = sqrt(x)", "x", 1),
    Known("1/u - u_x", "u = sqrt(2*x + a**2)", "x a", 1),
    Known("u_xx*u - u_x**2 + u**2/cosh(x)**2*(-1)", "u = cosh(x)", "x", 1),
    Known("sqrt(u) - u_x", "u = x**2/4", "x>0", 2),
    Known("u_x**2 - 4*u", "u = x**2", "x", 1),
)  # fmt: skip

WEIGHTS = [known.weight for known in KNOWN]


def known_composition(draw: random.Random) -> TextStatement | None:
    """One of `KNOWN` under symmetries."""
    return draw.choices(KNOWN, WEIGHTS)[0].draft(draw).statement("compositions: known")


@dataclass(frozen=True)
class Composed:
    """outer(inner(f)) = value(f) for all f between ``low`` and ``high``, and often not beyond."""

    outer: str
    inner: str
    value: str
    low: Fraction | None = None
    high: Fraction | None = None


def _above(low: int, *triples: tuple[str, str, str]) -> tuple[Composed, ...]:
    return tuple(Composed(*triple, low=Fraction(low)) for triple in triples)


def _between(end: Fraction | int, *triples: tuple[str, str, str]) -> tuple[Composed, ...]:
    return tuple(Composed(*triple, low=-Fraction(end), high=Fraction(end)) for triple in triples)


COMPOSED = (
    *_above(
        0,
        ("exp(u)", "log(f)", "f"),
        ("exp(2*u)", "log(f)", "f**2"),
        ("exp(-u/2)", "log(f)", "1/sqrt(f)"),
        ("tanh(u)", "log(f)", "(f**2-1)/(f**2+1)"),
        ("sinh(u)", "log(f)", "(f-1/f)/2"),
        ("cosh(u)", "log(f)", "(f+1/f)/2"),
        ("log(u)", "f**2", "2*log(f)"),
        ("log(u)", "3*f**2", "log(3*f) + log(f)"),
        ("log(u)", "(f+1)/f", "log(f+1) - log(f)"),
        ("log(u)", "1/f", "-log(f)"),
        ("sqrt(u)", "f**2", "f"),
        ("u**(1/3)", "f**3", "f"),
        ("u**(3/2)", "f**2", "f**3"),
        ("u**(1/4)", "f**2", "sqrt(f)"),
        ("abs(u)", "-f", "f"),
        ("abs(u)*u", "f", "f**2"),
        ("sign(u)", "f", "1"),
        ("u**g", "f", "exp(g*log(f))"),
        ("u**g", "f**(1/g)", "f"),
        ("u**g", "f**2", "f**(2*g)"),
        ("log(u)", "f**g", "g*log(f)"),
        ("u**g*u**(1-g)", "f", "f"),
        ("acosh(u)", "cosh(f)", "f"),
        ("atan(u)", "1/f", "pi/2 - atan(f)"),
        ("atan(u)", "(f-1)/(f+1)", "atan(f) - pi/4"),
        ("sqrt(u)*sqrt(u+1)", "f", "sqrt(f**2+f)"),
        ("sqrt(-u)", "f", "I*sqrt(f)"),
        ("log(-u)", "f", "log(f) + I*pi"),
    ),
    *_above(
        1,
        ("cosh(u)", "acosh(f)", "f"),
        ("sinh(u)", "acosh(f)", "sqrt(f-1)*sqrt(f+1)"),
        ("exp(u)", "acosh(f)", "f + sqrt(f**2-1)"),
        ("sqrt(u)", "(f-1)**2", "f-1"),
        ("log(u)", "f**2-1", "log(f-1) + log(f+1)"),
        ("abs(u-1)", "f", "f-1"),
    ),
    *_between(
        1,
        ("sin(u)", "asin(f)", "f"),
        ("cos(u)", "asin(f)", "sqrt(1-f**2)"),
        ("cos(2*u)", "asin(f)", "1-2*f**2"),
        ("tan(u)", "asin(f)", "f/sqrt(1-f**2)"),
        ("cos(u)", "acos(f)", "f"),
        ("sin(u)", "acos(f)", "sqrt(1-f**2)"),
        ("sin(2*u)", "acos(f)", "2*f*sqrt(1-f**2)"),
        ("asin(f) + u", "acos(f)", "pi/2"),
        ("tanh(u)", "atanh(f)", "f"),
        ("exp(2*u)", "atanh(f)", "(1+f)/(1-f)"),
        ("cosh(u)", "atanh(f)", "1/sqrt(1-f**2)"),
        ("log(u)", "(1+f)/(1-f)", "2*atanh(f)"),
        ("sqrt(u)", "(1-f)**2", "1-f"),
        ("sqrt(u)", "(1-f**2)**2", "1-f**2"),
        ("sqrt(1-u)*sqrt(1+u)", "f", "sqrt(1-f**2)"),
        ("atan(u)", "2*f/(1-f**2)", "2*atan(f)"),
        ("atan(u)", "f/sqrt(1-f**2)", "asin(f)"),
    ),
    *_between(
        Fraction(3, 2),
        ("atan(u)", "tan(f)", "f"),
        ("asin(u)", "sin(f)", "f"),
        ("sqrt(1-u**2)", "sin(f)", "cos(f)"),
        ("sqrt(1+u**2)", "tan(f)", "1/cos(f)"),
        ("log(u)", "exp(I*f)", "I*f"),
        ("sqrt(u)", "exp(2*I*f)", "exp(I*f)"),
        ("sqrt(2+2*u)", "cos(f)", "2*cos(f/2)"),
    ),
    *(
        Composed(*triple)
        for triple in (
            ("sin(u)", "atan(f)", "f/sqrt(1+f**2)"),
            ("cos(u)", "atan(f)", "1/sqrt(1+f**2)"),
            ("tan(u)", "atan(f)", "f"),
            ("sin(2*u)", "atan(f)", "2*f/(1+f**2)"),
            ("cos(2*u)", "atan(f)", "(1-f**2)/(1+f**2)"),
            ("sin(4*u)", "atan(f)", "4*f*(1-f**2)/(1+f**2)**2"),
            ("cos(4*u)", "atan(f)", "1-8*f**2/(1+f**2)**2"),
            ("tan(2*u)", "atan(f)", "2*f/(1-f**2)"),
            ("exp(2*I*u)", "atan(f)", "(1+I*f)/(1-I*f)"),
            ("sinh(u)", "asinh(f)", "f"),
            ("cosh(u)", "asinh(f)", "sqrt(1+f**2)"),
            ("exp(u)", "asinh(f)", "f+sqrt(1+f**2)"),
            ("sinh(2*u)", "asinh(f)", "2*f*sqrt(1+f**2)"),
            ("tanh(u)", "asinh(f)", "f/sqrt(1+f**2)"),
            ("log(u)", "exp(f)", "f"),
            ("log(u)", "f + sqrt(1+f**2)", "asinh(f)"),
            ("log(u)", "f**2", "2*log(abs(f))"),
            ("sqrt(u)", "f**2", "abs(f)"),
            ("sqrt(u)", "f**4", "f**2"),
            ("u**(1/4)", "f**2", "sqrt(abs(f))"),
            ("abs(u)**2", "f", "f**2"),
            ("abs(u)", "f**3", "abs(f)*f**2"),
            ("sign(u)*u", "f", "abs(f)"),
            ("asinh(u)", "sinh(f)", "f"),
            ("atanh(u)", "tanh(f)", "f"),
            ("atan(u)", "sinh(f)", "2*atan(tanh(f/2))"),
            ("sqrt(1+u**2)", "sinh(f)", "cosh(f)"),
            ("sqrt(1-u**2)", "tanh(f)", "sech(f)"),
            ("sqrt(u**2-1)", "cosh(f)", "abs(sinh(f))"),
            ("u**(1/3)", "exp(f)", "exp(f/3)"),
            ("u**g", "exp(f)", "exp(g*f)"),
            ("log(u**g)", "exp(f)", "g*f"),
            ("conjugate(sqrt(u))", "1+I*f", "sqrt(1-I*f)"),
            ("re(log(u))", "1+I*f", "log(1+f**2)/2"),
            ("im(log(u))", "1+I*f", "atan(f)"),
            ("abs(sqrt(u))", "1+I*f", "(1+f**2)**(1/4)"),
            ("log(u) + log(conjugate(u))", "1+I*f", "log(1+f**2)"),
        )
    ),
)
"""Identities of branches, each with the whole range on which it holds."""

WITHIN_UNIT = ("tanh({0})", "({0})/sqrt(1 + ({0})**2)", "sin({0})/2", "1/(2 + ({0})**2)")
ABOVE_ONE = ("1 + exp({0})", "2 + ({0})**2", "1 + 1/(1+({0})**2)", "2*cosh({0})")
POSITIVE = ("exp({0})", "1 + ({0})**2", "cosh({0})", "sech({0})", "2 + sin({0})", "1/cosh({0})**2")


def composed(draw: random.Random) -> TextStatement | None:
    """An entry of `COMPOSED`, within its range or over its end."""
    made = Draft(draw)
    entry = draw.choice(COMPOSED)
    if "g" in entry.outer + entry.inner:
        made.letter(draw.choice(("g>0", "g:1:3", "g>0") if "1/g" in entry.inner else ("g", "g>0")))
    made.letter("t")
    over = draw.random() < 0.3 and (entry.low is not None or entry.high is not None)
    f = _beyond(made, entry) if over else _within(made, entry)
    inner, value = put(read(entry.inner), {"f": f}), put(read(entry.value), {"f": f})
    outer = put(read(entry.outer, ("u",)), {"f": f})
    kind = draw.random()
    slope = next((v for v in "xt" if v in f.names() and v in made.letters), "")
    if kind < 0.2 and slope and "abs" not in entry.value:
        made.equations = [Tree("diff", (outer,), slope) - derivative(value, slope)]
    elif kind < 0.4 and slope:
        steps = Tree("jet", value=("u", slope, None)) - derivative(inner, slope)
        made.equations = [outer - value + made.number() * steps]
    else:
        made.equations = [outer - value]
    if "abs" in str(inner) or "sign" in str(inner):
        return None
    made.solutions = {"u": inner}
    return made.statement("compositions: branch", falsehood=0.3)


def _within(made: Draft, entry: Composed) -> Tree:
    """A formula whose values are in the entry's range."""
    draw, low, high = made.draw, entry.low, entry.high
    if draw.random() < 0.35:
        made.letters["x"] = Letter("x", low, high)
        if low == 0 and high is None and draw.random() < 0.5:
            return made.letter("a>0") * name("x")
        return name("x")
    made.letter("x")
    if low == 0 and high is None and draw.random() < 0.2:
        made.letter("a>0")
        return stay_under(made, "a") * draw.choice((read("exp(x)"), read("1 + x**2")))
    place = {"Z": random_phase(made, "xt", random_parameters(made, 1))}
    if low is None:
        return place["Z"] if draw.random() < 0.7 else random_formula(made, "xt", [])
    forms = WITHIN_UNIT if high is not None else ABOVE_ONE if low == 1 else POSITIVE
    return put(read(draw.choice(forms).format("Z")), place)


def _beyond(made: Draft, entry: Composed) -> Tree:
    """x on a range that goes over an end, by much or by very little."""
    draw = made.draw
    width = Fraction(1, 10 ** draw.choice((0, 1, 12, 30)))
    low, high = entry.low, entry.high
    if low is not None and (high is None or draw.random() < 0.5):
        place = low - width / 3
        low -= width
    else:
        assert high is not None
        place = high + width / 3
        high += width
    made.letters["x"] = Letter("x", low, high)
    made.counterexample = {"x": place}
    return name("x")


OUTER = (
    "sin(u)", "exp(u)", "cos(2*u)", "sinh(u)", "u**3", "1/(1+u**2)", "log(2+u**2)", "tanh(u)",
    "sqrt(1+u**2)", "exp(-u**2)", "u*sin(u)", "exp(u)*u", "cosh(u)", "atan(u)", "sin(u)**2",
)  # fmt: skip


def of_unknown(draw: random.Random) -> TextStatement | None:
    """A random function of the unknown in an equation with a source."""
    made = Draft(draw)
    for letter in "xt":
        made.letter(letter + draw.choice(("", "", ">0")))
    u = random_formula(made, "xt", random_parameters(made, 1))
    outer = read(draw.choice(OUTER), ("u",))
    steps = draw.choice(("x", "t", "xx", "xt"))
    left = Tree("jet", value=("u", steps, None)) + made.number() * outer
    slope = u
    for letter in steps:
        slope = derivative(slope, letter)
    made.equations = [left - slope - left.args[1].args[0] * _at(outer, u)]
    made.solutions = {"u": u}
    return made.statement("compositions: function of u")


def _at(tree: Tree, u: Tree) -> Tree:
    return mapped(tree, lambda node: u if node.head == "jet" else None)


NOTHING = (
    ("sin({0})**2 + cos({0})**2", "1"),
    ("cosh({0})**2", "1 + sinh({0})**2"),
    ("tanh({0})*cosh({0})", "sinh({0})"),
    ("exp({0})*exp(-({0}))", "1"),
    ("sin(2*({0}))", "2*sin({0})*cos({0})"),
    ("(({0}) + 1)**2", "({0})**2 + 2*({0}) + 1"),
    ("log(exp({0}))", "{0}"),
    ("sqrt(1 + sinh({0})**2)", "cosh({0})"),
    ("jacobi_sn({0}, 1/3)**2", "1 - jacobi_cn({0}, 1/3)**2"),
    ("(1 + I*({0}))*conjugate(1 + I*({0}))", "1 + ({0})**2"),
)
"""Pairs of formulas with the difference 0."""

UNDEFINED = (
    "1/({0})", "log({0})", "({0})/({0})", "x + 1/({0})**2", "exp(1/({0}))", "atan(1/({0}))",
    "({0})**(-1/2)", "x*({0})/({0})", "coth({0})", "1/sinh({0})",
)  # fmt: skip


def nowhere_defined(draw: random.Random) -> TextStatement | None:
    """A formula that is 1/0 or log(0) in disguise, in an equation that it would seem to solve."""
    made = Draft(draw)
    for letter in "xt":
        made.letter(letter)
    place = random_phase(made, "xt", random_parameters(made, 1))
    left, right = (f"({put(read(t.format('Z')), {'Z': place})})" for t in draw.choice(NOTHING))
    solution = read(draw.choice(UNDEFINED).format(f"{left} - {right}"))
    equations = ("u - ({0})", "u_t - u_t", "u/u - 1", "u_x - u_x + u*0", "diff(u - u, x)*x + u - u")
    text = draw.choice(equations).format(solution)
    made.equations = [read(text, ("u",))]
    made.solutions = {"u": solution}
    found = made._written("compositions: nowhere defined", Truth.TRUE)
    return replace(found, truth=Truth.VOID)


MAKERS = ((known_composition, 4), (composed, 8), (of_unknown, 3), (nowhere_defined, 1))
"""The kinds of compositions, each with its share."""

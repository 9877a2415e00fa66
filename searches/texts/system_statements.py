"""Systems: several unknowns and equations in one to three space variables."""

from __future__ import annotations

import random

from searches.texts.drafts import (
    Draft,
    Known,
    random_formula,
    random_parameters,
    transformed,
    with_jets,
)
from searches.texts.text_statement import TextStatement
from searches.texts.trees import (
    Tree,
    as_tree,
    call,
    derivative,
    mapped,
    name,
    put,
    read,
    total,
)

KNOWN = (
    Known(
        "u_x - v_y ;; u_y + v_x", "u = exp(k*x)*cos(k*y) ;; v = exp(k*x)*sin(k*y)", "x y k", 2
    ),
    Known("u_x - v_y ;; u_y + v_x", "u = x**2 - y**2 + a*x ;; v = 2*x*y + a*y", "x y a"),
    Known("u_x - v_y ;; u_y + v_x", "u = x/(x**2+y**2) ;; v = -y/(x**2+y**2)", "x y"),
    Known("u_x - v_y ;; u_y + v_x", "u = log(x**2+y**2)/2 ;; v = atan(y/x)", "x>0 y"),
    Known("u_x - v_y ;; u_y + v_x", "u = sin(x)*cosh(y) ;; v = cos(x)*sinh(y)", "x y", 2),
    Known("u_t - u_xx ;; u*v + 2*u_x", "u = 1+exp(k*x+k**2*t) ;; v = -2*k*exp(k*x+k**2*t)/(1+"
          "exp(k*x+k**2*t))", "x t k"),
    Known("u_t - k*v ;; v_t + k*u", "u = a*sin(k*t+x) ;; v = a*cos(k*t+x)", "x t a k", 2),
    Known("u_t + u*v ;; v_t - u*v", "u = k/(1+exp(k*(t-x))) ;; v = k - k/(1+exp(k*(t-x)))",
          "x t k", 1),
    Known(
        "u_t + u*u_x + v_x ;; v_t + diff(u*v, x)",
        "u = 2*(x/t + a)/3 ;; v = (2*a - x/t)**2/9",
        "x t>0 a",
        2,
    ),
    Known(
        "u_t + v_x ;; v_t + diff(u + 3*u**2 + u_xx, x)",
        "u = 2*k**2*sech(k*(x - sqrt(1 + 4*k**2)*t))**2 ;; "
        "v = 2*k**2*sqrt(1 + 4*k**2)*sech(k*(x - sqrt(1 + 4*k**2)*t))**2",
        "x t k",
        0.5,
    ),
    Known(
        "u_t + 6*u*u_x + u_xxx + 3*v_y ;; v_x - u_y",
        "u = 2*k**2*sech(k*x + l*y - (4*k**3 + 3*l**2/k)*t)**2 ;; "
        "v = 2*k*l*sech(k*x + l*y - (4*k**3 + 3*l**2/k)*t)**2",
        "x y t k>0 l",
        1,
    ),
    Known(
        "u - v**2 - v_x ;; v_t - 6*v**2*v_x + v_xxx",
        "u = k**2*tanh(k*(x+2*k**2*t))**2 + k**2*sech(k*(x+2*k**2*t))**2 ;; "
        "v = k*tanh(k*(x+2*k**2*t))",
        "x t k",
        1,
    ),
    Known(
        "u_x + v_y + w_z ;; w_y - v_z - u ;; u_z - w_x - v ;; v_x - u_y - w",
        "u = a*sin(z) + c*cos(y) ;; v = b*sin(x) + a*cos(z) ;; w = c*sin(y) + b*cos(x)",
        "x y z a b c",
        2,
    ),
    Known(
        "u_x + v_y ;; u_t + u*u_x + v*u_y + p_x - r*(u_xx+u_yy) ;; "
        "v_t + u*v_x + v*v_y + p_y - r*(v_xx+v_yy)",
        "u = cos(x)*sin(y)*exp(-2*r*t) ;; v = -sin(x)*cos(y)*exp(-2*r*t) ;; "
        "p = -(cos(2*x)+cos(2*y))*exp(-4*r*t)/4",
        "x y t r>0",
        1,
    ),
    Known(
        "u_t - v*w ;; v_t + u*w ;; w_t + m*u*v",
        "u = jacobi_sn(t+x, m) ;; v = jacobi_cn(t+x, m) ;; w = jacobi_dn(t+x, m)",
        "x t m:0:1",
        1,
    ),
    Known("u_x - v ;; v_x - 2*m*u**3 + (1+m)*u",
          "u = jacobi_sn(x, m) ;; v = jacobi_cn(x, m)*jacobi_dn(x, m)", "x m:0:1"),
    Known("u_x + u*v ;; v_x - u**2", "u = k*sech(k*x) ;; v = k*tanh(k*x)", "x k", 2),
    Known("u_x - u*v ;; v_x - v**2", "u = a/(b-x) ;; v = 1/(b-x)", "x a b"),
    Known("u_xx + u_yy + u_zz - v ;; v - 6", "u = x**2+y**2+z**2 + a*x*y ;; v = 6", "x y z a"),
    Known("u_t - u_xx - u_yy - u_zz ;; v - u_x", "u = exp(-3*k**2*t)*sin(k*x)*sin(k*y)*sin(k*z) ;; "
          "v = k*exp(-3*k**2*t)*cos(k*x)*sin(k*y)*sin(k*z)", "x y z t k"),
    Known("u_tt - u_xx - u_yy - u_zz ;; v_t - u", "u = cos(a*x+b*y+c*z-sqrt(a**2+b**2+c**2)*t) ;; "
          "v = -sin(a*x+b*y+c*z-sqrt(a**2+b**2+c**2)*t)/sqrt(a**2+b**2+c**2)",
          "x y z t a>0 b c", 1),
    Known("u_x - sqrt(v) ;; v_x - 2*u*u_x", "u = sinh(x) ;; v = cosh(x)**2", "x", 1),
    Known("u_x**2 + v_x**2 - 1 ;; u*v_x - v*u_x - 1", "u = cos(x+t) ;; v = sin(x+t)", "x t", 1),
    Known("u_t + v_x ;; v_t + u_x", "u = sech(x-t)**2 + tanh(x+t) ;; v = sech(x-t)**2 - tanh(x+t)",
          "x t", 1),
)  # fmt: skip

WEIGHTS = [known.weight for known in KNOWN]


def known_system(draw: random.Random) -> TextStatement | None:
    """One of `KNOWN` under symmetries."""
    return draw.choices(KNOWN, WEIGHTS)[0].draft(draw).statement("systems: known")


TERMS = (
    "{u}_{s}", "{u}_{s}", "{u}", "{u}*{v}_{s}", "{u}*{v}", "{u}**2", "{v}_{s}{s}", "{c}*{v}_{s}",
    "diff({u}*{v}, {s})", "{u}_{s}*{v}_{r}", "diff({u}_{r}, {s})", "x*{u}_{s}", "{u}_{s}**2",
)  # fmt: skip


def with_sources(draw: random.Random) -> TextStatement | None:
    """Random formulas in random equations, each with the source that makes it hold."""
    made = Draft(draw)
    variables = draw.choice(("xt", "xt", "xyt", "xy", "xyz", "xyzt"))
    for letter in variables:
        made.letter(letter + draw.choice(("", "", "", ">0")))
    parameters = random_parameters(made)
    unknowns = draw.sample(("u", "v", "w", "p", "psi"), draw.choice((2, 2, 2, 3)))
    within = "".join(draw.sample(variables, min(2, len(variables))))
    made.solutions = {u: random_formula(made, within, parameters) for u in unknowns}
    for place in range(draw.choice((1, 2, 2))):
        mine, other = unknowns[place], draw.choice(unknowns)
        terms = []
        for _ in range(draw.choice((1, 2))):
            text = draw.choice(TERMS).format(
                u=mine,
                v=other,
                s=draw.choice(variables),
                r=draw.choice(variables),
                c=made.constant(parameters),
            )
            terms.append(made.constant(parameters) * read(text, tuple(unknowns)))
        missing = [u for u in unknowns[len(made.equations) + 1 :] if place or len(unknowns) < 3]
        terms += [Tree("jet", value=(u, "", None)) for u in missing]
        left = total(*terms)
        made.equations.append(left - filled(left, made.solutions))
    used = {node.jet[0] for e in made.equations for node in e.nodes() if node.head == "jet"}
    made.solutions = {u: f for u, f in made.solutions.items() if u in used}
    return made.statement("systems: source")


def filled(tree: Tree, solutions: dict[str, Tree]) -> Tree:
    """The tree with the formulas in the places of the unknowns, derivatives worked out."""

    def image(node: Tree) -> Tree | None:
        if node.head == "jet":
            unknown, steps, shift = node.jet
            found = solutions[unknown]
            if shift:
                found = put(found, {"n": name("n") + shift})
            for letter in steps:
                found = derivative(found, letter)
            return found
        if node.head == "diff":
            found = filled(node.args[0], solutions)
            for letter in str(node.value):
                found = derivative(found, letter)
            return found
        return None

    return mapped(tree, image)


def travelling_pair(draw: random.Random) -> TextStatement | None:
    """The wave equation as a system, two random waves, in mixed unknowns."""
    made = Draft(draw)
    for letter in ("x", "t", draw.choice(("c", "c>0"))):
        made.letter(letter)
    waves = [put(random_formula(made, "x", []), {"x": read(p)}) for p in ("x - c*t", "x + c*t")]
    made.solutions = {"u": waves[0] + waves[1], "v": waves[0] - waves[1]}
    made.equations = [read("u_t + c*v_x", ("u", "v")), read("v_t + c*u_x", ("u", "v"))]
    if draw.random() < 0.4:
        made.solutions["v"] = name("c") * made.solutions["v"]
        images = {"v": {"v": as_tree(1) / name("c")}}
        made.equations = [with_jets(equation, images) for equation in made.equations]
    return transformed(made).statement("systems: waves")


def eliminated(draw: random.Random) -> TextStatement | None:
    """v as the derivative, the logarithm or the exponential of a random u."""
    made = Draft(draw)
    for letter in "xt":
        made.letter(letter)
    u = random_formula(made, "xt", random_parameters(made, 1))
    kind = draw.randrange(3)
    if kind == 0:
        made.solutions = {"u": u, "v": derivative(u, "x")}
        texts = ("v - u_x", "v_t - u_xt")
    elif kind == 1:
        made.solutions = {"u": call("exp", u), "v": u}
        texts = ("u_x - u*v_x", "u_t - u*v_t")
    else:
        made.solutions = {"u": call("log", u**2 + 1), "v": u}
        texts = ("(1+v**2)*u_x - 2*v*v_x", draw.choice(("exp(u) - v**2 - 1", "u_t*exp(u)-2*v*v_t")))
    made.equations = [read(text, ("u", "v")) for text in texts]
    return made.statement("systems: eliminated")


MAKERS = ((known_system, 5), (with_sources, 5), (travelling_pair, 2), (eliminated, 2))
"""The kinds of systems, each with its share."""

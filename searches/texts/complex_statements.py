"""Complex fields: the nonlinear Schroedinger family, conjugates, moduli, real parts."""

from __future__ import annotations

import random

from searches.texts.drafts import (
    Draft,
    Known,
    random_formula,
    random_parameters,
    random_phase,
)
from searches.texts.system_statements import filled
from searches.texts.text_statement import TextStatement
from searches.texts.trees import (
    Tree,
    call,
    derivative,
    mapped,
    name,
    put,
    read,
    total,
)

MODULUS = ("abs(u)**2*u", "u**2*conjugate(u)", "u*conjugate(u)*u", "(re(u)**2 + im(u)**2)*u")
"""The same term in four guises."""

NLS = "I*u_t + u_xx + 2*abs(u)**2*u"
DEFOCUSING = "I*u_t + u_xx - 2*abs(u)**2*u"

KNOWN = (
    Known(NLS, "u = a*sech(a*x)*exp(I*a**2*t)", "x t a", 3),
    Known(
        NLS,
        "u = a*sech(a*(x - 2*k*t))*exp(I*(k*x + (a**2 - k**2)*t))",
        "x t a k",
        1,
    ),
    Known(NLS, "u = a*exp(I*(k*x + (2*a**2 - k**2)*t))", "x t a k", 4),
    Known(NLS, "u = (1 - 4*(1+4*I*t)/(1+4*x**2+16*t**2))*exp(2*I*t)", "x t", 1),
    Known(NLS, "u = k*jacobi_dn(k*x, m)*exp(I*(2-m)*k**2*t)", "x t k m:0:1", 1),
    Known(NLS, "u = sqrt(m)*jacobi_cn(x, m)*exp(I*(2*m-1)*t)", "x t m:0:1", 1),
    Known(DEFOCUSING, "u = a*tanh(a*x)*exp(-2*I*a**2*t)", "x t a", 3),
    Known(DEFOCUSING, "u = a*exp(I*(k*x - (2*a**2 + k**2)*t))", "x t a k", 2),
    Known("I*u_t + u_xx", "u = exp(I*x**2/(4*t))/sqrt(t)", "x t>0", 2),
    Known("I*u_t + u_xx", "u = exp(I*k*x - I*k**2*t)*b", "x t k b", 2),
    Known("I*u_t + u_xx - x**2*u", "u = exp(-x**2/2 - I*t)", "x t", 2),
    Known("I*u_t + u_xx - x**2*u", "u = x*exp(-x**2/2 - 3*I*t)", "x t", 1),
    Known("I*u_t + u_xx + u_yy", "u = exp(I*(k*x + b*y - (k**2+b**2)*t))", "x y t k b", 2),
    Known("I*u_t + u_xx + u_yy + 2*abs(u)**2*u", "u = a*exp(I*(x+y+(2*a**2-2)*t))", "x y t a", 2),
    Known(
        "u_t + 6*abs(u)**2*u_x + u_xxx",
        "u = a*exp(I*(k*x + (k**3 - 6*a**2*k)*t))",
        "x t a k",
        2,
    ),
    Known("u_t + 6*abs(u)**2*u_x + u_xxx", "u = a*sech(a*x - a**3*t)*exp(I*b)", "x t a b", 1),
    Known(
        "I*u_t + u_xx + 2*(abs(u)**2 + abs(v)**2)*u ;; I*v_t + v_xx + 2*(abs(u)**2 + abs(v)**2)*v",
        "u = 3*a*sech(5*a*x)*exp(25*I*a**2*t) ;; v = 4*I*a*sech(5*a*x)*exp(25*I*a**2*t)",
        "x t a",
        1,
    ),
    Known(
        "I*u_t + u_xx + 2*(abs(u)**2 + abs(v)**2)*u ;; I*v_t + v_xx + 2*(abs(u)**2 + abs(v)**2)*v",
        "u = a*exp(2*I*(a**2+b**2)*t) ;; v = I*b*exp(2*I*(a**2+b**2)*t)",
        "x t a b",
        2,
    ),
    Known(
        "u_t - (1+I*b)*u_xx - u + (1+I*c)*abs(u)**2*u",
        "u = exp(-I*c*t)",
        "x t b c",
        2,
    ),
    Known(
        "I*u_t + u_xx + I*diff(abs(u)**2*u, x)",
        "u = a*exp(I*(k*x - (k**2 + a**2*k)*t))",
        "x t a k",
        2,
    ),
    Known("diff(abs(u)**2, t) + diff(2*im(conjugate(u)*u_x), x)",
          "u = exp(I*(k*x - k**2*t)) + b*exp(I*(2*x - 4*t))", "x t k b", 1),
    Known("diff(abs(u)**2, x)", "u = (1 + I*x)/(1 - I*x)", "x", 1),
    Known(
        "I*u_t + u_xx - v*u ;; v_tt - v_xx - diff(abs(u)**2, x, x)",
        "u = k*sqrt(2*(1 - c**2))*sech(k*(x - c*t))*exp(I*(c*x/2 + (k**2 - c**2/4)*t)) ;; "
        "v = -2*k**2*sech(k*(x - c*t))**2",
        "x t k>0 c:-1:1",
        0.5,
    ),
    Known(
        "I*u_t + u_xx - v*u ;; v_t - 2*diff(abs(u)**2, x)",
        "u = k*sqrt(c)*sech(k*(x - c*t))*exp(I*(c*x/2 + (k**2 - c**2/4)*t)) ;; "
        "v = -2*k**2*sech(k*(x - c*t))**2",
        "x t k>0 c>0",
        0.5,
    ),
    Known("I*u_t + u_xx + I*diff(abs(u)**2, x)*u", "u = a*exp(I*(k*x - k**2*t))", "x t a k", 1),
    Known("u_x*conjugate(u) + u*conjugate(u_x) - diff(abs(u)**2, x)",
          "u = (x + I*t)*exp(I*a*x)", "x t a", 1),
    Known("abs(u) - 1", "u = (a + I*x)/(a - I*x)", "x a", 1),
    Known("conjugate(u)*u - 1", "u = exp(I*x)*(2+I*sin(x))/(2-I*sin(x))", "x", 1),
    Known("u_x - I*abs(u)*u", "u = a*exp(I*a*x)", "x a>0", 2),
    Known("u_x - abs(u)/x*I", "u = I*x", "x>0", 1),
    Known("re(u)**2 + im(u)**2 - exp(2*x)", "u = exp(x + I*t)", "x t", 2),
)  # fmt: skip

WEIGHTS = [known.weight for known in KNOWN]


def known_field(draw: random.Random) -> TextStatement | None:
    """One of `KNOWN` under symmetries, the modulus in one of its guises."""
    known = draw.choices(KNOWN, WEIGHTS)[0]
    made = known.draft(draw)
    guise = draw.choice(MODULUS)

    def image(node: Tree) -> Tree | None:
        square = node.head == "**" and node.args[0].head == "abs"
        if not square:
            return None
        inner = node.args[0].args[0]
        if guise.startswith("abs"):
            return node
        if "re" in guise:
            return call("re", inner) ** 2 + call("im", inner) ** 2
        return inner * call("conjugate", inner)

    made.equations = [mapped(equation, image) for equation in made.equations]
    return made.statement("complex: known")


def _of_phase(p: Tree, s: Tree) -> Tree:
    return p * call("exp", name("I") * s)


PARTS = (
    ("re(u)", "p*cos(s)"),
    ("im(u)", "p*sin(s)"),
    ("conjugate(u)", "p*exp(-I*s)"),
    ("abs(u)**2", "p**2"),
    ("u*conjugate(u)", "p**2"),
    ("diff(conjugate(u), x)", "P*exp(-I*s) - I*p*S*exp(-I*s)"),
    ("conjugate(u_x)", "P*exp(-I*s) - I*p*S*exp(-I*s)"),
    ("im(conjugate(u)*u_x)", "p**2*S"),
    ("re(conjugate(u)*u_x)", "p*P"),
    ("diff(re(u), x)", "P*cos(s) - p*S*sin(s)"),
    ("im(u_x)", "P*sin(s) + p*S*cos(s)"),
    ("diff(abs(u)**2, x)", "2*p*P"),
    ("abs(u_x)**2", "P**2 + p**2*S**2"),
    ("u*conjugate(u_x) - u_x*conjugate(u)", "-2*I*p**2*S"),
    ("abs(u - conjugate(u))**2", "4*p**2*sin(s)**2"),
    ("u**2*conjugate(u)", "p**3*exp(I*s)"),
    ("re(u**2)", "p**2*cos(2*s)"),
    ("im(I*u)", "p*cos(s)"),
    ("diff(abs(u)**2, x, x)", "2*P**2 + 2*p*Q"),
    ("diff(u*conjugate(u), x, x)", "2*P**2 + 2*p*Q"),
    ("diff(abs(u)**2, t)", "2*p*R"),
    ("diff(abs(u)**4, x)", "4*p**3*P"),
    ("abs(u**2)", "p**2"),
    ("abs(u*u_x)**2", "p**2*(P**2 + p**2*S**2)"),
    ("diff(conjugate(u)**2*u, x)", "3*p**2*P*exp(-I*s) - I*p**3*S*exp(-I*s)"),
    ("diff(abs(u)**2*u, x)", "3*p**2*P*exp(I*s) + I*p**3*S*exp(I*s)"),
    ("diff(re(u), x, x)", "(Q - p*S**2)*cos(s) - 2*P*S*sin(s)"),
    ("re(u_xx)", "(Q - p*S**2)*cos(s) - 2*P*S*sin(s)"),
    ("conjugate(u_t)*u_x", "(R - I*p*T)*(P + I*p*S)"),
    ("abs(u_t)**2", "R**2 + p**2*T**2"),
)
"""Parts of u = p*exp(I*s) with real p and s, s linear; P, S are derivatives by x, R, T by t, and
Q is the second one of p by x."""

POSITIVE_PARTS = (
    ("abs(u)", "p"),
    ("u/abs(u)", "exp(I*s)"),
    ("sign(u)", "exp(I*s)"),
    ("diff(abs(u), x)", "P"),
    ("sqrt(u*conjugate(u))", "p"),
    ("log(abs(u))", "log(p)"),
    ("re(log(u))", "log(p)"),
    ("abs(u)**3", "p**3"),
    ("diff(abs(u), x, x)", "Q"),
    ("diff(log(abs(u)), x)", "P/p"),
    ("diff(log(u), x)", "P/p + I*S"),
    ("u_x/u", "P/p + I*S"),
    ("diff(u/conjugate(u), x)", "2*I*S*exp(2*I*s)"),
    ("diff(sign(u), t)", "I*T*exp(I*s)"),
    ("abs(1/u)", "1/p"),
    ("sqrt(abs(u))", "sqrt(p)"),
    ("abs(sqrt(u))", "sqrt(p)"),
)
"""Those that hold for a positive p."""

POSITIVE = (
    "exp({0})",
    "1 + ({0})**2",
    "cosh({0})",
    "sech({0})",
    "1/(2 + ({0})**2)",
    "2 + sin({0})",
)


def polar(draw: random.Random) -> TextStatement | None:
    """One or two parts of p*exp(I*s) and their values."""
    made = Draft(draw)
    for letter in "xt":
        made.letter(letter)
    parameters = random_parameters(made, 1)
    positive = draw.random() < 0.35
    if positive:
        place = {"Z": random_phase(made, "xt", parameters)}
        p = put(read(draw.choice(POSITIVE).format("Z")), place)
    else:
        p = random_formula(made, "xt", parameters)
    s = random_phase(made, "xt", parameters)
    known = {"p": p, "s": s, "P": derivative(p, "x"), "S": derivative(s, "x")}
    known |= {"R": derivative(p, "t"), "T": derivative(s, "t"), "Q": derivative(known["P"], "x")}
    table = (*PARTS, *POSITIVE_PARTS, *POSITIVE_PARTS) if positive else PARTS
    terms = []
    for _ in range(draw.choice((1, 1, 2))):
        left, right = draw.choice(table)
        terms.append(made.number() * (read(left, ("u",)) - put(read(right), known)))
    made.equations = [total(*terms)]
    made.solutions = {"u": _of_phase(p, s)}
    return made.statement("complex: polar")


TERMS = (
    "I*u_t", "u_x", "u_xx", "conjugate(u)", "conjugate(u_x)", "u*conjugate(u)", "abs(u)**2*u",
    "re(u)", "im(u_t)", "diff(conjugate(u), t)", "u**2", "I*u*conjugate(u_x)", "re(u*u_x)",
)  # fmt: skip


def with_source(draw: random.Random) -> TextStatement | None:
    """f + I*g in a random equation, with its source."""
    made = Draft(draw)
    for letter in "xt":
        made.letter(letter)
    parameters = random_parameters(made, 1)
    f, g = (random_formula(made, "xt", parameters) for _ in range(2))
    terms = [read(text, ("u",)) for text in draw.sample(TERMS, draw.choice((1, 2)))]
    left = terms[0] if len(terms) == 1 else terms[0] + made.constant(parameters) * terms[1]
    made.solutions = {"u": f + name("I") * g}
    made.equations = [left - _parted(left, f, g)]
    return made.statement("complex: source")


def _parted(tree: Tree, f: Tree, g: Tree) -> Tree:
    """The tree with f + I*g for u; conjugates, moduli, real and imaginary parts by f and g."""
    one = {"u": f}, {"u": g}

    def image(node: Tree) -> Tree | None:
        if node.head == "**" and node.args[0].head == "abs":
            return f**2 + g**2
        if node.head == "jet":
            real, imaginary = (filled(node, own) for own in one)
            return real + name("I") * imaginary
        if node.head == "diff" or node.head in ("conjugate", "re", "im"):
            return _part(node)
        return None

    def _part(node: Tree) -> Tree | None:
        inner = node.args[0]
        if node.head == "diff" and inner.head == "conjugate":
            jet = Tree("jet", value=("u", str(node.value), None))
            return _part(call("conjugate", jet))
        if inner.head == "*":
            product = f * f - g * g
            slope = {"re": product, "im": f * g * 2}[node.head]
            return derivative(slope, "x") / 2
        real, imaginary = (filled(inner, own) for own in one)
        if node.head == "conjugate":
            return real - name("I") * imaginary
        return real if node.head == "re" else imaginary

    return mapped(tree, image)


MAKERS = ((known_field, 6), (polar, 4), (with_source, 4))
"""The kinds of complex fields, each with its share."""

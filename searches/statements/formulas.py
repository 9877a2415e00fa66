"""Random formulas in the functions that the prover supports, and the same in other words.

Each identity by which a formula is rewritten holds wherever both of its sides are smooth; those of
roots and logarithms are used only where SymPy's assumptions give the signs that they need.
"""

from __future__ import annotations

import random
from collections.abc import Callable

import sympy as sp

from longwave.solutions.functions import jacobi
from longwave.verify.subexpressions import distinct_nodes, outer_nodes, replaced
from searches.statements.random_statement import Setting

SMALL = (-3, -2, -1, 1, 2, 3)


def number(setting: Setting) -> sp.Rational:
    """A small rational number other than 0."""
    return sp.Rational(setting.draw.choice(SMALL), setting.draw.choice((1, 1, 1, 2, 3)))


def constant(setting: Setting) -> sp.Expr:
    """A number or a parameter, or their product."""
    draw = setting.draw
    if setting.parameters and draw.random() < 0.6:
        power = draw.choice((1, 1, 1, 2, -1))
        return draw.choice((sp.S.One, number(setting))) * draw.choice(setting.parameters) ** power
    return number(setting)


def phase(setting: Setting) -> sp.Expr:
    """A linear function of some variables."""
    draw = setting.draw
    chosen = draw.sample(setting.variables, draw.randint(1, len(setting.variables)))
    total = sp.Add(*(constant(setting) * variable for variable in chosen))
    return total + (constant(setting) if draw.random() < 0.2 else 0)


def polynomial(setting: Setting) -> sp.Expr:
    """A polynomial of a few terms."""
    draw = setting.draw
    total = sp.S.Zero
    for _ in range(draw.randint(1, 3)):
        chosen = [draw.choice(setting.variables) for _ in range(draw.randint(0, 2))]
        total += constant(setting) * sp.Mul(*chosen)
    return total


def positive(setting: Setting) -> sp.Expr:
    """A formula that is positive everywhere."""
    draw = setting.draw
    kind = draw.random()
    signed = setting.of_sign(1)
    if kind < 0.3 and signed:
        return draw.choice(signed)
    if kind < 0.4 and signed:
        return draw.choice(signed) * (1 + phase(setting) ** 2)
    if kind < 0.5:
        return sp.exp(phase(setting))
    return sp.Rational(draw.randint(1, 4)) + phase(setting) ** 2


def argument(setting: Setting, depth: int) -> sp.Expr:
    """What stands in a function: mostly a phase."""
    kind = setting.draw.random()
    if kind < 0.75:
        return phase(setting)
    return polynomial(setting) if kind < 0.9 or depth <= 0 else formula(setting, depth - 1)


ENTIRE = (sp.exp, sp.sin, sp.cos, sp.sinh, sp.cosh, sp.tanh, sp.sech, sp.atan)
BOUNDED = (sp.sin, sp.cos, sp.atan)
SINGULAR = (sp.tan, sp.cot, sp.sec, sp.csc, sp.coth, sp.csch)
ELLIPTIC = (jacobi.jacobi_sn, jacobi.jacobi_cn, jacobi.jacobi_dn)
SECOND = (jacobi.jacobi_zeta, jacobi.jacobi_epsilon)


def _entire(setting: Setting, depth: int) -> sp.Expr:
    """No growing function of another: no precision would do to check its values."""
    chosen = setting.draw.choice(ENTIRE)
    return chosen(argument(setting, depth if chosen in BOUNDED else 0))


def _root(setting: Setting, depth: int) -> sp.Expr:
    exponent = sp.Rational(setting.draw.choice((1, 1, 1, -1, 3, 2)), 2)
    if exponent.is_Integer:
        exponent = sp.Rational(setting.draw.choice((1, 2, -1)), 3)
    return positive(setting) ** exponent


def elliptic_phase(setting: Setting) -> sp.Expr:
    """A phase without a constant; one for all Jacobi functions keeps a statement small."""
    draw = setting.draw
    return sp.Add(*(sp.Rational(draw.choice(SMALL)) * v for v in setting.variables[:2]))


def _modulus(setting: Setting, depth: int) -> sp.Expr:
    sign = setting.draw.choice((1, -1))
    return setting.draw.choice((sp.Abs, sp.Abs, sp.sign))(sign * positive(setting))


def _elliptic(setting: Setting, depth: int) -> sp.Expr:
    m = setting.elliptic_parameter()
    return setting.draw.choice(ELLIPTIC)(elliptic_phase(setting), m)


def _second(setting: Setting, depth: int) -> sp.Expr:
    m = setting.elliptic_parameter()
    return setting.draw.choice(SECOND)(setting.variables[0], m)


PIECES: tuple[tuple[Callable[[Setting, int], sp.Expr], float], ...] = (
    (lambda setting, _: polynomial(setting), 4),
    (lambda setting, _: polynomial(setting) / (1 + phase(setting) ** 2), 2),
    (_entire, 8),
    (lambda setting, depth: setting.draw.choice(SINGULAR)(argument(setting, depth)), 1),
    (_root, 3),
    (lambda setting, _: sp.log(positive(setting)), 1.5),
    (_modulus, 0.7),
    (_elliptic, 1),
    (_second, 0.3),
)


def piece(setting: Setting, depth: int) -> sp.Expr:
    """One function, root or polynomial."""
    makers, weights = zip(*PIECES, strict=True)
    (maker,) = setting.draw.choices(makers, weights)
    return maker(setting, depth)


def formula(setting: Setting, size: int = 2) -> sp.Expr:
    """A sum, product or quotient of pieces that depends on a variable.

    ``size`` is the number of pieces.
    """
    for _ in range(20):
        found = piece(setting, size - 1)
        for _ in range(size - 1):
            found = _joined(setting, found, piece(setting, size - 2))
        found = constant(setting) * found
        if found.free_symbols & set(setting.variables) and not found.has(sp.nan, sp.zoo, sp.oo):
            return found
    return setting.variables[0]


def _joined(setting: Setting, left: sp.Expr, right: sp.Expr) -> sp.Expr:
    kind = setting.draw.random()
    if kind < 0.45:
        return left + constant(setting) * right
    if kind < 0.85 or right == 0:
        return left * right
    return left / (1 + positive(setting)) if kind < 0.95 else left / right


Identity = Callable[[sp.Expr, random.Random], sp.Expr]

LONGEST = 40
"""Operations of a sum that is multiplied out."""

SHORT = 8
"""Operations of what stands in a logarithm or under a root that is written out longer."""

WITHIN = 0.1
"""How often an identity may fall into the argument of a function."""


def rewritten(formula: sp.Expr, draw: random.Random, changes: int) -> sp.Expr:
    """``formula`` after up to ``changes`` random identities."""
    for _ in range(changes):
        within = draw.random() < WITHIN
        nodes = distinct_nodes(formula) if within else outer_nodes(formula)
        places = [node for node in nodes if node.func in IDENTITIES]
        if not places:
            continue
        node = draw.choice(places)
        image = draw.choice(IDENTITIES[node.func])(node, draw)
        if image != node:
            changed = replaced(formula, node, image)
            if not changed.has(sp.nan, sp.zoo, sp.oo):
                formula = changed
    return formula


def _split(z: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Two expressions whose sum is ``z``."""
    if z.is_Add:
        return z.args[0], sp.Add(*z.args[1:])
    return 2 * z, -z


def _of_argument(image: Callable[[sp.Expr], sp.Expr]) -> Identity:
    return lambda node, _: image(node.args[0])


def _of_sum(image: Callable[[sp.Expr, sp.Expr], sp.Expr]) -> Identity:
    """An addition theorem, for two parts of the argument."""
    return lambda node, _: image(*_split(node.args[0]))


def _in_exponentials(node: sp.Expr, _: random.Random) -> sp.Expr:
    return node.rewrite(sp.exp)


def _tanh(node: sp.Expr, draw: random.Random) -> sp.Expr:
    z = node.args[0]
    return draw.choice((sp.sinh(z) / sp.cosh(z), 1 - 2 / (1 + sp.exp(2 * z))))


def _exp(node: sp.Expr, draw: random.Random) -> sp.Expr:
    z = node.args[0]
    half = sp.tanh(z / 2)
    return draw.choice((sp.cosh(z) + sp.sinh(z), (1 + half) / (1 - half)))


def _log(node: sp.Expr, _: random.Random) -> sp.Expr:
    z = node.args[0]
    if z.is_Mul and all(factor.is_positive for factor in z.args):
        return sp.Add(*map(sp.log, z.args))
    if z.is_positive and z.count_ops() < SHORT:
        return sp.log(z**2 + z, evaluate=False) - sp.log(1 + z)
    return node


def _square(node: sp.Expr, draw: random.Random) -> sp.Expr:
    """A power: squares of functions, products under roots, powers of sums."""
    base, exponent = node.base, node.exp
    if exponent == 2 and base.func in SQUARES:
        return SQUARES[base.func](base, draw)
    if exponent.is_Integer and 1 < exponent < 4 and base.is_Add and base.count_ops() < LONGEST:
        return sp.expand(node, deep=False)
    if not exponent.is_Integer and base.is_positive:
        return _other_root(node, draw)
    return node


def _other_root(node: sp.Expr, draw: random.Random) -> sp.Expr:
    base, exponent = node.base, node.exp
    if exponent.is_Rational and base.count_ops() < SHORT and draw.random() < 0.5:
        return sp.expand(base * (1 + base) ** 2) ** exponent / (1 + base) ** (2 * exponent)
    return sp.exp(exponent * sp.log(base), evaluate=False)


def _difference_of_squares(node: sp.Expr, draw: random.Random) -> sp.Expr:
    """The other factor is an odd number, which no sum here is minus everywhere."""
    shift = sp.Rational(draw.choice((7, 11, 13)), 17)
    if node.count_ops() > LONGEST or not node.free_symbols:
        return node
    return (node**2 - shift**2) / (node + shift) + shift


def _over_a_sum(node: sp.Expr, _: random.Random) -> sp.Expr:
    squares = [symbol**2 for symbol in sorted(node.free_symbols, key=str) if symbol.is_real]
    if not squares or node.count_ops() > LONGEST:
        return node
    return sp.Add(*(part * (1 + squares[0]) for part in node.args)) / (1 + squares[0])


def _jacobi_sum(node: sp.Expr, _: random.Random) -> sp.Expr:
    z, m = node.args
    a, b = (z / 2, z / 2) if not z.is_Add else (z.args[0], sp.Add(*z.args[1:]))
    sn, cn, dn = jacobi.jacobi_sn, jacobi.jacobi_cn, jacobi.jacobi_dn
    s, c, d = (f(a, m) for f in (sn, cn, dn))
    s2, c2, d2 = (f(b, m) for f in (sn, cn, dn))
    above = {
        sn: s * c2 * d2 + s2 * c * d,
        cn: c * c2 - s * d * s2 * d2,
        dn: d * d2 - m * s * c * s2 * c2,
    }[node.func]
    return above / (1 - m * s**2 * s2**2)


SQUARES: dict[type, Identity] = {
    sp.sin: lambda base, _: (1 - sp.cos(2 * base.args[0])) / 2,
    sp.cos: lambda base, _: 1 - sp.sin(base.args[0]) ** 2,
    sp.tanh: lambda base, _: 1 - sp.sech(base.args[0]) ** 2,
    sp.sech: lambda base, _: 1 - sp.tanh(base.args[0]) ** 2,
    sp.cosh: lambda base, _: 1 + sp.sinh(base.args[0]) ** 2,
    jacobi.jacobi_sn: lambda base, _: 1 - jacobi.jacobi_cn(*base.args) ** 2,
    jacobi.jacobi_cn: lambda base, _: 1 - jacobi.jacobi_sn(*base.args) ** 2,
    jacobi.jacobi_dn: lambda base, _: 1 - base.args[1] * jacobi.jacobi_sn(*base.args) ** 2,
}

IDENTITIES: dict[type, tuple[Identity, ...]] = {
    sp.sin: (
        _in_exponentials,
        _of_argument(lambda z: 2 * sp.sin(z / 2) * sp.cos(z / 2)),
        _of_sum(lambda a, b: sp.sin(a) * sp.cos(b) + sp.cos(a) * sp.sin(b)),
    ),
    sp.cos: (
        _in_exponentials,
        _of_argument(lambda z: 1 - 2 * sp.sin(z / 2) ** 2),
        _of_sum(lambda a, b: sp.cos(a) * sp.cos(b) - sp.sin(a) * sp.sin(b)),
    ),
    sp.tan: (_in_exponentials, _of_argument(lambda z: sp.sin(z) / sp.cos(z))),
    sp.cot: (_in_exponentials,),
    sp.sinh: (
        _in_exponentials,
        _of_sum(lambda a, b: sp.sinh(a) * sp.cosh(b) + sp.cosh(a) * sp.sinh(b)),
    ),
    sp.cosh: (_in_exponentials, _of_argument(lambda z: 1 + 2 * sp.sinh(z / 2) ** 2)),
    sp.tanh: (_in_exponentials, _tanh),
    sp.sech: (_in_exponentials, _of_argument(lambda z: 2 * sp.exp(z) / (1 + sp.exp(2 * z)))),
    sp.coth: (_in_exponentials,),
    sp.exp: (_exp,),
    sp.log: (_log,),
    sp.Pow: (_square,),
    sp.Add: (_difference_of_squares, _over_a_sum),
    sp.Abs: (
        lambda node, _: sp.sqrt(sp.expand(node.args[0] ** 2)) if node.args[0].is_real else node,
    ),
    jacobi.jacobi_sn: (_jacobi_sum,),
    jacobi.jacobi_cn: (_jacobi_sum,),
    jacobi.jacobi_dn: (_jacobi_sum,),
    jacobi.jacobi_zeta: (
        lambda node, _: (
            jacobi.jacobi_epsilon(*node.args)
            - node.args[0] * sp.elliptic_e(node.args[1]) / sp.elliptic_k(node.args[1])
        ),
    ),
}

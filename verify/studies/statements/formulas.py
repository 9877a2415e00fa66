"""Random formulas in the functions that the prover supports."""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from solutions.functions import jacobi

from .setting import Setting

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


def _singular(setting: Setting, depth: int) -> sp.Expr:
    return setting.draw.choice(SINGULAR)(argument(setting, depth))


def _root(setting: Setting, depth: int) -> sp.Expr:
    exponent = sp.Rational(setting.draw.choice((1, 1, 1, -1, 3, 2)), 2)
    if exponent.is_Integer:
        exponent = sp.Rational(setting.draw.choice((1, 2, -1)), 3)
    return positive(setting) ** exponent


def _logarithm(setting: Setting, depth: int) -> sp.Expr:
    return sp.log(positive(setting))


def _modulus(setting: Setting, depth: int) -> sp.Expr:
    sign = setting.draw.choice((1, -1))
    return setting.draw.choice((sp.Abs, sp.Abs, sp.sign))(sign * positive(setting))


def _quotient(setting: Setting, depth: int) -> sp.Expr:
    return polynomial(setting) / (1 + phase(setting) ** 2)


def _polynomial(setting: Setting, depth: int) -> sp.Expr:
    return polynomial(setting)


def elliptic_phase(setting: Setting) -> sp.Expr:
    """A phase without a constant; one for all Jacobi functions keeps a statement small."""
    draw = setting.draw
    return sp.Add(*(sp.Rational(draw.choice(SMALL)) * v for v in setting.variables[:2]))


def _elliptic(setting: Setting, depth: int) -> sp.Expr:
    m = setting.elliptic_parameter()
    return setting.draw.choice(ELLIPTIC)(elliptic_phase(setting), m)


def _second(setting: Setting, depth: int) -> sp.Expr:
    m = setting.elliptic_parameter()
    return setting.draw.choice(SECOND)(setting.variables[0], m)


PIECES: tuple[tuple[Callable[[Setting, int], sp.Expr], float], ...] = (
    (_polynomial, 4),
    (_quotient, 2),
    (_entire, 8),
    (_singular, 1),
    (_root, 3),
    (_logarithm, 1.5),
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

"""Epsilon, zeta and theta functions: what the elliptic functions' integrals bring in."""

from __future__ import annotations

from typing import TYPE_CHECKING

import sympy as sp

from solutions.special import jacobi_sn, jacobi_theta, jacobi_zeta

from .elliptic import check_parameter, point
from .generator import Unsupported

if TYPE_CHECKING:
    from .translation import Translation


def additive(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """Epsilon or zeta of an argument: f(u+v) = f(u) + f(v) - m sn u sn v sn(u+v)."""
    argument, m = expression.args
    kind, kernels = expression.func, translation.kernels
    variable, constant = kernels.parts(argument)
    reached, value = sp.S.Zero, sp.S.Zero
    for lattice, part in ((kernels.moving(m), variable), (kernels.fixed(m), constant)):
        if part == 0:
            continue
        for basis_argument, factor in zip(lattice.basis, lattice.coordinates(part), strict=True):
            step = int(sp.sign(factor)) * basis_argument
            for _ in range(abs(factor)):
                value += _generator(translation, kind, step, m)
                value -= _defect(translation, reached, step, m)
                reached += step
    return value


def _defect(translation: Translation, u: sp.Expr, v: sp.Expr, m: sp.Expr) -> sp.Expr:
    if u == 0:
        return sp.S.Zero
    sines = [point(translation, argument, m).sn for argument in (u, v, u + v)]
    return translation.image(m) * sp.Mul(*sines)


def _generator(translation: Translation, kind: type, argument: sp.Expr, m: sp.Expr) -> sp.Expr:
    """Epsilon or zeta of a basis argument or its negative."""
    if argument.could_extract_minus_sign():
        return -_generator(translation, kind, -argument, m)
    if argument == sp.elliptic_k(m):
        check_parameter(translation, argument, m)
        return sp.S.Zero if kind is jacobi_zeta else translation.image(sp.elliptic_e(m))
    meaning = kind(argument, m)
    return translation.primitive(kind.__name__.removeprefix("jacobi_"), meaning)


def theta(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """Theta of a constant, of a basis argument u, or of u + d with a constant d.

    ``P = Theta(u+d)/Theta(u)`` is a generator with (log P)' = Z(d) - m sn u sn d sn(u+d), and with
    gamma = Theta(d)/Theta(0), Theta(u+d) Theta(u-d) is gamma**2 Theta(u)**2 times
    1 - m sn(u)**2 sn(d)**2.
    """
    argument, m = expression.args
    variable, constant = translation.kernels.parts(argument)
    if variable == 0:
        return translation.primitive("theta", jacobi_theta(constant, m))
    basis = translation.kernels.moving(m).basis
    if -variable in basis:
        variable, constant = -variable, -constant
    if variable not in basis:
        raise Unsupported(f"theta of a multiple of another argument: {expression}")
    here = _theta_here(translation, variable, m)
    if constant == 0:
        return here
    if not constant.could_extract_minus_sign():
        return here * _quotient(translation, variable, constant, m)
    return here * _quotient_behind(translation, variable, -constant, m)


def _quotient_behind(translation: Translation, u: sp.Expr, d: sp.Expr, m: sp.Expr) -> sp.Expr:
    """Theta(u-d)/Theta(u) in Theta(u+d)/Theta(u)."""
    sines = [point(translation, z, m).sn for z in (u, d)]
    gamma = translation.image(jacobi_theta(d, m)) / translation.image(jacobi_theta(0, m))
    product = gamma**2 * (1 - translation.image(m) * sines[0] ** 2 * sines[1] ** 2)
    return product / _quotient(translation, u, d, m)


def eta(translation: Translation, expression: sp.Expr) -> sp.Expr:
    """H = sqrt(k) sn Theta."""
    argument, m = expression.args
    check_parameter(translation, expression, m)
    if not translation.rewriting.signs.is_nonnegative(m):
        raise Unsupported(
            f"{m} is not shown to be positive on the domain, which {expression} needs"
        )
    root = translation.image(sp.sqrt(sp.sqrt(m)))
    sine = point(translation, argument, m).sn
    return root * sine * theta(translation, jacobi_theta(argument, m))


def _theta_here(translation: Translation, u: sp.Expr, m: sp.Expr) -> sp.Symbol:
    meaning = jacobi_theta(u, m)
    known = translation.generators.known(meaning)
    if known is not None:
        return known
    symbol = translation.generators.symbol("theta")
    zeta = translation.image(jacobi_zeta(u, m))
    slopes = {v: rate * zeta * symbol for v, rate in translation.derivatives(u).items()}
    return translation.register(symbol, meaning, slopes)


def _quotient(translation: Translation, u: sp.Expr, d: sp.Expr, m: sp.Expr) -> sp.Symbol:
    meaning = jacobi_theta(u + d, m) / jacobi_theta(u, m)
    known = translation.generators.known(meaning)
    if known is not None:
        return known
    symbol = translation.generators.symbol("quotient")
    sines = [translation.image(jacobi_sn(z, m)) for z in (u, d, u + d)]
    slope = translation.image(jacobi_zeta(d, m)) - translation.image(m) * sp.Mul(*sines)
    slopes = {v: rate * slope * symbol for v, rate in translation.derivatives(u).items()}
    return translation.register(symbol, meaning, slopes)

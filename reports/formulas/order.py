r"""The order in which the field writes terms and factors.

Sums begin with the phase's $\xi$ or the highest power; products put parameters before variables,
functions last.
"""

import enum

import sympy as sp

from solutions.symbols import tau, xi

FUNCTION_ORDER = (r"\mathrm{sn}", r"\mathrm{cn}", r"\mathrm{dn}", r"\mathcal{E}", r"\mathrm{Z}")
"""Elliptic functions in the order in which they stand in a product; others follow."""


class Kind(enum.IntEnum):
    """Kinds of factors in the order of a product."""

    NUMBER = enum.auto()
    PARAMETER = enum.auto()
    COEFFICIENT = enum.auto()
    VARIABLE = enum.auto()
    PART = enum.auto()
    OTHER = enum.auto()
    SUM = enum.auto()
    FUNCTION = enum.auto()
    EXPONENTIAL = enum.auto()
    DERIVATIVE = enum.auto()


_KINDS = {
    sp.exp: Kind.EXPONENTIAL,
    sp.Function: Kind.FUNCTION,
    sp.Derivative: Kind.DERIVATIVE,
}


def function_name(function: sp.Expr) -> str:
    """Return the name of an elliptic function as LaTeX."""
    return str(function.latex_symbol).replace("operatorname", "mathrm")


def ordered_terms(total: sp.Expr) -> list[sp.Expr]:
    """Return a sum's terms as they are printed, a positive one first where an end has one.

    >>> k = sp.Symbol("k")
    >>> ordered_terms(k**2 - 1 + k), ordered_terms(1 - k**2), ordered_terms(tau * k + xi)
    ([k**2, k, -1], [1, -k**2], [xi, k*tau])
    """
    rank = _phase_rank if is_linear(total) else _degree_rank
    terms: list[sp.Expr] = sorted(sp.Add.make_args(total), key=rank)
    if len(terms) == 2 and terms[1].is_positive and terms[1].is_number:
        return terms[::-1]
    negative = [bool(term.as_coeff_Mul()[0].is_negative) for term in terms]
    return terms[::-1] if negative[0] and not negative[-1] else terms


def ordered_factors(product: sp.Expr) -> list[sp.Expr]:
    """Return a product's factors as they are printed."""
    return sorted(sp.Mul.make_args(product), key=_factor_rank)


def is_linear(total: sp.Expr) -> bool:
    """Tell whether the expression is of first degree in xi and tau."""
    if not total.has(xi):
        return False
    slopes = [term.as_independent(xi, tau)[1] for term in sp.Add.make_args(total)]
    return xi in slopes and set(slopes) <= {xi, tau, sp.S.One}


def is_phase(total: sp.Expr) -> bool:
    """Tell whether the expression is of first degree in xi and tau, without named parts."""
    return is_linear(total) and not total.atoms(sp.Dummy)


def runs_left(argument: sp.Expr) -> bool:
    """Tell whether a sum falls with xi."""
    return bool(argument.is_Add and argument.coeff(xi).is_negative)


def _phase_rank(term: sp.Expr) -> tuple[object, ...]:
    return not term.has(xi), not term.has(tau), str(term)


def _degree_rank(term: sp.Expr) -> tuple[object, ...]:
    """Fractions last, a named phase first, then by falling powers of tau, of xi, of all."""
    numerator, denominator = sp.fraction(term, exact=True)
    powers = numerator.as_powers_dict()
    phase = any(isinstance(base, sp.Dummy) and base.name.startswith("phi") for base in powers)
    explicit = (-float(powers.get(symbol, 0)) for symbol in (tau, xi))
    return (bool(denominator.free_symbols), not phase, *explicit, -_degree(numerator), str(term))


def _degree(expression: sp.Expr) -> float:
    """Return the total degree, every function counting as one variable."""
    if expression.is_Add:
        return max(_degree(term) for term in expression.args)
    if expression.is_Mul:
        return sum(_degree(factor) for factor in expression.args)
    if expression.is_Pow and expression.exp.is_Rational:
        return float(expression.exp) * _degree(expression.base)
    return float(not expression.is_number)


def _factor_rank(factor: sp.Expr) -> tuple[int, int, str]:
    base = factor.base if factor.is_Pow and factor.exp.is_number else factor
    name = function_name(base) if hasattr(base, "latex_symbol") else getattr(base, "name", "")
    known = name in FUNCTION_ORDER
    place = FUNCTION_ORDER.index(name) if known else len(FUNCTION_ORDER)
    return _kind(base), place, base.name if base.is_Symbol else str(base)


def _kind(base: sp.Expr) -> Kind:
    if base.is_number:
        return Kind.NUMBER
    if base.is_Symbol:
        return _symbol_kind(base)
    if base.is_Add or base.is_Pow:
        varies = base.has(xi, tau) or base.atoms(sp.Dummy)
        return Kind.SUM if varies else Kind.COEFFICIENT
    classes = (
        (sp.exp, Kind.EXPONENTIAL),
        (sp.Function, Kind.FUNCTION),
        (sp.Derivative, Kind.DERIVATIVE),
    )
    return next((kind for cls, kind in classes if isinstance(base, cls)), Kind.OTHER)


def _symbol_kind(symbol: sp.Symbol) -> Kind:
    if symbol in (xi, tau):
        return Kind.VARIABLE
    if not symbol.is_Dummy or symbol.name == "k'":
        return Kind.PARAMETER
    return Kind.FUNCTION if symbol.name in FUNCTION_ORDER else Kind.PART

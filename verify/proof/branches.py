"""Which formulas have no branch point on the domains, so that one point speaks for all of them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import sympy as sp

from solutions.special import jacobi_cn, jacobi_dn, jacobi_epsilon, jacobi_sn
from solutions.special.function import JacobiFunction
from verify.tree import distinct_nodes

from .domain import Domains
from .ranges import Range
from .signs import Signs, is_small_polynomial

ROOT_LIKE = (sp.log, sp.Abs, sp.sign)
INVERSE = (sp.atan, sp.asinh, sp.atanh, sp.asin, sp.acos, sp.acosh)
CELLS = 64
"""More boxes than this are not made of a domain."""


class Branches:
    """Tells formulas that are analytic but for poles from those with branch points or jumps.

    The domains are intervals, so they form a convex box.  A formula without branch points is
    single-valued beyond its poles: if it vanishes on any open piece of the box, it vanishes
    everywhere.
    """

    def __init__(self, signs: Signs) -> None:
        self._signs = signs
        self._found: dict[sp.Expr, bool] = {}

    def is_free(self, expression: sp.Expr) -> bool:
        """Whether ``expression`` is shown to have no branch point and no jump on the box."""
        if expression not in self._found:
            inner = all(map(self.is_free, expression.args))
            self._found[expression] = inner and self._is_free(expression)
        return self._found[expression]

    def _is_free(self, node: sp.Expr) -> bool:
        if node.is_Pow:
            return bool(node.exp.is_Integer) or self._has_a_sign(node.base)
        if isinstance(node, ROOT_LIKE):
            return self._has_a_sign(node.args[0])
        if isinstance(node, INVERSE):
            return self._is_inside(node)
        if isinstance(node, jacobi_sn | jacobi_cn | jacobi_dn | jacobi_epsilon):
            return True  # meromorphic in the argument and the parameter
        if isinstance(node, JacobiFunction | sp.elliptic_k | sp.elliptic_e):
            parameter = self._signs.range(node.args[-1])
            return parameter is not None and _is_below_one(parameter)
        if isinstance(node, sp.conjugate | sp.re | sp.im):
            return self._signs.is_real(node.args[0])
        return True

    def _has_a_sign(self, expression: sp.Expr) -> bool:
        found = self._signs.range(expression)
        return found is not None and found.excludes_zero

    def _is_inside(self, node: sp.Expr) -> bool:
        """An inverse function of an argument without pole, off the ends of its cuts."""
        inner = self._signs.range(node.args[0])
        if inner is None or not self._has_no_pole(node.args[0]):
            return False
        if isinstance(node, sp.atan | sp.asinh):
            return True
        if isinstance(node, sp.acosh):
            return _is_below_one(-inner + Range(Fraction(2), Fraction(2)))
        return _is_below_one(inner) and _is_below_one(-inner)

    def _has_no_pole(self, expression: sp.Expr) -> bool:
        nodes = distinct_nodes(expression)
        denominators = [n.base for n in nodes if n.is_Pow and n.exp.is_negative]
        poles = (sp.tan, sp.cot, sp.sec, sp.csc, sp.coth, sp.csch)
        return all(map(self._has_a_sign, denominators)) and not any(
            isinstance(node, poles) for node in nodes
        )


def _is_below_one(found: Range) -> bool:
    return found.upper < 1 or (found.upper == 1 and found.upper_open)


def cells(domains: Domains, expressions: list[sp.Expr]) -> Iterator[Domains]:
    """Boxes that fill the domains, cut at the rational branch points of ``expressions``.

    Only zeros of polynomials in one symbol are found.  None are given if they are too many.
    """
    cuts: dict[sp.Symbol, set[sp.Rational]] = {}
    for expression in expressions:
        for node in distinct_nodes(expression):
            inner = node.base if node.is_Pow else node.args[0] if node.args else node
            if len(inner.free_symbols) == 1 and is_small_polynomial(inner):
                (symbol,) = inner.free_symbols
                roots = sp.Poly(inner, symbol, domain="QQ").ground_roots()
                cuts.setdefault(symbol, set()).update(roots)
    pieces = [
        [(symbol, low, high) for low, high in itertools.pairwise(_ends(domains, symbol, zeros))]
        for symbol, zeros in cuts.items()
    ]
    if sp.Mul(*map(len, pieces)) > CELLS:
        return
    for choice in itertools.product(*pieces):
        box = dict(domains)
        for symbol, low, high in choice:
            box[symbol] = replace(domains[symbol], lower=low, upper=high, nonzero=False)
            box[symbol] = replace(box[symbol], lower_open=True, upper_open=True)
        yield box


def _ends(domains: Domains, symbol: sp.Symbol, zeros: set[sp.Rational]) -> list[sp.Expr]:
    domain = domains[symbol]
    lower, upper = domain.lower, domain.upper
    known = not (lower.free_symbols or upper.free_symbols)
    inside = sorted(z for z in zeros if known and lower < z < upper)
    return [lower, *inside, upper]

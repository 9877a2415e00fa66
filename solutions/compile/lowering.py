"""Lowering of a closed form's stable expression to what is computed at each point.

Subexpressions free of xi, tau and zeta become named constants, evaluated once to many digits. The
part of a sum that is linear in them becomes one phase ``p xi + q tau + r + w zeta``, which is
computed accurately elsewhere. It includes the secular part ``(E/K) u`` of the epsilon function, so
that nothing cancels. All Jacobi functions of one phase become the symbols of one call; sin and cos
are sn and cn at m = 0.
"""

from collections.abc import Iterable
from typing import NamedTuple

import sympy as sp

from longwave.solutions.functions import (
    jacobi_cn,
    jacobi_dn,
    jacobi_epsilon,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)
from longwave.solutions.symbols import tau, xi, zeta

JACOBI_FUNCTIONS = (jacobi_sn, jacobi_cn, jacobi_dn, jacobi_zeta, jacobi_theta)


class Phase(NamedTuple):
    """``symbol = p xi + q tau + r + w zeta``; coefficients are expressions in the parameters."""

    symbol: sp.Symbol
    p: sp.Expr
    q: sp.Expr
    r: sp.Expr
    w: sp.Expr


class JacobiCall(NamedTuple):
    """The Jacobi functions of one phase and one parameter m.

    ``symbols`` are sn, cn, dn, zeta, theta, in the order in which they are computed.
    """

    phase: sp.Symbol
    m: sp.Expr
    symbols: tuple[sp.Symbol, ...]

    def derivatives(self, mean: sp.Expr) -> dict[sp.Symbol, sp.Expr]:
        """Return each symbol's derivative with respect to the phase; ``mean`` is E/K."""
        z = sp.Dummy("z", real=True)
        m = sp.Dummy("m", positive=True)
        functions = {f(z, m): self.symbol_of(f) for f in JACOBI_FUNCTIONS}
        functions |= {sp.elliptic_e(m) / sp.elliptic_k(m): mean}
        rates = (sp.diff(f(z, m), z).subs(functions).subs(m, self.m) for f in JACOBI_FUNCTIONS)
        return dict(zip(self.symbols, rates, strict=True))

    def symbol_of(self, function: type[sp.Function]) -> sp.Symbol:
        """Return the symbol of ``function`` of the phase."""
        return self.symbols[JACOBI_FUNCTIONS.index(function)]


_AT_PARAMETER_ZERO = {sp.sin: jacobi_sn, sp.cos: jacobi_cn}

SPACE_TIME_VARIABLES = (xi, tau, zeta)

Parts = tuple[sp.Expr, sp.Expr]
"""Real and imaginary part."""

Terms = dict[sp.Expr | None, list[sp.Expr]]
"""Terms of a sum by their factor xi, tau, 1 or zeta; None is the key of all other terms."""


def _add_terms(parts: Iterable[tuple[sp.Expr, Terms]]) -> Terms:
    """Return the sum of ``factor * terms`` over the pairs (factor, terms) in ``parts``."""
    total: Terms = {}
    for factor, terms in parts:
        for variable, coefficients in terms.items():
            total.setdefault(variable, []).extend(factor * term for term in coefficients)
    return total


class Lowering:
    """Lowering of expressions, which collects their phases, Jacobi calls and constants."""

    def __init__(self) -> None:
        self.phases: dict[tuple[sp.Expr, ...], Phase] = {}
        self.calls: dict[tuple[sp.Symbol, sp.Expr], JacobiCall] = {}
        self.constants: dict[sp.Expr, sp.Symbol] = {}
        self._lowered: dict[sp.Expr, sp.Expr] = {}
        self._varies: dict[sp.Expr, bool] = {}

    def lower(self, expression: sp.Expr) -> sp.Expr:
        """Return ``expression`` in terms of phases, symbols of Jacobi calls and constants."""
        if expression not in self._lowered:
            self._lowered[expression] = self._lower(expression)
        return self._lowered[expression]

    def constant(self, expression: sp.Expr) -> sp.Expr:
        """Return the symbol that stands for a constant expression, or a rational number itself."""
        if expression.is_Rational:
            return expression
        name = f"C_{len(self.constants)}"
        return self.constants.setdefault(expression, sp.Symbol(name, real=True))

    def _lower(self, expression: sp.Expr) -> sp.Expr:
        if not self._is_varying(expression):
            return self.constant(expression)
        if expression.is_Symbol or expression.is_Add or expression.func is jacobi_epsilon:
            return self._lower_sum(expression)
        if expression.func in JACOBI_FUNCTIONS:
            call = self._call(*expression.args)
            return call.symbol_of(expression.func)
        if expression.func in _AT_PARAMETER_ZERO:
            call = self._call(expression.args[0], sp.S.Zero)
            return call.symbol_of(_AT_PARAMETER_ZERO[expression.func])
        if expression.is_Mul:
            constant_factors, varying = self._split(expression)
            return sp.Mul(self.constant(constant_factors), *map(self.lower, varying))
        if expression.is_Pow:
            return self.lower(expression.base) ** self.constant(expression.exp)
        return expression.func(*(self.lower(argument) for argument in expression.args))

    def _lower_sum(self, expression: sp.Expr) -> sp.Expr:
        terms = self._sum(expression)
        other_terms = [self.lower(term) for term in terms.get(None, ())]
        if not terms.keys() & SPACE_TIME_VARIABLES:
            return sp.Add(self.constant(sp.Add(*terms.get(sp.S.One, ()))), *other_terms)
        return sp.Add(self._phase(terms), *other_terms)

    def _phase(self, terms: Terms) -> sp.Symbol:
        """Return the symbol of the phase whose coefficients are the sums of ``terms``."""
        key = tuple(sp.Add(*terms.get(part, ())) for part in (xi, tau, sp.S.One, zeta))
        if key not in self.phases:
            symbol = sp.Symbol(f"phi_{len(self.phases)}", real=True)
            self.phases[key] = Phase(symbol, *key)
        return self.phases[key].symbol

    def _sum(self, expression: sp.Expr) -> Terms:
        """Split a sum into `Terms`; a constant times a part linear in xi, tau, zeta is expanded."""
        if not self._is_varying(expression):
            return {sp.S.One: [expression]}
        if expression in SPACE_TIME_VARIABLES:
            return {expression: [sp.S.One]}
        if expression.func is jacobi_epsilon:
            z, m = expression.args
            mean = sp.elliptic_e(m) / sp.elliptic_k(m)
            return _add_terms([(sp.S.One, {None: [jacobi_zeta(z, m)]}), (mean, self._sum(z))])
        if expression.is_Add:
            return _add_terms((sp.S.One, self._sum(term)) for term in expression.args)
        if expression.is_Mul:
            constant_factors, varying = self._split(expression)
            inner = self._sum(varying[0]) if len(varying) == 1 else {}
            if inner.keys() & SPACE_TIME_VARIABLES:
                return _add_terms([(constant_factors, inner)])
        return {None: [expression]}

    def _call(self, z: sp.Expr, m: sp.Expr) -> JacobiCall:
        terms = self._sum(z)
        if None in terms:
            raise ValueError(
                f"arguments of Jacobi functions must be linear in xi, tau, zeta, got {z} "
                "(give the form an evaluator of its own)"
            )
        phase = self._phase(terms)
        names = ("sn", "cn", "dn", "zeta", "theta")
        symbols = tuple(sp.Symbol(f"{name}_{phase.name}", real=True) for name in names)
        return self.calls.setdefault((phase, m), JacobiCall(phase, m, symbols))

    def _split(self, product: sp.Expr) -> tuple[sp.Expr, list[sp.Expr]]:
        varying = [factor for factor in product.args if self._is_varying(factor)]
        constant_factors = [factor for factor in product.args if not self._is_varying(factor)]
        return sp.Mul(*constant_factors), varying

    def _is_varying(self, expression: sp.Expr) -> bool:
        if expression not in self._varies:
            is_variable = expression in SPACE_TIME_VARIABLES
            self._varies[expression] = is_variable or any(map(self._is_varying, expression.args))
        return self._varies[expression]


def complex_parts(expression: sp.Expr) -> Parts:
    """Return real and imaginary part of a complex expression.

    It may have sums, products and powers of real expressions, I and exp(I ...). Nothing is expanded
    or simplified; symbols and functions without I are taken as real. Raises ValueError for I in
    another function or in a divisor.

    >>> x, y = sp.symbols("x y", real=True)
    >>> complex_parts((1 + 2 * sp.I * x) / (1 + x**2) * sp.exp(sp.I * y))[1]
    2*x*cos(y)/(x**2 + 1) + sin(y)/(x**2 + 1)
    """
    if not expression.has(sp.I):
        return expression, sp.S.Zero
    if expression == sp.I:
        return sp.S.Zero, sp.S.One
    if expression.is_Add:
        pairs = [complex_parts(term) for term in expression.args]
        return sp.Add(*(re for re, _ in pairs)), sp.Add(*(im for _, im in pairs))
    if expression.is_Mul:
        return _product(expression)
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        return _product(sp.Mul(*[expression.base] * int(expression.exp), evaluate=False))
    if isinstance(expression, sp.exp):
        growth, angle = complex_parts(expression.args[0])
        return sp.exp(growth) * sp.cos(angle), sp.exp(growth) * sp.sin(angle)
    raise ValueError(
        f"I must occur only in sums, products and exponentials, got {expression} "
        "(write the real and the imaginary part)"
    )


def _product(product: sp.Expr) -> Parts:
    """Return real and imaginary part of a product; its real factors are kept as one factor."""
    real = sp.Mul(*(factor for factor in product.args if not factor.has(sp.I)))
    re, im = real, sp.S.Zero
    for factor in product.args:
        if factor.has(sp.I):
            other_re, other_im = complex_parts(factor)
            re, im = re * other_re - im * other_im, re * other_im + im * other_re
    return re, im

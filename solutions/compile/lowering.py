"""From a closed form's stable expression to what is computed at each point.

Everything free of xi, tau and zeta becomes a named constant (evaluated once, to many digits). A
sum's part linear in them becomes one phase ``p xi + q tau + r + w zeta``, formed accurately
outside; the secular part ``(E/K) u`` of the epsilon function joins it, so that nothing cancels.
All Jacobi functions of one phase become the symbols of one call; sin and cos are sn and cn at
m = 0.
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

JACOBI_FUNCTIONS: tuple[type[sp.Function], ...] = (
    jacobi_sn,
    jacobi_cn,
    jacobi_dn,
    jacobi_zeta,
    jacobi_theta,
)


class Phase(NamedTuple):
    """``symbol = p xi + q tau + r + w zeta`` with coefficients in the parameters."""

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
        """Each symbol's derivative with respect to the phase; ``mean`` is E/K."""
        z = sp.Dummy("z", real=True)
        m = sp.Dummy("m", positive=True)
        functions = {f(z, m): self.symbol_of(f) for f in JACOBI_FUNCTIONS}
        functions |= {sp.elliptic_e(m) / sp.elliptic_k(m): mean}
        rates = {}
        for f in JACOBI_FUNCTIONS:
            rate = sp.diff(f(z, m), z).subs(functions).subs(m, self.m)
            rates[self.symbol_of(f)] = rate
        return rates

    def symbol_of(self, function: type[sp.Function]) -> sp.Symbol:
        """The symbol that stands for ``function`` of the phase."""
        return self.symbols[JACOBI_FUNCTIONS.index(function)]


_AT_PARAMETER_ZERO = {sp.sin: jacobi_sn, sp.cos: jacobi_cn}


MOVING = (xi, tau, zeta)

Parts = tuple[sp.Expr, sp.Expr]
"""Real and imaginary part."""

Terms = dict[sp.Expr | None, list[sp.Expr]]
"""A sum by its coefficients of xi, tau, 1 and zeta; under None are the other terms."""


def _total(parts: Iterable[tuple[sp.Expr, Terms]]) -> Terms:
    """The sum of sums, each times a factor."""
    total: Terms = {}
    for factor, terms in parts:
        for variable, coefficients in terms.items():
            total.setdefault(variable, []).extend(factor * term for term in coefficients)
    return total


class Lowering:
    """Collects the phases, Jacobi calls and constants of the expressions it lowers."""

    def __init__(self) -> None:
        self.phases: dict[tuple[sp.Expr, ...], Phase] = {}
        self.calls: dict[tuple[sp.Symbol, sp.Expr], JacobiCall] = {}
        self.constants: dict[sp.Expr, sp.Symbol] = {}
        self._lowered: dict[sp.Expr, sp.Expr] = {}
        self._varies: dict[sp.Expr, bool] = {}

    def lower(self, expression: sp.Expr) -> sp.Expr:
        """``expression`` in phases, symbols of Jacobi calls and constants."""
        if expression not in self._lowered:
            self._lowered[expression] = self._lower(expression)
        return self._lowered[expression]

    def constant(self, expression: sp.Expr) -> sp.Expr:
        """The symbol of a constant; rational numbers stay as they are."""
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
            fixed, varying = self._split(expression)
            return sp.Mul(self.constant(fixed), *(self.lower(factor) for factor in varying))
        if expression.is_Pow:
            return self.lower(expression.base) ** self.constant(expression.exp)
        return expression.func(*(self.lower(argument) for argument in expression.args))

    def _lower_sum(self, expression: sp.Expr) -> sp.Expr:
        terms = self._sum(expression)
        rest = [self.lower(term) for term in terms.get(None, ())]
        if not terms.keys() & MOVING:
            return sp.Add(self.constant(sp.Add(*terms.get(sp.S.One, ()))), *rest)
        return sp.Add(self._phase(terms), *rest)

    def _phase(self, terms: Terms) -> sp.Symbol:
        """The symbol of the phase with these summed coefficients."""
        key = tuple(sp.Add(*terms.get(part, ())) for part in (xi, tau, sp.S.One, zeta))
        if key not in self.phases:
            symbol = sp.Symbol(f"phi_{len(self.phases)}", real=True)
            self.phases[key] = Phase(symbol, *key)
        return self.phases[key].symbol

    def _sum(self, expression: sp.Expr) -> Terms:
        """Split a sum; constant factors are multiplied out where a linear part is inside."""
        if not self._is_varying(expression):
            return {sp.S.One: [expression]}
        if expression in MOVING:
            return {expression: [sp.S.One]}
        if expression.func is jacobi_epsilon:
            z, m = expression.args
            mean = sp.elliptic_e(m) / sp.elliptic_k(m)
            return _total([(sp.S.One, {None: [jacobi_zeta(z, m)]}), (mean, self._sum(z))])
        if expression.is_Add:
            return _total((sp.S.One, self._sum(term)) for term in expression.args)
        if expression.is_Mul:
            fixed, varying = self._split(expression)
            inner = self._sum(varying[0]) if len(varying) == 1 else {}
            if inner.keys() & MOVING:
                return _total([(fixed, inner)])
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
        fixed = [factor for factor in product.args if not self._is_varying(factor)]
        return sp.Mul(*fixed), varying

    def _is_varying(self, expression: sp.Expr) -> bool:
        if expression not in self._varies:
            self._varies[expression] = expression in MOVING or any(
                self._is_varying(argument) for argument in expression.args
            )
        return self._varies[expression]


def complex_parts(expression: sp.Expr) -> Parts:
    """Real and imaginary part of sums, products and powers of real expressions, I and exp(I ...).

    Nothing is expanded or simplified, and every symbol and function without I in it is taken for
    real. Raises ValueError where I stands in another function or in a divisor.

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
        f"I must stand in sums, products and exponentials alone, got {expression} "
        "(write the real and the imaginary part)"
    )


def _product(product: sp.Expr) -> Parts:
    """The real factors stay together; the others are multiplied one by one."""
    real = sp.Mul(*(factor for factor in product.args if not factor.has(sp.I)))
    re, im = real, sp.S.Zero
    for factor in product.args:
        if factor.has(sp.I):
            other_re, other_im = complex_parts(factor)
            re, im = re * other_re - im * other_im, re * other_im + im * other_re
    return re, im

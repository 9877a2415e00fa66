"""From a closed form's stable expression to what is computed at each point.

Everything free of xi, tau and zeta becomes a named constant (evaluated once, to many digits). A
sum's part linear in them becomes one phase ``p xi + q tau + r + w zeta``, formed accurately
outside; the secular part ``(E/K) u`` of the epsilon function joins it, so that nothing cancels.
All Jacobi functions of one phase become the symbols of one call; sin and cos are sn and cn at
m = 0.
"""

from dataclasses import dataclass, field

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


@dataclass(frozen=True)
class Phase:
    """``symbol = p xi + q tau + r + w zeta`` with coefficients in the parameters."""

    symbol: sp.Symbol
    p: sp.Expr
    q: sp.Expr
    r: sp.Expr
    w: sp.Expr

    @property
    def coefficients(self) -> tuple[sp.Expr, ...]:
        """p, q, r and w."""
        return self.p, self.q, self.r, self.w


@dataclass(frozen=True)
class JacobiCall:
    """The Jacobi functions of one phase and one parameter m."""

    phase: sp.Symbol
    m: sp.Expr
    sn: sp.Symbol
    cn: sp.Symbol
    dn: sp.Symbol
    zeta: sp.Symbol
    theta: sp.Symbol

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """sn, cn, dn, zeta, theta, in the order in which they are computed."""
        return (self.sn, self.cn, self.dn, self.zeta, self.theta)

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


@dataclass
class _Sum:
    """A sum split into ``p xi + q tau + r + w zeta`` and the other terms."""

    p: list[sp.Expr] = field(default_factory=list)
    q: list[sp.Expr] = field(default_factory=list)
    r: list[sp.Expr] = field(default_factory=list)
    w: list[sp.Expr] = field(default_factory=list)
    rest: list[sp.Expr] = field(default_factory=list)

    @property
    def is_moving(self) -> bool:
        return bool(self.p or self.q or self.w)

    def extend(self, other: "_Sum", factor: sp.Expr) -> None:
        for mine, theirs in zip(
            (self.p, self.q, self.r, self.w, self.rest),
            (other.p, other.q, other.r, other.w, other.rest),
            strict=True,
        ):
            mine.extend(factor * term for term in theirs)


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
        rest = [self.lower(term) for term in terms.rest]
        if not terms.is_moving:
            return sp.Add(self.constant(sp.Add(*terms.r)), *rest)
        return sp.Add(self._phase(terms), *rest)

    def _phase(self, terms: _Sum) -> sp.Symbol:
        """The symbol of the phase with these summed coefficients."""
        key = tuple(sp.Add(*part) for part in (terms.p, terms.q, terms.r, terms.w))
        if key not in self.phases:
            symbol = sp.Symbol(f"phi_{len(self.phases)}", real=True)
            self.phases[key] = Phase(symbol, *key)
        return self.phases[key].symbol

    def _sum(self, expression: sp.Expr) -> _Sum:
        """Split a sum; constant factors are multiplied out where a linear part is inside."""
        if not self._is_varying(expression):
            return _Sum(r=[expression])
        if expression == xi:
            return _Sum(p=[sp.S.One])
        if expression == tau:
            return _Sum(q=[sp.S.One])
        if expression == zeta:
            return _Sum(w=[sp.S.One])
        if expression.func is jacobi_epsilon:
            return self._epsilon(*expression.args)
        if expression.is_Add:
            total = _Sum()
            for term in expression.args:
                total.extend(self._sum(term), sp.S.One)
            return total
        if expression.is_Mul:
            return self._scaled(expression)
        return _Sum(rest=[expression])

    def _scaled(self, expression: sp.Expr) -> _Sum:
        fixed, varying = self._split(expression)
        if len(varying) == 1:
            inner = self._sum(varying[0])
            if inner.is_moving:
                total = _Sum()
                total.extend(inner, fixed)
                return total
        return _Sum(rest=[expression])

    def _epsilon(self, z: sp.Expr, m: sp.Expr) -> _Sum:
        total = _Sum(rest=[jacobi_zeta(z, m)])
        total.extend(self._sum(z), sp.elliptic_e(m) / sp.elliptic_k(m))
        return total

    def _call(self, z: sp.Expr, m: sp.Expr) -> JacobiCall:
        terms = self._sum(z)
        if terms.rest:
            raise ValueError(
                f"arguments of Jacobi functions must be linear in xi, tau, zeta, got {z} "
                "(give the form an evaluator of its own)"
            )
        phase = self._phase(terms)
        names = ("sn", "cn", "dn", "zeta", "theta")
        symbols = (sp.Symbol(f"{name}_{phase.name}", real=True) for name in names)
        return self.calls.setdefault((phase, m), JacobiCall(phase, m, *symbols))

    def _split(self, product: sp.Expr) -> tuple[sp.Expr, list[sp.Expr]]:
        varying = [factor for factor in product.args if self._is_varying(factor)]
        fixed = [factor for factor in product.args if not self._is_varying(factor)]
        return sp.Mul(*fixed), varying

    def _is_varying(self, expression: sp.Expr) -> bool:
        if expression not in self._varies:
            self._varies[expression] = expression in (xi, tau, zeta) or any(
                self._is_varying(argument) for argument in expression.args
            )
        return self._varies[expression]

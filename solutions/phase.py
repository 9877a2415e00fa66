"""What a closed form is evaluated from: linear phases, and the Jacobi functions of them."""

from dataclasses import dataclass

import sympy as sp

from solutions.special import jacobi_cn, jacobi_dn, jacobi_sn, jacobi_theta, jacobi_zeta

__all__ = ["JACOBI_FUNCTIONS", "JacobiCall", "Phase"]

JACOBI_FUNCTIONS: tuple[type[sp.Function], ...] = (
    jacobi_sn,
    jacobi_cn,
    jacobi_dn,
    jacobi_zeta,
    jacobi_theta,
)


@dataclass(frozen=True)
class Phase:
    """``symbol = p xi + q tau + r`` with coefficients in the parameters."""

    symbol: sp.Symbol
    p: sp.Expr
    q: sp.Expr
    r: sp.Expr


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

"""Decay of a soliton by weak losses, from the balance of its momentum.

A solitary wave of ``Y_T + alpha Y^r Y_X + delta Y_XXX = 0`` with crest a has
``Y_X^2 = kappa Y^2 (a^r - Y^r)``, ``kappa = 2 alpha/((r + 1) (r + 2) delta)``, so that its
integrals over X become integrals over Y.  With ``damping Y - diffusion Y_XX`` on the left of the
equation it keeps this shape, at leading order, and the balance
``d/dT int Y^2 = -2 damping int Y^2 - 2 diffusion int Y_X^2`` gives a(T).  The bright soliton of the
NLS equation has the same shape with r = 2.
"""

import re
from collections.abc import Collection
from dataclasses import dataclass

from sympy import Expr, Rational, S, Symbol, beta, exp, gammasimp

from longwave.derive.algebra.formula_printing import Printed
from longwave.derive.output.notation import Displayed
from longwave.derive.output.own_names import unused

crest, first_crest, slow_time = (Symbol(name, positive=True) for name in ("a(T)", "a(0)", "T"))
"""Crest, initial crest and slow time, with names that no constant of a lattice can have."""


@dataclass(frozen=True, repr=False)
class AmplitudeLaw(Displayed):
    """``a' = -linear a - further a^(power + 1)`` of a soliton's crest a(T).

    >>> g, h = Symbol("g", positive=True), Symbol("h", positive=True)
    >>> AmplitudeLaw(1, g, h).solution
    a(0)*exp(-T*g)/(a(0)*h*(1 - exp(-T*g))/g + 1)
    """

    power: int
    linear: Expr
    further: Expr = S.Zero

    @property
    def rate(self) -> Expr:
        """The rate a'(T)."""
        return -self.linear * crest - self.further * crest ** (self.power + 1)

    @property
    def solution(self) -> Expr:
        """The crest a(T) as a function of T and its initial value a(0)."""
        decayed, r = exp(-self.linear * slow_time), self.power
        loss_integral = (1 - decayed**r) / self.linear if self.linear else r * slow_time
        divisor = (1 + self.further * first_crest**r * loss_integral) ** Rational(1, r)
        return first_crest * decayed / divisor

    def text_beside(self, taken: Collection[str]) -> str:
        """Return `text`, with the symbol ``a`` renamed if the lattice has ``taken`` this name."""
        name = unused("a", taken)
        return re.sub(r"\ba(?='?\((T|0)\))", name, self.text())

    def written(self, printed: Printed) -> str:
        """Return the text ``a'(T) = ..., a(T) = ...``, with formulas formatted by ``printed``."""
        return f"a'(T) = {printed(self.rate)}, a(T) = {printed(self.solution)}"


def amplitude_law(power: int, ratio: Expr, damping: Expr, diffusion: Expr) -> AmplitudeLaw:
    """Return the decay law of a soliton with ``Y_X^2 = ratio Y^2 (a^power - Y^power)``.

    The loss terms are ``damping Y - diffusion Y_XX`` on the left-hand side of its equation.

    >>> gamma = Symbol("gamma", positive=True)
    >>> amplitude_law(1, S.One, gamma / 2, S.Zero).solution
    a(0)*exp(-2*T*gamma/3)
    """
    half, exponent = Rational(1, 2), Rational(2, power)
    slopes_to_squares = gammasimp(beta(exponent, 3 * half) / beta(exponent, half))
    momentum_power = 2 - half * power
    further = 2 * diffusion * ratio * slopes_to_squares / momentum_power
    return AmplitudeLaw(power, 2 * damping / momentum_power, further)

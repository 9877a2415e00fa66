"""The variables and parameters of a random statement, with their ranges."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

import sympy as sp

from verify.studies.statements.record import Point, Range

VARIABLES = ("x", "t", "y")
PARAMETERS = ("a", "b", "c", "q", "w", "i", "e", "root", "sn", "U", "u", "lambda")
"""Among them are names that a prover may take for its own."""


@dataclass
class Setting:
    """The symbols of a statement.

    ``modulus`` is the parameter m of the Jacobi functions, once one was asked for.
    """

    draw: random.Random
    variables: tuple[sp.Symbol, ...]
    parameters: list[sp.Symbol]
    ranges: dict[sp.Symbol, Range]
    modulus: sp.Expr | None = field(default=None)

    @property
    def unknown(self) -> sp.Expr:
        """The function to be solved for."""
        return sp.Function("u")(*self.variables)

    def point(self) -> Point:
        """A random admissible point."""
        return {s: self.ranges[s].number(self.draw) for s in (*self.variables, *self.parameters)}

    def of_sign(self, sign: int) -> list[sp.Symbol]:
        """The symbols that have one sign throughout."""
        return [made.symbol for made in self.ranges.values() if made.has_sign(sign)]

    def with_both_signs(self) -> list[sp.Symbol]:
        """The symbols that have both signs."""
        signed = {*self.of_sign(1), *self.of_sign(-1)}
        return [symbol for symbol in self.ranges if symbol not in signed]

    def new_parameter(
        self, name: str, low: sp.Rational | None, high: sp.Rational | None
    ) -> sp.Symbol:
        """One more parameter with a range of its own."""
        made = ranged(name, low, high)
        self.parameters.append(made.symbol)
        self.ranges[made.symbol] = made
        return made.symbol

    def elliptic_parameter(self) -> sp.Expr:
        """The m of all Jacobi functions here: a number, or the square of a modulus."""
        if self.modulus is None:
            kind = self.draw.random()
            if kind < 0.3:
                self.modulus = sp.Rational(self.draw.randint(1, 8), 9)
            elif kind < 0.8:
                self.modulus = self.new_parameter("k", sp.S.Zero, sp.S.One) ** 2
            else:
                self.modulus = self.new_parameter("m", sp.S.Zero, sp.S.One)
        return self.modulus


def ranged(name: str, low: sp.Rational | None, high: sp.Rational | None) -> Range:
    """A symbol whose assumptions say what they can of its range."""
    if low is not None and low >= 0:
        return Range(sp.Symbol(name, positive=True), low, high)
    if high is not None and high <= 0:
        return Range(sp.Symbol(name, negative=True), low, high)
    return Range(sp.Symbol(name, real=True), low, high)


def random_setting(draw: random.Random, variables: int = 0, parameters: int = -1) -> Setting:
    """One to three variables and up to three parameters, each with a random range."""
    count = variables or draw.choice((1, 2, 2, 2, 3))
    names = VARIABLES[:count]
    extra = draw.sample(PARAMETERS, draw.randint(0, 3) if parameters < 0 else parameters)
    if draw.random() < 0.8:
        extra = list("abc")[: len(extra)]
    made = [random_range(draw, name) for name in (*names, *extra)]
    symbols = [r.symbol for r in made]
    return Setting(draw, tuple(symbols[:count]), symbols[count:], {r.symbol: r for r in made})


def random_range(draw: random.Random, name: str) -> Range:
    """The whole line, a half line or an interval."""
    kind = draw.random()
    if kind < 0.4:
        return ranged(name, None, None)
    if kind < 0.6:
        return ranged(name, sp.S.Zero, None)
    if kind < 0.75:
        return ranged(name, None, sp.S.Zero)
    end = sp.Rational(draw.randint(-12, 12), draw.choice((1, 2, 3, 5)))
    if kind < 0.8:
        return ranged(name, end, None)
    if kind < 0.85:
        return ranged(name, None, end)
    return ranged(name, end, end + sp.Rational(draw.randint(1, 30), draw.choice((1, 4, 9, 10))))

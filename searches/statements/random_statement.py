"""Random statement as SymPy builds it: its symbols with their ranges, and its truth."""

from __future__ import annotations

import random
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

import sympy as sp

from longwave.derive.algebra.formula_printing import formula_as_text
from searches.texts.text_statement import Letter, TextStatement, Truth

Point = Mapping[sp.Symbol, sp.Rational]

SPAN = 4
"""How far beyond the end of a half line, and beyond 0 on the whole line, numbers are drawn."""

LARGEST_DENOMINATOR = 200


@dataclass(frozen=True)
class SymbolRange:
    """The open interval from which a symbol takes its values; None for an end at infinity."""

    symbol: sp.Symbol
    low: sp.Rational | None = None
    high: sp.Rational | None = None

    def has_sign(self, sign: int) -> bool:
        """Whether all values have the sign +1 or -1."""
        end = self.low if sign > 0 else self.high
        return end is not None and bool(sign * end >= 0)

    def number(self, draw: random.Random) -> sp.Rational:
        """A random rational number in the range, other than 0."""
        low = self.low if self.low is not None else min(self.high or 0, 0) - SPAN
        high = self.high if self.high is not None else max(self.low or 0, 0) + SPAN
        denominator = draw.randint(7, LARGEST_DENOMINATOR)
        part = sp.Rational(draw.randint(1, denominator - 1), denominator)
        found = low + (high - low) * part
        return found if found != 0 else self.number(draw)

    def letter(self, name: str) -> Letter:
        """Return the range in text, under a name."""
        ends = (None if end is None else sp.Rational(end) for end in (self.low, self.high))
        low, high = (end if end is None else Fraction(int(end.p), int(end.q)) for end in ends)
        return Letter(name, low, high)


@dataclass(frozen=True)
class RandomStatement:
    """``left = right`` as functions of ``variables``; or, with ``unknown``, ``left = 0`` solved.

    In the second case ``left`` is the equation's left-hand side and ``right`` the formula that
    is put for ``unknown``.  ``ranges`` has every symbol.  ``counterexample`` is an admissible
    point at which a false statement fails, if it fails at few.
    """

    kind: str
    truth: Truth
    left: sp.Expr
    right: sp.Expr
    variables: tuple[sp.Symbol, ...]
    ranges: tuple[SymbolRange, ...]
    unknown: sp.Expr | None = None
    counterexample: Point | None = None

    def text(self) -> TextStatement:
        """Return the statement in text, its variables as x, t, y."""
        names = dict(zip(self.variables, map(sp.Symbol, VARIABLES), strict=False))
        names = {own: sp.Symbol(new.name, **own.assumptions0) for own, new in names.items()}
        letters = [made.letter(names.get(made.symbol, made.symbol).name) for made in self.ranges]
        right, unknown = self.right.xreplace(names), self.unknown
        equation, solution = sp.Function("u")(*names.values()) - right, self.left.xreplace(names)
        if unknown is not None:
            own = sp.Function("u")(*names.values())
            left = self.left.subs(unknown, sp.Function("u")(*unknown.args)).xreplace(names)
            equation, solution = left.replace(type(unknown), lambda *_: own), right
        point = {
            names.get(symbol, symbol).name: Fraction(int(value.p), int(value.q))
            for symbol, value in (self.counterexample or {}).items()
        }
        texts = formula_as_text(equation), f"u = {formula_as_text(solution)}"
        used = {*re.findall(r"\b[A-Za-z]\w*", " ".join(texts))}
        used |= {*"".join(name[2:] for name in used if name.startswith("u_"))}
        return TextStatement(
            self.kind,
            self.truth,
            texts[:1],
            texts[1:],
            tuple(letter for letter in letters if letter.name in used),
            counterexample=point or None,
        )


VARIABLES = ("x", "t", "y")
PARAMETERS = ("a", "b", "c", "q", "w", "g", "h", "p", "r", "s", "v", "zeta")


@dataclass
class Setting:
    """The symbols of a statement.

    ``modulus`` is the parameter m of the Jacobi functions, once one was asked for.
    """

    draw: random.Random
    variables: tuple[sp.Symbol, ...]
    parameters: list[sp.Symbol]
    ranges: dict[sp.Symbol, SymbolRange]
    modulus: sp.Expr | None = field(default=None)

    @property
    def unknown(self) -> sp.Expr:
        """The function to be solved for."""
        return sp.Function("u")(*self.variables)

    def equation(self, kind: str, left: sp.Expr, solution: sp.Expr) -> RandomStatement:
        """The true statement that ``solution`` makes ``left`` vanish."""
        return replace(self.equality(kind, left, solution), unknown=self.unknown)

    def equality(self, kind: str, left: sp.Expr, right: sp.Expr) -> RandomStatement:
        """The true statement that two formulas are one function."""
        ranges = tuple(self.ranges.values())
        return RandomStatement(kind, Truth.TRUE, left, right, self.variables, ranges)

    def narrow(self, low: sp.Rational, high: sp.Rational) -> sp.Symbol:
        """The first variable, from now on with this range."""
        place, *rest = self.variables
        made = ranged(place.name, low, high)
        del self.ranges[place]
        self.ranges[made.symbol] = made
        self.variables = (made.symbol, *rest)
        return made.symbol

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


def ranged(name: str, low: sp.Rational | None, high: sp.Rational | None) -> SymbolRange:
    """A symbol whose assumptions say what they can of its range."""
    if low is not None and low >= 0:
        return SymbolRange(sp.Symbol(name, positive=True), low, high)
    if high is not None and high <= 0:
        return SymbolRange(sp.Symbol(name, negative=True), low, high)
    return SymbolRange(sp.Symbol(name, real=True), low, high)


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


def random_range(draw: random.Random, name: str) -> SymbolRange:
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

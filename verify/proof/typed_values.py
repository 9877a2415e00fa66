"""What was typed, evaluated by itself: a guard against a text that SymPy reads as another.

SymPy simplifies while it builds formulas (`sign(z)**2` becomes 1; `abs(n)` becomes n for n > 0, and
is shifted then).  So a verdict is compared with balls around the residual of the texts as they
stand, at points of the domain: at some that are drawn, and at the first integers that it holds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import islice, product

import sympy as sp

from verify.studies.statements.random_statement import Truth
from verify.studies.texts.ball_judge import BITS, Judge, Unsaid
from verify.studies.texts.text_statement import Letter, TextPoint, TextStatement

from .domains import Domain, Domains
from .samples import sample
from .text_names import SITE
from .typed_statement import StatementTexts

POINTS = 4
"""Points of the domain that are drawn."""

QUICK = (128,)
"""Bits of the balls at drawn points: a failure that needs more is no misreading."""

FIRST, MOST = 4, 16
"""Integers next to the end of their domain, or about 0, that are looked at; their combinations."""

CONSTANTS = ("pi", "I")


class TypedValues:
    """The residuals of a statement's texts at points; a text of another grammar has none."""

    def __init__(self, texts: StatementTexts, domains: Domains) -> None:
        self._domains = domains
        parts = [tuple(map(str.strip, p.split("=", 1))) for p in texts.parameters if ":" not in p]
        definitions = tuple((name, text) for name, text in parts)
        try:
            self._judge: Judge | None = Judge(
                TextStatement(
                    "typed",
                    Truth.TRUE,
                    texts.equations,
                    texts.solutions,
                    tuple(Letter(name) for name in texts.variables),
                    definitions,
                    derived=tuple(name for name in texts.variables if name != SITE),
                )
            )
        except (ValueError, KeyError, IndexError):
            self._judge = None
            return
        trees = [*self._judge.equations, *self._judge.solutions.values()]
        trees += self._judge.definitions.values()
        names = {*texts.variables, *(name for tree in trees for name in tree.names())}
        self._names = names - {name for name, _ in definitions} - {*CONSTANTS}

    def fails_at(self, point: TextPoint, bits: Sequence[int] = BITS) -> bool | None:
        """Whether an equation fails at a point; None where that cannot be said."""
        if self._judge is None or not self._names <= point.keys():
            return None
        try:
            return self._judge.fails_at(point, bits)
        except (Unsaid, LookupError, ValueError, RuntimeError, OverflowError):
            return None

    def failure(self) -> TextPoint | None:
        """A point of the domain at which an equation fails; None if none was found."""
        return next((point for point in self._points() if self.fails_at(point, QUICK)), None)

    def _points(self) -> Iterator[TextPoint]:
        known = {str(symbol): symbol for symbol in self._domains}
        added = {sp.Symbol(name, real=True): Domain() for name in self._names - known.keys()}
        integers = [s for s in self._domains if self._domains[s].integer]
        for drawn in sample({**self._domains, **added}, POINTS):
            yield {str(symbol): Fraction(int(v.p), int(v.q)) for symbol, v in drawn.items()}
            if not integers:
                continue
            for values in islice(product(*map(self._first, integers)), MOST):
                whole = {**drawn, **dict(zip(integers, values, strict=True))}
                if all(d.contains(whole[s], whole) for s, d in self._domains.items()):
                    yield {str(s): Fraction(int(v.p), int(v.q)) for s, v in whole.items()}

    def _first(self, symbol: sp.Symbol) -> list[sp.Integer]:
        domain = self._domains[symbol]
        if domain.lower.is_Rational:
            return [sp.floor(domain.lower) + step for step in range(FIRST + 1)]
        if domain.upper.is_Rational:
            return [sp.ceiling(domain.upper) - step for step in range(FIRST + 1)]
        return [sp.Integer(step) for step in range(-FIRST // 2, FIRST // 2 + 1)]

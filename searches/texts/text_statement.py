"""A statement in text with the ranges of its letters, and what is known of it."""

from __future__ import annotations

import enum
import random
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, floor

TextPoint = Mapping[str, Fraction]

VARIABLES = "nxyzt"

SPAN = 3
"""How far beyond the end of a half line, and beyond 0 on the whole line, numbers are drawn."""

LARGEST_DENOMINATOR = 60


class Truth(enum.StrEnum):
    """Truth of a statement.  VOID: the formula is defined nowhere, so that nothing can be said."""

    TRUE = "true"
    FALSE = "false"
    VOID = "void"


@dataclass(frozen=True)
class Letter:
    """A variable or parameter, and the open interval of its values; None for no end.

    ``under`` is a parameter that it stays below, which is stated before.

    >>> Letter("k", Fraction(0)).text, Letter("n", integer=True).text
    ('k>0', 'integer')
    >>> Letter("a", Fraction(0), under="b").text
    '0<a<b'
    """

    name: str
    low: Fraction | None = None
    high: Fraction | None = None
    integer: bool = False
    under: str = ""

    @property
    def text(self) -> str:
        """The range in the grammar."""
        if self.under:
            return f"{self.low}<{self.name}<{self.under}"
        if self.low is None and self.high is None:
            return "integer" if self.integer else "real"
        if self.high is None:
            return f"{self.name}>{self.low}"
        if self.low is None:
            return f"{self.name}<{self.high}"
        return f"{self.low}<{self.name}<{self.high}"

    def number(self, draw: random.Random) -> Fraction:
        """A random rational number in the range, other than 0."""
        zero = Fraction(0)
        low = self.low if self.low is not None else min(self.high or zero, zero) - SPAN
        high = self.high if self.high is not None else max(self.low or zero, zero) + SPAN
        if self.integer:
            return Fraction(draw.randint(floor(low) + 1, ceil(high) - 1))
        denominator = draw.randint(7, LARGEST_DENOMINATOR)
        found = low + (high - low) * Fraction(draw.randint(1, denominator - 1), denominator)
        return found if found else self.number(draw)

    def holds(self, value: Fraction) -> bool:
        """Whether ``value`` lies between the ends that are numbers."""
        above = self.low is None or value > self.low
        below = self.high is None or value < self.high
        return above and below and (value.denominator == 1 or not self.integer)


@dataclass(frozen=True)
class TextStatement:
    """Equations and solutions in text; ``letters`` has every variable and parameter.

    ``definitions`` are parameters that stand for formulas.  ``counterexample`` is a point of the
    ranges at which one of the equations of a false statement has a residual.
    """

    kind: str
    truth: Truth
    equations: tuple[str, ...]
    solutions: tuple[str, ...]
    letters: tuple[Letter, ...]
    definitions: tuple[tuple[str, str], ...] = ()
    counterexample: TextPoint | None = None
    seed: int = 0
    index: int = 0

    @property
    def parameters(self) -> str:
        """The part ``parameters`` of the statement."""
        stated = [f"{own.name}: {own.text}" for own in self.letters if own.name not in VARIABLES]
        return "; ".join([*stated, *(f"{name} = {text}" for name, text in self.definitions)])

    @property
    def domain(self) -> str:
        """The part ``domain`` of the statement."""
        own = [letter for letter in self.letters if letter.name in VARIABLES]
        return "; ".join(made.text for made in own if made.low is not None or made.high is not None)

    def point(self, draw: random.Random) -> TextPoint:
        """A random admissible point."""
        found: dict[str, Fraction] = {}
        for letter in self.letters:
            own = replace(letter, high=found[letter.under]) if letter.under else letter
            found[letter.name] = own.number(draw)
        return found

    def holds_at(self, point: TextPoint) -> bool:
        """Whether the point lies in all ranges."""
        return all(
            letter.holds(point[letter.name])
            and (not letter.under or point[letter.name] < point[letter.under])
            for letter in self.letters
        )

    def script(self) -> str:
        """Python source that asks the prover about the statement."""
        return "\n".join(
            [
                f"# {self.kind}, {self.truth}: {self.seed}, {self.index}",
                "import longwave",
                f"print(longwave.prove({list(self.equations)!r}, {list(self.solutions)!r},",
                f"    parameters={self.parameters!r}, domain={self.domain!r}))",
            ]
        )

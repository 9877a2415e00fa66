"""The independent variables of a statement in text: those named, or of x, y, z, t and n."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from longwave.derive.algebra.formula_text import CONSTANTS, FormulaError, Token, tokens

from .text_domains import TextPart
from .text_names import CONTINUOUS, FUNCTIONS, SITE

MOST_VARIABLES = 8
"""VariableNames that a certificate may have."""


def variable_names(text: str) -> tuple[str, ...]:
    """The names in ``r, t``; raises FormulaError for what is no name of a variable.

    >>> variable_names("r, t")
    ('r', 't')
    """
    found: list[str] = []
    for place, word in enumerate(words := tokens(text, "variables")[:-1]):
        if place % 2:
            if word.text not in (",", ";"):
                raise FormulaError("variables", f"expected ',', got {word}", text, word.start)
            continue
        name = word.text
        if word.kind != "name" or len(name) > 1 or name in CONSTANTS or name in found:
            wanted = f"expected a letter of its own for a variable, as in r, t, got {word}"
            raise FormulaError("variables", wanted, text, word.start)
        found.append(name)
    if len(words) != max(0, 2 * len(found) - 1) or len(found) > MOST_VARIABLES:
        said = f"expected at most {MOST_VARIABLES} letters with commas between, as in r, t"
        raise FormulaError("variables", said, text, 0)
    return tuple(found)


class VariableNames:
    """Which names are variables in the texts ``parts``.

    Without any in ``named`` they are those of x, y, z, t and n that occur; n is the site of a
    lattice, also where others are named.
    """

    def __init__(self, named: Sequence[str], parts: Iterable[TextPart]) -> None:
        self.continuous = tuple(name for name in named if name != SITE) or tuple(CONTINUOUS)
        self._named, self._parts = tuple(named), tuple(parts)
        self.reserved = (*self.continuous, SITE)

    def words(self) -> Iterator[tuple[TextPart, int, Token]]:
        """The words of all parts, with their places."""
        for part in self._parts:
            for place, word in enumerate(part.words):
                yield part, place, word

    def is_derivative(self, word: Token, names: Iterable[str]) -> bool:
        """Whether a word is an unknown with subscripts, not one of the declared ``names``."""
        base, _, steps = word.text.partition("_")
        return bool(
            word.kind == "name"
            and steps
            and set(steps) <= {*self.continuous}
            and base not in names
            and word.text not in FUNCTIONS
        )

    def letters(self, names: Iterable[str]) -> list[str]:
        """The variables, the site first: those that are named, else those that occur, else x."""
        found: set[str] = set(self._named)
        for _, _, word in self.words():
            if word.kind == "name" and word.text in self.reserved:
                found.add(word.text)
            elif self.is_derivative(word, names):
                found |= set(word.text.partition("_")[2])
        letters = [letter for letter in (SITE, *self.continuous) if letter in found]
        return letters or [CONTINUOUS[0]]

    def indexed(self) -> set[str]:
        """The names with a site behind them."""
        return {
            word.text.partition("_")[0]
            for part, place, word in self.words()
            if word.kind == "name" and part.words[place + 1].text == "["
        }

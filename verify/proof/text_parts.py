"""Split a statement's text into parts; find their variables and parse the domains they state.

Variables are the named ones, or x, y, z, t and n.  Domains look like ``0<k<1``, ``integer, j>0``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import and_

import sympy as sp

from longwave.derive.algebra import formula_text
from longwave.derive.algebra.formula_expression import ExpressionBuilder
from longwave.derive.algebra.formula_text import FormulaError

from .domains import REAL, Domain
from .text_names import CONTINUOUS, FUNCTIONS, SITE

WORDS = {
    "real": REAL,
    "integer": Domain(integer=True),
    "positive": Domain(lower=sp.S.Zero),
    "negative": Domain(upper=sp.S.Zero),
    "nonzero": Domain(nonzero=True),
}
"""Domains by their word; ``complex`` is not a domain and must be the only word."""

RESERVED = (*WORDS, "complex", "function")
"""Words for domains and kinds, which cannot be names."""

MOST_VARIABLES = 8
"""Most variables of a certificate."""


@dataclass(frozen=True)
class TextPart:
    """Part of a text between separators, as its tokens and a last token of kind ``end``."""

    label: str
    text: str
    words: list[formula_text.Token]

    @property
    def written(self) -> str:
        """The part as typed."""
        return self.text[self.words[0].start : self.words[-1].start].strip()

    def parser(self, vocabulary: formula_text.Vocabulary, skipped: int = 0) -> formula_text.Parser:
        """Return a parser of the words after the first ``skipped``."""
        return formula_text.Parser(self.text, self.words[skipped:], vocabulary, self.label)

    def error(self, words: str, place: int = 0) -> FormulaError:
        """Return the error at word number ``place``."""
        return FormulaError(self.label, words, self.text, self.words[place].start)

    def index(self, *signs: str) -> int | None:
        """Return the position of the first word among ``signs``, or None."""
        positions = (i for i, w in enumerate(self.words) if w.kind == "sign" and w.text in signs)
        return next(positions, None)


def text_parts(text: str, label: str, *separators: str) -> Iterator[TextPart]:
    """Yield the parts of a text; without separators it is split at ``;;`` and no part may be empty.

    >>> [part.text[part.words[0].start :] for part in text_parts("u_t ;; v_t", "equation")]
    ['u_t ;; v_t', 'v_t']
    """
    words = formula_text.tokens(text, label)
    cuts = separators or (";;",)
    start = 0
    for place, word in enumerate(words):
        if word.kind != "end" and not (word.kind == "sign" and word.text in cuts):
            continue
        if place > start:
            end = formula_text.Token("end", "", word.start)
            yield TextPart(label, text, [*words[start:place], end])
        elif not separators:
            got = "the end" if word.kind == "end" else str(word)
            raise FormulaError(label, f"expected a formula, got {got}", text, word.start)
        start = place + 1


def condition(part: TextPart, parser: formula_text.Parser, name: str) -> Domain:
    """Parse the next condition on ``name``, a word or inequalities; FormulaError otherwise."""
    own = parser.vocabulary.names[name]
    start = part.words.index(parser.next)
    if parser.next.text in WORDS:
        return WORDS[parser.take().text]
    build = ExpressionBuilder.after(parser).expression
    sides, signs = [build(parser.formula())], []
    while sign := parser.take_sign("<", "<=", ">", ">=", "!="):
        signs.append(sign.text)
        sides.append(build(parser.formula()))
    if any(side.is_extended_real is False for side in sides):
        raise part.error("expected real bounds, got a complex one", start)
    if not signs:
        known = ", ".join(WORDS)
        words = f"expected an inequality such as {name}>0, or one of {known}, got"
        raise part.error(f"{words} {part.words[start]}", start)
    expected = f"expected inequalities of {name}, as in 0<{name}<1"
    if sides.count(own) != 1 or any(s != own and s.has(own) for s in sides):
        pairs = zip(sides, signs, sides[1:], strict=False)
        domains = [_linear(left - right, sign, own) for left, sign, right in pairs]
        if None in domains:
            remedy = f"or sums with a multiple of {name} by a number, as in {name} + c > 0"
            raise part.error(f"{expected}, {remedy}", start)
        return reduce(and_, (domain for domain in domains if domain))
    if "!=" in signs:
        if signs != ["!="] or sp.S.Zero not in sides:
            raise part.error(f"expected {name}!=0 alone", start)
        return WORDS["nonzero"]
    if len({sign[0] for sign in signs}) > 1 or len(sides) > 3:
        raise part.error(f"{expected}, got signs both ways", start)
    place = sides.index(own)
    if len(sides) == 3 and place != 1:
        raise part.error(expected, start)
    return _between(sides, signs, place)


def inhabited(part: TextPart, domain: Domain, name: str, place: int = 0) -> Domain:
    """Return ``domain``; raises FormulaError if its numeric bounds leave no inner point."""
    if domain.lower.is_number and domain.upper.is_number and not domain.lower < domain.upper:
        words = f"expected a domain with inner points, got {domain.text(sp.Symbol(name))}"
        raise part.error(words, place)
    return domain


def symbol_of(name: str, domain: Domain) -> sp.Symbol:
    """Return a real symbol with the sign of its domain; a site has no sign, since it is shifted."""
    if name == SITE:
        return sp.Symbol(name, integer=True)
    known: dict[str, bool] = {"integer": True} if domain.integer else {"real": True}
    if domain.lower.is_nonnegative:
        positive = domain.lower_open or domain.lower.is_positive
        known["positive" if positive else "nonnegative"] = True
    elif domain.upper.is_nonpositive:
        negative = domain.upper_open or domain.upper.is_negative
        known["negative" if negative else "nonpositive"] = True
    if domain.nonzero:
        known["nonzero"] = True
    return sp.Symbol(name, **known)


def _linear(gap: sp.Expr, sign: str, own: sp.Symbol) -> Domain | None:
    """Return the domain of ``own`` where ``gap`` ``sign`` 0; None if ``gap`` is not linear."""
    slope = sp.expand(gap).coeff(own, 1)
    end = sp.expand(gap) - slope * own
    if not slope.is_Rational or slope == 0 or end.has(own) or sign == "!=":
        return None
    above, is_open = (sign[0] == ">") == (slope > 0), "=" not in sign
    end = sp.expand(-end / slope)
    return Domain(lower=end, lower_open=is_open) if above else Domain(upper=end, upper_open=is_open)


def _between(sides: Sequence[sp.Expr], signs: Sequence[str], place: int) -> Domain:
    """Return the domain of side number ``place`` in a chain of inequalities."""
    if signs[0][0] == ">":
        sides, signs, place = sides[::-1], signs[::-1], len(signs) - place
    lower, upper, lower_open, upper_open = -sp.oo, sp.oo, True, True
    if place > 0:
        lower, lower_open = sides[place - 1], "=" not in signs[place - 1]
    if place < len(signs):
        upper, upper_open = sides[place + 1], "=" not in signs[place]
    return Domain(lower, upper, lower_open, upper_open)


def variable_names(text: str) -> tuple[str, ...]:
    """Return the names in ``r, t``; raises FormulaError for anything but names of variables.

    >>> variable_names("r, t")
    ('r', 't')
    """
    names: list[str] = []
    for place, word in enumerate(words := formula_text.tokens(text, "variables")[:-1]):
        if place % 2:
            if word.text not in (",", ";"):
                raise FormulaError("variables", f"expected ',', got {word}", text, word.start)
            continue
        name = word.text
        if word.kind != "name" or len(name) > 1 or name in formula_text.CONSTANTS or name in names:
            words_expected = f"expected a letter of its own for a variable, as in r, t, got {word}"
            raise FormulaError("variables", words_expected, text, word.start)
        names.append(name)
    if len(words) != max(0, 2 * len(names) - 1) or len(names) > MOST_VARIABLES:
        limit = f"expected at most {MOST_VARIABLES} letters with commas between, as in r, t"
        raise FormulaError("variables", limit, text, 0)
    return tuple(names)


class VariableNames:
    """Names of the variables in texts: those ``named``, else those of x, y, z, t, n that occur."""

    def __init__(self, named: Sequence[str], parts: Iterable[TextPart]) -> None:
        self.continuous = tuple(name for name in named if name != SITE) or tuple(CONTINUOUS)
        self._named, self._parts = tuple(named), tuple(parts)
        self.reserved = (*self.continuous, SITE)

    def words(self) -> Iterator[tuple[TextPart, int, formula_text.Token]]:
        """Yield the words of all parts, with their positions."""
        for part in self._parts:
            for place, word in enumerate(part.words):
                yield part, place, word

    def is_derivative(self, word: formula_text.Token, names: Iterable[str]) -> bool:
        """Return whether a word is an unknown with subscripts and not a declared name."""
        base, _, steps = word.text.partition("_")
        is_new = word.kind == "name" and base not in names and word.text not in FUNCTIONS
        return is_new and bool(steps) and set(steps) <= {*self.continuous}

    def letters(self, names: Iterable[str]) -> list[str]:
        """Return the variables, the site first: those named or occurring, else x."""
        occurring: set[str] = set(self._named)
        for _, _, word in self.words():
            if word.kind == "name" and word.text in self.reserved:
                occurring.add(word.text)
            elif self.is_derivative(word, names):
                occurring |= set(word.text.partition("_")[2])
        letters = [letter for letter in (SITE, *self.continuous) if letter in occurring]
        return letters or [CONTINUOUS[0]]

    def indexed(self) -> set[str]:
        """Return the names that are followed by a site, as in u[n]."""
        names = ((part, place, word) for part, place, word in self.words() if word.kind == "name")
        indexed = (word for part, place, word in names if part.words[place + 1].text == "[")
        return {word.text.partition("_")[0] for word in indexed}

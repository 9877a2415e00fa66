"""Terms and steps: what the checker did, as data that every engine's script is written from."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from textwrap import wrap
from typing import Any

from flint import fmpq, fmpq_mpoly

Term = tuple[Any, ...]
"""``("number", q)``, ``("generator", i)``, ``("node", k)``, ``("jet", k)``, ``("sum", ...)``,
``("product", ...)``, ``("minus", a)``, ``("inverse", a)``, ``("power", a, n)`` with n > 0, or
``("slope", v, a)``, the derivative of a along the variable of that place; in premises also
``("free", k)``."""

Powers = tuple[int, ...] | None
"""Exponents of the denominators that a value is written over, where they are known; the last are
not 0."""


@dataclass(frozen=True)
class Definition:
    """``name``, a node or jet, is ``term``; ``below`` are the denominators of its value."""

    name: Term
    term: Term
    below: Powers
    comment: str


@dataclass(frozen=True)
class Relation:
    """``generator ** degree`` is ``term``."""

    generator: int
    degree: int
    term: Term
    below: Powers


@dataclass(frozen=True)
class SlopeAxiom:
    """The derivative of a generator along a variable is ``term``."""

    variable: int
    generator: int
    term: Term
    below: Powers


@dataclass(frozen=True)
class Rate:
    """The derivative of a name along a variable is ``term``: checked, and used as written."""

    variable: int
    name: Term
    term: Term
    below: Powers


@dataclass(frozen=True)
class Vanishing:
    """``term`` is 0."""

    term: Term
    comment: str


Step = Definition | Relation | SlopeAxiom | Rate | Vanishing


@dataclass(frozen=True)
class Premise:
    """What the proof needs and no script shows: a ``relation`` of ``terms``, in words, for what.

    A denominator, a polynomial in the generators, is one that is ``not_zero``.
    """

    relation: str
    terms: tuple[Term, ...]
    words: str
    comment: str


@dataclass(frozen=True)
class WrittenProof:
    """All that a script is written from.

    ``meanings`` are what the generators stand for, ``variables`` the names of the variables that
    something is differentiated by, ``free`` elements that are in premises alone.  ``guards`` are
    the places of the premises that a definition rests on.
    """

    title: str
    statement: str
    meanings: Sequence[str]
    variables: Sequence[str]
    free: Mapping[int, str]
    premises: Sequence[Premise]
    guards: Mapping[Term, Sequence[int]]
    steps: Sequence[Step]

    @property
    def conditions(self) -> list[str]:
        """The premises in words, each once."""
        return list(dict.fromkeys(premise.words for premise in self.premises))

    @property
    def denominators(self) -> list[Term]:
        """What must not be 0."""
        return [premise.terms[0] for premise in self.premises if premise.relation == "not_zero"]


def number(value: fmpq | int) -> Term:
    """A rational number as a term."""
    return ("number", fmpq(value))


NAMES = ("generator", "node", "jet", "free")
"""Kinds of terms that are names."""

LETTERS = {"node": "n", "jet": "u", "free": "free"}


def name_of(term: Term) -> str:
    """A node as n12, a jet as u3."""
    return f"{LETTERS[term[0]]}{term[1]}"


def is_number(term: Term, value: int) -> bool:
    """Whether a term is that number."""
    return term[0] == "number" and term[1] == value


def added(parts: Sequence[Term]) -> Term:
    """The sum, without zeros; flat."""
    flat: list[Term] = []
    for part in parts:
        flat += part[1:] if part[0] == "sum" else [part]
    kept = [part for part in flat if not is_number(part, 0)]
    return kept[0] if len(kept) == 1 else ("sum", *kept) if kept else number(0)


def multiplied(parts: Sequence[Term]) -> Term:
    """The product, without ones; flat."""
    flat: list[Term] = []
    for part in parts:
        flat += part[1:] if part[0] == "product" else [part]
    kept = [part for part in flat if not is_number(part, 1)]
    if any(is_number(part, 0) for part in kept):
        return number(0)
    return kept[0] if len(kept) == 1 else ("product", *kept) if kept else number(1)


def negated(part: Term) -> Term:
    """Minus a term."""
    if part[0] == "number":
        return number(-part[1])
    return part[1] if part[0] == "minus" else ("minus", part)


def inverted(part: Term) -> Term:
    """One over a term."""
    if part[0] == "number":
        return number(1 / part[1])
    return part[1] if part[0] == "inverse" else ("inverse", part)


def raised(part: Term, exponent: int) -> Term:
    """A power with an exponent of 0 or more."""
    if exponent == 0 or is_number(part, 1):
        return number(1)
    return part if exponent == 1 else ("power", part, exponent)


def polynomial_term(polynomial: fmpq_mpoly) -> Term:
    """A polynomial of the checker's ring, its generators last first."""
    parts = []
    for exponents, coefficient in polynomial.terms():
        powers = (
            raised(("generator", place), int(n)) for place, n in enumerate(reversed(exponents)) if n
        )
        parts.append(multiplied([number(coefficient), *powers]))
    return added(parts)


def inner_terms(term: Term) -> Iterator[Term]:
    """A term and all that it is made of."""
    yield term
    if term[0] in ("number", *NAMES):
        return
    for part in term[1:]:
        if isinstance(part, tuple):
            yield from inner_terms(part)


def spelled(term: Term, language: Mapping[str, Callable[..., str]]) -> str:
    """A term in a language: how it writes each kind of term, from the texts of its parts."""
    parts = (spelled(part, language) if isinstance(part, tuple) else part for part in term[1:])
    return language[term[0]](*parts)


def engine_text(name: str) -> str:
    """The part that all scripts of a system have in common."""
    return (files(__package__) / "engines" / name).read_text("utf-8").rstrip("\n")


PLAIN = re.compile(r"[^A-Za-z0-9_ .,;:=<>+*/^()\[\]-]")
"""What a comment does not hold: nothing ends it, begins another, or continues a line."""

WIDTH = 100


def plain(text: str) -> list[str]:
    """A text as lines for a comment: other characters are named by their code, * stands apart."""
    shown = PLAIN.sub(lambda found: f"<{ord(found[0]):x}>", text)
    return wrap(shown.replace("*", " * "), WIDTH)


def plain_lines(proof: WrittenProof) -> list[str]:
    """What a script says of itself."""
    lines = [f"longwave: {proof.title}", *proof.statement.splitlines()]
    lines += ["Generators and what they stand for:"]
    lines += [f"g{place}: {text}" for place, text in enumerate(proof.meanings)]
    lines += ["Derivatives are along " + ", ".join(proof.variables)]
    lines += ["Names and what they stand for:"]
    lines += [
        f"{name_of(step.name)}: {step.comment}"
        for step in proof.steps
        if isinstance(step, Definition) and step.comment
    ]
    lines += [f"{name_of(('free', place))}: {text}" for place, text in proof.free.items()]
    lines += ["Accepted means proved if", *map(premise_line, proof.premises)]
    return [short for line in lines for short in plain(line)]


def premise_line(premise: Premise) -> str:
    """A premise in words, with what it is for."""
    return f"{premise.words} ({premise.comment})"


FEW = 3
"""Premises that are told where there is no room for all."""


def premises_in_short(words: Sequence[str]) -> str:
    """The first premises, and how many more there are."""
    more = [f"{len(words) - FEW} more"] if len(words) > FEW else []
    return "; ".join([*words[:FEW], *more])


def premise_lines(proof: WrittenProof) -> list[str]:
    """What a script prints of its premises, in letters that no string ends at."""
    return [
        f"{'...' if place else 'if'} {line}"
        for premise in proof.premises
        for place, line in enumerate(plain(premise_line(premise)))
    ]

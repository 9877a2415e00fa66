"""Terms and steps of a proof: the data from which the scripts of all systems are written."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from textwrap import wrap
from typing import Any

from flint import fmpq, fmpq_mpoly

from longwave.verify.kernel.nodes import Node

Term = tuple[Any, ...]
"""``("number", q)``, ``("generator", i)``, ``("node", k)``, ``("jet", k)``, ``("sum", ...)``,
``("product", ...)``, ``("minus", a)``, ``("inverse", a)``, ``("power", a, n)`` with n > 0, or
``("slope", v, a)``, the derivative of a along variable number v.  Premises also have
``("free", k)``."""

Powers = tuple[int, ...] | None
"""Exponents of the denominators of a value, without trailing zeros; None if unknown."""


@dataclass(frozen=True)
class Definition:
    """Definition of ``name``, a node or jet, as ``term``; ``below`` has its denominators."""

    name: Term
    term: Term
    below: Powers
    comment: str


@dataclass(frozen=True)
class Relation:
    """Axiom ``generator ** degree = term``."""

    generator: int
    degree: int
    term: Term
    below: Powers


@dataclass(frozen=True)
class SlopeAxiom:
    """Axiom that the derivative of a generator along a variable is ``term``."""

    variable: int
    generator: int
    term: Term
    below: Powers


@dataclass(frozen=True)
class Rate:
    """Claim that the derivative of ``name`` along a variable is ``term``, checked by the script."""

    variable: int
    name: Term
    term: Term
    below: Powers


@dataclass(frozen=True)
class Vanishing:
    """Claim that ``term`` is 0."""

    term: Term
    comment: str


Step = Definition | Relation | SlopeAxiom | Rate | Vanishing


@dataclass(frozen=True)
class Premise:
    """Condition that a script assumes; the relation ``not_zero`` is used for denominators only."""

    relation: str
    terms: tuple[Term, ...]
    words: str
    comment: str


@dataclass(frozen=True)
class WrittenProof:
    """Data from which a script is written.

    ``meanings`` explains the generators, ``variables`` names the variables of derivatives, ``free``
    has the elements that occur only in premises, and ``guards`` maps definitions to the indices
    of their premises.
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
        """Premises in words, without repeats."""
        return list(dict.fromkeys(premise.words for premise in self.premises))

    @property
    def denominators(self) -> list[Term]:
        """Denominators, which must be nonzero."""
        return [premise.terms[0] for premise in self.premises if premise.relation == "not_zero"]


def number(value: fmpq | int) -> Term:
    """Return a rational number as a term."""
    return ("number", fmpq(value))


NAMES = ("generator", "node", "jet", "free")
"""Kinds of terms that refer to an element by its index."""

LETTERS = {"node": "n", "jet": "u", "free": "free"}


def name_of(term: Term) -> str:
    """Return the name of a node (n12) or a jet (u3)."""
    return f"{LETTERS[term[0]]}{term[1]}"


def is_number(term: Term, value: int) -> bool:
    """Return whether a term is the number ``value``."""
    return term[0] == "number" and term[1] == value


def _flat(parts: Sequence[Term], kind: str) -> list[Term]:
    return [inner for part in parts for inner in (part[1:] if part[0] == kind else (part,))]


def added(parts: Sequence[Term]) -> Term:
    """Return the flattened sum, without zeros."""
    nonzero = [part for part in _flat(parts, "sum") if not is_number(part, 0)]
    return nonzero[0] if len(nonzero) == 1 else ("sum", *nonzero) if nonzero else number(0)


def multiplied(parts: Sequence[Term]) -> Term:
    """Return the flattened product, without ones."""
    factors = [part for part in _flat(parts, "product") if not is_number(part, 1)]
    if any(is_number(part, 0) for part in factors):
        return number(0)
    return factors[0] if len(factors) == 1 else ("product", *factors) if factors else number(1)


def negated(part: Term) -> Term:
    """Return minus a term."""
    if part[0] == "number":
        return number(-part[1])
    return part[1] if part[0] == "minus" else ("minus", part)


def inverted(part: Term) -> Term:
    """Return one over a term."""
    if part[0] == "number":
        return number(1 / part[1])
    return part[1] if part[0] == "inverse" else ("inverse", part)


def raised(part: Term, exponent: int) -> Term:
    """Return a power with a nonnegative exponent."""
    if exponent == 0 or is_number(part, 1):
        return number(1)
    return part if exponent == 1 else ("power", part, exponent)


def polynomial_term(polynomial: fmpq_mpoly) -> Term:
    """Return the term of a polynomial of the checker's ring, whose generators are last first."""
    parts = []
    for exponents, coefficient in polynomial.terms():
        pairs = ((place, int(n)) for place, n in enumerate(reversed(exponents)) if n)
        powers = (raised(("generator", place), n) for place, n in pairs)
        parts.append(multiplied([number(coefficient), *powers]))
    return added(parts)


def composed(node: Node, inner: Callable[[int], Term]) -> Term | None:
    """Return the term of a number, sum, product or power of nodes with known terms, else None."""
    match node:
        case ("number", value):
            return number(value)
        case (("Add" | "Mul") as name, *parts):
            return (added if name == "Add" else multiplied)([inner(part) for part in parts])
        case ("Pow", base, exponent) if exponent.q == 1 and exponent > 0:
            return raised(inner(base), int(exponent.p))
    return None


def inner_terms(term: Term) -> Iterator[Term]:
    """Yield a term and all its subterms."""
    yield term
    if term[0] in ("number", *NAMES):
        return
    for part in term[1:]:
        if isinstance(part, tuple):
            yield from inner_terms(part)


def spelled(term: Term, language: Mapping[str, Callable[..., str]]) -> str:
    """Write a term; ``language`` formats each kind of term from the texts of its parts."""
    parts = (spelled(part, language) if isinstance(part, tuple) else part for part in term[1:])
    return language[term[0]](*parts)


def engine_text(name: str) -> str:
    """Return the part that all scripts of a system share."""
    return (files(__package__) / "engines" / name).read_text("utf-8").rstrip("\n")


UNSAFE_CHARACTERS = re.compile(r"[^A-Za-z0-9_ .,;:=<>+*/^()\[\]-]")
"""Characters removed from comments, so that none ends, begins or continues a comment."""

COMMENT_WIDTH = 100


def plain(text: str) -> list[str]:
    """Return a text as comment lines: unsafe characters by their code, spaces around ``*``."""
    safe = UNSAFE_CHARACTERS.sub(lambda match: f"<{ord(match[0]):x}>", text)
    return wrap(safe.replace("*", " * "), COMMENT_WIDTH)


def plain_lines(proof: WrittenProof) -> list[str]:
    """Return the comment lines that describe a script's statement, names and premises."""
    lines = [f"longwave: {proof.title}", *proof.statement.splitlines()]
    lines += ["Generators and what they stand for:"]
    lines += [f"g{place}: {text}" for place, text in enumerate(proof.meanings)]
    lines += ["Derivatives are along " + ", ".join(proof.variables)]
    lines += ["Names and what they stand for:"]
    named = [step for step in proof.steps if isinstance(step, Definition) and step.comment]
    lines += [f"{name_of(step.name)}: {step.comment}" for step in named]
    lines += [f"{name_of(('free', place))}: {text}" for place, text in proof.free.items()]
    lines += ["Accepted means proved if", *map(premise_line, proof.premises)]
    return [short for line in lines for short in plain(line)]


def premise_line(premise: Premise) -> str:
    """Return a premise in words, with its purpose."""
    return f"{premise.words} ({premise.comment})"


SUMMARY_PREMISES = 3
"""Number of premises listed in a short summary."""


def premises_in_short(words: Sequence[str]) -> str:
    """Return the first premises, and the number of further ones."""
    more = [f"{len(words) - SUMMARY_PREMISES} more"] if len(words) > SUMMARY_PREMISES else []
    return "; ".join([*words[:SUMMARY_PREMISES], *more])


def premise_lines(proof: WrittenProof) -> list[str]:
    """Return the lines with which a script prints its premises, safe within a string."""
    return [
        f"{'...' if place else 'if'} {line}"
        for premise in proof.premises
        for place, line in enumerate(plain(premise_line(premise)))
    ]

"""Scope of a statement: the values for which it is made, as the checker reads the typed texts."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from longwave.verify.kernel.nodes import KINDS, Nodes
from longwave.verify.kernel.statement import read_statement

from .certificate_writer import as_data
from .mistyped_statements import split_outside
from .typed_statement import Statement, StatementTexts

COMPARED = r"<=|>=|!=|<|>"

SIGNED = {"positive": "> 0", "negative": "< 0", "nonzero": "!= 0"}

SMOOTH = "wherever the formulas are smooth"


@dataclass(frozen=True)
class Scope:
    """Names of a statement by kind (real, integer, ...), and the typed conditions on them."""

    kinds: Mapping[str, Sequence[str]]
    conditions: tuple[str, ...]

    def listed(self, kinds: Sequence[str]) -> str:
        """Join entries such as "real m, x" into one text; functions are the last entry."""
        *values, last = kinds
        if "function" not in self.kinds:
            return "; ".join(kinds)
        functions = last.replace("function", "functions", 1)
        return f"{'; '.join(values)} and {functions} that are real at real arguments"

    @property
    def text(self) -> str:
        """The scope in words."""
        kinds = [f"{kind} {', '.join(names)}" for kind, names in self.kinds.items()]
        limits = f" with {', '.join(self.conditions)}" if self.conditions else ""
        return f"for all {self.listed(kinds)}{limits}, {SMOOTH}"


def scope(statement: Statement) -> Scope:
    """Return the scope of a statement's texts: all names in them, even if they cancel.

    >>> from longwave.verify.proof.statement_text import read_statement as read
    >>> scope(read("u - 1", "u = abs(m)/m + 0*x", "m: m>0")).text
    'for all real m, x with m > 0, wherever the formulas are smooth'
    """
    nodes = Nodes()
    read_statement(nodes, as_data(statement.texts))
    symbols = [node for node in nodes.all if node[0] == "symbol"]
    named = {kind: sorted(node[1] for node in symbols if node[2] == kind) for kind in KINDS}
    kinds = {kind: names for kind, names in named.items() if names}
    return Scope(kinds, tuple(c for c in conditions(statement.texts) if ":" not in c))


def conditions(texts: StatementTexts) -> list[str]:
    """Return the typed conditions, such as ``k > 0`` and ``b: complex``, without repeats."""
    return list(dict.fromkeys(_conditions(texts)))


def _conditions(texts: StatementTexts) -> Iterator[str]:
    for part in texts.parameters:
        name, sign, stated = (piece.strip() for piece in part.partition(":"))
        for condition in split_outside(stated, ",") if sign else ():
            yield _condition(name, condition)
    for part in texts.domain:
        for condition in split_outside(part, ","):
            yield _condition("", condition)


def _condition(name: str, text: str) -> str:
    """Return an inequality with spaces, also for "positive" and the like, or ``name: kind``."""
    word = text.strip()
    if word in KINDS:
        return f"{name}: {word}"
    word = f"{name} {SIGNED[word]}" if word in SIGNED else word
    return " ".join(re.sub(f"({COMPARED})", r" \1 ", word).split())

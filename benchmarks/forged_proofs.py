"""Certificates made by hand, with hints as texts: what an opponent of the kernel writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from verify.kernel.limits import FORMAT, digest

Data = dict[str, Any]
Pairs = Mapping[str, str]
Sums = Mapping[str, Mapping[str, str]]


class Proof:
    """The proof's part of a certificate, whose formulas are given as texts."""

    def __init__(self) -> None:
        self.formulas: list[str] = []

    def place(self, text: str) -> int:
        """The place of a formula among the hints."""
        if text not in self.formulas:
            self.formulas.append(text)
        return self.formulas.index(text)

    def pairs(self, hints: Pairs) -> list[list[int]]:
        """Hints that name another formula."""
        return [[self.place(left), self.place(right)] for left, right in hints.items()]

    def sums(self, hints: Sums) -> list[list[Any]]:
        """Hints that name a combination of formulas."""
        return [
            [self.place(z), [[number, self.place(u)] for u, number in terms.items()]]
            for z, terms in hints.items()
        ]

    def data(
        self,
        atoms: Sequence[str],
        point: Pairs,
        *,
        more: Sequence[Any] = (),
        parts: Sequence[Any] = (),
        values: Pairs | None = None,
        signs: Pairs | None = None,
        sums: Sums | None = None,
        logs: Sums | None = None,
    ) -> Data:
        """All of the proof but its formulas."""
        return {
            "generators": [*more, *(["atom", self.place(atom)] for atom in atoms)],
            "values": self.pairs(values or {}),
            "signs": self.pairs(signs or {}),
            "sums": self.sums(sums or {}),
            "logs": self.sums(logs or {}),
            "point": [[self.place(symbol), value] for symbol, value in point.items()],
            "parts": list(parts),
        }


def signed(statement: Mapping[str, Sequence[str]], proof: Proof, data: Data) -> Data:
    """The certificate of a statement with a proof, and its digest."""
    parts = {"variables": ["x"], "parameters": [], "domain": [], **statement}
    body: Data = {"format": FORMAT, "name": "attack", "statement": parts}
    body["proof"] = {"formulas": proof.formulas, **data}
    return body | {"digest": digest(body)}


def certificate(
    equation: str,
    solution: str,
    atoms: Sequence[str],
    point: Pairs,
    statement: Mapping[str, Sequence[str]] | None = None,
    **hints: Any,
) -> Data:
    """The certificate of one equation and one solution."""
    proof = Proof()
    stated = {"equations": [equation], "solutions": [solution], **(statement or {})}
    return signed(stated, proof, proof.data(atoms, point, **hints))

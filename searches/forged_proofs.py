"""Certificates made by hand, with hints as texts: what an opponent of the kernel writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from longwave.verify.kernel.limits import FORMAT, digest

Data = dict[str, Any]
Pairs = Mapping[str, str]
Sums = Mapping[str, Mapping[str, str]]


class Proof:
    """The proof's part of a certificate, whose formulas are given as texts."""

    def __init__(self) -> None:
        self.formulas: list[str] = []

    def place(self, text: str) -> int:
        """Return the place of a formula among the hints."""
        if text not in self.formulas:
            self.formulas.append(text)
        return self.formulas.index(text)

    def pairs(self, hints: Pairs) -> list[list[int]]:
        """Return hints that name another formula."""
        return [[self.place(left), self.place(right)] for left, right in hints.items()]

    def combination(self, terms: Pairs, wrapped: str = "{}") -> str:
        """Return a sum of multiples of formulas, each within another."""
        texts = [wrapped.format(f"#{self.place(u)}") for u in terms]
        products = [
            t if n == "1" else f"({n})*({t})" for t, n in zip(texts, terms.values(), strict=True)
        ]
        return " + ".join(products) or "0"

    def words(self, functions: Sums) -> Pairs:
        """Return functions of sums, such as ``exp(x)`` or ``jacobi_sn(x, 1/2)``."""
        found = {}
        for text, terms in functions.items():
            name, _, inner = text.partition("(")
            more = f",{inner[:-1].rpartition(',')[2]}" if name.startswith("jacobi") else ""
            found[text] = f"{name}({self.combination(terms)}{more})"
        return found

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
        """Return all of the proof but its formulas."""
        named = {**(values or {}), **self.words(sums or {})}
        named |= {
            log: self.combination(factors, "log({})") for log, factors in (logs or {}).items()
        }
        return {
            "generators": [*more, *(["atom", self.place(atom)] for atom in atoms)],
            "values": self.pairs(named),
            "signs": self.pairs(signs or {}),
            "point": [[self.place(symbol), value] for symbol, value in point.items()],
            "parts": list(parts),
        }


def signed(statement: Mapping[str, Sequence[str]], proof: Proof, data: Data) -> Data:
    """Return the certificate of a statement with a proof, and its digest."""
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
    """Return the certificate of one equation and one solution."""
    proof = Proof()
    stated = {"equations": [equation], "solutions": [solution], **(statement or {})}
    return signed(stated, proof, proof.data(atoms, point, **hints))

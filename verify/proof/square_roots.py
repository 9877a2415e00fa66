"""Square roots that depend on others, as hints: sqrt(6) = sqrt(2) sqrt(3).

The radicands' images are factored; a root whose square, times those of some others, is a square
is their product times a known element.  The checker verifies what is found here.
"""

from __future__ import annotations

from collections import Counter

import sympy as sp
from flint import fmpq, fmpq_mpoly

from .certificate_writer import Data, NodeTable
from .checker.check import registered
from .checker.field import Field
from .checker.limits import CertificateError
from .checker.nodes import Nodes
from .checker.ring import Element
from .checker.statement import read_statement

Key = tuple[str, int]
"""A prime or -1, or the place of a factor in the ring's list."""


class Radicals:
    """The square roots among the generators of a field, and what the dependent ones are."""

    def __init__(self, field: Field, table: NodeTable, places: dict[int, int]) -> None:
        self._field, self._table = field, table
        self._places = places
        self._rows: list[tuple[frozenset[Key], frozenset[int]]] = []
        self._images: dict[int, Element] = {}

    def value(self, root: int) -> int | None:
        """The place of what ``root``, a node of the field, is; None if it is independent."""
        base = self._field.nodes.all[root][1]
        image = self._field.image(base)
        odd = frozenset(key for key, power in self._exponents(image).items() if power % 2)
        members = frozenset[int]()
        for row, row_members in self._rows:
            if max(row) in odd:
                odd, members = odd ^ row, members ^ row_members
        if odd:
            self._rows.append((odd, members | {root}))
            self._images[root] = image
            return None
        quotient = image
        for member in members:
            quotient = quotient / self._images[member]
        parts = [self._places[member] for member in members]
        for key, power in self._exponents(quotient).items():
            parts.append(self._made_power(key, power // 2))
        return self._table.made("Mul", *(parts or [self._table.place(sp.S.One)]))

    def _exponents(self, element: Element) -> Counter[Key]:
        ring = element.ring
        unit, powers = ring.split(element.numerator)
        found: Counter[Key] = Counter({("factor", i): n for i, n in powers.items()})
        found.subtract({("factor", i): n for i, n in element.powers.items()})
        for number, sign in ((unit.p, 1), (unit.q, -1)):
            for prime, power in sp.factorint(int(number)).items():
                found["number", int(prime)] += sign * power
        return found

    def _made_power(self, key: Key, power: int) -> int:
        kind, value = key
        base = (
            self._written(self._field.ring.factors[value])
            if kind == "factor"
            else self._table.place(sp.Integer(value))
        )
        return self._table.made("Pow", base, str(power))

    def _written(self, polynomial: fmpq_mpoly) -> int:
        """A polynomial in the generators as a node in their meanings."""
        terms = []
        for exponents, coefficient in polynomial.terms():
            powers = [
                self._table.made("Pow", self._meaning(place), str(int(n)))
                for place, n in enumerate(reversed(exponents))
                if n
            ]
            terms.append(self._table.made("Mul", self._number(coefficient), *powers))
        return terms[0] if len(terms) == 1 else self._table.made("Add", *terms)

    def _number(self, value: fmpq) -> int:
        return self._table.made("number", str(value))

    def _meaning(self, place: int) -> int:
        generator = self._field.generators[place]
        if generator.form:
            raise CertificateError("a linear form under a root is not written out")
        node = self._places[generator.node]
        if generator.scale is not None:
            return self._table.made("Mul", node, self._written(generator.scale))
        if generator.below is not None:
            below = self._table.made("Pow", self._places[generator.below], "-1")
            return self._table.made("Mul", node, below)
        return node


def with_radicals(table: NodeTable, statement: Data, proof: Data) -> Data:
    """The proof with each square root that depends on earlier ones named, not a generator."""
    roots = {
        entry[1]
        for entry in proof["generators"]
        if entry[0] == "atom"
        and table.nodes[entry[1]][0] == "Pow"
        and table.nodes[entry[1]][2] == "1/2"
    }
    if not roots:
        return proof
    nodes = Nodes(table.nodes)
    field = registered(nodes, read_statement(nodes, statement), proof)
    radicals = Radicals(field, table, {node: place for place, node in enumerate(nodes.places)})
    dependent: dict[int, int] = {}
    for entry in proof["generators"]:
        if entry[0] == "atom" and entry[1] in roots:
            value = radicals.value(nodes.places[entry[1]])
            if value is not None and _is_not_negative(table, statement, proof, value):
                dependent[entry[1]] = value
    kept = [e for e in proof["generators"] if e[0] != "atom" or e[1] not in dependent]
    values = [*proof["values"], *([root, value] for root, value in dependent.items())]
    return {**proof, "generators": kept, "values": values}


def _is_not_negative(table: NodeTable, statement: Data, proof: Data, value: int) -> bool:
    nodes = Nodes(table.nodes)
    field = registered(nodes, read_statement(nodes, statement), proof)
    return field.signs.not_negative(nodes.places[value])

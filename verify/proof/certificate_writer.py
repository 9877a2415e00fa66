"""Write certificates: SymPy expressions as nodes, a proof's generators and hints.

A node is ``[name, ...]``: a number, a symbol, a constant, or a function with the indices of its
arguments, which come earlier in the table.  Equal subexpressions share one node.  Generators and
hints are indices in the table, called places.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import sympy as sp
from flint import fmpq_mpoly
from sympy.core.function import AppliedUndef

from longwave.solutions.functions.jet_functions import JetFunction
from longwave.verify.kernel.limits import FORMAT, digest

from .domains import Point
from .text_names import FUNCTIONS as GRAMMAR
from .text_writer import Node, numbered
from .typed_statement import StatementTexts

FUNCTIONS: dict[str, Any] = {
    **{name: function for name, (function, _) in GRAMMAR.items() if function is not sp.sqrt},
    "Abs": sp.Abs,
    "Add": sp.Add,
    "Mul": sp.Mul,
}
NAMES = {function: name for name, function in FUNCTIONS.items()}
"""The checker's names of SymPy's and longwave's functions."""

CONSTANTS = {sp.I: "I", sp.pi: "pi"}


class NodeTable:
    """Table of nodes for SymPy expressions; an equation may contain applied ``unknowns``.

    >>> table = NodeTable()
    >>> table.place(sp.Symbol("x") / 2)
    2
    >>> table.nodes
    [['number', '1/2'], ['symbol', 'x', 'real'], ['Mul', 0, 1]]
    """

    def __init__(self, unknowns: Sequence[AppliedUndef] = ()) -> None:
        self.unknowns = tuple(unknowns)
        self.nodes: list[Node] = []
        self._places: dict[sp.Expr, int] = {}
        self._known: dict[str, int] = {}

    def place(self, expression: sp.Expr) -> int:
        """Return the index of an expression's node; raises ValueError for an unknown function."""
        if expression not in self._places:
            self._places[expression] = self.add(*self._node(expression))
        return self._places[expression]

    def add(self, *node: Any) -> int:
        """Add a node, unless the table has it, and return its index."""
        key = str(node)
        if key not in self._known:
            self._known[key] = len(self.nodes)
            self.nodes.append(list(node))
        return self._known[key]

    def _node(self, expression: sp.Expr) -> Node:
        if expression.is_Rational:
            return ["number", str(expression)]
        if expression.is_Symbol:
            return ["symbol", expression.name, "integer" if expression.is_integer else "real"]
        if expression in CONSTANTS:
            return ["constant", CONSTANTS[expression]]
        if expression is sp.E:
            return ["exp", self.place(sp.S.One)]
        if expression.is_Pow:
            base, exponent = expression.args
            if exponent.is_Rational:
                return ["Pow", self.place(base), str(exponent)]
            is_parity = base is sp.S.NegativeOne and exponent.is_integer
            places = [self.place(exponent)] if is_parity else map(self.place, (base, exponent))
            return ["parity" if is_parity else "power", *places]
        if isinstance(expression, sp.Derivative):
            return ["diff", *map(self.place, (expression.expr, *expression.variables))]
        if isinstance(expression, AppliedUndef):
            return self._unknown(expression)
        label = expression.func.__name__
        name = label if isinstance(expression, JetFunction) else NAMES.get(expression.func)
        if name is None:
            where = "which was stated or is SymPy's form of a part (write it by other functions)"
            raise ValueError(f"no axiom is known for {label}, {where}")
        return [name, *map(self.place, expression.args)]

    def _unknown(self, unknown: AppliedUndef) -> Node:
        for place, own in enumerate(self.unknowns):
            if own.func == unknown.func:
                pairs = zip(unknown.args, own.args, strict=True)
                shifts = [moved - variable for moved, variable in pairs]
                if all(shift.is_Integer for shift in shifts):
                    return ["unknown", place, list(map(int, shifts))]
        raise ValueError(f"unknowns must be the statement's at shifted variables, got {unknown}")

    def jet(self, orders: Sequence[int], variables: Sequence[sp.Symbol]) -> int:
        """Return the index of the derivative of the first unknown with these orders."""
        own = self.add("unknown", 0, [0] * len(orders))
        pairs = zip(variables, orders, strict=True)
        along = [self.place(variable) for variable, order in pairs for _ in range(order)]
        return self.add("diff", own, *along) if along else own

    def polynomial(self, polynomial: fmpq_mpoly, places: Sequence[int]) -> int:
        """Return the index of a polynomial in the nodes at ``places``, in that order."""
        terms = [[str(c), [int(n) for n in exponents]] for exponents, c in polynomial.terms()]
        return self.add("poly", terms, *places)

    def combination(self, terms: Sequence[tuple[str, int]]) -> int:
        """Return the index of a sum of multiples of nodes, from pairs of number and node."""
        parts = [p if n == "1" else self.add("Mul", self.add("number", n), p) for n, p in terms]
        parts = parts or [self.add("number", "0")]
        return parts[0] if len(parts) == 1 else self.add("Add", *parts)


Data = dict[str, Any]


def as_data(statement: StatementTexts) -> Data:
    """Return a statement's texts as JSON data."""
    return {part: list(texts) for part, texts in asdict(statement).items()}


class Certificate(Data):
    """Proof as plain data with its digest; ``json.dumps`` writes it.

    >>> nothing = StatementTexts((), (), ())
    >>> Certificate.signed("nothing", NodeTable(), nothing, {"generators": [], "point": []})
    <Certificate of nothing: 0 generators, 283 bytes, digest 4a5b90ec>
    """

    @classmethod
    def signed(
        cls, name: str, table: NodeTable, statement: StatementTexts, proof: Data
    ) -> Certificate:
        """Return the certificate with its digest; the indices in ``proof`` refer to ``table``."""
        body: Data = {"format": FORMAT, "name": name, "statement": as_data(statement)}
        body["proof"] = {"formulas": numbered(table.nodes), **proof}
        return cls(body | {"digest": digest(body)})

    def changed(self, **parts: Data) -> Certificate:
        """Return a copy with another statement or proof and a new digest; it may be invalid."""
        body = {**self, **parts}
        return Certificate(body | {"digest": digest(body)})

    @property
    def generators(self) -> int:
        """Number of generators of the proof."""
        entries = self["proof"]["generators"]
        return sum(len(entry[2]) if entry[0] == "forms" else 1 for entry in entries)

    @property
    def point(self) -> str:
        """The point at which no denominator vanishes, in words."""
        texts = self["proof"]["formulas"]
        parts = (f"{texts[place]} = {value}" for place, value in self["proof"]["point"])
        return ", ".join(sorted(parts))

    def __repr__(self) -> str:
        extent = f"{self.generators} generators, {len(json.dumps(self))} bytes"
        return f"<Certificate of {self['name']}: {extent}, digest {self['digest'][:8]}>"


class ProofWriter:
    """Proof under construction: generators, hints by kind, and witnesses of signs."""

    def __init__(self, table: NodeTable) -> None:
        self.table = table
        self.generators: list[list[Any]] = []
        self.registered: set[int] = set()
        self.values: dict[int, int] = {}
        self.signs: dict[int, int] = {}
        self.parts: list[list[Any]] = []

    def atom(self, place: int, factor: int | None = None) -> None:
        """Add a generator for the node at ``place``, or for ``factor`` times it, if it has none."""
        if place not in self.registered:
            self.registered.add(place)
            entry: list[Any] = ["atom", place]
            if factor is not None:
                entry = ["forms", [place], [[[factor], self.table.add("number", "0")]]]
            self.generators.append(entry)

    def name(self, *, place: int, value: int) -> None:
        """Record that the root or function at ``place`` equals the node at ``value``."""
        if place != value:
            self.values[place] = value

    def words(self, place: int, terms: Sequence[tuple[str, int]]) -> None:
        """Record the argument of the function at ``place`` as a sum of (number, node) products."""
        name, _, *more = self.table.nodes[place]
        self.values[place] = self.table.add(name, self.table.combination(terms), *more)

    def data(self, point: Point) -> Data:
        """Return the proof part of a certificate; no denominator vanishes at ``point``."""
        values, signs = (list(map(list, pairs.items())) for pairs in (self.values, self.signs))
        places = [[self.table.place(s), str(value)] for s, value in point.items()]
        hints = {"values": values, "signs": signs, "point": places, "parts": self.parts}
        return {"generators": self.generators, **hints}

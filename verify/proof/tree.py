"""SymPy expressions as a table of nodes, for certificates; read back through a closed list.

A node is ``[name, ...]``: a number, a symbol, a constant, or a function with the places of its
arguments, which stand earlier in the table.  Equal subexpressions share one node.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy as sp

from solutions import special

from .kernels import HYPERBOLIC, TRIGONOMETRIC

Node = list[Any]

FUNCTIONS: dict[str, type] = {
    function.__name__: function
    for function in (
        *(sp.Add, sp.Mul, sp.Pow, sp.exp, sp.log, sp.atan),
        *(sp.conjugate, sp.re, sp.im, sp.Abs, sp.elliptic_k, sp.elliptic_e),
        *HYPERBOLIC,
        *TRIGONOMETRIC,
        *(getattr(special, name) for name in special.__all__),
    )
}
CONSTANTS = {"I": sp.I, "pi": sp.pi}
KINDS = ("positive", "negative", "real", "complex")


class NodeTable:
    """The nodes of some expressions.

    >>> table = NodeTable()
    >>> table.place(sp.Symbol("x", real=True) / 2)
    2
    >>> table.nodes
    [['number', '1/2'], ['symbol', 'x', 'real'], ['Mul', 0, 1]]
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._places: dict[sp.Expr, int] = {}

    def place(self, expression: sp.Expr) -> int:
        """Where ``expression`` stands; raises ValueError for a function not in the list."""
        if expression not in self._places:
            node = self._node(expression)
            self._places[expression] = len(self.nodes)
            self.nodes.append(node)
        return self._places[expression]

    def _node(self, expression: sp.Expr) -> Node:
        if expression.is_Rational:
            return ["number", str(expression)]
        if expression.is_Symbol:
            kind = next((k for k in KINDS[:3] if getattr(expression, f"is_{k}")), KINDS[3])
            return ["symbol", expression.name, kind]
        for name, constant in CONSTANTS.items():
            if expression == constant:
                return ["constant", name]
        name = expression.func.__name__
        if FUNCTIONS.get(name) is not expression.func:
            raise ValueError(
                f"functions must have a node in certificates, got {name} (add it to FUNCTIONS)"
            )
        return [name, *map(self.place, expression.args)]


def expressions(nodes: Sequence[Node]) -> list[sp.Expr]:
    """The expressions of a table; raises ValueError for anything `NodeTable` does not write."""
    found: list[sp.Expr] = []
    for node in nodes:
        found.append(_expression(node, found))
    return found


def _expression(node: Node, found: Sequence[sp.Expr]) -> sp.Expr:
    match node:
        case ["number", str(text)]:
            return rational(text)
        case ["symbol", str(name), "complex"]:
            return sp.Symbol(name)
        case ["symbol", str(name), ("positive" | "negative" | "real") as kind]:
            return sp.Symbol(name, **{kind: True})
        case ["constant", ("I" | "pi") as name]:
            return CONSTANTS[name]
        case [str(name), *places] if name in FUNCTIONS:
            if all(isinstance(place, int) and 0 <= place < len(found) for place in places):
                return FUNCTIONS[name](*(found[place] for place in places))
    raise ValueError(f"nodes must be such as the prover writes, got {node!r} (prove it anew)")


def rational(text: str) -> sp.Rational:
    """A rational number written ``p`` or ``p/q``.

    >>> rational("-3/4")
    -3/4
    """
    parts = text.split("/")
    digits = [part.removeprefix("-") for part in parts]
    if len(parts) > 2 or not all(part.isascii() and part.isdigit() for part in digits):
        raise ValueError(f"numbers must be written p or p/q, got {text!r} (such as 3 or 3/4)")
    return sp.Rational(*map(int, parts))

"""Nodes of a certificate as texts of the grammar, which the checker reads back node for node."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

Node = list[Any]

Text = Callable[[int], str]
"""What stands for the node at a place in the text of another."""

LEAVES = ("number", "symbol", "constant")

LONG = 40
"""Characters from which a formula that occurs twice gets a name."""


def node_text(node: Node, text: Text, unknowns: Sequence[str], variables: Sequence[str]) -> str:
    """A node as text; a sum or product has brackets around it."""
    match node:
        case ["number", value]:
            return f"({value})" if value.startswith("-") or "/" in value else str(value)
        case ["symbol", name, _] | ["constant", name]:
            return str(name)
        case ["Add", *parts]:
            return f"({' + '.join(map(text, parts))})"
        case ["Mul", *parts]:
            return f"({'*'.join(map(text, parts))})"
        case ["Pow", base, exponent]:
            power = exponent if exponent.isdigit() else f"({exponent})"
            return f"({text(base)}**{power})"
        case ["power", base, exponent]:
            return f"({text(base)}**({text(exponent)}))"
        case ["parity", exponent]:
            return f"((-1)**({text(exponent)}))"
        case ["poly", terms, *parts]:
            texts = list(map(text, parts))
            return f"({' + '.join(_monomial(c, e, texts) for c, e in terms)})"
        case ["diff", inner, *along]:
            return f"diff({', '.join(map(text, (inner, *along)))})"
        case ["unknown", place, shifts]:
            moved = [f"{v}{n:+d}" if n else v for v, n in zip(variables, shifts, strict=True)]
            return unknowns[place] + (f"[{', '.join(moved)}]" if any(shifts) else "")
    name, *parts = node
    return f"{'abs' if name == 'Abs' else name}({', '.join(map(text, parts))})"


def _monomial(coefficient: str, exponents: Sequence[int], texts: Sequence[str]) -> str:
    powers = [f"{t}**{n}" if n > 1 else t for t, n in zip(texts, exponents, strict=True) if n]
    if coefficient in ("1", "-1") and powers:
        return ("-" if coefficient == "-1" else "") + "*".join(powers)
    return "*".join([coefficient if coefficient.isdigit() else f"({coefficient})", *powers])


def numbered(nodes: Sequence[Node]) -> list[str]:
    """A text for every node, in the numbers of those before it: ``#3*#7``."""

    def text(place: int) -> str:
        leaf = nodes[place][0] in LEAVES
        return node_text(nodes[place], text, (), ()) if leaf else f"#{place}"

    return [plain(node_text(node, text, (), ())) for node in nodes]


def plain(text: str) -> str:
    """The text without brackets around all of it."""
    depth = 0
    for place, sign in enumerate(text):
        depth += (sign == "(") - (sign == ")")
        if depth == 0:
            return text[1:-1] if text[0] == "(" and place == len(text) - 1 else text
    return text


class Written:
    """Formulas in full; what occurs twice and is long gets a name, once."""

    def __init__(
        self,
        nodes: Sequence[Node],
        roots: Sequence[int],
        unknowns: Sequence[str],
        variables: Sequence[str],
    ) -> None:
        self.named: dict[str, str] = {}
        self._texts: dict[int, str] = {}
        taken = {*unknowns, *(node[1] for node in nodes if node[0] == "symbol")}
        uses = Counter(place for node in nodes for place in set(_children(node)))
        uses.update(roots)
        for node in nodes:
            if node[0] == "poly":
                uses.update(dict.fromkeys(node[2:], LONG))
        hidden = _with_unknowns(nodes)
        for place, node in enumerate(nodes):
            text = node_text(node, self._texts.__getitem__, unknowns, variables)
            often = uses[place] > 1 and len(text) > 8 and uses[place] * len(text) > 2 * LONG
            if place not in hidden and (often or len(text) > 100 * LONG):
                name = f"f{len(self.named) + 1}"
                while name in taken:
                    name += "_"
                self.named[name], text = plain(text), name
            self._texts[place] = text

    def text(self, place: int) -> str:
        """The text of the node at a place."""
        return plain(self._texts[place])


def _children(node: Node) -> list[int]:
    match node:
        case [("number" | "symbol" | "constant" | "unknown"), *_]:
            return []
        case ["Pow", base, _]:
            return [base]
        case ["poly", _, *parts]:
            return parts
    return node[1:]


def _with_unknowns(nodes: Sequence[Node]) -> set[int]:
    found: set[int] = set()
    for place, node in enumerate(nodes):
        if node[0] == "unknown" or not found.isdisjoint(_children(node)):
            found.add(place)
    return found

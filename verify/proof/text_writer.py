"""Write nodes of a certificate as texts of the grammar, which the checker reads back exactly."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

from longwave.derive.algebra.formula_tree import ATOM, POWER, PRODUCT, SUM, Part, signed_sum

Node = list[Any]

Meaning = Callable[[int], Part]
"""Function that maps the index of a node to its text, for use within another text."""

LEAVES = ("number", "symbol", "constant")

LONG_TEXT = 40
"""Length from which repeated formulas get a name (see `Written`)."""


def node_text(
    node: Node,
    meaning: Meaning,
    unknowns: Sequence[str] = (),
    variables: Sequence[str] = (),
    power: str = "**",
) -> Part:
    """Return a node as text; with the power sign ``**`` it is read back as the same node."""

    def enclosed(place: int, closely: int) -> str:
        text, level = meaning(place)
        return text if level >= closely else f"({text})"

    match node:
        case ["number", value]:
            return str(value), ATOM if value.isdigit() else PRODUCT
        case ["symbol", name, _] | ["constant", name]:
            return str(name), ATOM
        case ["Add", *parts]:
            return signed_sum([enclosed(part, PRODUCT) for part in parts]), SUM
        case ["Mul", *parts]:
            return _product([meaning(part) for part in parts]), PRODUCT
        case ["Pow", base, exponent]:
            above = exponent if exponent.isdigit() else f"({exponent})"
            return f"{enclosed(base, ATOM)}{power}{above}", POWER
        case ["power", base, exponent]:
            return f"{enclosed(base, ATOM)}{power}{enclosed(exponent, ATOM)}", POWER
        case ["parity", exponent]:
            return f"(-1){power}{enclosed(exponent, ATOM)}", POWER
        case ["poly", terms, *parts]:
            texts = [enclosed(part, ATOM) for part in parts]
            return signed_sum([_monomial(c, e, texts, power) for c, e in terms] or ["0"]), SUM
        case ["unknown", place, shifts]:
            moved = [f"{v}{n:+d}" if n else v for v, n in zip(variables, shifts, strict=True)]
            return unknowns[place] + (f"[{', '.join(moved)}]" if any(shifts) else ""), ATOM
    name, *parts = node
    texts = [enclosed(part, SUM) for part in parts]
    return f"{'abs' if name == 'Abs' else name}({', '.join(texts)})", ATOM


def _product(parts: Sequence[Part]) -> str:
    """Return a product as text; a number comes first, and -1 is written as a sign."""
    (head, level), *rest = parts
    texts = [head if level >= POWER or (head[-1].isdigit() and level) else f"({head})"]
    texts += [text if level >= POWER else f"({text})" for text, level in rest]
    return "-" + "*".join(texts[1:]) if texts[0] == "-1" and rest else "*".join(texts)


def _monomial(coefficient: str, exponents: Sequence[int], texts: Sequence[str], power: str) -> str:
    powers = [f"{t}{power}{n}" if n > 1 else t for t, n in zip(texts, exponents, strict=True) if n]
    if coefficient in ("1", "-1") and powers:
        return ("-" if coefficient == "-1" else "") + "*".join(powers)
    return "*".join([coefficient, *powers])


def numbered(nodes: Sequence[Node]) -> list[str]:
    """Return a text for every node; earlier nodes are references such as ``#3*#7``."""

    def meaning(place: int) -> Part:
        leaf = nodes[place][0] in LEAVES
        return node_text(nodes[place], meaning) if leaf else (f"#{place}", ATOM)

    return [node_text(node, meaning)[0] for node in nodes]


class Written:
    """Formulas as full texts; long parts that occur often are ``named`` and written once."""

    def __init__(
        self,
        nodes: Sequence[Node],
        roots: Sequence[int],
        unknowns: Sequence[str],
        variables: Sequence[str],
    ) -> None:
        self.named: dict[str, str] = {}
        self._texts: dict[int, Part] = {}
        taken = {*unknowns, *(node[1] for node in nodes if node[0] == "symbol")}
        uses = Counter(place for node in nodes for place in set(_children(node)))
        uses.update(roots)
        for node in nodes:
            if node[0] == "poly":
                uses.update(dict.fromkeys(node[2:], LONG_TEXT))
        hidden = set[int]()
        for place, node in enumerate(nodes):
            if node[0] == "unknown" or not hidden.isdisjoint(_children(node)):
                hidden.add(place)
            text, level = node_text(node, self._texts.__getitem__, unknowns, variables)
            often = uses[place] > 1 and len(text) > 8 and uses[place] * len(text) > 2 * LONG_TEXT
            if place not in hidden and (often or len(text) > 100 * LONG_TEXT):
                name = f"f{len(self.named) + 1}"
                while name in taken:
                    name += "_"
                self.named[name], text, level = text, name, ATOM
            self._texts[place] = text, level

    def text(self, place: int) -> str:
        """Return the text of the node at a place."""
        return self._texts[place][0]


def _children(node: Node) -> list[int]:
    match node:
        case [("number" | "symbol" | "constant" | "unknown"), *_]:
            return []
        case ["Pow", base, _]:
            return [base]
        case ["poly", _, *parts]:
            return parts
    return node[1:]

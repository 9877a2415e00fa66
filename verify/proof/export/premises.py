"""The premises of a proof: what its axioms need that no algebra shows, noted as the checker asks.

The signs here are the checker's; each question that is answered with yes is noted for whoever asked
it: the formula whose image rests on it, a generator, or a denominator.  What an answer rests on
within the rules of signs is not noted: it is the checker's to show, or the reader's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial

from flint import fmpq, fmpq_mpoly

from longwave.derive.algebra.formula_tree import ATOM, SUM, Part
from longwave.verify.kernel.field import Field
from longwave.verify.kernel.nodes import Node, Nodes, children
from longwave.verify.kernel.signs import Signs

from ..text_writer import Meaning, node_text
from ..text_writer import Node as WrittenNode


@dataclass(frozen=True)
class Question:
    """Whether a ``relation`` of formulas, a key of `RELATIONS`, holds on the domain."""

    relation: str
    nodes: tuple[int, ...] = ()


RELATIONS: Mapping[str, str] = {
    "less": "{} < {}",
    "at_most": "{} <= {}",
    "real": "{} is real",
    "is_integer": "{} is an integer",
    "analytic": "{} is analytic but for isolated poles",
    "connected": "the domain is connected",
    "not_zero": "{} is not 0",
}
"""How relations are told in words."""

PURPOSES: Mapping[str, str] = {
    **dict.fromkeys(("Pow", "log"), "the branch of"),
    **dict.fromkeys(("asin", "acos", "atan", "asinh", "acosh", "atanh"), "the branch of"),
    "Abs": "the value of",
    **dict.fromkeys(("elliptic_k", "elliptic_e"), "the parameter of"),
    **{f"jacobi_{name}": "the parameter of" for name in ("zeta", "theta", "eta")},
}
"""What the premises are for that the image of a function rests on."""


@dataclass
class Asker:
    """Whoever asks; ``depth`` counts the rules of signs that are at work, ``noted`` what holds."""

    depth: int = 0
    noted: dict[Question, None] = field(default_factory=dict)


class TracedSigns(Signs):
    """The checker's signs, which note what was asked and holds."""

    def __init__(self, images: Field) -> None:
        super().__init__(images.nodes, images.image, images.positive, images.hints.signs)
        self.askers = [Asker()]
        self.kept: dict[Question, str] = {}

    def keep(self, asked: Iterable[Question], comment: str) -> None:
        """Keep what no definition rests on but all of the proof, with what it is for."""
        for question in asked:
            self.kept.setdefault(question, comment)

    @contextmanager
    def asked(self) -> Iterator[dict[Question, None]]:
        """Note apart what is asked meanwhile."""
        self.askers.append(Asker())
        try:
            yield self.askers[-1].noted
        finally:
            self.askers.pop()

    def note(self, question: Question) -> None:
        """Note a premise, but for plain ones: of numbers, or that a fraction is analytic."""
        if question.relation == "analytic" and all(map(self._is_fraction, question.nodes)):
            return
        values = [self._nodes.value(node) for node in question.nodes]
        known = [value for value in values if value is not None]
        if values and len(known) == len(values) and _holds(question.relation, known):
            return
        self.askers[-1].noted[question] = None

    def _is_fraction(self, node: int) -> bool:
        """Whether a node is made of symbols and numbers by sums, products and integer powers."""
        inner = (self._nodes.all[place] for place in self._nodes.below([node]))
        return all(n[0] in RATIONAL or (n[0] == "Pow" and n[2].q == 1) for n in inner)

    def is_real(self, node: int) -> bool:
        """Whether ``node`` is shown to be real."""
        return self._ask(partial(super().is_real, node), Question("real", (node,)))

    def positive(self, node: int) -> bool:
        """Whether ``node`` is shown to be real and greater than 0."""
        zero = self._nodes.rational(0)
        return self._ask(partial(super().positive, node), Question("less", (zero, node)))

    def not_negative(self, node: int) -> bool:
        """Whether ``node`` is shown to be real and at least 0."""
        zero = self._nodes.rational(0)
        return self._ask(partial(super().not_negative, node), Question("at_most", (zero, node)))

    def below_one(self, m: int) -> bool:
        """Whether ``m`` is shown to be real and less than 1."""
        one = self._nodes.rational(1)
        return self._ask(partial(super().below_one, m), Question("less", (m, one)))

    def is_between(self, node: int, low: fmpq | None, high: fmpq | None) -> bool:
        """Whether ``node`` is shown to be real and not outside two rational numbers (None: any)."""
        asked = []
        for end, is_low in ((low, True), (high, False)):
            if end is not None:
                place = self._nodes.rational(int(end.p), int(end.q))
                asked.append(Question("at_most", (place, node) if is_low else (node, place)))
        asked = asked or [Question("real", (node,))]
        return self._ask(partial(super().is_between, node, low, high), *asked)

    def is_analytic(self, node: int) -> bool:
        """Whether a formula is analytic on the whole domain but for isolated poles."""
        return self._ask(partial(super().is_analytic, node), Question("analytic", (node,)))

    def _ask(self, answer: Callable[[], bool], *asked: Question) -> bool:
        asker = self.askers[-1]
        asker.depth += 1
        try:
            found = answer()
        finally:
            asker.depth -= 1
        if found and not asker.depth:
            for question in asked:
                self.note(question)
        return found


def _holds(relation: str, values: list[fmpq]) -> bool:
    match relation, values:
        case "less", [left, right]:
            return bool(left < right)
        case "at_most", [left, right]:
            return bool(left <= right)
    return relation in ("real", "analytic")


RATIONAL = ("number", "symbol", "pi", "I", "Add", "Mul", "poly")

LONG = 60
"""Characters from which a part of a formula is named where a premise is told."""


class FormulaWords:
    """Formulas in words, long parts by their names, which are told behind them."""

    def __init__(self, nodes: Nodes) -> None:
        self._nodes = nodes
        self._known: dict[int, tuple[Part, frozenset[int]]] = {}

    def told(self, form: str, *nodes: int) -> str:
        """A sentence about formulas, with what its names mean."""
        found = [self._of(node) for node in nodes]
        todo = sorted({name for _, names in found for name in names})
        where: dict[int, str] = {}
        while todo:
            name = todo.pop()
            (text, _), names = self._of(name)
            where[name] = f"n{name} = {text}"
            todo += sorted(names - where.keys())
        rest = f" where {'; '.join(where.values())}" if where else ""
        return form.format(*(text for (text, _), _ in found)) + rest

    def part(self, node: int) -> Part:
        """A formula as a part of another, with what its names mean."""
        (_, level), names = self._of(node)
        return self.told("{}", node), SUM if names else level

    def _of(self, node: int) -> tuple[Part, frozenset[int]]:
        """The text of a node and the nodes that it names."""
        if node not in self._known:
            names: set[int] = set()
            self._known[node] = self.written(node, partial(self._part, names)), frozenset(names)
        return self._known[node]

    def _part(self, names: set[int], node: int) -> Part:
        part, inner = self._of(node)
        if len(part[0]) > LONG:
            names.add(node)
            return f"n{node}", ATOM
        names |= inner
        return part

    def written(self, node: int, meaning: Meaning) -> Part:
        """The text of a node, with ``meaning`` for those in it."""
        return node_text(self._in_certificate(node), meaning, power="^")

    def _in_certificate(self, node: int) -> WrittenNode:
        match found := self._nodes.all[node]:
            case ("number", value):
                return ["number", str(value)]
            case (("I" | "pi") as name,):
                return ["constant", name]
            case ("symbol", *_):
                return list(found)
            case ("Add", *parts):
                return ["Add", *self._parted(parts)[::-1]]
            case ("Mul", *parts):
                return ["Mul", *self._parted(parts)]
            case ("Pow", base, exponent):
                return ["sqrt", base] if exponent == fmpq(1, 2) else ["Pow", base, str(exponent)]
            case ("poly", monomials, *places):
                return ["poly", [(str(c), powers) for c, powers in monomials], *places]
        return [called(found), *children(found)]

    def _parted(self, parts: list[int]) -> list[int]:
        """Numbers before all others."""
        return sorted(parts, key=lambda part: self._nodes.value(part) is None)


def called(node: Node) -> str:
    """The name of a node's function; the second derivative of f is f^(2)."""
    name, *_, last = node
    if name not in ("jet", "theta"):
        return str(name)
    label, order = last
    return f"{label}^({order})" if order else str(label)


def polynomial_words(polynomial: fmpq_mpoly, meaning: Callable[[int], Part]) -> str:
    """A polynomial in generators, the last first, in words."""
    used = [place for place, n in enumerate(reversed(polynomial.degrees())) if n]
    terms = [(str(c), [int(n[-1 - i]) for i in used]) for n, c in polynomial.terms()]
    return node_text(["poly", terms, *used], meaning, power="^")[0]

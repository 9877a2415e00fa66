"""Premises of a proof: conditions of its axioms that algebra does not show, recorded when checked.

The signs here are the checker's.  Each question with the answer yes is recorded for what asked it:
the formula whose image depends on it, a generator, or a denominator.  Questions that the rules of
signs ask among themselves are not recorded; the checker or the reader must show these.
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
    """Question whether a ``relation`` of formulas, a key of `RELATIONS`, holds on the domain."""

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
"""Template of each relation in words."""

PURPOSES: Mapping[str, str] = {
    **dict.fromkeys(("Pow", "log"), "the branch of"),
    **dict.fromkeys(("asin", "acos", "atan", "asinh", "acosh", "atanh"), "the branch of"),
    "Abs": "the value of",
    **dict.fromkeys(("elliptic_k", "elliptic_e"), "the parameter of"),
    **{f"jacobi_{name}": "the parameter of" for name in ("zeta", "theta", "eta")},
}
"""Purpose, in words, of the premises on which the image of a function depends."""


@dataclass
class Asker:
    """Record of one block: the questions that hold, and the nesting ``depth`` of open ones."""

    depth: int = 0
    noted: dict[Question, None] = field(default_factory=dict)


class TracedSigns(Signs):
    """The checker's signs, which record each question that holds."""

    def __init__(self, images: Field) -> None:
        super().__init__(images.nodes, images.image, images.positive, images.hints.signs)
        self.askers = [Asker()]
        self.shared: dict[Question, str] = {}

    def keep(self, questions: Iterable[Question], comment: str) -> None:
        """Add premises of the whole proof, rather than of a definition, with their purpose."""
        for question in questions:
            self.shared.setdefault(question, comment)

    @contextmanager
    def recording(self) -> Iterator[dict[Question, None]]:
        """Record the questions of this block separately."""
        self.askers.append(Asker())
        try:
            yield self.askers[-1].noted
        finally:
            self.askers.pop()

    def note(self, question: Question) -> None:
        """Record a question that holds as a premise, unless it is trivial.

        Relations between numbers are trivial, and that a rational formula is analytic."""
        if question.relation == "analytic" and all(map(self._is_fraction, question.nodes)):
            return
        values = [self._nodes.value(node) for node in question.nodes]
        known = [value for value in values if value is not None]
        if values and len(known) == len(values) and _holds(question.relation, known):
            return
        self.askers[-1].noted[question] = None

    def _is_fraction(self, node: int) -> bool:
        """Return whether a node has only symbols, numbers, sums, products and integer powers."""
        inner = (self._nodes.all[place] for place in self._nodes.below([node]))
        return all(n[0] in RATIONAL or (n[0] == "Pow" and n[2].q == 1) for n in inner)

    def is_real(self, node: int) -> bool:
        """Return whether ``node`` is shown to be real."""
        return self._ask(partial(super().is_real, node), Question("real", (node,)))

    def positive(self, node: int) -> bool:
        """Return whether ``node`` is shown to be real and greater than 0."""
        zero = self._nodes.rational(0)
        return self._ask(partial(super().positive, node), Question("less", (zero, node)))

    def not_negative(self, node: int) -> bool:
        """Return whether ``node`` is shown to be real and at least 0."""
        zero = self._nodes.rational(0)
        return self._ask(partial(super().not_negative, node), Question("at_most", (zero, node)))

    def below_one(self, m: int) -> bool:
        """Return whether ``m`` is shown to be real and less than 1."""
        one = self._nodes.rational(1)
        return self._ask(partial(super().below_one, m), Question("less", (m, one)))

    def is_between(self, node: int, low: fmpq | None, high: fmpq | None) -> bool:
        """Return whether ``node`` is shown to be real and within bounds (None: unbounded)."""
        questions = []
        for end, is_low in ((low, True), (high, False)):
            if end is not None:
                place = self._nodes.rational(int(end.p), int(end.q))
                questions.append(Question("at_most", (place, node) if is_low else (node, place)))
        questions = questions or [Question("real", (node,))]
        return self._ask(partial(super().is_between, node, low, high), *questions)

    def is_analytic(self, node: int) -> bool:
        """Return whether a formula is analytic on the whole domain except for isolated poles."""
        return self._ask(partial(super().is_analytic, node), Question("analytic", (node,)))

    def _ask(self, answer: Callable[[], bool], *questions: Question) -> bool:
        asker = self.askers[-1]
        asker.depth += 1
        try:
            holds = answer()
        finally:
            asker.depth -= 1
        if holds and not asker.depth:
            for question in questions:
                self.note(question)
        return holds


def _holds(relation: str, values: list[fmpq]) -> bool:
    match relation, values:
        case "less", [left, right]:
            return bool(left < right)
        case "at_most", [left, right]:
            return bool(left <= right)
    return relation in ("real", "analytic")


RATIONAL = ("number", "symbol", "pi", "I", "Add", "Mul", "poly")

LONG_PART = 60
"""Length in characters above which a part of a premise's formula gets a name."""


class FormulaWords:
    """Formulas as text; long parts are named, and the names are explained after the formula."""

    def __init__(self, nodes: Nodes) -> None:
        self._nodes = nodes
        self._known: dict[int, tuple[Part, frozenset[int]]] = {}

    def sentence(self, form: str, *nodes: int) -> str:
        """Fill the template ``form`` with formulas, and append what the names in them mean."""
        parts = [self._of(node) for node in nodes]
        todo = sorted({name for _, names in parts for name in names})
        where: dict[int, str] = {}
        while todo:
            name = todo.pop()
            (text, _), names = self._of(name)
            where[name] = f"n{name} = {text}"
            todo += sorted(names - where.keys())
        rest = f" where {'; '.join(where.values())}" if where else ""
        return form.format(*(text for (text, _), _ in parts)) + rest

    def part(self, node: int) -> Part:
        """Return a formula as a part of another, followed by the meaning of its names."""
        (_, level), names = self._of(node)
        return self.sentence("{}", node), SUM if names else level

    def _of(self, node: int) -> tuple[Part, frozenset[int]]:
        """Return the text of a node, and the nodes whose names occur in the text."""
        if node not in self._known:
            names: set[int] = set()
            self._known[node] = self.written(node, partial(self._part, names)), frozenset(names)
        return self._known[node]

    def _part(self, names: set[int], node: int) -> Part:
        part, inner = self._of(node)
        if len(part[0]) > LONG_PART:
            names.add(node)
            return f"n{node}", ATOM
        names |= inner
        return part

    def written(self, node: int, meaning: Meaning) -> Part:
        """Return the text of a node; ``meaning`` gives the texts of its arguments."""
        return node_text(self._in_certificate(node), meaning, power="^")

    def _in_certificate(self, node: int) -> WrittenNode:
        match node_entry := self._nodes.all[node]:
            case ("number", value):
                return ["number", str(value)]
            case (("I" | "pi") as name,):
                return ["constant", name]
            case ("symbol", *_):
                return list(node_entry)
            case ("Add", *parts):
                return ["Add", *self._numbers_first(parts)[::-1]]
            case ("Mul", *parts):
                return ["Mul", *self._numbers_first(parts)]
            case ("Pow", base, exponent):
                return ["sqrt", base] if exponent == fmpq(1, 2) else ["Pow", base, str(exponent)]
            case ("poly", monomials, *places):
                return ["poly", [(str(c), powers) for c, powers in monomials], *places]
        return [called(node_entry), *children(node_entry)]

    def _numbers_first(self, parts: list[int]) -> list[int]:
        """Sort numbers before all other nodes."""
        return sorted(parts, key=lambda part: self._nodes.value(part) is None)


def called(node: Node) -> str:
    """Return the name of a node's function; the second derivative of f is f^(2)."""
    name, *_, last = node
    if name not in ("jet", "theta"):
        return str(name)
    label, order = last
    return f"{label}^({order})" if order else str(label)


def polynomial_words(polynomial: fmpq_mpoly, meaning: Callable[[int], Part]) -> str:
    """Return a polynomial as text; the ring has the generators last first."""
    used = [place for place, n in enumerate(reversed(polynomial.degrees())) if n]
    terms = [(str(c), [int(n[-1 - i]) for i in used]) for n, c in polynomial.terms()]
    return node_text(["poly", terms, *used], meaning, power="^")[0]

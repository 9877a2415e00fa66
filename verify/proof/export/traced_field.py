"""The checker's field; it records every step, and the premises on which its images depend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import fmpq, fmpq_mpoly

from longwave.derive.algebra.formula_tree import ATOM, Part
from longwave.verify.kernel.field import Field, Slopes
from longwave.verify.kernel.ring import Element

from ..text_writer import node_text
from . import terms
from .premises import PURPOSES, RELATIONS, FormulaWords, Question, TracedSigns
from .terms import Definition, Premise, Rate, Relation, SlopeAxiom, Step, Term
from .traced_ring import Trace, TracedElement, TracedRing, plain, term_of, traced


class TracedSlopes(Slopes):
    """Derivatives of the checker's field; those of formulas are left to the script.

    A derivative may need the slope that is being stated (of an epsilon in a linear form).  Then the
    value from the formula's structure is stated, and checked when the slope is known.
    """

    def __init__(self, field: TracedField) -> None:
        super().__init__(field)
        self._traced = field
        self._noted: set[tuple[int, int]] = set()
        self._missing: set[tuple[int, int]] = set()
        self._rates_noted: set[tuple[int, Term]] = set()

    def slope(self, place: int, variable: int) -> Element:
        """Return the derivative of a generator; record it at the first call."""
        self._traced.trace.open.add((place, variable))
        value = super().slope(place, variable)
        self._traced.trace.open.discard((place, variable))
        if (place, variable) not in self._noted:
            self._noted.add((place, variable))
            axis = self._traced.axis(variable)
            self._traced.note(SlopeAxiom(axis, place, term_of(value), None), value)
        if not self._traced.trace.open:
            while missing := self._missing - self._noted:
                self.slope(*min(missing))
            self._traced.trace.settle()
        return value

    def derivative(self, element: Element, variable: int) -> Element:
        """Return the derivative of an element, as a term for the script if possible."""
        return self._left(super().derivative(element, variable), element, variable)

    def rate(self, node: int, variable: int) -> Element:
        """Return the derivative of a formula, as a term for the script if possible."""
        return self._left(super().rate(node, variable), self._traced.image(node), variable)

    def _left(self, value: Element, element: Element, variable: int) -> Element:
        """Return the derivative as a term for the script; ``value`` if a slope is not yet known."""
        if not element.places:
            return self._traced.zero
        axis, term = self._traced.axis(variable), term_of(element)
        written: Term = ("slope", axis, term)
        slopes = {(place, variable) for place in element.places}
        if slopes & self._traced.trace.open:
            self._missing |= slopes
            gap = terms.added([written, terms.negated(term_of(value))])
            self._traced.trace.vanishing(gap, "a derivative that a slope contains")
            return value
        for place, _ in sorted(slopes - self._noted):
            self.slope(place, variable)
        if term[0] == "node" and (axis, term) not in self._rates_noted:
            self._rates_noted.add((axis, term))
            if term_of(value) != written:
                self._traced.note(Rate(axis, term, term_of(value), None), value)
        return traced(plain(value), written)


class TracedField(Field):
    """The checker's field, with every step of its computation recorded."""

    ring_type = TracedRing
    slopes_type = TracedSlopes

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.signs: TracedSigns = TracedSigns(self)
        self.words = FormulaWords(self.nodes)
        self.free: dict[int, str] = {}
        self.guards: dict[int, list[Question]] = {}
        self._roots: list[tuple[int, int, TracedElement]] = []
        self._defined: dict[int, TracedElement] = {}

    @property
    def trace(self) -> Trace:
        """The recorded steps."""
        assert isinstance(self.ring, TracedRing)
        return self.ring.trace

    def axis(self, variable: int) -> int:
        """Return the index of a variable among those of the statement."""
        return list(self.variables).index(variable)

    def note(self, step: Step, value: Element) -> None:
        """Record a step, and the checker's value for it."""
        self.trace.steps.append((step, value))

    def image(self, node: int) -> TracedElement:
        """Return the image of a node; the script names it unless it is a number or has a name."""
        if node in self._defined:
            return self._defined[node]
        with self.signs.recording() as questions:
            value = super().image(node)
        if questions and self.nodes.all[node][0] != "exp":  # its axioms hold for any argument
            self.guards[node] = list(questions)
        self._defined[node] = self.define(value, self.written(node), node)
        return self._defined[node]

    def register(self, node: int) -> None:
        """Register the next generator, and record its premises with their purpose."""
        with self.signs.recording() as questions:
            super().register(node)
            if self.nodes.all[node][0] == "parity":
                self.signs.note(Question("is_integer", (self.nodes.all[node][1],)))
        self.signs.keep(questions, self.purpose(node))

    def is_kept(self, name: str, f: int, value: int) -> bool:
        """Return whether a value is principal by continuity; record the premise that it is."""
        with self.signs.recording():
            is_principal = super().is_kept(name, f, value)
        if is_principal:
            turn = self.nodes.add("pi")
            fractions = (0, 1) if name == "acos" else (fmpq(-1, 2), fmpq(1, 2))
            ends = (self.nodes.add("number", fmpq(fraction)) for fraction in fractions)
            low, high = (self.nodes.add("Mul", end, turn) for end in ends)
            self.signs.note(Question("less", (low, value)))
            self.signs.note(Question("less", (value, high)))
        return is_principal

    def derivative(self, element: Element, variable: int) -> Element:
        """Return the derivative of an element, for the script to compute."""
        value = super().derivative(plain(element), variable)
        return traced(plain(value), ("slope", self.axis(variable), term_of(element)))

    def define(self, value: Element, comment: str, node: int) -> TracedElement:
        """Give a value a name in the script, unless it is a number or a name without premises."""
        term = term_of(value)
        if term[0] in ("number", *terms.NAMES) and node not in self.guards:
            return traced(plain(value), term)
        self.note(Definition(("node", node), term, None, comment), value)
        return traced(plain(value), ("node", node))

    def sum(self, parts: Sequence[Element]) -> Element:
        """Return the sum of elements, as one term for the script."""
        whole = super().sum([plain(part) for part in parts])
        return traced(plain(whole), terms.added([term_of(part) for part in parts]))

    def purpose(self, node: int) -> str:
        """Return, in words, the purpose of the premises for the image of a node."""
        match self.nodes.all[node]:
            case ("Pow", _, exponent) if exponent.q == 1:
                purpose = "for"
            case (name, *_):
                purpose = PURPOSES.get(name, "for")
        return self.words.sentence(f"{purpose} {{}}", node)

    def premise(self, question: Question, comment: str) -> Premise:
        """Return the script's premise that states a ``question`` whose answer is yes."""
        form, parts = RELATIONS[question.relation], question.nodes
        if question.nodes and self.nodes.value(parts[0]) == 0 and len(parts) == 2:
            form, parts = {"less": "{} > 0", "at_most": "{} >= 0"}[question.relation], parts[1:]
        stated = tuple(map(self.stated, question.nodes))
        return Premise(question.relation, stated, self.words.sentence(form, *parts), comment)

    def stated(self, node: int) -> Term:
        """Return the term of a premise's formula; without an image it becomes a free element."""
        if node in self._images:
            return self.image(node).term
        term = terms.composed(self.nodes.all[node], self.stated)
        if term is not None:
            return term
        self.free[node] = self.words.sentence("{}", node)
        return ("free", node)

    def generator_words(self, place: int) -> Part:
        """Return the text of a generator: the function it stands for, or else its name."""
        generator = self.generators[place]
        is_plain = generator.scale.is_one() and generator.formula == generator.form[0][1]
        return self.words.part(generator.formula) if is_plain else (f"g{place}", ATOM)

    def written(self, node: int) -> str:
        """Return the text of a function or root; "" for sums, products and integer powers."""
        match self.nodes.all[node]:
            case (("number" | "Add" | "Mul" | "poly"), *_):
                return ""
            case ("Pow", _, exponent) if exponent.q == 1:
                return ""
        return self.words.written(node, self._short)[0]

    def meaning(self, place: int) -> str:
        """Return the meaning of a generator in words.  Generator number ``place`` may be unused."""
        if place >= len(self.generators):
            return "not used"
        generator = self.generators[place]
        known = [self.nodes.product(*pair) for pair in generator.form]
        terms_of = [t for t in self.nodes.terms(generator.formula) if t not in known]
        pairs = [(self._short(f), (self.written(node), ATOM)) for f, node in generator.form]
        texts = [node_text(["Mul", 0, 1], pair.__getitem__)[0] for pair in pairs]
        if not texts or generator.formula == generator.form[0][1]:
            texts, terms_of = [], [generator.formula]
        text = " + ".join([*texts, *(self.written(t) or self._short(t)[0] for t in terms_of)])
        return text + ("" if generator.scale.is_one() else f", times ({generator.scale})")

    def _short(self, node: int) -> Part:
        """Return the name of a node, or its text if it has none."""
        if node in self._defined and self._defined[node].term[0] != "number":
            kind, place = self._defined[node].term
            return f"{kind[0]}{place}", ATOM
        return self.words.written(node, self._short)

    def relate(self, place: int, degree: int, value: Element, factor: Element) -> fmpq_mpoly:
        """Enter a relation into the ring and record it."""
        scale = super().relate(place, degree, value, factor)
        whole = value * factor**degree
        term, below = term_of(whole), whole.denominator()
        if not below.is_one():
            own = terms.polynomial_term(below)
            above = terms.polynomial_term(whole.numerator)
            gap = [terms.multiplied([term, own]), terms.negated(above)]
            self.trace.vanishing(terms.added(gap), "a radicand times its denominator")
            term = terms.multiplied([above, terms.raised(own, degree - 1)])
        self.note(Relation(place, degree, term, None), self.one)
        power = plain(self.ring.generator(place)) ** degree
        self._roots.append((place, degree, traced(power, term)))
        return scale

    def note_slopes_of_relations(self) -> None:
        """Record that the slopes of roots agree with the derivatives of their relations."""
        stated = [s for s, _ in self.trace.steps if isinstance(s, SlopeAxiom)]
        for place, degree, value in self._roots:
            for axis in sorted({s.variable for s in stated if s.generator == place}):
                for other in sorted(value.places):
                    self.slopes.slope(other, self.variables[axis])
                root = ("generator", place)
                outer = [terms.number(degree), terms.raised(root, degree - 1)]
                own = terms.multiplied([*outer, ("slope", axis, root)])
                gap = terms.added([own, terms.negated(("slope", axis, value.term))])
                self.trace.vanishing(gap, "the derivative of a relation")

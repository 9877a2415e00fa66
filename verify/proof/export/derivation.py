"""A certificate's proof, step by step: the checker is followed, and what it computes is noted.

The field here is the checker's, with elements that remember how they were made.  A formula that
gets an image becomes a definition, an axiom of a root or a derivative a relation or a slope, and
each identity that the checker has found true and relies on becomes a term that must vanish.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from flint import fmpq

from verify.kernel.check import opened, registered
from verify.kernel.derivations import Slopes
from verify.kernel.field import Field
from verify.kernel.identity import Residual
from verify.kernel.limits import CertificateError
from verify.kernel.ring import Element, Ring
from verify.kernel.statement import Jet, Statement, statement_text

from . import terms
from .terms import Definition, Rate, Relation, SlopeAxiom, Step, Term, Vanishing, WrittenProof


@dataclass(frozen=True)
class TracedElement(Element):
    """A fraction of the checker's ring with the term that it was made by."""

    term: Term = ("number", fmpq(0))

    @property
    def plain(self) -> Element:
        """The fraction alone."""
        return Element(self.ring, self.numerator, self.powers)

    @property
    def is_zero(self) -> bool:
        """Whether the normal form is 0; if it is, something may rest on it, and it is noted."""
        found = self.plain.is_zero
        if found and isinstance(self.ring, TracedRing):
            self.ring.trace.vanishing(self.term, "a premise")
        return found

    def __add__(self, other: Element) -> TracedElement:
        return traced(self.plain + plain(other), terms.added([self.term, term_of(other)]))

    def __radd__(self, other: Element) -> TracedElement:
        return traced(plain(other) + self.plain, terms.added([term_of(other), self.term]))

    def __neg__(self) -> TracedElement:
        return traced(-self.plain, terms.negated(self.term))

    def __sub__(self, other: Element) -> TracedElement:
        negative = terms.negated(term_of(other))
        return traced(self.plain - plain(other), terms.added([self.term, negative]))

    def __rsub__(self, other: Element) -> TracedElement:
        negative = terms.negated(self.term)
        return traced(plain(other) - self.plain, terms.added([term_of(other), negative]))

    def __mul__(self, other: Element) -> TracedElement:
        return traced(self.plain * plain(other), terms.multiplied([self.term, term_of(other)]))

    def __rmul__(self, other: Element) -> TracedElement:
        return traced(plain(other) * self.plain, terms.multiplied([term_of(other), self.term]))

    def __truediv__(self, other: Element) -> TracedElement:
        return self * _inverse(other)

    def __rtruediv__(self, other: Element) -> TracedElement:
        return _inverse(self) * other

    def __pow__(self, exponent: int) -> TracedElement:
        base = _inverse(self) if exponent < 0 else self
        value = base.plain ** abs(exponent)
        return traced(value, terms.raised(base.term, abs(exponent)))

    def inverse(self) -> TracedElement:
        """One over it."""
        return _inverse(self)


def traced(element: Element, term: Term) -> TracedElement:
    """An element with its term."""
    return TracedElement(element.ring, element.numerator, element.powers, term)


def plain(element: Element) -> Element:
    """An element without a term."""
    return element.plain if isinstance(element, TracedElement) else element


def term_of(element: Element) -> Term:
    """How an element was made; one that was not followed is a fraction of polynomials."""
    if isinstance(element, TracedElement):
        return element.term
    below = [
        terms.raised(terms.inverted(terms.polynomial_term(element.ring.factors[place])), power)
        for place, power in element.powers.items()
    ]
    _note_factors(element.ring, element.powers)
    return terms.multiplied([terms.polynomial_term(element.numerator), *below])


def _inverse(element: Element) -> TracedElement:
    found = plain(element).inverse()
    _note_factors(element.ring, element.ring.split(element.numerator)[1])
    _note_factors(element.ring, found.powers)
    return traced(found, terms.inverted(term_of(element)))


def _note_factors(ring: Ring, powers: Mapping[int, int]) -> None:
    if isinstance(ring, TracedRing):
        ring.divisors.update(dict.fromkeys(powers))


class Trace:
    """The steps so far, each with the checker's value of it.

    ``open`` are the slopes that are being stated; what vanishes waits until there is none.
    """

    def __init__(self) -> None:
        self.steps: list[tuple[Step, Element | None]] = []
        self.open: set[tuple[int, int]] = set()
        self._vanishing: set[Term] = set()
        self._waiting: list[Vanishing] = []

    def vanishing(self, term: Term, comment: str) -> None:
        """Note that a term is 0."""
        if not terms.is_number(term, 0) and term not in self._vanishing:
            self._vanishing.add(term)
            self._waiting.append(Vanishing(term, comment))
            self.settle()

    def settle(self) -> None:
        """Note what has waited for slopes that are known now."""
        if not self.open:
            self.steps += [(step, None) for step in self._waiting]
            self._waiting.clear()


class TracedRing(Ring):
    """The checker's ring with elements that remember how they were made.

    ``divisors`` are the places of the factors that something was divided by.
    """

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self.trace = Trace()
        self.divisors: dict[int, None] = {}

    def number(self, value: fmpq | int) -> TracedElement:
        """A rational number."""
        return traced(super().number(value), terms.number(value))

    def generator(self, place: int) -> TracedElement:
        """A generator."""
        return traced(super().generator(place), terms.generator(place))


class TracedSlopes(Slopes):
    """Derivatives, in which those of formulas stand as such and are left to the script.

    Where a formula's derivative would need the slope that is being stated (the argument of an
    epsilon that is part of a linear form with its variable), the value that follows from the
    formula's structure is stated, and checked when the slope is known.
    """

    def __init__(self, field: TracedField) -> None:
        super().__init__(field)
        self._field = field
        self._noted: set[tuple[int, int]] = set()
        self._wanted: set[tuple[int, int]] = set()
        self._rates_noted: set[tuple[int, Term]] = set()

    def slope(self, place: int, variable: int) -> Element:
        """The derivative of a generator, noted when it is first asked for."""
        self._field.trace.open.add((place, variable))
        value = super().slope(place, variable)
        self._field.trace.open.discard((place, variable))
        if (place, variable) not in self._noted:
            self._noted.add((place, variable))
            axis = self._field.axis(variable)
            self._field.note(SlopeAxiom(axis, place, term_of(value), None), value)
        if not self._field.trace.open:
            while missing := self._wanted - self._noted:
                self.slope(*min(missing))
            self._field.trace.settle()
        return value

    def derivative(self, element: Element, variable: int) -> Element:
        """The derivative of what is made of generators."""
        return self._left(super().derivative(element, variable), element, variable)

    def _rate(self, node: int, variable: int) -> Element:
        return self._left(super()._rate(node, variable), self._field.image(node), variable)

    def _left(self, value: Element, element: Element, variable: int) -> Element:
        """The derivative that the script takes of ``element``; its known ``value`` if it cannot."""
        if not element.places:
            return self._field.zero
        axis, term = self._field.axis(variable), term_of(element)
        written: Term = ("slope", axis, term)
        wanted = {(place, variable) for place in element.places}
        if wanted & self._field.trace.open:
            self._wanted |= wanted
            gap = terms.added([written, terms.negated(term_of(value))])
            self._field.trace.vanishing(gap, "a derivative that a slope contains")
            return value
        for place, _ in sorted(wanted - self._noted):
            self.slope(place, variable)
        if term[0] == "node" and (axis, term) not in self._rates_noted:
            self._rates_noted.add((axis, term))
            if term_of(value) != written:
                self._field.note(Rate(axis, term, term_of(value), None), value)
        return traced(plain(value), written)


class TracedField(Field):
    """The checker's field; what it computes is noted step by step."""

    ring_type = TracedRing

    @property
    def trace(self) -> Trace:
        """The steps."""
        assert isinstance(self.ring, TracedRing)
        return self.ring.trace

    @cached_property
    def _slopes(self) -> Slopes:
        return TracedSlopes(self)

    @cached_property
    def _roots(self) -> list[tuple[int, int, TracedElement]]:
        return []

    @cached_property
    def _defined(self) -> dict[int, TracedElement]:
        return {}

    def axis(self, variable: int) -> int:
        """The place of a variable among those of the statement."""
        return list(self.variables).index(variable)

    def note(self, step: Step, value: Element) -> None:
        """Another step, with what the checker has as its value."""
        self.trace.steps.append((step, value))

    def image(self, node: int) -> TracedElement:
        """The image of a node, under a name if it is made of others."""
        value = super().image(node)
        if node not in self._defined:
            self._defined[node] = self.define(value, self.written(node), node)
        return self._defined[node]

    def derivative(self, element: Element, variable: int) -> Element:
        """The derivative of an element, for the script to take."""
        value = super().derivative(plain(element), variable)
        return traced(plain(value), ("slope", self.axis(variable), term_of(element)))

    def define(self, value: Element, comment: str, node: int) -> TracedElement:
        """Give a value a name, unless it has one."""
        term = term_of(value)
        if term[0] in ("number", *terms.NAMES):
            return traced(plain(value), term)
        self.note(Definition(terms.node(node), term, None, comment), value)
        return traced(plain(value), terms.node(node))

    def sum(self, parts: list[Element]) -> Element:
        """The sum."""
        whole = super().sum([plain(part) for part in parts])
        return traced(plain(whole), terms.added([term_of(part) for part in parts]))

    def written(self, node: int) -> str:
        """A function of named arguments in words; nothing for sums, products and powers."""
        name, *arguments = self.nodes.all[node]
        if name in ("symbol", "I", "pi"):
            return str(arguments[0]) if arguments else str(name)
        if name == "Pow":
            base, exponent = arguments
            return f"({self._short(base)})^({exponent})" if exponent.q > 1 else ""
        if name in ("number", "Add", "Mul", "poly"):
            return ""
        return f"{name}({', '.join(map(self._short, arguments))})"

    def meaning(self, place: int) -> str:
        """What a generator stands for, in words."""
        if place >= len(self.generators):
            return "not used"
        found = self.generators[place]
        if found.form:
            products = [f"{self._short(f)} * {self.written(n)}" for f, n in found.form]
            return " + ".join([self._short(found.shift), *products])
        text = self.written(found.node) or self._short(found.node)
        text += "" if found.scale is None else f", times ({found.scale})"
        return text + ("" if found.below is None else f", over {self._short(found.below)}")

    def _short(self, node: int) -> str:
        """The name of a node, or its text where it has none."""
        if node in self._defined and self._defined[node].term[0] != "number":
            kind, place = self._defined[node].term
            return f"{kind[0]}{place}"
        match self.nodes.all[node]:
            case ("number", value):
                return str(value)
            case ("symbol", name, _) | (name,):
                return str(name)
            case (("Add" | "Mul") as name, *parts):
                return f"({(' + ' if name == 'Add' else ' * ').join(map(self._short, parts))})"
            case ("Pow", base, exponent):
                return f"{self._short(base)}^({exponent})"
        return self.written(node)

    def _algebraic(
        self, node: int, degree: int, value: Element, scale: Element | None = None
    ) -> None:
        place = len(self.generators)
        super()._algebraic(node, degree, value, scale)
        whole = value if scale is None else value * scale**degree
        term, below = term_of(whole), whole.denominator()
        if not below.is_one():
            factor = terms.polynomial_term(below)
            above = terms.polynomial_term(whole.numerator)
            gap = [terms.multiplied([term, factor]), terms.negated(above)]
            self.trace.vanishing(terms.added(gap), "a radicand times its denominator")
            term = terms.multiplied([above, terms.raised(factor, degree - 1)])
        self.note(Relation(place, degree, term, None), self.one)
        power = plain(self.ring.generator(place)) ** degree
        self._roots.append((place, degree, traced(power, term)))

    def note_slopes_of_relations(self) -> None:
        """Note that the slopes of roots are those which follow from their relations."""
        stated = [s for s, _ in self.trace.steps if isinstance(s, SlopeAxiom)]
        for place, degree, value in self._roots:
            for axis in sorted({s.variable for s in stated if s.generator == place}):
                for other in sorted(value.places):
                    self.slope(other, self.variables[axis])
                root = terms.generator(place)
                outer = [terms.number(degree), terms.raised(root, degree - 1)]
                own = terms.multiplied([*outer, ("slope", axis, root)])
                gap = terms.added([own, terms.negated(("slope", axis, value.term))])
                self.trace.vanishing(gap, "the derivative of a relation")


def written_out(certificate: Mapping[str, Any]) -> WrittenProof:
    """The steps of a certificate's proof.

    Raises CertificateError if a step fails, or for a proof that rests on others.
    """
    if certificate["proof"]["parts"]:
        raise CertificateError("a proof by equal parts has no script (its parts have proofs)")
    statement = opened(certificate)
    nodes = statement.nodes
    field = registered(nodes, statement, certificate["proof"], field_type=TracedField)
    assert isinstance(field, TracedField)
    field.walk(statement.roots)
    _Equations(field, statement).note()
    field.note_slopes_of_relations()
    assert isinstance(field.ring, TracedRing)
    divisors = [place for place in field.ring.divisors if not _is_constant(field.ring, place)]
    return WrittenProof(
        title=str(certificate["name"]),
        statement=statement_text(statement, certificate["statement"]),
        meanings=[field.meaning(place) for place in range(len(field.ring.names))],
        variables=[str(nodes.all[variable][1]) for variable in statement.variables],
        denominators=[terms.polynomial_term(field.ring.factors[place]) for place in divisors],
        steps=list(_wanted([_over(step, value, divisors) for step, value in field.trace.steps])),
    )


def _is_constant(ring: Ring, place: int) -> bool:
    return bool(ring.factors[place].is_constant())


class _Equations:
    """The statement's equations, in derivatives that the script takes itself."""

    def __init__(self, field: TracedField, statement: Statement) -> None:
        self._field, self._statement = field, statement
        self._jets: dict[Jet, Term] = {}
        self._residual = Residual(field, statement)

    def note(self) -> None:
        """Note what an unknown and its derivatives are, and that each equation vanishes."""
        trace = self._field.trace
        for number, equation in enumerate(self._statement.equations, 1):
            if isinstance(equation, int):
                residual = self._residual.substituted(equation)
                self._field.walk([residual])
                term = term_of(self._field.image(residual))
            else:
                self._long = self._residual.quotient(equation) is not None
                term = terms.added([self._product(*entry) for entry in equation])
            trace.steps.append((Vanishing(term, f"equation {number}"), None))

    def _product(self, value: fmpq, known: Sequence[int], jets: Sequence[Jet]) -> Term:
        factors = [term_of(self._field.image(node)) for node in known]
        factors += [self._jet(jet) for jet in jets]
        return terms.multiplied([terms.number(value), *factors])

    def _jet(self, jet: Jet) -> Term:
        if jet not in self._jets:
            unknown, orders = jet
            symbol = self._statement.unknowns[unknown]
            formula = self._field.image(self._statement.formulas[unknown])
            axis = next((i for i, n in enumerate(orders) if n), None)
            if axis is None:
                term, comment = term_of(formula), f"the unknown {symbol}"
            else:
                lower = (*orders[:axis], orders[axis] - 1, *orders[axis + 1 :])
                term = ("slope", axis, self._jet((unknown, lower)))
                comment = f"derivative of {symbol} of order {orders}"
            name = terms.jet(len(self._jets) + 1)
            value = None if self._long else plain(self._residual.jet(jet))
            self._field.trace.steps.append((Definition(name, term, None, comment), value))
            self._jets[jet] = name
        return self._jets[jet]


def _over(step: Step, value: Element | None, divisors: Sequence[int]) -> Step:
    """A step with the exponents of the denominators that its value is written over."""
    if value is None or isinstance(step, Vanishing):
        return step
    below = [value.powers.get(place, 0) for place in divisors]
    while below and below[-1] == 0:
        below.pop()
    return replace(step, below=tuple(below))


def _wanted(steps: Sequence[Step]) -> Iterator[Step]:
    """The steps without definitions that nothing uses."""
    used: set[Any] = set()
    kept = []
    for step in reversed(steps):
        if isinstance(step, Definition) and step.name not in used:
            continue
        used |= {inner for inner in terms.inner_terms(step.term) if inner[0] in ("node", "jet")}
        kept.append(step)
    return reversed(kept)

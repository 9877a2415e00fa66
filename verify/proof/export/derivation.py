"""Follow the checker through a certificate and record every step of its computation.

The field here is the checker's, with elements that record their provenance.  A formula that gets an
image becomes a definition.  An axiom of a root becomes a relation, one of a derivative a slope.
Each identity that the checker relies on becomes a term that must vanish.  What it shows by signs
becomes a premise of the definition that depends on it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from longwave.verify.kernel.check import opened, registered
from longwave.verify.kernel.denominators import Denominators
from longwave.verify.kernel.limits import CertificateError
from longwave.verify.kernel.nodes import number
from longwave.verify.kernel.quotients import long_quotient, shape
from longwave.verify.kernel.ring import Element
from longwave.verify.kernel.statement import Statement, Substitution, statement_text

from . import terms
from .premises import RELATIONS, Question, polynomial_words
from .terms import Definition, Premise, Step, Term, Vanishing, WrittenProof
from .traced_field import TracedField
from .traced_ring import TracedRing, plain, term_of


def written_out(certificate: Mapping[str, Any]) -> WrittenProof:
    """Return the steps and premises of a proof; raises CertificateError for equal parts."""
    if certificate["proof"]["parts"]:
        raise CertificateError("a proof by equal parts has no script (its parts have proofs)")
    statement = opened(certificate)
    nodes = statement.nodes
    field = registered(statement, certificate["proof"], field_type=TracedField)
    assert isinstance(field, TracedField)
    field.walk(statement.formulas)
    _Equations(field, statement).note()
    field.note_slopes_of_relations()
    assert isinstance(field.ring, TracedRing)
    factors = field.ring.factors
    divisors = [place for place in field.ring.divisors if not factors[place].is_constant()]
    premises = _Premises(field, statement)
    premises.note_denominators(divisors, certificate["proof"]["point"])
    steps = premises.used_steps()
    return WrittenProof(
        title=str(certificate["name"]),
        statement=statement_text(statement, certificate["statement"]),
        meanings=[field.meaning(place) for place in range(len(field.ring.names))],
        variables=[str(nodes.all[variable][1]) for variable in statement.variables],
        free=field.free,
        premises=premises.all,
        guards=premises.guards,
        steps=[_over(step, value, divisors) for step, value in steps],
    )


class _Premises:
    """Premises of a proof: the domain, those of generators and definitions, and denominators."""

    def __init__(self, field: TracedField, statement: Statement) -> None:
        self._field, self._statement = field, statement
        self._comments = {
            Question("at_most" if weak else "less", (left, right)): "the domain"
            for weak, left, right in statement.domain
        }
        self._denominators: list[Premise] = []
        self.guards: dict[Term, list[int]] = {}

    def note_denominators(self, divisors: Sequence[int], point: Sequence[Any]) -> None:
        """Add the premises that denominators are not 0; raises CertificateError if not shown."""
        field, nodes = self._field, self._field.nodes
        values = {nodes.place(symbol): number(value) for symbol, value in point}
        at = ", ".join(f"{nodes.all[symbol][1]} = {value}" for symbol, value in values.items())
        reason = f"shown at {at}, on every branch"
        symbols = all(nodes.all[g.formula][0] == "symbol" for g in field.generators)
        free = symbols and not field.ring.relations
        with field.signs.recording() as questions:
            check = Denominators(field, self._statement, values)
            for place in divisors:
                if not free:
                    check.check(field.ring.factors[place])
        if any(question.relation == "analytic" for question in questions):
            questions[Question("connected")] = None
        field.signs.keep(questions, "for the denominators")
        for place in divisors:
            factor = field.ring.factors[place]
            words = RELATIONS["not_zero"].format(polynomial_words(factor, field.generator_words))
            comment = "a denominator, no zero polynomial" if free else f"a denominator, {reason}"
            term = terms.polynomial_term(factor)
            self._denominators.append(Premise("not_zero", (term,), words, comment))

    @property
    def all(self) -> list[Premise]:
        """All premises in order; `guards` refers to them by index."""
        stated = [self._field.premise(*entry) for entry in self._comments.items()]
        return [*stated, *self._denominators]

    def used_steps(self) -> list[tuple[Step, Element | None]]:
        """Return the steps, omitting definitions that no step and no premise uses."""
        field = self._field
        for question, comment in field.signs.shared.items():
            self._comments.setdefault(question, comment)
        while True:
            before = len(self._comments)
            used = {name for premise in self.all for term in premise.terms for name in _names(term)}
            steps = list(_used_backwards(field.trace.steps, used))[::-1]
            names = (step.name for step, _ in steps if isinstance(step, Definition))
            named = [place for kind, place in names if kind == "node"]
            guards = {node: field.guards[node] for node in named if node in field.guards}
            for node, questions in guards.items():
                for question in questions:
                    self._comments.setdefault(question, field.purpose(node))
            for question in field.signs.askers[0].noted:
                self._comments.setdefault(question, "for generators and their slopes")
            if len(self._comments) == before:
                break
        order = {question: place for place, question in enumerate(self._comments)}
        self.guards = {("node", n): [order[q] for q in guards[n]] for n in guards}
        return steps


class _Equations:
    """Equations of the statement, in derivatives that the script computes itself."""

    def __init__(self, field: TracedField, statement: Statement) -> None:
        self._field, self._statement = field, statement
        self._jets: dict[int, tuple[Term, Element | None]] = {}
        self._put = Substitution(field.nodes, statement.variables, statement.formulas)

    def note(self) -> None:
        """Record the unknowns, their derivatives, and that each equation vanishes."""
        for place, equation in enumerate(self._statement.equations, 1):
            if shape(self._field.nodes, equation) is None:
                residual = self._put(equation)
                self._field.walk([residual])
                term = term_of(self._field.image(residual))
            else:
                self._long = long_quotient(self._field, self._statement) is not None
                term = self._polynomial(equation)
            self._field.trace.steps.append((Vanishing(term, f"equation {place}"), None))

    def _polynomial(self, node: int) -> Term:
        """Return the term of a polynomial in derivatives of the unknowns."""
        term = terms.composed(self._field.nodes.all[node], self._polynomial)
        return self._jet(node)[0] if term is None else term

    def _jet(self, node: int) -> tuple[Term, Element | None]:
        """Return the name of an unknown or of its derivative, and the checker's value of it."""
        if node not in self._jets:
            nodes, (name, inner, *along) = self._field.nodes, self._field.nodes.all[node]
            place = inner if name == "unknown" else nodes.all[inner][1]
            symbol, variables = self._statement.unknowns[place], self._statement.variables
            if name == "unknown":
                formula: Element | None = self._field.image(self._statement.formulas[place])
                assert formula is not None
                term, comment = term_of(formula), f"the unknown {symbol}"
                value = None if self._long else plain(formula)
            else:
                *before, last = along
                below, lower = self._jet(nodes.add("diff", inner, *before) if before else inner)
                term = ("slope", variables.index(last), below)
                orders = tuple(along.count(variable) for variable in variables)
                comment = f"derivative of {symbol} of order {orders}"
                value = None if lower is None else plain(self._field.derivative(lower, last))
            own = "jet", len(self._jets) + 1
            self._field.trace.steps.append((Definition(own, term, None, comment), value))
            self._jets[node] = own, value
        return self._jets[node]


def _over(step: Step, value: Element | None, divisors: Sequence[int]) -> Step:
    """Return a step with the exponents of the denominators of its value."""
    if value is None or isinstance(step, Vanishing):
        return step
    below = [value.powers.get(place, 0) for place in divisors]
    while below and below[-1] == 0:
        below.pop()
    return replace(step, below=tuple(below))


def _names(term: Term) -> set[Term]:
    return {inner for inner in terms.inner_terms(term) if inner[0] in ("node", "jet")}


def _used_backwards(
    steps: Sequence[tuple[Step, Element | None]], used: set[Term]
) -> Iterator[tuple[Step, Element | None]]:
    """Yield the steps, last first, omitting definitions of unused names; extend ``used``."""
    for step, value in reversed(steps):
        if isinstance(step, Definition) and step.name not in used:
            continue
        used |= _names(step.term)
        yield step, value

"""Misprints of a closed form, decided one by one: how many are refuted, and why the rest solve.

A formula's subexpressions are each changed throughout, as if the line that defines them were
misprinted: the coefficient of a term (written or 1) by one part in a hundred, its sign, the term
left out, a modulus k put for the parameter m = k**2 and the other way about.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import sympy as sp

from longwave.solutions.record import ClosedForm
from longwave.solutions.symbols import k
from longwave.verify.proof import form_domains, prove_equal
from longwave.verify.proof.catalogue_proofs import own_problem
from longwave.verify.proof.prover import decide
from longwave.verify.subexpressions import abbreviated, distinct_nodes, replaced
from longwave.verify.verdict import Outcome

COEFFICIENT_CHANGE = sp.Rational(101, 100)


@dataclass(frozen=True)
class Mutant:
    """A formula with one change, and the change in words."""

    description: str
    expression: sp.Expr


def mutants(expression: sp.Expr) -> Iterator[Mutant]:
    """Every formula that differs from ``expression`` by one change; each one once.

    A mutant can still be a solution where the equation has a symmetry (U to -U, a shift): that is
    for the caller to see.

    >>> x = sp.Symbol("x")
    >>> for mutant in mutants(3 * x**2 + sp.sin(k**2 * x)):
    ...     print(mutant.description)
    term 3*x**2: coefficient times 101/100
    term 3*x**2: sign flipped
    term 3*x**2: dropped
    term sin(k**2*x): coefficient times 101/100
    term sin(k**2*x): sign flipped
    term sin(k**2*x): dropped
    argument k**2*x: coefficient times 101/100
    k**2 in k**2*x: k for k**2
    """
    seen = {expression}
    changes = [] if expression.is_Add else [(expression, _coefficients("term", expression))]
    changes += [(node, _changes(node)) for node in distinct_nodes(expression)]
    for node, images in changes:
        for description, image in images:
            changed = replaced(expression, node, image)
            if changed not in seen:
                seen.add(changed)
                yield Mutant(description, changed)


Change = tuple[str, sp.Expr]
"""A description, and what takes the place of a subexpression."""


def _changes(node: sp.Expr) -> Iterator[Change]:
    """The changes of a subexpression; the terms of a sum in an argument come with the sum."""
    if node.is_Add:
        for place, term in enumerate(node.args):
            rest = sp.Add(*node.args[:place], *node.args[place + 1 :])
            yield from ((words, rest + new) for words, new in _coefficients("term", term))
            yield f"term {abbreviated(term)}: dropped", rest
    elif node.is_Mul and node.args[0].is_Number:
        yield from _coefficients("factor", node)
    elif node.is_Function:
        for place, argument in enumerate(node.args):
            changes = [] if argument.is_Add else _coefficients("argument", argument)
            for words, new in changes:
                yield words, node.func(*node.args[:place], new, *node.args[place + 1 :])
    for old, new in ((k**2, k), (k, k**2)):
        if old in node.args and node != k**2:
            swapped = node.func(*(new if argument == old else argument for argument in node.args))
            yield f"{old} in {abbreviated(node)}: {new} for {old}", swapped


def _coefficients(kind: str, term: sp.Expr) -> Iterator[Change]:
    words = f"{kind} {abbreviated(term)}"
    yield f"{words}: coefficient times {COEFFICIENT_CHANGE}", COEFFICIENT_CHANGE * term
    yield f"{words}: sign flipped", -term


@dataclass(frozen=True)
class Survivor:
    """A mutant that is not refuted: the change, the outcome, and the reason."""

    description: str
    outcome: Outcome
    reason: str


@dataclass(frozen=True)
class MutationCount:
    """How the mutants of one form came out; ``survivors`` are those not refuted."""

    name: str
    mutants: int
    survivors: tuple[Survivor, ...]
    seconds: float

    @property
    def proved(self) -> int:
        """How many are solutions after all."""
        return self._count(Outcome.PROVED)

    @property
    def undecided(self) -> int:
        """How many could not be decided."""
        return self._count(Outcome.UNDECIDED)

    @property
    def refuted(self) -> int:
        """How many are refuted with a witness."""
        return self.mutants - len(self.survivors)

    def _count(self, outcome: Outcome) -> int:
        return sum(survivor.outcome is outcome for survivor in self.survivors)

    def json(self) -> dict[str, Any]:
        """The record as plain data."""
        counts = {"refuted": self.refuted, "proved": self.proved, "undecided": self.undecided}
        return asdict(self) | counts


def count_mutants(form: ClosedForm) -> MutationCount:
    """Decide every mutant of ``form`` (`verify.evidence.mutations`) in the form's own variables.

    >>> from longwave.solutions import closed_form
    >>> count = count_mutants(closed_form("kink"))
    >>> count.mutants, count.refuted, count.undecided, count.survivors[0].reason
    (8, 7, 0, 'symmetry U to -U')
    """
    start = time.perf_counter()
    made = list(mutants(form.expression))
    survivors = tuple(s for mutant in made if (s := _survivor(form, mutant)) is not None)
    return MutationCount(form.name, len(made), survivors, time.perf_counter() - start)


def _survivor(form: ClosedForm, mutant: Mutant) -> Survivor | None:
    problem = own_problem(replace(form, expression=mutant.expression))
    verdict = decide(problem, time.perf_counter())
    if verdict.outcome is Outcome.REFUTED:
        return None
    proved = verdict.outcome is Outcome.PROVED
    reason = solution_reason(form, mutant.expression) if proved else verdict.detail
    return Survivor(mutant.description, verdict.outcome, reason)


def solution_reason(form: ClosedForm, expression: sp.Expr) -> str:
    """Why a solution made from ``form`` by one change is one.

    >>> from longwave.solutions import closed_form
    >>> form = closed_form("rational_1")
    >>> solution_reason(form, sp.Integer(3))
    'constant'
    """
    variables = form.equation.variables
    if not expression.free_symbols & set(variables):
        return "constant"
    if expression == -form.expression:
        return "symmetry U to -U"
    for symbol in (parameter.symbol for parameter in form.parameters):
        others = (sp.S.Zero, -symbol, COEFFICIENT_CHANGE * symbol)
        if expression in (replaced(form.expression, symbol, other) for other in others):
            return f"another value of {symbol}"
    known = {"symmetry U to -U": form.expression, "bare wave": form.background}
    for reason, solution in known.items():
        for image in (-solution, solution):
            verdict = prove_equal(expression, image, variables, domains=form_domains(form))
            if verdict.outcome is Outcome.PROVED:
                return reason
    return "another solution"

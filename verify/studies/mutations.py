"""Misprints of a closed form decided one by one: how many are refuted, and why the rest solve."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import sympy as sp

from solutions.record import ClosedForm
from solutions.symbols import k
from verify.mutation import COEFFICIENT_CHANGE, Mutant, mutants
from verify.proof import form_domains, prove, prove_equal
from verify.subexpressions import replaced
from verify.verdict import Outcome


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
    """Decide every mutant of ``form`` (`verify.mutation`) in the form's own variables.

    >>> from solutions import closed_form
    >>> count = count_mutants(closed_form("kink"))
    >>> count.mutants, count.refuted, count.undecided, count.survivors[0].reason
    (8, 7, 0, 'symmetry U to -U')
    """
    start = time.perf_counter()
    made = list(_mutants(form))
    survivors = tuple(s for mutant in made if (s := _survivor(form, mutant)) is not None)
    return MutationCount(form.name, len(made), survivors, time.perf_counter() - start)


def _mutants(form: ClosedForm) -> Iterator[Mutant]:
    return mutants(form.expression, k if form.expression.has(k) else None)


def _survivor(form: ClosedForm, mutant: Mutant) -> Survivor | None:
    verdict = prove(form.equation, mutant.expression, domains=form_domains(form))
    if verdict.outcome is Outcome.REFUTED:
        return None
    proved = verdict.outcome is Outcome.PROVED
    reason = solution_reason(form, mutant.expression) if proved else verdict.detail
    return Survivor(mutant.description, verdict.outcome, reason)


def solution_reason(form: ClosedForm, expression: sp.Expr) -> str:
    """Why a solution made from ``form`` by one change is one.

    >>> from solutions import closed_form
    >>> form = closed_form("rational_1")
    >>> solution_reason(form, sp.Integer(3))
    'constant'
    """
    variables = (form.equation.xi, form.equation.tau)
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

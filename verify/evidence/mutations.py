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


def mutants(expression: sp.Expr, modulus: sp.Symbol | None = None) -> Iterator[Mutant]:
    """Every formula that differs from ``expression`` by one change; each one once.

    ``modulus`` is the symbol k whose powers k and k**2 are swapped; without it there are no such
    mutants.  A mutant can still be a solution where the equation has a symmetry (U to -U, a
    shift): that is for the caller to see.

    >>> x, k = sp.symbols("x k")
    >>> for mutant in mutants(3 * x**2 + sp.sin(k**2 * x), k):
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
    for description, target, replacement in _changes(expression, modulus):
        changed = replaced(expression, target, replacement)
        if changed not in seen:
            seen.add(changed)
            yield Mutant(description, changed)


Change = tuple[str, sp.Expr, sp.Expr]
"""A description, a subexpression, and what takes its place."""


def _changes(expression: sp.Expr, modulus: sp.Symbol | None) -> Iterator[Change]:
    if not expression.is_Add:
        yield from _coefficient_changes(f"term {abbreviated(expression)}", expression, expression)
    for node in distinct_nodes(expression):
        if node.is_Add:
            yield from _term_changes(node)
        elif node.is_Mul and node.args[0].is_Number:
            yield from _coefficient_changes(f"factor {abbreviated(node)}", node, node)
        elif node.is_Function:
            yield from _argument_changes(node)
        if modulus is not None:
            yield from _modulus_changes(node, modulus)


def _term_changes(total: sp.Expr) -> Iterator[Change]:
    for place, term in enumerate(total.args):
        rest = sp.Add(*total.args[:place], *total.args[place + 1 :])
        words = f"term {abbreviated(term)}"
        for description, _, changed in _coefficient_changes(words, term, term):
            yield description, total, rest + changed
        yield f"{words}: dropped", total, rest


def _argument_changes(function: sp.Expr) -> Iterator[Change]:
    """The arguments that are no sums (the terms of those come with the sums)."""
    for place, argument in enumerate(function.args):
        if argument.is_Add:
            continue
        words = f"argument {abbreviated(argument)}"
        for description, _, changed in _coefficient_changes(words, argument, argument):
            arguments = (*function.args[:place], changed, *function.args[place + 1 :])
            yield description, function, function.func(*arguments)


def _coefficient_changes(place: str, target: sp.Expr, term: sp.Expr) -> Iterator[Change]:
    yield f"{place}: coefficient times {COEFFICIENT_CHANGE}", target, COEFFICIENT_CHANGE * term
    yield f"{place}: sign flipped", target, -term


def _modulus_changes(node: sp.Expr, k: sp.Symbol) -> Iterator[Change]:
    m = k**2
    if node == m:
        return
    if m in node.args:
        swapped = node.func(*(k if argument == m else argument for argument in node.args))
        yield f"k**2 in {abbreviated(node)}: k for k**2", node, swapped
    if k in node.args:
        swapped = node.func(*(m if argument == k else argument for argument in node.args))
        yield f"k in {abbreviated(node)}: k**2 for k", node, swapped


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
    made = list(_mutants(form))
    survivors = tuple(s for mutant in made if (s := _survivor(form, mutant)) is not None)
    return MutationCount(form.name, len(made), survivors, time.perf_counter() - start)


def _mutants(form: ClosedForm) -> Iterator[Mutant]:
    return mutants(form.expression, k if form.expression.has(k) else None)


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

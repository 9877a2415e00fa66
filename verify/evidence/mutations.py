"""Single-change mutants of a closed form: how many are refuted, and the reasons for the others.

Each subexpression is changed wherever it occurs, as if the line that defines it were misprinted.
A change multiplies the coefficient of a term by 101/100, flips its sign, drops the term, or swaps
the modulus k and the parameter m = k**2.
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
    """Yield every formula that differs from ``expression`` by one change, without repeats.

    A mutant can still be a solution if the equation has a symmetry (U to -U, a shift); the caller
    must check for that.

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
    earlier = {expression}
    changes = [] if expression.is_Add else [(expression, _coefficients("term", expression))]
    changes += [(node, _changes(node)) for node in distinct_nodes(expression)]
    for node, images in changes:
        for description, image in images:
            changed = replaced(expression, node, image)
            if changed not in earlier:
                earlier.add(changed)
                yield Mutant(description, changed)


Change = tuple[str, sp.Expr]
"""Change in words, and the subexpression after the change."""


def _changes(node: sp.Expr) -> Iterator[Change]:
    """Yield the changes of one node; a sum as a function's argument is changed at its own node."""
    if node.is_Add:
        for index, term in enumerate(node.args):
            rest = sp.Add(*node.args[:index], *node.args[index + 1 :])
            yield from ((words, rest + new) for words, new in _coefficients("term", term))
            yield f"term {abbreviated(term)}: dropped", rest
    elif node.is_Mul and node.args[0].is_Number:
        yield from _coefficients("factor", node)
    elif node.is_Function:
        for index, argument in enumerate(node.args):
            changes = [] if argument.is_Add else _coefficients("argument", argument)
            for words, new in changes:
                yield words, node.func(*node.args[:index], new, *node.args[index + 1 :])
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
    """Counts of one form's mutants by outcome; ``survivors`` are those not refuted."""

    name: str
    mutants: int
    survivors: tuple[Survivor, ...]
    seconds: float

    @property
    def proved(self) -> int:
        """Number of mutants proved to be solutions."""
        return sum(survivor.outcome is Outcome.PROVED for survivor in self.survivors)

    @property
    def undecided(self) -> int:
        """Number of mutants left undecided."""
        return len(self.survivors) - self.proved

    @property
    def refuted(self) -> int:
        """Number of mutants refuted with a witness."""
        return self.mutants - len(self.survivors)

    def json(self) -> dict[str, Any]:
        """Return the counts and survivors as plain data."""
        counts = {"refuted": self.refuted, "proved": self.proved, "undecided": self.undecided}
        return asdict(self) | counts


def count_mutants(form: ClosedForm) -> MutationCount:
    """Decide whether each mutant of ``form`` is a solution too; return the counts by outcome.

    >>> from longwave.solutions import closed_form
    >>> count = count_mutants(closed_form("kink"))
    >>> count.mutants, count.refuted, count.undecided, count.survivors[0].reason
    (8, 7, 0, 'symmetry U to -U')
    """
    start = time.perf_counter()
    candidates = list(mutants(form.expression))
    survivors = tuple(s for mutant in candidates if (s := _survivor(form, mutant)) is not None)
    return MutationCount(form.name, len(candidates), survivors, time.perf_counter() - start)


def _survivor(form: ClosedForm, mutant: Mutant) -> Survivor | None:
    verdict = decide(own_problem(replace(form, expression=mutant.expression)))
    if verdict.outcome is Outcome.REFUTED:
        return None
    proved = verdict.outcome is Outcome.PROVED
    reason = solution_reason(form, mutant.expression) if proved else verdict.detail
    return Survivor(mutant.description, verdict.outcome, reason)


def solution_reason(form: ClosedForm, expression: sp.Expr) -> str:
    """Return why ``expression``, a mutant of ``form``, is a solution too.

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

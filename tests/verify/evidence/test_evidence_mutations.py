"""Mutants of formulas with one change each; the residual alone catches every wrong one."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import pytest
import sympy as sp

from longwave.solutions.catalogue import CATALOGUE
from longwave.solutions.functions import jacobi_dn
from longwave.solutions.record import ClosedForm
from longwave.solutions.symbols import X_0, k, tau, xi
from longwave.verify.evidence.mutations import Mutant, mutants
from longwave.verify.evidence.residual import Sampling, check_residual
from longwave.verify.proof.catalogue_proofs import own_problem
from longwave.verify.proof.prover import decide
from longwave.verify.subexpressions import replaced
from longwave.verify.verdict import Outcome

QUICK = Sampling(digits=(30, 50), points=2, seed=7)
DENSE = Sampling(digits=(30, 50), points=24, seed=8)
"""Where one exponential outweighs the rest by 50 digits, a point or two cannot see a wrong term."""

KINDS = ("coefficient", "sign flipped", "dropped", "k for k**2", "k**2 for k")


def _kind(mutant: Mutant) -> str:
    return next(kind for kind in KINDS if kind in mutant.description.rsplit(": ", 1)[1])


def _solutions_by_symmetry(form: ClosedForm) -> set[sp.Expr]:
    """Return the symmetric solutions: U to -U, another X_0, the bare background."""
    shifts = {
        replaced(form.expression, X_0, x) for x in (sp.S.Zero, -X_0, sp.Rational(101, 100) * X_0)
    }
    return {-form.expression, form.background, *shifts}


def _wrong(form: ClosedForm) -> Iterator[Mutant]:
    """Return the mutants that are neither constant nor a solution by symmetry."""
    symmetric = _solutions_by_symmetry(form)
    for mutant in mutants(form.expression):
        if mutant.expression not in symmetric and mutant.expression.args:
            yield mutant


def _refuted(form: ClosedForm, mutant: Mutant) -> bool:
    wrong = replace(form, expression=mutant.expression)
    return any(
        check_residual(wrong, sampling).outcome is Outcome.REFUTED for sampling in (QUICK, DENSE)
    )


def _is_a_solution(form: ClosedForm, mutant: Mutant) -> bool:
    """Return whether the mutant is proved to solve the equation all the same."""
    problem = own_problem(replace(form, expression=mutant.expression))
    return decide(problem).outcome is Outcome.PROVED


def _first_ones(form: ClosedForm) -> list[Mutant]:
    """Return the first mutant of each kind."""
    return list({_kind(mutant): mutant for mutant in reversed(list(_wrong(form)))}.values())


MOST = 40
"""Misprints of a form that are looked at."""

QUICK_FORMS = [
    form for form in CATALOGUE.of("mKdV") if form.name not in ("rogue_cn", "breather_sn")
]


@pytest.mark.slow
def test_a_misprint_of_each_form_and_of_each_kind_is_refuted() -> None:
    counts: Counter[str] = Counter()
    for form in QUICK_FORMS:
        mutant = min(_first_ones(form), key=lambda mutant: counts[_kind(mutant)])
        counts[_kind(mutant)] += 1
        assert _refuted(form, mutant), mutant.description
    assert counts.keys() == set(KINDS)


@pytest.mark.slow
@pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
def test_misprints_of_every_form_are_refuted(form: ClosedForm) -> None:
    """Tests all mutants of a short form, and about `MOST`, evenly spaced, of a longer one."""
    wrong = [*_wrong(form)]
    some = wrong[:: max(1, len(wrong) // MOST)]
    passed = [m for m in some if not _refuted(form, m)]
    assert [m.description for m in passed if not _is_a_solution(form, m)] == []


def test_elliptic_forms_have_every_kind_of_mutant() -> None:
    form = next(form for form in CATALOGUE if form.name == "soliton_dn")
    assert {_kind(mutant) for mutant in mutants(form.expression)} >= set(KINDS[:4])


def test_mutants_are_distinct_and_differ_from_the_original() -> None:
    for form in CATALOGUE[:3]:
        expressions = [mutant.expression for mutant in mutants(form.expression)]
        assert len(set(expressions)) == len(expressions)
        assert form.expression not in expressions


def test_a_subexpression_changes_wherever_it_stands() -> None:
    phase = xi - 2 * tau
    expression = sp.sin(phase) / (2 + sp.cos(phase))
    flipped = sp.sin(xi + 2 * tau) / (2 + sp.cos(xi + 2 * tau))
    assert flipped in [mutant.expression for mutant in mutants(expression)]


def test_modulus_and_parameter_are_swapped_both_ways() -> None:
    expression = k * jacobi_dn(xi, k**2)
    expressions = [mutant.expression for mutant in mutants(expression)]
    assert k * jacobi_dn(xi, k) in expressions
    assert k**2 * jacobi_dn(xi, k**2) in expressions

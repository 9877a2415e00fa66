"""Prove and check, by name, the catalogue's closed forms and higher rational orders.

A form is proved in the variables of its normal form; NLS is taken as its complex equation.  Forms
of mKdV are proved in the lab variables X, T with symbolic constants, parametrised without square
roots.  The normal form has ``xi = a X``, ``tau = b T`` with square roots of K2 and K4 in a and b.
In the generators c > 0 and a > 0 everything is rational: K2, K4 of fixed sign and b follow from the
derivation's record, and (K2, |K4|) <-> (c, a) is one to one.  An identity in X, T, a, c therefore
holds for all X, T, K2 > 0 and K4 of that sign.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from longwave.derive import mkdv_normal_form, mkdv_reduction
from longwave.derive.symbols import K2, K4, T, X, c
from longwave.solutions.catalogue import CATALOGUE, closed_form
from longwave.solutions.forms.rational import rational
from longwave.solutions.forms.tau_polynomials import rational_tau
from longwave.solutions.record import ClosedForm
from longwave.support.user_files import shown
from longwave.verify.kernel import CertificateError
from longwave.verify.kernel import check_certificate as check_content
from longwave.verify.verdict import ProofVerdict, timed

from .certificate import statement_texts
from .certificate_writer import as_data
from .domains import Domain
from .problem import Problem, equality_problem, solution_problem
from .prover import decide
from .rational_proofs import prove_rational, rational_texts
from .statement_problem import statement_problem
from .typed_statement import Statement, StatementTexts


@timed
def prove_form(form: ClosedForm) -> ProofVerdict:
    """Decide whether ``form`` solves its equation; mKdV in X, T with symbolic K2 > 0 and K4.

    >>> from longwave.solutions import closed_form
    >>> prove_form(closed_form("kink")).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    _check_form(form)
    return decide(_problems(form)[0](form))


def _problems(form: ClosedForm) -> Sequence[Callable[[ClosedForm], Problem]]:
    """Return functions that build problems of ``form``: first the one to prove, then the others."""
    return (lab_problem, own_problem) if form.equation.normal == "mKdV" else (own_problem,)


def lab_problem(form: ClosedForm) -> Problem:
    """Return the problem to prove that an mKdV ``form`` solves the equation in lab variables."""
    frame = lab_frame(form.equation.s)
    return solution_problem(
        frame.residual(sp.Function("U")(X, T)),
        form.expression.xreplace({form.equation.xi: frame.xi, form.equation.tau: frame.tau}),
        name=form.name,
        equation_name=f"mKdV in X, T, K4 {'>' if frame.s > 0 else '<'} 0",
        stated=form_domains(form),
    )


def own_problem(form: ClosedForm) -> Problem:
    """Return the problem to prove that ``form`` solves its equation, in its own variables."""
    equation, domains = form.equation, form_domains(form)
    unknown = sp.Function("U")(*equation.variables)
    left = equation.residual(unknown)
    if not equation.is_complex:
        return solution_problem(
            left, form.expression, name=form.name, equation_name=equation.name, stated=domains
        )
    statement = Statement(form.name, (left,), {unknown: form.expression}, domains)
    return replace(statement_problem(statement, left), equation_name=equation.name)


@timed
def prove_stable(form: ClosedForm) -> ProofVerdict:
    """Decide whether the evaluation form of ``form`` is the same function as its canonical one.

    >>> from longwave.solutions import closed_form
    >>> prove_stable(closed_form("rational_2")).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    return decide(stable_problem(form))


def stable_problem(form: ClosedForm) -> Problem:
    """Return the problem to prove that the evaluation form of ``form`` equals its canonical one."""
    return equality_problem(
        form.expression, form.stable, form.equation.variables, form.name,
        "stable form = canonical form", form_domains(form),
    )  # fmt: skip


def _check_form(form: object) -> None:
    if not isinstance(form, ClosedForm):
        got = f"{shown(form)} (solutions.closed_form('kink'))"
        raise TypeError(f"form must be a ClosedForm, got {got}")


def form_domains(form: ClosedForm) -> dict[sp.Symbol, Domain]:
    """Return the domains of a closed form's parameters; raises TypeError for anything else.

    >>> from longwave.solutions import closed_form
    >>> {str(s): d.text(s) for s, d in form_domains(closed_form("wave_cn")).items()}
    {'k': '0 < k < 1'}
    """
    _check_form(form)
    domains = {}
    for parameter in form.parameters:
        low, high = parameter.lower, parameter.upper
        values = -sp.oo if low is None else low.value, sp.oo if high is None else high.value
        opens = low is None or low.is_open, high is None or high.is_open
        domains[parameter.symbol] = Domain(*values, *opens)
    return domains


def check_certificate(data: Any) -> str:
    """Repeat the proof in ``data`` and return its statement in words.

    Raises CertificateError also if a name of the catalogue stands for another statement.
    """
    statement = check_content(data)
    name = data["name"]
    try:
        form = closed_form(name)
    except ValueError:
        return statement
    if not any(data["statement"] == as_data(texts) for texts in _named(form)):
        raise CertificateError(f"{name} is a closed form of the catalogue, and not the one stated")
    return statement


def _named(form: ClosedForm) -> Iterator[StatementTexts]:
    """Yield the statements that a certificate may make under the name of ``form``."""
    family = form.name.removeprefix("rational_")
    if family.isdigit() and form not in CATALOGUE:
        tau = rational_tau(int(family))
        yield rational_texts(int(family), tau.A, tau.B)
    for build in (*_problems(form), stable_problem):
        yield statement_texts(build(form))


a = sp.Symbol("a", positive=True)


@dataclass(frozen=True)
class LabFrame:
    """Reduced equation with K4 of sign ``s``; K2, K4, xi and tau are rational in X, T, a and c."""

    s: int
    K2: sp.Expr
    K4: sp.Expr
    xi: sp.Expr
    tau: sp.Expr

    def constants(self) -> dict[sp.Symbol, sp.Expr]:
        """Return the lattice constants K2 and K4 in terms of the generators a and c."""
        return {K2: self.K2, K4: self.K4}

    def residual(self, U: sp.Expr) -> sp.Expr:
        """Return the derived left-hand side ``Y_T + beta Y^2 Y_X + delta Y_XXX`` at Y = ``U``."""
        pde, constants = mkdv_reduction().pde, self.constants()
        nonlinear = pde.nonlinear_coefficient.subs(constants)
        dispersive = pde.dispersive_coefficient.subs(constants)
        return sp.diff(U, T) + nonlinear * U**2 * sp.diff(U, X) + dispersive * sp.diff(U, X, 3)


@functools.cache
def lab_frame(s: int) -> LabFrame:
    """Return the frame for K4 of sign ``s`` (+1 or -1), from the normal-form record."""
    magnitude = sp.Symbol("size", positive=True)
    record = mkdv_normal_form(K2, s * magnitude)
    stiffness = sp.solve(record.c**2 - c**2, K2)[0]
    cubic = sp.solve(record.a**2 - a**2, magnitude)[0].subs(K2, stiffness)
    rate = record.b.subs({magnitude: cubic, K2: stiffness})
    return LabFrame(s, stiffness, s * cubic, a * X, rate * T)


HIGHER_ORDERS = range(4, 10)
"""Orders of the rational family that are proved along with the catalogue."""

NAMES = (*CATALOGUE.names, *(f"rational_{order}" for order in HIGHER_ORDERS))
"""Forms that are checked if none is named."""


def higher_order(name: str) -> int | None:
    """Return 7 for "rational_7" and so on, and None for a catalogue name; else raise ValueError.

    >>> higher_order("rational_7"), higher_order("rational_2")
    (7, None)
    """
    member = re.fullmatch(r"rational_([1-9][0-9]?)", name)
    if member is None or int(member[1]) < HIGHER_ORDERS.start:
        closed_form(name)
        return None
    return int(member[1])


def named_form(name: str) -> ClosedForm:
    """Return the closed form ``name``; raises ValueError for an unknown name."""
    order = higher_order(name)
    return closed_form(name) if order is None else rational(order)


def prove_named(name: str) -> ProofVerdict:
    """Return the exact verdict on the form ``name``; raises ValueError for an unknown name.

    >>> print(prove_named("rational_2").outcome, prove_named("rational_4").outcome)
    PROVED PROVED
    """
    order = higher_order(name)
    return prove_form(named_form(name)) if order is None else prove_rational(order)


def prove_all(names: Iterable[str] = NAMES) -> Iterator[ProofVerdict]:
    """Yield the verdicts on the forms called ``names``, each as soon as it is decided."""
    for name in names:
        yield prove_named(name)

"""The catalogue's closed forms: proved in the lab variables, all constants symbolic."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

from solutions.catalogue import CATALOGUE, closed_form
from solutions.forms.rational import rational_tau
from solutions.record import ClosedForm

from .certificate import equality_certificate, equation_certificate
from .checker import CertificateError, same_statement
from .checker import check_certificate as check_content
from .domain import form_domains
from .draft import Data
from .lab import LabEquation, lab_frame
from .problem import Problem, make_equality, make_problem
from .proof import decide, prove_equal
from .rational_orders import rational_certificate
from .verdict import ProofVerdict


def prove_form(form: ClosedForm) -> ProofVerdict:
    """Decide whether ``form`` solves the reduced equation of X, T, K2 > 0 and K4.

    The canonical expression is taken at ``xi = a X``, ``tau = b T``; K2 and K4 are given by the
    generators of `lab.lab_frame`, one to one.

    >>> from solutions import closed_form
    >>> prove_form(closed_form("kink")).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    start = time.perf_counter()
    return decide(lab_problem(form)).timed(time.perf_counter() - start)


def lab_problem(form: ClosedForm) -> Problem:
    """The statement that ``form`` solves the equation in the lab variables."""
    frame = lab_frame(form.equation.s)
    variables = {form.equation.xi: frame.xi, form.equation.tau: frame.tau}
    expression = form.expression.xreplace(variables)
    return make_problem(LabEquation(frame), expression, (), form.name, form_domains(form))


def prove_stable(form: ClosedForm) -> ProofVerdict:
    """Decide whether the evaluation form of ``form`` is the same function as its canonical one.

    >>> from solutions import closed_form
    >>> prove_stable(closed_form("rational_2")).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    return prove_equal(
        form.expression,
        form.stable,
        (form.equation.xi, form.equation.tau),
        name=form.name,
        equation_name="stable form = canonical form",
        domains=form_domains(form),
    )


def check_certificate(data: Any) -> str:
    """Repeat the proof in ``data`` and return its statement in words.

    Raises CertificateError if the proof fails, or if it has the name of a closed form and states
    something else.
    """
    statement = check_content(data)
    name = data["name"]
    try:
        form = closed_form(name)
    except ValueError:
        return statement
    if not any(same_statement(data, other) for other in _named(form)):
        raise CertificateError(f"{name} is a closed form of the catalogue, and not the one stated")
    return statement


def _named(form: ClosedForm) -> Iterator[Data]:
    """What a certificate with the name of ``form`` may state."""
    family = form.name.removeprefix("rational_")
    if family.isdigit() and form not in CATALOGUE:
        tau = rational_tau(int(family))
        yield rational_certificate(int(family), tau.A, tau.B)
    yield equation_certificate(lab_problem(form))
    domains, variables = form_domains(form), (form.equation.xi, form.equation.tau)
    own = make_problem(form.equation, form.expression, (), form.name, domains)
    yield equation_certificate(own)
    names = (form.name, "stable form = canonical form")
    equality = make_equality(form.expression, form.stable, (), names, domains)
    yield equality_certificate(equality, form.expression, form.stable, variables)

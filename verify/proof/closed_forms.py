"""The catalogue's closed forms: proved in the lab variables, all constants symbolic."""

from __future__ import annotations

from solutions.closed_form import ClosedForm

from .domain import form_domains
from .lab import LabEquation, lab_frame
from .proof import prove, prove_equal
from .verdict import ProofVerdict


def prove_form(form: ClosedForm) -> ProofVerdict:
    """Decide whether ``form`` solves the reduced equation of X, T, K2 > 0 and K4.

    The canonical expression is taken at ``xi = a X``, ``tau = b T``; K2 and K4 are given by the
    generators of `lab.lab_frame`, one to one.

    >>> from solutions import closed_form
    >>> prove_form(closed_form("kink")).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    frame = lab_frame(form.equation.s)
    equation = LabEquation(frame)
    variables = {form.equation.xi: frame.xi, form.equation.tau: frame.tau}
    return prove(
        equation,
        form.expression.xreplace(variables),
        name=form.name,
        domains=form_domains(form),
    )


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

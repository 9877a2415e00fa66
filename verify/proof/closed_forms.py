"""The catalogue's closed forms: proved in the lab variables, all constants symbolic."""

from __future__ import annotations

import random

import sympy as sp

from solutions.closed_form import ClosedForm
from verify.sampling import sample_points

from .balls import Point
from .lab import LabEquation, lab_frame
from .proof import prove, prove_equal
from .verdict import ProofVerdict

POINTS = 4
DENOMINATOR = 1009


def prove_form(form: ClosedForm, *, certify: bool = False) -> ProofVerdict:
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
        points=_lab_points(form, (equation.xi, equation.tau, *frame.generators)),
        certify=certify,
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
        points=sample_points(form, POINTS, 0),
    )


def _lab_points(form: ClosedForm, symbols: tuple[sp.Symbol, ...]) -> list[Point]:
    """The form's own sample points, with X, T and the generators of K2, K4 between 1/2 and 3/2."""
    draw = random.Random(form.name)
    return [
        {**point, **{symbol: _number(draw) for symbol in symbols}}
        for point in sample_points(form, POINTS, 0)
    ]


def _number(draw: random.Random) -> sp.Rational:
    return sp.Rational(1, 2) + sp.Rational(draw.randint(1, DENOMINATOR - 1), DENOMINATOR)

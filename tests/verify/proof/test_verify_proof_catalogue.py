"""Every closed form of the catalogue, proved for all parameters at once."""

import json

import pytest
import sympy as sp
from flint import ctx
from mpmath import MPContext

from solutions import CATALOGUE, ClosedForm
from solutions.special.mp import mp_module
from solutions.straight_line import StraightLine
from verify.proof import check_certificate, form_domains, prove, prove_form, prove_stable
from verify.proof.compilation import compile_expressions, generator_balls, polynomial_ball
from verify.proof.signs import Signs
from verify.sampling import Point, sample_points
from verify.verdict import Outcome

ALL = pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
TOLERANCE = 1e-48


@ALL
def test_every_form_is_proved_with_a_certificate(form: ClosedForm) -> None:
    domains = form_domains(form)
    verdict = prove(form.equation, form.expression, name=form.name, domains=domains)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
    assert verdict.certificate is not None
    assert verdict.assumptions


@ALL
def test_every_form_is_proved_in_lab_variables_with_symbolic_constants(form: ClosedForm) -> None:
    verdict = prove_form(form)
    assert verdict.outcome is Outcome.PROVED, verdict.detail
    assert verdict.certificate is not None
    check_certificate(json.loads(json.dumps(verdict.certificate)))


@ALL
def test_the_image_is_the_expression_to_fifty_digits(form: ClosedForm) -> None:
    (point,) = sample_points(form, 1, 5)
    variables = (form.equation.xi, form.equation.tau)
    compiled = compile_expressions(
        [form.expression], [], variables, point, Signs(form_domains(form))
    )
    with ctx.workprec(400):
        values = generator_balls(compiled.field, point)
        image = polynomial_ball(compiled.elements[0].numerator, values)
        image /= polynomial_ball(compiled.elements[0].denominator(), values)
        written = sp.N(image.real.mid().str(60, radius=False), 60)
    expected = _at_sixty_digits(form.expression, point)
    assert abs(written - expected) < TOLERANCE * max(1, abs(expected))


def _at_sixty_digits(expression: sp.Expr, point: Point) -> sp.Float:
    """The value by mpmath, not by the prover's balls."""
    context = MPContext()
    context.dps = 60
    tape = StraightLine()
    entry = tape.record(expression)
    symbols = sorted(expression.free_symbols, key=str)
    evaluate = tape.compile(symbols, [entry], mp_module(context))
    (value,) = evaluate(*(context.mpf(int(point[s].p)) / int(point[s].q) for s in symbols))
    return sp.Float(context.nstr(context.re(value), 60), 60)


@ALL
def test_the_stable_form_is_the_canonical_form(form: ClosedForm) -> None:
    verdict = prove_stable(form)
    assert verdict.outcome is Outcome.PROVED, verdict.detail

"""Formulas as elements of a differential field made for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp
from flint import acb, ctx, fmpq_mpoly

from solutions.special import jacobi_epsilon, jacobi_sn, jacobi_zeta
from verify.tree import distinct_nodes, replaced

from .algebra import DifferentialField
from .balls import BallEvaluator, Point
from .dependence import Dependence
from .fraction import Fraction
from .jet import Shape
from .linear import LinearForms, MissingForm, linear_forms
from .rewriting import Rewriting
from .signs import Signs
from .table import TABLE
from .translation import Translation

BITS = 320
GATHERINGS = 6
"""How often a linear form that slopes or arguments bring is added before all are given up."""


@dataclass(frozen=True)
class Compilation:
    """``elements[i]`` is the image of ``expressions[i]`` in ``field``."""

    field: DifferentialField
    expressions: tuple[sp.Expr, ...]
    elements: tuple[Fraction, ...]


def compile_expressions(
    expressions: Sequence[sp.Expr],
    coefficients: Sequence[sp.Expr],
    variables: Sequence[sp.Symbol],
    point: Point,
    signs: Signs,
) -> Compilation:
    """The images of ``expressions`` in a field that also contains ``coefficients``.

    ``signs`` says what may be simplified; ``point`` is one of their domains.  Raises Unsupported
    for a function without an entry in the table of generators, and ZeroDivisionError if a
    denominator vanishes identically.
    """
    dependence = Dependence(variables)
    rewriting = Rewriting(signs)
    written = _with_one_integral([rewriting(e) for e in expressions], dependence)
    known = [rewriting(coefficient) for coefficient in coefficients]
    found = linear_forms([*written, *known], dependence)
    for _ in range(GATHERINGS):
        forms = LinearForms(found, point)
        try:
            return _compile(written, known, variables, rewriting, forms)
        except MissingForm as missing:
            found = [*found, missing.form]
        except _InconsistentForms:
            break
    return _compile(written, known, variables, rewriting, None)


def _with_one_integral(expressions: Sequence[sp.Expr], dependence: Dependence) -> list[sp.Expr]:
    """Epsilon without shifts, by its addition theorem, and zeta(z) = epsilon(z) - z E/K.

    Without epsilon, zeta stays.
    """
    nodes = {expression: distinct_nodes(expression) for expression in expressions}
    if not any(isinstance(node, jacobi_epsilon) for found in nodes.values() for node in found):
        return list(expressions)

    def epsilon(z: sp.Expr, m: sp.Expr) -> sp.Expr:
        shift, variable = dependence.summands(sp.expand(z))
        total = jacobi_epsilon(variable, m) + jacobi_epsilon(shift, m)
        return total - m * sp.Mul(*(jacobi_sn(u, m) for u in (variable, shift, z)))

    def zeta(z: sp.Expr, m: sp.Expr) -> sp.Expr:
        return epsilon(z, m) - z * sp.elliptic_e(m) / sp.elliptic_k(m)

    def with_one_integral(expression: sp.Expr) -> sp.Expr:
        for kind, image in ((jacobi_epsilon, epsilon), (jacobi_zeta, zeta)):
            for node in nodes[expression]:
                if isinstance(node, kind):
                    images[expression] = replaced(images[expression], node, image(*node.args))
        return images[expression]

    images = {expression: expression for expression in expressions}
    return [with_one_integral(expression) for expression in expressions]


class _InconsistentForms(Exception):
    """Linear forms that look dependent at the point are not."""


def _compile(
    expressions: Sequence[sp.Expr],
    coefficients: Sequence[sp.Expr],
    variables: Sequence[sp.Symbol],
    rewriting: Rewriting,
    forms: LinearForms | None,
) -> Compilation:
    translation = Translation([*expressions, *coefficients], variables, TABLE, rewriting, forms)
    images = [translation.image(expression) for expression in expressions]
    for coefficient in coefficients:
        translation.image(coefficient)
    obligations = [translation.image(o) for o in forms.obligations] if forms else []
    field = DifferentialField(translation)
    if not all(field.fraction(obligation).is_zero for obligation in obligations):
        raise _InconsistentForms
    return Compilation(field, tuple(expressions), tuple(field.fraction(image) for image in images))


def generator_balls(
    field: DifferentialField, point: Point, parts: Mapping[sp.Expr, sp.Expr] | None = None
) -> list[acb]:
    """The values of the generators at a point; the precision is python-flint's.

    ``parts`` says what the symbols stand for that are neither variables nor parameters.
    """
    evaluator = BallEvaluator(Shape([(0,)]), (), point)
    meanings = (generator.meaning.xreplace(parts or {}) for generator in field.generators)
    return [evaluator.jet(meaning).value for meaning in meanings]


def polynomial_ball(polynomial: fmpq_mpoly, values: Sequence[acb]) -> acb:
    """``polynomial`` at ``values``, given in the order of the field's generators."""
    powers = [
        [value**exponent for exponent in range(int(degree) + 1)]
        for value, degree in zip(reversed(values), polynomial.degrees(), strict=True)
    ]
    total = acb(0)
    for exponents, coefficient in polynomial.terms():
        term = acb(coefficient)
        for power, exponent in zip(powers, exponents, strict=True):
            if exponent:
                term *= power[exponent]
        total += term
    return total


def regular_point(
    field: DifferentialField,
    points: Sequence[Point],
    parts: Mapping[sp.Expr, sp.Expr] | None = None,
) -> Point | None:
    """A point where no denominator of the field vanishes, as balls show; None if none is found."""
    with ctx.workprec(BITS):
        for point in points:
            try:
                values = generator_balls(field, point, parts)
            except ValueError:
                continue
            balls = [polynomial_ball(factor, values) for factor in field.ring.factors]
            if all(ball.is_finite() and not ball.contains(0) for ball in balls):
                return point
    return None

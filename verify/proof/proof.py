"""The prover: PROVED, REFUTED or UNDECIDED, and never one for another."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import sympy as sp

from verify.terms import FieldEquation
from verify.verdict import Outcome

from .assumptions import assumptions
from .balls import Point
from .certificate import make_certificate
from .compilation import Compilation, compile_expressions, regular_point
from .jets import EquationImage, coefficients
from .lemmas import equal_by_lemmas
from .problem import Problem, Stated, make_equality, make_problem
from .signs import Signs
from .verdict import METHOD, ProofVerdict
from .witness import QUICK_BITS, Witness, find_difference, find_witness

NO_REGULAR_POINT = "no point was found at which every denominator is shown not to vanish"


def prove(
    equation: FieldEquation | sp.Expr,
    expression: sp.Expr,
    *,
    name: str = "expression",
    points: Sequence[Point] = (),
    domains: Stated | None = None,
    certify: bool = False,
) -> ProofVerdict:
    """Decide whether ``expression`` solves ``equation`` on the whole of its domains.

    ``equation`` is an object with a residual (as `solutions.equation.Equation`) or the left-hand
    side of an equation "= 0", a polynomial in one undefined function and its derivatives.
    ``domains`` states intervals (`domain.Domain` or `sympy.Interval`) of variables and parameters
    beyond what SymPy's assumptions say; a symbol without either is real.  ``points`` are rational
    points of the domains to look for a witness at, besides sampled ones.  With ``certify``, a
    proof carries a certificate for `checker.check_certificate`.

    Raises ValueError for an equation without exactly one unknown function, for domains that are
    none and for points outside them.

    >>> x, t, c = sp.symbols("x t c")
    >>> u = sp.Function("u")(x, t)
    >>> transport = u.diff(t) + c * u.diff(x)
    >>> prove(transport, sp.sin(x - c * t)).outcome
    <Outcome.PROVED: 'PROVED'>
    >>> prove(transport, sp.sin(x + c * t)).outcome
    <Outcome.REFUTED: 'REFUTED'>
    """
    start = time.perf_counter()
    problem = make_problem(equation, expression, points, name, domains or {})
    return _decide(problem, certify).timed(time.perf_counter() - start)


def prove_equal(
    left: sp.Expr,
    right: sp.Expr,
    variables: Sequence[sp.Symbol],
    *,
    name: str = "expressions",
    equation_name: str = "equality",
    points: Sequence[Point] = (),
    domains: Stated | None = None,
) -> ProofVerdict:
    """Decide whether two formulas are the same function of ``variables`` and all parameters.

    ``domains`` and ``points`` are those of `prove`.

    >>> x = sp.Symbol("x")
    >>> prove_equal(sp.tanh(x) ** 2, 1 - sp.sech(x) ** 2, [x]).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    start = time.perf_counter()
    problem = make_equality(left, right, points, (name, equation_name), domains or {})
    return _decide_equal(problem, left, right, variables).timed(time.perf_counter() - start)


def _decide(problem: Problem, certify: bool) -> ProofVerdict:
    witness = find_witness(problem, QUICK_BITS)
    if witness is not None:
        return _refuted(problem, witness)
    known = coefficients(problem.left, problem.unknown)
    signs, point = Signs(problem.domains), problem.points[0]
    try:
        compiled = compile_expressions([problem.expression], known, problem.variables, point, signs)
        image = EquationImage(compiled.field, problem.unknown, compiled.elements[0])
        residual = image.residual(problem.left)
    except (ValueError, ZeroDivisionError) as error:
        return _undecided(problem, str(error))
    if residual.is_zero:
        return _proved(problem, compiled, certify)
    witness = find_witness(problem)
    if witness is not None:
        return _refuted(problem, witness)
    return _undecided(problem, f"{len(residual.numerator)} terms are left of the numerator")


def _decide_equal(
    problem: Problem, left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol]
) -> ProofVerdict:
    witness = find_difference(problem.expression, problem.points, QUICK_BITS)
    if witness is not None:
        return _refuted(problem, witness)
    signs, point = Signs(problem.domains), problem.points[0]
    try:
        by_parts = equal_by_lemmas(left, right, variables, point, signs)
        if by_parts is not None:
            return _proved(problem, by_parts[0], certify=False, parts=by_parts[1])
        compiled = compile_expressions([left, right], [], variables, point, signs)
        difference = compiled.elements[0] - compiled.elements[1]
    except (ValueError, ZeroDivisionError) as error:
        return _undecided(problem, str(error))
    if difference.is_zero:
        return _proved(problem, compiled, certify=False)
    witness = find_difference(problem.expression, problem.points)
    if witness is not None:
        return _refuted(problem, witness)
    return _undecided(problem, f"{len(difference.numerator)} terms are left of the difference")


def _proved(
    problem: Problem,
    compiled: Compilation,
    certify: bool,
    parts: Mapping[sp.Expr, sp.Expr] | None = None,
) -> ProofVerdict:
    point = regular_point(compiled.field, problem.points, parts)
    if point is None:
        return _undecided(problem, NO_REGULAR_POINT)
    detail = f"numerator 0 in {len(compiled.field.generators)} generators, all parameters symbolic"
    return ProofVerdict(
        problem.name,
        problem.equation_name,
        METHOD,
        Outcome.PROVED,
        detail,
        residual=0.0,
        assumptions=assumptions(compiled, point),
        certificate=make_certificate(problem, compiled, point) if certify else None,
    )


def _refuted(problem: Problem, witness: Witness) -> ProofVerdict:
    return ProofVerdict(
        problem.name,
        problem.equation_name,
        METHOD,
        Outcome.REFUTED,
        witness.text(),
        witness=witness.coordinates(),
    )


def _undecided(problem: Problem, reason: str) -> ProofVerdict:
    return ProofVerdict(problem.name, problem.equation_name, METHOD, Outcome.UNDECIDED, reason)

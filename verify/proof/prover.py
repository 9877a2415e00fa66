"""The prover; its verdicts are PROVED, REFUTED or UNDECIDED.

A witness against a formula is a point at which ball arithmetic shows that its residual is not 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import sympy as sp

from longwave.solutions.equation import Equation
from longwave.verify.kernel import check_certificate
from longwave.verify.verdict import Outcome, ProofVerdict, on_each_side, timed

from .certificate import equal_parts, make_certificate
from .certificate_writer import Certificate
from .domain_signs import DomainSigns, corners, singularities
from .domains import Point
from .problem import Problem, Stated, equality_problem, solution_problem

METHOD = "differential algebra"

QUICK_BITS = (160,)
LONG_BITS = (2560,)
BITS = (160, 640, 2560)
HIGH_BITS, HIGH_BITS_POINTS = 640, 8
"""Above ``HIGH_BITS`` bits a residual is evaluated at no more than ``HIGH_BITS_POINTS`` points."""

SHOWN_DIGITS = 6


@timed
def prove(
    equation: Equation | sp.Expr,
    expression: sp.Expr,
    *,
    name: str = "expression",
    domains: Stated | None = None,
) -> ProofVerdict:
    """Decide whether ``expression`` solves ``equation`` on the whole of its domains.

    ``equation`` is an object with a residual (as `solutions.record.Equation`) or the left-hand
    side of an equation "= 0", a polynomial in one undefined function and its derivatives.
    ``domains`` states intervals (`domains.Domain` or `sympy.Interval`) of variables and parameters
    beyond what SymPy's assumptions say; a symbol without either is real.  PROVED means that
    `verify.kernel.check_certificate` has accepted the certificate that the verdict carries.

    Raises ValueError for an equation without exactly one unknown function, and for invalid domains.

    >>> x, t, c = sp.symbols("x t c")
    >>> u = sp.Function("u")(x, t)
    >>> transport = u.diff(t) + c * u.diff(x)
    >>> prove(transport, sp.sin(x - c * t)).outcome
    <Outcome.PROVED: 'PROVED'>
    >>> prove(transport, sp.sin(x + c * t)).outcome
    <Outcome.REFUTED: 'REFUTED'>
    """
    return decide(solution_problem(equation, expression, name, stated=domains))


@timed
def prove_equal(
    left: sp.Expr,
    right: sp.Expr,
    variables: Sequence[sp.Symbol],
    *,
    name: str = "expressions",
    equation_name: str = "equality",
    domains: Stated | None = None,
) -> ProofVerdict:
    """Decide whether two formulas are the same function; ``domains`` are as in `prove`.

    >>> x = sp.Symbol("x")
    >>> prove_equal(sp.tanh(x) ** 2, 1 - sp.sech(x) ** 2, [x]).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    return decide(equality_problem(left, right, variables, name, equation_name, domains))


def decide(problem: Problem) -> ProofVerdict:
    """Return the verdict on a problem; PROVED only if the checker accepts its certificate."""
    witness = find_witness(problem, problem.points, QUICK_BITS)
    witness = witness or find_witness(problem, problem.points[:1], LONG_BITS)
    if witness is None:
        try:
            return _proved(problem)
        except (ValueError, RecursionError) as error:
            reason = str(error)
        witness = find_witness(problem, [*problem.points, *problem.more_points()])
        if witness is None:
            return _verdict(problem, Outcome.UNDECIDED, reason)
    point, detail = witness
    coordinates = {str(symbol): str(value) for symbol, value in point.items()}
    return _verdict(problem, Outcome.REFUTED, detail, witness=coordinates)


def find_witness(
    problem: Problem, points: Sequence[Point], bits: Sequence[int] = BITS
) -> tuple[Point, str] | None:
    """Return a point at which the residual's ball excludes 0, and the ball in words, or None."""
    signs = DomainSigns(problem.domains)
    for precision in bits:
        for point in points[:HIGH_BITS_POINTS] if precision > HIGH_BITS else points:
            try:
                ball = problem.residual(point, precision, signs)
            except (ValueError, ZeroDivisionError, RecursionError):
                continue
            if ball.is_finite() and not ball.contains(0):
                return point, f"residual {ball.str(SHOWN_DIGITS)} excludes 0"
    return None


def _proved(problem: Problem) -> ProofVerdict:
    """Return an accepted proof, by equal parts first; raises ValueError if no attempt succeeds."""
    reason = ValueError("there is no proof")
    for parts in equal_parts(problem):
        try:
            return accepted(problem, make_certificate(problem, parts))
        except ValueError as error:
            reason = error
    raise reason


def accepted(problem: Problem, certificate: Certificate) -> ProofVerdict:
    """Return the verdict PROVED; raises CertificateError if the checker rejects the certificate."""
    statement = check_certificate(certificate)
    places = singularities(problem.expressions, problem.domains)
    return _verdict(
        problem,
        Outcome.PROVED,
        f"numerator 0 in {certificate.generators} generators, accepted by the checker",
        residual=0.0,
        assumptions=(
            statement.splitlines()[-1],
            f"no denominator vanishes identically: see {certificate.point}",
            *(f"holds where the formula is smooth, possibly not so: {line}" for line in places),
        ),
        singularities=places,
        certificate=certificate,
        sides=on_each_side(corners(problem.expressions, problem.domains, problem.variables)),
    )


def _verdict(problem: Problem, outcome: Outcome, detail: str, **fields: Any) -> ProofVerdict:
    name, equation = problem.name, problem.equation_name
    return ProofVerdict(name, equation, METHOD, outcome, detail, **fields)

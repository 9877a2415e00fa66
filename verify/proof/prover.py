"""The prover: PROVED, REFUTED or UNDECIDED, and never one for another.

A witness against a formula is a point at which ball arithmetic shows that its residual is not 0.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import sympy as sp
from flint import acb

from verify.terms import FieldEquation
from verify.verdict import Outcome, ProofVerdict

from .balls import ball_value, residual_ball
from .certificate import (
    equality_certificate,
    equation_certificate,
    find_lemmas,
    generator_count,
    point_text,
    regular_point,
)
from .certificate_writer import Data
from .checker import check_certificate
from .domain_signs import Signs, singularities
from .domains import Point
from .problem import (
    Problem,
    Stated,
    coefficients,
    formula,
    make_equality,
    make_problem,
    more_points,
    real_symbols,
)

METHOD = "differential algebra"


def prove(
    equation: FieldEquation | sp.Expr,
    expression: sp.Expr,
    *,
    name: str = "expression",
    points: Sequence[Point] = (),
    domains: Stated | None = None,
) -> ProofVerdict:
    """Decide whether ``expression`` solves ``equation`` on the whole of its domains.

    ``equation`` is an object with a residual (as `solutions.record.Equation`) or the left-hand
    side of an equation "= 0", a polynomial in one undefined function and its derivatives.
    ``domains`` states intervals (`domain.Domain` or `sympy.Interval`) of variables and parameters
    beyond what SymPy's assumptions say; a symbol without either is real.  ``points`` are rational
    points of the domains to look for a witness at, besides sampled ones.  PROVED means that
    `checker.check_certificate` has accepted the certificate that the verdict carries.

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
    return decide(problem).timed(time.perf_counter() - start)


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
    left, right = formula("left", left), formula("right", right)
    real = real_symbols(left.free_symbols | right.free_symbols | set(variables))
    left, right = left.xreplace(real), right.xreplace(real)
    variables = [real.get(variable, variable) for variable in variables]
    problem = make_equality(left, right, points, (name, equation_name), domains or {})
    verdict = _decide_equal(problem, left, right, variables)
    verdict = _with_singularities(verdict, [left, right], problem)
    return verdict.timed(time.perf_counter() - start)


def decide(problem: Problem) -> ProofVerdict:
    """The verdict on a problem; PROVED only if the checker accepts its certificate."""
    found = [problem.expression, *coefficients(problem.left, problem.unknown)]
    return _with_singularities(_decide(problem), found, problem)


def _with_singularities(
    verdict: ProofVerdict, expressions: Sequence[sp.Expr], problem: Problem
) -> ProofVerdict:
    """A proof with what it does not speak of: where ``expressions`` may fail to be smooth."""
    if verdict.outcome is not Outcome.PROVED:
        return verdict
    found = singularities(expressions, problem.domains)
    lines = tuple(f"holds where the formula is smooth, possibly not so: {line}" for line in found)
    return replace(verdict, singularities=found, assumptions=(*verdict.assumptions, *lines))


def _first_look(problem: Problem) -> Witness | None:
    """A witness that costs less than a proof: all points coarsely, one to many digits."""
    found = find_witness(problem, problem.points, QUICK_BITS)
    return found or find_witness(problem, problem.points[:1], LONG_BITS)


def _decide(problem: Problem) -> ProofVerdict:
    witness = _first_look(problem)
    if witness is not None:
        return _refuted(problem, witness)
    try:
        return proved(problem.equation_name, METHOD, equation_certificate(problem))
    except (ValueError, RecursionError) as error:
        witness = find_witness(problem, [*problem.points, *more_points(problem)])
        return _refuted(problem, witness) if witness else _undecided(problem, str(error))


def _decide_equal(
    problem: Problem, left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol]
) -> ProofVerdict:
    witness = _first_look(problem)
    if witness is not None:
        return _refuted(problem, witness)
    try:
        return _proved_equal(problem, left, right, variables)
    except (ValueError, RecursionError) as error:
        reason = str(error)
    witness = find_witness(problem, [*problem.points, *more_points(problem)])
    return _refuted(problem, witness) if witness else _undecided(problem, reason)


def _proved_equal(
    problem: Problem, left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol]
) -> ProofVerdict:
    """The proof by equal parts, or else at once; raises ValueError if neither is accepted."""
    reason = ValueError("there is no proof")
    for parts in _partitions(problem, left, right, variables):
        try:
            certificate = equality_certificate(problem, left, right, variables, parts)
            return proved(problem.equation_name, METHOD, certificate)
        except ValueError as error:
            reason = error
    raise reason


def _partitions(
    problem: Problem, left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol]
) -> Iterator[list[tuple[sp.Expr, sp.Expr]]]:
    """Equal parts to prove first, and none."""
    point = regular_point([left, right], problem.points)
    lemmas = find_lemmas(left, right, variables, point)
    if lemmas:
        yield lemmas
    yield []


def proved(equation: str, method: str, certificate: Data) -> ProofVerdict:
    """The verdict PROVED, if the checker accepts ``certificate``.

    Raises CertificateError if it does not.
    """
    statement = check_certificate(certificate)
    *_, reading = statement.splitlines()
    return ProofVerdict(
        certificate["name"],
        equation,
        method,
        Outcome.PROVED,
        f"numerator 0 in {generator_count(certificate)} generators, accepted by the checker",
        residual=0.0,
        assumptions=(
            reading,
            f"no denominator vanishes identically: see {point_text(certificate)}",
        ),
        certificate=certificate,
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


QUICK_BITS = (160,)
LONG_BITS = (2560,)
BITS = (160, 640, 2560)
LONG, LONG_POINTS = 640, 8
"""Beyond so many bits a residual is evaluated at so many points only."""

SHOWN_DIGITS = 6


@dataclass(frozen=True)
class Witness:
    """A point, and the ball of the residual there, which does not contain 0."""

    point: Point
    ball: acb

    def coordinates(self) -> dict[str, str]:
        """The point as text."""
        return {str(symbol): str(value) for symbol, value in self.point.items()}

    def text(self) -> str:
        """The ball on one line."""
        return f"residual {self.ball.str(SHOWN_DIGITS)} excludes 0"


def find_witness(
    problem: Problem, points: Sequence[Point], bits: Sequence[int] = BITS
) -> Witness | None:
    """A witness among ``points`` against the equation, or against the equality of a problem."""
    signs = Signs(problem.domains)
    for precision in bits:
        for point in points[:LONG_POINTS] if precision > LONG else points:
            try:
                ball = _residual(problem, point, precision, signs)
            except (ValueError, ZeroDivisionError, RecursionError):
                continue
            if ball.is_finite() and not ball.contains(0):
                return Witness(point, ball)
    return None


def _residual(problem: Problem, point: Point, bits: int, signs: Signs) -> acb:
    if problem.unknown == 0:
        return ball_value(problem.expression, point, bits, signs)
    left, unknown, expression = problem.left, problem.unknown, problem.expression
    return residual_ball(left, unknown, expression, point, bits, signs)

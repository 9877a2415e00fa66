"""A point at which ball arithmetic shows that a residual is not 0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import acb

from .balls import Point, ball_value, residual_ball
from .domain_signs import Signs
from .problem import Problem

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

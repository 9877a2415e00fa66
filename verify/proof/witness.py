"""A point at which ball arithmetic shows that a residual is not 0."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp
from flint import acb

from .balls import Point, ball_value, residual_ball
from .problem import Problem

QUICK_BITS = (160,)
BITS = (160, 640, 2560)
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


def find_witness(problem: Problem, bits: Sequence[int] = BITS) -> Witness | None:
    """A witness against the equation, if one of the points has one."""
    for precision in bits:
        for point in problem.points:
            try:
                ball = residual_ball(
                    problem.left, problem.unknown, problem.expression, point, precision
                )
            except ValueError:
                continue
            if ball.is_finite() and not ball.contains(0):
                return Witness(point, ball)
    return None


def find_difference(
    difference: sp.Expr, points: Sequence[Point], bits: Sequence[int] = BITS
) -> Witness | None:
    """A witness against ``difference = 0``."""
    for precision in bits:
        for point in points:
            try:
                ball = ball_value(difference, point, precision)
            except ValueError:
                continue
            if ball.is_finite() and not ball.contains(0):
                return Witness(point, ball)
    return None

"""High-precision residual of a closed form, at several precisions and many points.

The residual is taken relative to the sum of the magnitudes of its terms.  At d digits a solution
leaves about 10^-d times the conditioning of the formula at the point, whatever d is; a formula
that is wrong leaves a number that does not depend on d.  This is evidence and never a proof: the
outcome of a solution is CHECKED.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import sympy as sp

from solutions.compile.straight_line import StraightLine, UnknownDerivativeError
from solutions.functions.multiprecision import mp_module
from solutions.record import ClosedForm
from verify.decay import Decay, checked_digits
from verify.sampling import Point, sample_points
from verify.terms import FieldEquation, field_derivatives, residual_terms
from verify.verdict import Outcome, Verdict

DIGITS = (30, 50, 100)
MOST_POINTS = 100_000
POINTS = 24

SETTLED = 0.005
"""A residual whose logarithm moves by less than this when the digits double has settled."""


class EvaluationError(ValueError):
    """The residual has no finite value at a point, or a function in it no implementation."""


@dataclass(frozen=True)
class Sampling:
    """At how many points, from which seed and at which digits a residual is evaluated."""

    digits: tuple[int, ...] = DIGITS
    points: int = POINTS
    seed: int = 0

    def __post_init__(self) -> None:
        checked_digits(self.digits)
        if not 1 <= self.points <= MOST_POINTS:
            raise ValueError(
                f"points must satisfy 1 <= points <= {MOST_POINTS}, got {self.points} (24 is usual)"
            )


class ResidualProgram:
    """The terms of the residual of one expression, differentiated and compiled once.

    ``level(point, digits)`` is the decimal logarithm of the relative residual at an exact point.
    Raises EvaluationError for a function without a known derivative.
    """

    def __init__(self, expression: sp.Expr, equation: FieldEquation) -> None:
        self.symbols = tuple(sorted({equation.xi, equation.tau} | expression.free_symbols, key=str))
        self._context = mpmath.mp.clone()
        tape = StraightLine()
        try:
            entries = _term_entries(tape, expression, equation)
        except UnknownDerivativeError as error:
            raise EvaluationError(str(error)) from error
        self._terms = tape.compile(self.symbols, entries, mp_module(self._context))

    def level(self, point: Point, digits: int) -> float:
        """log10 of |residual| / sum of |terms| at ``point``; -inf if the residual is 0.

        Raises EvaluationError where the value is not finite or cannot be formed.
        """
        context = self._context
        context.dps = digits
        values = [context.mpf(point[s].p) / point[s].q for s in self.symbols]
        try:
            terms = self._terms(*values)
            total, size = abs(context.fsum(terms)), context.fsum(terms, absolute=True)
        except (ArithmeticError, ValueError, TypeError, NameError) as error:
            raise EvaluationError(f"{type(error).__name__}: {error}") from error
        if not context.isfinite(size):
            raise EvaluationError("the residual is not finite")
        return float(context.log10(total / size)) if total else float("-inf")


def _term_entries(
    tape: StraightLine, expression: sp.Expr, equation: FieldEquation
) -> list[sp.Expr]:
    terms, field = residual_terms(equation)
    value = tape.record(expression)
    entries = {}
    for derivative in field_derivatives(terms, field):
        entry = value
        for variable in getattr(derivative, "variables", ()):
            entry = tape.derivative(entry, variable)
        entries[derivative] = entry
    return [tape.record(term.xreplace(entries)) for term in terms]


def check_residual(form: ClosedForm, sampling: Sampling | None = None) -> Verdict:
    """Evaluate the residual of ``form`` at random admissible points; judge how it falls.

    CHECKED if it falls with the digits at all points; REFUTED with the point as witness if it has
    settled at a value other than 0; UNDECIDED with the reason if it cannot be evaluated or does
    neither.
    """
    start = time.perf_counter()
    sampling = sampling or Sampling()
    method = f"residual at {', '.join(map(str, sampling.digits))} digits"
    try:
        findings = _judge(form, sampling)
    except EvaluationError as error:
        findings = {"outcome": Outcome.UNDECIDED, "detail": str(error)}
    seconds = time.perf_counter() - start
    return Verdict(form.name, form.equation.name, method, **findings, seconds=seconds)


def _judge(form: ClosedForm, sampling: Sampling) -> dict[str, Any]:
    program = ResidualProgram(form.expression, form.equation)
    points = sample_points(form, sampling.points, sampling.seed)
    decay, worst = _sweep(program, points, sampling.digits)
    findings = {
        "outcome": Outcome.CHECKED,
        "detail": f"{decay.text()}, {len(points)} points",
        "residual": 10 ** decay.levels[-1],
    }
    if decay.falls():
        return findings
    finer = program.level(worst, 2 * decay.digits[-1])
    if abs(finer - decay.levels[-1]) < SETTLED:
        return findings | {"outcome": Outcome.REFUTED, "witness": _text(worst)}
    reason = f"{decay.text()}: neither falls with the digits nor settles"
    return findings | {"outcome": Outcome.UNDECIDED, "detail": reason}


def _sweep(
    program: ResidualProgram, points: Sequence[Point], digits: Sequence[int]
) -> tuple[Decay, Point]:
    """The decay of the largest residual, and the point where it is largest at the last digits.

    Stops at the first step in precision at which the residual does not fall.
    """
    levels: list[float] = []
    for precision in digits:
        found = [_level_at(program, point, precision) for point in points]
        levels.append(max(found))
        decay = Decay(tuple(digits[: len(levels)]), tuple(levels))
        if not decay.falls():
            break
    return decay, points[found.index(levels[-1])]


def _level_at(program: ResidualProgram, point: Point, digits: int) -> float:
    try:
        return program.level(point, digits)
    except EvaluationError as error:
        place = ", ".join(f"{name} = {value}" for name, value in _text(point).items())
        raise EvaluationError(f"no value at {place} with {digits} digits: {error}") from error


def _text(point: Point) -> dict[str, str]:
    return {str(symbol): str(value) for symbol, value in point.items()}

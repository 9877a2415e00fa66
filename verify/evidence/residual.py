"""High-precision residual of a closed form, at several precisions and many points.

The residual is relative to the sum of the magnitudes of its terms.  At d digits a solution leaves
about 10^-d times the condition number of the formula at the point; a wrong formula leaves a number
that does not depend on d.  This is evidence, not a proof: the outcome of a solution is CHECKED.

The points are random, admissible and exact rationals, the same for the same seed.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import mpmath
import sympy as sp

from longwave.solutions.compile.tape import Tape, UnknownDerivativeError
from longwave.solutions.equation import Equation
from longwave.solutions.record import ClosedForm
from longwave.verify.proof import form_domains
from longwave.verify.proof.domains import Domain, Point, in_order
from longwave.verify.proof.samples import rational_near
from longwave.verify.verdict import Outcome, Verdict, timed

SLACK_DIGITS = 4
"""Digits by which the residual's decay may fall short of the digits gained, for rounding."""

MOST_DIGITS = 10_000
MINIMUM_GAP = 2 * SLACK_DIGITS + 1
"""Smallest difference in digits between two precisions, so that the decay is significant."""


@dataclass(frozen=True)
class Decay:
    """Decimal logarithms (-inf for 0) of the largest relative residual at each of ``digits``."""

    digits: tuple[int, ...]
    levels: tuple[float, ...]

    def falls(self) -> bool:
        """Return whether the residual falls by all digits gained but at most `SLACK_DIGITS`.

        A residual below 10^-d counts as 10^-d.

        >>> Decay((30, 50), (-28.3, -48.1)).falls()
        True
        >>> Decay((30, 50), (-28.3, -31.0)).falls()
        False
        """
        floored = [max(level, -d) for d, level in zip(self.digits, self.levels, strict=True)]
        steps = itertools.pairwise(zip(self.digits, floored, strict=True))
        falls = ((before - after, high - low) for (low, before), (high, after) in steps)
        return all(fall >= digits - SLACK_DIGITS for fall, digits in falls)

    def text(self) -> str:
        """Return the residuals and their digits on one line.

        >>> Decay((30, 50), (-28.3, -48.1)).text()
        '5.0e-29, 7.9e-49 at 30, 50 digits'
        """
        residuals = ", ".join(scientific(level) for level in self.levels)
        return f"{residuals} at {', '.join(map(str, self.digits))} digits"


def scientific(level: float) -> str:
    """Return 10**level with two significant digits, even if it underflows a float.

    >>> scientific(-400.5), scientific(float("-inf"))
    ('3.2e-401', '0')
    """
    if level == float("-inf"):
        return "0"
    exponent = int(level // 1)
    return f"{10 ** (level - exponent):.1f}e{exponent:+03d}"


HALF_WIDTH = 4
"""Variables are drawn between -HALF_WIDTH and HALF_WIDTH.  A parameter's domain without an end is
cut at the distance HALF_WIDTH beyond 0 or beyond its other end."""

DENOMINATOR = 1009
"""Denominator of drawn values; a prime, so that no drawn value is exact in binary."""

MARGIN = sp.Rational(1, 20)
"""Fraction of a parameter's interval that is not drawn, at each end, where forms degenerate."""


def sample_points(form: ClosedForm, count: int, seed: int) -> list[Point]:
    """Draw ``count`` points with parameters in their domains and variables within +-4."""
    draw, domains = random.Random(f"{form.name}:{seed}"), form_domains(form)

    def fraction() -> sp.Rational:
        """Draw a rational strictly between 0 and 1."""
        return sp.Rational(draw.randint(1, DENOMINATOR - 1), DENOMINATOR)

    def point() -> Point:
        values: dict[sp.Symbol, sp.Rational] = {}
        for symbol in in_order(domains):
            low, high = _interval(domains[symbol], values)
            values[symbol] = low + (high - low) * fraction()
        for variable in form.equation.variables:
            values[variable] = HALF_WIDTH * (2 * fraction() - 1)
        for sign in form.equation.free_sign:
            values[sign] = sp.Integer(draw.choice((1, -1)))
        return values

    return [point() for _ in range(count)]


def _interval(domain: Domain, known: Point) -> tuple[sp.Rational, sp.Rational]:
    """Return the ends between which a parameter is drawn: its domain without margins."""
    lower, upper = map(rational_near, domain.ends(known))
    if lower is None:
        lower = min(sp.S.Zero if upper is None else upper, sp.S.Zero) - HALF_WIDTH
    if upper is None:
        upper = max(lower, sp.S.Zero) + HALF_WIDTH
    margin = MARGIN * (upper - lower)
    return lower + margin, upper - margin


DIGITS = (30, 50, 100)
MOST_POINTS = 100_000
POINTS = 24

SETTLED_CHANGE = 0.005
"""A residual has settled if its log10 moves by less than this when the digits double."""


class EvaluationError(ValueError):
    """Raised if the residual has no finite value or contains an unimplemented function."""


@dataclass(frozen=True)
class Sampling:
    """Sampling plan of a residual: digits, number of points, and random seed.

    Raises ValueError for fewer than two precisions, ones too close together, and too many points.
    """

    digits: tuple[int, ...] = DIGITS
    points: int = POINTS
    seed: int = 0

    def __post_init__(self) -> None:
        digits = self.digits
        gaps = [high - low for low, high in itertools.pairwise(digits)]
        if not gaps or digits[0] < 15 or min(gaps) < MINIMUM_GAP or digits[-1] > MOST_DIGITS:
            words = f"two or more numbers from 15 to {MOST_DIGITS}, each at least {MINIMUM_GAP}"
            got = f"{','.join(map(str, digits)) or 'none'} (30,50,100 is usual)"
            raise ValueError(f"digits must be {words} above the one before, got {got}")
        if not 1 <= self.points <= MOST_POINTS:
            words = f"points must satisfy 1 <= points <= {MOST_POINTS}"
            raise ValueError(f"{words}, got {self.points} (24 is usual)")


class ResidualProgram:
    """Compiled terms of a residual; raises EvaluationError for an unknown derivative."""

    def __init__(self, expression: sp.Expr, equation: Equation) -> None:
        symbols = {*equation.variables, *equation.free_sign} | expression.free_symbols
        self.symbols = tuple(sorted(symbols, key=str))
        self._context = mpmath.mp.clone()
        tape = Tape()
        try:
            entries = _term_entries(tape, expression, equation)
        except UnknownDerivativeError as error:
            raise EvaluationError(str(error)) from error
        self._terms = tape.formula(self.symbols, entries)

    def level(self, point: Point, digits: int) -> float:
        """Return log10 of |sum of terms| / sum of |terms|; raises EvaluationError if not finite."""
        context = self._context
        context.dps = digits
        values = [context.mpf(point[s].p) / point[s].q for s in self.symbols]
        try:
            terms = self._terms(context, *values)
            total, magnitude = abs(context.fsum(terms)), context.fsum(terms, absolute=True)
        except (ArithmeticError, ValueError, TypeError, NameError) as error:
            raise EvaluationError(f"{type(error).__name__}: {error}") from error
        if not context.isfinite(magnitude):
            raise EvaluationError("the residual is not finite")
        return float(context.log10(total / magnitude)) if total else float("-inf")


def _term_entries(tape: Tape, expression: sp.Expr, equation: Equation) -> list[sp.Expr]:
    """Record the terms of the expanded residual on the tape, and return their entries."""
    field = sp.Function("U")(*equation.variables)
    residual = sp.expand(equation.residual(field))
    value, entries = tape.record(expression), {}
    for jet in sorted(residual.atoms(sp.Derivative, type(field)), key=sp.default_sort_key):
        entries[jet] = reduce(tape.derivative, getattr(jet, "variables", ()), value)
    return [tape.record(term.xreplace(entries)) for term in sp.Add.make_args(residual)]


@timed
def check_residual(form: ClosedForm, sampling: Sampling | None = None) -> Verdict:
    """Evaluate the residual of ``form`` at random admissible points and judge its decay.

    CHECKED if it falls with the digits, REFUTED if it settles above 0, UNDECIDED otherwise.
    """
    sampling = sampling or Sampling()
    method = f"residual at {', '.join(map(str, sampling.digits))} digits"
    try:
        findings = _judge(form, sampling)
    except EvaluationError as error:
        findings = {"outcome": Outcome.UNDECIDED, "detail": str(error)}
    return Verdict(form.name, form.equation.name, method, **findings)


def _judge(form: ClosedForm, sampling: Sampling) -> dict[str, Any]:
    program = ResidualProgram(form.expression, form.equation)
    points = sample_points(form, sampling.points, sampling.seed)
    decay, worst = _sweep(program, points, sampling.digits)
    detail = f"{decay.text()}, {len(points)} points"
    findings = {"outcome": Outcome.CHECKED, "detail": detail, "residual": 10 ** decay.levels[-1]}
    if decay.falls():
        return findings
    finer = program.level(worst, 2 * decay.digits[-1])
    if abs(finer - decay.levels[-1]) < SETTLED_CHANGE:
        return findings | {"outcome": Outcome.REFUTED, "witness": _text(worst)}
    reason = f"{decay.text()}: neither falls with the digits nor settles"
    return findings | {"outcome": Outcome.UNDECIDED, "detail": reason}


def _sweep(
    program: ResidualProgram, points: Sequence[Point], digits: Sequence[int]
) -> tuple[Decay, Point]:
    """Return the decay up to the first precision that fails, and the worst point there."""
    decay = Decay((), ())
    for precision in digits:
        levels = [_level_at(program, point, precision) for point in points]
        decay = Decay((*decay.digits, precision), (*decay.levels, max(levels)))
        if not decay.falls():
            break
    return decay, points[levels.index(max(levels))]


def _level_at(program: ResidualProgram, point: Point, digits: int) -> float:
    try:
        return program.level(point, digits)
    except EvaluationError as error:
        place = ", ".join(f"{name} = {value}" for name, value in _text(point).items())
        raise EvaluationError(f"no value at {place} with {digits} digits: {error}") from error


def _text(point: Point) -> dict[str, str]:
    return {str(symbol): str(value) for symbol, value in point.items()}

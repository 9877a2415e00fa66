"""High-precision residual of a closed form, at several precisions and many points.

The residual is taken relative to the sum of the magnitudes of its terms.  At d digits a solution
leaves about 10^-d times the conditioning of the formula at the point, whatever d is; a formula
that is wrong leaves a number that does not depend on d.  This is evidence and never a proof: the
outcome of a solution is CHECKED.

The points are random, admissible and exact rationals, the same for the same seed.
"""

from __future__ import annotations

import itertools
import random
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import sympy as sp

from longwave.solutions.compile.tape import Tape, UnknownDerivativeError
from longwave.solutions.equation import Equation
from longwave.solutions.record import ClosedForm
from longwave.verify.proof import form_domains
from longwave.verify.proof.domains import Domain, Point, in_order
from longwave.verify.proof.samples import rational_near
from longwave.verify.verdict import Outcome, Verdict

SLACK_DIGITS = 4
"""Digits by which a fall may miss d2 - d1, for the luck of rounding at the worst point."""

MOST_DIGITS = 10_000
MINIMUM_GAP = 2 * SLACK_DIGITS + 1
"""Smallest distance of two precisions at which the fall still says something."""


@dataclass(frozen=True)
class Decay:
    """Decimal logarithms of the largest relative residual (``levels``) at each of ``digits``.

    A residual of exactly 0 has level -inf.
    """

    digits: tuple[int, ...]
    levels: tuple[float, ...]

    def falls(self) -> bool:
        """Whether each step from d1 to d2 digits lowers the residual by 10^(d2 - d1), less slack.

        A residual below 10^-d counts as 10^-d.

        >>> Decay((30, 50), (-28.3, -48.1)).falls()
        True
        >>> Decay((30, 50), (-28.3, -31.0)).falls()
        False
        """
        floored = [max(level, -d) for d, level in zip(self.digits, self.levels, strict=True)]
        steps = itertools.pairwise(zip(self.digits, floored, strict=True))
        return all(
            before - after >= high - low - SLACK_DIGITS for (low, before), (high, after) in steps
        )

    def text(self) -> str:
        """The residuals with their digits on one line.

        >>> Decay((30, 50), (-28.3, -48.1)).text()
        '5.0e-29, 7.9e-49 at 30, 50 digits'
        """
        residuals = ", ".join(scientific(level) for level in self.levels)
        return f"{residuals} at {', '.join(map(str, self.digits))} digits"


def scientific(level: float) -> str:
    """The number 10**level with two digits, also where it is too small for a float.

    >>> scientific(-400.5), scientific(float("-inf"))
    ('3.2e-401', '0')
    """
    if level == float("-inf"):
        return "0"
    exponent = int(level // 1)
    return f"{10 ** (level - exponent):.1f}e{exponent:+03d}"


HALF_WIDTH = 4
"""A variable is drawn between plus and minus this; a domain without an end is cut this far beyond
0 and its other end."""

DENOMINATOR = 1009
"""A prime, so that no drawn value is exact in binary and every one tests the precision."""

MARGIN = sp.Rational(1, 20)
"""Share of a bounded domain left out at each end, where the neighbouring limit takes over."""


def sample_points(form: ClosedForm, count: int, seed: int) -> list[Point]:
    """``count`` points with parameters inside their domains and xi, tau within +-4.

    A form's points depend on its name, the seed and nothing else.
    """
    draw, domains = random.Random(f"{form.name}:{seed}"), form_domains(form)

    def share() -> sp.Rational:
        """A rational strictly between 0 and 1."""
        return sp.Rational(draw.randint(1, DENOMINATOR - 1), DENOMINATOR)

    def point() -> Point:
        found: dict[sp.Symbol, sp.Rational] = {}
        for symbol in in_order(domains):
            low, high = _interval(domains[symbol], found)
            found[symbol] = low + (high - low) * share()
        for variable in form.equation.variables:
            found[variable] = HALF_WIDTH * (2 * share() - 1)
        for sign in form.equation.free_sign:
            found[sign] = sp.Integer(draw.choice((1, -1)))
        return found

    return [point() for _ in range(count)]


def _interval(domain: Domain, known: Point) -> tuple[sp.Rational, sp.Rational]:
    """The ends between which the parameter is drawn; a margin short of each bound."""
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

SETTLED = 0.005
"""A residual whose logarithm moves by less than this when the digits double has settled."""


class EvaluationError(ValueError):
    """The residual has no finite value at a point, or a function in it no implementation."""


@dataclass(frozen=True)
class Sampling:
    """At how many points, from which seed and at which digits a residual is evaluated.

    Raises ValueError for digits that are not two or more precisions far enough apart for the fall
    to be seen, and for points beyond `MOST_POINTS`.
    """

    digits: tuple[int, ...] = DIGITS
    points: int = POINTS
    seed: int = 0

    def __post_init__(self) -> None:
        digits = self.digits
        gaps = [high - low for low, high in itertools.pairwise(digits)]
        if not gaps or digits[0] < 15 or min(gaps) < MINIMUM_GAP or digits[-1] > MOST_DIGITS:
            raise ValueError(
                f"digits must be two or more numbers from 15 to {MOST_DIGITS}, each at least "
                f"{MINIMUM_GAP} above the one before, got "
                f"{','.join(map(str, digits)) or 'none'} (30,50,100 is usual)"
            )
        if not 1 <= self.points <= MOST_POINTS:
            raise ValueError(
                f"points must satisfy 1 <= points <= {MOST_POINTS}, got {self.points} (24 is usual)"
            )


class ResidualProgram:
    """The terms of the residual of one expression, differentiated and compiled once.

    ``level(point, digits)`` is the decimal logarithm of the relative residual at an exact point.
    Raises EvaluationError for a function without a known derivative.
    """

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
        """log10 of |residual| / sum of |terms| at ``point``; -inf if the residual is 0.

        Raises EvaluationError where the value is not finite or cannot be formed.
        """
        context = self._context
        context.dps = digits
        values = [context.mpf(point[s].p) / point[s].q for s in self.symbols]
        try:
            terms = self._terms(context, *values)
            total, size = abs(context.fsum(terms)), context.fsum(terms, absolute=True)
        except (ArithmeticError, ValueError, TypeError, NameError) as error:
            raise EvaluationError(f"{type(error).__name__}: {error}") from error
        if not context.isfinite(size):
            raise EvaluationError("the residual is not finite")
        return float(context.log10(total / size)) if total else float("-inf")


def _term_entries(tape: Tape, expression: sp.Expr, equation: Equation) -> list[sp.Expr]:
    """The terms of the residual in the tape's registers.

    The field is first an undefined function, whose derivatives stand unevaluated in the terms.
    """
    field = sp.Function("U")(*equation.variables)
    residual = sp.expand(equation.residual(field))
    value = tape.record(expression)
    entries = {}
    for jet in sorted(residual.atoms(sp.Derivative, type(field)), key=sp.default_sort_key):
        entry = value
        for variable in getattr(jet, "variables", ()):
            entry = tape.derivative(entry, variable)
        entries[jet] = entry
    terms = sp.Add.make_args(residual)
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

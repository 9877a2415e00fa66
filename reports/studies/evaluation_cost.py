"""Evaluation: correct digits against seconds, for each wave in each arithmetic.

The cost of a point includes the wave and both its derivatives. Double-doubles are timed on
arrays, mpmath and balls (python-flint's acb) one point at a time. The digits are those of the
worst of the three values over the points, relative to max(1, |value|). The reference is mpmath
with more digits; for balls the proved radius is the error.
"""

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import chain
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from flint import acb, ctx

from longwave.reports.studies.evaluation_accuracy import SOLITON_VALUES, WaveCase
from longwave.solutions import CATALOGUE
from longwave.solutions.compile.tape import Tape
from longwave.solutions.functions.multiprecision import MpmathFormula
from longwave.solutions.symbols import tau, xi
from longwave.support.processes import Job, Key
from longwave.verify.proof.balls import BallEvaluator, JetShape

POINTS: tuple[sp.Rational, ...] = tuple(sp.Rational(7 * i - 24, 16) for i in range(8))
"""Positions X (or xi) of the points; they are exact in every arithmetic."""

TIME = sp.Rational(5, 16)
"""Slow time T (or tau) of all points."""

ARRAY = 20_000
"""Number of points in the array on which double-doubles are timed."""

REPEATS = 3
EXACT_DIGITS = 120
"""Number of digits of the reference values."""

_ORDINARY = {"k": "7/10", "alpha": "1/2", "A": "1", "X_0": "0", "p": "6/5", "q": "4/5"}
_ORDINARY |= {"A_1": "7/5", "A_2": "3/5", "kappa": "9/10", "U_0": "1/2"}
ORDINARY = {name: sp.Rational(value) for name, value in _ORDINARY.items()}
"""Parameter name -> the value at which every wave with this parameter is measured."""

Errors = Iterable[float]
Row = Sequence[Any]
Measure = Callable[[WaveCase], tuple[Errors, float]]


@dataclass(frozen=True)
class EvaluationCost:
    """Worst number of correct decimal digits over the points, and seconds a point."""

    wave: str
    arithmetic: str
    digits: float
    seconds: float


def ordinary_case(name: str) -> WaveCase:
    """Return the wave with generic rational parameters.

    >>> str(ordinary_case("breather_sn"))
    'k = 0.7, alpha = 0.5, X_0 = 0'
    """
    if name in SOLITON_VALUES:
        return WaveCase(name, SOLITON_VALUES[name][0])
    names = [parameter.name for parameter in WaveCase(name).form.parameters]
    return WaveCase(name, tuple((key, ORDINARY[key]) for key in names))


def evaluation_costs(name: str) -> list[EvaluationCost]:
    """Measure digits and seconds of every arithmetic on one wave."""
    case = ordinary_case(name)
    measured = {arithmetic: measure(case) for arithmetic, measure in ARITHMETICS.items()}
    return [EvaluationCost(name, a, correct_digits(e), s) for a, (e, s) in measured.items()]


def correct_digits(errors: Errors) -> float:
    """Return the number of correct digits for the worst error; infinity if it is 0.

    >>> correct_digits([1e-3, 1e-5])
    3.0
    """
    worst = max(errors)
    return math.inf if worst == 0 else -math.log10(worst)


def least_seconds(function: Callable[[], object], repeats: int = REPEATS) -> float:
    """Return the least time of several calls."""
    best = math.inf
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - start)
    return best


def measure_array(case: WaveCase) -> tuple[Errors, float]:
    """Return errors and seconds per point of double-doubles, at eps = 1 (exact X and T)."""
    wave = case.wave()
    speed = int(wave.normal_form.c)
    rows = [wave.pairs_at(float(x + speed * TIME), float(TIME), 1.0) for x in POINTS]
    values = [[np.atleast_1d(part) for part in row] for row in rows]
    n = np.linspace(-50.0, 50.0, ARRAY)
    seconds = least_seconds(lambda: wave.pairs_at(n, float(TIME), 1.0)) / ARRAY
    return _errors(values, exact_values(case)), seconds


def measure_mpmath(digits: int, case: WaveCase) -> tuple[Errors, float]:
    """Return errors and seconds per point of mpmath with ``digits`` digits."""
    exact = exact_values(case)
    start = time.perf_counter()
    values = _mp_values(case, digits)
    seconds = (time.perf_counter() - start) / len(POINTS)
    return _errors([[[value] for value in row] for row in values], exact), seconds


def measure_balls(digits: int, case: WaveCase) -> tuple[Errors, float]:
    """Return errors and seconds per point of balls with ``digits`` digits; radii are the errors."""
    bits = math.ceil(digits * math.log2(10))
    form, parameter_values = case.form, dict(case.wave().parameters)

    def values() -> list[acb]:
        with ctx.workprec(bits):
            jets = (_balls(form.expression, parameter_values, point) for point in POINTS)
            return list(chain.from_iterable(jets))

    balls = values()
    errors = [float(ball.real.rad()) / max(1.0, abs(float(ball.real.mid()))) for ball in balls]
    return errors, least_seconds(values, 1) / len(POINTS)


def _balls(
    U: sp.Expr, parameters: Mapping[sp.Symbol, sp.Expr], point: sp.Rational
) -> tuple[acb, ...]:
    """Return the expression ``U`` and its derivatives U_xi, U_tau at one point xi, as balls."""
    shape = JetShape([(1, 0), (0, 1)])
    values = {**parameters, xi: point, tau: TIME}
    coefficients: tuple[acb, ...] = BallEvaluator(shape, (xi, tau), values).jet(U).coefficients
    return coefficients


@lru_cache(maxsize=1)
def exact_values(case: WaveCase) -> list[Row]:
    """Return the wave and its derivatives, Y, Y_X, Y_T, at `POINTS` to `EXACT_DIGITS` digits."""
    return _mp_values(case, EXACT_DIGITS)


@lru_cache(maxsize=1)
def _mp_program(case: WaveCase) -> tuple[Any, MpmathFormula]:
    """Return an mpmath context, and a function of (xi, tau, *parameters) that evaluates the wave.

    The values are U, U_xi, U_tau in the variables of the normal form.
    """
    context, tape = mpmath.MPContext(), Tape()
    value = tape.record(case.form.expression)
    entries = [value, *(tape.derivative(value, variable) for variable in (xi, tau))]
    symbols = (xi, tau, *case.wave().parameters)
    return context, tape.formula(symbols, entries)


def _mp_values(case: WaveCase, digits: int) -> list[Row]:
    """Return the wave and its derivatives, Y, Y_X, Y_T, at `POINTS` with ``digits`` digits."""
    wave = case.wave()
    context, formula = _mp_program(case)
    with context.workdps(digits):
        numbers = [context.mpf(value.p) / value.q for value in (*wave.parameters.values(), TIME)]
        a, b = (_to_mpf(context, getattr(wave.normal_form, name)) for name in ("a", "b"))
        rows = [
            formula(context, a * context.mpf(point.p) / point.q, b * numbers[-1], *numbers[:-1])
            for point in POINTS
        ]
        return [(row[0], a * row[1], b * row[2]) for row in rows]


def _to_mpf(context: Any, exact: sp.Expr) -> Any:
    return context.mpf(exact._to_mpmath(context.prec))


def _errors(values: Sequence[Sequence[Any]], exact: Sequence[Row]) -> list[float]:
    """Return |value - exact| / max(1, |exact|); a value is given as parts to be added."""
    context = mpmath.MPContext()
    context.dps = EXACT_DIGITS
    pairs = ((v, e) for row in zip(values, exact, strict=True) for v, e in zip(*row, strict=True))
    return [float(abs(context.fsum(map(context.mpf, v)) - e) / max(1, abs(e))) for v, e in pairs]


ARITHMETICS: Mapping[str, Measure] = {
    "double-double": measure_array,
    **{f"balls, {digits} digits": partial(measure_balls, digits) for digits in (20, 40, 80)},
    **{f"mpmath, {digits} digits": partial(measure_mpmath, digits) for digits in (15, 30, 60)},
}
"""Measurement function of each arithmetic; the text before the comma names its family."""


def evaluation_cost_jobs() -> dict[Key, Job]:
    """Return a job for every closed form of the mKdV equation."""
    names = CATALOGUE.of("mKdV").names
    return {("cost", name): Job(evaluation_costs, (name,), 1.0) for name in names}

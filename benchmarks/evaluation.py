"""Time of Y, Y_X and Y_T at 1e5 points for every wave, beside mpmath.

Run: ``python benchmarks/evaluation.py`` (about a minute). Times are the least of several runs.
"""

import time
from collections.abc import Callable

import numpy as np
import sympy as sp

from longwave.reports.studies.evaluation_accuracy import SOLITON_VALUES, WaveCase, wave_names

POINTS = 100_000
REPEATS = 7
REFERENCE_POINTS = 3
DIGITS = 15
HARD_MODULI = {"rogue_cn": 1 - sp.Rational(1, 10**6), "soliton_dn": 1 - sp.Rational(1, 10**6)}


def cases() -> list[WaveCase]:
    """Return an ordinary case for each wave, then cases near the end of a domain."""
    values = {"k": sp.Rational(7, 10), "alpha": sp.Rational(1, 2), "A": sp.Rational(1, 2)}
    ordinary = []
    for name in wave_names():
        required = [p.name for p in WaveCase(name).form.parameters if p.name in values]
        if name in SOLITON_VALUES:
            rows = SOLITON_VALUES[name]
            ordinary.append(WaveCase(name, rows[len(rows) // 2]))
        else:
            ordinary.append(WaveCase(name, tuple((key, values[key]) for key in required)))
    return ordinary + [WaveCase(name, (("k", k),)) for name, k in HARD_MODULI.items()]


def least_seconds(function: Callable[[], object], repeats: int) -> float:
    """Return the least time of several calls."""
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - start)
    return best


def row(case: WaveCase) -> str:
    """Return a line: milliseconds for all points, mpmath's seconds, and their ratio."""
    wave = case.wave()
    X, T = np.linspace(-50.0, 50.0, POINTS), 0.3
    across = {"Z": 0.0} if wave.form.equation.has_across else {}
    wave(X, T, **across)
    seconds = least_seconds(lambda: wave(X, T, **across), REPEATS)
    wave.mp(0.1, T, DIGITS, **across)
    places = [0.3 + i for i in range(REFERENCE_POINTS)]
    slow = (
        least_seconds(lambda: [wave.mp(x, T, DIGITS, **across) for x in places], 1)
        / REFERENCE_POINTS
    )
    times = f"{1e3 * seconds:9.1f} {slow * POINTS:11.0f}"
    return f"{case.name:18} {case!s:18.18}{times} {slow * POINTS / seconds:10.0f}"


def main() -> None:
    """Print the table."""
    print(f"Y, Y_X, Y_T at {POINTS} points; mpmath at {DIGITS} digits, from {REFERENCE_POINTS}")
    heading = f"{'ms':>9} {'mpmath s':>11} {'ratio':>10}"
    print(f"{'wave':18} {'parameters':18}{heading}")
    for case in cases():
        print(row(case), flush=True)


if __name__ == "__main__":
    main()

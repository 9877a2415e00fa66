"""Reference solutions of the chains of `searches.feature_judge`, by DOP853 in compiled code.

The equations of each cell are written out here in other words than the library's, and the method's
coefficients are SciPy's. A search of 20 000 chains takes minutes for its references, where
``solve_ivp`` takes an hour.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.integrate._ivp import dop853_coefficients as dop853

Array = NDArray[np.float64]

SHAPES = ("bump", "wiggle", "step", "corner")
KINDS = ("law", "force", "displacement", "velocity")

STAGES, SIZE = 12, 0.1
"""Of the method; what values must exceed for errors to be measured by their size."""
_A = np.ascontiguousarray(dop853.A[:STAGES, :STAGES])
_B, _C = np.ascontiguousarray(dop853.B), np.ascontiguousarray(dop853.C[:STAGES])
_E3, _E5 = np.ascontiguousarray(dop853.E3), np.ascontiguousarray(dop853.E5)


@numba.njit(cache=True)
def feature(s: float, numbers: Array) -> float:
    """Return the feature (shape, place, width, height, carrier) at a stretch or time."""
    shape, place, width, height, carrier = numbers
    z = (s - place) / width
    if shape < 2:
        value = math.exp(-z * z) * (math.sin(3.0 * z) if shape == 1 else 1.0)
    elif shape == 2:
        value = math.tanh(z)
    else:
        value = width * math.hypot(z, 1e-3)
    return float(height * value + (0.1 * math.sin(carrier * s) if carrier else 0.0))


@numba.njit(cache=True)
def slopes(
    t: float, y: Array, kind: int, quartic: float, loss: float, free: bool, numbers: Array
) -> Array:
    """Return rates of the positions, the velocities and the left wall's position, in this order."""
    n, base = y.size // 2, feature(0.0, numbers)
    found = np.empty_like(y)
    left = feature(t, numbers) if kind == 2 else (y[2 * n] if kind == 3 else 0.0)
    pull = 0.0
    for place in range(n + 1):
        before = left if place == 0 else y[place - 1]
        x = (0.0 if place == n else y[place]) - before
        force = x + quartic * x * x * x
        if kind == 0:
            force += feature(x, numbers) - base
        if free and (place == n or (place == 0 and kind == 0)):
            force = 0.0
        if place:
            found[n + place - 1] = force - pull - loss * y[n + place - 1]
            found[place - 1] = y[n + place - 1]
        pull = force
    if kind == 1:
        found[n] += feature(t, numbers)
    found[2 * n] = feature(t, numbers) if kind == 3 else 0.0
    return found


@numba.njit(cache=True)
def solved(
    y: Array,
    spans: Array,
    rtol: float,
    dearest: int,
    kind: int,
    quartic: float,
    loss: float,
    free: bool,
    numbers: Array,
) -> tuple[Array, bool]:
    """Return the state at the end, and whether it was reached.

    ``spans`` of time have the columns begin, end and longest step. The end is not reached after
    ``dearest`` evaluations, nor where a number overflows.
    """
    calls, stages = 0, np.empty((STAGES + 1, y.size))
    for begin, end, longest in spans:
        t, step = begin, min(longest, end - begin)
        stages[0] = slopes(t, y, kind, quartic, loss, free, numbers)
        while t < end:
            step = min(step, longest, end - t)
            for stage in range(1, STAGES):
                moved = y + step * (_A[stage, :stage] @ stages[:stage])
                stages[stage] = slopes(
                    t + _C[stage] * step, moved, kind, quartic, loss, free, numbers
                )
            tried = y + step * (_B @ stages[:STAGES])
            after = end if step >= end - t else t + step
            stages[STAGES] = slopes(after, tried, kind, quartic, loss, free, numbers)
            calls += STAGES
            scale = rtol * (SIZE + np.maximum(np.abs(y), np.abs(tried)))
            five = np.sum(((_E5 @ stages) / scale) ** 2)
            three = np.sum(((_E3 @ stages) / scale) ** 2)
            error = 0.0
            if five > 0.0 or three > 0.0:
                error = step * five / math.sqrt((five + 0.01 * three) * y.size)
            if not math.isfinite(error) or calls > dearest:
                return y, False
            if error < 1.0:
                t, y = after, tried
                stages[0] = stages[STAGES]
                step *= 10.0 if error == 0.0 else min(10.0, 0.9 * error ** (-1.0 / 8.0))
            else:
                step *= max(0.2, 0.9 * error ** (-1.0 / 8.0))
                if t + step == t:
                    return y, False
    return y, True

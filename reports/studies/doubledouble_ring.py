"""The lattice in double-double arithmetic (about 32 digits), to measure rounding errors."""

from fractions import Fraction
from itertools import pairwise, repeat

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.model import Model
from longwave.lattice.schemes import Composition
from longwave.solutions.run.doubledouble import add, multiply, scale, split, subtract
from longwave.support.compiled.jit import doubles, njit

Array = NDArray[np.float64]


@njit()
def _axpy(y: Array, weight: Array, s: Array) -> None:
    """Add weight * s to y in place; numbers are pairs along the last axis."""
    for i in range(y.shape[0]):
        total = add((y[i, 0], y[i, 1]), multiply((weight[0], weight[1]), (s[i, 0], s[i, 1])))
        y[i, 0], y[i, 1] = total


@njit()
def _forces(y: Array, f: Array, K2: float, K3: float, K4: float) -> None:
    for i in range(y.shape[0]):
        pair = (y[i, 0], y[i, 1])
        slope = add(scale(pair, K4), (K3, 0.0))
        slope = add(multiply(slope, pair), (K2, 0.0))
        f[i, 0], f[i, 1] = multiply(slope, pair)


@njit()
def _second_differences(f: Array, g: Array) -> None:
    size = f.shape[0]
    for i in range(size):
        left, right = f[i - 1], f[(i + 1) % size]
        ends = add((left[0], left[1]), (right[0], right[1]))
        g[i, 0], g[i, 1] = subtract(ends, scale((f[i, 0], f[i, 1]), 2.0))


@njit(cache=True, examples=[(*repeat(doubles(2), 6), 0, 0.0, 0.0, 0.0)])
def _advance(
    y: Array,
    s: Array,
    f: Array,
    g: Array,
    drifts: Array,
    kicks: Array,
    steps: int,
    K2: float,
    K3: float,
    K4: float,
) -> None:
    """Advance (y, s) by a number of steps in place; ``f`` and ``g`` are work arrays.

    ``drifts`` and ``kicks`` are the splitting scheme's coefficients times the step.
    """
    for _ in range(steps):
        for i in range(kicks.shape[0]):
            _axpy(y, drifts[i], s)
            _forces(y, f, K2, K3, K4)
            _second_differences(f, g)
            _axpy(s, kicks[i], g)
        _axpy(y, drifts[kicks.shape[0]], s)


def doubled(values: Array) -> Array:
    """Return the values as double-double pairs (value, 0) along a new last axis."""
    return np.stack([values, np.zeros_like(values)], axis=-1)


def advance_doubled(
    scheme: Composition, y: Array, s: Array, h: float, steps: int, constants: Model
) -> None:
    """Advance the ring of pairs (y, s) in place; the coefficients have 26 digits."""
    kicks = [Fraction(gamma) * Fraction(h) for gamma in scheme.gammas]
    ends = [Fraction(0), *kicks, Fraction(0)]
    drifts = [(a + b) / 2 for a, b in pairwise(ends)]
    work = np.empty_like(y), np.empty_like(y)
    arguments = _pairs(drifts), _pairs(kicks), steps, constants.K2, constants.K3, constants.K4
    _advance(y, s, *work, *arguments)


def _pairs(numbers: list[Fraction]) -> Array:
    return np.array([split(number) for number in numbers])

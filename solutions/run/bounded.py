"""Double-double numbers with bounds of their absolute errors: arithmetic for compiled loops.

A number is (hi, lo, bound): the true value differs from hi + lo by at most the bound. An operation
computes its bound from the operands' bounds and its own rounding. An infinite or NaN bound means
that the error is unknown.
"""

import math

from longwave.solutions.run import doubledouble
from longwave.solutions.run.doubledouble import Array, Pair, add_loosely
from longwave.support.compiled.jit import njit

Bounded = tuple[float, float, float]

PARTS = 3
"""Number of parts of a stored number: high part, low part and bound."""

BLOCK = 128
"""Numbers in a block, which is an array of all high parts, then all low parts, then all bounds."""

UNIT = 2.0**-99
"""Bound of the rounding error of an operation relative to its result (of a sum: to its operands),
and of a constant relative to its value."""

TINY = 2.0**-960
"""Bound of the error by underflow of a low part or of an exponential."""


@njit()
def load(block: Array, i: int) -> Bounded:
    """Return the i-th number of a block of high parts, low parts and bounds."""
    return block[i], block[i + BLOCK], block[i + 2 * BLOCK]


@njit()
def store(block: Array, i: int, value: Bounded) -> None:
    """Set the i-th number of a block."""
    block[i], block[i + BLOCK], block[i + 2 * BLOCK] = value


@njit()
def load_pair(block: Array, i: int) -> Pair:
    """Return the i-th number of a block without its bound."""
    return block[i], block[i + BLOCK]


@njit()
def store_pair(block: Array, i: int, value: Pair) -> None:
    """Set the high and low part of the i-th number of a block, keeping its bound."""
    block[i], block[i + BLOCK] = value


@njit()
def rounded(value: Pair, error: float) -> Bounded:
    """Return ``value`` with its bound: ``error``, due to the operands, plus its rounding error."""
    return value[0], value[1], error + (UNIT * abs(value[0]) + TINY)


@njit()
def add(a: Bounded, b: Bounded) -> Bounded:
    """Return a + b."""
    high, low = add_loosely((a[0], a[1]), (b[0], b[1]))
    return high, low, a[2] + b[2] + UNIT * (abs(a[0]) + abs(b[0]))


@njit()
def negate(a: Bounded) -> Bounded:
    """Return -a."""
    return -a[0], -a[1], a[2]


@njit()
def subtract(a: Bounded, b: Bounded) -> Bounded:
    """Return a - b."""
    return add(a, negate(b))


@njit()
def multiply(a: Bounded, b: Bounded) -> Bounded:
    """Return a b."""
    error = abs(a[0]) * b[2] + (abs(b[0]) + b[2]) * a[2]
    return rounded(doubledouble.multiply((a[0], a[1]), (b[0], b[1])), error)


@njit()
def scale(a: Bounded, c: float) -> Bounded:
    """Return a c for a power of two c, or minus one."""
    return a[0] * c, a[1] * c, a[2] * abs(c) + TINY


@njit()
def relative_error(d: float) -> float:
    """Return the relative error of 1/x if x has the relative error d; infinite for d > 1/2."""
    return d / (1.0 - d) if d <= 0.5 else math.inf


@njit()
def reciprocal(a: Bounded) -> Bounded:
    """Return 1 / a."""
    high, low = doubledouble.reciprocal((a[0], a[1]))
    return rounded((high, low), abs(high) * relative_error(a[2] * abs(high)))


@njit()
def square_root(a: Bounded) -> Bounded:
    """Return the square root of a > 0."""
    high, low = doubledouble.square_root((a[0], a[1]))
    return rounded((high, low), high * relative_error(a[2] / a[0]))

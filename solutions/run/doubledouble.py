"""Double-double arithmetic: a number as an unevaluated sum hi + lo of two floats, about 32 digits.

The functions are numba-compiled primitives on pairs (hi, lo) with |lo| <= ulp(hi) / 2: Dekker's and
Knuth's algorithms, with a fused multiply-add for the exact product.  They are meant to be called
from compiled loops, but also work from Python on single numbers.

>>> multiply((1.0 + 2.0**-30, 0.0), (1.0 - 2.0**-30, 0.0)) == (1.0, -(2.0**-60))
True
"""

from fractions import Fraction
from typing import Any

import numpy as np
from mpmath import MPContext
from numpy.typing import NDArray

from longwave.support.compiled.jit import Intrinsic, njit

Array = NDArray[np.float64]
Pair = tuple[float, float]
Three = tuple[float, float, float]

_CONTEXT = MPContext()
_BITS = 240


def split(number: Any) -> Pair:
    """Return the pair nearest to an exact number: int, float, Fraction, mpf, SymPy's, or literal.

    >>> split(0.1)
    (0.1, 0.0)
    >>> split("0.1")
    (0.1, -5.551115123125783e-18)
    """
    high, low, _ = split_three(number)
    return high, low


def split_three(number: Any) -> Three:
    """Return the three floats whose sum is nearest to an exact number.

    >>> sum(map(Fraction, split_three("0.1"))) - Fraction("0.1") < 1e-49
    True
    """
    if isinstance(number, str):
        number = Fraction(number)
    with _CONTEXT.workprec(_BITS):
        if hasattr(number, "_to_mpmath"):
            number = number._to_mpmath(_BITS)
        elif isinstance(number, Fraction):
            number = _CONTEXT.mpf(number.numerator) / number.denominator
        value = _CONTEXT.convert(number)
        high = float(value)
        if not np.isfinite(high):
            return high, 0.0, 0.0
        middle = float(value - high)
        return high, middle, float(value - high - middle)


def check_range(number: Any) -> Any:
    """Return `number`. Raises OverflowError unless it is 0 or within 1e-250 .. 1e250."""
    if number and not 1e-250 < abs(number) < 1e250:
        raise OverflowError(_CONTEXT.nstr(_CONTEXT.convert(number), 3))
    return number


def _fma_signature(typing_context: Any, x: Any, y: Any, z: Any) -> Any:
    from numba import types

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fma(*args)

    return types.float64(types.float64, types.float64, types.float64), generate


def _power_signature(typing_context: Any, n: Any) -> Any:
    from numba import types

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        exponent = builder.fsub(context.get_constant(types.float64, _EXPONENT), args[0])
        bits = builder.bitcast(exponent, context.get_value_type(types.int64))
        shifted = builder.shl(bits, context.get_constant(types.int64, 52))
        return builder.bitcast(shifted, context.get_value_type(types.float64))

    return types.float64(types.float64), generate


_EXPONENT = 1.5 * 2.0**52 + 1023.0  # minus n, its lowest bits are the exponent field of 2^-n
_fma: Any = Intrinsic(_fma_signature)
_halves: Any = Intrinsic(_power_signature)


@njit()
def fma(x: float, y: float, z: float) -> float:
    """Return x y + z, rounded once."""
    return _fma(x, y, z)


@njit()
def power_of_half(n: float) -> float:
    """Return 2^-n for a whole number n, -1023 < n < 1023."""
    return _halves(n)


@njit()
def quick_two_sum(a: float, b: float) -> Pair:
    """Return a + b exactly, for |a| >= |b|."""
    s = a + b
    return s, b - (s - a)


@njit()
def two_sum(a: float, b: float) -> Pair:
    """Return a + b exactly."""
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


@njit()
def normalized(high: float, middle: float, low: float) -> Three:
    """Return three floats with the same sum, each below the rounding of the one before."""
    high, middle = two_sum(high, middle)
    middle, low = two_sum(middle, low)
    high, middle = two_sum(high, middle)
    middle, low = two_sum(middle, low)
    return high, middle, low


@njit()
def two_prod(a: float, b: float) -> Pair:
    """Return a b exactly (barring underflow)."""
    p = a * b
    return p, _fma(a, b, -p)


@njit()
def add(a: Pair, b: Pair) -> Pair:
    """Return a + b with relative error below 2^-103, cancellation included."""
    s, e = two_sum(a[0], b[0])
    t, f = two_sum(a[1], b[1])
    s, e = quick_two_sum(s, e + t)
    return quick_two_sum(s, e + f)


@njit()
def add_loosely(a: Pair, b: Pair) -> Pair:
    """Return a + b with error below 2^-103 (|a| + |b|): half the work of `add`."""
    s, e = two_sum(a[0], b[0])
    return quick_two_sum(s, e + (a[1] + b[1]))


@njit()
def subtract(a: Pair, b: Pair) -> Pair:
    """Return a - b."""
    return add(a, (-b[0], -b[1]))


@njit()
def multiply(a: Pair, b: Pair) -> Pair:
    """Return a b with relative error below 2^-101."""
    p, e = two_prod(a[0], b[0])
    return quick_two_sum(p, _fma(a[0], b[1], _fma(a[1], b[0], e)))


@njit()
def scale(a: Pair, b: float) -> Pair:
    """Return a b for a float b."""
    p, e = two_prod(a[0], b)
    return quick_two_sum(p, _fma(a[1], b, e))


@njit()
def reciprocal(x: Pair) -> Pair:
    """Return 1 / x with relative error below 2^-101."""
    q = 1.0 / x[0]
    residual = _fma(-q, x[0], 1.0)
    return quick_two_sum(q, q * _fma(-q, x[1], residual))


@njit()
def square_root(a: Pair) -> Pair:
    """Return the square root of a >= 0 with relative error below 2^-100."""
    root = np.sqrt(a[0])
    if root == 0.0:
        return root, 0.0
    residual = subtract(a, two_prod(root, root))
    return quick_two_sum(root, residual[0] / (2.0 * root))

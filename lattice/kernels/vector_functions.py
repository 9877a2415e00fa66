"""Functions of force laws as vector arithmetic: exponentials, logarithms, powers, trigonometry.

Each is branch-free and consists of sums, products and at most one quotient, so that all cells of a
row are computed together without calls to the C library; only sine, cosine and tangent call it, for
arguments beyond `LARGEST_ANGLE`. Errors are below 2 units in the last place (ulp) for every double;
each docstring gives a bound that the tests confirm. NaN, infinities and zeros of either sign give
the C library's results. LLVM contracts or reassociates nothing here, because the
instructions carry no such flags. `LaneCode.fma` alone may round once or twice; no error bound
depends on which. A product's rounding error comes from a fused multiply-add if the processor has
one, else from halves of the factors (Dekker, Numer. Math. 18, 1971): both are exact.

Machine code that advances a lattice flushes subnormal numbers to 0 (`support.compiled.subnormals`):
there exp(-710) is 0, and the logarithm of 1e-310 is that of 0. Where nothing is flushed, subnormal
arguments and results have the same error.

Polynomials are near-minimax (Chebyshev), fitted with mpmath when code is generated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partialmethod
from typing import TYPE_CHECKING, Any, NamedTuple

from llvmlite import ir  # type: ignore[import-untyped]

if TYPE_CHECKING:
    from longwave.lattice.kernels.lane_code import LaneCode

__all__ = ["FUNCTIONS_OF_LANES", "LARGEST_EXPONENT", "Lanes", "power"]

LARGEST_ANGLE = 8192.0
"""Largest argument of sine, cosine and tangent that is reduced here."""

LARGEST_EXPONENT = 2.0**20
"""Largest abs(exponent) for `power`."""

CONSTANT_DIGITS = 60
"""Decimal digits with which constants are computed."""

SHIFT = 1.5 * 2.0**52
"""A double of this size has no fractional bits: adding it rounds to whole numbers, and the whole
number is in the last bits of the sum."""

ONE_BITS, SHIFT_BITS = 1023 << 52, 0x433 << 52
"""Bit patterns of 1 and of 2^52."""

INFINITY, NAN = float("inf"), float("nan")


class Lanes:
    """A vector of doubles in generated code, with Python's arithmetic operators."""

    def __init__(self, code: LaneCode, value: Any) -> None:
        self.code, self.value = code, value

    def of(self, other: Lanes | float) -> Any:
        """Return the value of another vector, or of a number repeated in all lanes."""
        return other.value if isinstance(other, Lanes) else self.code.constant(other)

    def with_value(self, value: Any) -> Lanes:
        """Return a vector with another value, for the same code generator."""
        return Lanes(self.code, value)

    def _combined(self, word: str, other: Lanes | float) -> Lanes:
        return self.with_value(getattr(self.code.builder, word)(self.value, self.of(other)))

    __add__ = partialmethod(_combined, "fadd")
    __sub__ = partialmethod(_combined, "fsub")
    __mul__ = partialmethod(_combined, "fmul")

    def __rsub__(self, other: float) -> Lanes:
        return self.with_value(self.code.builder.fsub(self.of(other), self.value))

    def __rtruediv__(self, other: float) -> Lanes:
        return self.with_value(self.code.builder.fdiv(self.of(other), self.value))

    def __neg__(self) -> Lanes:
        return self.with_value(self.code.builder.fneg(self.value))

    def times_plus(self, factor: Lanes | float, term: Lanes | float) -> Lanes:
        """Return self * factor + term, rounded once or twice."""
        return self.with_value(self.code.fma(self.value, self.of(factor), self.of(term)))

    def where(self, sign: str, bound: Lanes | float, value: Lanes | float) -> Lanes:
        """Return ``value`` where ``self sign bound`` holds, as for "<", else self, also if NaN."""
        return self.replaced(self.compared(sign, bound), value)

    def replaced(self, mask: Any, value: Lanes | float) -> Lanes:
        """Return ``value`` where the mask is set, else self."""
        return self.with_value(self.code.builder.select(mask, self.of(value), self.value))

    def compared(self, sign: str, bound: Lanes | float) -> Any:
        """Return a mask of lanes where ``self sign bound`` holds, as for "<"; False for NaN."""
        return self.code.builder.fcmp_ordered(sign, self.value, self.of(bound))

    def bits(self) -> Bits:
        """Return the bit patterns of the doubles."""
        return Bits(self.code, self.code.builder.bitcast(self.value, words_of(self.code)))

    def size(self) -> Lanes:
        """Return the absolute value."""
        return (self.bits() & ((1 << 63) - 1)).doubles()

    def signed_as(self, other: Lanes) -> Lanes:
        """Return self, which must not be negative, with the sign of ``other``."""
        return (self.bits() | other.sign()).doubles()

    def sign(self) -> Bits:
        """Return the vector's sign bits alone."""
        return self.bits() & (1 << 63)


class Bits:
    """A vector of 64-bit integers in generated code."""

    def __init__(self, code: LaneCode, value: Any) -> None:
        self.code, self.value = code, value

    def _combined(self, word: str, other: Bits | int) -> Bits:
        if isinstance(other, int):
            lanes, kind = self.code.lanes, words_of(self.code)
            signed = (other + (1 << 63)) % (1 << 64) - (1 << 63)
            operand = ir.Constant(kind, signed if lanes == 1 else [signed] * lanes)
        else:
            operand = other.value
        return Bits(self.code, getattr(self.code.builder, word)(self.value, operand))

    __add__ = partialmethod(_combined, "add")
    __sub__ = partialmethod(_combined, "sub")
    __and__ = partialmethod(_combined, "and_")
    __or__ = partialmethod(_combined, "or_")
    __xor__ = partialmethod(_combined, "xor")
    __lshift__ = partialmethod(_combined, "shl")
    __rshift__ = partialmethod(_combined, "lshr")

    def doubles(self) -> Lanes:
        """Return the doubles with these bit patterns."""
        return Lanes(self.code, self.code.builder.bitcast(self.value, self.code.kind))


class Pair(NamedTuple):
    """An unevaluated sum of two vectors; ``low`` is at most a few last places of ``high``."""

    high: Lanes
    low: Lanes


def words_of(code: LaneCode) -> Any:
    """Return the LLVM type of the integers that hold a vector's bits."""
    word = ir.IntType(64)
    return word if code.lanes == 1 else ir.VectorType(word, code.lanes)


def exact_sum(large: Lanes, small: Lanes) -> Pair:
    """Return a sum with its rounding error; needs abs(large) >= abs(small), or ``large`` 0."""
    total = large + small
    return Pair(total, small - (total - large))


def whole(pair: Pair) -> Lanes:
    """Return the rounded sum of the pair."""
    return pair.high + pair.low


def exact_product(first: Lanes, second: Lanes) -> Pair:
    """Return a product with its rounding error; absolute values must be below 1e290."""
    total = first * second
    if first.code.fused:
        rest = first.code.fused_multiply_add(first.value, second.value, (-total).value)
        return Pair(total, first.with_value(rest))
    (a, b), (c, d) = _halves(first), _halves(second)
    return Pair(total, ((a * c - total) + a * d + b * c) + b * d)


def _halves(value: Lanes) -> Pair:
    """Return two doubles of 26 bits whose sum is the value."""
    wide = value * (2.0**27 + 1.0)
    high = wide - (wide - value)
    return Pair(high, value - high)


def quotient(over: Pair, under: Pair) -> Pair:
    """Return a quotient with a relative error of about 2^-100."""
    inverse = 1.0 / under.high
    first = over.high * inverse
    product = exact_product(first, under.high)
    rest = (over.high - product.high) - product.low
    return Pair(first, (rest + over.low - first * under.low) * inverse)


def polynomial(z: Lanes, factors: Sequence[float]) -> Lanes:
    """Return the polynomial with the coefficients ``factors``, lowest first, evaluated at ``z``."""
    if len(factors) < 4:
        return _horner(z, factors)
    square = z * z
    even, odd = (_horner(square, factors[start::2]) for start in (0, 1))
    return odd.times_plus(z, even)


def _horner(z: Lanes, factors: Sequence[float]) -> Lanes:
    """Return the polynomial with these coefficients, lowest first, by Horner's rule."""
    *lower, highest = factors
    result = z.with_value(z.code.constant(highest))
    for factor in reversed(lower):
        result = result.times_plus(z, factor)
    return result


# Constants are computed when code is generated; the machine code is cached.


@cache
def parts_of(name: str, *bits: int) -> tuple[float, ...]:
    """Return a constant as a sum of doubles: the leading ones have ``bits`` bits, the last has 53.

    >>> parts_of("ln2", 42)
    (0.6931471805598903, 5.497923018708371e-14)
    """
    import mpmath

    with mpmath.workdps(CONSTANT_DIGITS):
        left = {"ln2": +mpmath.ln2, "half_pi": mpmath.pi / 2, "third": mpmath.mpf(1) / 3}[name]
        doubles = []
        for count in bits:
            unit = mpmath.ldexp(1, mpmath.frexp(left)[1] - count)
            doubles.append(float(mpmath.floor(left / unit) * unit))
            left -= doubles[-1]
        return (*doubles, float(left))


@cache
def fitted(name: str) -> tuple[float, ...]:
    """Return the coefficients of the polynomial of that name in `SERIES`, lowest power first."""
    import mpmath

    low, high, count, make_function = SERIES[name]
    with mpmath.workdps(CONSTANT_DIGITS):
        function = make_function(mpmath)
        return tuple(map(float, reversed(mpmath.chebyfit(function, [low, high], count))))


SERIES: dict[str, tuple[float, float, int, Callable[[Any], Callable[[Any], Any]]]] = {
    "exp": (-0.34658, 0.34658, 10, lambda m: lambda r: (m.expm1(r) - r) / r**2),
    "sinh": (0.0, 0.12012, 5, lambda m: lambda z: (m.sinh(m.sqrt(z)) / m.sqrt(z) - 1) / z),
    "cosh": (0.0, 0.12012, 6, lambda m: lambda z: (m.cosh(m.sqrt(z)) - 1) / z),
    "log": (0.0, 0.02945, 7, lambda m: lambda z: (m.atanh(m.sqrt(z)) / m.sqrt(z) - 1) * 2 / z),
    "log_rest": (
        0.0,
        0.02945,
        8,
        lambda m: lambda z: ((m.atanh(m.sqrt(z)) / m.sqrt(z) - 1) / z - m.mpf(1) / 3) / z,
    ),
    "sin": (0.0, 0.61686, 6, lambda m: lambda z: (m.sin(m.sqrt(z)) / m.sqrt(z) - 1) / z),
    "cos": (0.0, 0.61686, 6, lambda m: lambda z: (m.cos(m.sqrt(z)) - 1 + z / 2) / z**2),
    "atan": (0.0, 0.17158, 12, lambda m: lambda z: (m.atan(m.sqrt(z)) / m.sqrt(z) - 1) / z),
}
"""Polynomials by name: range, number of coefficients, and the function fitted. The ranges end a
little beyond ln(2)/2, its square, the squares of (sqrt(2) - 1)/(sqrt(2) + 1), pi/4, and sqrt(2) -
1. The relative error of the fits is below 2^-55, in "log_rest" below 2^-66."""


# Exponentials.

LEAST_EXPONENT, MOST_EXPONENT = -760.0, 720.0
"""Arguments below which the exponential is 0, and above which it is infinite: n ln(2) with n of 12
bits."""


def _doublings(x: Lanes, low: Lanes | None = None) -> tuple[Lanes, Lanes, Pair]:
    """Return n, n + `SHIFT` and r such that x (or x + low) = n ln(2) + r and abs(r) <= ln(2)/2."""
    high, rest = parts_of("ln2", 42)
    shifted = x.times_plus(1.0 / high, SHIFT)
    n = shifted - SHIFT
    left, off = n.times_plus(-high, x), n * rest
    off = off if low is None else off - low
    r = left - off
    return n, shifted, Pair(r, (left - r) - off)


def _power_of_two(shifted: Lanes) -> Lanes:
    """Return 2^n, given n + `SHIFT`, for n in -1022 .. 1023."""
    return ((shifted.bits() << 52) + ONE_BITS).doubles()


def exponential(x: Lanes, low: Lanes | None = None) -> Lanes:
    """Return exp(x), or exp(x + low), to 1.2 ulp; of the two factors of 2^n only one rounds."""
    n, shifted, (r, _) = _doublings(
        x.where("<", LEAST_EXPONENT, LEAST_EXPONENT).where(">", MOST_EXPONENT, MOST_EXPONENT), low
    )
    more = (r * r).times_plus(polynomial(r, fitted("exp")), r)
    half = n.times_plus(0.5, SHIFT).bits() << 52
    other = (shifted.bits() << 52) - half
    return (more + 1.0) * (half + ONE_BITS).doubles() * (other + ONE_BITS).doubles()


class _Hyperbolic(NamedTuple):
    """``sinh`` and ``cosh`` of x over 2^up, ``fall`` = exp(-x), and ``n`` = x/ln(2) rounded."""

    sinh: Pair
    cosh: Pair
    fall: Lanes
    up: Lanes
    n: Lanes


def _hyperbolic(x: Lanes) -> _Hyperbolic:
    """Return the hyperbolic functions of x >= 0.

    With exp(r) = 1 + c + s, exp(-r) = 1 + c - s and a, b = 2^n / 2, 2^-n / 2:
    sinh = (a - b)(1 + c) + (a + b) s, cosh = (a + b)(1 + c) + (a - b) s.
    """
    n, _, (r, low) = _doublings(x)
    z = r * r
    c = z * polynomial(z, fitted("cosh"))
    s, s_low = exact_sum(r, (r * z).times_plus(polynomial(z, fitted("sinh")), low))
    half = n.times_plus(0.5, SHIFT)
    up = n - (half - SHIFT)
    a = _power_of_two(half - 1.0)
    b = _power_of_two(SHIFT - 1.0 - (n.where(">", 100.0, 100.0) + up))
    (less, less_low), (more, more_low) = exact_sum(a, -b), exact_sum(a, b)
    less_low, more_low = more.times_plus(s_low, less_low), less.times_plus(s_low, more_low)
    odd = exact_sum(less, less.times_plus(c, more.times_plus(s, less_low)))
    even = exact_sum(more, more.times_plus(c, less.times_plus(s, more_low)))
    return _Hyperbolic(odd, even, (c - s + 1.0) * (b + b), up, n)


def sinh(x: Lanes) -> Lanes:
    """Return the hyperbolic sine, to 1.6 ulp."""
    result = _hyperbolic(x.size().where(">", MOST_EXPONENT, MOST_EXPONENT))
    return (result.sinh.high * _power_of_two(result.up + SHIFT)).signed_as(x)


def cosh(x: Lanes) -> Lanes:
    """Return the hyperbolic cosine, to 1.6 ulp."""
    result = _hyperbolic(x.size().where(">", MOST_EXPONENT, MOST_EXPONENT))
    return result.cosh.high * _power_of_two(result.up + SHIFT)


def tanh(x: Lanes) -> Lanes:
    """Return the hyperbolic tangent, to 1.8 ulp; from about 1 on as 1 - exp(-x) / cosh(x)."""
    result = _hyperbolic(x.size().where(">", 25.0, 25.0))
    far = result.n.compared(">", 1.0)
    over = Pair(result.sinh.high.replaced(far, -result.fall), result.sinh.low.replaced(far, 0.0))
    limit = x.with_value(x.code.constant(0.0)).replaced(far, 1.0)
    return (limit + whole(quotient(over, result.cosh))).signed_as(x)


# Logarithms and powers.

ROOT_HALF_BITS = 0x3FE6A09E667F3BCD
"""Bit pattern of the square root of 1/2."""


def _mantissa(x: Lanes) -> tuple[Lanes, Lanes]:
    """Return k and m such that x = 2^k m and sqrt(1/2) <= m <= sqrt(2); x must be positive."""
    small = x.compared("<", 2.0**-1022)
    bits = x.replaced(small, x * 2.0**54).bits()
    up = bits + (ONE_BITS + (1 << 52) - ROOT_HALF_BITS)
    raised = ((up >> 52) | SHIFT_BITS).doubles() - (2.0**52 + 1024.0)
    k = raised.replaced(small, raised - 54.0)
    return k, (bits - (up & (0xFFF << 52)) + (ONE_BITS + (1 << 52))).doubles()


def logarithm(x: Lanes) -> Lanes:
    """Return the natural logarithm, to 0.9 ulp."""
    result = _logarithm(*_mantissa(x))
    result = result.replaced(x.compared("==", INFINITY), INFINITY)
    result = result.replaced(x.compared("==", 0.0), -INFINITY)
    below = x.code.builder.fcmp_unordered("<", x.value, x.of(0.0))
    return result.replaced(below, NAN)


def _logarithm(k: Lanes, m: Lanes, more: Lanes | float = 0.0) -> Lanes:
    """Return the logarithm of 2^k m, plus a small correction ``more``."""
    high, rest = parts_of("ln2", 42)
    f = m - 1.0
    s = f * (1.0 / (m + 1.0))
    z, half = s * s, f * f * 0.5
    series = z.times_plus(polynomial(z, fitted("log")), half)
    low = s.times_plus(series, k.times_plus(rest, more))
    return k.times_plus(high, f - (half - low))


def area_sine(x: Lanes) -> Lanes:
    """Return the inverse hyperbolic sine, to 1.7 ulp.

    It is log(1 + u) with u = |x| + x^2 / (1 + sqrt(1 + x^2)), and log(2 |x|) from 2^28 on.
    """
    size = x.size()
    large = size.compared(">", 2.0**28)
    t = size.where(">", 2.0**28, 2.0**28)
    root = x.with_value(x.code.root(t.times_plus(t, 1.0).value))
    u = (t * t).times_plus(1.0 / (root + 1.0), t)
    total = u + 1.0
    below = u.compared("<", 1.0)
    lost = (total - u - 1.0).replaced(below, total - 1.0 - u)
    off = (-lost * (1.0 / total)).replaced(large, 0.0)
    k, m = _mantissa(total.replaced(large, size))
    result = _logarithm(k.replaced(large, k + 1.0), m, off)
    result = result.replaced(size.compared("==", INFINITY), INFINITY)
    missing = x.code.builder.fcmp_unordered("!=", x.value, x.value)
    return result.replaced(missing, NAN).signed_as(x)


def _logarithm_pair(x: Lanes) -> Pair:
    """Return the natural logarithm with a relative error of 2^-65; x is positive and finite.

    The logarithm of m is 2 s (1 + z/3 + z^2 Q(z)) with s = (m - 1)/(m + 1) and z = s^2, all as
    pairs but Q.
    """
    k, m = _mantissa(x)
    over, under = m - 1.0, m + 1.0
    none = x.with_value(x.code.constant(0.0))
    s = quotient(Pair(over, none), Pair(under, m - (under - 1.0)))
    z = exact_product(s.high, s.high)
    z_low = (s.high * 2.0).times_plus(s.low, z.low)
    third, third_low = parts_of("third", 53)
    part = exact_product(z.high, x.with_value(x.code.constant(third)))
    part_low = z_low.times_plus(third, z.high.times_plus(third_low, part.low))
    rest = z.high * z.high * polynomial(z.high, fitted("log_rest"))
    series = exact_sum(part.high, rest)
    series_low = series.low + part_low
    more = exact_product(s.high, series.high)
    more_low = s.high.times_plus(series_low, s.low.times_plus(series.high, more.low))
    half = exact_sum(s.high, more.high)
    half_low = half.low + (s.low + more_low)
    high, low = parts_of("ln2", 42)
    total = exact_sum(k * high, half.high * 2.0)
    return Pair(total.high, total.low + k.times_plus(low, half_low * 2.0))


def power(x: Lanes, exponent: float) -> Lanes:
    """Return x^exponent to 1.6 ulp, for 0 < abs(exponent) <= `LARGEST_EXPONENT`."""
    size = x.size()
    log = _logarithm_pair(size)
    factor = x.with_value(x.code.constant(exponent))
    product = exact_product(log.high, factor)
    result = exponential(product.high, factor.times_plus(log.low, product.low))
    at_zero, beyond = (0.0, INFINITY) if exponent > 0.0 else (INFINITY, 0.0)
    is_whole = exponent.is_integer()
    wrong = x.code.builder.fcmp_unordered(
        "!=" if is_whole else "<", x.value, x.of(x if is_whole else 0.0)
    )
    result = result.replaced(wrong, NAN)
    result = result.replaced(size.compared("==", 0.0), at_zero)
    result = result.replaced(size.compared("==", INFINITY), beyond)
    return result.signed_as(x) if is_whole and exponent % 2.0 == 1.0 else result


# Trigonometric functions.


def _reduced(x: Lanes) -> tuple[Bits, Pair, Pair]:
    """Return n (in the last bits), and sine and cosine of x - n pi/2; x <= `LARGEST_ANGLE`."""
    first, second, third = parts_of("half_pi", 40, 40)
    shifted = x.times_plus(1.0 / (first + second), SHIFT)
    n = shifted - SHIFT
    left, off = n.times_plus(-first, x), n * -second
    r = left + off
    subtracted = r - left
    error = (left - (r - subtracted)) + (off - subtracted)
    high, low = exact_sum(r, n.times_plus(-third, error))
    z = high * high
    half = z * 0.5
    sine = exact_sum(high, (high * z).times_plus(polynomial(z, fitted("sin")), low - half * low))
    cosine = exact_sum(x.with_value(x.code.constant(1.0)), -half)
    rest = (z * z).times_plus(polynomial(z, fitted("cos")), cosine.low - high * low)
    return shifted.bits(), sine, exact_sum(cosine.high, rest)


def _even(quarters: Bits) -> Any:
    """Return a mask of the lanes where the integer is even."""
    nothing = (quarters ^ quarters).value
    return quarters.code.builder.icmp_unsigned("==", (quarters & 1).value, nothing)


def _circle(x: Lanes, more_quarters: int) -> Bits:
    """Return the bits of the sine of x >= 0 plus ``more_quarters`` quarter turns."""
    quarters, sine, cosine = _reduced(x)
    quarters += more_quarters
    result = cosine.high.replaced(_even(quarters), sine.high)
    return result.bits() ^ ((quarters & 2) << 62)


def sine(x: Lanes) -> Lanes:
    """Return the sine, to 0.9 ulp."""
    return _within(x, "sin", (_circle(x.size(), 0) ^ x.sign()).doubles())


def cosine(x: Lanes) -> Lanes:
    """Return the cosine, to 0.9 ulp."""
    return _within(x, "cos", _circle(x.size(), 1).doubles())


def tangent(x: Lanes) -> Lanes:
    """Return the tangent, to 1.0 ulp."""
    quarters, sine, cosine = _reduced(x.size())
    even = _even(quarters)
    over, under = (
        Pair(*(b.replaced(even, a) for a, b in zip(*pair, strict=True)))
        for pair in ((sine, cosine), (cosine, sine))
    )
    result = whole(quotient(over, under)).bits() ^ ((quarters & 1) << 63)
    return _within(x, "tan", (result ^ x.sign()).doubles())


def _within(x: Lanes, name: str, result: Lanes) -> Lanes:
    """Return ``result``, or the C library's function ``name`` of x if abs(x) > `LARGEST_ANGLE`."""
    code, builder = x.code, x.code.builder
    is_beyond = builder.fcmp_unordered(">", x.size().value, x.of(LARGEST_ANGLE))
    flags = ir.IntType(code.lanes)
    somewhere = builder.icmp_unsigned("!=", builder.bitcast(is_beyond, flags), flags(0))
    before = builder.block
    with builder.if_then(somewhere, likely=False):
        library_result = builder.select(is_beyond, code.function(name, x.value), result.value)
        after = builder.block
    total = builder.phi(code.kind)
    total.add_incoming(result.value, before)
    total.add_incoming(library_result, after)
    return x.with_value(total)


def arctangent(x: Lanes) -> Lanes:
    """Return the arctangent to 0.9 ulp, by pi/2 and -1/x or by pi/4 and (x - 1)/(x + 1)."""
    size = x.size().where(">", 2.0**60, 2.0**60)
    middle, steep = size.compared(">", 2.0**0.5 - 1.0), size.compared(">", 1.0 + 2.0**0.5)
    none, one = (x.with_value(x.code.constant(value)) for value in (0.0, 1.0))
    less, more = size - 1.0, size + 1.0
    over = size.replaced(middle, less).replaced(steep, -1.0)
    over_low = none.replaced(middle, size - (less + 1.0)).replaced(steep, 0.0)
    under = one.replaced(middle, more).replaced(steep, size)
    under_low = none.replaced(middle, size - (more - 1.0)).replaced(steep, 0.0)
    t = quotient(Pair(over, over_low), Pair(under, under_low))
    half, half_low = parts_of("half_pi", 53)
    base = none.replaced(middle, half / 2.0).replaced(steep, half)
    base_low = none.replaced(middle, half_low / 2.0).replaced(steep, half_low)
    total, low = exact_sum(base, t.high)
    z = t.high * t.high
    low = (t.high * z).times_plus(polynomial(z, fitted("atan")), base_low + t.low) + low
    return (total + low).signed_as(x)


FUNCTIONS_OF_LANES: dict[str, Callable[[Lanes], Lanes]] = {
    "exp": exponential, "log": logarithm, "sin": sine, "cos": cosine, "tan": tangent,
    "sinh": sinh, "cosh": cosh, "tanh": tanh, "atan": arctangent, "asinh": area_sine,
}  # fmt: skip
"""Vector versions of the functions in `lattice.force_program.UNARY` other than comparisons."""

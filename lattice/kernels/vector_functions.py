"""Functions of a force law as vector arithmetic: exponentials, logarithms, powers, circles.

Each is written without branches, of sums, products and one quotient at most, so that all cells of a
row are done together, and the C library is not called; sine, cosine and tangent alone ask it for
arguments beyond `TURNED`. Errors are below 2 units in the last place (ulp) for every double; each
docstring says what is not exceeded in tests. NaN, infinities and zeros of either sign give
what the C library gives. Nothing here is contracted or reassociated by LLVM: its instructions
carry no such flags; `LaneCode.fma` alone may round once or twice, and no error bound counts on
either. A product's rounding error comes from a fused multiply-add where the processor has one, else
from halves of the factors (Dekker, Numer. Math. 18, 1971): both are exact.

Machine code that advances a lattice takes and gives 0 for subnormal numbers
(`support.compiled.subnormals`): there exp(-710) is 0, and the logarithm of 1e-310 is that of 0.
Where nothing is flushed, subnormal arguments and results are good to the same error.

Polynomials are near-minimax (Chebyshev), found by mpmath when code is written.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from llvmlite import ir  # type: ignore[import-untyped]

if TYPE_CHECKING:
    from longwave.lattice.kernels.lane_code import LaneCode

__all__ = ["FUNCTIONS_OF_LANES", "LARGEST_EXPONENT", "Lanes", "power"]

TURNED = 8192.0
"""Largest argument of sine, cosine and tangent whose turns are taken off here."""

LARGEST_EXPONENT = 2.0**20
"""Largest size of an exponent of `power`."""

DIGITS = 60
"""Decimal digits with which constants are found."""

SHIFT = 1.5 * 2.0**52
"""A double of this size has no places after the point: adding it rounds to whole numbers, and the
whole number stands in the last bits of the sum."""

ONE_BITS, SHIFT_BITS = 1023 << 52, 0x433 << 52
"""The bits of 1, and of 2^52."""

INFINITY, NAN = float("inf"), float("nan")


class Lanes:
    """A vector of doubles in the code that is written, with Python's signs for its arithmetic."""

    def __init__(self, code: LaneCode, value: Any) -> None:
        self.code, self.value = code, value

    def of(self, other: Lanes | float) -> Any:
        """Return the value of another vector, or of a number in all lanes."""
        return other.value if isinstance(other, Lanes) else self.code.constant(other)

    def made(self, value: Any) -> Lanes:
        """Return another value of the same code."""
        return Lanes(self.code, value)

    def __add__(self, other: Lanes | float) -> Lanes:
        return self.made(self.code.builder.fadd(self.value, self.of(other)))

    def __sub__(self, other: Lanes | float) -> Lanes:
        return self.made(self.code.builder.fsub(self.value, self.of(other)))

    def __rsub__(self, other: float) -> Lanes:
        return self.made(self.code.builder.fsub(self.of(other), self.value))

    def __mul__(self, other: Lanes | float) -> Lanes:
        return self.made(self.code.builder.fmul(self.value, self.of(other)))

    def __rtruediv__(self, other: float) -> Lanes:
        return self.made(self.code.builder.fdiv(self.of(other), self.value))

    def __neg__(self) -> Lanes:
        return self.made(self.code.builder.fneg(self.value))

    def times_plus(self, factor: Lanes | float, term: Lanes | float) -> Lanes:
        """Return self * factor + term, rounded once or twice."""
        return self.made(self.code.fma(self.value, self.of(factor), self.of(term)))

    def where(self, sign: str, bound: Lanes | float, value: Lanes | float) -> Lanes:
        """Return the value where self compares so with the bound, else self; NaN stays."""
        return self.chosen(self.compared(sign, bound), value)

    def chosen(self, mask: Any, value: Lanes | float) -> Lanes:
        """Return the value where the mask is set, else self."""
        return self.made(self.code.builder.select(mask, self.of(value), self.value))

    def compared(self, sign: str, bound: Lanes | float) -> Any:
        """Return where self compares so with the bound; never with NaN."""
        return self.code.builder.fcmp_ordered(sign, self.value, self.of(bound))

    def bits(self) -> Bits:
        """Return the doubles' bits."""
        words = words_of(self.code)
        return Bits(self.code, self.code.builder.bitcast(self.value, words))

    def size(self) -> Lanes:
        """Return the absolute value."""
        return (self.bits() & ((1 << 63) - 1)).doubles()

    def signed_as(self, other: Lanes) -> Lanes:
        """Return self, which is not negative, with the sign of the other."""
        return (self.bits() | other.sign()).doubles()

    def sign(self) -> Bits:
        """Return the bit that tells of a minus sign, alone."""
        return self.bits() & (1 << 63)


class Bits:
    """A vector of integers of 64 bits."""

    def __init__(self, code: LaneCode, value: Any) -> None:
        self.code, self.value = code, value

    def _made(self, word: str, other: Bits | int) -> Bits:
        if isinstance(other, int):
            lanes, kind = self.code.lanes, words_of(self.code)
            signed = (other + (1 << 63)) % (1 << 64) - (1 << 63)
            given = ir.Constant(kind, signed if lanes == 1 else [signed] * lanes)
        else:
            given = other.value
        return Bits(self.code, getattr(self.code.builder, word)(self.value, given))

    def __add__(self, other: Bits | int) -> Bits:
        return self._made("add", other)

    def __sub__(self, other: Bits | int) -> Bits:
        return self._made("sub", other)

    def __and__(self, other: Bits | int) -> Bits:
        return self._made("and_", other)

    def __or__(self, other: Bits | int) -> Bits:
        return self._made("or_", other)

    def __xor__(self, other: Bits | int) -> Bits:
        return self._made("xor", other)

    def __lshift__(self, places: int) -> Bits:
        return self._made("shl", places)

    def __rshift__(self, places: int) -> Bits:
        return self._made("lshr", places)

    def doubles(self) -> Lanes:
        """Return the doubles that have these bits."""
        return Lanes(self.code, self.code.builder.bitcast(self.value, self.code.kind))


class Pair(NamedTuple):
    """An unevaluated sum: ``low`` is a few last places of ``high`` at most."""

    high: Lanes
    low: Lanes


def words_of(code: LaneCode) -> Any:
    """Return the type of the integers that stand for a vector's doubles."""
    word = ir.IntType(64)
    return word if code.lanes == 1 else ir.VectorType(word, code.lanes)


def exact_sum(large: Lanes, small: Lanes) -> Pair:
    """Return a sum with its rounding error; the first is 0 or not the smaller."""
    total = large + small
    return Pair(total, small - (total - large))


def whole(pair: Pair) -> Lanes:
    """Return the sum, rounded."""
    return pair.high + pair.low


def exact_product(one: Lanes, other: Lanes) -> Pair:
    """Return a product with its rounding error; sizes are below 1e290."""
    total = one * other
    if one.code.fused:
        rest = one.code.fused_multiply_add(one.value, other.value, (-total).value)
        return Pair(total, one.made(rest))
    (a, b), (c, d) = _halves(one), _halves(other)
    return Pair(total, ((a * c - total) + a * d + b * c) + b * d)


def _halves(value: Lanes) -> Pair:
    """Return two doubles of 26 bits that sum up to the value."""
    wide = value * (2.0**27 + 1.0)
    high = wide - (wide - value)
    return Pair(high, value - high)


def quotient(over: Pair, under: Pair) -> Pair:
    """Return a quotient to some 2^-100."""
    inverse = 1.0 / under.high
    first = over.high * inverse
    product = exact_product(first, under.high)
    rest = (over.high - product.high) - product.low
    return Pair(first, (rest + over.low - first * under.low) * inverse)


def polynomial(z: Lanes, factors: Sequence[float]) -> Lanes:
    """Return the polynomial whose ``factors`` begin with that of the power 0.

    Even and odd powers are summed apart, so that two sums are under way at a time.
    """
    if len(factors) < 4:
        return _horner(z, factors)
    square = z * z
    even, odd = (_horner(square, factors[start::2]) for start in (0, 1))
    return odd.times_plus(z, even)


def _horner(z: Lanes, factors: Sequence[float]) -> Lanes:
    *lower, highest = factors
    found = z.made(z.code.constant(highest))
    for factor in reversed(lower):
        found = found.times_plus(z, factor)
    return found


# Constants: found when code is written, for machine code is kept.


@cache
def parts_of(name: str, *bits: int) -> tuple[float, ...]:
    """Return a constant of mpmath as a sum of doubles, the first of so many bits, the last of 53.

    >>> parts_of("ln2", 42)
    (0.6931471805598903, 5.497923018708371e-14)
    """
    import mpmath

    with mpmath.workdps(DIGITS):
        rest, found = (
            {"ln2": +mpmath.ln2, "half_pi": mpmath.pi / 2, "third": mpmath.mpf(1) / 3}[name],
            [],
        )
        for count in bits:
            unit = mpmath.ldexp(1, mpmath.frexp(rest)[1] - count)
            found.append(float(mpmath.floor(rest / unit) * unit))
            rest -= found[-1]
        return (*found, float(rest))


@cache
def fitted(name: str) -> tuple[float, ...]:
    """Return the factors of the polynomial of that `SERIES`, that of the power 0 first."""
    import mpmath

    low, high, count, made = SERIES[name]
    with mpmath.workdps(DIGITS):
        function = made(mpmath)
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
"""Of each polynomial: the ends of its range, how many factors, and what it stands for. The ranges
end a little beyond ln(2)/2, its square, the squares of (sqrt(2) - 1)/(sqrt(2) + 1), pi/4, and
sqrt(2) - 1. So many factors leave less than 2^-55 of the function's value, 2^-66 in
"log_rest"."""


# Exponentials.

LEAST_EXPONENT, MOST_EXPONENT = -760.0, 720.0
"""Beyond these the exponential is 0, and infinite: n ln(2) with n of 12 bits."""


class _Doublings(NamedTuple):
    """The whole n and the rest r of n ln(2) + r, where r is not larger than ln(2)/2."""

    n: Lanes
    shifted: Lanes
    rest: Pair


def _doublings(x: Lanes, low: Lanes | None = None) -> _Doublings:
    """Return those of x, or of x + low."""
    high, rest = parts_of("ln2", 42)
    shifted = x.times_plus(1.0 / high, SHIFT)
    n = shifted - SHIFT
    left, off = n.times_plus(-high, x), n * rest
    off = off if low is None else off - low
    r = left - off
    return _Doublings(n, shifted, Pair(r, (left - r) - off))


def _power_of_two(shifted: Lanes) -> Lanes:
    """Return 2^n of n + `SHIFT`, for n of -1022 .. 1023."""
    return ((shifted.bits() << 52) + ONE_BITS).doubles()


def _bounded(x: Lanes, least: float, most: float) -> Lanes:
    return x.where("<", least, least).where(">", most, most)


def exponential(x: Lanes, low: Lanes | None = None) -> Lanes:
    """Return exp(x), or exp(x + low), to 1.2 ulp.

    It is multiplied by two halves of 2^n: only the last product may be rounded.
    """
    n, shifted, (r, _) = _doublings(_bounded(x, LEAST_EXPONENT, MOST_EXPONENT), low)
    more = (r * r).times_plus(polynomial(r, fitted("exp")), r)
    half = n.times_plus(0.5, SHIFT).bits() << 52
    other = (shifted.bits() << 52) - half
    return (more + 1.0) * (half + ONE_BITS).doubles() * (other + ONE_BITS).doubles()


class _Hyperbolic(NamedTuple):
    """Those of x, which lies next to n ln(2): to be multiplied by 2^up. ``fall`` is exp(-x)."""

    sinh: Pair
    cosh: Pair
    fall: Lanes
    up: Lanes
    n: Lanes


def _hyperbolic(x: Lanes) -> _Hyperbolic:
    """Return hyperbolic functions of x, not negative.

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
    found = _hyperbolic(x.size().where(">", MOST_EXPONENT, MOST_EXPONENT))
    return (found.sinh.high * _power_of_two(found.up + SHIFT)).signed_as(x)


def cosh(x: Lanes) -> Lanes:
    """Return the hyperbolic cosine, to 1.6 ulp."""
    found = _hyperbolic(x.size().where(">", MOST_EXPONENT, MOST_EXPONENT))
    return found.cosh.high * _power_of_two(found.up + SHIFT)


def tanh(x: Lanes) -> Lanes:
    """Return the hyperbolic tangent, to 1.8 ulp: from about 1 on it is 1 - exp(-x) / cosh(x)."""
    found = _hyperbolic(x.size().where(">", 25.0, 25.0))
    far = found.n.compared(">", 1.0)
    over = Pair(found.sinh.high.chosen(far, -found.fall), found.sinh.low.chosen(far, 0.0))
    base = x.made(x.code.constant(0.0)).chosen(far, 1.0)
    return (base + whole(quotient(over, found.cosh))).signed_as(x)


# Logarithms and powers.

BELOW_ONE = 0x3FE6A09E667F3BCD
"""The bits of the root of 1/2."""


def _mantissa(x: Lanes) -> tuple[Lanes, Lanes]:
    """Return k and m of x = 2^k m, where m lies between the roots of 1/2 and 2; x is positive."""
    small = x.compared("<", 2.0**-1022)
    bits = x.chosen(small, x * 2.0**54).bits()
    up = bits + (ONE_BITS + (1 << 52) - BELOW_ONE)
    raised = ((up >> 52) | SHIFT_BITS).doubles() - (2.0**52 + 1024.0)
    k = raised.chosen(small, raised - 54.0)
    return k, (bits - (up & (0xFFF << 52)) + (ONE_BITS + (1 << 52))).doubles()


def logarithm(x: Lanes) -> Lanes:
    """Return the natural logarithm, to 0.9 ulp."""
    found = _logarithm(*_mantissa(x))
    found = found.chosen(x.compared("==", INFINITY), INFINITY)
    found = found.chosen(x.compared("==", 0.0), -INFINITY)
    below = x.code.builder.fcmp_unordered("<", x.value, x.of(0.0))
    return found.chosen(below, NAN)


def _logarithm(k: Lanes, m: Lanes, more: Lanes | float = 0.0) -> Lanes:
    """Return that of 2^k m, and a little more."""
    high, rest = parts_of("ln2", 42)
    f = m - 1.0
    s = f * (1.0 / (m + 1.0))
    z, half = s * s, f * f * 0.5
    series = z.times_plus(polynomial(z, fitted("log")), half)
    low = s.times_plus(series, k.times_plus(rest, more))
    return k.times_plus(high, f - (half - low))


def area_sine(x: Lanes) -> Lanes:
    """Return the inverse of the hyperbolic sine, to 1.7 ulp.

    log(1 + u) with u = |x| + x^2 / (1 + sqrt(1 + x^2)), and log(2 |x|) from 2^28 on.
    """
    size = x.size()
    large = size.compared(">", 2.0**28)
    t = size.where(">", 2.0**28, 2.0**28)
    root = x.made(x.code.root(t.times_plus(t, 1.0).value))
    u = (t * t).times_plus(1.0 / (root + 1.0), t)
    total = u + 1.0
    below = u.compared("<", 1.0)
    lost = (total - u - 1.0).chosen(below, total - 1.0 - u)
    off = (-lost * (1.0 / total)).chosen(large, 0.0)
    k, m = _mantissa(total.chosen(large, size))
    found = _logarithm(k.chosen(large, k + 1.0), m, off)
    found = found.chosen(size.compared("==", INFINITY), INFINITY)
    missing = x.code.builder.fcmp_unordered("!=", x.value, x.value)
    return found.chosen(missing, NAN).signed_as(x)


def _logarithm_pair(x: Lanes) -> Pair:
    """Return the natural logarithm to 2^-65 of its value; x is positive and finite.

    That of m is 2 s (1 + z/3 + z^2 Q(z)) with s = (m - 1)/(m + 1) and z = s^2, all as pairs but Q.
    """
    k, m = _mantissa(x)
    over, under = m - 1.0, m + 1.0
    none = x.made(x.code.constant(0.0))
    s = quotient(Pair(over, none), Pair(under, m - (under - 1.0)))
    z = exact_product(s.high, s.high)
    z_low = (s.high * 2.0).times_plus(s.low, z.low)
    third, third_low = parts_of("third", 53)
    part = exact_product(z.high, x.made(x.code.constant(third)))
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
    """Return x to an exponent, to 1.6 ulp.

    The exponent is not 0, and its size is at most `LARGEST_EXPONENT`.
    """
    size = x.size()
    log = _logarithm_pair(size)
    factor = x.made(x.code.constant(exponent))
    product = exact_product(log.high, factor)
    found = exponential(product.high, factor.times_plus(log.low, product.low))
    at_zero, beyond = (0.0, INFINITY) if exponent > 0.0 else (INFINITY, 0.0)
    is_whole = exponent.is_integer()
    wrong = x.code.builder.fcmp_unordered(
        "!=" if is_whole else "<", x.value, x.of(x if is_whole else 0.0)
    )
    found = found.chosen(wrong, NAN)
    found = found.chosen(size.compared("==", 0.0), at_zero)
    found = found.chosen(size.compared("==", INFINITY), beyond)
    return found.signed_as(x) if is_whole and exponent % 2.0 == 1.0 else found


# Circles.


class _Turn(NamedTuple):
    """What is left of an angle without whole quarters, their number in the last bits, its sine
    and cosine."""

    quarters: Bits
    sine: Pair
    cosine: Pair


def _turn(x: Lanes) -> _Turn:
    """Take off the quarters, n pi/2, of an angle that is not larger than `TURNED`.

    In three parts: products with the first two are exact. It leaves 2^-120.
    """
    first, second, third = parts_of("half_pi", 40, 40)
    shifted = x.times_plus(1.0 / (first + second), SHIFT)
    n = shifted - SHIFT
    left, off = n.times_plus(-first, x), n * -second
    r = left + off
    gone = r - left
    lost = (left - (r - gone)) + (off - gone)
    high, low = exact_sum(r, n.times_plus(-third, lost))
    z = high * high
    half = z * 0.5
    sine = exact_sum(high, (high * z).times_plus(polynomial(z, fitted("sin")), low - half * low))
    cosine = exact_sum(x.made(x.code.constant(1.0)), -half)
    rest = (z * z).times_plus(polynomial(z, fitted("cos")), cosine.low - high * low)
    return _Turn(shifted.bits(), sine, exact_sum(cosine.high, rest))


def _even(quarters: Bits) -> Any:
    """Return where a number is even."""
    nothing = (quarters ^ quarters).value
    return quarters.code.builder.icmp_unsigned("==", (quarters & 1).value, nothing)


def _circle(x: Lanes, ahead: int) -> Bits:
    """Return the sine of an angle, not negative, and so many quarters."""
    turn = _turn(x)
    quarters = turn.quarters + ahead
    found = turn.cosine.high.chosen(_even(quarters), turn.sine.high)
    return found.bits() ^ ((quarters & 2) << 62)


def sine(x: Lanes) -> Lanes:
    """Return the sine, to 0.9 ulp."""
    return _within(x, "sin", (_circle(x.size(), 0) ^ x.sign()).doubles())


def cosine(x: Lanes) -> Lanes:
    """Return the cosine, to 0.9 ulp."""
    return _within(x, "cos", _circle(x.size(), 1).doubles())


def tangent(x: Lanes) -> Lanes:
    """Return the tangent, to 1.0 ulp."""
    turn = _turn(x.size())
    even = _even(turn.quarters)
    over, under = (
        Pair(*(b.chosen(even, a) for a, b in zip(*pair, strict=True)))
        for pair in ((turn.sine, turn.cosine), (turn.cosine, turn.sine))
    )
    found = whole(quotient(over, under)).bits() ^ ((turn.quarters & 1) << 63)
    return _within(x, "tan", (found ^ x.sign()).doubles())


def _within(x: Lanes, name: str, found: Lanes) -> Lanes:
    """Return what was found, and the C library's value where the argument is beyond `TURNED`."""
    code, builder = x.code, x.code.builder
    beyond = builder.fcmp_unordered(">", x.size().value, x.of(TURNED))
    flags = ir.IntType(code.lanes)
    somewhere = builder.icmp_unsigned("!=", builder.bitcast(beyond, flags), flags(0))
    before = builder.block
    with builder.if_then(somewhere, likely=False):
        asked = builder.select(beyond, code.function(name, x.value), found.value)
        after = builder.block
    total = builder.phi(code.kind)
    total.add_incoming(found.value, before)
    total.add_incoming(asked, after)
    return x.made(total)


def arctangent(x: Lanes) -> Lanes:
    """Return the arctangent, to 0.9 ulp.

    That of -1/x is taken from pi/2, that of (x - 1)/(x + 1) from pi/4.
    """
    size = x.size().where(">", 2.0**60, 2.0**60)
    middle, steep = size.compared(">", 2.0**0.5 - 1.0), size.compared(">", 1.0 + 2.0**0.5)
    none, one = (x.made(x.code.constant(value)) for value in (0.0, 1.0))
    less, more = size - 1.0, size + 1.0
    over = size.chosen(middle, less).chosen(steep, -1.0)
    over_low = none.chosen(middle, size - (less + 1.0)).chosen(steep, 0.0)
    under = one.chosen(middle, more).chosen(steep, size)
    under_low = none.chosen(middle, size - (more - 1.0)).chosen(steep, 0.0)
    t = quotient(Pair(over, over_low), Pair(under, under_low))
    half, half_low = parts_of("half_pi", 53)
    base = none.chosen(middle, half / 2.0).chosen(steep, half)
    base_low = none.chosen(middle, half_low / 2.0).chosen(steep, half_low)
    total, low = exact_sum(base, t.high)
    z = t.high * t.high
    low = (t.high * z).times_plus(polynomial(z, fitted("atan")), base_low + t.low) + low
    return (total + low).signed_as(x)


FUNCTIONS_OF_LANES: dict[str, Callable[[Lanes], Lanes]] = {
    "exp": exponential, "log": logarithm, "sin": sine, "cos": cosine, "tan": tangent,
    "sinh": sinh, "cosh": cosh, "tanh": tanh, "atan": arctangent, "asinh": area_sine,
}  # fmt: skip
"""Those of `lattice.force_program.UNARY` that are not made of comparisons."""

"""Programs for the machine: plain data, and the Jacobi functions.

The Jacobi functions sn, cn, dn, zeta and Theta are such programs, made from the modulus. The
argument is reduced to u = j K + r, |r| <= K/2, so that no function is evaluated near a
cancellation; u and K are sums of three floats there, for u may be 1e28 and must keep its place in
the period.  For m <= 1/2 the theta series run in sines and cosines of v = pi r / (2K) with the nome
q; for m > 1/2 Jacobi's imaginary transformation turns the same four series into hyperbolic
functions of w = pi r / (2K') with the nome q', down to m1 = 0 (q' = 0: tanh and sech).  Either nome
is below 0.0433.  Errors are below 1e-30 of max(1, |value|), plus 1e-45 |u| from the period; each
value comes with its bound.  Sources: DLMF 20.2, 20.7(viii), 22.2, 22.16(iii).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import mpmath
import numpy as np

from longwave.solutions.functions.multiprecision import MpmathFormula
from longwave.solutions.run.bytecode import Bytecode, Code, Operation, Value
from longwave.solutions.run.doubledouble import (
    Array,
    Three,
    quick_two_sum,
    split,
    split_three,
    two_prod,
    two_sum,
)
from longwave.solutions.run.linear_phase import CONSTANT_DIGITS, LONG, long_number
from longwave.solutions.run.machine import run_pairs
from longwave.support.compiled.jit import THREE, doubles, njit

if TYPE_CHECKING:
    from sympy import Expr

_PRECISE: Any = mpmath.MPContext()
_PRECISE.prec = 240

_PERIOD, _REST = 2.0**-150, 2.0**-104
"""Bounds of the error of the reduced argument, relative to the argument and to itself."""

_FARTHEST = 2.0**100
"""From as many quarter periods on, the quotient has more bits than two doubles."""


class JacobiProgram(NamedTuple):
    """The functions for one modulus: from what `reduced` makes, sn, cn, dn, zeta and Theta.

    ``quarter`` is K as three floats, 0 for an infinite one.
    """

    quarter: Three
    bytecode: Bytecode
    constants: Array

    def __call__(self, phase: Array) -> Array:
        """The values (functions, 3, points) at a phase (4, points): three floats and a bound."""
        out = np.empty((len(self.bytecode.outputs), 3, phase.shape[1]))
        run_pairs(self.bytecode, self.constants, reduced(phase, self.quarter), out)
        return out

    def only(self, wanted: Sequence[bool]) -> JacobiProgram:
        """Return what evaluates the wanted functions alone; what others are is undefined."""
        outputs = self.bytecode.outputs
        spare = next((o for o, is_wanted in zip(outputs, wanted, strict=True) if is_wanted), 0)
        kept = [o if is_wanted else spare for o, is_wanted in zip(outputs, wanted, strict=True)]
        return self._replace(bytecode=self.bytecode.only(kept)[0])


@lru_cache(maxsize=256)
def jacobi_program(m: Any, m1: Any, wanted: tuple[bool, ...] = (True,) * 5) -> JacobiProgram:
    """The program for long numbers m and m1 = 1 - m, mpf of any context.

    Of sn, cn, dn, zeta and Theta those that are not ``wanted`` are 0.

    Raises ValueError for Theta at m = 1, where the nome is 1.

    >>> from mpmath import mpf
    >>> sn, *_ = jacobi_program(mpf(0.25), mpf(0.75))(np.array([[1.0], [0.0], [0.0], [0.0]]))
    >>> sn[0].tolist()
    [0.8226355781298...]
    """
    ctx = _PRECISE
    m, m1 = ctx.convert(m), ctx.convert(m1)
    if wanted[-1] and m1 == 0:
        raise ValueError("m must satisfy m < 1, got 1 (Theta has no limit as m -> 1)")
    K, K1 = _quarter_period(m1), _quarter_period(m)
    ratio = K1 / K if m <= 0.5 else K / K1
    nome = ctx.exp(-ctx.pi * ratio)
    code = Code(inputs=5)
    values = (_circular if m <= 0.5 else _hyperbolic)(code, m, m1, K, K1, nome)
    needed = (value if is_wanted else 0 for value, is_wanted in zip(values, wanted, strict=True))
    bytecode = code.assemble([_number(code, value) for value in needed])
    quarter = split_three(K) if ctx.isfinite(K) else (0.0, 0.0, 0.0)
    constants = np.array([split(number) for number in bytecode.pool]).reshape(-1, 2)
    return JacobiProgram(quarter, replace(bytecode, pool=()), constants)


def _quarter_period(m1: Any) -> Any:
    """K for the parameter whose complement is m1."""
    ctx = _PRECISE
    return ctx.inf if m1 == 0 else ctx.pi / (2 * ctx.agm(1, ctx.sqrt(m1)))


def _number(code: Code, value: Any) -> int:
    if isinstance(value, Value):
        return value.number
    return code.with_constant(Operation.CONSTANT, value)


class _Series(NamedTuple):
    """Sums over n of the theta series; ``b_1 = 2 q cos 2v`` or ``2 q cosh 2w``.

    theta_3 and theta_4; ``theta_1/(2 q**(1/4) sin v)`` and ``theta_2/(2 q**(1/4) cos v)``; the
    latter's derivative ``rise``; ``-theta_3'/(4 q sin 2v)`` and ``theta_4'/(4 q sin 2v)``.
    """

    theta3: Any
    theta4: Any
    sine: Any
    cosine: Any
    rise: Any
    fall3: Any
    rise4: Any


def _series(q: Any, b1: Any) -> _Series:
    """The series, every multiple of the angle with its power of the nome: ``b_n <= q**(n/2)``."""
    square = q * q
    b2 = b1 * b1 - 2 * square
    b3 = b1 * (b2 - square)
    b4 = b1 * b3 - square * b2
    even = 1 + square * b2 + q**12 * b4
    odd = b1 + q**6 * b3 + q**20 * (b1 * b4)
    a1 = b1 + q
    a2 = b2 + q * a1
    a3 = b3 + q * a2
    a4 = b4 + q * a3
    c1 = b1 - q
    c2 = b2 - q * c1
    c3 = b3 - q * c2
    c4 = b4 - q * c3
    falling = 1 + 3 * q**6 * (b2 + square) + 5 * q**20 * b4
    rising = 2 * square * b1 + 4 * q**12 * (b3 + square * b1)
    return _Series(
        theta3=even + odd,
        theta4=even - odd,
        sine=1 - q * (a1 - q**3 * (a2 - q**5 * (a3 - q**7 * a4))),
        cosine=1 + q * (c1 + q**3 * (c2 + q**5 * (c3 + q**7 * c4))),
        rise=1 + q * (3 * a1 + q**3 * (5 * a2 + q**5 * (7 * a3 + 9 * q**7 * a4))),
        fall3=falling + rising,
        rise4=falling - rising,
    )


def _inverse(value: Any) -> Any:
    return value.made(Operation.RECIPROCAL) if isinstance(value, Value) else 1 / value


def _choose(odd: Value, one: Any, other: Any) -> Any:
    """``one`` on odd quarter periods, ``other`` on even ones; either may be a number."""
    if not isinstance(one, Value) and one == other:
        return one
    first, second = (Value(odd.code, _number(odd.code, value)) for value in (one, other))
    return first.made(Operation.CHOOSE, second, odd)


def _circular(code: Code, m: Any, m1: Any, K: Any, _: Any, q: Any) -> list[Any]:
    ctx = _PRECISE
    r, odd, sn_sign, cn_sign, zeta_sign = (Value(code, place) for place in range(5))
    root = ctx.root(m1, 4)
    sn_scale = 2 * ctx.root(q / m, 4) if m else ctx.one
    rate = ctx.pi / (2 * K)
    v = rate * r
    s, c = v.made(Operation.SINE), v.made(Operation.COSINE)
    sums = _series(q, q * (2 - 4 * (s * s)))
    sine, cosine = s * sums.sine, c * sums.cosine
    theta = _choose(odd, sums.theta3, sums.theta4)
    inverse = _inverse(theta)
    slope = (s * c) * _choose(odd, -1 * sums.fall3, sums.rise4)
    return [
        sn_sign * (sn_scale * _choose(odd, cosine, sine) * inverse),
        cn_sign * (sn_scale * root * _choose(odd, sine, cosine) * inverse),
        root * _choose(odd, sums.theta4, sums.theta3) * inverse,
        zeta_sign * (8 * q * rate * slope * inverse),
        theta,
    ]


def _hyperbolic(code: Code, m: Any, m1: Any, K: Any, K1: Any, q: Any) -> list[Any]:
    ctx = _PRECISE
    r, odd, sn_sign, cn_sign, zeta_sign = (Value(code, place) for place in range(5))
    rate = ctx.pi / (2 * K1)
    sn_scale = 1 / ctx.root(m, 4)
    on_even, on_odd = ctx.root(m1 / q, 4) / 2 if m1 else ctx.one, 2 * ctx.root(q * m1, 4)
    w = rate * r
    tanh, sech = w.made(Operation.TANH), w.made(Operation.SECH)
    cosh = sech.made(Operation.RECIPROCAL)
    square = cosh * cosh
    sums = _series(q, q * (4 * square - 2))
    inverse = _inverse(_choose(odd, sums.theta3, sums.cosine))
    sine = sn_scale * on_odd * (tanh * cosh) * sums.sine
    slope = tanh * _choose(odd, 8 * q * square * sums.fall3, sums.rise)
    zeta_rate = -ctx.pi / (2 * K * K1)
    scale = ctx.sqrt(K / K1) if m1 else ctx.zero
    fall = (-ctx.pi / (4 * K * K1) * (r * r)).made(Operation.EXPONENTIAL) if m1 else 0
    half = 2 * ctx.root(q, 4) * scale * (cosh * sums.cosine)
    return [
        sn_sign * (sn_scale * _choose(odd, sums.theta4, tanh * sums.sine) * inverse),
        cn_sign * (_choose(odd, sine, sn_scale * on_even * sech * sums.theta4) * inverse),
        _choose(odd, on_odd * cosh * sums.cosine, on_even * sech * sums.theta3) * inverse,
        zeta_sign * (zeta_rate * r + rate * slope * inverse),
        fall * _choose(odd, scale * sums.theta3, half),
    ]


@njit()
def _without(u: Three, j: float, quarter: Three) -> Three:
    """Return u - j K as three floats, with an error of 2^-155 |u|."""
    high, e = two_prod(quarter[0], j)
    middle, f = two_prod(quarter[1], j)
    high, g = two_sum(u[0], -high)
    middle, a = two_sum(u[1], -middle)
    middle, b = two_sum(middle, -e)
    middle, c = two_sum(middle, g)
    low = (u[2] - quarter[2] * j) + ((a - f) + (b + c))
    high, middle = two_sum(high, middle)
    middle, low = two_sum(middle, low)
    high, middle = two_sum(high, middle)
    middle, low = two_sum(middle, low)
    return high, middle, low


@njit(cache=True, examples=[(doubles(2), THREE, doubles(3))])
def _reduce(phase: Array, K: Three, out: Array) -> None:
    """A quotient of more than 53 bits takes the second step."""
    quarter = K[0] if K[0] != 0.0 else np.inf
    for i in range(phase.shape[1]):
        u, middle = two_sum(phase[0, i], phase[1, i])
        first = np.floor(u / quarter + 0.5)
        rest = _without((u, middle, phase[2, i]), first, K)
        second = np.floor(rest[0] / quarter + 0.5)
        high, middle, low = _without(rest, second, K)
        high, low = quick_two_sum(high, middle + low)
        j = first - 4.0 * np.floor(0.25 * first) + (second - 4.0 * np.floor(0.25 * second))
        j -= 4.0 * np.floor(0.25 * j)
        odd = j == 1.0 or j == 3.0
        turned, side = 1.0 if j < 2.0 else -1.0, 1.0 if high >= 0.0 else -1.0
        e = (phase[3, i] + _PERIOD * abs(u) + _REST * abs(high)) * (1.0 + 2.0**-50)
        out[0, 0, i], out[0, 1, i] = side * high, side * low
        out[0, 2, i] = math.inf if abs(first) + abs(second) > _FARTHEST else e
        out[1, 0, i] = 1.0 if odd else 0.0
        out[2, 0, i] = turned if odd else turned * side
        out[3, 0, i] = -turned * side if odd else turned
        out[4, 0, i] = side


def reduced(phase: Array, quarter: Three) -> Array:
    """A phase (4, points) without its quarter periods: the inputs (5, 3, points) of the program.

    |r| with the bound of its error; whether their number is odd, as 1 or 0; the signs of sn, cn and
    zeta.
    """
    out = np.zeros((5, 3, phase.shape[1]))
    _reduce(phase, quarter, out)
    return out


AGREEMENT = 1e-50
"""Relative difference of a constant from the same with twice the digits; three floats hold 48."""


class Numbers(NamedTuple):
    """What a program takes from the parameters' values, as mpf."""

    constants: list[Any]
    coefficients: list[tuple[Any, Any, Any, Any]]
    moduli: list[Any]


@dataclass(frozen=True)
class Program:
    """Values, xi and tau derivatives as a function of phases, Jacobi values, constants.

    The bytecode's inputs are the phases, then sn, cn, dn, zeta, theta of each call; ``calls`` has
    the place of each call's phase, and ``wanted`` which of the five it reads. ``fixed`` takes the
    parameters and gives the bytecode's constants, p, q, r, w of each of the ``phases``, then m of
    each call.
    """

    phases: int
    calls: Sequence[int]
    wanted: Sequence[Sequence[bool]]
    bytecode: Bytecode
    fixed: MpmathFormula

    def numbers(self, parameters: Sequence[Expr]) -> Numbers:
        """The numbers at these exact parameters, with so many digits that more change nothing."""
        digits, found = CONSTANT_DIGITS, self._fixed_with(CONSTANT_DIGITS, parameters)
        while True:
            digits, before = 2 * digits, found
            found = self._fixed_with(digits, parameters)
            zero = LONG.mpf(10) ** (-digits // 4)
            found = [
                0 * new if max(abs(old), abs(new)) < zero and not _agree(old, new) else new
                for old, new in zip(before, found, strict=True)
            ]
            if all(new == 0 or _agree(old, new) for old, new in zip(before, found, strict=True)):
                break
        second = len(found) - len(self.calls)
        first = second - 4 * self.phases
        coefficients = zip(*(iter(found[first:second]),) * 4, strict=True)
        return Numbers(found[:first], list(coefficients), found[second:])

    def _fixed_with(self, digits: int, parameters: Sequence[Expr]) -> list[Any]:
        with LONG.workdps(digits):
            values = self.fixed(LONG, *map(long_number, parameters))
            return [LONG.convert(value) for value in values]


def _agree(old: Any, new: Any) -> bool:
    return bool(abs(new - old) <= AGREEMENT * abs(new))

"""Programs for the machine as plain data, and the programs of the Jacobi functions.

The programs of sn, cn, dn, zeta and Theta are generated from the modulus. The argument is reduced
to u = j K + r, |r| <= K/2, so that no function is evaluated near a cancellation. There u and K are
sums of three floats, because u may be 1e28 and must keep its position in the period.  For m <= 1/2
the theta series use sines and cosines of v = pi r / (2K) with the nome q. For m > 1/2 Jacobi's
imaginary transformation turns the same four series into hyperbolic functions of w = pi r / (2K')
with the nome q', down to m1 = 0 (q' = 0: tanh and sech).  Either nome is below 0.0433.  Errors are
below 1e-30 of max(1, |value|), plus 1e-45 |u| from the period; each value comes with its bound.
Sources: DLMF 20.2, 20.7(viii), 22.2, 22.16(iii).
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
from longwave.solutions.run import doubledouble as dd
from longwave.solutions.run.bytecode import Bytecode, Code, Operation, Value
from longwave.solutions.run.linear_phase import CONSTANT_DIGITS, LONG, long_number
from longwave.solutions.run.machine import run_pairs
from longwave.support.compiled.jit import THREE, doubles, njit

if TYPE_CHECKING:
    from sympy import Expr

_PRECISE: Any = mpmath.MPContext()
_PRECISE.prec = 240

_PERIOD_ERROR, _REDUCTION_ERROR = 2.0**-150, 2.0**-104
"""Two parts of the error bound of a reduced argument: the first is relative to the argument before
its reduction, the second to the reduced argument."""

_MAX_QUARTERS = 2.0**100
"""Number of quarter periods beyond which the error bound of a reduced phase is infinite."""


class JacobiProgram(NamedTuple):
    """The functions sn, cn, dn, zeta and Theta for one modulus, on the inputs from `reduced`.

    ``quarter`` is K as three floats, 0 if K is infinite.
    """

    quarter: dd.Three
    bytecode: Bytecode
    constants: dd.Array

    def __call__(self, phase: dd.Array) -> dd.Array:
        """Return values (functions, 3, points) at a phase (4, points): three floats and a bound."""
        out = np.empty((len(self.bytecode.outputs), 3, phase.shape[1]))
        run_pairs(self.bytecode, self.constants, reduced(phase, self.quarter), out)
        return out

    def only(self, requested: Sequence[bool]) -> JacobiProgram:
        """Return a program of the requested functions only; the values of others are undefined."""
        pairs = list(zip(self.bytecode.outputs, requested, strict=True))
        substitute = next((output for output, is_requested in pairs if is_requested), 0)
        outputs = [output if is_requested else substitute for output, is_requested in pairs]
        return self._replace(bytecode=self.bytecode.only(outputs)[0])


@lru_cache(maxsize=256)
def jacobi_program(m: Any, m1: Any, requested: tuple[bool, ...] = (True,) * 5) -> JacobiProgram:
    """Return the program for long numbers m and m1 = 1 - m, mpf of any context.

    Functions among sn, cn, dn, zeta and Theta that are not ``requested`` are 0.

    Raises ValueError for Theta at m = 1, where the nome is 1.

    >>> from mpmath import mpf
    >>> sn, *_ = jacobi_program(mpf(0.25), mpf(0.75))(np.array([[1.0], [0.0], [0.0], [0.0]]))
    >>> sn[0].tolist()
    [0.8226355781298...]
    """
    ctx = _PRECISE
    m, m1 = ctx.convert(m), ctx.convert(m1)
    if requested[-1] and m1 == 0:
        raise ValueError("m must satisfy m < 1, got 1 (Theta has no limit as m -> 1)")
    K, K1 = _quarter_period(m1), _quarter_period(m)
    ratio = K1 / K if m <= 0.5 else K / K1
    nome = ctx.exp(-ctx.pi * ratio)
    code = Code(inputs=5)
    values = (_circular if m <= 0.5 else _hyperbolic)(code, m, m1, K, K1, nome)
    needed = (v if is_requested else 0 for v, is_requested in zip(values, requested, strict=True))
    bytecode = code.assemble([code.number(value) for value in needed])
    quarter = dd.split_three(K) if ctx.isfinite(K) else (0.0, 0.0, 0.0)
    constants = np.array([dd.split(number) for number in bytecode.pool]).reshape(-1, 2)
    return JacobiProgram(quarter, replace(bytecode, pool=()), constants)


def _quarter_period(m1: Any) -> Any:
    """Return the quarter period K for m = 1 - m1; infinity for m1 = 0."""
    ctx = _PRECISE
    return ctx.inf if m1 == 0 else ctx.pi / (2 * ctx.agm(1, ctx.sqrt(m1)))


class _Series(NamedTuple):
    """Sums over n of the theta series; ``b_1 = 2 q cos 2v`` or ``2 q cosh 2w``.

    Fields: theta_3, theta_4, ``theta_1/(2 q**(1/4) sin v)``, ``theta_2/(2 q**(1/4) cos v)``,
    ``-theta_2'/(2 q**(1/4) sin v)``, ``-theta_3'/(4 q sin 2v)``, ``theta_4'/(4 q sin 2v)``.
    """

    theta3: Any
    theta4: Any
    sine: Any
    cosine: Any
    rise: Any
    fall3: Any
    rise4: Any


def _series(q: Any, b1: Any) -> _Series:
    """Sum the theta series, whose terms ``b_n = 2 q**n cos 2 n v`` (or cosh) obey a recurrence."""
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
    return value.apply(Operation.RECIPROCAL) if isinstance(value, Value) else 1 / value


def _choose(odd: Value, one: Any, other: Any) -> Any:
    """Return ``one`` where ``odd`` is 1, else ``other``; both are values or numbers."""
    if not isinstance(one, Value) and one == other:
        return one
    first, second = (Value(odd.code, odd.code.number(value)) for value in (one, other))
    return first.apply(Operation.CHOOSE, second, odd)


def _circular(code: Code, m: Any, m1: Any, K: Any, _: Any, q: Any) -> list[Any]:
    ctx = _PRECISE
    r, odd, sn_sign, cn_sign, zeta_sign = (Value(code, index) for index in range(5))
    root = ctx.root(m1, 4)
    sn_scale = 2 * ctx.root(q / m, 4) if m else ctx.one
    rate = ctx.pi / (2 * K)
    v = rate * r
    s, c = v.apply(Operation.SINE), v.apply(Operation.COSINE)
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
    r, odd, sn_sign, cn_sign, zeta_sign = (Value(code, index) for index in range(5))
    rate = ctx.pi / (2 * K1)
    sn_scale = 1 / ctx.root(m, 4)
    on_even, on_odd = ctx.root(m1 / q, 4) / 2 if m1 else ctx.one, 2 * ctx.root(q * m1, 4)
    w = rate * r
    tanh, sech = w.apply(Operation.TANH), w.apply(Operation.SECH)
    cosh = sech.apply(Operation.RECIPROCAL)
    square = cosh * cosh
    sums = _series(q, q * (4 * square - 2))
    inverse = _inverse(_choose(odd, sums.theta3, sums.cosine))
    sine = sn_scale * on_odd * (tanh * cosh) * sums.sine
    slope = tanh * _choose(odd, 8 * q * square * sums.fall3, sums.rise)
    zeta_rate = -ctx.pi / (2 * K * K1)
    scale = ctx.sqrt(K / K1) if m1 else ctx.zero
    fall = (-ctx.pi / (4 * K * K1) * (r * r)).apply(Operation.EXPONENTIAL) if m1 else 0
    half = 2 * ctx.root(q, 4) * scale * (cosh * sums.cosine)
    return [
        sn_sign * (sn_scale * _choose(odd, sums.theta4, tanh * sums.sine) * inverse),
        cn_sign * (_choose(odd, sine, sn_scale * on_even * sech * sums.theta4) * inverse),
        _choose(odd, on_odd * cosh * sums.cosine, on_even * sech * sums.theta3) * inverse,
        zeta_sign * (zeta_rate * r + rate * slope * inverse),
        fall * _choose(odd, scale * sums.theta3, half),
    ]


@njit()
def _subtract_quarters(u: dd.Three, j: float, quarter: dd.Three) -> dd.Three:
    """Return u - j K as three floats, with an error of 2^-155 |u|."""
    high, e = dd.two_prod(quarter[0], j)
    middle, f = dd.two_prod(quarter[1], j)
    high, g = dd.two_sum(u[0], -high)
    middle, a = dd.two_sum(u[1], -middle)
    middle, b = dd.two_sum(middle, -e)
    middle, c = dd.two_sum(middle, g)
    low = (u[2] - quarter[2] * j) + ((a - f) + (b + c))
    return dd.normalized(high, middle, low)


@njit(cache=True, examples=[(doubles(2), THREE, doubles(3))])
def _reduce(phase: dd.Array, K: dd.Three, out: dd.Array) -> None:
    """Fill ``out`` with phases reduced by quarter periods, in two steps for very large phases."""
    quarter = K[0] if K[0] != 0.0 else np.inf
    for i in range(phase.shape[1]):
        u, middle = dd.two_sum(phase[0, i], phase[1, i])
        first = np.floor(u / quarter + 0.5)
        remainder = _subtract_quarters((u, middle, phase[2, i]), first, K)
        second = np.floor(remainder[0] / quarter + 0.5)
        high, middle, low = _subtract_quarters(remainder, second, K)
        high, low = dd.quick_two_sum(high, middle + low)
        j = first - 4.0 * np.floor(0.25 * first) + (second - 4.0 * np.floor(0.25 * second))
        j -= 4.0 * np.floor(0.25 * j)
        odd = j == 1.0 or j == 3.0
        half_turn_sign, sign = 1.0 if j < 2.0 else -1.0, 1.0 if high >= 0.0 else -1.0
        e = (phase[3, i] + _PERIOD_ERROR * abs(u) + _REDUCTION_ERROR * abs(high)) * (1.0 + 2.0**-50)
        out[0, 0, i], out[0, 1, i] = sign * high, sign * low
        out[0, 2, i] = math.inf if abs(first) + abs(second) > _MAX_QUARTERS else e
        out[1, 0, i] = 1.0 if odd else 0.0
        out[2, 0, i] = half_turn_sign if odd else half_turn_sign * sign
        out[3, 0, i] = -half_turn_sign * sign if odd else half_turn_sign
        out[4, 0, i] = sign


def reduced(phase: dd.Array, quarter: dd.Three) -> dd.Array:
    """Reduce a phase (4, points) by quarter periods: the inputs (5, 3, points) of the program.

    They are |r| with the bound of its error, the parity of the number of quarter periods (1 if
    odd), and the signs of sn, cn and zeta.
    """
    out = np.zeros((5, 3, phase.shape[1]))
    _reduce(phase, quarter, out)
    return out


CONVERGED_CHANGE = 1e-50
"""Relative change of a constant, when digits are doubled, that counts as converged: three floats
hold 48 digits."""


class Numbers(NamedTuple):
    """Constants, phase coefficients and moduli of a program at given parameters, as mpf."""

    constants: list[Any]
    coefficients: list[tuple[Any, Any, Any, Any]]
    moduli: list[Any]


@dataclass(frozen=True)
class Program:
    """Program for values and their xi and tau derivatives, from phases and Jacobi functions.

    The bytecode's inputs are the phases, then sn, cn, dn, zeta, theta of each call. ``calls`` has
    the index of each call's phase, ``requested`` which of the five functions it reads. ``fixed``
    returns, from the parameters, the bytecode's constants, then p, q, r, w of each of the
    ``phases``, then m of each call.
    """

    phases: int
    calls: Sequence[int]
    requested: Sequence[Sequence[bool]]
    bytecode: Bytecode
    fixed: MpmathFormula

    def numbers(self, parameters: Sequence[Expr]) -> Numbers:
        """Compute the numbers at exact parameters, doubling the digits until they converge."""
        digits, numbers = CONSTANT_DIGITS, self._fixed_with(CONSTANT_DIGITS, parameters)
        while True:
            digits, previous = 2 * digits, numbers
            numbers = self._fixed_with(digits, parameters)
            zero = LONG.mpf(10) ** (-digits // 4)
            numbers = [
                0 * new if max(abs(old), abs(new)) < zero and not _agree(old, new) else new
                for old, new in zip(previous, numbers, strict=True)
            ]
            pairs = zip(previous, numbers, strict=True)
            if all(new == 0 or _agree(old, new) for old, new in pairs):
                break
        first_modulus = len(numbers) - len(self.calls)
        first_coefficient = first_modulus - 4 * self.phases
        coefficients = zip(*(iter(numbers[first_coefficient:first_modulus]),) * 4, strict=True)
        return Numbers(numbers[:first_coefficient], list(coefficients), numbers[first_modulus:])

    def _fixed_with(self, digits: int, parameters: Sequence[Expr]) -> list[Any]:
        with LONG.workdps(digits):
            values = self.fixed(LONG, *map(long_number, parameters))
            return [LONG.convert(value) for value in values]


def _agree(old: Any, new: Any) -> bool:
    return bool(abs(new - old) <= CONVERGED_CHANGE * abs(new))

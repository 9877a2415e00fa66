"""A wave that moves along the lattice, its initial data, and what feeds a window at its front.

Its parameters may be multiples of the quarter period: "K/2", "3*K/4", "K". The grammar is
``[integer *] K [/ integer]`` and nothing else; nothing is evaluated as code.

The feed is the wave's initial far field, moved rigidly. In the frame that moves with it this is one
smooth function, wanted on few hundred sites over and over again. It is therefore evaluated once, on
Chebyshev points, and interpolated from there.
"""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from typing import Protocol

import numpy as np
import sympy as sp
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

import derive
from derive.algebra.exact_numbers import exact_number
from lattice.model import Model
from solutions import ClosedForm, Wave, WaveValues
from solutions.run.jit import njit

Array = NDArray[np.float64]
Sites = NDArray[np.int64]

DEGREES = (16, 32, 64, 128)
"""Degrees tried: Y2's far field takes the first of them."""

INTERPOLATION_ERROR = 1e-14
"""Largest error of the interpolation, of y/eps or of what is largest."""


GRAMMAR = re.compile(r"(?:(?P<times>\d{1,6})\s*\*\s*)?K(?:\s*/\s*(?P<over>\d{1,6}))?")


def quarter_period_multiple(name: str, text: str) -> Fraction:
    """The rational r for which ``text`` means r K.

    Raises ValueError for anything outside the grammar.

    >>> quarter_period_multiple("alpha", "3*K/4")
    Fraction(3, 4)
    """
    match = GRAMMAR.fullmatch(text.strip())
    if match is None or int(match["over"] or 1) == 0:
        raise ValueError(
            f"{name} must be a number or a multiple of K, got {text!r} (such as 0.7 or '3*K/4')"
        )
    return Fraction(int(match["times"] or 1), int(match["over"] or 1))


def exact_quantity(name: str, value: float | str, k: sp.Expr | None) -> float | sp.Expr:
    """``value`` as a wave takes it: a number unchanged, "K/2" as SymPy's elliptic_k(k**2)/2.

    ``k`` is the exact modulus, None if the wave has none (then a multiple of K is refused).
    """
    if not isinstance(value, str):
        return value
    multiple = quarter_period_multiple(name, value)
    if k is None:
        raise ValueError(f"{name} must be a number, got {value!r} (K needs the modulus k)")
    return sp.Rational(multiple.numerator, multiple.denominator) * sp.elliptic_k(k**2)


def build_wave(form: ClosedForm, constants: Model, values: Mapping[str, float | str]) -> Wave:
    """The wave of a closed form on a lattice, with numbers in.

    Raises ValueError for a parameter outside its domain, K3 != 0 and K4 of the wrong sign for the
    wave's equation.
    """
    if constants.K3 != 0:
        raise ValueError(
            f"K3 must be 0 for an mKdV wave, got {constants.K3:g} "
            "(order eps^4 of the reduction reads K3 (Y^2)_XX = 0)"
        )
    if constants.K4 * form.equation.s <= 0:
        sign = ">" if form.equation.s > 0 else "<"
        raise ValueError(
            f"K4 must satisfy K4 {sign} 0 for {form.name}, got {constants.K4:g} "
            f"(it solves the {form.equation.name} equation)"
        )
    modulus = exact_number("k", values["k"]) if "k" in values else None
    exact = {name: exact_quantity(name, value, modulus) for name, value in values.items()}
    return Wave(form, derive.mkdv_normal_form(constants.K2, constants.K4), **exact)


class _InitialVelocity(Protocol):
    def __call__(self, Y_X: Array, Y_T: Array, c: float, eps: float) -> Array: ...


@cache
def _initial_velocity() -> _InitialVelocity:
    expression = derive.initial_velocity()
    symbols = {symbol.name: symbol for symbol in expression.free_symbols}
    arguments = [symbols[name] for name in ("Y_X", "Y_T", "c", "eps")]
    function: _InitialVelocity = sp.lambdify(arguments, expression, "numpy")
    return function


@dataclass(frozen=True)
class MovingWave:
    """A wave on the lattice from ``times[0]`` on, compared within ``compared`` sites of c t.

    The later ``times`` are those that count, in order. Raises ValueError if they are not in order.
    """

    wave: Wave
    constants: Model
    eps: float
    times: tuple[float, ...]
    compared: int

    def __post_init__(self) -> None:
        if len(self.times) < 2 or sorted(self.times) != list(self.times):
            raise ValueError(f"times must increase from t0 on, got {self.times} (sort them)")

    @property
    def t0(self) -> float:
        """The time of the initial data."""
        return self.times[0]

    @property
    def end(self) -> float:
        """The last time."""
        return self.times[-1]

    @property
    def duration(self) -> float:
        """The time from the first to the last."""
        return self.end - self.t0

    @property
    def speed(self) -> float:
        """The speed c of long waves."""
        return self.constants.sound_speed()

    @property
    def level(self) -> float:
        """Strain of the constant background, 0 on a periodic one."""
        return self.eps * (self.wave.constant_background or 0.0)

    def frame(self, t: float) -> int:
        """The site nearest to c t: the middle of the compared region."""
        return math.floor(self.speed * t + 0.5)

    def compared_sites(self, t: float) -> Sites:
        """The sites within ``compared`` of c t."""
        return self.frame(t) + np.arange(-self.compared, self.compared + 1)

    def initial_data(self, sites: ArrayLike) -> tuple[Array, Array]:
        """Strain y_n = eps Y and velocity s_n of the ansatz at the sites (any real), at time t0."""
        return self._data(self.wave.at(sites, self.t0, self.eps), self.speed)

    def rigid_offsets(self, speed: float, sites: Sites, t: float) -> Array:
        """Sites at time t, from the place that began at c t0 and moves at ``speed``."""
        begin = self.speed * self.t0
        return np.asarray((sites - begin) - speed * (t - self.t0), dtype=np.float64)

    def rigid_data(self, speed: float, offsets: ArrayLike) -> tuple[Array, Array]:
        """Strain and velocity of the initial strain that moves rigidly at ``speed``.

        Far from the crest, on a constant background, this is what the lattice itself does with the
        wave's algebraic tail, which is long and weak; ``speed`` is the sound speed there,
        ``offsets`` are as `rigid_offsets` gives them.
        """
        X = self.eps * np.asarray(offsets, dtype=np.float64)
        value = self.wave(X, self.eps**3 * self.t0)
        return self._data(value._replace(Y_T=np.zeros_like(X)), speed)

    def _data(self, value: WaveValues, c: float) -> tuple[Array, Array]:
        """Strain and velocity of the ansatz at speed c where the wave has the given values."""
        return self.eps * value.Y, _initial_velocity()(value.Y_X, value.Y_T, c, self.eps)


_jit = njit(cache=True, fastmath={"contract"}, error_model="numpy")


@_jit
def _clenshaw(coefficients: Array, u: Array) -> Array:
    """Sums of coefficients[:, k] T_k(u), of shape (rows of ``coefficients``, u.size)."""
    rows, terms = coefficients.shape
    found = np.empty((rows, u.size))
    for row in range(rows):
        c = coefficients[row]
        for i in range(u.size):
            one, two = 0.0, 0.0
            for k in range(terms - 1, 0, -1):
                one, two = c[k] + 2.0 * u[i] * one - two, one
            found[row, i] = c[0] + u[i] * one - two
    return found


@dataclass(frozen=True)
class Tail:
    """The initial strain that moves at ``speed``, and its velocity, on a stretch of its frame.

    ``low`` and ``high`` are offsets in sites from the place that began at c t0.
    """

    moving: MovingWave
    speed: float
    low: float
    high: float

    def at(self, sites: Sites, t: float) -> tuple[Array, Array]:
        """Strain and velocity at time t on the sites, which must be in the stretch by then."""
        offsets = self.moving.rigid_offsets(self.speed, sites, t)
        if self._coefficients is None:
            return self.moving.rigid_data(self.speed, offsets)
        y, s = _clenshaw(self._coefficients, self._unit(offsets))
        return y, s

    def _unit(self, offsets: Array) -> Array:
        """The stretch as -1 .. 1."""
        return (offsets - 0.5 * (self.low + self.high)) * (2.0 / (self.high - self.low))

    def _exact(self, u: Array) -> Array:
        offsets = 0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * u
        return np.stack(self.moving.rigid_data(self.speed, offsets))

    @cached_property
    def _coefficients(self) -> Array | None:
        """Those of strain and velocity; None if no degree gives what lies between its points."""
        for degree in DEGREES:
            points = chebyshev.chebpts1(degree + 1)
            values = self._exact(points)
            level = values[:, 0]  # small coefficients then have small roundings
            found = (values.T - level).T @ chebyshev.chebvander(points, degree) * 2.0 / points.size
            found[:, 0] = 0.5 * found[:, 0] + level
            between = np.concatenate([[-1.0], 0.5 * (points[1:] + points[:-1]), [1.0]])
            exact = self._exact(between)
            error = np.abs(_clenshaw(found, between) - exact).max()
            if error <= INTERPOLATION_ERROR * max(self.moving.eps, np.abs(exact).max()):
                return found
        return None

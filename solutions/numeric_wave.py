"""A wave as numbers: its values at arrays of points, without the formulas that they came from.

The points are checked, broadcast, and cut into chunks that stay in the cache.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, lru_cache, partial
from numbers import Integral, Real
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from solutions.run.doubledouble import split
from solutions.run.linear_phase import LONG, LinearPhase, Variables, long_number
from solutions.run.machine import scale_rows
from solutions.run.program import PointEvaluator

__all__ = [
    "NumericWave",
    "Part",
    "Side",
    "WaveNumbers",
    "WaveValues",
    "check_points",
    "evaluate_points",
]

Array = NDArray[np.float64]
Side = Literal["left", "right"]
Part = Literal["wave", "background", "left", "right"]

CERTAIN = 5e-14
"""Largest bound of an error, in units of max(1, |value|), that double-double may leave."""

MOST_UNCERTAIN = 1000
"""Points with larger bounds that mpmath settles, at 5 to 100 ms each; more are refused."""


class WaveValues(NamedTuple):
    """``Y`` and its derivatives with respect to X and T, arrays of one shape."""

    Y: Array
    Y_X: Array
    Y_T: Array


class WaveNumbers(NamedTuple):
    """What a wave is beside its values.

    ``rates`` are a, b and c of the normal form as long numbers, ``a`` and ``b`` the nearest
    doubles, ``s`` its sign; ``is_bare`` says that a periodic wave has no background but itself.
    """

    name: str
    rates: tuple[Any, Any, Any]
    a: float
    b: float
    s: int
    wavelength: float | None
    constant_background: float | None
    is_bare: bool


class NumericWave:
    """``Y(X, T) = U(a X, b T)`` as numbers; `solutions.Wave` says what they are.

    ``numbers`` are the wave's, ``make`` gives the evaluator of a part, ``settle`` the values and
    derivatives of a part at a point (in the given variables) where double-double is not enough.
    """

    def __init__(
        self,
        numbers: WaveNumbers,
        make: Callable[[Part], PointEvaluator],
        settle: Callable[[Part, Variables, float, float], Array],
    ) -> None:
        self.numbers = numbers
        self._make, self._settle = make, settle
        self._evaluators: dict[Part, PointEvaluator] = {}
        self._known_phases: dict[tuple[Part, object], list[LinearPhase]] = {}
        self._lattices: dict[object, Variables] = {}

    @property
    def wavelength(self) -> float | None:
        """The period of the background in X, None if the background is constant."""
        return self.numbers.wavelength

    @property
    def constant_background(self) -> float | None:
        """The constant that the wave tends to on both sides, None if there is none."""
        return self.numbers.constant_background

    def __call__(self, X: ArrayLike, T: ArrayLike) -> WaveValues:
        """Y, Y_X, Y_T at the broadcast points (X, T)."""
        return self._evaluate("wave", self._slow, X, T)

    def at(self, n: ArrayLike, t: ArrayLike, eps: float) -> WaveValues:
        """Y, Y_X, Y_T at site n (any real) and lattice time t.

        The phases are formed in double-double from (n, t, eps); ``X = eps (n - c t)`` and
        ``T = eps**3 t`` are never rounded.
        """
        return self._evaluate("wave", self._lattice(eps), n, t)

    def pairs_at(self, n: ArrayLike, t: ArrayLike, eps: float) -> WaveValues:
        """``at`` in double-double: arrays (2, ...) of high and low parts, about 30 digits."""
        return WaveValues(*self._bounded("wave", self._lattice(eps), n, t)[:, :2])

    def phase_zeros(self, t: float, eps: float) -> list[float]:
        """The sites at which one of the wave's phases vanishes at lattice time t, ascending.

        The crest of a localised wave is near one of them.
        """
        zeros = {phase.zero(t) for phase in self._phases("wave", self._lattice(eps))}
        return sorted(zero for zero in zeros if zero is not None)

    def background(self, X: ArrayLike, T: ArrayLike) -> WaveValues:
        """The bare background wave of the same phase (or the constant) at (X, T)."""
        return self._evaluate("background", self._slow, X, T)

    def background_at(self, n: ArrayLike, t: ArrayLike, eps: float) -> WaveValues:
        """``background`` at site n and lattice time t."""
        return self._evaluate("background", self._lattice(eps), n, t)

    def far_field(self, X: ArrayLike, T: ArrayLike, side: Side) -> WaveValues:
        """What the wave tends to as X goes to -infinity ("left") or +infinity ("right")."""
        return self._evaluate(check_side(side), self._slow, X, T)

    def far_field_at(self, n: ArrayLike, t: ArrayLike, eps: float, side: Side) -> WaveValues:
        """``far_field`` at site n and lattice time t."""
        return self._evaluate(check_side(side), self._lattice(eps), n, t)

    @cached_property
    def _slow(self) -> Variables:
        a, b, _ = self.numbers.rates
        return Variables(a, b, LONG.zero)

    @cached_property
    def _scales(self) -> tuple[tuple[float, float], ...]:
        a, b, _ = self.numbers.rates
        return tuple(split(rate) for rate in (LONG.one, a, b))

    def _lattice(self, eps: object) -> Variables:
        exact = _exact_eps(eps)
        if exact not in self._lattices:
            (a, b, c), e = self.numbers.rates, long_number(exact)
            self._lattices[exact] = Variables(a * e, b * e**3, -a * c * e, exact)
        return self._lattices[exact]

    def _phases(self, part: Part, variables: Variables) -> list[LinearPhase]:
        key = (part, variables.eps)
        if key not in self._known_phases:
            try:
                self._known_phases[key] = self._evaluator(part).phases(variables)
            except OverflowError as error:
                raise ValueError(self._out_of_range(error)) from None
        return self._known_phases[key]

    def _out_of_range(self, error: OverflowError) -> str:
        return (
            f"parameters and eps must keep every coefficient within 1e-250 .. 1e250, got {error} "
            f"for {self.numbers.name} (use Wave.mp, or less extreme ones)"
        )

    def _evaluator(self, part: Part) -> PointEvaluator:
        if part not in self._evaluators:
            self._evaluators[part] = self._make(part)
        return self._evaluators[part]

    def _evaluate(self, part: Part, variables: Variables, x: ArrayLike, t: ArrayLike) -> WaveValues:
        return WaveValues(*self._bounded(part, variables, x, t)[:, 0])

    def _bounded(self, part: Part, variables: Variables, x: ArrayLike, t: ArrayLike) -> Array:
        """Value and derivatives: high parts, low parts, bounds of their errors (3, 3, ...)."""
        x, t = check_points(x, t)
        phases = self._phases(part, variables)
        rows = evaluate_points(partial(self._evaluator(part), phases), x, t)
        rows = scale_rows(rows, self._scales)
        with np.errstate(invalid="ignore"):
            certain = rows[:, 2] <= CERTAIN * np.maximum(1, np.abs(rows[:, 0]))
        uncertain = np.argwhere(~np.all(certain, axis=0))
        if len(uncertain) > MOST_UNCERTAIN:
            first = tuple(uncertain[0])
            raise ValueError(
                f"at most {MOST_UNCERTAIN} points may need more than double-double, got "
                f"{len(uncertain)}, the first at ({x[first]:g}, {t[first]:g}) (use Wave.mp there)"
            )
        for place in map(tuple, uncertain):
            rows[(slice(None), slice(None), *place)] = self._settle(
                part, variables, x[place], t[place]
            )
        return rows


def _exact_eps(eps: object) -> Any:
    """The exact number meant by ``eps``, which must be positive: a Fraction, or SymPy's."""
    if isinstance(eps, float) and 0.0 < eps < np.inf:
        return Fraction(repr(float(eps)))
    from derive.algebra.exact_numbers import exact_number

    exact = exact_number("eps", eps)
    if not exact > 0:
        raise ValueError(f"eps must satisfy eps > 0, got {eps} (0.05 is usual)")
    return Fraction(int(exact.p), int(exact.q)) if exact.is_Rational else exact


def check_side(side: Side) -> Side:
    """``side``, or a ValueError if it is none."""
    if side not in ("left", "right"):
        raise ValueError(f"side must be 'left' or 'right', got {side!r} (a far field has two)")
    return side


CHUNK = 4096


@lru_cache(maxsize=1)
def _executor() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="wave")


def evaluate_points(function: Callable[[Array, Array], Array], x: Array, t: Array) -> Array:
    """``function`` at points of one shape: ``(..., points)`` becomes ``(..., *shape)``.

    ``function`` takes flat contiguous arrays of one size. Chunks run in threads, as the compiled
    loops release the interpreter.

    >>> grid = check_points([1, 2], [[3], [4]])
    >>> evaluate_points(lambda x, t: np.stack([x, x * t]), *grid).tolist()
    [[[1.0, 2.0], [1.0, 2.0]], [[3.0, 6.0], [4.0, 8.0]]]
    """
    flat_x, flat_t = np.ravel(x), np.ravel(t)
    slices = [slice(start, start + CHUNK) for start in range(0, max(flat_x.size, 1), CHUNK)]
    if len(slices) == 1:
        out = function(flat_x.copy(), flat_t.copy())
    else:
        chunks = _executor().map(lambda s: function(flat_x[s].copy(), flat_t[s].copy()), slices)
        out = np.concatenate(list(chunks), axis=-1)
    return out.reshape(*out.shape[:-1], *x.shape)


def check_points(position: ArrayLike, time: ArrayLike) -> tuple[Array, Array]:
    """Positions and times as doubles, broadcast together.

    Integers must be doubles exactly; other numbers are rounded to the nearest double.

    Raises ValueError for what is no finite real number, and for shapes that do not broadcast.

    >>> check_points([1, 2], 1j)
    Traceback (most recent call last):
    ...
    ValueError: every time must be a real number, got complex128 (take its real part)
    """
    x, t = _doubles("position", position), _doubles("time", time)
    try:
        x, t = np.broadcast_arrays(x, t)
    except ValueError:
        raise ValueError(
            f"position and time must broadcast, got the shapes {x.shape} and {t.shape} "
            "(give one of them a further axis)"
        ) from None
    return x, t


def _doubles(name: str, values: ArrayLike) -> Array:
    if np.ma.is_masked(values):
        raise ValueError(f"no {name} may be masked, got a masked array (leave such points out)")
    try:
        array = np.asarray(values)
    except (ValueError, TypeError):
        raise ValueError(
            f"every {name} must be a number or an array of one shape, got {type(values).__name__} "
            "with rows of different lengths or no numbers (make it an array first)"
        ) from None
    if array.dtype.kind == "O":
        doubles = _from_objects(name, array)
    elif array.dtype.kind in "iuf":
        with np.errstate(over="ignore"):
            doubles = array.astype(float)
        if array.dtype.kind != "f":
            _check_integers(name, array, doubles)
    else:
        remedy = {"c": "take its real part", "b": "0 and 1 are numbers"}
        raise ValueError(
            f"every {name} must be a real number, got {array.dtype} "
            f"({remedy.get(array.dtype.kind, 'convert it to numbers')})"
        )
    if not np.all(np.isfinite(doubles)):
        raise ValueError(
            f"every {name} must be finite, got NaN or infinity (leave such points out)"
        )
    return doubles


def _shown(value: object) -> str:
    from derive.algebra.exact_numbers import shown  # with SymPy, for what is wrong alone

    return shown(value)


def _check_integers(name: str, integers: NDArray[Any], doubles: Array) -> None:
    beyond = np.abs(doubles) >= 2.0**53
    for integer, double in zip(integers[beyond].tolist(), doubles[beyond].tolist(), strict=True):
        if integer != int(double):
            raise ValueError(
                f"every integer {name} must be a double exactly, got {_shown(integer)} "
                "(use Wave.mp)"
            )


def _from_objects(name: str, objects: NDArray[Any]) -> Array:
    """Doubles from Python's own numbers (int of any size, Fraction, Decimal, ...)."""
    doubles = np.empty(objects.shape)
    for index, number in np.ndenumerate(objects):
        if isinstance(number, bool | np.bool_) or not isinstance(number, Real | Decimal):
            raise ValueError(
                f"every {name} must be a real number, got {_shown(number)} "
                f"of type {type(number).__name__} (convert it to numbers)"
            )
        try:
            doubles[index] = float(number)
        except OverflowError:
            raise ValueError(
                f"every {name} must be finite as a double, got {_shown(number)} (take less)"
            ) from None
        if isinstance(number, Integral):
            _check_integers(name, np.array([number], dtype=object), doubles[index][None])
    return doubles

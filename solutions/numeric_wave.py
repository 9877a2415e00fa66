"""A wave evaluated at arrays of points as numbers, without the formulas it came from."""

from collections.abc import Callable
from fractions import Fraction
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.solutions.pieces import PIECE, in_pieces
from longwave.solutions.points import check_points, evaluate_points
from longwave.solutions.run.doubledouble import split
from longwave.solutions.run.linear_phase import LONG, LinearPhase, Variables, long_number
from longwave.solutions.run.machine import add_row, scale_rows

if TYPE_CHECKING:
    from longwave.solutions.quadrature import IntegralFromZero
    from longwave.solutions.run.evaluator import Evaluator, PointEvaluator

Array = NDArray[np.float64]
Side = Literal["left", "right"]
Part = Literal["wave", "formula", "background", "left", "right", "potential"]
"""What is evaluated: the wave, its background, its left or right far field, or its potential.
"formula" is the wave by its compiled program, even if the wave has another evaluator."""

ACCEPTED_BOUND = 5e-14
"""Largest error bound, in units of max(1, |value|), accepted from double-double."""

ACCEPTED_JET_BOUND = 1e-13
"""Largest accepted error bound of a jet, relative to the largest value of its order."""

JET_SCALE_FLOOR = 1e-10
"""A jet's error bound is judged relative to this value or larger ones, in units of h a**order."""

HIGHEST_JET = 20
"""Highest order of a jet."""

FAR_PHASE = 60.0
"""Distance from a phase's zero, in phase, beyond which a wave is constant: exp(-60) is 1e-26."""

MAX_CACHED_INTEGRALS = 4
"""Most cached integrals. A run needs three: at compared cells, on a ring, at the ring's ends."""

MOST_UNCERTAIN = 1000
"""Most points that mpmath evaluates when bounds are too large, at 5 to 100 ms each."""


class WaveValues(NamedTuple):
    """``Y`` and its derivatives with respect to X and T, arrays of one shape; complex for NLS."""

    Y: Array
    Y_X: Array
    Y_T: Array


class PlanarValues(NamedTuple):
    """``Y`` and its derivatives with respect to X, T and Z, arrays of one shape."""

    Y: Array
    Y_X: Array
    Y_T: Array
    Y_Z: Array


class Rates(NamedTuple):
    """Constants of a normal form as long numbers: ``Y = h U(a (X - drift T), e Z, b T)``."""

    a: Any
    b: Any
    c: Any
    h: Any
    e: Any
    drift: Any


class WaveConstants(NamedTuple):
    """Constants and properties of a wave.

    ``a`` and ``b`` are the doubles nearest to those of ``rates``, ``s`` is the normal form's sign.
    ``is_bare`` says that a periodic wave is its own background. ``equation`` is the name of the
    normal form, ``order`` that of its highest X derivative: ``T = eps**order t``.
    """

    name: str
    equation: str
    order: int
    is_complex: bool
    rates: Rates
    a: float
    b: float
    s: int
    wavelength: float | None
    constant_background: float | None
    is_bare: bool

    @property
    def is_planar(self) -> bool:
        """Whether the wave depends on a transverse variable, Z."""
        return bool(self.rates.e)


class NumericWave:
    """Numerical wave ``Y(X, T) = h U(a X, b T)``; `solutions.Wave` describes its guarantees.

    ``make_evaluator`` returns the evaluator of a part. ``evaluate_exactly`` returns values and
    derivatives of a part at a point, in the given variables, where double-double is not enough.
    Waves of KP take the transverse coordinate ``Z`` or site ``m`` as well.
    """

    def __init__(
        self,
        numbers: WaveConstants,
        make_evaluator: Callable[[Part], "PointEvaluator"],
        evaluate_exactly: Callable[..., Array],
    ) -> None:
        self.numbers = numbers
        self._make, self._settle = make_evaluator, evaluate_exactly
        self._evaluators: dict[Part, PointEvaluator] = {}
        self._value_evaluators: dict[Part, PointEvaluator | None] = {}
        self._known_phases: dict[tuple[Part, object], list[LinearPhase]] = {}
        self._lattices: dict[object, Variables] = {}
        self._series: dict[int, Evaluator] = {}
        self._integrals: dict[tuple[float, float, float], IntegralFromZero] = {}

    def __reduce__(self) -> tuple[Callable[..., "NumericWave"], tuple[Any, ...]]:
        """Return the call that rebuilds the wave on unpickling; compiled code is not pickled."""
        return type(self), (self.numbers, self._make, self._settle)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NumericWave) and self.__reduce__() == other.__reduce__()

    def __hash__(self) -> int:
        return hash((self.numbers.name, self.numbers.a, self.numbers.b))

    @property
    def wavelength(self) -> float | None:
        """Period of the background in X, None if the background is constant."""
        return self.numbers.wavelength

    @property
    def constant_background(self) -> float | None:
        """Constant that the wave tends to on both sides, None if there is none."""
        return self.numbers.constant_background

    def __call__(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike | None = None) -> WaveValues:
        """Return Y, Y_X, Y_T at the broadcast points (X, T); for KP at (X, T, Z), with Y_Z."""
        return self._evaluate("wave", self._slow, X, T, Z)

    def at(
        self, n: ArrayLike, t: ArrayLike, eps: float, *, m: ArrayLike | None = None
    ) -> WaveValues:
        """Return Y, Y_X, Y_T at site n (any real) and lattice time t.

        Phases are computed in double-double from (n, t, eps): ``X = eps (n - c t)``, ``T =
        eps**order t`` and ``Z = eps**2 m`` are never rounded.
        """
        return self._evaluate("wave", self._lattice(eps), n, t, m)

    def pairs_at(
        self, n: ArrayLike, t: ArrayLike, eps: float, *, m: ArrayLike | None = None
    ) -> WaveValues:
        """Return the values of `at` as arrays (2, ...) of high and low parts, about 30 digits."""
        variables = self._lattice(eps)
        return self._join_parts(
            self._bounded_rows("wave", variables, *self._points(n, t, m))[:, :2]
        )

    def value_at(
        self,
        n: ArrayLike,
        t: ArrayLike,
        eps: float,
        part: Part = "wave",
        *,
        m: ArrayLike | None = None,
    ) -> Array:
        """Return Y alone, of the wave, its background or a far field, at site n and lattice time t.

        The values are those of `at`, `background_at` and `far_field_at`, in half the time for most
        waves.
        """
        variables, points = self._lattice(eps), self._points(n, t, m)
        evaluator = self._values_alone(part)
        if points[0].size >= PIECE or evaluator is None:
            return np.asarray(self._evaluate(part, variables, n, t, m).Y)
        values = self._bounded_rows(part, variables, *points, evaluator=evaluator)[:, 0]
        return values[0] + 1j * values[1] if self.numbers.is_complex else values[0]

    @property
    def _value_rows(self) -> list[int]:
        """Indices of an evaluator's rows that hold the value: its real and any imaginary part."""
        return [0, 3 + self.numbers.is_planar] if self.numbers.is_complex else [0]

    def _values_alone(self, part: Part) -> "PointEvaluator | None":
        """Return an evaluator of a part's values alone; None if that saves no work."""
        from longwave.solutions.run.evaluator import Evaluator

        if part not in self._value_evaluators:
            evaluator, rows = self._evaluator(part), self._value_rows
            selected = evaluator.only(rows) if isinstance(evaluator, Evaluator) else None
            self._value_evaluators[part] = selected
        return self._value_evaluators[part]

    def jets(
        self, X: ArrayLike, T: ArrayLike, highest: int, *, Z: ArrayLike | None = None
    ) -> Array:
        """Return Y, Y_X, Y_XX, ... to the order ``highest`` at the points: (highest + 1, ...).

        Computed by Taylor arithmetic in double-double. The error is below 1e-13 of the largest
        value of the same order at these points, or below 1e-23 h a**order. Complex for NLS.

        Raises ValueError for an order that is not one of 0 .. ``HIGHEST_JET``.
        """
        points = self._points(X, T, Z)
        evaluator = self._taylor(highest)
        rates, rate = [self.numbers.rates.h], self.numbers.rates.a
        for order in range(1, highest + 1):
            rates.append(rates[-1] * rate * order)
        rates *= 2 if self.numbers.is_complex else 1
        is_far = partial(self._is_far, "formula", self._slow)
        units = np.abs(np.array(rates, dtype=float))
        jets = in_pieces(partial(self._jet_rows, evaluator, rates), points, is_far, units)
        if self.numbers.is_complex:
            jets = jets[: highest + 1] + 1j * jets[highest + 1 :]
        return jets

    def _jet_rows(self, evaluator: "Evaluator", rates: list[Any], *points: Array) -> Array:
        """Return the jets at points, each row scaled by its rate; imaginary parts come last."""
        rows = evaluate_points(partial(evaluator, evaluator.phases(self._slow)), *points)
        rows = scale_rows(rows, [split(rate) for rate in rates])
        flat = np.abs(rows[:, 0]).reshape(len(rows), -1)
        least = JET_SCALE_FLOOR * np.abs(np.array(rates, dtype=float))
        with np.errstate(invalid="ignore"):
            largest = np.max(flat, axis=1, initial=0.0, where=np.isfinite(flat))
            allowed = ACCEPTED_JET_BOUND * np.maximum(largest, least)
            certain = rows[:, 2] <= allowed.reshape(-1, *[1] * points[0].ndim)
        highest = len(rates) // (1 + self.numbers.is_complex) - 1
        settle = partial(self._settle, "formula", self._slow, highest=highest)
        return settle_rows(rows, certain, points, settle)[:, 0]

    def _is_far(
        self, part: Part, variables: Variables, x: Array, t: Array, *transverse: Array
    ) -> bool:
        """Return whether all points have one time and no phase vanishes near or between them."""
        if transverse or t.min() != t.max():
            return False
        first, last, time = float(x.min()), float(x.max()), float(t[0])
        for phase in self._phases(part, variables):
            zero, distance = phase.zero(time), FAR_PHASE / abs(phase.rate or 1.0)
            if zero is not None and first - distance <= zero <= last + distance:
                return False
        return True

    def _taylor(self, highest: int) -> "Evaluator":
        if (
            not isinstance(highest, int)
            or isinstance(highest, bool)
            or not 0 <= highest <= HIGHEST_JET
        ):
            raise ValueError(
                f"highest must be a whole number from 0 to {HIGHEST_JET}, got {highest!r:.40} "
                "(the order of the highest X derivative)"
            )
        if highest not in self._series:
            program: Any = self._evaluator("formula")
            self._series[highest] = program.taylor(self._value_rows, highest)
        return self._series[highest]

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """Return W at the points X and one time T, with W_X = Y and W = 0 at X = 0.

        Computed by quadrature, with an error below 1e-12 of the largest |W|. The panels of recent
        calls are cached, because a run needs the same points for data and theory. Raises ValueError
        as `solutions.quadrature.IntegralFromZero` does.
        """
        (points, _) = check_points(X, T)
        if not points.size:
            return np.empty(points.shape)
        fastest = max(abs(phase.rate) for phase in self._phases("formula", self._slow))
        low, high = float(points.min()), float(points.max())
        if fastest:
            low, high = np.floor(low * fastest) / fastest, np.ceil(high * fastest) / fastest
        key = (T, low, high)
        integral = self._integrals.get(key)
        if integral is None:
            from longwave.solutions.quadrature import IntegralFromZero

            width = 1.0 / fastest if fastest else np.inf
            integral = IntegralFromZero(lambda x: self(x, T).Y, low, high, width)
            recent = list(self._integrals.items())[1 - MAX_CACHED_INTEGRALS :]
            self._integrals = {**dict(recent), key: integral}
        return integral(points)

    def potential(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike) -> PlanarValues:
        """Return W, W_X, W_T, W_Z at the points (X, T, Z), with W_X = Y and W constant on the left.

        Raises ValueError for a wave whose potential has no known closed form.
        """
        values = self._evaluate("potential", self._slow, X, T, Z)
        return PlanarValues(*(value / self.numbers.a for value in values))

    def phase_zeros(self, t: float, eps: float, *, m: float = 0.0) -> list[float]:
        """Return the sites where one of the wave's phases vanishes at lattice time t, ascending.

        The crest of a localised wave is near one of them.
        """
        zeros = {phase.zero(t, m) for phase in self._phases("wave", self._lattice(eps))}
        return sorted(zero for zero in zeros if zero is not None)

    def slow_phase_zeros(self, T: float) -> list[float]:
        """Return the X where one of the wave's phases vanishes at the slow time T, ascending."""
        zeros = {phase.zero(T, 0.0) for phase in self._phases("wave", self._slow)}
        return sorted(zero for zero in zeros if zero is not None)

    def background(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike | None = None) -> WaveValues:
        """Return the background at (X, T): a periodic wave of the same phase, or a constant."""
        return self._evaluate("background", self._slow, X, T, Z)

    def background_at(
        self, n: ArrayLike, t: ArrayLike, eps: float, *, m: ArrayLike | None = None
    ) -> WaveValues:
        """Return the values of `background` at site n and lattice time t."""
        return self._evaluate("background", self._lattice(eps), n, t, m)

    def far_field(
        self, X: ArrayLike, T: ArrayLike, side: Side, *, Z: ArrayLike | None = None
    ) -> WaveValues:
        """Return the limit of the wave as X goes to -infinity ("left") or +infinity ("right")."""
        return self._evaluate(check_side(side), self._slow, X, T, Z)

    def far_field_at(
        self, n: ArrayLike, t: ArrayLike, eps: float, side: Side, *, m: ArrayLike | None = None
    ) -> WaveValues:
        """Return the values of `far_field` at site n and lattice time t."""
        return self._evaluate(check_side(side), self._lattice(eps), n, t, m)

    @cached_property
    def _slow(self) -> Variables:
        rates = self.numbers.rates
        return Variables(rates.a, rates.b, -rates.a * rates.drift, e=rates.e)

    @cached_property
    def _scales(self) -> tuple[tuple[float, float], ...]:
        """Factor of each evaluator row as (high, low part): h times the rate of its derivative."""
        rates = self.numbers.rates
        of_values = [LONG.one, rates.a, rates.b]
        of_values += [rates.e] if self.numbers.is_planar else []
        scales = [split(rates.h * rate) for rate in of_values]
        return tuple(scales * (2 if self.numbers.is_complex else 1))

    def _lattice(self, eps: object) -> Variables:
        exact = _exact_eps(eps)
        if exact not in self._lattices:
            (a, b, c, _, transverse_rate, drift), e = self.numbers.rates, long_number(exact)
            time_rate = e**self.numbers.order
            frame_rate = -a * c * e - a * drift * time_rate
            self._lattices[exact] = Variables(
                a * e, b * time_rate, frame_rate, exact, transverse_rate * e**2
            )
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

    def _evaluator(self, part: Part) -> "PointEvaluator":
        if part not in self._evaluators:
            self._evaluators[part] = self._make(part)
        return self._evaluators[part]

    def _evaluate(
        self, part: Part, variables: Variables, x: ArrayLike, t: ArrayLike, z: ArrayLike | None
    ) -> Any:
        def values(*points: Array) -> Array:
            return self._bounded_rows(part, variables, *points)[:, 0]

        units = [abs(high) for high, _ in self._scales]
        is_far = partial(self._is_far, part, variables)
        return self._join_parts(in_pieces(values, self._points(x, t, z), is_far, units))

    def _join_parts(self, rows: Array) -> Any:
        """Return the rows as a named tuple, real and imaginary parts combined."""
        if self.numbers.is_complex:
            rows = rows[: len(rows) // 2] + 1j * rows[len(rows) // 2 :]
        return PlanarValues(*rows) if self.numbers.is_planar else WaveValues(*rows)

    def _points(self, x: ArrayLike, t: ArrayLike, z: ArrayLike | None) -> tuple[Array, ...]:
        """Broadcast the points. Raises ValueError for a missing or extra transverse coordinate."""
        if (z is not None) == self.numbers.is_planar:
            return check_points(x, t) if z is None else check_points(x, t, z)
        needed, got = ("given", "none") if z is None else ("left out", "one")
        raise ValueError(
            f"transverse coordinate Z or m must be {needed} for {self.numbers.name}, got {got} "
            f"(it solves the {self.numbers.equation} equation)"
        )

    def _bounded_rows(
        self,
        part: Part,
        variables: Variables,
        *points: Array,
        evaluator: "PointEvaluator | None" = None,
    ) -> Array:
        """Return value and derivatives: high parts, low parts and error bounds, (rows, 3, ...).

        With an ``evaluator`` of values alone, the rows are those of the value.
        """
        phases, count = self._phases(part, variables), 3 + self.numbers.is_planar
        indices = [*range(len(self._scales))] if evaluator is None else self._value_rows
        function = self._evaluator(part) if evaluator is None else evaluator
        rows = evaluate_points(partial(function, phases), *points)
        rows = scale_rows(rows, [self._scales[index] for index in indices])
        if self.numbers.rates.drift and evaluator is None:
            drift = split(-self.numbers.rates.drift)
            for first in range(0, len(rows), count):  # Y_T, because xi = a (X - drift T)
                add_row(rows[first + 2], rows[first + 1], drift)

        def exact_rows(*point: float) -> Array:
            return self._settle(part, variables, *point)[indices]

        return settle_rows(rows, _are_certain(rows), points, exact_rows)


def _are_certain(rows: Array) -> NDArray[np.bool_]:
    """Return where the error bounds of ``rows`` (rows, 3, ...) are accepted, shape (rows, ...)."""
    with np.errstate(invalid="ignore"):
        return np.asarray(rows[:, 2] <= ACCEPTED_BOUND * np.maximum(1, np.abs(rows[:, 0])))


def settle_rows(
    rows: Array, certain: NDArray[np.bool_], points: tuple[Array, ...], settle: Callable[..., Array]
) -> Array:
    """Recompute ``rows`` (rows, 3, ...) in place at points where any row is not ``certain``.

    Returns ``rows``. ``settle`` takes a point and returns its rows (rows, 3). Raises ValueError if
    more than ``MOST_UNCERTAIN`` points are to be recomputed.
    """
    uncertain = np.argwhere(~np.all(certain, axis=0))
    if len(uncertain) > MOST_UNCERTAIN:
        first = ", ".join(f"{axis[tuple(uncertain[0])]:g}" for axis in points)
        raise ValueError(
            f"at most {MOST_UNCERTAIN} points may need more than double-double, got "
            f"{len(uncertain)}, the first at ({first}) (use Wave.mp there)"
        )
    for index in map(tuple, uncertain):
        rows[(slice(None), slice(None), *index)] = settle(*(axis[index] for axis in points))
    return rows


def _exact_eps(eps: object) -> Any:
    """Return ``eps`` as an exact positive number: a Fraction, or SymPy's number."""
    if isinstance(eps, float) and 0.0 < eps < np.inf:
        return Fraction(repr(float(eps)))
    from longwave.derive.algebra.exact_numbers import exact_number

    exact = exact_number("eps", eps)
    if not exact > 0:
        raise ValueError(f"eps must satisfy eps > 0, got {eps} (0.05 is usual)")
    return Fraction(int(exact.p), int(exact.q)) if exact.is_Rational else exact


def check_side(side: Side) -> Side:
    """Return ``side``, or raise ValueError if it is not "left" or "right"."""
    if side not in ("left", "right"):
        raise ValueError(f"side must be 'left' or 'right', got {side!r} (a far field has two)")
    return side

"""A wave as numbers: its values at arrays of points, without the formulas that they came from."""

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
"""What is evaluated of a wave; "formula" is the wave by its program, whatever else evaluates it."""

CERTAIN = 5e-14
"""Largest bound of an error, in units of max(1, |value|), that double-double may leave."""

OF_LARGEST = 1e-13
"""Largest bound of a jet's error, in units of the largest of its order."""

NOTHING = 1e-10
"""A jet that is smaller than this everywhere, in units of h a**order, counts as this large."""

HIGHEST = 20
"""Highest order of a jet."""

FAR = 60.0
"""A phase so large is far from where a wave may rise or fall: exp(-60) is 1e-26."""

MOST_KEPT = 4
"""Integrals that are kept: of compared cells, of a ring, and of the ring's ends."""

MOST_UNCERTAIN = 1000
"""Points with larger bounds that mpmath settles, at 5 to 100 ms each; more are refused."""


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
    """The numbers of a normal form as long numbers: ``Y = h U(a (X - drift T), e Z, b T)``."""

    a: Any
    b: Any
    c: Any
    h: Any
    e: Any
    drift: Any


class WaveConstants(NamedTuple):
    """What a wave is beside its values.

    ``a`` and ``b`` are the doubles nearest to those of ``rates``, ``s`` is the normal form's sign;
    ``is_bare`` says that a periodic wave has no background but itself. ``equation`` is the name of
    the normal form, ``order`` that of its highest X derivative: ``T = eps**order t``.
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
        """Whether there is a second direction, Z."""
        return bool(self.rates.e)


class NumericWave:
    """``Y(X, T) = h U(a X, b T)`` as numbers; `solutions.Wave` says what they are.

    ``numbers`` are the wave's, ``make`` gives the evaluator of a part, ``settle`` the values and
    derivatives of a part at a point (in the given variables) where double-double is not enough.
    Waves of KP are asked with the place across, ``Z`` or the site ``m``, others without.
    """

    def __init__(
        self,
        numbers: WaveConstants,
        make: Callable[[Part], "PointEvaluator"],
        settle: Callable[..., Array],
    ) -> None:
        self.numbers = numbers
        self._make, self._settle = make, settle
        self._evaluators: dict[Part, PointEvaluator] = {}
        self._valuers: dict[Part, PointEvaluator | None] = {}
        self._known_phases: dict[tuple[Part, object], list[LinearPhase]] = {}
        self._lattices: dict[object, Variables] = {}
        self._series: dict[int, Evaluator] = {}
        self._integrals: dict[tuple[float, float, float], IntegralFromZero] = {}

    def __reduce__(self) -> tuple[Callable[..., "NumericWave"], tuple[Any, ...]]:
        """What makes the wave again: no program and no kernel is pickled."""
        return type(self), (self.numbers, self._make, self._settle)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, NumericWave) and self.__reduce__() == other.__reduce__()

    def __hash__(self) -> int:
        return hash((self.numbers.name, self.numbers.a, self.numbers.b))

    @property
    def wavelength(self) -> float | None:
        """The period of the background in X, None if the background is constant."""
        return self.numbers.wavelength

    @property
    def constant_background(self) -> float | None:
        """The constant that the wave tends to on both sides, None if there is none."""
        return self.numbers.constant_background

    def __call__(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike | None = None) -> WaveValues:
        """Y, Y_X, Y_T at the broadcast points (X, T); for KP at (X, T, Z), and Y_Z."""
        return self._evaluate("wave", self._slow, X, T, Z)

    def at(
        self, n: ArrayLike, t: ArrayLike, eps: float, *, m: ArrayLike | None = None
    ) -> WaveValues:
        """Y, Y_X, Y_T at site n (any real) and lattice time t.

        The phases are formed in double-double from (n, t, eps); ``X = eps (n - c t)`` and
        ``T = eps**order t`` are never rounded, neither is ``Z = eps**2 m``.
        """
        return self._evaluate("wave", self._lattice(eps), n, t, m)

    def pairs_at(
        self, n: ArrayLike, t: ArrayLike, eps: float, *, m: ArrayLike | None = None
    ) -> WaveValues:
        """``at`` in double-double: arrays (2, ...) of high and low parts, about 30 digits."""
        variables = self._lattice(eps)
        return self._joined(self._bounded("wave", variables, *self._points(n, t, m))[:, :2])

    def value_at(
        self,
        n: ArrayLike,
        t: ArrayLike,
        eps: float,
        part: Part = "wave",
        *,
        m: ArrayLike | None = None,
    ) -> Array:
        """Y alone of the wave, its background or a far field, at site n and lattice time t.

        As `at`, `background_at` and `far_field_at` give it, in half of the time for most waves.
        """
        variables, points = self._lattice(eps), self._points(n, t, m)
        evaluator = self._values_alone(part)
        if points[0].size >= PIECE or evaluator is None:
            return np.asarray(self._evaluate(part, variables, n, t, m).Y)
        found = self._bounded_values(evaluator, part, variables, *points)[:, 0]
        return found[0] + 1j * found[1] if self.numbers.is_complex else found[0]

    @property
    def _value_rows(self) -> list[int]:
        """The rows of an evaluator that hold the value, its real part and its imaginary one."""
        return [0, 3 + self.numbers.is_planar] if self.numbers.is_complex else [0]

    def _values_alone(self, part: Part) -> "PointEvaluator | None":
        """What evaluates the value of a part alone; None where that takes no less."""
        from longwave.solutions.run.evaluator import Evaluator

        if part not in self._valuers:
            whole, rows = self._evaluator(part), self._value_rows
            self._valuers[part] = whole.only(rows) if isinstance(whole, Evaluator) else None
        return self._valuers[part]

    def jets(
        self, X: ArrayLike, T: ArrayLike, highest: int, *, Z: ArrayLike | None = None
    ) -> Array:
        """Y, Y_X, Y_XX, ... to the order ``highest`` at the points: (highest + 1, ...).

        By Taylor arithmetic in double-double. The error is below 1e-13 of the largest value of the
        same order at these points, or below 1e-23 h a**order. Complex for NLS.

        Raises ValueError for an order that is not one of 0 .. ``HIGHEST``.
        """
        points = self._points(X, T, Z)
        evaluator = self._taylor(highest)
        rates, rate = [self.numbers.rates.h], self.numbers.rates.a
        for order in range(1, highest + 1):
            rates.append(rates[-1] * rate * order)
        rates *= 2 if self.numbers.is_complex else 1
        far = partial(self._is_far, "formula", self._slow)
        units = np.abs(np.array(rates, dtype=float))
        found = in_pieces(partial(self._jet_rows, evaluator, rates), points, far, units)
        if self.numbers.is_complex:
            found = found[: highest + 1] + 1j * found[highest + 1 :]
        return found

    def _jet_rows(self, evaluator: "Evaluator", rates: list[Any], *points: Array) -> Array:
        """The jets at points, real and imaginary parts one after the other."""
        rows = evaluate_points(partial(evaluator, evaluator.phases(self._slow)), *points)
        rows = scale_rows(rows, [split(rate) for rate in rates])
        flat = np.abs(rows[:, 0]).reshape(len(rows), -1)
        least = NOTHING * np.abs(np.array(rates, dtype=float))
        with np.errstate(invalid="ignore"):
            largest = np.max(flat, axis=1, initial=0.0, where=np.isfinite(flat))
            allowed = OF_LARGEST * np.maximum(largest, least)
            certain = rows[:, 2] <= allowed.reshape(-1, *[1] * points[0].ndim)
        highest = len(rates) // (1 + self.numbers.is_complex) - 1
        settle = partial(self._settle, "formula", self._slow, highest=highest)
        return settle_rows(rows, certain, points, settle)[:, 0]

    def _is_far(self, part: Part, variables: Variables, x: Array, t: Array, *across: Array) -> bool:
        """Whether points of one time are far from every place where a phase vanishes."""
        if across or t.min() != t.max():
            return False
        low, high, time = float(x.min()), float(x.max()), float(t[0])
        for phase in self._phases(part, variables):
            zero, room = phase.zero(time), FAR / abs(phase.rate or 1.0)
            if zero is not None and low - room <= zero <= high + room:
                return False
        return True

    def _taylor(self, highest: int) -> "Evaluator":
        if not isinstance(highest, int) or isinstance(highest, bool) or not 0 <= highest <= HIGHEST:
            raise ValueError(
                f"highest must be a whole number from 0 to {HIGHEST}, got {highest!r:.40} "
                "(the order of the highest X derivative)"
            )
        if highest not in self._series:
            program: Any = self._evaluator("formula")
            self._series[highest] = program.taylor(self._value_rows, highest)
        return self._series[highest]

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """W at the points X and one time T, with W_X = Y and W = 0 at X = 0.

        By quadrature, its error below 1e-12 of the largest |W|; raises ValueError as
        `solutions.quadrature.IntegralFromZero` does. The panels of the last calls are kept: data
        and theory of a run ask for the same places again.
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
            kept = list(self._integrals.items())[1 - MOST_KEPT :]
            self._integrals = {**dict(kept), key: integral}
        return integral(points)

    def potential(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike) -> PlanarValues:
        """W, W_X, W_T, W_Z at the points (X, T, Z), with W_X = Y and W constant on the left.

        Raises ValueError for a wave whose potential is not known in closed form.
        """
        values = self._evaluate("potential", self._slow, X, T, Z)
        return PlanarValues(*(value / self.numbers.a for value in values))

    def phase_zeros(self, t: float, eps: float, *, m: float = 0.0) -> list[float]:
        """The sites at which one of the wave's phases vanishes at lattice time t, ascending.

        The crest of a localised wave is near one of them.
        """
        zeros = {phase.zero(t, m) for phase in self._phases("wave", self._lattice(eps))}
        return sorted(zero for zero in zeros if zero is not None)

    def slow_phase_zeros(self, T: float) -> list[float]:
        """The X at which one of the wave's phases vanishes at the slow time T, ascending."""
        zeros = {phase.zero(T, 0.0) for phase in self._phases("wave", self._slow)}
        return sorted(zero for zero in zeros if zero is not None)

    def background(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike | None = None) -> WaveValues:
        """The bare background wave of the same phase (or the constant) at (X, T)."""
        return self._evaluate("background", self._slow, X, T, Z)

    def background_at(
        self, n: ArrayLike, t: ArrayLike, eps: float, *, m: ArrayLike | None = None
    ) -> WaveValues:
        """``background`` at site n and lattice time t."""
        return self._evaluate("background", self._lattice(eps), n, t, m)

    def far_field(
        self, X: ArrayLike, T: ArrayLike, side: Side, *, Z: ArrayLike | None = None
    ) -> WaveValues:
        """What the wave tends to as X goes to -infinity ("left") or +infinity ("right")."""
        return self._evaluate(check_side(side), self._slow, X, T, Z)

    def far_field_at(
        self, n: ArrayLike, t: ArrayLike, eps: float, side: Side, *, m: ArrayLike | None = None
    ) -> WaveValues:
        """``far_field`` at site n and lattice time t."""
        return self._evaluate(check_side(side), self._lattice(eps), n, t, m)

    @cached_property
    def _slow(self) -> Variables:
        rates = self.numbers.rates
        return Variables(rates.a, rates.b, -rates.a * rates.drift, e=rates.e)

    @cached_property
    def _scales(self) -> tuple[tuple[float, float], ...]:
        """Of each row of an evaluator: h times the derivative's rate, for both parts of Y."""
        rates = self.numbers.rates
        of_values = [LONG.one, rates.a, rates.b]
        of_values += [rates.e] if self.numbers.is_planar else []
        scales = [split(rates.h * rate) for rate in of_values]
        return tuple(scales * (2 if self.numbers.is_complex else 1))

    def _lattice(self, eps: object) -> Variables:
        exact = _exact_eps(eps)
        if exact not in self._lattices:
            (a, b, c, _, across, drift), e = self.numbers.rates, long_number(exact)
            later = e**self.numbers.order
            moving = -a * c * e - a * drift * later
            self._lattices[exact] = Variables(a * e, b * later, moving, exact, across * e**2)
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
            return self._bounded(part, variables, *points)[:, 0]

        units = [abs(high) for high, _ in self._scales]
        far = partial(self._is_far, part, variables)
        return self._joined(in_pieces(values, self._points(x, t, z), far, units))

    def _joined(self, rows: Array) -> Any:
        """The rows by their names, real and imaginary parts together."""
        if self.numbers.is_complex:
            rows = rows[: len(rows) // 2] + 1j * rows[len(rows) // 2 :]
        return PlanarValues(*rows) if self.numbers.is_planar else WaveValues(*rows)

    def _points(self, x: ArrayLike, t: ArrayLike, z: ArrayLike | None) -> tuple[Array, ...]:
        """The points broadcast together; ValueError for a place across too many or too few."""
        if (z is not None) == self.numbers.is_planar:
            return check_points(x, t) if z is None else check_points(x, t, z)
        needed, got = ("given", "none") if z is None else ("left out", "one")
        raise ValueError(
            f"the place across, Z or m, must be {needed} for {self.numbers.name}, got {got} "
            f"(it solves the {self.numbers.equation} equation)"
        )

    def _bounded(self, part: Part, variables: Variables, *points: Array) -> Array:
        """Value and derivatives: high parts, low parts, bounds of their errors (rows, 3, ...)."""
        phases = self._phases(part, variables)
        rows = evaluate_points(partial(self._evaluator(part), phases), *points)
        rows = scale_rows(rows, self._scales)
        if self.numbers.rates.drift:
            self._drift(rows)
        return settle_rows(rows, _are_certain(rows), points, partial(self._settle, part, variables))

    def _bounded_values(
        self, evaluator: "PointEvaluator", part: Part, variables: Variables, *points: Array
    ) -> Array:
        """The same of the value alone, by what evaluates no other rows."""
        rows = evaluate_points(partial(evaluator, self._phases(part, variables)), *points)
        rows = scale_rows(rows, [self._scales[row] for row in self._value_rows])

        def settle(*point: float) -> Array:
            return self._settle(part, variables, *point)[self._value_rows]

        return settle_rows(rows, _are_certain(rows), points, settle)

    def _drift(self, rows: Array) -> None:
        """Subtract drift Y_X from Y_T, for ``xi = a (X - drift T)``."""
        drift = split(-self.numbers.rates.drift)
        count = 3 + self.numbers.is_planar
        for first in range(0, len(rows), count):
            add_row(rows[first + 2], rows[first + 1], drift)


def _are_certain(rows: Array) -> NDArray[np.bool_]:
    """Whether the bound of the error of each number in ``rows`` (rows, 3, ...) is small enough."""
    with np.errstate(invalid="ignore"):
        return np.asarray(rows[:, 2] <= CERTAIN * np.maximum(1, np.abs(rows[:, 0])))


def settle_rows(
    rows: Array, certain: NDArray[np.bool_], points: tuple[Array, ...], settle: Callable[..., Array]
) -> Array:
    """``rows`` (rows, 3, ...) with those at points where one is not ``certain`` settled, in place.

    ``settle`` takes a point and gives its rows (rows, 3). Raises ValueError for more points than
    ``MOST_UNCERTAIN``.
    """
    uncertain = np.argwhere(~np.all(certain, axis=0))
    if len(uncertain) > MOST_UNCERTAIN:
        first = ", ".join(f"{axis[tuple(uncertain[0])]:g}" for axis in points)
        raise ValueError(
            f"at most {MOST_UNCERTAIN} points may need more than double-double, got "
            f"{len(uncertain)}, the first at ({first}) (use Wave.mp there)"
        )
    for place in map(tuple, uncertain):
        rows[(slice(None), slice(None), *place)] = settle(*(axis[place] for axis in points))
    return rows


def _exact_eps(eps: object) -> Any:
    """The exact number meant by ``eps``, which must be positive: a Fraction, or SymPy's."""
    if isinstance(eps, float) and 0.0 < eps < np.inf:
        return Fraction(repr(float(eps)))
    from longwave.derive.algebra.exact_numbers import exact_number

    exact = exact_number("eps", eps)
    if not exact > 0:
        raise ValueError(f"eps must satisfy eps > 0, got {eps} (0.05 is usual)")
    return Fraction(int(exact.p), int(exact.q)) if exact.is_Rational else exact


def check_side(side: Side) -> Side:
    """``side``, or a ValueError if it is none."""
    if side not in ("left", "right"):
        raise ValueError(f"side must be 'left' or 'right', got {side!r} (a far field has two)")
    return side

"""The integral of a function from 0 to many points, by polynomials in panels."""

import math
from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]

NODES = 16
PRECISE = 1e-13
"""Largest error in a panel, in units of the integral of the absolute value over all panels."""

HALVINGS = 12
MOST_PANELS = 2_000_000

BLOCK = 65_536
"""Points that are evaluated at once, so that they fit the cache."""

CONFIRMED_AT = np.linspace(-0.75, 1.0, 8)
"""Where in a panel, from -1 to 1, its two halves must give the same integral."""

X, WEIGHTS = legendre.leggauss(NODES)
SERIES = (np.arange(NODES) + 0.5)[:, None] * WEIGHTS * legendre.legvander(X, NODES - 1).T
INTEGRAL = legendre.legint(SERIES, lbnd=-1)
"""Values at the nodes to the Legendre series of the integral from -1 on."""


class IntegralFromZero:
    """The integrals of ``function`` from 0 to any points from ``low`` to ``high``, real or complex.

    No panel is wider than ``width``, over which the function must not hide anything; a panel that
    its two halves do not confirm is halved. The cost is that of the panels, however many points
    lie in them. Raises ValueError for ends that are too far apart for that, and where halving does
    not end.

    >>> sine = IntegralFromZero(np.cos, -1.0, 0.5, 1.0)
    >>> float(abs(sine(np.array([0.5, -1.0])) - np.sin([0.5, -1.0])).max()) < 1e-15
    True
    """

    def __init__(
        self, function: Callable[[Array], Array], low: float, high: float, width: float
    ) -> None:
        self._function = function
        low, high = min(low, 0.0), max(high, 0.0)
        width = min(width, max(high - low, 1.0))
        count = high / width - low / width + 2.0
        if not count <= MOST_PANELS:
            raise ValueError(
                f"points must span at most {MOST_PANELS * width:g}, got {high - low:g} "
                "(integrate between nearer ones)"
            )
        first = math.floor(low / width)
        steps = np.arange(first, max(math.ceil(high / width), first + 1), dtype=np.float64)
        whole = steps * width, np.full(steps.size, width)
        self._left, self._step, self._series = self._confirmed(*whole)
        ends = np.concatenate([[0.0], np.cumsum(self._series.sum(axis=0))])
        origin = np.searchsorted(np.append(self._left, high), 0.0)
        self._before = ends[:-1] - ends[origin]

    def __call__(self, points: Array) -> Array:
        """The integrals to ``points``, an array of any shape."""
        flat = points.ravel()
        found = np.empty(flat.size, self._series.dtype)
        for start in range(0, flat.size, BLOCK):
            block = slice(start, start + BLOCK)
            panel = np.maximum(np.searchsorted(self._left, flat[block], "right") - 1, 0)
            place = 2.0 * (flat[block] - self._left[panel]) / self._step[panel] - 1.0
            inside = legendre.legval(place, self._series[:, panel], tensor=False)
            found[block] = self._before[panel] + inside
        return found.reshape(points.shape)

    def _panels(self, left: Array, step: Array) -> tuple[Array, float]:
        """The series (NODES + 1, panels) of the integrals within panels, and the sum of |f|."""
        at = left + step * (0.5 + 0.5 * X[:, None])
        values = self._function(at.ravel()).reshape(at.shape) * (step / 2)
        return INTEGRAL @ values, float(np.sum(WEIGHTS @ np.abs(values)))

    def _confirmed(self, left: Array, step: Array) -> tuple[Array, Array, Array]:
        """Left ends, widths and series of panels, each one of two halves that confirmed a whole."""
        kept: list[tuple[Array, Array, Array]] = []
        series, size = self._panels(left, step)
        in_whole, in_half = _values_at(CONFIRMED_AT), _values_at(2.0 * CONFIRMED_AT[:4] + 1.0)
        for _ in range(HALVINGS):
            halves = np.concatenate([left, left + step / 2]), np.concatenate([step, step]) / 2
            parts, _ = self._panels(*halves)
            first, second = parts[:, : left.size], parts[:, left.size :]
            both = np.concatenate([in_half @ first, first.sum(axis=0) + in_half @ second])
            apart = np.max(np.abs(in_whole @ series - both), axis=0)
            right = np.tile(apart <= PRECISE * size, 2)
            kept.append((halves[0][right], halves[1][right], parts[:, right]))
            if right.all():
                lefts, steps, found = zip(*kept, strict=True)
                order = np.argsort(np.concatenate(lefts))
                return (
                    np.concatenate(lefts)[order],
                    np.concatenate(steps)[order],
                    np.concatenate(found, axis=1)[:, order],
                )
            left, step, series = halves[0][~right], halves[1][~right], parts[:, ~right]
        raise ValueError(
            f"panels must be confirmed after {HALVINGS} halvings, got {left.size} that are not, "
            f"the first at {left[0]:g} (the function is not smooth there)"
        )


def _values_at(places: Array) -> Array:
    """The values of Legendre series at places from -1 to 1, as a matrix."""
    return np.asarray(legendre.legvander(places, NODES), dtype=np.float64)

"""Integrals of a function from 0 to many points, by polynomials in panels."""

import math
from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]

NODES = 16
"""Number of Gauss-Legendre nodes in a panel."""

PANEL_TOLERANCE = 1e-13
"""Largest error in a panel, in units of the integral of the absolute value over all panels."""

MAX_HALVINGS, MAX_PANELS, MAX_WIDTHS = 12, 2_000_000, 20_000_000
"""Most halvings of a panel; most panels; longest interval, in units of ``width``."""

MERGE_ABOVE = 4096
"""Number of panels above which neighbouring panels are merged where the function is constant."""

NEGLIGIBLE_CHANGE = 1e-20
"""Largest change across a panel that counts as none, in units of the function's largest value."""

BLOCK = 65_536
"""Number of points where integrals are evaluated at once, so that they fit the cache."""

CONFIRMED_AT = np.linspace(-0.75, 1.0, 8)
"""Points of a panel, from -1 to 1, where its two halves must give the same integral."""

X, WEIGHTS = legendre.leggauss(NODES)
SERIES = (np.arange(NODES) + 0.5)[:, None] * WEIGHTS * legendre.legvander(X, NODES - 1).T
INTEGRAL = legendre.legint(SERIES, lbnd=-1)
"""Matrix from values at the nodes to the Legendre series of the integral from -1 on."""


class IntegralFromZero:
    """Integrals of ``function`` from 0 to any points from ``low`` to ``high``, real or complex.

    Panels are at most ``width`` wide, which must resolve every feature of the function; many panels
    where it is constant are merged. A panel is halved until its two halves confirm it. The cost is
    that of the panels, for any number of points. Raises ValueError for ends too far apart, and if
    halving does not converge.

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
        self._check(count, MAX_WIDTHS, width, high - low)
        first = math.floor(low / width)
        steps = np.arange(first, max(math.ceil(high / width), first + 1), dtype=np.float64)
        left, widths = steps * width, np.full(steps.size, width)
        if steps.size > MERGE_ABOVE:
            left, widths = self._merge_constant(left, widths)
            self._check(left.size, MAX_PANELS, width, high - low)
        self._left, self._step, self._series = self._halve_until_confirmed(left, widths)
        ends = np.concatenate([[0.0], np.cumsum(self._series.sum(axis=0))])
        origin = np.searchsorted(np.append(self._left, high), 0.0)
        self._before = ends[:-1] - ends[origin]

    def __call__(self, points: Array) -> Array:
        """Return the integrals from 0 to ``points``, an array of any shape."""
        flat = points.ravel()
        integrals = np.empty(flat.size, self._series.dtype)
        for start in range(0, flat.size, BLOCK):
            block = slice(start, start + BLOCK)
            panel = np.maximum(np.searchsorted(self._left, flat[block], "right") - 1, 0)
            reference = 2.0 * (flat[block] - self._left[panel]) / self._step[panel] - 1.0
            inside = legendre.legval(reference, self._series[:, panel], tensor=False)
            integrals[block] = self._before[panel] + inside
        return integrals.reshape(points.shape)

    @staticmethod
    def _check(count: float, most: int, width: float, span: float) -> None:
        if not count <= most:
            raise ValueError(
                f"points must span at most {most * width:g}, got {span:g} (integrate between "
                "nearer ones)"
            )

    def _merge_constant(self, left: Array, step: Array) -> tuple[Array, Array]:
        """Merge panels where the function is constant; return left ends and widths."""
        values = self._function(np.append(left, left[-1] + step[-1]))
        changes = np.abs(np.diff(values)) > NEGLIGIBLE_CHANGE * np.max(np.abs(values))
        needed = np.convolve(changes, np.ones(4), "full")[1:-2] > 0.0
        needed[0] = True
        needed |= left == 0.0
        starts = np.flatnonzero(needed)
        return left[starts], np.add.reduceat(step, starts)

    def _panels(self, left: Array, step: Array) -> tuple[Array, float]:
        """Return the Legendre series (NODES + 1, panels) of integrals from each panel's left end.

        Also returns the integral of the absolute value over all panels.
        """
        at = left + step * (0.5 + 0.5 * X[:, None])
        values = self._function(at.ravel()).reshape(at.shape) * (step / 2)
        return INTEGRAL @ values, float(np.sum(WEIGHTS @ np.abs(values)))

    def _halve_until_confirmed(self, left: Array, step: Array) -> tuple[Array, Array, Array]:
        """Halve panels until the halves confirm them; return left ends, widths and series."""
        accepted: list[tuple[Array, Array, Array]] = []
        series, size = self._panels(left, step)
        in_whole, in_half = _values_at(CONFIRMED_AT), _values_at(2.0 * CONFIRMED_AT[:4] + 1.0)
        for _ in range(MAX_HALVINGS):
            halves = np.concatenate([left, left + step / 2]), np.concatenate([step, step]) / 2
            parts, _ = self._panels(*halves)
            first, second = parts[:, : left.size], parts[:, left.size :]
            both = np.concatenate([in_half @ first, first.sum(axis=0) + in_half @ second])
            differences = np.max(np.abs(in_whole @ series - both), axis=0)
            is_accepted = np.tile(differences <= PANEL_TOLERANCE * size, 2)
            accepted.append((halves[0][is_accepted], halves[1][is_accepted], parts[:, is_accepted]))
            if is_accepted.all():
                lefts, steps, series_parts = zip(*accepted, strict=True)
                left, step = np.concatenate(lefts), np.concatenate(steps)
                order = np.argsort(left)
                return left[order], step[order], np.concatenate(series_parts, axis=1)[:, order]
            left, step = halves[0][~is_accepted], halves[1][~is_accepted]
            series = parts[:, ~is_accepted]
        raise ValueError(
            f"panels must be confirmed after {MAX_HALVINGS} halvings, got {left.size} that are "
            f"not, the first at {left[0]:g} (the function is not smooth there)"
        )


def _values_at(points: Array) -> Array:
    """Return the matrix that evaluates Legendre series at points from -1 to 1."""
    return np.asarray(legendre.legvander(points, NODES), dtype=np.float64)

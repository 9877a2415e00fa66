"""Integrals of functions of one variable, accurate to rounding, on adaptive panels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from longwave.lattice.force_program import ForceProgram
from longwave.support.real_arrays import Array, Mask

MIN_PANELS, MAX_PANELS, GAUSS_POINTS = 2**13, 2**18, 12
"""Initial and largest number of panels, and points of Gauss's rule on each panel."""

ROUNDING = 2.0**-50
"""Relative rounding error of a panel's integral."""

LEAST_PANEL = 2.0**-48
"""Length of the shortest panel, in units of the largest abs(number) in it."""

ENCLOSURE_SLACK = 0.02
"""Fraction of the largest slope near a panel by which enclosures of the slope may be too wide, as
for a product of terms that depend on each other; otherwise a straight line on either side of a
corner would be halved for ever."""

_POINTS, _WEIGHTS = legendre.leggauss(GAUSS_POINTS)

_DEGREES = np.arange(GAUSS_POINTS)[:, np.newaxis]
_LEGENDRE = (_DEGREES + 0.5) * legendre.legvander(_POINTS, GAUSS_POINTS - 1).T * _WEIGHTS
"""Matrix from values at Gauss's points to Legendre coefficients of the polynomial through them."""


class Smooth(Protocol):
    """Protocol of a function of an array that has a slope."""

    def __call__(self, times: Array, /) -> Array:
        """Return the values."""

    def slope(self, times: Array, /) -> Array:
        """Return the derivatives."""


@dataclass(frozen=True, eq=False)
class Integral:
    """Integral of the function ``slope`` from a start, accurate to rounding.

    Computed by Gauss's rule on panels that are halved until both halves together agree with the
    whole. If the function is a formula, its derivative is also enclosed on each panel, which is
    halved if the derivative may leave the range sampled on the panel and its neighbours: a pulse
    between the points would otherwise be missed.

    >>> from longwave.derive.lattice_file import time_formula
    >>> from longwave.lattice.force_program import program_of
    >>> moved = Integral.of(program_of(time_formula("velocity", "cos(t)")), 1.0, 9.0)
    >>> bool(abs(moved(np.array(7.0)) - np.sin(7.0) + np.sin(1.0)) < 1e-15)
    True
    """

    slope: Smooth
    edges: Array
    sums: Array

    @classmethod
    def of(
        cls, slope: Smooth, begin: float, end: float, panels: int = MIN_PANELS, allowed: float = 0.0
    ) -> Integral:
        """Integrate ``slope`` from ``begin`` to ``end``.

        ``allowed`` is an error allowed on each panel in addition to rounding. Raises ValueError for
        a function that changes too fast.
        """
        knots = np.array(getattr(slope, "times", ()))
        within = knots[(begin < knots) & (knots < end)]
        edges = np.union1d(np.linspace(begin, end, panels + 1), within)
        low, high = edges[:-1], edges[1:]
        hull = _Hull.around(slope, low, high) if isinstance(slope, ForceProgram) else None
        largest_time, values = max(abs(begin), abs(end)), 0.0
        starts, sums, count = [low[:0]], [low[:0]], edges.size
        while low.size:
            middle = (low + high) / 2.0
            halves = integrated(slope, low, middle) + integrated(slope, middle, high)
            with np.errstate(all="ignore"):
                values = max(values, float(np.abs(slope(middle)).max()))
                sensitivity = largest_time * np.abs(slope.slope(middle))
                error = ROUNDING * (high - low) * (values + sensitivity) + allowed
                rough = ~(np.abs(halves - integrated(slope, low, high)) <= error)
                if hull is not None:
                    assert isinstance(slope, ForceProgram)
                    hull = hull.widened(slope, low, high)
                    rough |= hull.is_left_by(slope, low, high, error / (high - low) ** 2)
            rough &= high - low > LEAST_PANEL * np.maximum(np.abs(low), np.abs(high))
            starts.append(low[~rough])
            sums.append(halves[~rough])
            count += int(np.count_nonzero(rough))
            if count > MAX_PANELS:
                raise ValueError(
                    f"velocity of a wall must change slowly enough to be integrated, got one that "
                    f"{panels} panels from {begin:g} to {end:g} do not resolve (end earlier)"
                )
            halved = (low, middle), (middle, high)
            low, high = (np.column_stack(pair)[rough].ravel() for pair in halved)
            hull = None if hull is None else hull.halved(rough)
        order = np.argsort(np.concatenate(starts))
        edges = np.append(np.concatenate(starts)[order], end)
        return cls(slope, edges, np.append(0.0, np.cumsum(np.concatenate(sums)[order])))

    @cached_property
    def _rounding(self) -> Array:
        """Rounding error of the integral over each panel between two ``edges``."""
        return self._rounding_between(self.edges[:-1], self.edges[1:])

    def _rounding_between(self, low: Array, high: Array) -> Array:
        """Return the errors of integrals from ``low`` to ``high`` by rounded times and values."""
        points, size = np.array([low, (low + high) / 2.0, high]), float(np.abs(self.edges).max())
        with np.errstate(all="ignore"):
            values, slopes = np.abs(self.slope(points)), np.abs(self.slope.slope(points))
        return np.asarray(2.0**-52 * (high - low) * (values + size * slopes).max(axis=0))

    def rounding(self, low: Array, high: Array) -> Array:
        """Return each panel's rounding error of Gauss's rule minus this integral."""
        panels_error = self._rounding[self._panel_of(np.array([low, high]))].sum(axis=0)
        return np.asarray(panels_error + self._rounding_between(low, high))

    def missed_within(self, low: Array, high: Array) -> Array:
        """Return each panel's largest error of Gauss's rule for integrals to a point within it."""
        edges, sums = np.append(self.edges, high), np.append(self.sums, self(high))
        order = np.argsort(low)
        panel = order[np.searchsorted(low[order], edges, "left") - 1]
        on = (low[panel] < edges) & (edges <= high[panel])
        edges, sums, panel = edges[on], sums[on], panel[on]
        half, started = (high - low) / 2.0, self(low)
        with np.errstate(all="ignore"):
            values = self.slope(low[:, np.newaxis] + half[:, np.newaxis] * (1.0 + _POINTS))
            terms = legendre.legint(_LEGENDRE @ values.T, lbnd=-1.0)
            partial = legendre.legval(
                (edges - low[panel]) / half[panel] - 1.0, terms[:, panel], False
            )
            errors = np.abs(half[panel] * partial - (sums - started[panel]))
        most = np.zeros(low.size)
        np.maximum.at(most, panel, errors)
        return most

    def moment(self, low: Array, high: Array) -> Array:
        """Return, for each panel, the mean of the integral from the panel's beginning."""
        half = (high - low)[:, np.newaxis] / 2.0
        points = low[:, np.newaxis] + half * (1.0 + _POINTS)
        doubled_mean = (self(points) - self(low)[:, np.newaxis]) @ _WEIGHTS
        return np.asarray(doubled_mean / 2.0)

    def _panel_of(self, times: Array) -> NDArray[np.intp]:
        """Return the indices of the panels that contain these times."""
        return np.clip(np.searchsorted(self.edges, times, "right"), 1, self.edges.size - 1) - 1

    def __call__(self, times: Array, /) -> Array:
        """Return the integrals from the start to these times."""
        panel = self._panel_of(times)
        return np.asarray(self.sums[panel] + integrated(self.slope, self.edges[panel], times))


@dataclass(frozen=True)
class _Hull:
    """Range of the slopes sampled on each panel and its neighbours."""

    least: Array
    most: Array

    @classmethod
    def around(cls, value: ForceProgram, low: Array, high: Array) -> _Hull:
        """Return the hull of slopes at Gauss's points of the panels and of their neighbours."""
        least, most = _slopes_met(value, low, high)
        least, most = (np.pad(ends, 1, mode="edge") for ends in (least, most))
        return cls(
            np.minimum.reduce([least[:-2], least[1:-1], least[2:]]),
            np.maximum.reduce([most[:-2], most[1:-1], most[2:]]),
        )

    def widened(self, value: ForceProgram, low: Array, high: Array) -> _Hull:
        """Return the hull extended by the slopes sampled on the panels from ``low`` to ``high``."""
        least, most = _slopes_met(value, low, high)
        return _Hull(np.fmin(self.least, least), np.fmax(self.most, most))

    def is_left_by(self, value: ForceProgram, low: Array, high: Array, margin: Array) -> Mask:
        """Return a mask of panels on which the slope may leave the hull, widened by ``margin``."""
        bounds = value.slope_enclosed(low, high)
        largest = np.maximum(np.abs(self.least), np.abs(self.most))
        margin = margin + (self.most - self.least) + ENCLOSURE_SLACK * largest
        return ~((bounds[0] >= self.least - margin) & (bounds[1] <= self.most + margin))

    def halved(self, rough: Mask) -> _Hull:
        """Return the hull for the halves of the ``rough`` panels; the other panels are dropped."""
        return _Hull(np.repeat(self.least[rough], 2), np.repeat(self.most[rough], 2))


def _slopes_met(value: ForceProgram, low: Array, high: Array) -> tuple[Array, Array]:
    """Return the least and the largest slope at Gauss's points of each panel."""
    half = (high - low)[:, np.newaxis] / 2.0
    with np.errstate(all="ignore"):
        slopes = value.slope(low[:, np.newaxis] + half * (1.0 + _POINTS))
    return slopes.min(axis=1), slopes.max(axis=1)


def integrated(value: Smooth, low: Array, high: Array) -> Array:
    """Return the integrals from ``low`` to ``high`` by one application of Gauss's rule."""
    half = (high - low) / 2.0
    with np.errstate(all="ignore"):
        values = value(low[..., np.newaxis] + half[..., np.newaxis] * (1.0 + _POINTS))
    return np.asarray(half * (values @ _WEIGHTS))

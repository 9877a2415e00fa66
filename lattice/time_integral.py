"""Integrals of functions of one number to rounding, on panels that no feature slips between."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from longwave.lattice.force_program import ForceProgram

Array = NDArray[np.float64]

PANELS, MOST_PANELS, NODES = 2**13, 2**18, 12
"""Of an integral: at first, at most, and the points of Gauss's rule on each."""

ROUNDING = 2.0**-50
"""Share of the size of a panel's integral that is taken for rounding."""

LEAST_PANEL = 2.0**-48
"""Length of the shortest panel, in units of the largest number in it."""

LOOSE = 0.02
"""Share of the largest slope near a panel by which bounds may be too wide, as of a product of terms
that depend on each other: a straight line on either side of a corner would be halved for ever."""

_POINTS, _WEIGHTS = legendre.leggauss(NODES)

_LEGENDRE = (
    (np.arange(NODES)[:, np.newaxis] + 0.5) * legendre.legvander(_POINTS, NODES - 1).T * _WEIGHTS
)
"""Coefficients of the polynomial through values at the points."""


class Smooth(Protocol):
    """A function of an array of numbers that has a slope."""

    def __call__(self, times: Array, /) -> Array:
        """Return the values."""

    def slope(self, times: Array, /) -> Array:
        """Return the derivatives."""


@dataclass(frozen=True, eq=False)
class Integral:
    """The integral of a function from the start on, to rounding: the function is its slope.

    By Gauss's rule, on panels that are halved until their halves give the same. The slope of a
    formula is enclosed on each panel, which is halved, too, where it may leave the range of what is
    met on it and beside it: a pulse between the points would go unseen.

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
        cls,
        slope: Smooth,
        begin: float,
        end: float,
        panels: int = PANELS,
        allowed: float = 0.0,
    ) -> Integral:
        """From the first of two numbers on, to the second; ValueError for what is too fast.

        ``allowed`` is an error of a panel's integral beside that of rounding.
        """
        knots = np.array(getattr(slope, "times", ()))
        within = knots[(begin < knots) & (knots < end)]
        edges = np.union1d(np.linspace(begin, end, panels + 1), within)
        low, high = edges[:-1], edges[1:]
        met = _Hull.around(slope, low, high) if isinstance(slope, ForceProgram) else None
        size, values = max(abs(begin), abs(end)), 0.0
        starts, sums, count = [low[:0]], [low[:0]], edges.size
        while low.size:
            middle = (low + high) / 2.0
            halves = integrated(slope, low, middle) + integrated(slope, middle, high)
            with np.errstate(all="ignore"):
                values = max(values, float(np.abs(slope(middle)).max()))
                turned = size * np.abs(slope.slope(middle))
                error = ROUNDING * (high - low) * (values + turned) + allowed
                rough = ~(np.abs(halves - integrated(slope, low, high)) <= error)
                if met is not None:
                    assert isinstance(slope, ForceProgram)
                    met = met.widened(slope, low, high)
                    rough |= met.is_left_by(slope, low, high, error / (high - low) ** 2)
            rough &= high - low > LEAST_PANEL * np.maximum(np.abs(low), np.abs(high))
            starts.append(low[~rough])
            sums.append(halves[~rough])
            count += int(np.count_nonzero(rough))
            if count > MOST_PANELS:
                raise ValueError(
                    f"velocity of a wall must change slowly enough to be integrated, got one that "
                    f"{panels} panels from {begin:g} to {end:g} do not resolve (end earlier)"
                )
            low, high = (
                np.column_stack(pair)[rough].ravel() for pair in ((low, middle), (middle, high))
            )
            met = None if met is None else met.halved(rough)
        order = np.argsort(np.concatenate(starts))
        edges = np.append(np.concatenate(starts)[order], end)
        return cls(slope, edges, np.append(0.0, np.cumsum(np.concatenate(sums)[order])))

    @cached_property
    def _rounding(self) -> Array:
        """What rounding does to the integral on each panel."""
        return self._rounded(self.edges[:-1], self.edges[1:])

    def _rounded(self, low: Array, high: Array) -> Array:
        """What rounding of numbers and of values does to integrals from ``low`` to ``high``."""
        points, size = np.array([low, (low + high) / 2.0, high]), float(np.abs(self.edges).max())
        with np.errstate(all="ignore"):
            values, slopes = np.abs(self.slope(points)), np.abs(self.slope.slope(points))
        return np.asarray(2.0**-52 * (high - low) * (values + size * slopes).max(axis=0))

    def rounding(self, low: Array, high: Array) -> Array:
        """The same, of an integral by Gauss's rule beside one of `Integral`."""
        own = self._rounding[self._places(np.array([low, high]))].sum(axis=0)
        return np.asarray(own + self._rounded(low, high))

    def missed_within(self, low: Array, high: Array) -> Array:
        """How far Gauss's rule is off on panels, from their beginnings to any edge of its own.

        On each panel the most, for all edges on it and its end: (panels,).
        """
        edges, sums = np.append(self.edges, high), np.append(self.sums, self(high))
        order = np.argsort(low)
        place = order[np.searchsorted(low[order], edges, "left") - 1]
        on = (low[place] < edges) & (edges <= high[place])
        edges, sums, place = edges[on], sums[on], place[on]
        half, begun = (high - low) / 2.0, self(low)
        with np.errstate(all="ignore"):
            values = self.slope(low[:, np.newaxis] + half[:, np.newaxis] * (1.0 + _POINTS))
            terms = legendre.legint(_LEGENDRE @ values.T, lbnd=-1.0)
            found = legendre.legval(
                (edges - low[place]) / half[place] - 1.0, terms[:, place], False
            )
            apart = np.abs(half[place] * found - (sums - begun[place]))
        most = np.zeros(low.size)
        np.maximum.at(most, place, apart)
        return most

    def moment(self, low: Array, high: Array) -> Array:
        """What the integral itself comes to on panels, in units of their lengths."""
        half = (high - low)[:, np.newaxis] / 2.0
        points = low[:, np.newaxis] + half * (1.0 + _POINTS)
        found = (self(points) - self(low)[:, np.newaxis]) @ _WEIGHTS
        return np.asarray(found / 2.0)

    def _places(self, times: Array) -> NDArray[np.intp]:
        return np.clip(np.searchsorted(self.edges, times, "right"), 1, self.edges.size - 1) - 1

    def __call__(self, times: Array, /) -> Array:
        """The integrals from the start to these times."""
        place = self._places(times)
        return np.asarray(self.sums[place] + integrated(self.slope, self.edges[place], times))


@dataclass(frozen=True)
class _Hull:
    """Least and largest slopes that were met on each panel and beside it."""

    least: Array
    most: Array

    @classmethod
    def around(cls, value: ForceProgram, low: Array, high: Array) -> _Hull:
        """Those on the panels and on their neighbours."""
        least, most = _slopes_met(value, low, high)
        least, most = (np.pad(ends, 1, mode="edge") for ends in (least, most))
        return cls(
            np.minimum.reduce([least[:-2], least[1:-1], least[2:]]),
            np.maximum.reduce([most[:-2], most[1:-1], most[2:]]),
        )

    def widened(self, value: ForceProgram, low: Array, high: Array) -> _Hull:
        """With those that are met at the points of the panels themselves."""
        least, most = _slopes_met(value, low, high)
        return _Hull(np.fmin(self.least, least), np.fmax(self.most, most))

    def is_left_by(
        self, value: ForceProgram, low: Array, high: Array, room: Array
    ) -> NDArray[np.bool_]:
        """Whether slopes on the panels may leave it by more than its width and ``room``.

        And by more than their part `LOOSE`.
        """
        bounds = value.slope_enclosed(low, high)
        largest = np.maximum(np.abs(self.least), np.abs(self.most))
        room = room + (self.most - self.least) + LOOSE * largest
        return ~((bounds[0] >= self.least - room) & (bounds[1] <= self.most + room))

    def halved(self, rough: NDArray[np.bool_]) -> _Hull:
        """Those of both halves of the panels that are halved."""
        return _Hull(np.repeat(self.least[rough], 2), np.repeat(self.most[rough], 2))


def _slopes_met(value: ForceProgram, low: Array, high: Array) -> tuple[Array, Array]:
    """The least and the largest slope at points of each panel."""
    half = (high - low)[:, np.newaxis] / 2.0
    with np.errstate(all="ignore"):
        found = value.slope(low[:, np.newaxis] + half * (1.0 + _POINTS))
    return found.min(axis=1), found.max(axis=1)


def integrated(value: Smooth, low: Array, high: Array) -> Array:
    """The integrals between numbers, by Gauss's rule."""
    half = (high - low) / 2.0
    with np.errstate(all="ignore"):
        found = value(low[..., np.newaxis] + half[..., np.newaxis] * (1.0 + _POINTS))
    return np.asarray(half * (found @ _WEIGHTS))

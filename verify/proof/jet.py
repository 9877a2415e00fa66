"""Truncated Taylor series in several variables with ball coefficients.

A jet holds the Taylor coefficients ``c[i, j, ...]`` of a function at a point for the multi-indices
of a set that contains, with an index, all smaller ones.  Every operation is python-flint's ball
arithmetic, so the true coefficient lies in its ball.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from flint import acb

Index = tuple[int, ...]


class Shape:
    """The multi-indices below some given ones, with the pairs whose sum stays among them."""

    def __init__(self, tops: Sequence[Index]) -> None:
        found = {tuple(0 for _ in tops[0])}
        waiting = list(tops)
        while waiting:
            index = waiting.pop()
            if index not in found:
                found.add(index)
                waiting += [_lowered(index, place) for place in range(len(index)) if index[place]]
        self.indices = sorted(found, key=lambda index: (sum(index), index))
        self.order = max(map(sum, self.indices))
        place = {index: i for i, index in enumerate(self.indices)}
        self.products = [
            (i, j, place[total])
            for i, left in enumerate(self.indices)
            for j, right in enumerate(self.indices)
            if (total := tuple(map(sum, zip(left, right, strict=True)))) in place
        ]


def _lowered(index: Index, place: int) -> Index:
    return tuple(value - (i == place) for i, value in enumerate(index))


@dataclass(frozen=True)
class Jet:
    """Coefficients in the order of ``shape.indices``; the first is the value."""

    shape: Shape
    coefficients: tuple[acb, ...]

    @property
    def value(self) -> acb:
        """The value at the point."""
        return self.coefficients[0]

    def __add__(self, other: Jet) -> Jet:
        pairs = zip(self.coefficients, other.coefficients, strict=True)
        return Jet(self.shape, tuple(a + b for a, b in pairs))

    def __mul__(self, other: Jet) -> Jet:
        total = [acb(0)] * len(self.coefficients)
        for i, j, place in self.shape.products:
            total[place] += self.coefficients[i] * other.coefficients[j]
        return Jet(self.shape, tuple(total))

    def composed(self, taylor: Callable[[acb, int], Sequence[acb]]) -> Jet:
        """``f(self)``, with ``taylor(z, n)`` the coefficients of f at z up to order n."""
        outer = taylor(self.value, self.shape.order)
        step = Jet(self.shape, (acb(0), *self.coefficients[1:]))
        result = constant(self.shape, outer[-1])
        for coefficient in reversed(outer[:-1]):
            result = result * step + constant(self.shape, coefficient)
        return result

    def conjugate(self) -> Jet:
        """The complex conjugate, for real variables."""
        parts = (acb(c.real, -c.imag) for c in self.coefficients)
        return Jet(self.shape, tuple(parts))


def constant(shape: Shape, value: acb) -> Jet:
    """A constant as a jet."""
    return Jet(shape, (value,) + (acb(0),) * (len(shape.indices) - 1))


def variable(shape: Shape, place: int, value: acb) -> Jet:
    """The variable number ``place`` at ``value``."""
    unit = tuple(int(i == place) for i in range(len(shape.indices[0])))
    slopes = {unit: acb(1)}
    rest: Mapping[Index, acb] = slopes
    return Jet(shape, (value, *(rest.get(index, acb(0)) for index in shape.indices[1:])))

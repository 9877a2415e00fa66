"""Taylor series of several variables in balls, up to a total order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from flint import acb

Index = tuple[int, ...]


@dataclass(frozen=True)
class TaylorSum:
    """Taylor coefficients up to a total order, in as many variables as the indices are long."""

    order: int
    terms: Mapping[Index, acb]

    @property
    def value(self) -> acb:
        """The value at the point."""
        return self.terms[(0,) * len(next(iter(self.terms)))]

    @property
    def is_constant(self) -> bool:
        """Whether all coefficients behind the value are 0."""
        return all(c == 0 for index, c in self.terms.items() if any(index))

    @property
    def is_real(self) -> bool:
        """Whether no coefficient has an imaginary part."""
        return all(c.imag == 0 for c in self.terms.values())

    def __add__(self, other: TaylorSum) -> TaylorSum:
        order, found = min(self.order, other.order), dict(self.terms)
        for index, c in other.terms.items():
            found[index] = found[index] + c if index in found else c
        return TaylorSum(order, _short(found, order))

    def __mul__(self, other: TaylorSum) -> TaylorSum:
        order = min(self.order, other.order)
        found: dict[Index, acb] = {}
        for (left, a), (right, b) in product(self.terms.items(), other.terms.items()):
            index = tuple(map(sum, zip(left, right, strict=True)))
            if sum(index) <= order:
                found[index] = found[index] + a * b if index in found else a * b
        return TaylorSum(order, found)

    def times(self, number: acb) -> TaylorSum:
        """A multiple."""
        return TaylorSum(self.order, {index: c * number for index, c in self.terms.items()})

    def conjugate(self) -> TaylorSum:
        """The conjugate, for real variables."""
        return TaylorSum(self.order, {i: c.conjugate() for i, c in self.terms.items()})

    def of(self, coefficients: Sequence[acb]) -> TaylorSum:
        """A function of it, by its Taylor coefficients at the value."""
        start = (0,) * len(next(iter(self.terms)))
        rest = TaylorSum(self.order, {**self.terms, start: acb(0)})
        found = TaylorSum(self.order, {start: coefficients[-1]})
        for coefficient in reversed(coefficients[:-1]):
            found = found * rest + TaylorSum(self.order, {start: coefficient})
        return found

    def slope(self, place: int) -> TaylorSum:
        """The derivative by one of the variables, of one order less."""
        found = {(0,) * len(next(iter(self.terms))): acb(0)}
        for index, c in self.terms.items():
            if index[place]:
                lower = tuple(k - (i == place) for i, k in enumerate(index))
                found[lower] = c * index[place]
        return TaylorSum(self.order - 1, found)


def _short(terms: dict[Index, acb], order: int) -> dict[Index, acb]:
    return {index: c for index, c in terms.items() if sum(index) <= order}

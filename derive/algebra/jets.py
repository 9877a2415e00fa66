"""Sparse polynomials in the derivatives (jets) of one unknown field, and series in eps of them.

A jet is the tuple of derivative counts along the slow axes, time last: in one dimension
``(d_X, d_T)``, so ``Y`` is ``(0, 0)`` and ``Y_XT`` is ``(1, 1)``.  A monomial is the sorted tuple
of its jets, with repetition; ``()`` is the constant monomial.  Coefficients are rational functions
of the constants, so the algebra is exact.

A first-order operator is a tuple of ``(axis, exponent, factor)``, representing the sum of
``factor eps^exponent d_axis``.  A lattice shift is the exponential of such an operator, and the
time derivative is such an operator.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from longwave.derive.algebra.rational_functions import RationalFunction, RationalFunctions

Jet = tuple[int, ...]
Monomial = tuple[Jet, ...]
Operator = tuple[tuple[int, int, RationalFunction], ...]


def raised(jet: Jet, axis: int, by: int = 1) -> Jet:
    """Return the jet with ``by`` more derivatives along ``axis``.

    >>> raised((1, 0), 1)
    (1, 1)
    """
    return (*jet[:axis], jet[axis] + by, *jet[axis + 1 :])


@dataclass(frozen=True)
class DifferentialPolynomial:
    """``{monomial: coefficient}`` over ``field``; zero coefficients are never stored.

    >>> from longwave.derive.symbols import K4
    >>> constants = RationalFunctions((K4,))
    >>> Y = DifferentialPolynomial.monomial(constants, ((0, 0),))
    >>> (constants(K4) * Y * Y).derivative(0).terms
    {((0, 0), (1, 0)): 2*K4}
    """

    field: RationalFunctions
    terms: Mapping[Monomial, RationalFunction]

    @classmethod
    def collect(
        cls, field: RationalFunctions, items: Iterable[tuple[Monomial, RationalFunction]]
    ) -> DifferentialPolynomial:
        """Sum the (monomial, coefficient) pairs, dropping terms that cancel."""
        total: dict[Monomial, RationalFunction] = {}
        for monomial, coefficient in items:
            previous = total.get(monomial)
            total[monomial] = coefficient if previous is None else previous + coefficient
        return cls(field, {key: value for key, value in total.items() if value})

    @classmethod
    def monomial(cls, field: RationalFunctions, jets: Iterable[Jet]) -> DifferentialPolynomial:
        """Return the product of the given jets with coefficient one."""
        return cls(field, {tuple(sorted(jets)): field.one})

    @classmethod
    def zero(cls, field: RationalFunctions) -> DifferentialPolynomial:
        """Return the zero polynomial."""
        return cls(field, {})

    def __bool__(self) -> bool:
        return bool(self.terms)

    def __add__(self, other: DifferentialPolynomial) -> DifferentialPolynomial:
        return self.collect(self.field, [*self.terms.items(), *other.terms.items()])

    def __neg__(self) -> DifferentialPolynomial:
        return self.map_coefficients(lambda value: -value)

    def __sub__(self, other: DifferentialPolynomial) -> DifferentialPolynomial:
        return self + (-other)

    def __mul__(self, other: DifferentialPolynomial) -> DifferentialPolynomial:
        products = (
            (tuple(sorted(left + right)), left_value * right_value)
            for left, left_value in self.terms.items()
            for right, right_value in other.terms.items()
        )
        return self.collect(self.field, products)

    def __rmul__(self, scalar: RationalFunction) -> DifferentialPolynomial:
        return self.map_coefficients(lambda value: scalar * value)

    def map_coefficients(
        self, function: Callable[[RationalFunction], RationalFunction]
    ) -> DifferentialPolynomial:
        """Apply ``function`` to every coefficient; terms that become zero are dropped."""
        return self.collect(self.field, ((key, function(v)) for key, v in self.terms.items()))

    def select(self, keep: Callable[[Monomial], bool]) -> DifferentialPolynomial:
        """Return the polynomial of the terms whose monomials satisfy ``keep``."""
        return DifferentialPolynomial(self.field, {m: v for m, v in self.terms.items() if keep(m)})

    def derivative(self, axis: int) -> DifferentialPolynomial:
        """Return the total derivative along ``axis`` (Leibniz rule on the jets)."""
        items = (
            (tuple(sorted((*m[:i], raised(jet, axis), *m[i + 1 :]))), value)
            for m, value in self.terms.items()
            for i, jet in enumerate(m)
        )
        return self.collect(self.field, items)

    def coefficient(self, *jets: Jet) -> RationalFunction:
        """Return the coefficient of the product of ``jets``, zero if absent."""
        return self.terms.get(tuple(sorted(jets)), self.field.zero)

    def antiderivative(self, axis: int = 0) -> DifferentialPolynomial | None:
        """Return the polynomial without constant term whose ``axis``-derivative this is, or None.

        Monomials are ranked by their jets in falling order.  The leading term of a derivative has
        its highest jet to the first power, and lowering that jet gives the leading term of the
        antiderivative; if it cannot be lowered there is no antiderivative.

        >>> from longwave.derive.symbols import K4
        >>> constants = RationalFunctions((K4,))
        >>> Y_X = DifferentialPolynomial.monomial(constants, ((1, 0),))
        >>> (Y_X * Y_X).antiderivative() is None
        True
        """
        remaining, result = self, self.zero(self.field)
        while remaining:
            leading = max(remaining.terms, key=lambda m: sorted(m, reverse=True))
            lowered = _lowered(leading, axis)
            if lowered is None:
                return None
            value = remaining.terms[leading] / self.field(lowered.count(lowered[-1]))
            term = DifferentialPolynomial(self.field, {lowered: value})
            result, remaining = result + term, remaining - term.derivative(axis)
        return result


def _lowered(monomial: Monomial, axis: int) -> Monomial | None:
    """Return the monomial whose ``axis``-derivative has the leading term ``monomial``, or None."""
    if not monomial or monomial[-1][axis] == 0:
        return None
    jet = raised(monomial[-1], axis, -1)
    if len(monomial) > 1 and jet < monomial[-2]:
        return None
    return (*monomial[:-1], jet)


@dataclass(frozen=True)
class EpsSeries:
    """``{order: polynomial}``, truncated above the order ``limit``."""

    field: RationalFunctions
    limit: int
    parts: Mapping[int, DifferentialPolynomial]

    @classmethod
    def collect(
        cls,
        field: RationalFunctions,
        limit: int,
        items: Iterable[tuple[int, DifferentialPolynomial]],
    ) -> EpsSeries:
        """Sum the (order, polynomial) pairs up to ``limit``, dropping terms that cancel."""
        total: dict[int, DifferentialPolynomial] = {}
        for order, part in items:
            if order <= limit:
                total[order] = total[order] + part if order in total else part
        return cls(field, limit, {order: total[order] for order in sorted(total) if total[order]})

    def __add__(self, other: EpsSeries) -> EpsSeries:
        return self.collect(self.field, self.limit, [*self.parts.items(), *other.parts.items()])

    def __mul__(self, other: EpsSeries) -> EpsSeries:
        items = (
            (i + j, left * right)
            for i, left in self.parts.items()
            for j, right in other.parts.items()
            if i + j <= self.limit
        )
        return self.collect(self.field, self.limit, items)

    def __rmul__(self, scalar: RationalFunction) -> EpsSeries:
        items = ((i, scalar * part) for i, part in self.parts.items())
        return self.collect(self.field, self.limit, items)

    def apply(self, operator: Operator) -> EpsSeries:
        """Return the series with the first-order ``operator`` applied to it."""
        items = (
            (order + exponent, factor * part.derivative(axis))
            for order, part in self.parts.items()
            for axis, exponent, factor in operator
            if order + exponent <= self.limit
        )
        return self.collect(self.field, self.limit, items)

    def exponential(self, operator: Operator) -> EpsSeries:
        """Return ``exp(operator)`` applied to the series, as a sum of powers of the operator."""
        total, power, count = self, self, 0
        while power.parts and operator:
            count += 1
            power = (self.field.one / count) * power.apply(operator)
            total = total + power
        return total

    def at(self, order: int) -> DifferentialPolynomial:
        """Return the coefficient of ``eps^order``."""
        return self.parts.get(order) or DifferentialPolynomial.zero(self.field)

    def upto(self, limit: int, since: int = 0) -> EpsSeries:
        """Return the part of the series from ``eps^since`` to ``eps^limit``, both included."""
        items = (item for item in self.parts.items() if item[0] >= since)
        return self.collect(self.field, limit, items)

    def plus(self, order: int, part: DifferentialPolynomial) -> EpsSeries:
        """Return the series plus ``eps^order`` times a polynomial."""
        return self.collect(self.field, self.limit, [*self.parts.items(), (order, part)])

    def replaced(self, value: Callable[[Jet], EpsSeries | None]) -> EpsSeries:
        """Replace each jet by the series ``value(jet)``; a jet whose value is None is kept."""
        total = EpsSeries(self.field, self.limit, {})
        for order, part in self.parts.items():
            for monomial, number in part.terms.items():
                values = [(jet, value(jet)) for jet in monomial]
                kept = tuple(jet for jet, replacement in values if replacement is None)
                unchanged = DifferentialPolynomial(self.field, {kept: number})
                product = self.collect(self.field, self.limit, [(order, unchanged)])
                for _, replacement in values:
                    product = product if replacement is None else product * replacement
                total = total + product
        return total

    def derivative(self, axis: int, times: int = 1) -> EpsSeries:
        """Differentiate ``times`` times along ``axis``; the powers of eps do not change."""
        result = self
        for _ in range(times):
            result = result.apply(((axis, 0, self.field.one),))
        return result

    def delayed(self, by: int) -> EpsSeries:
        """Return the series times ``eps^by``."""
        return self.collect(self.field, self.limit, ((i + by, p) for i, p in self.parts.items()))

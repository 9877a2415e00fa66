"""Differential polynomials: sparse polynomials in the derivatives (jets) of one unknown field.

A jet is the tuple of derivative counts along the slow axes, time last: in one dimension
``(d_X, d_T)``, so ``Y`` is ``(0, 0)`` and ``Y_XT`` is ``(1, 1)``.  A monomial is the sorted tuple
of its jets, repeated as often as they occur; ``()`` is the constant monomial.  Coefficients are
rational functions of the constants, so the algebra is exact.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from longwave.derive.algebra.rational_functions import RationalFunction, RationalFunctions

Jet = tuple[int, ...]
Monomial = tuple[Jet, ...]


def raised(jet: Jet, axis: int, by: int = 1) -> Jet:
    """The jet with ``by`` more derivatives along ``axis``.

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
        """Sum the (monomial, coefficient) pairs, dropping what cancels."""
        total: dict[Monomial, RationalFunction] = {}
        for monomial, coefficient in items:
            known = total.get(monomial)
            total[monomial] = coefficient if known is None else known + coefficient
        return cls(field, {key: value for key, value in total.items() if value})

    @classmethod
    def monomial(cls, field: RationalFunctions, jets: Iterable[Jet]) -> DifferentialPolynomial:
        """The product of the given jets with coefficient one."""
        return cls(field, {tuple(sorted(jets)): field.one})

    @classmethod
    def zero(cls, field: RationalFunctions) -> DifferentialPolynomial:
        """The zero polynomial."""
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
        return self.collect(
            self.field,
            (
                (tuple(sorted(left + right)), left_value * right_value)
                for left, left_value in self.terms.items()
                for right, right_value in other.terms.items()
            ),
        )

    def __rmul__(self, scalar: RationalFunction) -> DifferentialPolynomial:
        return self.map_coefficients(lambda value: scalar * value)

    def map_coefficients(
        self, function: Callable[[RationalFunction], RationalFunction]
    ) -> DifferentialPolynomial:
        """Apply ``function`` to every coefficient; terms that become zero are dropped."""
        return self.collect(self.field, ((key, function(v)) for key, v in self.terms.items()))

    def select(self, keep: Callable[[Monomial], bool]) -> DifferentialPolynomial:
        """The part whose monomials satisfy ``keep``."""
        return DifferentialPolynomial(self.field, {m: v for m, v in self.terms.items() if keep(m)})

    def derivative(self, axis: int) -> DifferentialPolynomial:
        """The total derivative along ``axis`` (Leibniz rule on the jets)."""
        return self.collect(
            self.field,
            (
                (tuple(sorted((*m[:i], raised(jet, axis), *m[i + 1 :]))), value)
                for m, value in self.terms.items()
                for i, jet in enumerate(m)
            ),
        )

    def coefficient(self, *jets: Jet) -> RationalFunction:
        """The coefficient of the product of ``jets``, zero when absent."""
        return self.terms.get(tuple(sorted(jets)), self.field.zero)

    def antiderivative(self, axis: int = 0) -> DifferentialPolynomial | None:
        """The polynomial without constant term whose ``axis``-derivative this is, or None.

        Monomials are ranked by their jets in falling order.  The leading term of a derivative has
        its highest jet to the first power, and lowering that jet gives the leading term of the
        antiderivative; when it cannot be lowered no antiderivative exists.

        >>> from longwave.derive.symbols import K4
        >>> constants = RationalFunctions((K4,))
        >>> Y_X = DifferentialPolynomial.monomial(constants, ((1, 0),))
        >>> (Y_X * Y_X).antiderivative() is None
        True
        """
        rest, result = self, self.zero(self.field)
        while rest:
            leading = max(rest.terms, key=lambda m: sorted(m, reverse=True))
            lowered = _lowered(leading, axis)
            if lowered is None:
                return None
            multiplicity = self.field(lowered.count(lowered[-1]))
            term = DifferentialPolynomial(self.field, {lowered: rest.terms[leading] / multiplicity})
            result, rest = result + term, rest - term.derivative(axis)
        return result


def _lowered(monomial: Monomial, axis: int) -> Monomial | None:
    """The monomial with its highest jet lowered, or None if that is not its preimage."""
    if not monomial or monomial[-1][axis] == 0:
        return None
    jet = raised(monomial[-1], axis, -1)
    if len(monomial) > 1 and jet < monomial[-2]:
        return None
    return (*monomial[:-1], jet)

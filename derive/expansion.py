"""The lattice equation under the ansatz, as one series in eps.

Shifts are exponentials, ``f_{n+s} = exp(s . sum eps^a d_X) f``, and time derivatives follow the
chain rule, ``d/dt = -sum speed eps^a d_X + eps^q d_T``.  The force is evaluated by Horner's rule
on the stretch of the bond, so that differences cancel before they are multiplied.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import QQ, Expr
from sympy.polys.fields import FracField
from sympy.polys.orderings import lex

from derive.algebra.exact_numbers import instance
from derive.algebra.jets import DifferentialPolynomial
from derive.algebra.series import EpsSeries, Operator
from derive.lattice import Bond, Cell, Lattice, Stencil
from derive.scaling import Scaling
from derive.symbols import check_constants, powers_of_eps


def coefficient_field(lattice: Lattice, scaling: Scaling) -> FracField:
    """The rational functions of the ansatz' and the lattice's constants, over Q."""
    own = [s for s in scaling.constants if s not in lattice.constants]
    check_constants((*own, *lattice.constants))
    return FracField((*own, *lattice.constants), QQ, lex)


@dataclass(frozen=True)
class Expansion:
    """Expands ``lattice`` under ``scaling`` up to the power ``limit`` of eps."""

    lattice: Lattice
    scaling: Scaling
    limit: int
    field: FracField

    @property
    def time_derivative(self) -> Operator:
        """d/dt by the chain rule through the slow variables."""
        frame = tuple(
            (axis, variable.exponent, -self.field.from_expr(variable.speed))
            for axis, variable in enumerate(self.scaling.space)
        )
        return (*frame, (len(frame), self.scaling.time, self.field.one))

    def shift(self, cell: Cell) -> Operator:
        """The logarithm of the shift by ``cell``."""
        steps = (
            (axis, v.exponent, sum(d * s for d, s in zip(v.direction, cell, strict=True)))
            for axis, v in enumerate(self.scaling.space)
        )
        return tuple((axis, power, self.field(step)) for axis, power, step in steps if step)

    def ansatz(self) -> EpsSeries:
        """``background + eps^amplitude Y``."""
        jet = (0,) * len(self.scaling.axes)
        wave = DifferentialPolynomial.monomial(self.field, (jet,))
        one = DifferentialPolynomial.monomial(self.field, ())
        mean = (
            (power + further, self.field.from_expr(part) * one)
            for power, value in self.scaling.background
            for further, part in powers_of_eps(value).items()
        )
        return EpsSeries.collect(self.field, self.limit, [(self.scaling.amplitude, wave), *mean])

    def velocity(self) -> EpsSeries:
        """d/dt of the ansatz."""
        return self.ansatz().apply(self.time_derivative)

    def residual(self) -> EpsSeries:
        """``mass y'' - forces`` under the ansatz; the lattice is solved where it vanishes."""
        acceleration = self.velocity().apply(self.time_derivative)
        total = self._number(self.lattice.masses[0]) * acceleration
        for bond in self.lattice.bonds:
            force = self._force(bond, self._combined(bond.stretch, self.ansatz()))
            total = total + self.field(-1) * self._combined(bond.action, force)
        return total

    def _combined(self, stencils: tuple[Stencil, ...], series: EpsSeries) -> EpsSeries:
        total = EpsSeries(self.field, self.limit, {})
        for entry in stencils:
            shifted = series.exponential(self.shift(entry.shift))
            total = total + self.field(entry.weight) * shifted
        return total

    def _force(self, bond: Bond, stretch: EpsSeries) -> EpsSeries:
        total = EpsSeries(self.field, self.limit, {})
        for coefficient in bond.coefficients():
            total = total * stretch + self._number(coefficient)
        return total

    def _number(self, value: Expr) -> EpsSeries:
        """A constant, which may be a polynomial in eps, as a series."""
        one = DifferentialPolynomial.monomial(self.field, ())
        parts = powers_of_eps(value).items()
        return EpsSeries.collect(
            self.field, self.limit, ((p, self.field.from_expr(part) * one) for p, part in parts)
        )


def expand(lattice: Lattice, scaling: Scaling, limit: int) -> Expansion:
    """The expansion of a one-field lattice up to ``eps^limit``.

    Raises ValueError for a lattice with several fields, and for a scaling that does not fit it.
    """
    instance("lattice", lattice, Lattice, "LATTICES['fput_strain'] is one")
    instance("scaling", scaling, Scaling, "Scaling() is the paper's")
    if len(lattice.fields) != 1:
        raise ValueError(
            f"lattice must have one field, got {len(lattice.fields)} "
            "(the expansion does not slave fields to one another)"
        )
    for variable in scaling.space:
        if len(variable.direction) != lattice.dimension:
            raise ValueError(
                f"direction of {variable.name} must have {lattice.dimension} entries, one an axis "
                f"of {lattice.name}, got {variable.direction} ((1,) is along a chain)"
            )
    if scaling.frame_symbol in lattice.constants:
        raise ValueError(
            f"speed must be no constant of {lattice.name}, got {scaling.speed} (the reduction "
            "finds it: take another symbol)"
        )
    return Expansion(lattice, scaling, limit, coefficient_field(lattice, scaling))

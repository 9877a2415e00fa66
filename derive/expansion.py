"""The lattice equation under the ansatz, as one series in eps.

Shifts are exponentials, ``f_{n+s} = exp(s . sum eps^a d_X) f``, and time derivatives follow the
chain rule, ``d/dt = -sum speed eps^a d_X + eps^q d_T``.  The force is evaluated by Horner's rule
on the stretch of the bond, so that differences cancel before they are multiplied.

The fields of a cell move together in a long wave, ``f_j = eps^p (e_j W + G_j)``: e is the null
vector of the forces at wavenumber zero.  All rows of the equations of motion but one are solved for
the slaved parts G order by order; the rows weighted with the left null vector leave one equation
for W.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from sympy import Expr, S

from longwave.derive.algebra.exact_numbers import instance
from longwave.derive.algebra.jets import DifferentialPolynomial
from longwave.derive.algebra.rational_functions import RationalFunctions
from longwave.derive.algebra.series import EpsSeries, Operator
from longwave.derive.algebra.small_matrices import (
    Column,
    Matrix,
    inverse,
    null_space,
    transposed,
    without,
)
from longwave.derive.lattice import Bond, Cell, Lattice
from longwave.derive.scaling import Scaling
from longwave.derive.symbols import check_constants, powers_of_eps


def coefficient_field(lattice: Lattice, scaling: Scaling) -> RationalFunctions:
    """The rational functions of the ansatz' and the lattice's constants, over Q."""
    own = [s for s in scaling.constants if s not in lattice.constants]
    check_constants((*own, *lattice.constants))
    return RationalFunctions((*own, *lattice.constants))


@dataclass(frozen=True)
class Expansion:
    """Expands ``lattice`` under ``scaling`` up to the power ``limit`` of eps."""

    lattice: Lattice
    scaling: Scaling
    limit: int
    field: RationalFunctions

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
        return tuple(
            (axis, power, self.field.from_expr(step)) for axis, power, step in steps if step
        )

    @cached_property
    def together(self) -> tuple[Column, Column]:
        """The null vectors of the forces at wavenumber zero, right and left: e and l.

        The first entry of each that is not 0 is 1.  Raises ValueError unless there is one of each.
        """
        matrix = self._uniform_forces()
        found = (null_space(matrix), null_space(transposed(matrix)))
        if any(len(vectors) != 1 for vectors in found):
            apart, held = "its fields move apart at no cost", "pinned: derive a carrier's envelope"
            raise ValueError(
                f"lattice must have one wave of vanishing frequency, got {len(found[0])} "
                f"({apart if len(found[0]) > 1 else held})"
            )
        return found[0][0], found[1][0]

    @property
    def is_displacement(self) -> bool:
        """Whether no bond feels all fields moved together: the wave enters by its derivatives."""
        moved = self.together[0]
        return not any(
            sum((entry.weight * moved[entry.field] for entry in bond.stretch), self.field.zero)
            for bond in self.lattice.bonds
        )

    def ansatz(self) -> EpsSeries:
        """``background + eps^amplitude W``."""
        mean = (
            (power + further, self.field.from_expr(part) * self._one)
            for power, value in self.scaling.background
            for further, part in powers_of_eps(value).items()
        )
        wave = (self.scaling.amplitude, self._wave)
        return EpsSeries.collect(self.field, self.limit, [wave, *mean])

    def velocity(self) -> EpsSeries:
        """d/dt of the ansatz."""
        return self.ansatz().apply(self.time_derivative)

    def slaved(self) -> tuple[EpsSeries, ...]:
        """The parts G of the fields that follow the wave, with their power of eps."""
        right, left = self.together
        count = len(right)
        parts = [EpsSeries(self.field, self.limit, {})] * count
        if count == 1:
            return tuple(parts)
        column = next(j for j, value in enumerate(right) if value)
        row = next(i for i, value in enumerate(left) if value)
        rows, columns = ([i for i in range(count) if i != out] for out in (row, column))
        solved = inverse(without(self._uniform_forces(), row, column))
        for order in range(self.scaling.amplitude + 1, self.limit + 1):
            short = replace(self, limit=order)
            known = short.residuals(tuple(parts))
            nothing = DifferentialPolynomial.zero(self.field)
            rest = [known[i].parts.get(order, nothing) for i in rows]
            for weights, j in zip(solved, columns, strict=True):
                terms = (w * part for w, part in zip(weights, rest, strict=True) if w and part)
                found = [(order, sum(terms, nothing)), *parts[j].parts.items()]
                parts[j] = EpsSeries.collect(self.field, self.limit, found)
        return tuple(parts)

    def residuals(self, slaved: tuple[EpsSeries, ...]) -> tuple[EpsSeries, ...]:
        """``mass f'' - forces`` of each field, with these slaved parts."""
        fields = [
            EpsSeries.collect(
                self.field,
                self.limit,
                [*((value * self.ansatz()).parts.items() if value else ()), *part.parts.items()],
            )
            for value, part in zip(self.together[0], slaved, strict=True)
        ]
        rows = [
            self._number(mass) * field.apply(self.time_derivative).apply(self.time_derivative)
            for mass, field in zip(self.lattice.masses, fields, strict=True)
        ]
        for bond in self.lattice.bonds:
            force = self._force(bond, self._stretch(bond, fields))
            for entry in bond.action:
                pull = self.field(-entry.weight) * force.exponential(self.shift(entry.shift))
                rows[entry.field] = rows[entry.field] + pull
        return tuple(rows)

    def residual(self, slaved: tuple[EpsSeries, ...] | None = None) -> EpsSeries:
        """The rows weighted with the left null vector; the lattice is solved where it vanishes."""
        total = EpsSeries(self.field, self.limit, {})
        rows = self.residuals(self.slaved() if slaved is None else slaved)
        for weight, row in zip(self.together[1], rows, strict=True):
            total = total + weight * row if weight else total
        return total

    @property
    def _one(self) -> DifferentialPolynomial:
        return DifferentialPolynomial.monomial(self.field, ())

    @property
    def _wave(self) -> DifferentialPolynomial:
        return DifferentialPolynomial.monomial(self.field, ((0,) * len(self.scaling.axes),))

    def _uniform_forces(self) -> Matrix:
        """The linear forces about the mean at wavenumber zero: row = field that feels them."""
        mean = sum(
            (powers_of_eps(b).get(0, 0) for p, b in self.scaling.background if p == 0), S.Zero
        )
        count = len(self.lattice.fields)
        total = [[self.field.zero] * count for _ in range(count)]
        for bond in self.lattice.bonds:
            about = sum(entry.weight for entry in bond.stretch) * mean
            slope = self.field.from_expr(powers_of_eps(bond.stiffness(about)).get(0, S.Zero))
            for end in bond.action:
                for part in bond.stretch:
                    total[end.field][part.field] += end.weight * part.weight * slope
        return total

    def _stretch(self, bond: Bond, fields: Sequence[EpsSeries]) -> EpsSeries:
        total = EpsSeries(self.field, self.limit, {})
        for entry in bond.stretch:
            moved = fields[entry.field].exponential(self.shift(entry.shift))
            total = total + self.field(entry.weight) * moved
        return total

    def _force(self, bond: Bond, stretch: EpsSeries) -> EpsSeries:
        total = EpsSeries(self.field, self.limit, {})
        for coefficient in bond.coefficients():
            total = total * stretch + self._number(coefficient)
        return total

    def _number(self, value: Expr) -> EpsSeries:
        """A constant, which may be a polynomial in eps, as a series."""
        parts = powers_of_eps(value).items()
        return EpsSeries.collect(
            self.field,
            self.limit,
            ((p, self.field.from_expr(part) * self._one) for p, part in parts),
        )


def expand(lattice: Lattice, scaling: Scaling, limit: int) -> Expansion:
    """The expansion of a lattice up to ``eps^limit``, forces that are no polynomials expanded.

    Raises ValueError for a scaling that does not fit the lattice.
    """
    instance("lattice", lattice, Lattice, "LATTICES['fput_strain'] is one")
    instance("scaling", scaling, Scaling, "Scaling() is the paper's")
    if len(lattice.fields) > 1 and scaling.background:
        raise ValueError(
            f"background must be left out with several fields, got {len(lattice.fields)} fields "
            "(put the static stretch of each bond into its force)"
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
    if not lattice.is_polynomial:
        lattice = _polynomial(lattice, scaling, limit)
    return Expansion(lattice, scaling, limit, coefficient_field(lattice, scaling))


def _polynomial(lattice: Lattice, scaling: Scaling, limit: int) -> Lattice:
    """The lattice with its forces expanded as far as ``eps^limit`` needs them."""
    smallest = min(scaling.amplitude, *(power for power, _ in scaling.background), limit)
    if all(sum(entry.weight for entry in bond.stretch) == 0 for bond in lattice.bonds):
        smallest = scaling.amplitude + scaling.space[0].exponent
    if smallest < 1:
        raise ValueError(
            f"force must be a polynomial where the stretch is of order one, got amplitude "
            f"{scaling.amplitude} (take a larger amplitude exponent)"
        )
    return lattice.expanded(max(limit // smallest, 1))

"""Chains whose masses or springs differ from cell to cell, with bounds on their wave speeds.

A cell's mass is ``m (1 + d)``, or the part ``c G`` of a bond's force is ``c (1 + d) G``. Here d is
the cell's deviation; its size is at most ``bound``, which must be less than 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.kernels.streams import merged_weights
from longwave.lattice.numeric_lattice import Entry, NumericLattice
from longwave.lattice.variation import MassKind, Variation
from longwave.support.real_arrays import Array, Complex, real_array


def mass_kind(lattice: NumericLattice) -> MassKind:
    """Return whether fields are "displacements" or "strains"; raise ValueError for neither."""
    kind = _kind_of_fields(lattice)
    if kind is None:
        raise ValueError(
            f"lattice with varied masses must be one of displacements or of strains, got "
            f"{lattice.name}, whose bonds do not act on the fields that stretch them (declare it "
            "in its displacements)"
        )
    return kind


def _kind_of_fields(lattice: NumericLattice) -> MassKind | None:
    """Return whether fields are "displacements" or "strains"; None if they are neither."""
    if lattice.conserves_energy:
        return "displacements"
    if len(lattice.fields) == lattice.dimension == 1 and all(
        merged_weights(bond.action) == merged_weights(_action_on_strains(bond.stretch))
        for bond in lattice.bonds
    ):
        return "strains"
    return None


def _action_on_masses(stretch: Sequence[Entry]) -> list[Entry]:
    """Return the stencil by which a bond acts on the masses, given its ``stretch`` in strains."""
    return [
        Entry((offset - entry.shift[0],), sign * entry.weight, 0)
        for entry in stretch
        for offset, sign in ((0, 1.0), (-1, -1.0))
    ]


def _action_on_strains(stretch: Sequence[Entry]) -> list[Entry]:
    """Return the stencil by which a bond with this ``stretch`` acts on strains u_{n+1} - u_n."""
    return [
        Entry((entry.shift[0] + offset,), sign * entry.weight, 0)
        for entry in _action_on_masses(stretch)
        for offset, sign in ((1, 1.0), (0, -1.0))
    ]


@dataclass(frozen=True, eq=False)
class DisorderedLattice(NumericLattice):
    """A chain whose masses and forces have relative ``deviations`` from cell to cell.

    ``deviations``, (rows, cells), has rows for masses, then for varied forces. Frequencies and
    speeds of waves are upper bounds: those of an ordered chain with the lightest masses and, from
    `rest_slopes`, `largest_slope` and `steepest`, the stiffest springs that ``variation`` allows.
    """

    variation: Variation
    deviations: Array

    def __eq__(self, other: object) -> bool:
        """Return whether ``other`` has the same type and equal attributes."""
        pairs = ((getattr(self, item.name), getattr(other, item.name)) for item in fields(self))
        return type(other) is type(self) and all(
            np.array_equal(one, two) if isinstance(one, np.ndarray) else one == two
            for one, two in pairs
        )

    __hash__ = NumericLattice.__hash__

    @property
    def ordered(self) -> NumericLattice:
        """The same chain without deviations."""
        return NumericLattice(*(getattr(self, item.name) for item in fields(NumericLattice)))

    @property
    def cellwise(self) -> tuple[NumericLattice, Variation, Array]:
        """The ordered chain, its variation, and the relative deviations of all cells (`shares`)."""
        return self.ordered, self.variation, self.shares

    @property
    def cell_count(self) -> int | None:
        """Number of cells of the ring."""
        return int(self.deviations.shape[1])

    @property
    def shares(self) -> Array:
        """Relative deviations of inverse masses, then of varied forces, (rows, cells)."""
        masses = self.variation.mass_rows(len(self.fields))
        shares = np.array(self.deviations)
        shares[:masses] = -shares[:masses] / (1.0 + shares[:masses])
        return shares

    def rest_slopes(self, bound_sign: float = 1.0) -> list[float]:
        """Return upper bounds of bond slopes at mean stretch; lower ones for ``bound_sign`` -1."""
        slopes, change = super().rest_slopes(), bound_sign * self.variation.bound
        for index, part in enumerate(self.variation.forces):
            if part is not None:
                slopes[index] += change * abs(float(part.slope(np.array(self.bonds[index].offset))))
        return slopes

    def largest_slope(self, index: int, stretches: Array) -> float:
        """Return an upper bound, over all cells, of abs(slope) of one bond's force at stretches."""
        return super().largest_slope(index, stretches) + self._added_slope(index, stretches)

    def steepest(self, index: int, stretches: Array) -> float:
        """Return an upper bound, over all cells, of the slope of one bond's force at stretches."""
        return super().steepest(index, stretches) + self._added_slope(index, stretches)

    def _added_slope(self, index: int, stretches: Array) -> float:
        """Return by how much the variation may increase abs(slope) of one bond's force."""
        part = self.variation.forces[index] if self.variation.forces else None
        if part is None:
            return 0.0
        with np.errstate(all="ignore"):
            return self.variation.bound * float(np.max(np.abs(part.slope(stretches))))

    def _varied_parts(self) -> list[tuple[ForceProgram, Array] | None]:
        """Return each bond's varied force with its deviations by cell; None for other bonds."""
        rows = iter(self.deviations[self.variation.mass_rows(len(self.fields)) :])
        parts = self.variation.forces or (None,) * len(self.bonds)
        return [None if part is None else (part, next(rows)) for part in parts]

    def slopes(self, stretches: Sequence[Array]) -> list[Array]:
        """Return the slope of each bond's force at its stretches, cell by cell."""
        with np.errstate(all="ignore"):
            return self._varied(super().slopes(stretches), stretches, ForceProgram.slope)

    def forces(self, f: Array) -> list[Array]:
        """Return the force of each bond in each cell."""
        stretches = self.stretches(f)
        forces = [bond.force(x) for bond, x in zip(self.bonds, stretches, strict=True)]
        return self._varied(forces, stretches, ForceProgram.__call__)

    def _varied(
        self,
        values: list[Array],
        stretches: Sequence[Array],
        evaluate: Callable[[ForceProgram, Array], Array],
    ) -> list[Array]:
        """Add to each bond's ``values``, in place, ``deviation * evaluate(varied force)``."""
        for index, varied in enumerate(self._varied_parts()):
            if varied is not None:
                part, row = varied
                values[index] = values[index] + row * evaluate(part, stretches[index])
        return values

    def acceleration(self, f: Array) -> Array:
        """Compute f'' of every field and cell with NumPy; compiled kernels must agree with it."""
        total = np.zeros_like(f)
        strains = self.variation.masses == "strains"
        for bond, force in zip(self.bonds, self.forces(f), strict=True):
            for entry in _action_on_masses(bond.stretch) if strains else bond.action:
                total[entry.field] += entry.weight * np.roll(force, -entry.shift[0])
        if self.variation.masses:
            total *= 1.0 + self.shares[: len(self.fields)]
        if strains:
            total = np.roll(total, -1, axis=1) - total
        return np.asarray(total / np.array(self.masses)[:, None], dtype=np.float64)

    @property
    def lightest(self) -> float:
        """Lower bound of the cells' masses, in units of the masses of the ordered chain."""
        return 1.0 - self.variation.bound if self.variation.masses else 1.0

    def dynamical_matrix(self, wavenumbers: ArrayLike, slopes: Sequence[float]) -> Complex:
        """Return the dynamical matrix of an ordered chain with the lightest masses."""
        return self.ordered.dynamical_matrix(wavenumbers, slopes) / self.lightest

    def energy(self, f: Array, v: Array) -> float:
        """Return the total energy, the sum of `energies`."""
        return float(np.sum(self.energies(f, v)))

    def energies(
        self, f: Array, v: Array, velocity: float = 0.0, rest: Sequence[float] = ()
    ) -> Array:
        """Return the energy of each cell; a bond stores none at its stretch in ``rest``, or at 0.

        If the fields are strains, ``velocity`` is the velocity of the first cell's mass, which
        strains do not determine.
        """
        velocities = velocity + (np.cumsum(v, axis=1) - v) if self.holds_strains else v
        total = np.sum(0.5 * self.cell_masses * velocities * velocities, axis=0)
        rest_stretches = rest or (0.0,) * len(self.bonds)
        for bond, stretch, varied, rest_stretch in zip(
            self.bonds, self.stretches(f), self._varied_parts(), rest_stretches, strict=True
        ):
            total = total + _energy_above_rest(bond.force, stretch, rest_stretch)
            if varied is not None:
                part, row = varied
                total = total + row * _energy_above_rest(part, stretch, rest_stretch)
        return np.asarray(total)

    @property
    def has_energy(self) -> bool:
        """Whether the lattice has masses; without them `energies` are meaningless."""
        return _kind_of_fields(self) is not None

    @property
    def holds_strains(self) -> bool:
        """Whether the fields are strains between masses."""
        return not self.conserves_energy

    @property
    def cell_masses(self) -> Array:
        """Mass of each field in each cell, (fields, cells)."""
        masses = np.array(self.masses)[:, None] * np.ones((1, self.deviations.shape[1]))
        if not self.variation.masses:
            return masses
        return np.asarray(masses * (1.0 + self.deviations[: len(self.fields)]))


def _energy_above_rest(force: ForceProgram, stretch: Array, rest: float) -> Array:
    """Return potential(stretch) - potential(rest) - force(rest) * (stretch - rest)."""
    rest_energy, rest_force = energy_and_force_at(force, rest)
    return np.asarray(force.potential(stretch) - (rest_energy + rest_force * (stretch - rest)))


@lru_cache(maxsize=64)
def energy_and_force_at(force: ForceProgram, rest: float) -> tuple[float, float]:
    """Return the energy that a bond stores at the stretch ``rest``, and its force there."""
    still = np.array(rest)
    return float(force.potential(still)), float(force(still))


def disordered(
    lattice: NumericLattice, variation: Variation, deviations: ArrayLike
) -> DisorderedLattice:
    """Return a chain whose masses and forces vary by ``deviations``, (rows, cells).

    Raises ValueError for a lattice of several axes, for varied forces that do not vanish at rest,
    and for a spread so large that the softest springs make the chain unstable.
    """
    if lattice.dimension != 1:
        raise ValueError(
            f"disorder must be in a chain, got {lattice.name} in {lattice.dimension} dimensions "
            "(take a lattice with one axis)"
        )
    ordered_fields = {item.name: getattr(lattice, item.name) for item in fields(NumericLattice)}
    rows = real_array("every deviation", deviations)
    chain = DisorderedLattice(**ordered_fields, variation=variation, deviations=rows)
    if any(part is not None and float(part(np.array(0.0))) != 0.0 for part in variation.forces):
        raise ValueError(
            f"disordered springs must exert no force at zero stretch, got {lattice.name}, whose "
            "force there would differ from bond to bond (let the masses differ)"
        )
    if not chain.is_stable(chain.rest_slopes(-1.0)):
        raise ValueError(
            f"spread must leave {lattice.name} linearly stable, got {variation.bound:g}, with "
            "which some waves grow at rest (take a smaller one)"
        )
    return chain

"""A chain whose masses or springs differ from cell to cell, with what bounds its waves.

A cell's mass is ``m (1 + d)``, or the part ``c G`` of a bond's force is ``c (1 + d) G``, where d is
the cell's deviation: at most ``bound`` in size, which must be less than 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import Complex, Entry, NumericLattice
from longwave.lattice.variation import MassKind, Variation
from longwave.support.real_arrays import real_array

Array = NDArray[np.float64]


def mass_kind(lattice: NumericLattice) -> MassKind:
    """Whether the lattice's fields are displacements of masses or strains between them.

    Raises ValueError for a lattice of neither kind: its masses have no place in a cell.
    """
    found = _moving(lattice)
    if found is None:
        raise ValueError(
            f"masses must be those of displacements or of the strains between them, got "
            f"{lattice.name}, whose bonds do not act on what they are stretched by (declare it in "
            "its displacements)"
        )
    return found


def _moving(lattice: NumericLattice) -> MassKind | None:
    """What moves in the lattice, None if neither does."""
    if lattice.conserves_energy:
        return "displacements"
    if len(lattice.fields) == lattice.dimension == 1 and all(
        _terms(bond.action) == _terms(_moves(bond.stretch)) for bond in lattice.bonds
    ):
        return "strains"
    return None


def _terms(entries: Sequence[Entry]) -> dict[int, float]:
    found: dict[int, float] = {}
    for entry in entries:
        found[entry.shift[0]] = found.get(entry.shift[0], 0.0) + entry.weight
    return {shift: weight for shift, weight in found.items() if weight}


def _pulls(stretch: Sequence[Entry]) -> list[Entry]:
    """How a bond with this stretch in strains pulls at the masses between which they lie."""
    return [
        Entry((step - entry.shift[0],), sign * entry.weight, 0)
        for entry in stretch
        for step, sign in ((0, 1.0), (-1, -1.0))
    ]


def _moves(stretch: Sequence[Entry]) -> list[Entry]:
    """How it acts on the strains, which are differences of neighbouring masses."""
    return [
        Entry((entry.shift[0] + step,), sign * entry.weight, 0)
        for entry in _pulls(stretch)
        for step, sign in ((1, 1.0), (0, -1.0))
    ]


@dataclass(frozen=True, eq=False)
class DisorderedLattice(NumericLattice):
    """A chain of cells with the deviations ``deviations``, (rows, cells), of what varies.

    What is asked of waves, their frequencies and speeds, is answered for the ordered chain with the
    lightest masses and, where slopes are told, the stiffest springs that ``variation`` allows: no
    wave of the disordered one is faster.
    """

    variation: Variation
    deviations: Array

    def __eq__(self, other: object) -> bool:
        """Whether all that they are made of is the same."""
        return type(other) is type(self) and all(
            np.array_equal(one, two) if isinstance(one, np.ndarray) else one == two
            for one, two in (
                (getattr(self, item.name), getattr(other, item.name)) for item in fields(self)
            )
        )

    __hash__ = NumericLattice.__hash__

    @property
    def ordered(self) -> NumericLattice:
        """The chain without deviations."""
        return NumericLattice(*(getattr(self, held.name) for held in fields(NumericLattice)))

    @property
    def cellwise(self) -> tuple[NumericLattice, Variation, Array]:
        """The ordered chain, what differs in it, and the shares by which it does."""
        return self.ordered, self.variation, self.shares

    @property
    def cell_count(self) -> int | None:
        """The cells of its ring."""
        return int(self.deviations.shape[1])

    @property
    def shares(self) -> Array:
        """The deviations; of masses, by how much their inverse is larger."""
        masses = self.variation.mass_rows(len(self.fields))
        found = np.array(self.deviations)
        found[:masses] = -found[:masses] / (1.0 + found[:masses])
        return found

    @property
    def stays_at_rest(self) -> bool:
        """Whether no varied force pulls where no bond is stretched."""
        parts = (part for part in self.variation.forces if part is not None)
        return all(float(part(np.array(0.0))) == 0.0 for part in parts)

    @property
    def softest(self) -> list[float]:
        """The least slopes of the bonds' forces at the mean stretch."""
        pairs = zip(super().rest_slopes(), self._part_slopes(), strict=True)
        return [slope - self.variation.bound * abs(part) for slope, part in pairs]

    def _part_slopes(self) -> list[float]:
        parts = self.variation.forces or (None,) * len(self.bonds)
        return [
            0.0 if part is None else float(part.slope(np.array(bond.offset)))
            for bond, part in zip(self.bonds, parts, strict=True)
        ]

    def rest_slopes(self) -> list[float]:
        """The largest slope of each bond's force at the mean stretch."""
        pairs = zip(super().rest_slopes(), self._part_slopes(), strict=True)
        return [slope + self.variation.bound * abs(part) for slope, part in pairs]

    def largest_slope(self, place: int, stretches: Array) -> float:
        """The largest size of the slope of a bond's force at these stretches, in any cell."""
        return super().largest_slope(place, stretches) + self._added_slope(place, stretches)

    def steepest(self, place: int, stretches: Array) -> float:
        """The largest slope of a bond's force at these stretches, in any cell."""
        return super().steepest(place, stretches) + self._added_slope(place, stretches)

    def _added_slope(self, place: int, stretches: Array) -> float:
        part = self.variation.forces[place] if self.variation.forces else None
        if part is None:
            return 0.0
        with np.errstate(all="ignore"):
            return self.variation.bound * float(np.max(np.abs(part.slope(stretches))))

    def _varied(self) -> list[tuple[ForceProgram, Array] | None]:
        """The varied part of each bond's force and its deviations in all cells."""
        rows = iter(self.deviations[self.variation.mass_rows(len(self.fields)) :])
        parts = self.variation.forces or (None,) * len(self.bonds)
        return [None if part is None else (part, next(rows)) for part in parts]

    def slopes(self, stretches: Sequence[Array]) -> list[Array]:
        """The slope of each bond's force at its stretches, cell by cell."""
        found = super().slopes(stretches)
        with np.errstate(all="ignore"):
            for place, varied in enumerate(self._varied()):
                if varied is not None:
                    part, row = varied
                    found[place] = found[place] + row * part.slope(stretches[place])
        return found

    def forces(self, f: Array) -> list[Array]:
        """The force of each bond in each cell."""
        stretches = self.stretches(f)
        found = [bond.force(x) for bond, x in zip(self.bonds, stretches, strict=True)]
        for place, varied in enumerate(self._varied()):
            if varied is not None:
                part, row = varied
                found[place] = found[place] + row * part(stretches[place])
        return found

    def acceleration(self, f: Array) -> Array:
        """f'' of every field and cell, by NumPy: what the kernel must give."""
        total = np.zeros_like(f)
        strains = self.variation.masses == "strains"
        for bond, force in zip(self.bonds, self.forces(f), strict=True):
            for entry in _pulls(bond.stretch) if strains else bond.action:
                total[entry.field] += entry.weight * np.roll(force, -entry.shift[0])
        if self.variation.masses:
            total *= 1.0 + self.shares[: len(self.fields)]
        if strains:
            total = np.roll(total, -1, axis=1) - total
        return np.asarray(total / np.array(self.masses)[:, None], dtype=np.float64)

    @property
    def lightest(self) -> float:
        """The least mass, in units of those of the ordered chain."""
        return 1.0 - self.variation.bound if self.variation.masses else 1.0

    def dynamical_matrix(self, wavenumbers: ArrayLike, slopes: Sequence[float]) -> Complex:
        """As of an ordered chain with the lightest masses."""
        return self.ordered.dynamical_matrix(wavenumbers, slopes) / self.lightest

    def energy(self, f: Array, v: Array) -> float:
        """The sum of `energies`."""
        return float(np.sum(self.energies(f, v)))

    def energies(
        self, f: Array, v: Array, velocity: float = 0.0, rest: Sequence[float] = ()
    ) -> Array:
        """The energy of each cell, 0 where bonds are stretched as at ``rest``: not, unless told.

        Of strains it takes the ``velocity`` of the first cell's mass, which they do not tell.
        """
        moving = velocity + (np.cumsum(v, axis=1) - v) if self.holds_strains else v
        total = np.sum(0.5 * self.cell_masses * moving * moving, axis=0)
        resting = rest or (0.0,) * len(self.bonds)
        for bond, stretch, varied, still in zip(
            self.bonds, self.stretches(f), self._varied(), resting, strict=True
        ):
            total = total + _stored(bond.force, stretch, still)
            if varied is not None:
                part, row = varied
                total = total + row * _stored(part, stretch, still)
        return np.asarray(total)

    @property
    def has_energy(self) -> bool:
        """Whether there are masses: of a lattice without, `energies` are none."""
        return _moving(self) is not None

    @property
    def holds_strains(self) -> bool:
        """Whether the fields are strains between masses."""
        return not self.conserves_energy

    @property
    def cell_masses(self) -> Array:
        """The mass of each field in each cell, (fields, cells)."""
        masses = np.array(self.masses)[:, None] * np.ones((1, self.deviations.shape[1]))
        if not self.variation.masses:
            return masses
        return np.asarray(masses * (1.0 + self.deviations[: len(self.fields)]))


def _stored(force: ForceProgram, stretch: Array, rest: float) -> Array:
    """The energy of a stretch above that at rest, less what the force there does on the way."""
    stored, resting = held_at(force, rest)
    return np.asarray(force.potential(stretch) - (stored + resting * (stretch - rest)))


@lru_cache(maxsize=64)
def held_at(force: ForceProgram, rest: float) -> tuple[float, float]:
    """What a bond stores at a stretch, and its force there."""
    still = np.array(rest)
    return float(force.potential(still)), float(force(still))


def disordered(
    lattice: NumericLattice, variation: Variation, deviations: ArrayLike
) -> DisorderedLattice:
    """The chain with these deviations, (rows, cells) of its ring.

    Raises ValueError in one line for a lattice of more axes, and where the softest springs or the
    forces at rest would let the chain fall apart.
    """
    if lattice.dimension != 1:
        raise ValueError(
            f"disorder must be in a chain, got {lattice.name} in {lattice.dimension} dimensions "
            "(take a lattice of one axis)"
        )
    held = {item.name: getattr(lattice, item.name) for item in fields(NumericLattice)}
    rows = real_array("every deviation", deviations)
    made = DisorderedLattice(**held, variation=variation, deviations=rows)
    if not made.stays_at_rest:
        raise ValueError(
            f"disorder must leave {lattice.name} at rest where nothing is stretched, got a force "
            "there that differs from bond to bond (let the masses differ)"
        )
    if not made.is_stable(made.softest):
        raise ValueError(
            f"spread must leave waves of {lattice.name} stable, got {variation.bound:g}, with "
            "which some grow at rest (take a smaller one)"
        )
    return made

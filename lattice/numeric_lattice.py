"""Any lattice with numbers: a declared lattice whose constants have values, ready for a kernel.

A state is two arrays of shape (fields, *cells), positions and velocities, on a ring along each
axis. Of a displacement that grows with the cell, ``u_n = E n + periodic part``, the periodic part
is held, and each bond's ``offset`` is what the mean strain E adds to its stretch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.force_program import ForceProgram, force_program
from longwave.support.known_names import one_of

if TYPE_CHECKING:
    from longwave.derive.algebra.exact_numbers import Number
    from longwave.derive.lattice import Bond, Lattice, Stencil
    from longwave.lattice.schemes import Scheme
    from longwave.lattice.state import State
    from longwave.lattice.variation import Variation

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Range = tuple[float, float]


@dataclass(frozen=True)
class Entry:
    """``weight`` times what stands in ``field`` of the cell at offset ``shift``."""

    shift: tuple[int, ...]
    weight: float
    field: int


def place_text(field: str, shift: tuple[int, ...]) -> str:
    """A field in the cell at an offset, as lattice files write it.

    >>> place_text("u", (1,)), place_text("u", (0, -1))
    ('u[n+1]', 'u[n,m-1]')
    """
    axes = zip("nml", shift, strict=False)
    return f"{field}[{','.join(axis + (f'{step:+d}' if step else '') for axis, step in axes)}]"


def stretch_text(entries: tuple[Entry, ...], fields: tuple[str, ...]) -> str:
    """A sum of fields in words, its positive terms first.

    >>> stretch_text((Entry((0,), -1.0, 0), Entry((1,), 2.0, 0)), ("u",))
    '2 u[n+1] - u[n]'
    """
    text = ""
    for entry in sorted(entries, key=lambda one: one.weight < 0.0):
        sign = (" - " if text else "-") if entry.weight < 0.0 else (" + " if text else "")
        size = "" if abs(entry.weight) == 1.0 else f"{abs(entry.weight):g} "
        text += f"{sign}{size}{place_text(fields[entry.field], entry.shift)}"
    return text


@dataclass(frozen=True)
class NumericBond:
    """A bond of cell n: stretched by ``sum weight f_{n+shift} + offset``, acting as `Bond` says."""

    stretch: tuple[Entry, ...]
    action: tuple[Entry, ...]
    force: ForceProgram
    offset: float = 0.0

    def stretched(self, f: Array) -> Array:
        """The stretch in each cell, where these are the fields."""
        parts = (entry.weight * _shifted(f[entry.field], entry.shift) for entry in self.stretch)
        total = next(parts)
        if self.offset:
            total += self.offset
        for part in parts:
            total += part
        return total

    def grown(self, mean_strain: Sequence[float], shares: Sequence[float]) -> NumericBond:
        """Return the bond where displacements grow by ``mean_strain`` (`NumericLattice.grown`)."""
        growth = [e.weight * (shares[e.field] if shares else 1.0) for e in self.stretch]
        if abs(math.fsum(growth)) > ROUNDED * max(map(abs, growth)):
            raise ValueError(
                "mean_strain must be 0 where a bond feels a field itself, got "
                f"{tuple(mean_strain)} (such a lattice has no uniform strain, or it is the "
                "field's own mean)"
            )
        moved = [
            sum(a * b for a, b in zip(mean_strain, e.shift, strict=True)) * share
            for e, share in zip(self.stretch, growth, strict=True)
        ]
        return replace(self, offset=math.fsum(moved))

    def stretch_range(self, f: Array, ranges: Sequence[Range]) -> Range:
        """The least and the largest stretch, where these are the fields and their ranges."""
        if len(self.stretch) > 1:
            return value_range(self.stretched(f))
        [entry] = self.stretch
        least, most = sorted(entry.weight * end + self.offset for end in ranges[entry.field])
        return least, most


@dataclass(frozen=True)
class DriveSteps:
    """The longest ``step`` at all times, ``stops`` at which steps end, whether a drive has corners
    beside them, and what integrals of drives between the stops are off by."""

    step: float
    stops: Array
    turns: bool
    missed: float = 0.0


@dataclass(frozen=True)
class NumericLattice:
    """Equations ``mass f'' = sum of bond forces`` with numbers; hashable, so kernels can be kept.

    >>> from longwave.derive import LATTICES
    >>> chain = numeric_lattice(LATTICES["fput"], {"K2": 1, "K3": 0, "K4": 1})
    >>> chain.acceleration(np.array([[0.0, 1.0, 0.0, 0.0]]))
    array([[ 2., -4.,  2.,  0.]])
    """

    name: str
    fields: tuple[str, ...]
    masses: tuple[float, ...]
    bonds: tuple[NumericBond, ...]

    @property
    def dimension(self) -> int:
        """The number of axes."""
        return len(self.bonds[0].stretch[0].shift)

    def grown(self, mean_strain: Sequence[float], shares: Sequence[float] = ()) -> NumericLattice:
        """Return the lattice at rest with its displacements growing by ``mean_strain``.

        Arguments and errors are those of `numeric_lattice`.
        """
        if not any(mean_strain):
            return self
        return replace(self, bonds=tuple(bond.grown(mean_strain, shares) for bond in self.bonds))

    @property
    def reach(self) -> int:
        """The number of cells, along any axis, over which a force acts at once."""
        return max(
            abs(there + here)
            for bond in self.bonds
            for end in bond.action
            for part in bond.stretch
            for there, here in zip(end.shift, part.shift, strict=True)
        )

    @property
    def cellwise(self) -> tuple[NumericLattice, Variation | None, Array]:
        """What is the same in all cells, what is not, and how much of it a cell has: nothing."""
        return self, None, np.zeros((0, 0))

    @property
    def cell_count(self) -> int | None:
        """The cells of its states; None if they may be so many as one likes."""
        return None

    @property
    def is_driven(self) -> bool:
        """Whether stages take weights of their own times (`DrivenChain.stage_weights`): no."""
        return False

    def drive_within(self, begin: float, end: float) -> tuple[float, bool]:
        """The least time in which what drives it changes by all that it does; inf without any.

        And whether that has corners.
        """
        return math.inf, False

    def driven_within(self, begin: float, end: float) -> float:
        """The least time of `drive_within`."""
        return self.drive_within(begin, end)[0]

    def drive_steps(
        self, begin: float, end: float, step: float, scheme: Scheme, tolerance: float
    ) -> DriveSteps:
        """Steps, none longer than ``step``, that follow what drives it: nothing does."""
        return DriveSteps(step, np.zeros(0), False)

    def spread_within(self, duration: float) -> int:
        """Cells by which signals run ahead of their speed for losses: 0 without any."""
        return 0

    def held(self, state: State) -> State:
        """The state with the cells by which the lattice holds its ends: it has none."""
        return state

    @property
    def conserves_energy(self) -> bool:
        """Whether every bond acts on what it is stretched by, so that `energy` is conserved."""
        return all(
            sorted((tuple(-s for s in e.shift), -e.weight, e.field) for e in bond.stretch)
            == sorted((e.shift, e.weight, e.field) for e in bond.action)
            for bond in self.bonds
        )

    @property
    def is_linear(self) -> bool:
        """Whether every force is proportional to its stretch."""
        return all(bond.force.is_linear for bond in self.bonds)

    @cached_property
    def gets_stiffer_by_bonds(self) -> bool:
        """Whether each bond, its slope positive, only adds to the squares of the frequencies.

        Then no wave grows where all slopes are positive.
        """
        if self.cellwise[1] is not None:
            return False
        waves = zone_wavenumbers(self.dimension, WAVENUMBERS[self.dimension])
        root = np.sqrt(self.masses)
        for unit in np.eye(len(self.bonds)):
            found = self.dynamical_matrix(waves, list(unit)) * (root[:, None] / root)
            size = ROUNDED * np.abs(found).max()
            if np.abs(found - found.conj().swapaxes(-1, -2)).max() > size:
                return False
            if np.linalg.eigvalsh(found).min() < -size:
                return False
        return True

    def stretches(self, f: Array) -> list[Array]:
        """The stretch of each bond in each cell."""
        return [bond.stretched(f) for bond in self.bonds]

    def stretch_ranges(self, f: Array, ranges: Sequence[Range]) -> list[Range]:
        """The least and the largest stretch of each bond, where these are the fields' ranges."""
        return [bond.stretch_range(f, ranges) for bond in self.bonds]

    def acceleration(self, f: Array) -> Array:
        """f'' of every field and cell, by NumPy: what every kernel must give."""
        return self.pulled([bond.force(bond.stretched(f)) for bond in self.bonds])

    def pulled(self, forces: Sequence[Array]) -> Array:
        """What forces in the bonds of all cells do to f''."""
        total = np.zeros((len(self.fields), *forces[0].shape))
        for bond, force in zip(self.bonds, forces, strict=True):
            for entry in bond.action:
                total[entry.field] += entry.weight * _shifted(force, entry.shift)
        masses = np.array(self.masses).reshape(-1, *(1,) * (total.ndim - 1))
        return np.asarray(total / masses, dtype=np.float64)

    def dynamical_matrix(self, wavenumbers: ArrayLike, slopes: Sequence[float]) -> Complex:
        """D with ``f'' = -D f`` for waves exp(i k n), forces linearised with a slope for each bond.

        ``wavenumbers`` have shape (..., axes); the matrices have shape (..., fields, fields).
        """
        k = np.asarray(wavenumbers, dtype=np.float64)
        count = len(self.fields)
        found = np.zeros((*k.shape[:-1], count, count), dtype=np.complex128)
        for bond, slope in zip(self.bonds, slopes, strict=True):
            for end in bond.action:
                for part in bond.stretch:
                    turn = k @ np.add(end.shift, part.shift).astype(np.float64)
                    weight = end.weight * part.weight * slope / self.masses[end.field]
                    found[..., end.field, part.field] -= weight * np.exp(1j * turn)
        return found

    def squared_frequencies(self, wavenumbers: ArrayLike, slopes: Sequence[float]) -> Array:
        """The eigenvalues of the dynamical matrix, ascending along the last axis."""
        values = np.linalg.eigvals(self.dynamical_matrix(wavenumbers, slopes))
        return np.sort(values.real, axis=-1)

    def slopes(self, stretches: Sequence[Array]) -> list[Array]:
        """The slope of each bond's force at its stretches; not finite where there is no force."""
        pairs = zip(self.bonds, stretches, strict=True)
        with np.errstate(all="ignore"):
            return [np.asarray(bond.force.slope(stretch)) for bond, stretch in pairs]

    def largest_slope(self, place: int, stretches: Array) -> float:
        """The largest size of the slope of a bond's force at these stretches; may be nan."""
        with np.errstate(all="ignore"):
            return float(np.max(np.abs(self.bonds[place].force.slope(stretches))))

    def steepest(self, place: int, stretches: Array) -> float:
        """The largest slope of a bond's force at these stretches; may be nan."""
        with np.errstate(all="ignore"):
            return float(np.max(self.bonds[place].force.slope(stretches)))

    def rest_slopes(self) -> list[float]:
        """The slope of each bond's force at the mean stretch."""
        return [float(bond.force.slope(np.array(bond.offset))) for bond in self.bonds]

    def highest_frequency(self, slopes: Sequence[float]) -> float:
        """The largest frequency of any wave, forces linearised with these slopes."""
        return math.sqrt(max(float(np.max(self._all_squares(slopes))), 0.0))

    def is_stable(self, slopes: Sequence[float]) -> bool:
        """Whether no wave grows, forces linearised with these slopes."""
        squares = self._all_squares(slopes)
        return bool(np.min(squares) >= -ROUNDED * max(float(np.max(squares)), 1e-300))

    def _all_squares(self, slopes: Sequence[float]) -> Array:
        waves = zone_wavenumbers(self.dimension, WAVENUMBERS[self.dimension])
        return self.squared_frequencies(waves, slopes)

    def energy(self, f: Array, v: Array) -> float:
        """Kinetic and potential energy of a ring of displacements.

        Of a lattice of strains, whose equations are no Newton's of a mass in each cell, it is no
        energy.
        """
        masses = np.array(self.masses).reshape(-1, *(1,) * (f.ndim - 1))
        total = 0.5 * float(np.sum(masses * v * v))
        for bond, stretch in zip(self.bonds, self.stretches(f), strict=True):
            total += float(np.sum(bond.force.potential(stretch)))
        return total


WAVENUMBERS = {1: 257, 2: 33, 3: 9}
"""Of a grid over the zone: the largest frequency of a chain is found to 1e-4 of itself."""

ROUNDED = 1e-12
"""A square of a frequency so far below 0, in units of the largest, is rounding."""


def zone_wavenumbers(dimension: int, count: int) -> Array:
    """A grid (waves, axes) over half the zone, which holds every wave or its conjugate.

    There are ``count`` wavenumbers from 0 to pi along the first axis.
    """
    axis = np.linspace(0.0, math.pi, count)
    axes = [axis, *[np.linspace(-math.pi, math.pi, 2 * count - 1)] * (dimension - 1)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dimension)


def value_range(values: Array) -> Range:
    """The least value and the largest; nan if one of them is."""
    return float(np.minimum.reduce(values, None)), float(np.maximum.reduce(values, None))


def _shifted(values: Array, shift: tuple[int, ...]) -> Array:
    """``values`` of the cells at that offset; cells lie along the last axes."""
    if not any(shift):
        return values
    if len(shift) == 1:
        first = shift[0] % values.shape[-1]
        return np.concatenate((values[..., first:], values[..., :first]), axis=-1)
    axes = tuple(range(-len(shift), 0))
    return np.roll(values, tuple(-step for step in shift), axes)


def numeric_lattice(
    lattice: Lattice,
    constants: Mapping[str, Number],
    mean_strain: Sequence[float] = (),
    shares: Sequence[float] = (),
) -> NumericLattice:
    """The lattice with values for all its constants, its displacements growing by ``mean_strain``.

    ``mean_strain`` has one entry for each axis; a field grows by its one of the ``shares`` of that,
    by all of it unless they are given. Raises ValueError for constants that are missing,
    unknown or not what their symbols are declared to be, and for a mean strain where forces tie
    what grows to its site.

    >>> from longwave.derive import LATTICES
    >>> chain = numeric_lattice(LATTICES["toda"], {"a": 1, "b": 1})
    >>> chain.highest_frequency(chain.rest_slopes())
    2.0
    """
    from longwave.derive.algebra.exact_numbers import exact

    if lattice.has_losses:
        raise ValueError(
            f"losses must not be in a lattice that is run, got those of {lattice.name} (give them "
            "to driven_chain, or in [losses] of a scene)"
        )
    names = {str(symbol): symbol for symbol in lattice.constants}
    for name in (*constants, *names):
        if name not in names or name not in constants:
            word = "must be given, got none" if name in names else "is not known"
            raise ValueError(f"constant {name} of {lattice.name} {word} ({one_of(name, names)})")
    values = {names[name]: exact(name, value) for name, value in constants.items()}
    touched = lattice.contact_constants if 0 in values.values() else set()
    for symbol, value in values.items():
        if symbol.is_positive and not (value > 0 or (value == 0 and symbol in touched)):
            raise ValueError(f"{symbol} must satisfy {symbol} > 0, got {value} ({lattice.name})")
    found = NumericLattice(
        lattice.name,
        lattice.fields,
        tuple(float(mass.xreplace(values)) for mass in lattice.masses),
        tuple(_numeric_bond(bond, values) for bond in lattice.bonds),
    )
    return found.grown(mean_strain, shares)


def _numeric_bond(bond: Bond, values: Mapping[Any, Any]) -> NumericBond:
    stretch, action = (tuple(map(_entry, part)) for part in (bond.stretch, bond.action))
    return NumericBond(stretch, action, force_program(bond.force.xreplace(values)))


def _entry(entry: Stencil) -> Entry:
    return Entry(entry.shift, float(entry.weight), entry.field)

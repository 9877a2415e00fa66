"""Numerical lattices: declared lattices whose constants have values, ready for a kernel.

A state is two arrays of shape (fields, *cells), positions and velocities, on a ring along each
axis. For displacements that grow with the cell, ``u_n = E n + periodic part``, the arrays hold the
periodic part, and each bond's ``offset`` is the stretch that the mean strain E adds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from longwave.lattice.force_program import ForceProgram, force_program
from longwave.support.known_names import one_of
from longwave.support.real_arrays import Array, Complex

if TYPE_CHECKING:
    from longwave.derive.algebra.exact_numbers import Number
    from longwave.derive.lattice import Bond, Lattice
    from longwave.lattice.schemes import Scheme
    from longwave.lattice.state import State
    from longwave.lattice.variation import Variation

Range = tuple[float, float]


@dataclass(frozen=True)
class Entry:
    """Stencil term: ``weight`` times the value of ``field`` in the cell at offset ``shift``."""

    shift: tuple[int, ...]
    weight: float
    field: int


def place_text(field: str, shift: tuple[int, ...]) -> str:
    """Return a field in the cell at an offset as text, in the notation of lattice files.

    >>> place_text("u", (1,)), place_text("u", (0, -1))
    ('u[n+1]', 'u[n,m-1]')
    """
    axes = zip("nml", shift, strict=False)
    return f"{field}[{','.join(axis + (f'{step:+d}' if step else '') for axis, step in axes)}]"


def stretch_text(entries: tuple[Entry, ...], fields: tuple[str, ...]) -> str:
    """Return a stretch, a sum of fields, as text; its positive terms come first.

    >>> stretch_text((Entry((0,), -1.0, 0), Entry((1,), 2.0, 0)), ("u",))
    '2 u[n+1] - u[n]'
    """
    text = ""
    for entry in sorted(entries, key=lambda one: one.weight < 0.0):
        sign = (" - " if text else "-") if entry.weight < 0.0 else (" + " if text else "")
        factor = "" if abs(entry.weight) == 1.0 else f"{abs(entry.weight):g} "
        text += f"{sign}{factor}{place_text(fields[entry.field], entry.shift)}"
    return text


@dataclass(frozen=True)
class NumericBond:
    """A bond of cell n with the stretch ``sum weight f_{n+shift} + offset``; see `Bond`."""

    stretch: tuple[Entry, ...]
    action: tuple[Entry, ...]
    force: ForceProgram
    offset: float = 0.0

    def stretched(self, f: Array) -> Array:
        """Return the stretch in each cell for the fields ``f``."""
        parts = (entry.weight * _shifted(f[entry.field], entry.shift) for entry in self.stretch)
        total = next(parts)
        if self.offset:
            total += self.offset
        for part in parts:
            total += part
        return total

    def with_mean_strain(self, strain: Sequence[float], shares: Sequence[float]) -> NumericBond:
        """Return the bond with the offset of fields that grow by ``shares * strain`` per cell."""
        growth = [e.weight * (shares[e.field] if shares else 1.0) for e in self.stretch]
        if abs(math.fsum(growth)) > ROUNDED_SQUARE * max(map(abs, growth)):
            raise ValueError(
                "mean_strain must be 0 where a bond feels a field itself, got "
                f"{tuple(strain)} (such a lattice has no uniform strain, or it is the "
                "field's own mean)"
            )
        offsets = [
            sum(a * b for a, b in zip(strain, e.shift, strict=True)) * share
            for e, share in zip(self.stretch, growth, strict=True)
        ]
        return replace(self, offset=math.fsum(offsets))

    def stretch_range(self, f: Array, ranges: Sequence[Range]) -> Range:
        """Return the least and the largest stretch for the fields ``f`` and their ranges."""
        if len(self.stretch) > 1:
            return value_range(self.stretched(f))
        [entry] = self.stretch
        least, most = sorted(entry.weight * end + self.offset for end in ranges[entry.field])
        return least, most


@dataclass(frozen=True)
class DriveSteps:
    """Steps that resolve the drives: the longest ``step`` and additional ``stops``.

    ``turns`` is True if a drive has corners between stops; ``missed`` is an upper bound of the
    errors of the drives' integrals at the stops.
    """

    step: float
    stops: Array
    turns: bool
    missed: float = 0.0


@dataclass(frozen=True)
class NumericLattice:
    """Equations ``mass f'' = sum of bond forces`` with numbers; hashable, a key for kernels.

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
        """Number of axes."""
        return len(self.bonds[0].stretch[0].shift)

    def with_mean_strain(
        self, mean_strain: Sequence[float], shares: Sequence[float] = ()
    ) -> NumericLattice:
        """Return the lattice of fields that grow by ``shares * mean_strain`` per cell."""
        if not any(mean_strain):
            return self
        bonds = tuple(bond.with_mean_strain(mean_strain, shares) for bond in self.bonds)
        return replace(self, bonds=bonds)

    @property
    def reach(self) -> int:
        """Largest distance, in cells along any axis, at which cells act on each other directly."""
        return max(
            abs(there + here)
            for bond in self.bonds
            for end in bond.action
            for part in bond.stretch
            for there, here in zip(end.shift, part.shift, strict=True)
        )

    @property
    def cellwise(self) -> tuple[NumericLattice, Variation | None, Array]:
        """The ordered lattice, its variation and relative deviations by cell (none here)."""
        return self, None, np.zeros((0, 0))

    @property
    def cell_count(self) -> int | None:
        """Required number of cells of a state; None if any number will do."""
        return None

    @property
    def is_driven(self) -> bool:
        """Whether a stage's weights depend on its time (`DrivenChain.stage_weights`)."""
        return False

    def drive_within(self, begin: float, end: float) -> tuple[float, bool]:
        """Return the shortest time scale of drives (inf here), and whether they have corners."""
        return math.inf, False

    def driven_within(self, begin: float, end: float) -> float:
        """Return the shortest time scale of drives, the first result of `drive_within`."""
        return self.drive_within(begin, end)[0]

    def drive_steps(
        self, begin: float, end: float, step: float, scheme: Scheme, tolerance: float
    ) -> DriveSteps:
        """Return steps, none longer than ``step``, that resolve the drives; there are none here."""
        return DriveSteps(step, np.zeros(0), False)

    def spread_within(self, duration: float) -> int:
        """Return the number of cells by which losses smear fronts in this time: here 0."""
        return 0

    def with_walls(self, state: State) -> State:
        """Return the state with the cells of walls appended; here there are none."""
        return state

    @property
    def conserves_energy(self) -> bool:
        """Whether every bond acts on the fields that stretch it, so that `energy` is conserved."""
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
        """Whether positive slopes of all bonds exclude growing waves."""
        if self.cellwise[1] is not None:
            return False
        waves = zone_wavenumbers(self.dimension, WAVENUMBERS[self.dimension])
        root = np.sqrt(self.masses)
        for unit in np.eye(len(self.bonds)):
            matrices = self.dynamical_matrix(waves, list(unit)) * (root[:, None] / root)
            tolerance = ROUNDED_SQUARE * np.abs(matrices).max()
            if np.abs(matrices - matrices.conj().swapaxes(-1, -2)).max() > tolerance:
                return False
            if np.linalg.eigvalsh(matrices).min() < -tolerance:
                return False
        return True

    def stretches(self, f: Array) -> list[Array]:
        """Return the stretch of each bond in each cell."""
        return [bond.stretched(f) for bond in self.bonds]

    def stretch_ranges(self, f: Array, ranges: Sequence[Range]) -> list[Range]:
        """Return the least and largest stretch of each bond for fields ``f`` with these ranges."""
        return [bond.stretch_range(f, ranges) for bond in self.bonds]

    def acceleration(self, f: Array) -> Array:
        """Compute f'' of every field and cell with NumPy; compiled kernels must agree with it."""
        return self.acceleration_by([bond.force(bond.stretched(f)) for bond in self.bonds])

    def acceleration_by(self, forces: Sequence[Array]) -> Array:
        """Return f'' due to the given forces in the bonds of all cells."""
        total = np.zeros((len(self.fields), *forces[0].shape))
        for bond, force in zip(self.bonds, forces, strict=True):
            for entry in bond.action:
                total[entry.field] += entry.weight * _shifted(force, entry.shift)
        masses = np.array(self.masses).reshape(-1, *(1,) * (total.ndim - 1))
        return np.asarray(total / masses, dtype=np.float64)

    def dynamical_matrix(self, wavenumbers: ArrayLike, slopes: Sequence[float]) -> Complex:
        """Return D with ``f'' = -D f`` for waves exp(i k n), given one force slope for each bond.

        ``wavenumbers`` have shape (..., axes); the matrices have shape (..., fields, fields).
        """
        k = np.asarray(wavenumbers, dtype=np.float64)
        count = len(self.fields)
        matrices = np.zeros((*k.shape[:-1], count, count), dtype=np.complex128)
        for bond, slope in zip(self.bonds, slopes, strict=True):
            for end in bond.action:
                for part in bond.stretch:
                    phase = k @ np.add(end.shift, part.shift).astype(np.float64)
                    weight = end.weight * part.weight * slope / self.masses[end.field]
                    matrices[..., end.field, part.field] -= weight * np.exp(1j * phase)
        return matrices

    def squared_frequencies(self, wavenumbers: ArrayLike, slopes: Sequence[float]) -> Array:
        """Return the eigenvalues of the dynamical matrix, ascending along the last axis."""
        values = np.linalg.eigvals(self.dynamical_matrix(wavenumbers, slopes))
        return np.sort(values.real, axis=-1)

    def slopes(self, stretches: Sequence[Array]) -> list[Array]:
        """Return the slope of each bond's force at its stretches; not finite where undefined."""
        pairs = zip(self.bonds, stretches, strict=True)
        with np.errstate(all="ignore"):
            return [np.asarray(bond.force.slope(stretch)) for bond, stretch in pairs]

    def largest_slope(self, index: int, stretches: Array) -> float:
        """Return the largest abs(slope) of the force of bond ``index`` at stretches; may be nan."""
        with np.errstate(all="ignore"):
            return float(np.max(np.abs(self.bonds[index].force.slope(stretches))))

    def steepest(self, index: int, stretches: Array) -> float:
        """Return the largest slope of the force of bond ``index`` at stretches; may be nan."""
        with np.errstate(all="ignore"):
            return float(np.max(self.bonds[index].force.slope(stretches)))

    def rest_slopes(self) -> list[float]:
        """Return the slope of each bond's force at the mean stretch."""
        return [float(bond.force.slope(np.array(bond.offset))) for bond in self.bonds]

    def highest_frequency(self, slopes: Sequence[float]) -> float:
        """Return the largest frequency of any wave if the bonds' forces have these slopes."""
        return math.sqrt(max(float(np.max(self._all_squares(slopes))), 0.0))

    def is_stable(self, slopes: Sequence[float]) -> bool:
        """Return whether no wave grows if the bonds' forces have these slopes."""
        squares = self._all_squares(slopes)
        return bool(np.min(squares) >= -ROUNDED_SQUARE * max(float(np.max(squares)), 1e-300))

    def _all_squares(self, slopes: Sequence[float]) -> Array:
        waves = zone_wavenumbers(self.dimension, WAVENUMBERS[self.dimension])
        return self.squared_frequencies(waves, slopes)

    def energy(self, f: Array, v: Array) -> float:
        """Return the kinetic and potential energy of a ring of displacements (not of strains)."""
        masses = np.array(self.masses).reshape(-1, *(1,) * (f.ndim - 1))
        total = 0.5 * float(np.sum(masses * v * v))
        for bond, stretch in zip(self.bonds, self.stretches(f), strict=True):
            total += float(np.sum(bond.force.potential(stretch)))
        return total


WAVENUMBERS = {1: 257, 2: 33, 3: 9}
"""Number of wavenumbers per axis, keyed by dimension, for finding the highest frequency (to 1e-4 in
a chain)."""

ROUNDED_SQUARE = 1e-12
"""Negative squared frequencies up to this fraction of the largest one count as rounding."""


def zone_wavenumbers(dimension: int, count: int) -> Array:
    """Return wavenumbers (waves, axes) of half the Brillouin zone, ``count`` on the first axis."""
    axis = np.linspace(0.0, math.pi, count)
    axes = [axis, *[np.linspace(-math.pi, math.pi, 2 * count - 1)] * (dimension - 1)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dimension)


def value_range(values: Array) -> Range:
    """Return the least and the largest value; both are nan if any value is."""
    return float(np.minimum.reduce(values, None)), float(np.maximum.reduce(values, None))


def _shifted(values: Array, shift: tuple[int, ...]) -> Array:
    """Return ``values``, each from the cell at offset ``shift``; the last axes are the cells."""
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
    """Return the lattice with values for all its constants and a uniform mean strain.

    ``mean_strain`` has one entry for each axis. Field i grows by ``shares[i]`` times the mean
    strain, by all of it without ``shares``. Raises ValueError for constants that are missing,
    unknown or out of their symbols' range, and for a mean strain if a growing field feels forces of
    its site.

    >>> from longwave.derive import LATTICES
    >>> chain = numeric_lattice(LATTICES["toda"], {"a": 1, "b": 1})
    >>> chain.highest_frequency(chain.rest_slopes())
    2.0
    """
    from longwave.derive.algebra.exact_numbers import exact

    if lattice.has_losses:
        raise ValueError(
            f"lattice must have no losses of its own to be run, got {lattice.name} with losses "
            "(give them to driven_chain, or in [losses] of a scene)"
        )
    names = {str(symbol): symbol for symbol in lattice.constants}
    for name in (*constants, *names):
        if name not in names or name not in constants:
            word = "must be given, got none" if name in names else "is not known"
            raise ValueError(f"constant {name} of {lattice.name} {word} ({one_of(name, names)})")
    values = {names[name]: exact(name, value) for name, value in constants.items()}
    zero_allowed = lattice.contact_constants if 0 in values.values() else set()
    for symbol, value in values.items():
        if symbol.is_positive and not (value > 0 or (value == 0 and symbol in zero_allowed)):
            raise ValueError(f"{symbol} must satisfy {symbol} > 0, got {value} ({lattice.name})")
    numeric = NumericLattice(
        lattice.name,
        lattice.fields,
        tuple(float(mass.xreplace(values)) for mass in lattice.masses),
        tuple(_numeric_bond(bond, values) for bond in lattice.bonds),
    )
    return numeric.with_mean_strain(mean_strain, shares)


def _numeric_bond(bond: Bond, values: Mapping[Any, Any]) -> NumericBond:
    stretch, action = (
        tuple(Entry(one.shift, float(one.weight), one.field) for one in entries)
        for entries in (bond.stretch, bond.action)
    )
    return NumericBond(stretch, action, force_program(bond.force.xreplace(values)))

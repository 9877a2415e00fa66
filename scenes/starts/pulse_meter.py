"""Measurement of a wave in a disordered lattice: largest force, crest position, energy."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from longwave.lattice.disordered_lattice import DisorderedLattice
from longwave.lattice.trial import SAFETY
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.support.real_arrays import Array

ENERGY_FRACTION = 0.999
"""Fraction of the initial energy that the window about the crest contains at the start."""

CLOSED_FRACTION = 1e-4
"""A ring of strains counts as closed if its velocities sum to at most this fraction of the sum of
their moduli. If its ends cut off part of the wave, up to 2e-6 of the energy is missing; the control
run misses another amount, so the loss is part of the estimated error."""


class Pulse(NamedTuple):
    """Measured wave at one time.

    ``peak`` is the largest force of a bond, ``place`` its position in cells, ``energy`` the energy
    in the window about the crest, ``whole`` the energy of the ring. Energies are NaN for a ring of
    strains that does not close and for a lattice without an energy.
    """

    peak: float
    place: float
    energy: float
    whole: float


class PulseMeter:
    """Meter that measures a `Pulse` anywhere on a ring of a disordered lattice.

    The crest may be delayed so much that it has left the compared cells. ``rest`` are the bonds'
    stretches outside the wave. The energy is summed in a window about the crest that contains the
    fraction ``ENERGY_FRACTION`` of the initial energy.
    """

    def __init__(self, ring: InitialCells, rest: Sequence[float]) -> None:
        assert isinstance(ring.lattice, DisorderedLattice)
        self._lattice = ring.lattice
        self._rest = tuple(rest)
        self._cells = ring.cells
        self._masses = ring.lattice.cell_masses
        self._momentum = self._momentum_at_rest(ring.v)
        self._reach = 0.0
        energies = self._energies(ring.f, ring.v)
        position = self._crest(ring.f)[1]
        distances = np.abs(self._cells - position)
        order = np.argsort(distances, kind="stable")
        enclosed = np.cumsum(energies[order])
        index = np.searchsorted(enclosed, ENERGY_FRACTION * enclosed[-1])
        self._reach = float(distances[order][min(int(index), enclosed.size - 1)])

    def __call__(self, f: Array, v: Array) -> Pulse:
        """Measure the wave in the ring's state of fields ``f`` and velocities ``v``."""
        energies = self._energies(f, v)
        peak, position = self._crest(f)
        near = np.abs(self._cells - position) <= self._reach + 0.5
        return Pulse(peak, position, float(np.sum(energies[near])), float(np.sum(energies)))

    def _momentum_at_rest(self, v: Array) -> float:
        """Return the momentum of a ring of strains in the frame in which its first mass rests."""
        return float(np.sum(self._masses[0] * (np.cumsum(v[0]) - v[0])))

    def _energies(self, f: Array, v: Array) -> Array:
        if not self._lattice.has_energy:
            return np.full(v.shape[1], np.nan)
        if not self._lattice.holds_strains:
            return self._lattice.energies(f, v, rest=self._rest)
        if abs(float(np.sum(v))) > CLOSED_FRACTION * float(np.sum(np.abs(v))):
            return np.full(v.shape[1], np.nan)
        missing = self._momentum - self._momentum_at_rest(v)
        velocity = missing / float(np.sum(self._masses))
        return self._lattice.energies(f, v, velocity, self._rest)

    def _crest(self, f: Array) -> tuple[float, float]:
        rows = zip(self._lattice.bonds, self._lattice.forces(f), self._rest, strict=True)
        forces = [force - float(bond.force(np.array(rest))) for bond, force, rest in rows]
        return crest(self._cells, np.max(np.abs(forces), axis=0))


def pulse_track(
    readings: Array, coarser: Array, theory: Sequence[tuple[float, float]]
) -> tuple[dict[str, Array], dict[str, float]]:
    """Return peak, delay and energy over time with their errors, and the values at the last time.

    ``readings`` are those of a `PulseMeter`, (times, 4); ``coarser`` are those of the run with the
    next longer step; their differences give the errors. ``theory`` holds height and position of the
    ordered lattice's crest at the times. Values missing in one of the runs are NaN.
    """
    values, others = _relative(readings, theory), _relative(coarser, theory)
    errors = {name: SAFETY * np.abs(others[name] - column) for name, column in values.items()}
    values = {name: np.where(np.isnan(errors[name]), np.nan, values[name]) for name in values}
    error_columns = {f"{name}_error": error for name, error in errors.items()}
    last = {f"last_{name}": float(column[-1]) for name, column in values.items()}
    return values | error_columns, last


def _relative(readings: Array, theory: Sequence[tuple[float, float]]) -> dict[str, Array]:
    """Return peak and energy relative to the start, and the delay behind the theoretical crest."""
    expected = np.array([position for _, position in theory])
    peak, position, energy, whole = readings.T
    with np.errstate(all="ignore"):
        return {
            "peak": peak / (peak[0] or np.nan),
            "delay": (expected - expected[0]) - (position - position[0]),
            "energy": energy / (whole[0] or np.nan),
        }


PULSE_VARIABLES = {
    "peak": ("1", "largest force, in units of that at the start"),
    "delay": ("sites", "how far the crest is behind that of the ordered lattice's wave"),
    "energy": ("1", "energy about the crest, in units of all at the start"),
    "peak_error": ("1", "estimated error of the largest force"),
    "delay_error": ("sites", "estimated error of the delay"),
    "energy_error": ("1", "estimated error of the energy about the crest"),
}
"""Unit and long name of each variable of `pulse_track`."""


def crest(cells: Array, values: Array) -> tuple[float, float]:
    """Return height and position of the crest of |values|, interpolated between cells.

    The height is taken from the parabola through the largest modulus and its neighbours; the
    position is the centroid of the peak above half its height.

    >>> height, position = crest(np.arange(9.0), np.array([0, 0, 1, 3, 4, 3, 1, 0, 0]))
    >>> height, position
    (4.0, 4.0)
    """
    sizes = np.abs(values)
    top = int(np.argmax(sizes))
    height = float(sizes[top])
    if 0 < top < sizes.size - 1:
        below, above = float(sizes[top - 1]), float(sizes[top + 1])
        bend = 2.0 * height - below - above
        height += (above - below) ** 2 / (8.0 * bend) if bend > 0.0 else 0.0
    low = np.flatnonzero(sizes[:top] < height / 2.0)
    high = np.flatnonzero(sizes[top:] < height / 2.0)
    first = int(low[-1]) + 1 if low.size else 0
    last = top + int(high[0]) if high.size else sizes.size
    weights = sizes[first:last] - height / 2.0
    total = float(np.sum(weights))
    position = float(np.sum(weights * cells[first:last]) / total) if total > 0.0 else cells[top]
    return height, float(position)

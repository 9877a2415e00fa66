"""What is left of a wave on its way through disorder: its largest force, its place, its energy."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.disordered_lattice import DisorderedLattice
from longwave.lattice.trial import SAFETY
from longwave.scenes.starts.initial_cells import InitialCells

Array = NDArray[np.float64]

HELD = 0.999
"""Of the energy, what the window about the crest holds at the start."""

CLOSED = 1e-4
"""A ring of strains closes if their velocities add up to at most this share of themselves. What is
missing of a wave that the ring's ends cut is up to 2e-6 of its energy then, and another part in the
run that this one is compared with: the error is larger."""


class Pulse(NamedTuple):
    """What is left of a wave at a time.

    ``peak``: the largest force of a bond; ``place`` of it, a cell; ``energy`` about it and
    ``whole``, that of the ring, nan where a ring of strains does not close and where a lattice has
    no masses.
    """

    peak: float
    place: float
    energy: float
    whole: float


class PulseMeter:
    """Measures `Pulse` on a ring of a disordered lattice, wherever on it the crest is.

    A crest may be so late that it is in none of the cells that are compared. ``rest``: the bonds'
    stretches beside the wave. The window in which a crest's energy is counted is as wide on either
    side as holds the share ``HELD`` of the energy at the start.
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
        place = self._crest(ring.f)[1]
        distances = np.abs(self._cells - place)
        order = np.argsort(distances, kind="stable")
        held = np.cumsum(energies[order])
        enough = np.searchsorted(held, HELD * held[-1])
        self._reach = float(distances[order][min(int(enough), held.size - 1)])

    def __call__(self, f: Array, v: Array) -> Pulse:
        """The pulse of a state of that ring."""
        energies = self._energies(f, v)
        peak, place = self._crest(f)
        near = np.abs(self._cells - place) <= self._reach + 0.5
        return Pulse(peak, place, float(np.sum(energies[near])), float(np.sum(energies)))

    def _momentum_at_rest(self, v: Array) -> float:
        """That of a ring of strains whose first mass rests; it stays."""
        return float(np.sum(self._masses[0] * (np.cumsum(v[0]) - v[0])))

    def _energies(self, f: Array, v: Array) -> Array:
        if not self._lattice.has_energy:
            return np.full(v.shape[1], np.nan)
        if not self._lattice.holds_strains:
            return self._lattice.energies(f, v, rest=self._rest)
        if abs(float(np.sum(v))) > CLOSED * float(np.sum(np.abs(v))):
            return np.full(v.shape[1], np.nan)
        missing = self._momentum - self._momentum_at_rest(v)
        velocity = missing / float(np.sum(self._masses))
        return self._lattice.energies(f, v, velocity, self._rest)

    def _crest(self, f: Array) -> tuple[float, float]:
        found = zip(self._lattice.bonds, self._lattice.forces(f), self._rest, strict=True)
        forces = [force - float(bond.force(np.array(still))) for bond, force, still in found]
        return crest(self._cells, np.max(np.abs(forces), axis=0))


def pulse_track(
    found: Array, before: Array, theory: Sequence[tuple[float, float]]
) -> tuple[dict[str, Array], dict[str, float]]:
    """What is left of a wave at all times of a run, by name, and the numbers of the last time.

    ``found`` are (times, numbers) as `PulseMeter` gives them, ``before`` those of the run that they
    control; ``theory`` holds the wave's crests at the times. What one of the two runs does not tell
    is NaN.
    """
    told, other = _told(found, theory), _told(before, theory)
    errors = {name: SAFETY * np.abs(other[name] - values) for name, values in told.items()}
    told = {name: np.where(np.isnan(errors[name]), np.nan, told[name]) for name in told}
    apart = {f"{name}_error": error for name, error in errors.items()}
    return told | apart, {f"last_{name}": float(values[-1]) for name, values in told.items()}


def _told(run: Array, theory: Sequence[tuple[float, float]]) -> dict[str, Array]:
    moved = np.array([place for _, place in theory])
    peak, place, energy, whole = run.T
    with np.errstate(all="ignore"):
        return {
            "peak": peak / (peak[0] or np.nan),
            "delay": (moved - moved[0]) - (place - place[0]),
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
"""Unit and long name of each column."""


def crest(cells: Array, values: Array) -> tuple[float, float]:
    """The largest size of the values, between cells, and where it is.

    Its size is that of the parabola through the largest and its neighbours; its place the centre of
    what rises above half of it about there.

    >>> height, place = crest(np.arange(9.0), np.array([0, 0, 1, 3, 4, 3, 1, 0, 0]))
    >>> height, place
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
    place = float(np.sum(weights * cells[first:last]) / total) if total > 0.0 else cells[top]
    return height, float(place)

"""What a march and its judge ask of a lattice: how it is advanced, how fast its waves are."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.blow_up import find_blow_up
from longwave.lattice.driving import DrivenChain
from longwave.lattice.kernels import nystroem, reference
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.model import chain_constants
from longwave.lattice.numeric_lattice import NumericLattice, value_range
from longwave.lattice.schemes import DriftKick, Scheme
from longwave.lattice.state import GROWTH, BlowUp, State
from longwave.support.real_arrays import real_array

Array = NDArray[np.float64]

SLOPES = 65
"""Stretches, from the least that was met to the most, at which slopes are looked at."""

LARGEST_SLOPE = 1e290
"""Beyond it sums of slopes, in units of masses, may be no numbers."""

WIDER = 0.125
"""By which part of itself a range of stretches is widened at either end where it is looked at, so
that waves that rise a little from stop to stop are not looked at anew each time."""


class Dynamics:
    """A lattice that can be advanced, and what its states say of how.

    *Ranges* are the least and the largest of each bond's stretch, then those of each field.
    """

    def __init__(self, lattice: NumericLattice) -> None:
        self.lattice = lattice
        self._kernels: dict[tuple[int, ...], RingKernel] = {}
        self._firm: list[tuple[float, float]] = []

    def checked(self, state: State) -> State:
        """The state with arrays of doubles of the lattice's shape."""
        fields, axes = len(self.lattice.fields), self.lattice.dimension
        f, v = (
            np.ascontiguousarray(
                real_array(f"every value of state.{name}", values, allows_nan=True)
            )
            for name, values in (("f", state.f), ("v", state.v))
        )
        found = State(state.t, f, v, state.left)
        for name, values in (("f", found.f), ("v", found.v)):
            fits = values.ndim == 1 + axes and values.shape == found.f.shape
            if not fits or values.shape[0] != fields or not values.size:
                raise ValueError(
                    f"state.{name} must have the shape (fields, *cells) of {fields} fields and "
                    f"{axes} axes, got {values.shape} (a chain of one field has (1, cells))"
                )
            _check_finite(name, values)
        cells = self.lattice.cell_count
        if cells not in (None, found.f.shape[1]):
            raise ValueError(
                f"state must have the {cells} cells of the lattice, got {found.f.shape[1]} (what "
                "differs from cell to cell, and its ends, are stated for so many)"
            )
        return found

    def advance(
        self, scheme: Scheme, f: Array, v: Array, h: float, steps: int, t: float = 0.0
    ) -> None:
        """Advance fields and velocities in place by ``steps`` steps of length ``h`` from ``t`` on.

        Chains and planes by machine code written for them, if the scheme is a splitting.
        """
        if self.lattice.is_driven:
            self._advance_driven(scheme, f, v, h, steps, t)
            return
        if not isinstance(scheme, DriftKick):
            self._advance_by_stages(scheme, f, v, h, steps)
            return
        weights = scheme.drifts * h, scheme.kicks * h
        if self.lattice.dimension <= 2:
            self._kernel(f.shape[1:]).advance(f, v, *weights, steps)
        else:
            reference.advance_splitting(self.lattice.acceleration, f, v, *weights, steps)

    def _advance_driven(
        self, scheme: Scheme, f: Array, v: Array, h: float, steps: int, t: float
    ) -> None:
        """With losses and forces at the time of each stage."""
        chain = self.lattice
        assert isinstance(chain, DrivenChain)
        if not isinstance(scheme, DriftKick):
            raise ValueError(
                f"scheme must be a splitting with ends, losses or forces, got {scheme.name} (leave "
                "it out)"
            )
        chain.place_walls(f, v, t)
        drifts, kicks = chain.stage_weights(scheme, v, t, h, steps)
        self._kernel(f.shape[1:]).advance_stages(f, v, drifts, kicks, len(kicks))
        chain.place_walls(f, v, t + steps * h)

    def _advance_by_stages(self, scheme: Scheme, f: Array, v: Array, h: float, steps: int) -> None:
        """A Nystroem method: of the paper's chain by machine code."""
        constants = chain_constants(self.lattice)
        if constants is not None and f.shape[1] >= 3:
            nystroem.advance_nystroem(f[0], v[0], scheme.floats, h, steps, *constants)
        else:
            acceleration = self.lattice.acceleration
            reference.advance_nystroem_method(acceleration, f, v, scheme.floats, h, steps)

    def _kernel(self, shape: tuple[int, ...]) -> RingKernel:
        """The kernel for rings of that shape, with the room that the last one took."""
        if shape not in self._kernels:
            self._kernels.clear()
            self._kernels[shape] = RingKernel(self.lattice, *shape)
        return self._kernels[shape]

    def threads(self, scheme: Scheme) -> int:
        """How many states may be advanced at once.

        The machine code leaves the interpreter to others, NumPy's many small calls do not.
        """
        return 2 if isinstance(scheme, DriftKick) and self.lattice.dimension <= 2 else 1

    def ranges(self, state: State) -> Array:
        """The ranges of one state."""
        with np.errstate(invalid="ignore", over="ignore"):  # after a blow-up
            fields = [value_range(values) for values in state.f]
            bonds = self.lattice.stretch_ranges(state.f, fields)
        return np.array([*bonds, *fields])

    def highest_frequency(self, ranges: Array) -> float:
        """The highest frequency of any wave about what is in these ranges; inf if none is.

        With the largest slope of each bond in its range, of either sign, and at rest.
        """
        found = []
        for place, bond in enumerate(self.lattice.bonds):
            least, most = map(float, ranges[place])
            if not math.isfinite(most - least):
                return math.inf
            stretches = np.append(np.linspace(least, most, SLOPES), bond.offset)
            seen = self.lattice.largest_slope(place, stretches)
            with np.errstate(all="ignore"):
                bare = float(np.max(np.abs(bond.force.slope(stretches))))
            hidden = bond.force.steepest_between(least, most, bare)
            found.append(seen if hidden == bare else seen / bare * hidden)
        if not all(slope < LARGEST_SLOPE for slope in found):
            return math.inf
        return self.lattice.highest_frequency(found)

    def largest(self, ranges: Array) -> float:
        """The size of the numbers whose rounding is felt, in the unit of stretches.

        The largest field, as often as it enters a stretch, or a force's largest summand: what
        rounding does to that, a stretch does that is smaller by the force's slope. Infinite after
        a blow-up.
        """
        bonds = self.lattice.bonds
        if not all(math.isfinite(most - least) for least, most in ranges.tolist()):
            return math.inf
        weights = [sum(abs(part.weight) for part in bond.stretch) for bond in bonds]
        found = float(np.max(np.abs(ranges[len(bonds) :]))) * max(weights)
        for bond, (least, most) in zip(bonds, ranges, strict=False):
            places = np.linspace(least, most, SLOPES)
            with np.errstate(all="ignore"):
                slope = float(np.max(np.abs(bond.force.slope(places))))
                summand = bond.force.largest_summand(places)
            found = max(found, summand / slope if slope > 0.0 else 0.0)
        return found

    def stretches(self, f: Array) -> Array:
        """The stretch of each bond in each cell."""
        return np.array(self.lattice.stretches(f))

    def find_blow_up(self, state: State, ranges: Array, amplitude: float | None) -> BlowUp | None:
        """What is wrong with a state of those ranges, if anything (`blow_up.find_blow_up`)."""
        sound = amplitude is not None and self._is_sound(ranges, GROWTH * amplitude)
        if sound and math.isfinite(float(state.v.sum())):
            return None
        return find_blow_up(self.lattice, state, amplitude)

    def _is_sound(self, ranges: Array, limit: float) -> bool:
        """Whether the ranges alone say that nothing is wrong: most of the work is saved then."""
        bonds = self.lattice.bonds
        met = ranges[: len(bonds)].tolist()
        for bond, (least, most) in zip(bonds, met, strict=True):
            if not -limit <= least - bond.offset <= most - bond.offset <= limit:
                return False
        if self._firm and all(
            low <= least and most <= high
            for (low, high), (least, most) in zip(self._firm, met, strict=True)
        ):
            return True
        rooms = [WIDER * (most - least) for least, most in met]
        wider = [
            (least - room, most + room) for (least, most), room in zip(met, rooms, strict=True)
        ]
        self._firm = wider if self._is_firm(wider) else []
        return bool(self._firm)

    def _is_firm(self, ranges: list[tuple[float, float]]) -> bool:
        """Whether no wave grows wherever the stretches are in these ranges.

        A slope's least value may lie between two that are looked at, lower by less than these
        differ from their neighbours.
        """
        if not self.lattice.gets_stiffer_by_bonds:
            return False
        for bond, ends in zip(self.lattice.bonds, ranges, strict=True):
            with np.errstate(all="ignore"):
                slopes = bond.force.slope(np.linspace(*ends, SLOPES))
            if not slopes.min() > np.abs(np.diff(slopes)).max():
                return False
        return True


def _check_finite(name: str, values: Array) -> None:
    broken = ~np.isfinite(values)
    if np.any(broken):
        place = tuple(int(axis) for axis in np.argwhere(broken)[0])
        where = place[0] if len(place) == 1 else place
        raise ValueError(
            f"state.{name} must be finite, got {values[place]} at place {where} "
            "(look at where the state comes from)"
        )

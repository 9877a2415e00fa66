"""A lattice's dynamics for a time march: advancing states, wave speeds, and checks of states."""

from __future__ import annotations

import math

import numpy as np

from longwave.lattice.blow_up import find_blow_up
from longwave.lattice.driving import DrivenChain
from longwave.lattice.kernels import nystroem, reference
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.model import chain_constants
from longwave.lattice.numeric_lattice import NumericLattice, value_range
from longwave.lattice.run_times import checked_fields
from longwave.lattice.schemes import DriftKick, Scheme
from longwave.lattice.state import GROWTH, BlowUp, State
from longwave.support.real_arrays import Array

SLOPE_SAMPLES = 65
"""Number of stretches, from the least to the largest encountered, at which slopes are evaluated."""

LARGEST_SLOPE = 1e290
"""Slope of a force above which frequencies count as infinite; smaller slopes cannot overflow."""

RANGE_MARGIN = 0.125
"""Margin added at either end of a range of stretches before it is checked, as a fraction of its
width, so that a wave that rises slowly from stop to stop does not need a new check each time."""


class Dynamics:
    """Time steps and frequencies of a lattice, and *ranges* of its stretches and fields."""

    def __init__(self, lattice: NumericLattice) -> None:
        self.lattice = lattice
        self._kernels: dict[tuple[int, ...], RingKernel] = {}
        self._safe_ranges: list[tuple[float, float]] = []

    def checked(self, state: State) -> State:
        """Return the state with contiguous double arrays; raise ValueError if it does not fit."""
        result = State(state.t, *checked_fields(self.lattice, state.f, state.v), state.left)
        cells = self.lattice.cell_count
        if cells not in (None, result.f.shape[1]):
            raise ValueError(
                f"state must have the {cells} cells of the lattice, got {result.f.shape[1]} (its "
                "disorder and ends are defined for that number)"
            )
        return result

    def advance(
        self, scheme: Scheme, f: Array, v: Array, h: float, steps: int, t: float = 0.0
    ) -> None:
        """Advance fields and velocities in place by ``steps`` steps of length ``h`` from ``t``."""
        if self.lattice.is_driven:
            self._drive(scheme, f, v, h, steps, t)
            return
        if not isinstance(scheme, DriftKick):
            self._advance_by_stages(scheme, f, v, h, steps)
            return
        weights = scheme.drifts * h, scheme.kicks * h
        if self.lattice.dimension <= 2:
            self._kernel(f.shape[1:]).advance(f, v, *weights, steps)
        else:
            reference.advance_splitting(self.lattice.acceleration, f, v, *weights, steps)

    def _drive(self, scheme: Scheme, f: Array, v: Array, h: float, steps: int, t: float) -> None:
        """Advance a driven chain; forces and walls are evaluated at the time of each stage."""
        chain = self.lattice
        assert isinstance(chain, DrivenChain)
        if not isinstance(scheme, DriftKick):
            raise ValueError(
                "a chain with ends, losses or forces needs a splitting scheme, got "
                f"{scheme.name} (leave scheme out)"
            )
        chain.place_walls(f, v, t)
        drifts, kicks = chain.stage_weights(scheme, v, t, h, steps)
        self._kernel(f.shape[1:]).advance_stages(f, v, drifts, kicks, len(kicks))
        chain.place_walls(f, v, t + steps * h)

    def _advance_by_stages(self, scheme: Scheme, f: Array, v: Array, h: float, steps: int) -> None:
        """Advance by a Nystroem method, compiled for the paper's chain and in NumPy for others."""
        constants = chain_constants(self.lattice)
        if constants is not None and f.shape[1] >= 3:
            nystroem.advance_nystroem(f[0], v[0], scheme.floats, h, steps, *constants)
        else:
            acceleration = self.lattice.acceleration
            reference.advance_nystroem_method(acceleration, f, v, scheme.floats, h, steps)

    def _kernel(self, shape: tuple[int, ...]) -> RingKernel:
        """Return the kernel for rings of that shape; only the last one is cached."""
        if shape not in self._kernels:
            self._kernels.clear()
            self._kernels[shape] = RingKernel(self.lattice, *shape)
        return self._kernels[shape]

    def threads(self, scheme: Scheme) -> int:
        """Return how many states can be advanced concurrently; 1 without a compiled kernel."""
        return 2 if isinstance(scheme, DriftKick) and self.lattice.dimension <= 2 else 1

    def ranges(self, state: State) -> Array:
        """Return the least and largest value of each bond's stretch, then of each field."""
        with np.errstate(invalid="ignore", over="ignore"):  # after a blow-up
            fields = [value_range(values) for values in state.f]
            bonds = self.lattice.stretch_ranges(state.f, fields)
        return np.array([*bonds, *fields])

    def highest_frequency(self, ranges: Array) -> float:
        """Return an upper bound (maybe inf) of wave frequencies for states in these ranges."""
        slopes = []
        for index, bond in enumerate(self.lattice.bonds):
            least, most = map(float, ranges[index])
            if not math.isfinite(most - least):
                return math.inf
            stretches = np.append(np.linspace(least, most, SLOPE_SAMPLES), bond.offset)
            sampled = self.lattice.largest_slope(index, stretches)
            with np.errstate(all="ignore"):
                ordered = float(np.max(np.abs(bond.force.slope(stretches))))
            bound = bond.force.steepest_between(least, most, ordered)
            slopes.append(sampled if bound == ordered else sampled / ordered * bound)
        if not all(slope < LARGEST_SLOPE for slope in slopes):
            return math.inf
        return self.lattice.highest_frequency(slopes)

    def largest(self, ranges: Array) -> float:
        """Return the size, in units of stretches, of the largest number whose rounding matters.

        It is the largest field times its weights in a stretch, or a force's largest summand divided
        by the force's slope. The size is infinite after a blow-up.
        """
        bonds = self.lattice.bonds
        if not all(math.isfinite(most - least) for least, most in ranges.tolist()):
            return math.inf
        weights = [sum(abs(part.weight) for part in bond.stretch) for bond in bonds]
        largest = float(np.max(np.abs(ranges[len(bonds) :]))) * max(weights)
        for bond, (least, most) in zip(bonds, ranges, strict=False):
            samples = np.linspace(least, most, SLOPE_SAMPLES)
            with np.errstate(all="ignore"):
                slope = float(np.max(np.abs(bond.force.slope(samples))))
                summand = bond.force.largest_summand(samples)
            largest = max(largest, summand / slope if slope > 0.0 else 0.0)
        return largest

    def find_blow_up(self, state: State, ranges: Array, amplitude: float | None) -> BlowUp | None:
        """Return `blow_up.find_blow_up` of a state; None at once if its ranges are clearly safe."""
        sound = amplitude is not None and self._is_clearly_sound(ranges, GROWTH * amplitude)
        if sound and math.isfinite(float(state.v.sum())):
            return None
        return find_blow_up(self.lattice, state, amplitude)

    def _is_clearly_sound(self, ranges: Array, limit: float) -> bool:
        """Return whether the ranges alone exclude a blow-up, without the full check."""
        bonds = self.lattice.bonds
        bond_ranges = ranges[: len(bonds)].tolist()
        for bond, (least, most) in zip(bonds, bond_ranges, strict=True):
            if not -limit <= least - bond.offset <= most - bond.offset <= limit:
                return False
        if self._safe_ranges and all(
            low <= least and most <= high
            for (low, high), (least, most) in zip(self._safe_ranges, bond_ranges, strict=True)
        ):
            return True
        margins = [RANGE_MARGIN * (most - least) for least, most in bond_ranges]
        wider = [
            (least - margin, most + margin)
            for (least, most), margin in zip(bond_ranges, margins, strict=True)
        ]
        self._safe_ranges = wider if self._is_stable_within(wider) else []
        return bool(self._safe_ranges)

    def _is_stable_within(self, ranges: list[tuple[float, float]]) -> bool:
        """Return whether no wave grows for stretches in these ranges, even between samples."""
        if not self.lattice.gets_stiffer_by_bonds:
            return False
        for bond, ends in zip(self.lattice.bonds, ranges, strict=True):
            with np.errstate(all="ignore"):
                slopes = bond.force.slope(np.linspace(*ends, SLOPE_SAMPLES))
            if not slopes.min() > np.abs(np.diff(slopes)).max():
                return False
        return True

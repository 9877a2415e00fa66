"""What a march and its judge ask of a lattice, answered for `Model` and for `NumericLattice`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol, overload

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.field_state import FieldState, field_blow_up
from longwave.lattice.force_program import ForceProgram
from longwave.lattice.kernels import nystroem, reference
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.model import BlowUp, Held, Model, State, extremes, find_blow_up
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice
from longwave.lattice.schemes import DriftKick, Scheme

Array = NDArray[np.float64]

NEGLIGIBLE = 1e-200
"""K3 and K4 in units of the largest constant below which no strain up to 1e90 feels them; quotients
of the others neither overflow nor underflow."""

CURVATURE = tuple(Entry((shift,), weight, 0) for shift, weight in ((1, 1.0), (0, -2.0), (-1, 1.0)))
"""D f_n = f_{n+1} - 2 f_n + f_{n-1}."""

SLOPES = 65
"""Stretches, from the least that was met to the most, at which the largest slope is looked for."""


class Dynamics(Protocol[Held]):
    """A lattice that can be advanced, and what its states say of how.

    *Ranges* are the least and the largest of what a state's stiffness depends on, (quantities, 2).
    """

    @property
    def is_linear(self) -> bool:
        """Whether perturbations never grow by what waves are there."""

    def checked(self, state: Held) -> Held:
        """The state with arrays of doubles; ValueError for what is no state of the lattice."""

    def in_order(self, state: Held) -> tuple[Array, Array]:
        """Copies of positions and velocities, sites in their order."""

    def advance(self, scheme: Scheme, f: Array, v: Array, h: float, steps: int) -> None:
        """Advance positions and velocities in place by ``steps`` steps of length ``h``."""

    def threads(self, scheme: Scheme) -> int:
        """How many states may be advanced at once: 1 where `advance` holds the interpreter."""

    def ranges(self, state: Held) -> Array:
        """The ranges of one state."""

    def highest_frequency(self, ranges: Array) -> float:
        """The highest frequency of any wave about what is in these ranges; inf if none is."""

    def largest(self, ranges: Array) -> float:
        """The size of the numbers whose rounding is felt, in the unit of stretches."""

    def stretches(self, f: Array) -> Array:
        """What the error is measured of."""

    def find_blow_up(self, state: Held, ranges: Array, amplitude: float | None) -> BlowUp | None:
        """What is wrong with a state of those ranges, if anything."""


@dataclass(frozen=True)
class StrainDynamics:
    """The FPUT lattice in its strain."""

    model: Model

    @property
    def is_linear(self) -> bool:
        """Whether the force is proportional to the strain."""
        return self.lattice.is_linear

    def checked(self, state: State) -> State:
        """The state with arrays of doubles, at least 3."""
        found = State(state.t, state.left, *_doubles(state.y, state.s))
        for name, values in (("y", found.y), ("s", found.s)):
            if values.shape != (found.size,) or found.size < 3:
                raise ValueError(
                    f"state.{name} must hold one number for each of at least 3 sites, got the "
                    f"shape {values.shape} (strain and velocity are arrays of one length)"
                )
            _check_finite(name, values)
        return found

    def in_order(self, state: State) -> tuple[Array, Array]:
        """Site n is stored at n mod size."""
        return state.strain(state.sites), state.velocity(state.sites)

    def advance(self, scheme: Scheme, f: Array, v: Array, h: float, steps: int) -> None:
        """By machine code of the scheme's kind."""
        if isinstance(scheme, DriftKick):
            self.chain.advance(scheme, f[None], v[None], h, steps)
            return
        [bond] = self.lattice.bonds
        K2, K3, K4 = (*bond.force.coefficients, 0.0, 0.0)[:3]
        nystroem.advance_nystroem(f, v, scheme.floats, h, steps, K2, K3 or None, K4 or None)

    @cached_property
    def chain(self) -> FieldDynamics:
        """The same chain among all lattices."""
        return FieldDynamics(self.lattice)

    @cached_property
    def lattice(self) -> NumericLattice:
        """The chain with these numbers, without terms that are absent or negligible.

        >>> StrainDynamics(Model(4, 1e-300, 1)).lattice.bonds[0].force.coefficients
        (4.0, 0.0, 1.0)
        """
        K2, *others = (float(value) for value in (self.model.K2, self.model.K3, self.model.K4))
        least = NEGLIGIBLE * max(K2, *map(abs, others))
        K3, K4 = (0.0 if abs(value) < least else value for value in others)
        force = ForceProgram((K2, K3, K4)[: 3 if K4 else 2 if K3 else 1])
        bond = NumericBond((Entry((0,), 1.0, 0),), CURVATURE, force)
        return NumericLattice("fput_strain", ("y",), (1.0,), (bond,))

    def threads(self, scheme: Scheme) -> int:
        """As many as `FieldDynamics` of the chain."""
        return self.chain.threads(scheme)

    def ranges(self, state: State) -> Array:
        """The smallest and the largest strain."""
        return extremes(state)

    def highest_frequency(self, ranges: Array) -> float:
        """About the ends of the range, where the stiffness is extreme within, and at rest."""
        K2, K3, K4 = self.model.K2, self.model.K3, self.model.K4
        places = np.append(ranges, 0.0)
        if abs(K4) > 0.0:
            places[-1] = np.clip(np.float64(-K3) / (3.0 * K4), *ranges[0])
        with np.errstate(over="ignore", invalid="ignore"):
            stiffest = max(float(np.max(np.abs(self.model.stiffness(places)))), K2)
        return 2.0 * math.sqrt(stiffest) if math.isfinite(stiffest) else math.inf

    def largest(self, ranges: Array) -> float:
        """The largest strain."""
        return float(np.max(np.abs(ranges)))

    def stretches(self, f: Array) -> Array:
        """The strain itself."""
        return f

    def find_blow_up(self, state: State, ranges: Array, amplitude: float | None) -> BlowUp | None:
        """As `lattice.model.find_blow_up`."""
        return find_blow_up(self.model, state, amplitude, ranges)


@dataclass(frozen=True)
class FieldDynamics:
    """Any lattice with numbers."""

    lattice: NumericLattice
    _kernels: dict[tuple[int, ...], RingKernel] = field(
        default_factory=dict, compare=False, repr=False
    )

    @property
    def is_linear(self) -> bool:
        """Whether every force is proportional to its stretch."""
        return self.lattice.is_linear

    def checked(self, state: FieldState) -> FieldState:
        """The state with arrays of doubles of the lattice's shape."""
        fields, axes = len(self.lattice.fields), self.lattice.dimension
        found = FieldState(state.t, *_doubles(state.f, state.v))
        for name, values in (("f", found.f), ("v", found.v)):
            fits = values.ndim == 1 + axes and values.shape == found.f.shape
            if not fits or values.shape[0] != fields or not values.size:
                raise ValueError(
                    f"state.{name} must have the shape (fields, *cells) of {fields} fields and "
                    f"{axes} axes, got {values.shape} (a chain of one field has (1, cells))"
                )
            _check_finite(name, values)
        _, variation, shares = self.lattice.cellwise
        if variation is not None and found.f.shape[1] != shares.shape[1]:
            raise ValueError(
                f"state must have the {shares.shape[1]} cells of the disordered lattice, got "
                f"{found.f.shape[1]} (each has deviations of its own)"
            )
        return found

    def in_order(self, state: FieldState) -> tuple[Array, Array]:
        """As they are stored."""
        return state.f.copy(), state.v.copy()

    def advance(self, scheme: Scheme, f: Array, v: Array, h: float, steps: int) -> None:
        """Chains and planes by machine code written for them, if the scheme is a splitting."""
        if not isinstance(scheme, DriftKick):
            table = scheme.floats
            reference.advance_nystroem_method(self.lattice.acceleration, f, v, table, h, steps)
            return
        weights = scheme.drifts * h, scheme.kicks * h
        if self.lattice.dimension <= 2:
            self._kernel(f.shape[1:]).advance(f, v, *weights, steps)
        else:
            reference.advance_splitting(self.lattice.acceleration, f, v, *weights, steps)

    def _kernel(self, shape: tuple[int, ...]) -> RingKernel:
        """The kernel for rings of that shape, with the room that the last one took."""
        if shape not in self._kernels:
            self._kernels.clear()
            self._kernels[shape] = RingKernel(self.lattice, *shape)
        return self._kernels[shape]

    def threads(self, scheme: Scheme) -> int:
        """The machine code leaves the interpreter to others, NumPy's many small calls do not."""
        return 2 if isinstance(scheme, DriftKick) and self.lattice.dimension <= 2 else 1

    def ranges(self, state: FieldState) -> Array:
        """Those of each bond's stretch, then those of each field."""
        with np.errstate(invalid="ignore", over="ignore"):  # after a blow-up
            values = [*self.lattice.stretches(state.f), *state.f]
        return np.array([[value.min(), value.max()] for value in values])

    def highest_frequency(self, ranges: Array) -> float:
        """With the largest slope of each bond in its range, of either sign, and at rest."""
        found = []
        for place, bond in enumerate(self.lattice.bonds):
            least, most = ranges[place]
            if not math.isfinite(float(most) - float(least)):
                return math.inf
            stretches = np.append(np.linspace(least, most, SLOPES), bond.offset)
            found.append(self.lattice.largest_slope(place, stretches))
        if not all(map(math.isfinite, found)):
            return math.inf
        return self.lattice.highest_frequency(found)

    def largest(self, ranges: Array) -> float:
        """The largest field, as often as it enters a stretch, or a force's largest summand.

        What rounding does to the latter a stretch does that is smaller by the force's slope.
        Infinite after a blow-up.
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

    def find_blow_up(
        self, state: FieldState, ranges: Array, amplitude: float | None
    ) -> BlowUp | None:
        """As `lattice.field_state.field_blow_up`."""
        return field_blow_up(self.lattice, state, amplitude)


def _doubles(*arrays: Array) -> list[Array]:
    return [np.ascontiguousarray(values, dtype=np.float64) for values in arrays]


def _check_finite(name: str, values: Array) -> None:
    broken = ~np.isfinite(values)
    if np.any(broken):
        place = tuple(int(axis) for axis in np.argwhere(broken)[0])
        where = place[0] if len(place) == 1 else place
        raise ValueError(
            f"state.{name} must be finite, got {values[place]} at place {where} "
            "(look at where the state comes from)"
        )


@overload
def dynamics_of(model: Model) -> Dynamics[State]: ...
@overload
def dynamics_of(model: NumericLattice) -> Dynamics[FieldState]: ...
@overload
def dynamics_of(model: Model | NumericLattice) -> Dynamics[Any]: ...
def dynamics_of(model: Model | NumericLattice) -> Dynamics[Any]:
    """The answers for that kind of lattice."""
    return StrainDynamics(model) if isinstance(model, Model) else FieldDynamics(model)

"""A chain as it stands on a bench: with ends, losses at its cells, and forces from outside.

The cells that move are followed by the walls', which are held or moved, on one ring. A drift is the
flow of ``u' = v, v' = -G v``, with the losses of cells and dashpots in G: it is linear in v, so a
splitting of Nystroem's kind keeps its order. Forces from outside are taken at each kick's time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.disordered_lattice import DisorderedLattice, held_at
from longwave.lattice.drive_steps import drive_steps
from longwave.lattice.kernels.streams import TERMS
from longwave.lattice.numeric_lattice import DriveSteps, NumericLattice, Range, value_range
from longwave.lattice.outer_forces import (
    SiteForce,
    TimeFunction,
    looked_at,
    slope_of,
    values_at,
)
from longwave.lattice.schemes import DriftKick, Scheme
from longwave.lattice.state import State
from longwave.lattice.trial import DRIVEN_SHARE
from longwave.lattice.variation import Pulse, Variation

Array = NDArray[np.float64]
Factors = Mapping[int, float | Sequence[float]]
"""By the numbers of cells or bonds, of all fields or bonds there or of each."""

End = Literal["fixed", "free"] | TimeFunction
"""What is at an end: a wall that is held, nothing, or a wall with a displacement in time."""


SPREAD_TIME = 0.8
"""The time, in units of the inverse rate of dashpots, half of which a step may take: the longest
drift, a quarter of a step, then turns velocities by 0.1 (`kernels.streams.TERMS`)."""

SMEARED = 3.5
"""Half of the standard deviations that are kept of the Gaussian to which dashpots smear a front:
1e-12 of it is beyond. Its variance for nearest neighbours grows as their dashpots' factor, which is
a quarter of `DrivenChain._spreading`."""

LOSS_TIME = 20.0
"""The time, in units of the inverse rate of losses of cells, half of which a step may take: stages
that go back in time let velocities grow by less than exp(10), far from what doubles hold."""


@dataclass(frozen=True)
class _Wall:
    """The ring's cells that stand for one end, and how they move; None if they are held."""

    places: tuple[int, ...]
    displacement: TimeFunction | None


@dataclass(frozen=True, eq=False)
class DrivenChain(DisorderedLattice):
    """A chain of ``cells`` cells with walls, losses and forces; `driven_chain` makes one.

    Its ring has the cells that move, then those of the walls.
    """

    cells: int
    outer_forces: tuple[SiteForce, ...]
    walls: tuple[_Wall, ...]
    free: tuple[tuple[int, int], ...]
    """Cells of the ring at which there is no wall, and the cell that each goes with."""

    @property
    def losses(self) -> tuple[float, ...]:
        """The rates at which each field's velocity shrinks."""
        return self.variation.damped or (0.0,) * len(self.fields)

    @property
    def dashpots(self) -> tuple[float, ...]:
        """The factor of each bond's rate of stretch."""
        return self.variation.dashpots or (0.0,) * len(self.bonds)

    @property
    def shares(self) -> Array:
        """By how much inverse masses are larger, what is cut, and where each pulse is felt.

        Walls have no inverse mass: nothing moves them.
        """
        found = super().shares
        rows, forces = self.variation.mass_rows(len(self.fields)), self.outer_forces
        found[:rows, self.cells :] = -1.0
        inverse = 1.0 + found[:rows] if rows else np.ones((len(self.fields), found.shape[1]))
        moved = [wall.places for wall in self.moved for _ in self.fields]
        pulses = np.zeros((len(forces) + len(moved), found.shape[1]))
        for row, force in zip(pulses, forces, strict=False):
            own = self.cell_masses[force.field, : self.cells]
            row[: self.cells] = inverse[force.field, : self.cells] * force.shares(own)
        for row, places in zip(pulses[len(forces) :], moved, strict=True):
            row[list(places)] = 1.0
        pulls = [self._pull(wall) * inverse for wall in self._pulling]
        return np.concatenate([found, pulses, *pulls])

    @property
    def _pulling(self) -> list[_Wall]:
        """Walls whose velocity is felt, through dashpots."""
        return self.moved if any(self.dashpots) else []

    def _pull(self, wall: _Wall) -> Array:
        """By how much a wall's unit velocity accelerates each field, if all had its usual mass."""
        unit = np.zeros((len(self.fields), self.deviations.shape[1]))
        unit[:, list(wall.places)] = 1.0
        return self.pulled(self.dashed(unit))

    def dashed(self, v: Array) -> list[Array]:
        """The forces of all dashpots."""
        parts = zip(self.bonds, self.dashpots, self.bond_shares, strict=True)
        return [kept * (pot * (bond.stretched(v) - bond.offset)) for bond, pot, kept in parts]

    @property
    def lightest(self) -> float:
        """The least mass of a cell, in units of its field's."""
        masses = self.deviations[: self.variation.mass_rows(len(self.fields)), : self.cells]
        return 1.0 + min(0.0, float(masses.min(initial=0.0)))

    @property
    def cell_masses(self) -> Array:
        """The mass of each field in each cell; walls, which take no part in the energy, have 0."""
        found = super().cell_masses.copy()
        found[:, self.cells :] = 0.0
        return found

    def energy(self, f: Array, v: Array) -> float:
        """Kinetic energy and what all bonds store: ends give way to forces at rest, too."""
        found = super().energy(f, v)
        for bond, kept in zip(self.bonds, self.bond_shares, strict=True):
            _, resting = held_at(bond.force, 0.0)
            if resting:
                found += resting * float(np.sum(kept * bond.stretched(f)))
        return found

    @property
    def bond_shares(self) -> Array:
        """1 for each bond in each cell, 0 where it is cut, (bonds, ring)."""
        ones = np.ones(self.deviations.shape[1])
        return np.array([ones if cut is None else ones + cut[1] for cut in self._varied()])

    @cached_property
    def _cuts(self) -> list[NDArray[np.bool_] | None]:
        """In which cells each bond is cut, None where in none."""
        cuts = self.bond_shares == 0.0
        return [cut if cut.any() else None for cut in cuts]

    def stretches(self, f: Array) -> list[Array]:
        """The stretch of each bond in each cell; a bond that is cut has none."""
        found = super().stretches(f)
        for place, (bond, cut) in enumerate(zip(self.bonds, self._cuts, strict=True)):
            if cut is not None:
                found[place] = np.where(cut, bond.offset, found[place])
        return found

    def stretch_ranges(self, f: Array, ranges: Sequence[Range]) -> list[Range]:
        """The least and the largest stretch of each bond, wherever it is not cut."""
        if not any(cut is not None for cut in self._cuts):
            return super().stretch_ranges(f, ranges)
        return [value_range(stretch) for stretch in self.stretches(f)]

    @property
    def cell_count(self) -> int | None:
        """The cells that move."""
        return self.cells

    @property
    def exchanges_energy(self) -> bool:
        """Whether its energy is changed from outside or lost."""
        return bool(self.variation.damped or self.variation.pulsed)

    @property
    def is_driven(self) -> bool:
        """Whether anything but held walls acts from outside."""
        return bool(self.exchanges_energy or self.free)

    @property
    def moved(self) -> list[_Wall]:
        """The walls that move."""
        return [wall for wall in self.walls if wall.displacement is not None]

    @property
    def drivers(self) -> tuple[str, ...]:
        """What does work on it, in words: walls that move, and forces."""
        sides = ["right" if wall.places[0] == self.cells else "left" for wall in self.moved]
        forces = [f"force {count}" for count in range(1, len(self.outer_forces) + 1)]
        return (*(f"{side} wall" for side in sides), *forces)

    def drive_within(self, begin: float, end: float) -> tuple[float, bool]:
        """The least time in which a force or a wall's displacement changes by all that it does.

        Or in which losses change velocities as much as a drift takes. And whether a force or a wall
        turns at corners: its slope jumps between times looked at.
        """
        found, turns = looked_at(self._drives, begin, end)
        return min(found, self._loss_time), turns

    @property
    def _loss_time(self) -> float:
        """The time in which losses change velocities as much as a drift takes."""
        found = LOSS_TIME / max(self.losses) if any(self.losses) else math.inf
        return min(found, SPREAD_TIME / self._spreading) if self._spreading else found

    def drive_steps(
        self, begin: float, end: float, step: float, scheme: Scheme, tolerance: float
    ) -> DriveSteps:
        """Steps, none longer than ``step``, that follow what drives the chain and what it loses."""
        found, within = drive_steps(self._drives, begin, end, step, scheme, tolerance)
        longest = DRIVEN_SHARE * min(within, self._loss_time)
        return replace(found, step=min(found.step, longest))

    @property
    def _drives(self) -> tuple[TimeFunction, ...]:
        """What acts in time: forces, and displacements of walls that move."""
        moved = (wall.displacement for wall in self.moved if wall.displacement is not None)
        return (*(force.value for force in self.outer_forces), *moved)

    def spread_within(self, duration: float) -> int:
        """Cells by which signals run ahead of their speed: dashpots smear their fronts."""
        return math.ceil(SMEARED * self.reach * math.sqrt(self._spreading * duration))

    @property
    def _spreading(self) -> float:
        """A bound of the rates at which dashpots change velocities; 0 without any."""
        total = np.array(self.losses) if self.variation.dashpots else np.zeros(len(self.fields))
        for bond, dashpot in zip(self.bonds, self.dashpots, strict=True):
            stretch = sum(abs(entry.weight) for entry in bond.stretch)
            for entry in bond.action:
                total[entry.field] += (
                    dashpot * stretch * abs(entry.weight) / self.masses[entry.field]
                )
        return float(total.max()) * (1.0 + self.variation.bound) / self.lightest

    def held(self, state: State) -> State:
        """The state on the ring: walls are where they are at that time."""
        more = self.deviations.shape[1] - self.cells
        f, v = (np.pad(values, ((0, 0), (0, more))) for values in state.arrays)
        found = State(state.t, f, v, state.left)
        self.place_walls(found.f, found.v, state.t)
        return found

    def place_walls(self, f: Array, v: Array, t: float | Array, moving: bool = False) -> None:
        """Put the walls' cells where they are at a time, without velocity unless ``moving``.

        With several times these are the last axis but one of the fields.
        """
        times = np.atleast_1d(t)
        for wall in self.walls:
            places = list(wall.places)
            f[..., places], v[..., places] = 0.0, 0.0
            if wall.displacement is not None:
                f[..., places] = values_at(wall.displacement, times)[:, np.newaxis]
                if moving:
                    v[..., places] = values_at(slope_of(wall.displacement), times)[:, np.newaxis]
        for place, beside in self.free:
            f[..., place], v[..., place] = f[..., beside], 0.0

    def stage_weights(
        self, scheme: DriftKick, v: Array, t: float, h: float, steps: int
    ) -> tuple[Array, Array]:
        """Drifts, and for each stage its kick, its damped drifts and its pulses.

        A last drift without a kick ends the last step. Walls that move get the velocity with which
        the first drift takes them to where they are then.
        """
        drifts, kicks = _stages(scheme, h, steps)
        times = t + np.concatenate([[0.0], np.cumsum(drifts)])
        times[-1] = t + steps * h
        spreads = bool(self.variation.dashpots)  # which walls do not feel
        rates = (0.0,) * len(self.fields) if spreads else self.losses
        factors = np.exp(-np.outer(drifts, rates))
        lengths = np.stack([_damped_length(rate, drifts) for rate in rates], axis=1)
        columns = [kicks[:, np.newaxis]]
        if spreads:
            columns.append(_series(drifts))
        elif self.variation.damped:
            columns += [lengths, factors]
        for force in self.outer_forces:
            share = kicks / self.masses[force.field]
            columns.append((share * values_at(force.value, times[1:]))[:, np.newaxis])
        for wall in self.moved:
            assert wall.displacement is not None
            path = values_at(wall.displacement, times)
            for place in range(len(self.fields)):
                speeds = _speeds(path, lengths[:, place])
                v[place, list(wall.places)] = speeds[0]
                kicked = np.append(speeds[1:], 0.0) - factors[:, place] * speeds
                columns.append(kicked[:, np.newaxis])
        for wall in self._pulling:
            speeds = kicks * values_at(slope_of(wall.displacement), times[1:])
            columns.append(np.repeat(speeds[:, np.newaxis], len(self.fields), axis=1))
        return drifts, np.ascontiguousarray(np.concatenate(columns, axis=1))


def _stages(scheme: DriftKick, h: float, steps: int) -> tuple[Array, Array]:
    """Drifts and kicks of all stages; the last drift of a step and the first of the next are one.

    The last stage has no kick.
    """
    drifts = np.tile(scheme.drifts[:-1] * h, steps)
    drifts[scheme.kicks.size :: scheme.kicks.size] += scheme.drifts[-1] * h
    kicks = np.tile(scheme.kicks * h, steps)
    return np.append(drifts, scheme.drifts[-1] * h), np.append(kicks, 0.0)


def _damped_length(rate: float, drifts: Array) -> Array:
    """By how much a unit velocity that shrinks at that rate moves a field in each drift."""
    return drifts if rate == 0.0 else -np.expm1(-rate * drifts) / rate


def _series(drifts: Array) -> Array:
    """What the terms of velocities that spread add to positions, and from the second to velocities.

    (drifts, terms)
    """
    powers = np.arange(1, TERMS + 2)
    series = drifts[:, np.newaxis] ** powers / np.array([math.factorial(p) for p in powers])
    return np.concatenate([series, series[:, :-1]], axis=1)


def _speeds(path: Array, lengths: Array) -> Array:
    """The velocities with which drifts of these lengths go from place to place."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(lengths == 0.0, 0.0, np.diff(path) / lengths)


def driven_chain(
    lattice: NumericLattice,
    cells: int,
    *,
    left: End | None = None,
    right: End | None = None,
    losses: Sequence[float] | float = 0.0,
    dashpots: Sequence[float] | float = 0.0,
    forces: Sequence[SiteForce] = (),
    mass_factors: Factors = MappingProxyType({}),
    spring_factors: Factors = MappingProxyType({}),
) -> DrivenChain:
    """A chain of so many cells with ends, losses and forces, for `lattice.integrate`.

    Without ``left`` and ``right`` it is a ring. Walls stand beside the first and the last cell (and
    hold as many cells as a force reaches). ``losses`` are the factors g of ``-g du/dt`` on each
    field's cells, ``dashpots`` those of the rate of each bond's stretch in a force beside its own.
    ``mass_factors`` say by cells how much heavier these are, ``spring_factors`` by how much the
    forces of single bonds, and of their dashpots, are larger: bond n is from cell n to the next, -1
    from a wall. The fields are displacements. Raises ValueError in one line.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> chain = numeric_lattice(LATTICES["beta_fput"], {"K2": 1, "K4": 2})
    >>> driven_chain(chain, 24, left=lambda t: 0.05 * np.sin(1.3 * t), right="fixed").cells
    24
    """
    rates = _rates("losses", "field", lattice.fields, losses)
    names = [f"bond {number}" for number in range(1, len(lattice.bonds) + 1)]
    pots = _rates("dashpots", "bond", names, dashpots)
    _check_chain(lattice, cells, left, right, forces, bool(mass_factors or spring_factors))
    ends = _ends(lattice, cells, left, right)
    count, ring = len(lattice.fields), ends.cut.shape[1]
    heavier = _heavier(mass_factors, np.ones((count, ring)), cells)
    stiffer = _stiffer(lattice, spring_factors, np.where(ends.cut, 0.0, 1.0), cells)
    each = [bool((row != 1.0).any()) for row in stiffer]
    spreads = any(pots) or (bool(mass_factors) and any(rates))
    parts = zip(lattice.bonds, each, strict=True)
    variation = Variation(
        max(0.0, float(stiffer.max()) - 1.0),
        "displacements" if ends.walls or mass_factors else None,
        tuple(bond.force if some else None for bond, some in parts),
        _pulsed(ends, forces, count, any(pots)),
        tuple(np.divide(rates, lattice.masses).tolist()) if any(rates) or any(pots) else (),
        pots if spreads else (),
        bool(mass_factors) and spreads,
    )
    walls = np.where(np.arange(ring) < cells, 0.0, -1.0)[np.newaxis][: variation.walled]
    varied = [heavier[: variation.mass_rows(count)] - 1.0, stiffer[each] - 1.0, walls]
    return DrivenChain(
        **{item.name: getattr(lattice, item.name) for item in fields(NumericLattice)},
        variation=variation,
        deviations=np.concatenate(varied),
        cells=cells,
        outer_forces=tuple(forces),
        walls=ends.walls,
        free=ends.free,
    )


def _heavier(given: Factors, found: Array, cells: int) -> Array:
    """By how much masses are larger, (fields, ring)."""
    for cell, factor in given.items():
        found[:, cell] = _checked("mass", cell, factor, len(found), 0 <= cell < cells)
    return found


def _stiffer(lattice: NumericLattice, given: Factors, found: Array, cells: int) -> Array:
    """By how much the forces of bonds that are not cut are larger, (bonds, ring)."""
    for number, factor in given.items():
        felt = [
            any(0 <= number + entry.shift[0] < cells for entry in bond.stretch)
            for bond in lattice.bonds
        ]
        factors = _checked("spring", number, factor, len(felt), any(felt))
        found[felt, number % found.shape[1]] *= factors[felt]
    return found


def _checked(
    name: str, number: int, given: float | Sequence[float], count: int, is_there: bool
) -> Array:
    """The factors of a defect for each field or bond."""
    found = np.array(given, dtype=np.float64)
    if not is_there:
        raise ValueError(f"{name} factors must be of cells and bonds of the chain, got {number}")
    is_positive = (found >= 0.0) & (found < math.inf) & ((found > 0.0) | (name == "spring"))
    if found.shape not in ((), (count,)) or not is_positive.all():
        raise ValueError(
            f"{name} factors must be positive, one or {count}, got {given} for {number} (1 is as "
            "everywhere; a spring's may be 0)"
        )
    return np.broadcast_to(found, (count,))


def _pulsed(ends: _Ends, forces: Sequence[SiteForce], count: int, pulls: bool) -> tuple[Pulse, ...]:
    """What each pulse is: of forces, of walls that move, of what pulls beside them."""
    moved = sum(wall.displacement is not None for wall in ends.walls)
    walls = [(place, None) for place in range(count)] * (2 * moved if pulls else moved)
    return (*((force.field, force.law) for force in forces), *walls)


def _rates(
    name: str, each: str, names: Sequence[str], given: Sequence[float] | float
) -> tuple[float, ...]:
    """A rate for each field or bond."""
    rates = (given,) * len(names) if isinstance(given, int | float) else tuple(given)
    if len(rates) != len(names) or not all(0.0 <= rate < math.inf for rate in rates):
        raise ValueError(
            f"{name} must be a rate of 0 or more for each {each}, got {given} (there are "
            f"{', '.join(names)})"
        )
    return tuple(float(rate) for rate in rates)


def _check_chain(
    lattice: NumericLattice,
    cells: int,
    left: End | None,
    right: End | None,
    forces: Sequence[SiteForce],
    has_defects: bool,
) -> None:
    acted = left is not None or bool(forces) or has_defects
    if lattice.dimension != 1 or (acted and not lattice.conserves_energy):
        raise ValueError(
            f"ends, losses and forces must be of a chain of displacements, got {lattice.name} "
            "(strains have no masses of their own; take the chain in displacements)"
        )
    if lattice.cellwise[1] is not None:
        raise ValueError(
            f"lattice must be ordered, got {lattice.name} with disorder (leave it out)"
        )
    if not isinstance(cells, int) or cells < max(2, lattice.reach):
        raise ValueError(
            f"cells must be at least {max(2, lattice.reach)}, got {cells} (so far does a force "
            f"of {lattice.name} reach)"
        )
    for name, end in (("left", left), ("right", right)):
        if (left is None) != (right is None) or not (
            end is None or end in ("fixed", "free") or callable(end)
        ):
            raise ValueError(
                f"{name} must be 'fixed', 'free' or a displacement in time, got {end!r} (give both "
                "ends, or none for a ring)"
            )
    for force in forces:
        force.check(cells, len(lattice.fields))


class _Ends(NamedTuple):
    """The walls, the cells that stand for none, and which bonds are ``cut``, (bonds, ring)."""

    walls: tuple[_Wall, ...]
    free: tuple[tuple[int, int], ...]
    cut: NDArray[np.bool_]


def _ends(lattice: NumericLattice, cells: int, left: End | None, right: End | None) -> _Ends:
    """Two fixed ends are held by the same cells of the ring, others by cells of their own."""
    bonds, reach = len(lattice.bonds), lattice.reach
    if left is None:
        return _Ends((), (), np.zeros((bonds, cells), dtype=np.bool_))
    upper = tuple(range(cells, cells + reach))
    if left == right == "fixed":
        return _Ends((_Wall(upper, None),), (), np.zeros((bonds, cells + reach), dtype=np.bool_))
    lower = tuple(range(cells + reach, cells + 2 * reach))
    walls, free = [], []
    for places, end, beside in ((lower, left, 0), (upper, right, cells - 1)):
        if end == "free":
            free += [(place, beside) for place in places]
        else:
            walls.append(_Wall(places, end if callable(end) else None))
    cut = np.zeros((bonds, cells + 2 * reach), dtype=np.bool_)
    for place, bond in enumerate(lattice.bonds):
        for cell in range(-reach, cells + reach):
            met = [cell + entry.shift[0] for entry in bond.stretch]
            cut[place, cell] = (
                not any(0 <= at < cells for at in met)
                or (left == "free" and min(met) < 0)
                or (right == "free" and max(met) >= cells)
            )
    return _Ends(tuple(walls), tuple(free), cut)

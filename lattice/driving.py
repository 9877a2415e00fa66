"""Driven chains: a chain with ends, losses and external forces.

The ring holds the moving cells, then the cells of the walls, which are fixed or driven. A drift is
the flow of ``u' = v, v' = -G v``, where G contains the losses of cells and dashpots. It is linear
in v, so a splitting of Nystroem type keeps its order. External forces are evaluated at the time of
each kick.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np

from longwave.lattice.disordered_lattice import DisorderedLattice, energy_and_force_at
from longwave.lattice.drive_steps import drive_steps
from longwave.lattice.kernels.streams import DASHPOT_TERMS
from longwave.lattice.numeric_lattice import DriveSteps, NumericLattice, Range, value_range
from longwave.lattice.outer_forces import (
    SiteForce,
    TimeFunction,
    shortest_time_scale,
    slope_of,
    values_at,
)
from longwave.lattice.schemes import DriftKick, Scheme
from longwave.lattice.state import State
from longwave.lattice.trial import DRIVEN_SHARE
from longwave.lattice.variation import Pulse, Variation
from longwave.support.real_arrays import Array, Mask

Factors = Mapping[int, float | Sequence[float]]
"""Factors keyed by cell or bond number: one for all fields (or bonds) of that cell, or one each."""

End = Literal["fixed", "free"] | TimeFunction
"""Boundary condition: a fixed wall, a free end, or a wall with a displacement in time."""


DASHPOT_TIME = 0.8
"""Twice the longest step, times the rate of dashpots: the longest drift, a quarter of a step, then
changes velocities by 0.1 (`kernels.streams.DASHPOT_TERMS`)."""

SMEARING_DEVIATIONS = 3.5
"""Dashpots smear a front to a Gaussian; half the number of its standard deviations that are kept
(1e-12 lies beyond). Its variance for nearest neighbours grows at the rate of their dashpots, a
quarter of `DrivenChain._spreading`."""

LOSS_TIME = 20.0
"""Twice the longest step, times the loss rate of cells: stages that go back in time then amplify
velocities by less than exp(10), far from overflow."""


@dataclass(frozen=True)
class _Wall:
    """One wall: ``places``, the ring indices of its cells, and ``displacement`` (None if fixed)."""

    places: tuple[int, ...]
    displacement: TimeFunction | None


@dataclass(frozen=True, eq=False)
class DrivenChain(DisorderedLattice):
    """A chain built by `driven_chain`: ``cells`` moving cells, then the cells of its walls."""

    cells: int
    outer_forces: tuple[SiteForce, ...]
    walls: tuple[_Wall, ...]
    free: tuple[tuple[int, int], ...]
    """Cells of the ring beyond a free end, each with the chain's cell that it copies."""

    @property
    def losses(self) -> tuple[float, ...]:
        """Decay rate of each field's velocity."""
        return self.variation.damped or (0.0,) * len(self.fields)

    @property
    def dashpots(self) -> tuple[float, ...]:
        """Dashpot coefficient of each bond: force per rate of stretch."""
        return self.variation.dashpots or (0.0,) * len(self.bonds)

    @property
    def shares(self) -> Array:
        """Rows for the kernel: deviations of inverse masses, of forces, and weights of pulses.

        Deviations are relative. Walls have the inverse mass 0, so that nothing moves them; a cut
        bond has the deviation -1.
        """
        shares = super().shares
        rows, forces = self.variation.mass_rows(len(self.fields)), self.outer_forces
        shares[:rows, self.cells :] = -1.0
        inverse = 1.0 + shares[:rows] if rows else np.ones((len(self.fields), shares.shape[1]))
        wall_places = [wall.places for wall in self.moved for _ in self.fields]
        pulses = np.zeros((len(forces) + len(wall_places), shares.shape[1]))
        for row, force in zip(pulses, forces, strict=False):
            masses = self.cell_masses[force.field, : self.cells]
            row[: self.cells] = inverse[force.field, : self.cells] * force.shares(masses)
        for row, indices in zip(pulses[len(forces) :], wall_places, strict=True):
            row[list(indices)] = 1.0
        wall_pulls = [self._drag(wall) * inverse for wall in self._dragging_walls]
        return np.concatenate([shares, pulses, *wall_pulls])

    @property
    def _dragging_walls(self) -> list[_Wall]:
        """Moving walls whose velocity acts on the chain through dashpots."""
        return self.moved if any(self.dashpots) else []

    def _drag(self, wall: _Wall) -> Array:
        """Return accelerations of nominal masses, (fields, ring), by dashpots of a moving wall.

        The wall has unit velocity.
        """
        unit = np.zeros((len(self.fields), self.deviations.shape[1]))
        unit[:, list(wall.places)] = 1.0
        return self.acceleration_by(self.dashpot_forces(unit))

    def dashpot_forces(self, v: Array) -> list[Array]:
        """Return the force of each bond's dashpot, cell by cell."""
        parts = zip(self.bonds, self.dashpots, self.bond_shares, strict=True)
        return [
            share * (dashpot * (bond.stretched(v) - bond.offset)) for bond, dashpot, share in parts
        ]

    @property
    def lightest(self) -> float:
        """Smallest mass of a moving cell, in units of its field's nominal mass; at most 1."""
        masses = self.deviations[: self.variation.mass_rows(len(self.fields)), : self.cells]
        return 1.0 + min(0.0, float(masses.min(initial=0.0)))

    @property
    def cell_masses(self) -> Array:
        """Mass of each field in each cell; 0 for walls, which carry no kinetic energy."""
        masses = super().cell_masses.copy()
        masses[:, self.cells :] = 0.0
        return masses

    def energy(self, f: Array, v: Array) -> float:
        """Return the energy of cells and bonds, including the work of forces at zero stretch."""
        energy = super().energy(f, v)
        for bond, share in zip(self.bonds, self.bond_shares, strict=True):
            _, rest_force = energy_and_force_at(bond.force, 0.0)
            if rest_force:
                energy += rest_force * float(np.sum(share * bond.stretched(f)))
        return energy

    @property
    def bond_shares(self) -> Array:
        """Relative stiffness of each bond in each cell, (bonds, ring): 1 as usual, 0 where cut."""
        ones = np.ones(self.deviations.shape[1])
        return np.array([ones if part is None else ones + part[1] for part in self._varied_parts()])

    @cached_property
    def _cuts(self) -> list[Mask | None]:
        """Mask of the cells in which each bond is cut; None for a bond that is cut nowhere."""
        cuts = self.bond_shares == 0.0
        return [cut if cut.any() else None for cut in cuts]

    def stretches(self, f: Array) -> list[Array]:
        """Return the stretch of each bond in each cell; where it is cut, the bond's ``offset``."""
        stretches = super().stretches(f)
        for index, (bond, cut) in enumerate(zip(self.bonds, self._cuts, strict=True)):
            if cut is not None:
                stretches[index] = np.where(cut, bond.offset, stretches[index])
        return stretches

    def stretch_ranges(self, f: Array, ranges: Sequence[Range]) -> list[Range]:
        """Return the least and largest stretch of each bond; where it is cut, `offset` counts."""
        if not any(cut is not None for cut in self._cuts):
            return super().stretch_ranges(f, ranges)
        return [value_range(stretch) for stretch in self.stretches(f)]

    @property
    def cell_count(self) -> int | None:
        """Number of moving cells."""
        return self.cells

    @property
    def exchanges_energy(self) -> bool:
        """Whether losses or external forces change the energy."""
        return bool(self.variation.damped or self.variation.pulsed)

    @property
    def is_driven(self) -> bool:
        """Whether the chain has a free end, a loss, a force or a moving wall."""
        return bool(self.exchanges_energy or self.free)

    @property
    def moved(self) -> list[_Wall]:
        """Walls whose displacement is a function of time."""
        return [wall for wall in self.walls if wall.displacement is not None]

    @property
    def drivers(self) -> tuple[str, ...]:
        """Names of the moving walls and forces that do work on the chain."""
        sides = ["right" if wall.places[0] == self.cells else "left" for wall in self.moved]
        forces = [f"force {count}" for count in range(1, len(self.outer_forces) + 1)]
        return (*(f"{side} wall" for side in sides), *forces)

    def drive_within(self, begin: float, end: float) -> tuple[float, bool]:
        """Return the shortest time scale of drives and losses, and whether a drive has corners."""
        shortest, turns = shortest_time_scale(self._drives, begin, end)
        return min(shortest, self._loss_time), turns

    @property
    def _loss_time(self) -> float:
        """Time scale of losses and dashpots: twice the longest step that they allow."""
        time = LOSS_TIME / max(self.losses) if any(self.losses) else math.inf
        return min(time, DASHPOT_TIME / self._spreading) if self._spreading else time

    def drive_steps(
        self, begin: float, end: float, step: float, scheme: Scheme, tolerance: float
    ) -> DriveSteps:
        """Return steps, none longer than ``step``, that resolve the drives and losses."""
        steps, time_scale = drive_steps(self._drives, begin, end, step, scheme, tolerance)
        longest = DRIVEN_SHARE * min(time_scale, self._loss_time)
        return replace(steps, step=min(steps.step, longest))

    @property
    def _drives(self) -> tuple[TimeFunction, ...]:
        """All functions of time: forces, and displacements of moving walls."""
        moved = (wall.displacement for wall in self.moved if wall.displacement is not None)
        return (*(force.value for force in self.outer_forces), *moved)

    def spread_within(self, duration: float) -> int:
        """Return the number of cells by which dashpots smear a front within ``duration``."""
        return math.ceil(SMEARING_DEVIATIONS * self.reach * math.sqrt(self._spreading * duration))

    @property
    def _spreading(self) -> float:
        """Upper bound of the rates at which dashpots change velocities; 0 without dashpots."""
        total = np.array(self.losses) if self.variation.dashpots else np.zeros(len(self.fields))
        for bond, drag in zip(self.bonds, self.dashpots, strict=True):
            stretch = sum(abs(entry.weight) for entry in bond.stretch)
            for entry in bond.action:
                total[entry.field] += drag * stretch * abs(entry.weight) / self.masses[entry.field]
        return float(total.max()) * (1.0 + self.variation.bound) / self.lightest

    def with_walls(self, state: State) -> State:
        """Return the state with the cells of walls appended, at their positions at ``state.t``."""
        wall_cells = self.deviations.shape[1] - self.cells
        f, v = (np.pad(values, ((0, 0), (0, wall_cells))) for values in state.arrays)
        padded = State(state.t, f, v, state.left)
        self.place_walls(padded.f, padded.v, state.t)
        return padded

    def place_walls(self, f: Array, v: Array, t: float | Array, moving: bool = False) -> None:
        """Set the walls' cells, in place, to their positions at time ``t``.

        Their velocities are set to 0 unless ``moving``. Several times ``t`` run along the last axis
        but one of ``f`` and ``v``.
        """
        times = np.atleast_1d(t)
        for wall in self.walls:
            indices = list(wall.places)
            f[..., indices], v[..., indices] = 0.0, 0.0
            if wall.displacement is not None:
                f[..., indices] = values_at(wall.displacement, times)[:, np.newaxis]
                if moving:
                    v[..., indices] = values_at(slope_of(wall.displacement), times)[:, np.newaxis]
        for index, neighbour in self.free:
            f[..., index], v[..., index] = f[..., neighbour], 0.0

    def stage_weights(
        self, scheme: DriftKick, v: Array, t: float, h: float, steps: int
    ) -> tuple[Array, Array]:
        """Return the drifts and a row of weights for each stage of ``steps`` steps.

        A row has the kick, then the damped drifts or the series of the dashpots, then the pulses. A
        last drift without a kick ends the last step. Velocities of moving walls are set, in ``v``,
        so that the first drift takes the walls to their positions after it.
        """
        drifts, kicks = _stages(scheme, h, steps)
        times = t + np.concatenate([[0.0], np.cumsum(drifts)])
        times[-1] = t + steps * h
        spreads = bool(self.variation.dashpots)  # which walls do not feel
        rates = (0.0,) * len(self.fields) if spreads else self.losses
        factors = np.exp(-np.outer(drifts, rates))
        # distances that unit velocities, decaying at these rates, cover in each drift
        lengths = [-np.expm1(-rate * drifts) / rate if rate else drifts for rate in rates]
        columns = [kicks[:, np.newaxis]]
        if spreads:
            columns.append(_series(drifts))
        elif self.variation.damped:
            columns += [np.stack(lengths, axis=1), factors]
        for force in self.outer_forces:
            share = kicks / self.masses[force.field]
            columns.append((share * values_at(force.value, times[1:]))[:, np.newaxis])
        for wall in self.moved:
            assert wall.displacement is not None
            path = values_at(wall.displacement, times)
            for index in range(len(self.fields)):
                speeds = _speeds(path, lengths[index])
                v[index, list(wall.places)] = speeds[0]
                changes = np.append(speeds[1:], 0.0) - factors[:, index] * speeds
                columns.append(changes[:, np.newaxis])
        for wall in self._dragging_walls:
            speeds = kicks * values_at(slope_of(wall.displacement), times[1:])
            columns.append(np.repeat(speeds[:, np.newaxis], len(self.fields), axis=1))
        return drifts, np.ascontiguousarray(np.concatenate(columns, axis=1))


def _stages(scheme: DriftKick, h: float, steps: int) -> tuple[Array, Array]:
    """Return the drifts and kicks of all steps; adjacent drifts are merged, the last kick is 0."""
    drifts = np.tile(scheme.drifts[:-1] * h, steps)
    drifts[scheme.kicks.size :: scheme.kicks.size] += scheme.drifts[-1] * h
    kicks = np.tile(scheme.kicks * h, steps)
    return np.append(drifts, scheme.drifts[-1] * h), np.append(kicks, 0.0)


def _series(drifts: Array) -> Array:
    """Return dashpot series (drifts, terms): factors for positions, then for velocities."""
    powers = np.arange(1, DASHPOT_TERMS + 2)
    series = drifts[:, np.newaxis] ** powers / np.array([math.factorial(p) for p in powers])
    return np.concatenate([series, series[:, :-1]], axis=1)


def _speeds(path: Array, lengths: Array) -> Array:
    """Return the increments of ``path`` divided by ``lengths``; 0 where a length is 0."""
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
    """Return a chain of ``cells`` cells with ends, losses and forces, for `lattice.integrate`.

    Without ``left`` and ``right`` the chain is a ring. Otherwise walls are added next to the first
    and the last cell; each has as many cells as a force reaches. ``losses`` are the factors g of
    ``-g du/dt`` on each field's cells; ``dashpots`` are the coefficients of each bond's rate of
    stretch in an additional force. ``mass_factors`` multiply masses of cells, ``spring_factors``
    forces of bonds and dashpots. Bond n joins cells n and n + 1; bond -1 joins a wall and cell 0.
    The fields must be displacements. Raises ValueError for arguments that do not fit.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> chain = numeric_lattice(LATTICES["beta_fput"], {"K2": 1, "K4": 2})
    >>> driven_chain(chain, 24, left=lambda t: 0.05 * np.sin(1.3 * t), right="fixed").cells
    24
    """
    rates = _rates("losses", "field", lattice.fields, losses)
    names = [f"bond {number}" for number in range(1, len(lattice.bonds) + 1)]
    dashpot_rates = _rates("dashpots", "bond", names, dashpots)
    _check_chain(lattice, cells, left, right, forces, bool(mass_factors or spring_factors))
    ends = _ends(lattice, cells, left, right)
    count, ring = len(lattice.fields), ends.cut.shape[1]
    masses = _mass_factors(mass_factors, np.ones((count, ring)), cells)
    springs = _bond_factors(lattice, spring_factors, np.where(ends.cut, 0.0, 1.0), cells)
    is_varied = [bool((row != 1.0).any()) for row in springs]
    is_lossy = any(rates) or any(dashpot_rates)
    has_drag = any(dashpot_rates) or (bool(mass_factors) and any(rates))
    variation = Variation(
        max(0.0, float(springs.max()) - 1.0),
        "displacements" if ends.walls or mass_factors else None,
        tuple(b.force if v else None for b, v in zip(lattice.bonds, is_varied, strict=True)),
        _pulses(ends, forces, count, any(dashpot_rates)),
        tuple(np.divide(rates, lattice.masses).tolist()) if is_lossy else (),
        dashpot_rates if has_drag else (),
        bool(mass_factors) and has_drag,
    )
    walls = np.where(np.arange(ring) < cells, 0.0, -1.0)[np.newaxis][: variation.walled]
    varied = [masses[: variation.mass_rows(count)] - 1.0, springs[is_varied] - 1.0, walls]
    return DrivenChain(
        **{item.name: getattr(lattice, item.name) for item in fields(NumericLattice)},
        variation=variation,
        deviations=np.concatenate(varied),
        cells=cells,
        outer_forces=tuple(forces),
        walls=ends.walls,
        free=ends.free,
    )


def _mass_factors(given: Factors, factors: Array, cells: int) -> Array:
    """Write the ``given`` mass factors into the array ``factors``, (fields, ring); return it."""
    for cell, factor in given.items():
        factors[:, cell] = _checked_factors("mass", cell, factor, len(factors), 0 <= cell < cells)
    return factors


def _bond_factors(lattice: NumericLattice, given: Factors, factors: Array, cells: int) -> Array:
    """Multiply ``factors``, (bonds, ring), by the ``given`` ones of each bond; cut bonds stay 0."""
    for number, factor in given.items():
        present = [
            any(0 <= number + entry.shift[0] < cells for entry in bond.stretch)
            for bond in lattice.bonds
        ]
        values = _checked_factors("spring", number, factor, len(present), any(present))
        factors[present, number % factors.shape[1]] *= values[present]
    return factors


def _checked_factors(
    name: str, number: int, given: float | Sequence[float], count: int, is_there: bool
) -> Array:
    """Return the factors of one cell's fields or bonds; raise ValueError if one is invalid."""
    factors = np.array(given, dtype=np.float64)
    if not is_there:
        raise ValueError(f"{name} factors must be within the chain, got {number} (0 is its first)")
    is_positive = (factors >= 0.0) & (factors < math.inf) & ((factors > 0.0) | (name == "spring"))
    if factors.shape not in ((), (count,)) or not is_positive.all():
        least = ">= 0" if name == "spring" else "> 0"
        raise ValueError(
            f"{name} factors must be {least}, one number or {count}, got {given} at {number} "
            "(1 changes nothing)"
        )
    return np.broadcast_to(factors, (count,))


def _pulses(ends: _Ends, forces: Sequence[SiteForce], count: int, pulls: bool) -> tuple[Pulse, ...]:
    """Return the pulses of forces, of moving walls (one for each field), and of dragging walls."""
    moved = sum(wall.displacement is not None for wall in ends.walls)
    walls = [(index, None) for index in range(count)] * (2 * moved if pulls else moved)
    return (*((force.field, force.law) for force in forces), *walls)


def _rates(
    name: str, item: str, names: Sequence[str], given: Sequence[float] | float
) -> tuple[float, ...]:
    """Return one rate for each field or bond; raise ValueError if the ``given`` ones do not fit."""
    rates = (given,) * len(names) if isinstance(given, int | float) else tuple(given)
    if len(rates) != len(names) or not all(0.0 <= rate < math.inf for rate in rates):
        raise ValueError(
            f"{name} must be a rate of 0 or more for each {item}, got {given} (there are "
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
    """Raise ValueError if the arguments of `driven_chain` do not fit the lattice."""
    is_modified = left is not None or bool(forces) or has_defects
    if lattice.dimension != 1 or (is_modified and not lattice.conserves_energy):
        raise ValueError(
            f"ends, losses and forces need a chain of displacements, got {lattice.name} "
            "(strains have no masses of their own; take the chain in displacements)"
        )
    if lattice.cellwise[1] is not None:
        raise ValueError(f"lattice must be ordered, got disorder in {lattice.name} (leave it out)")
    if not isinstance(cells, int) or cells < max(2, lattice.reach):
        raise ValueError(
            f"cells must be at least {max(2, lattice.reach)}, got {cells} (the reach of the "
            f"forces of {lattice.name})"
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
    """Ends: walls, free cells with the cells they copy, and the mask ``cut`` of bonds."""

    walls: tuple[_Wall, ...]
    free: tuple[tuple[int, int], ...]
    cut: Mask


def _ends(lattice: NumericLattice, cells: int, left: End | None, right: End | None) -> _Ends:
    """Build the chain's ends. Two fixed ends share wall cells; otherwise each end has its own."""
    bonds, reach = len(lattice.bonds), lattice.reach
    if left is None:
        return _Ends((), (), np.zeros((bonds, cells), dtype=np.bool_))
    upper = tuple(range(cells, cells + reach))
    if left == right == "fixed":
        return _Ends((_Wall(upper, None),), (), np.zeros((bonds, cells + reach), dtype=np.bool_))
    lower = tuple(range(cells + reach, cells + 2 * reach))
    walls, free = [], []
    for indices, end, neighbour in ((lower, left, 0), (upper, right, cells - 1)):
        if end == "free":
            free += [(index, neighbour) for index in indices]
        else:
            walls.append(_Wall(indices, end if callable(end) else None))
    cut = np.zeros((bonds, cells + 2 * reach), dtype=np.bool_)
    for index, bond in enumerate(lattice.bonds):
        for cell in range(-reach, cells + reach):
            cells_of_bond = [cell + entry.shift[0] for entry in bond.stretch]
            cut[index, cell] = (
                not any(0 <= at < cells for at in cells_of_bond)
                or (left == "free" and min(cells_of_bond) < 0)
                or (right == "free" and max(cells_of_bond) >= cells)
            )
    return _Ends(tuple(walls), tuple(free), cut)

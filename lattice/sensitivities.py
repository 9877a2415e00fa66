"""What sensors on a driven chain read, with the derivatives by parameters of its forces and losses.

The stages of the lattice's own splitting are done by NumPy, each with its derivative (the first
variation of the flow): the run is that of the compiled kernel, and its derivatives are exact but
for rounding; nothing is differenced. All arrays hold the value in their first column, then its
derivative by each parameter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from longwave.lattice.driving import DrivenChain
from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import Entry
from longwave.lattice.outer_forces import TimeFunction
from longwave.lattice.schemes import REDUCED_PHASE_6, DriftKick
from longwave.lattice.state import State

Array = NDArray[np.float64]

NEGLIGIBLE = 1e-17
"""The first term of a drift's series that is left out, in units of its velocities."""

SMALL = 256
"""Numbers of a state up to which a matrix is faster as it stands than a sparse one."""


@dataclass(frozen=True)
class FreeParameter:
    """What a unit of it adds to each bond's force, to masses, and to the factors of losses."""

    forces: tuple[ForceProgram | None, ...]
    masses: tuple[float, ...]
    losses: tuple[float, ...]
    dashpots: tuple[float, ...]


@dataclass(frozen=True)
class Sensor:
    """What is read (displacement, velocity, strain or force), in which field or bond and cell."""

    quantity: str
    inner: int
    cell: int


class VariedChain:
    """A chain and its derivatives by ``parameters``."""

    def __init__(self, chain: DrivenChain, parameters: Sequence[FreeParameter]) -> None:
        self._chain, self._parameters = chain, parameters
        self._ring = chain.deviations.shape[1]
        fields, bonds = len(chain.fields), len(chain.bonds)
        masses = chain.cell_masses.ravel()
        self._inverse = np.divide(1.0, masses, out=np.zeros_like(masses), where=masses > 0.0)
        self._pushes = []
        for force in chain.outer_forces:
            at = force.field * self._ring + np.arange(chain.cells)
            shares = force.shares(masses[at]) * self._inverse[at]
            [cells] = np.nonzero(shares)
            self._pushes.append((at[cells], shares[cells], force.law))
        self._kept = chain.bond_shares.ravel()
        stretch = self._matrix([bond.stretch for bond in chain.bonds], fields, 1)
        self._stretch = sparse.diags((self._kept != 0.0).astype(np.float64)) @ stretch
        action = self._matrix([bond.action for bond in chain.bonds], fields, -1).T
        self._action = sparse.diags(self._inverse) @ action @ sparse.diags(self._kept)
        heavier = [np.divide(one.masses, chain.masses) for one in parameters]
        self._heavier = self._columns(heavier, fields)
        self._pots = self._columns([chain.dashpots, *(one.dashpots for one in parameters)], bonds)
        rates = self._columns([one.losses for one in parameters], fields)
        own = self._columns([np.multiply(chain.losses, chain.masses)], fields)[:, 0]
        self._drag = sparse.diags(own * self._inverse) - self._damped(self._pots[:, 0])
        drags = [
            sparse.diags(rates[:, place] * self._inverse)
            - self._damped(self._pots[:, place + 1])
            - sparse.diags(self._heavier[:, place]) @ self._drag
            for place in range(len(parameters))
        ]
        self._drags = sparse.vstack([self._drag, *drags]).tocsr()
        self._fastest = float(abs(self._drag).sum(axis=1).max())
        self._is_damped = bool(abs(self._drags).sum())
        if masses.size <= SMALL:
            for name in ("_stretch", "_action", "_drag", "_drags"):
                setattr(self, name, getattr(self, name).toarray())

    def _matrix(self, parts: Sequence[Sequence[Entry]], fields: int, sign: int) -> sparse.csr_array:
        """The sum that each bond is of fields, (bonds * ring, fields * ring)."""
        cells = np.arange(self._ring)
        rows, columns, weights = [], [], []
        for bond, entries in enumerate(parts):
            for entry in entries:
                rows.append(bond * self._ring + cells)
                met = (cells + sign * entry.shift[0]) % self._ring
                columns.append(entry.field * self._ring + met)
                weights.append(np.full(self._ring, entry.weight))
        at = (np.concatenate(rows), np.concatenate(columns))
        shape = (len(parts) * self._ring, fields * self._ring)
        return sparse.csr_array((np.concatenate(weights), at), shape)

    def _columns(self, rows: Sequence[ArrayLike], count: int) -> Array:
        """Numbers of fields or bonds in all cells, (count * ring, rows)."""
        return np.repeat(np.reshape(np.array(rows), (len(rows), count)), self._ring, axis=1).T

    def _damped(self, dashpots: Array) -> sparse.csr_array:
        return self._action @ sparse.diags(dashpots) @ self._stretch

    def readings(
        self,
        state: State,
        times: Array,
        step: float,
        sensors: Sequence[Sensor],
        scheme: DriftKick = REDUCED_PHASE_6,
    ) -> Array:
        """What the sensors read at all times, (times, sensors, 1 + parameters).

        Steps are at most ``step`` long, and equal between two times, as in `lattice.integrate`.
        """
        held = self._chain.held(state)
        u, v = np.zeros((2, held.f.size, 1 + len(self._parameters)))
        u[:, 0], v[:, 0] = held.f.ravel(), held.v.ravel()
        found, begin = np.empty((times.size, len(sensors), u.shape[1])), state.t
        for place, t in enumerate(times.tolist()):
            steps = math.ceil((t - begin) / step * (1.0 - 1e-12))
            if steps:
                self._advance(u, v, scheme, begin, (t - begin) / steps, steps)
            found[place] = list(self._read(u, v, t, sensors))
            begin = t
        return found

    def _advance(
        self, u: Array, v: Array, scheme: DriftKick, t: float, h: float, steps: int
    ) -> None:
        """Advance in place."""
        drifts, kicks = scheme.drifts * h, scheme.kicks * h
        starts = t + h * np.arange(steps)[:, np.newaxis]
        moments: Array = np.asarray(starts + np.cumsum(drifts[:-1]), dtype=np.float64).reshape(-1)
        places, rates = np.zeros((2, moments.size, len(u)))
        pushes = [force.value(moments) for force in self._chain.outer_forces]
        walls = self._walls()
        for at, path in walls:
            places[:, at] = np.reshape(path(moments), (-1, 1))
            if self._pots.any():
                rates[:, at] = np.reshape(path.slope(moments), (-1, 1))  # type: ignore[attr-defined]
        for number in range(moments.size):
            stage = number % kicks.size
            self._drift(u, v, drifts[stage])
            for at, _ in walls:
                u[at, 0] = places[number, at]
            pushed = [values[number] for values in pushes]
            v += kicks[stage] * self._acceleration(u, pushed, rates[number])
            if stage == kicks.size - 1:
                self._drift(u, v, drifts[-1])

    def _walls(self) -> list[tuple[list[int], TimeFunction]]:
        """The places of walls that move, and how."""
        fields = range(len(self._chain.fields))
        return [
            ([field * self._ring + place for field in fields for place in wall.places], path)
            for wall in self._chain.walls
            if (path := wall.displacement) is not None
        ]

    def _drift(self, u: Array, v: Array, length: float) -> None:
        """The flow of ``u' = v, v' = -G v`` by its series."""
        u += length * v
        term, weight = v, length
        for power in range(2, self._terms(length) + 2):
            turned = (self._drags @ term[:, 0]).reshape(-1, len(u)).T
            turned[:, 1:] += self._drag @ term[:, 1:]
            term = -turned
            v += weight * term
            weight *= length / power
            u += weight * term

    def _terms(self, length: float) -> int:
        """The terms of a drift's series that are not negligible."""
        count, bound = int(self._is_damped), self._fastest * abs(length)
        size = bound
        while size > NEGLIGIBLE:
            count += 1
            size *= bound / count
        return count

    def _acceleration(self, u: Array, pushed: Sequence[float], rates: Array) -> Array:
        forces = self._forces(self._stretch @ u)
        if rates.any():
            forces += self._pots * (self._stretch @ rates)[:, np.newaxis]
        found = self._action @ forces
        for value, (rows, shares, law) in zip(pushed, self._pushes, strict=True):
            own = u[rows]
            found[rows, 0] += value * shares * (1.0 if law is None else law(own[:, 0]))
            if law is not None:
                slopes = value * shares * law.slope(own[:, 0])
                found[rows, 1:] += slopes[:, np.newaxis] * own[:, 1:]
        found[:, 1:] -= self._heavier * found[:, :1]
        return np.asarray(found)

    def _forces(self, stretches: Array) -> Array:
        """The bonds' forces and their derivatives, (bonds * ring, 1 + parameters)."""
        found = np.empty_like(stretches)
        for place, bond in enumerate(self._chain.bonds):
            rows = slice(place * self._ring, (place + 1) * self._ring)
            x = stretches[rows, 0]
            found[rows, 0] = bond.force(x)
            found[rows, 1:] = bond.force.slope(x)[:, np.newaxis] * stretches[rows, 1:]
            for column, parameter in enumerate(self._parameters, 1):
                added = parameter.forces[place]
                if added is not None:
                    found[rows, column] += added(x)
        return found

    def _read(self, u: Array, v: Array, t: float, sensors: Sequence[Sensor]) -> Iterator[Array]:
        u = u.copy()
        for at, path in self._walls():
            u[at, 0] = path(np.array([t]))
        for free, beside in self._chain.free:
            u[free :: self._ring] = u[beside :: self._ring]
        stretches = self._stretch @ u
        held = {
            "displacement": u,
            "velocity": v,
            "strain": stretches,
            "force": self._forces(stretches) * self._kept[:, np.newaxis],
        }
        for sensor in sensors:
            yield held[sensor.quantity][sensor.inner * self._ring + sensor.cell]

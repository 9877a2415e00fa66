"""Readings of sensors on a driven chain, and their derivatives by parameters of forces and losses.

The stages of the lattice's own splitting are done in NumPy, each with its derivative (the first
variation of the flow). The run equals that of the compiled kernel, and the derivatives are exact to
rounding; there are no finite differences. All arrays hold the value in their first column, then its
derivative by each parameter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from longwave.lattice.driving import DrivenChain
from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import Entry
from longwave.lattice.outer_forces import TimeFunction
from longwave.lattice.schemes import REDUCED_PHASE_6, DriftKick
from longwave.lattice.state import State
from longwave.support.real_arrays import Array

NEGLIGIBLE_TERM = 1e-17
"""Size, relative to the velocities, below which terms of a drift's series are neglected."""

SMALL = 256
"""Largest number of values in a state for which dense matrices are faster than sparse ones."""


@dataclass(frozen=True)
class FreeParameter:
    """Derivatives of bond forces, masses, losses and dashpot coefficients by one parameter."""

    forces: tuple[ForceProgram | None, ...]
    masses: tuple[float, ...]
    losses: tuple[float, ...]
    dashpots: tuple[float, ...]


@dataclass(frozen=True)
class Sensor:
    """Measured ``quantity`` (such as "strain"), ``index`` of its field or bond, and ``cell``."""

    quantity: str
    inner: int
    cell: int


class VariedChain:
    """A driven chain with the derivatives of its motion by ``parameters``."""

    def __init__(self, chain: DrivenChain, parameters: Sequence[FreeParameter]) -> None:
        self._chain, self._parameters = chain, parameters
        self._ring = chain.deviations.shape[1]
        fields, bonds = len(chain.fields), len(chain.bonds)
        masses = chain.cell_masses.ravel()
        self._inverse = np.divide(1.0, masses, out=np.zeros_like(masses), where=masses > 0.0)
        self._force_weights = []
        for force in chain.outer_forces:
            at = force.field * self._ring + np.arange(chain.cells)
            shares = force.shares(masses[at]) * self._inverse[at]
            [cells] = np.nonzero(shares)
            self._force_weights.append((at[cells], shares[cells], force.law))
        self._bond_shares = chain.bond_shares.ravel()
        stretch = self._matrix([bond.stretch for bond in chain.bonds], fields, 1)
        self._stretch = sparse.diags((self._bond_shares != 0.0).astype(np.float64)) @ stretch
        action = self._matrix([bond.action for bond in chain.bonds], fields, -1).T
        self._action = sparse.diags(self._inverse) @ action @ sparse.diags(self._bond_shares)
        mass_changes = [np.divide(one.masses, chain.masses) for one in parameters]
        self._mass_changes = self._columns(mass_changes, fields)
        self._dashpots = self._columns([chain.dashpots, *(p.dashpots for p in parameters)], bonds)
        rates = self._columns([one.losses for one in parameters], fields)
        losses = self._columns([np.multiply(chain.losses, chain.masses)], fields)[:, 0]
        self._drag = sparse.diags(losses * self._inverse) - self._damped(self._dashpots[:, 0])
        drags = [
            sparse.diags(rates[:, index] * self._inverse)
            - self._damped(self._dashpots[:, index + 1])
            - sparse.diags(self._mass_changes[:, index]) @ self._drag
            for index in range(len(parameters))
        ]
        self._drags = sparse.vstack([self._drag, *drags]).tocsr()
        self._fastest = float(abs(self._drag).sum(axis=1).max())
        self._is_damped = bool(abs(self._drags).sum())
        if masses.size <= SMALL:
            for name in ("_stretch", "_action", "_drag", "_drags"):
                setattr(self, name, getattr(self, name).toarray())

    def _matrix(self, parts: Sequence[Sequence[Entry]], fields: int, sign: int) -> sparse.csr_array:
        """Return the stencils, shifted times ``sign``, as matrix (parts * ring, fields * ring)."""
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
        """Return ``rows`` of values by field or bond as columns, repeated in all cells."""
        return np.repeat(np.reshape(np.array(rows), (len(rows), count)), self._ring, axis=1).T

    def _damped(self, dashpots: Array) -> sparse.csr_array:
        """Return the matrix from velocities to the accelerations caused by these dashpots."""
        return self._action @ sparse.diags(dashpots) @ self._stretch

    def readings(
        self,
        state: State,
        times: Array,
        step: float,
        sensors: Sequence[Sensor],
        scheme: DriftKick = REDUCED_PHASE_6,
    ) -> Array:
        """Return readings (times, sensors, 1 + parameters), in equal steps of at most ``step``."""
        start = self._chain.with_walls(state)
        u, v = np.zeros((2, start.f.size, 1 + len(self._parameters)))
        u[:, 0], v[:, 0] = start.f.ravel(), start.v.ravel()
        readings, begin = np.empty((times.size, len(sensors), u.shape[1])), state.t
        for row, t in enumerate(times.tolist()):
            steps = math.ceil((t - begin) / step * (1.0 - 1e-12))
            if steps:
                self._march(u, v, scheme, begin, (t - begin) / steps, steps)
            readings[row] = list(self._read(u, v, t, sensors))
            begin = t
        return readings

    def _march(self, u: Array, v: Array, scheme: DriftKick, t: float, h: float, steps: int) -> None:
        """Advance u and v, with their derivatives, in place by ``steps`` steps ``h`` from ``t``."""
        drifts, kicks = scheme.drifts * h, scheme.kicks * h
        starts = t + h * np.arange(steps)[:, np.newaxis]
        times: Array = np.asarray(starts + np.cumsum(drifts[:-1]), dtype=np.float64).reshape(-1)
        positions, rates = np.zeros((2, times.size, len(u)))
        force_values = [force.value(times) for force in self._chain.outer_forces]
        walls = self._walls()
        for at, path in walls:
            positions[:, at] = np.reshape(path(times), (-1, 1))
            if self._dashpots.any():
                rates[:, at] = np.reshape(path.slope(times), (-1, 1))  # type: ignore[attr-defined]
        for number in range(times.size):
            stage = number % kicks.size
            self._drift(u, v, drifts[stage])
            for at, _ in walls:
                u[at, 0] = positions[number, at]
            external = [values[number] for values in force_values]
            v += kicks[stage] * self._acceleration(u, external, rates[number])
            if stage == kicks.size - 1:
                self._drift(u, v, drifts[-1])

    def _walls(self) -> list[tuple[list[int], TimeFunction]]:
        """Return the row indices of each moving wall, and its displacement in time."""
        fields = range(len(self._chain.fields))
        return [
            ([field * self._ring + cell for field in fields for cell in wall.places], path)
            for wall in self._chain.walls
            if (path := wall.displacement) is not None
        ]

    def _drift(self, u: Array, v: Array, length: float) -> None:
        """Apply the flow of ``u' = v, v' = -G v`` in place, by its series."""
        u += length * v
        term, weight = v, length
        for power in range(2, self._terms(length) + 2):
            change = (self._drags @ term[:, 0]).reshape(-1, len(u)).T
            change[:, 1:] += self._drag @ term[:, 1:]
            term = -change
            v += weight * term
            weight *= length / power
            u += weight * term

    def _terms(self, length: float) -> int:
        """Return the number of terms of a drift's series that are not negligible."""
        count, bound = int(self._is_damped), self._fastest * abs(length)
        term_bound = bound
        while term_bound > NEGLIGIBLE_TERM:
            count += 1
            term_bound *= bound / count
        return count

    def _acceleration(self, u: Array, external: Sequence[float], rates: Array) -> Array:
        """Return the accelerations and their derivatives."""
        forces = self._forces(self._stretch @ u)
        if rates.any():
            forces += self._dashpots * (self._stretch @ rates)[:, np.newaxis]
        result = self._action @ forces
        for value, (rows, shares, law) in zip(external, self._force_weights, strict=True):
            displacements = u[rows]
            result[rows, 0] += value * shares * (1.0 if law is None else law(displacements[:, 0]))
            if law is not None:
                slopes = value * shares * law.slope(displacements[:, 0])
                result[rows, 1:] += slopes[:, np.newaxis] * displacements[:, 1:]
        result[:, 1:] -= self._mass_changes * result[:, :1]
        return np.asarray(result)

    def _forces(self, stretches: Array) -> Array:
        """Return the bonds' forces and their derivatives, (bonds * ring, 1 + parameters)."""
        forces = np.empty_like(stretches)
        for bond_index, bond in enumerate(self._chain.bonds):
            rows = slice(bond_index * self._ring, (bond_index + 1) * self._ring)
            x = stretches[rows, 0]
            forces[rows, 0] = bond.force(x)
            forces[rows, 1:] = bond.force.slope(x)[:, np.newaxis] * stretches[rows, 1:]
            for column, parameter in enumerate(self._parameters, 1):
                added = parameter.forces[bond_index]
                if added is not None:
                    forces[rows, column] += added(x)
        return forces

    def _read(self, u: Array, v: Array, t: float, sensors: Sequence[Sensor]) -> Iterator[Array]:
        """Yield the reading of each sensor, with its derivatives, at time ``t``."""
        u = u.copy()
        for at, path in self._walls():
            u[at, 0] = path(np.array([t]))
        for free, neighbour in self._chain.free:
            u[free :: self._ring] = u[neighbour :: self._ring]
        stretches = self._stretch @ u
        quantities = {
            "displacement": u,
            "velocity": v,
            "strain": stretches,
            "force": self._forces(stretches) * self._bond_shares[:, np.newaxis],
        }
        for sensor in sensors:
            yield quantities[sensor.quantity][sensor.inner * self._ring + sensor.cell]

"""Energy balance of a driven chain: work done on it, heat, and energy through its cuts.

Time integrals do not depend on the scheme. Within a step the fields are polynomials of degree 5
through the values, velocities and f'' at both ends. These give f'' at Gauss-Legendre nodes, which
give polynomials of degree 7, from which the rates are computed. The error falls like step^8.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from longwave.lattice.driving import DrivenChain
from longwave.lattice.state import State
from longwave.support.checkpoint import Memory
from longwave.support.real_arrays import Array

NODES, WEIGHTS = ((legendre.leggauss(4)[0] + 1.0) / 2.0, legendre.leggauss(4)[1] / 2.0)
"""Nodes and weights of Gauss's rule on 0 .. 1."""

BATCH_STEPS = 64
"""Largest number of steps integrated in one batch."""


def _powers(points: Sequence[float] | Array, derivative: int) -> Array:
    """Return 1, x, .., x^7, or derivatives of that order, at the points: (point, power)."""
    monomials = [np.polynomial.Polynomial(unit).deriv(derivative) for unit in np.eye(8)]
    return np.stack([each(np.array(points)) for each in monomials], axis=1)


def _at_nodes(*known: Array) -> Array:
    """Return matrices (2, node, datum) that map data to values, and to slopes, at `NODES`."""
    conditions = np.concatenate(known)
    inverse = np.linalg.inv(conditions[:, : len(conditions)])
    return np.array([_powers(NODES, each)[:, : len(inverse)] @ inverse for each in (0, 1)])


_ENDS = [_powers([0.0, 1.0], each) for each in range(3)]
FROM_ENDS = _at_nodes(*_ENDS)
"""Matrices from values, slopes and second derivatives at the ends to values and slopes at
`NODES`."""
FROM_ENDS_AND_NODES = _at_nodes(_ENDS[0], _ENDS[2], _powers(NODES, 2))
"""Matrices to values and slopes at `NODES` from values at the ends, and second derivatives at the
ends and at `NODES`."""


class Flow(NamedTuple):
    """Energies or powers: ``work`` of each driver, ``heat``, and the flow ``through`` each cut."""

    work: Array = np.zeros(0)
    heat: Array = np.zeros(1)
    through: Array = np.zeros(0)


def power(
    chain: DrivenChain, f: Array, v: Array, times: Array, cuts: Sequence[int] = ()
) -> tuple[Array, Array]:
    """Return the rates at which energy is exchanged, and f'', for states at several times.

    The rates, (rates, times), are the power of each of the chain's `drivers`, the heat, and the
    flow through each of the ``cuts``, just right of a cell. A bond's stored energy and loss count
    half on either side of a cut. Fields, velocities and f'' have the shape (fields, times, ring).
    Cells of walls are set, in place, to their positions and velocities at these times.
    """
    chain.place_walls(f, v, times, moving=True)
    cells, masses = chain.cells, np.array(chain.masses)[:, np.newaxis, np.newaxis]
    dashpot_forces = chain.dashpot_forces(v)
    forces = [
        force + dashpot_force
        for force, dashpot_force in zip(chain.forces(f), dashpot_forces, strict=True)
    ]
    acceleration = chain.acceleration_by(forces)
    wall_power = masses * acceleration * v
    flows = [-wall_power[..., list(wall.places)].sum(axis=(0, 2)) for wall in chain.moved]
    for outer in chain.outer_forces:
        acting = outer.at(f, times, chain.cell_masses[outer.field, :cells])
        flows.append((acting * v[outer.field, :, :cells]).sum(axis=1))
        acceleration[outer.field, :, :cells] += acting / chain.masses[outer.field]
    damping = np.array(chain.losses)[:, np.newaxis, np.newaxis] * v
    acceleration -= damping
    heat = (masses * damping * v)[..., :cells].sum(axis=(0, 2))
    for bond, dashpot_force in zip(chain.bonds, dashpot_forces, strict=True):
        heat = heat + (dashpot_force * (bond.stretched(v) - bond.offset)).sum(axis=-1)
    if rows := chain.variation.mass_rows(len(chain.fields)):
        acceleration /= 1.0 + chain.deviations[:rows, np.newaxis]
    flows += [heat, *(_flux(chain, forces, v, cut) for cut in cuts)]
    return np.array(flows), acceleration


def _flux(chain: DrivenChain, forces: Sequence[Array], v: Array, cut: int) -> Array:
    """Return the energy flow over a cut: half of the bonds' power right of it minus left of it."""
    flux, ring = np.zeros(v.shape[1]), v.shape[2]
    for bond, force in zip(chain.bonds, forces, strict=True):
        shifts = [entry.shift[0] for entry in bond.stretch]
        for left in range(min(shifts), max(shifts)):
            cell = cut - left
            for entry in bond.stretch:
                half = -0.5 if entry.shift[0] > left else 0.5
                speed = v[entry.field, :, (cell + entry.shift[0]) % ring]
                flux += half * entry.weight * force[:, cell % ring] * speed
    return flux


class EnergyBalance:
    """Energy flows, integrated step by step. ``total`` and ``rate`` belong to the last `settle`."""

    def __init__(self, chain: DrivenChain, cuts: Sequence[int], start: State) -> None:
        self._chain, self._cuts = chain, cuts
        self._sum: Array = np.zeros(len(chain.drivers) + 1 + len(cuts))
        self._ends = [(start.t, start.f.copy(), start.v.copy())]
        self.settle()

    def follow(self, state: State) -> None:
        """Record the state at the end of a step."""
        if state.t > self._ends[-1][0]:
            self._ends.append((state.t, state.f.copy(), state.v.copy()))
        if len(self._ends) > BATCH_STEPS:
            self.settle()

    def settle(self) -> None:
        """Integrate the flows over the steps recorded since the last call."""
        times, *rings = zip(*self._ends, strict=True)
        t, (f, v) = np.array(times), (np.stack(each, axis=1) for each in rings)
        with np.errstate(all="ignore"):  # before a blow-up
            rates, acceleration = power(self._chain, f, v, t, self._cuts)
            if t.size > 1:
                self._sum = self._sum + self._between(t, f, v, acceleration)
        self._ends = self._ends[-1:]
        kinds = np.cumsum([len(self._chain.drivers), 1])
        self.total, self.rate = (Flow(*np.split(each, kinds)) for each in (self._sum, rates[:, -1]))

    def memory(self) -> Memory:
        """Return the data from which `recall` resumes bit by bit."""
        return {"sum": self._sum, "ends": self._ends}

    def recall(self, memory: Memory) -> None:
        """Restore the balance from the `memory` of one with the same chain and cuts."""
        self._sum, self._ends = memory["sum"], memory["ends"]

    def _between(self, t: Array, f: Array, v: Array, acceleration: Array) -> Array:
        """Return the energy flows integrated over steps, given the motion at the steps' ends."""
        h = np.diff(t)
        times, length = t[:-1, np.newaxis] + np.outer(h, NODES), h[:, np.newaxis]

        def between(weights: Array, known: Sequence[Array]) -> tuple[Array, Array]:
            fields, speeds = weights[:, np.newaxis, np.newaxis] @ np.stack(known, axis=2)
            flat = len(f), times.size, f.shape[2]
            speeds = (speeds / length[..., np.newaxis]).reshape(flat)
            return power(self._chain, fields.reshape(flat), speeds, times.ravel(), self._cuts)

        end_values, slopes, accelerations = (
            [scale * values[:, :-1], scale * values[:, 1:]]
            for scale, values in ((1.0, f), (length, v), (length**2, acceleration))
        )
        _, at_nodes = between(FROM_ENDS, [*end_values, *slopes, *accelerations])
        inner = [length**2 * at_nodes[:, node :: NODES.size] for node in range(NODES.size)]
        rates, _ = between(FROM_ENDS_AND_NODES, [*end_values, *accelerations, *inner])
        return np.asarray(rates.reshape(-1, *times.shape) @ WEIGHTS @ h)

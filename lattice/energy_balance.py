"""What has been done to a chain since its start, what it has lost, and what went through it.

Integrals over time know nothing of the scheme. In a step fields are polynomials of degree 5 with
the values, velocities and f'' of both ends; they give f'' at the nodes of Gauss and Legendre, and
that polynomials of degree 7, of which rates are taken. The error falls like step^8.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from longwave.lattice.driving import DrivenChain
from longwave.lattice.state import State
from longwave.support.checkpoint import Memory

Array = NDArray[np.float64]

NODES, WEIGHTS = ((legendre.leggauss(4)[0] + 1.0) / 2.0, legendre.leggauss(4)[1] / 2.0)
"""On 0 .. 1."""

TOGETHER = 64
"""Most steps of which the integrals are taken at once."""


def _powers(places: Sequence[float] | Array, derivative: int) -> Array:
    """A derivative of 1, x, .., x^7 at some places, (place, power)."""
    found = [np.polynomial.Polynomial(unit).deriv(derivative) for unit in np.eye(8)]
    return np.stack([each(np.array(places)) for each in found], axis=1)


def _at_nodes(*known: Array) -> Array:
    """A polynomial's values and slopes at the nodes from what is known of it, (2, node, known)."""
    conditions = np.concatenate(known)
    given = np.linalg.inv(conditions[:, : len(conditions)])
    return np.array([_powers(NODES, each)[:, : len(given)] @ given for each in (0, 1)])


_ENDS = [_powers([0.0, 1.0], each) for each in range(3)]
FIRST = _at_nodes(*_ENDS)
"""From values, slopes and second derivatives at both ends."""
SECOND = _at_nodes(_ENDS[0], _ENDS[2], _powers(NODES, 2))
"""From values at both ends, and second derivatives there and at the nodes."""


class Flow(NamedTuple):
    """Energy, or power: from each of the chain's drivers, as heat, and through each cut."""

    work: Array = np.zeros(0)
    heat: Array = np.zeros(1)
    through: Array = np.zeros(0)


def power(
    chain: DrivenChain, f: Array, v: Array, times: Array, cuts: Sequence[int] = ()
) -> tuple[Array, Array]:
    """The rates at which energy comes and goes, and f'', of states at some times.

    Rates are (rates, times): of the work of each of the chain's `drivers`, of the heat, and of what
    goes through the ``cuts``, each to the right of a cell. There half of what a bond stores,
    and loses, is on either side. Fields, velocities and f'' have the shape (fields, times,
    ring); what walls do then is put in its place.
    """
    chain.place_walls(f, v, times, moving=True)
    cells, masses = chain.cells, np.array(chain.masses)[:, np.newaxis, np.newaxis]
    dashed = chain.dashed(v)
    forces = [force + pot for force, pot in zip(chain.forces(f), dashed, strict=True)]
    found = chain.pulled(forces)
    gained = masses * found * v
    flows = [-gained[..., list(wall.places)].sum(axis=(0, 2)) for wall in chain.moved]
    for push in chain.outer_forces:
        acting = push.at(f, times, chain.cell_masses[push.field, :cells])
        flows.append((acting * v[push.field, :, :cells]).sum(axis=1))
        found[push.field, :, :cells] += acting / chain.masses[push.field]
    damping = np.array(chain.losses)[:, np.newaxis, np.newaxis] * v
    found -= damping
    heat = (masses * damping * v)[..., :cells].sum(axis=(0, 2))
    for bond, pot in zip(chain.bonds, dashed, strict=True):
        heat = heat + (pot * (bond.stretched(v) - bond.offset)).sum(axis=-1)
    if rows := chain.variation.mass_rows(len(chain.fields)):
        found /= 1.0 + chain.deviations[:rows, np.newaxis]
    flows += [heat, *(_flux(chain, forces, v, cut) for cut in cuts)]
    return np.array(flows), found


def _flux(chain: DrivenChain, forces: Sequence[Array], v: Array, cut: int) -> Array:
    """Half of what the bonds over a cut do to the cells on its right, less that on its left."""
    found, ring = np.zeros(v.shape[1]), v.shape[2]
    for bond, force in zip(chain.bonds, forces, strict=True):
        shifts = [entry.shift[0] for entry in bond.stretch]
        for left in range(min(shifts), max(shifts)):
            base = cut - left
            for entry in bond.stretch:
                half = -0.5 if entry.shift[0] > left else 0.5
                speed = v[entry.field, :, (base + entry.shift[0]) % ring]
                found += half * entry.weight * force[:, base % ring] * speed
    return found


class EnergyBalance:
    """What flows in a chain and through ``cuts``, from a state on, followed step by step.

    ``total`` is since the start and ``rate`` now, both of when it was last settled.
    """

    def __init__(self, chain: DrivenChain, cuts: Sequence[int], start: State) -> None:
        self._chain, self._cuts = chain, cuts
        self._sum: Array = np.zeros(len(chain.drivers) + 1 + len(cuts))
        self._ends = [(start.t, start.f.copy(), start.v.copy())]
        self.settle()

    def follow(self, state: State) -> None:
        """Note the end of a step."""
        if state.t > self._ends[-1][0]:
            self._ends.append((state.t, state.f.copy(), state.v.copy()))
        if len(self._ends) > TOGETHER:
            self.settle()

    def settle(self) -> None:
        """Add what flowed in the steps since this was last done."""
        times, *rings = zip(*self._ends, strict=True)
        t, (f, v) = np.array(times), (np.stack(each, axis=1) for each in rings)
        with np.errstate(all="ignore"):  # before a blow-up
            rates, bent = power(self._chain, f, v, t, self._cuts)
            if t.size > 1:
                self._sum = self._sum + self._between(t, f, v, bent)
        self._ends = self._ends[-1:]
        kinds = np.cumsum([len(self._chain.drivers), 1])
        self.total, self.rate = (Flow(*np.split(each, kinds)) for each in (self._sum, rates[:, -1]))

    def memory(self) -> Memory:
        """What `recall` needs to go on, bit by bit."""
        return {"sum": self._sum, "ends": self._ends}

    def recall(self, memory: Memory) -> None:
        """Be what another balance, made alike, was."""
        self._sum, self._ends = memory["sum"], memory["ends"]

    def _between(self, t: Array, f: Array, v: Array, bent: Array) -> Array:
        """What flowed in steps with these fields, velocities and f'' at their ends."""
        h = np.diff(t)
        times, length = t[:-1, np.newaxis] + np.outer(h, NODES), h[:, np.newaxis]

        def between(weights: Array, known: Sequence[Array]) -> tuple[Array, Array]:
            places, speeds = weights[:, np.newaxis, np.newaxis] @ np.stack(known, axis=2)
            flat = len(f), times.size, f.shape[2]
            speeds = (speeds / length[..., np.newaxis]).reshape(flat)
            return power(self._chain, places.reshape(flat), speeds, times.ravel(), self._cuts)

        places, slopes, bends = (
            [scale * values[:, :-1], scale * values[:, 1:]]
            for scale, values in ((1.0, f), (length, v), (length**2, bent))
        )
        _, found = between(FIRST, [*places, *slopes, *bends])
        inner = [length**2 * found[:, node :: NODES.size] for node in range(NODES.size)]
        rates, _ = between(SECOND, [*places, *bends, *inner])
        return np.asarray(rates.reshape(-1, *times.shape) @ WEIGHTS @ h)

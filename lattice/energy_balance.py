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
            rates, bent = self._chain.power(f, v, t, self._cuts)
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

        def power(weights: Array, known: Sequence[Array]) -> tuple[Array, Array]:
            places, speeds = weights[:, np.newaxis, np.newaxis] @ np.stack(known, axis=2)
            flat = len(f), times.size, f.shape[2]
            speeds = (speeds / length[..., np.newaxis]).reshape(flat)
            return self._chain.power(places.reshape(flat), speeds, times.ravel(), self._cuts)

        places, slopes, bends = (
            [scale * values[:, :-1], scale * values[:, 1:]]
            for scale, values in ((1.0, f), (length, v), (length**2, bent))
        )
        _, found = power(FIRST, [*places, *slopes, *bends])
        inner = [length**2 * found[:, node :: NODES.size] for node in range(NODES.size)]
        rates, _ = power(SECOND, [*places, *bends, *inner])
        return np.asarray(rates.reshape(-1, *times.shape) @ WEIGHTS @ h)

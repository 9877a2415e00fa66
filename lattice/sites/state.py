"""The lattice at one time, on a ring of storage.

The energy of a ring of sites.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lattice.model import Constants

Array = NDArray[np.float64]
Sites = NDArray[np.int64]


@dataclass
class State:
    """Strains and velocities of the sites ``left`` .. ``left + size - 1`` at time ``t``.

    Site n is stored at index n mod size, so that a window moves without copying. The arrays are
    changed in place by a run.
    """

    t: float
    left: int
    y: Array
    s: Array

    @property
    def size(self) -> int:
        """Number of sites held."""
        return int(self.y.size)

    @property
    def sites(self) -> Sites:
        """The sites held, in increasing order."""
        return np.arange(self.left, self.left + self.size)

    def strain(self, sites: Sites) -> Array:
        """Strains (a copy) at the given sites, which must be held.

        >>> state = State(0.0, 5, np.array([6.0, 7.0, 5.0]), np.zeros(3))
        >>> state.strain(np.array([5, 6, 7]))
        array([5., 6., 7.])
        """
        return self.y[sites % self.size]

    def velocity(self, sites: Sites) -> Array:
        """Velocities (a copy) at the given sites, which must be held."""
        return self.s[sites % self.size]

    def store(self, sites: Sites, y: Array, s: Array) -> None:
        """Set strains and velocities at the given sites."""
        index = sites % self.size
        self.y[index] = y
        self.s[index] = s


def empty_state(t: float, left: int, size: int) -> State:
    """A state whose values are still to be stored."""
    return State(t, left, np.empty(size), np.empty(size))


def ring_energy(state: State, constants: Constants) -> float:
    """Energy of the chain whose bonds are strained by y: sum of p_n^2 / 2 + V(y_n).

    The strain lattice is the chain u_n'' = V'(y_n) - V'(y_{n-1}), y_n = u_{n+1} - u_n, whose energy
    this is. The velocities p_n = u_n' are rebuilt from s_n = p_{n+1} - p_n, in the frame of the
    centre of mass; the part of s that a ring cannot hold, its mean, is left out.

    The exact flow obeys dH/dt = mean(s) sum V'(y_n): the energy is conserved if the velocities
    sum to zero, and otherwise changes by the work of stretching the ring. mean(s) is conserved, so
    data that close up keep H for good.

    >>> state = State(0.0, 0, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, -1.0]))
    >>> round(ring_energy(state, Constants(4, 0, 1)), 12)  # V = 2 + 1/4, p = (-1, -1, 2) / 3
    2.583333333333
    """
    y, s = state.y, state.s
    momentum = np.cumsum(s - np.mean(s))
    momentum -= np.mean(momentum)
    K2, K3, K4 = constants.K2, constants.K3, constants.K4
    potential = y * y * (K2 / 2.0 + y * (K3 / 3.0 + y * (K4 / 4.0)))
    return float(np.sum(0.5 * momentum * momentum + potential))

"""The lattice at one time, on a ring of storage."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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

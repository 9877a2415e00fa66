"""The energy of a ring of sites."""

import numpy as np

from verify.lattice.constants import Constants
from verify.lattice.state import State


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

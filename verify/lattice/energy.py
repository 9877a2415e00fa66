"""The energy of a ring of sites."""

import numpy as np

from verify.lattice.constants import Constants
from verify.lattice.state import State


def ring_energy(state: State, constants: Constants) -> float:
    """Sum of p_n^2 / 2 + V(y_n) over the ring, p_n in the frame of its centre of mass.

    The momenta follow from s_n = p_{n+1} - p_n. The value is conserved by the exact flow if the
    velocities sum to zero over the ring; otherwise the ring is being stretched, and the stretching
    does work on it.
    """
    y, s = state.y, state.s
    momentum = np.cumsum(s - np.mean(s))
    momentum -= np.mean(momentum)
    K2, K3, K4 = constants.K2, constants.K3, constants.K4
    potential = y * y * (K2 / 2.0 + y * (K3 / 3.0 + y * (K4 / 4.0)))
    return float(np.sum(0.5 * momentum * momentum + potential))

"""A ring of any lattice through given times."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from verify.lattices.lattice_wave import RingState

Array = NDArray[np.float64]


def advanced(ring: RingState, times: Array, tolerance: float) -> list[Array]:
    """The fields' periodic parts at the times after the first, to a tolerance a step."""
    from scipy.integrate import solve_ivp

    shape = (2, *ring.f.shape)

    def rate(_: float, state: Array) -> Array:
        f, v = state.reshape(shape)
        return np.array([v, ring.lattice.acceleration(f)]).ravel()

    found = solve_ivp(
        rate,
        (times[0], times[-1]),
        np.array([ring.f, ring.v]).ravel(),
        "DOP853",
        t_eval=times[1:],
        rtol=1e-13,
        atol=tolerance,
    )
    return [state.reshape(shape)[0] for state in found.y.T]

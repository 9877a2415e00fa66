"""A ring of any lattice through given times, with a step that is a share of the longest stable."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from longwave.lattice import FieldState, integrate
from longwave.lattice.schemes import REDUCED_PHASE_6, stability_limit
from longwave.scenes.lattice_wave import CellRing

Array = NDArray[np.float64]


def advanced(ring: CellRing, times: Array, share: float) -> list[Array]:
    """The fields' periodic parts at the times after the first.

    ``share`` of the longest step that is stable at the stiffest bonds of the state.  Raises
    ValueError as `lattice.integrate` does.
    """
    stiffest = [float(np.max(slopes)) for slopes in ring.slopes]
    frequency = max(
        ring.lattice.highest_frequency(slopes) for slopes in (stiffest, ring.lattice.rest_slopes())
    )
    step = share * stability_limit(REDUCED_PHASE_6) / frequency
    state = FieldState(float(times[0]), ring.f, ring.v)
    found = integrate(ring.lattice, state, times[1:], step=step, measure_error=False)
    return list(found.f)

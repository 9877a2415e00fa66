"""Conserved quantities of a ring."""

from collections.abc import Mapping

import numpy as np

from verify.lattice.energy import ring_energy
from verify.lattice.observables.entry import View


def energy(view: View) -> Mapping[str, float]:
    """The energy of the chain whose bonds are strained by y (`energy.py`)."""
    return {"energy": ring_energy(view.state, view.constants)}


def momentum(view: View) -> Mapping[str, float]:
    """Mean strain and mean velocity over the ring.

    The second difference sums to zero over a ring, so the mean velocity is conserved and the mean
    strain moves linearly with it.
    """
    state = view.state
    return {"mean_strain": float(np.mean(state.y)), "mean_velocity": float(np.mean(state.s))}

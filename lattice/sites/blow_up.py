"""When a run must stop: non-finite or runaway strains, or waves that no longer exist."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lattice.model import Constants
from lattice.sites.state import State

GROWTH = 100.0
"""Growth of the largest strain, relative to the initial one, that counts as a blow-up."""


@dataclass(frozen=True)
class BlowUp:
    """What was first seen, when and where.

    ``from_seam`` is the distance in sites from a ring's seam whose signals can have been there.
    """

    criterion: str
    t: float
    site: int
    from_seam: int | None = None

    def __str__(self) -> str:
        text = f"blow-up: {self.criterion} at t = {self.t:g}, site {self.site}"
        if self.from_seam is None:
            return text
        return (
            f"{text}, {self.from_seam} sites from the ring's seam, where the wave does not close "
            "(what comes from there may be its cause: take sites with which it closes better, or "
            "a tolerance in the place of step and domain)"
        )


def find_blow_up(constants: Constants, state: State, initial_amplitude: float) -> BlowUp | None:
    """The first criterion that the state meets, None if it is sound.

    Criteria, in order: a strain or velocity that is not finite; the lattice's hyperbolicity,
    K2 + 2 K3 y + 3 K4 y^2 > 0, lost (disturbances then grow at once, fastest at the zone
    boundary); the largest strain grown by more than ``GROWTH``.
    """
    if _sound(constants, state, GROWTH * initial_amplitude):
        return None
    broken = ~(np.isfinite(state.y) & np.isfinite(state.s))
    if broken.any():
        return _seen("the strain is not finite", state, broken)
    with np.errstate(over="ignore"):
        soft = constants.stiffness(state.y) <= 0.0
    if soft.any():
        return _seen("K2 + 2 K3 y + 3 K4 y^2 <= 0", state, soft)
    large = np.abs(state.y) > GROWTH * initial_amplitude
    if large.any():
        return _seen(f"the largest strain has grown {GROWTH:g}-fold", state, large)
    return None


def _sound(constants: Constants, state: State, limit: float) -> bool:
    """Whether the extremes alone say that nothing is wrong: a tenth of the work of all criteria."""
    least, most = float(state.y.min()), float(state.y.max())
    with np.errstate(over="ignore", invalid="ignore"):
        finite = math.isfinite(float(state.s.sum())) and math.isfinite(least + most)
    return finite and max(-least, most) <= limit and constants.least_stiffness(least, most) > 0.0


def _seen(criterion: str, state: State, where: NDArray[np.bool_]) -> BlowUp:
    sites = state.sites
    return BlowUp(criterion, state.t, int(sites[where[sites % state.size]][0]))

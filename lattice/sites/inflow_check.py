"""A monitor of what a window is fed: the feed must fit the sites next to it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lattice.sites.blow_up import BlowUp
from lattice.sites.state import Sites, State

WATCHED = 8
"""Sites next to the fed ones on which feed and lattice are compared."""

TOLERANCE = 1e-5
"""Largest difference of y/eps between feed and lattice; a sound feed stays far below it."""


@dataclass
class FeedMonitor:
    """Compares each feed with the lattice; ``mismatch`` is the largest difference of y/eps seen."""

    eps: float
    mismatch: float = 0.0

    def compare(self, state: State, sites: Sites, feed: NDArray[np.float64]) -> BlowUp | None:
        """The fault at the first site where feed and lattice differ too much, None if none does.

        ``feed`` holds the strains that the feed would put on ``sites``, which it leaves alone.
        """
        misses = np.abs(state.strain(sites) - feed) / self.eps
        most = float(misses.max())
        self.mismatch = max(self.mismatch, most)
        wrong = misses > TOLERANCE
        if not wrong.any():
            return None
        criterion = (
            f"the window's feed misses the lattice by {most:.2g} eps, "
            f"more than {TOLERANCE:g} eps (the wave's far field is not what is fed)"
        )
        return BlowUp(criterion, state.t, int(sites[wrong][0]))

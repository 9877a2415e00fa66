"""The state of a ring at one time, blow-ups, and the domains of cells that runs follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from longwave.support.checkpoint import Memory

Array = NDArray[np.float64]
Sites = NDArray[np.int64]


@dataclass
class State:
    """Fields ``f`` and velocities ``v``, of shape (fields, *cells), on a ring at time ``t``.

    For displacements that grow with the cell, the arrays hold the periodic part; the growing part
    is in the offsets of the lattice's bonds. A chain's cells are ``left`` .. ``left + cells - 1``;
    cell n is stored at index n mod cells, so that a window moves without copying. A run changes the
    arrays in place.
    """

    t: float
    f: Array
    v: Array
    left: int = 0

    @property
    def arrays(self) -> tuple[Array, Array]:
        """Fields and velocities as they are stored."""
        return self.f, self.v

    @property
    def size(self) -> int:
        """Number of field values."""
        return int(self.f.size)

    def copy(self) -> State:
        """Return a copy with arrays of its own."""
        return State(self.t, self.f.copy(), self.v.copy(), self.left)

    @property
    def sites(self) -> Sites:
        """The cells of a chain, in increasing order."""
        return np.arange(self.left, self.left + self.f.shape[1])

    def at(self, sites: Sites) -> tuple[Array, Array]:
        """Return copies of fields and velocities in the given cells of a chain.

        The state must contain these cells.

        >>> state = State(0.0, np.array([[6.0, 7.0, 5.0]]), np.zeros((1, 3)), left=5)
        >>> state.at(np.array([5, 6, 7]))[0]
        array([[5., 6., 7.]])
        """
        f, v = (values.take(sites, axis=1, mode="wrap") for values in self.arrays)
        return f, v

    def store(self, sites: Sites, f: Array, v: Array) -> None:
        """Set fields and velocities in the given cells of a chain."""
        index = sites % self.f.shape[1]
        self.f[:, index] = f
        self.v[:, index] = v


def empty_chain(t: float, left: int, size: int) -> State:
    """Return a state of a chain of one field with uninitialised values."""
    return State(t, np.empty((1, size)), np.empty((1, size)), left)


GROWTH = 100.0
"""Factor of growth from which on the largest stretch of a bond counts as a blow-up."""


@dataclass(frozen=True)
class BlowUp:
    """First blow-up criterion met, at time ``t`` and ``site``, ``from_seam`` sites from a seam."""

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
            "(signals from there may be the cause, not the lattice: end earlier, take a number of "
            "sites with which it closes better, or a tolerance instead of step and domain)"
        )


class Domain(Protocol):
    """Protocol of a domain of cells that moves with a wave at the times ``moves``, if any."""

    moves: frozenset[float] = frozenset()

    @property
    def mismatch(self) -> float:
        """Largest difference of y/eps between the imposed far field and the sites next to it."""
        return 0.0

    def start(self) -> State:
        """Return the initial state."""

    def follow(self, state: State) -> BlowUp | None:
        """Move to the sites of ``state.t``, one of the ``moves``; return a blow-up on new sites."""
        return None

    def fade(self, state: State) -> None:
        """Damp, in place, the sites whose signals can no longer reach a compared site, if any."""
        return

    def locate(self, blow_up: BlowUp, state: State) -> BlowUp:
        """Return ``blow_up`` with its distance from the domain's seam, if the domain has a seam."""
        return blow_up

    def memory(self) -> Memory:
        """Return the domain's changing data, for `recall`."""
        return {}

    def recall(self, memory: Memory, t: float) -> None:
        """Restore the domain from a `memory` that was returned at time ``t``."""
        return

"""What moves on a ring of cells at one time, what stops a run, and the cells that it follows."""

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
    """Fields ``f`` and velocities ``v``, of shape (fields, *cells), on a ring at the time ``t``.

    Of displacements that grow with the cell the periodic part is held; the rest is in the offsets
    of the lattice's bonds. A chain's cells are ``left`` .. ``left + cells - 1``, cell n stored at
    index n mod cells, so that a window moves without copying. A run changes the arrays in place.
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
        """Fields of all cells."""
        return int(self.f.size)

    def copy(self) -> State:
        """A state of its own."""
        return State(self.t, self.f.copy(), self.v.copy(), self.left)

    @property
    def sites(self) -> Sites:
        """The cells of a chain, in increasing order."""
        return np.arange(self.left, self.left + self.f.shape[1])

    def at(self, sites: Sites) -> tuple[Array, Array]:
        """Copies of fields and velocities in the given cells of a chain, which must be held.

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
    """A state of a chain of one field, whose values are still to be stored."""
    return State(t, np.empty((1, size)), np.empty((1, size)), left)


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
            "(what comes from there may be its cause, and not the lattice: end earlier, take sites "
            "with which it closes better, or a tolerance in the place of step and domain)"
        )


class Domain(Protocol):
    """What a run needs of a domain; ``moves`` are the times at which it follows the wave.

    What is written here is a ring of sites that stays where it is.
    """

    moves: frozenset[float] = frozenset()

    @property
    def mismatch(self) -> float:
        """Largest difference of y/eps between what was fed and the sites next to it."""
        return 0.0

    def start(self) -> State:
        """The initial state."""

    def follow(self, state: State) -> BlowUp | None:
        """Move to the sites that belong to ``state.t``; say what is wrong there, if anything.

        To be called at each of the ``moves``.
        """
        return None

    def fade(self, state: State) -> None:
        """Change what can no longer reach a compared site, if that is of use.

        To be called wherever the march stops.
        """
        return

    def locate(self, found: BlowUp, state: State) -> BlowUp:
        """``found``, with what the domain may have to do with it."""
        return found

    def memory(self) -> Memory:
        """What has become of the domain on the way, for `recall`."""
        return {}

    def recall(self, memory: Memory, t: float) -> None:
        """Be what the domain was, at a stop of the march at ``t``."""
        return

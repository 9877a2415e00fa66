"""The lattice at one time, on a ring of storage: its energy, and what can be wrong with it.

A run must stop at strains that are not finite or run away, where waves no longer exist, and where
what a window is fed does not fit the sites next to it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lattice.model import Model

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


def ring_energy(state: State, model: Model) -> float:
    """Energy of the chain whose bonds are strained by y: sum of p_n^2 / 2 + V(y_n).

    The strain lattice is the chain u_n'' = V'(y_n) - V'(y_{n-1}), y_n = u_{n+1} - u_n, whose energy
    this is. The velocities p_n = u_n' are rebuilt from s_n = p_{n+1} - p_n, in the frame of the
    centre of mass; the part of s that a ring cannot hold, its mean, is left out.

    The exact flow obeys dH/dt = mean(s) sum V'(y_n): the energy is conserved if the velocities
    sum to zero, and otherwise changes by the work of stretching the ring. mean(s) is conserved, so
    data that close up keep H for good.

    >>> state = State(0.0, 0, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, -1.0]))
    >>> round(ring_energy(state, Model(4, 0, 1)), 12)  # V = 2 + 1/4, p = (-1, -1, 2) / 3
    2.583333333333
    """
    y, s = state.y, state.s
    momentum = np.cumsum(s - np.mean(s))
    momentum -= np.mean(momentum)
    K2, K3, K4 = model.K2, model.K3, model.K4
    potential = y * y * (K2 / 2.0 + y * (K3 / 3.0 + y * (K4 / 4.0)))
    return float(np.sum(0.5 * momentum * momentum + potential))


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


def find_blow_up(model: Model, state: State, initial_amplitude: float | None) -> BlowUp | None:
    """The first criterion that the state meets, None if it is sound.

    Criteria, in order: a strain or velocity that is not finite; for a wave, that is with an
    amplitude, the lattice's hyperbolicity, K2 + 2 K3 y + 3 K4 y^2 > 0, lost (disturbances then grow
    at once, fastest at the zone boundary); the largest strain grown by more than ``GROWTH``.
    """
    if initial_amplitude is not None and _sound(model, state, GROWTH * initial_amplitude):
        return None
    broken = ~(np.isfinite(state.y) & np.isfinite(state.s))
    if broken.any():
        return _seen("the strain is not finite", state, broken)
    if initial_amplitude is None:
        return None
    with np.errstate(over="ignore"):
        soft = model.stiffness(state.y) <= 0.0
    if soft.any():
        return _seen("K2 + 2 K3 y + 3 K4 y^2 <= 0", state, soft)
    large = np.abs(state.y) > GROWTH * initial_amplitude
    if large.any():
        return _seen(f"the largest strain has grown {GROWTH:g}-fold", state, large)
    return None


def _sound(model: Model, state: State, limit: float) -> bool:
    """Whether the extremes alone say that nothing is wrong: a tenth of the work of all criteria."""
    least, most = float(state.y.min()), float(state.y.max())
    with np.errstate(over="ignore", invalid="ignore"):
        finite = math.isfinite(float(state.s.sum())) and math.isfinite(least + most)
    return finite and max(-least, most) <= limit and model.least_stiffness(least, most) > 0.0


def _seen(criterion: str, state: State, where: NDArray[np.bool_]) -> BlowUp:
    sites = state.sites
    return BlowUp(criterion, state.t, int(sites[where[sites % state.size]][0]))


WATCHED = 8
"""Sites next to the fed ones on which feed and lattice are compared."""

LARGEST_MISFIT = 1e-5
"""Largest difference of y/eps between feed and lattice; a sound feed stays far below it."""


@dataclass
class InflowCheck:
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
        wrong = misses > LARGEST_MISFIT
        if not wrong.any():
            return None
        criterion = (
            f"the window's feed misses the lattice by {most:.2g} eps, "
            f"more than {LARGEST_MISFIT:g} eps (the wave's far field is not what is fed)"
        )
        return BlowUp(criterion, state.t, int(sites[wrong][0]))

"""The strain FPUT lattice: its constants, and its state at one time on a ring of storage.

A run must stop at strains that are not finite or run away, where waves no longer exist, and where
what a window is fed does not fit the sites next to it.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Model:
    """Force constants of V'(y) = K2 y + K3 y^2 + K4 y^3 (unit mass, unit spacing)."""

    K2: float
    K3: float
    K4: float

    def __post_init__(self) -> None:
        for name, value in (("K2", self.K2), ("K3", self.K3), ("K4", self.K4)):
            if not math.isfinite(value):
                raise ValueError(f"{name} must be finite, got {value} (1 is usual)")
        if self.K2 <= 0:
            raise ValueError(
                f"K2 must satisfy K2 > 0, got {self.K2:g} (the sound speed is sqrt(K2))"
            )

    def stiffness(self, y: Array) -> Array:
        """V''(y) = K2 + 2 K3 y + 3 K4 y^2; waves exist only where it is positive.

        >>> float(Model(4, 0, 1).stiffness(np.array(1.0)))
        7.0
        """
        y = np.asarray(y, dtype=np.float64)
        return self.K2 + y * (2.0 * self.K3 + 3.0 * self.K4 * y)

    def least_stiffness(self, least: float, most: float) -> float:
        """The smallest V''(y) of all strains from ``least`` to ``most``.

        >>> Model(4, 1, 1).least_stiffness(-2.0, 3.0)  # at y = -1/3
        3.6666666666666665
        """
        places = [least, most]
        if self.K4 > 0.0:
            places.append(min(max(-self.K3 / (3.0 * self.K4), least), most))
        return min(self._stiffness(y) for y in places)

    def _stiffness(self, y: float) -> float:
        return self.K2 + y * (2.0 * self.K3 + 3.0 * self.K4 * y)

    def sound_speed(self, ybar: float = 0.0) -> float:
        """Speed (sites per unit time) of long waves on the uniform strain ``ybar``.

        >>> Model(4, 0, 1).sound_speed()
        2.0
        """
        stiffness = self._stiffness(ybar)
        if stiffness <= 0:
            raise ValueError(
                f"K2 + 2 K3 y + 3 K4 y^2 must be positive, got {stiffness:g} at y = {ybar:g} "
                "(take a smaller eps)"
            )
        return math.sqrt(stiffness)

    def highest_frequency(self, y: Array) -> float:
        """Largest linear frequency (zone boundary, k = pi) about any strain in ``y``."""
        return 2.0 * math.sqrt(max(float(np.max(self.stiffness(y))), self.K2))


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
    def arrays(self) -> tuple[Array, Array]:
        """Strains and velocities as they are stored."""
        return self.y, self.s

    @property
    def size(self) -> int:
        """Number of sites held."""
        return int(self.y.size)

    def copy(self) -> "State":
        """A state of its own."""
        return State(self.t, self.left, self.y.copy(), self.s.copy())

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


def extremes(state: State) -> Array:
    """The smallest and the largest strain, as one row."""
    return np.array([[state.y.min(), state.y.max()]])


def find_blow_up(
    model: Model, state: State, initial_amplitude: float | None, ranges: Array | None = None
) -> BlowUp | None:
    """The first criterion that the state meets, None if it is sound; ``ranges``: its `extremes`.

    Criteria, in order: a strain or velocity that is not finite; for a wave, that is with an
    amplitude, the lattice's hyperbolicity, K2 + 2 K3 y + 3 K4 y^2 > 0, lost (disturbances then grow
    at once, fastest at the zone boundary); the largest strain grown by more than ``GROWTH``.
    """
    if initial_amplitude is not None:
        [met] = extremes(state) if ranges is None else ranges
        if _sound(model, state, met, GROWTH * initial_amplitude):
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


def _sound(model: Model, state: State, met: Array, limit: float) -> bool:
    """Whether the extremes alone say that nothing is wrong: a tenth of the work of all criteria."""
    least, most = met.tolist()
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
        if not most > LARGEST_MISFIT:
            return None
        wrong = misses > LARGEST_MISFIT
        criterion = (
            f"the window's feed misses the lattice by {most:.2g} eps, "
            f"more than {LARGEST_MISFIT:g} eps (the wave's far field is not what is fed)"
        )
        return BlowUp(criterion, state.t, int(sites[wrong][0]))


if TYPE_CHECKING:
    from longwave.lattice.field_state import FieldState
    from longwave.support.checkpoint import Memory

Held = TypeVar("Held", "State", "FieldState")
"""A kind of state."""


class Domain(Protocol[Held]):
    """What a run needs of a domain; ``moves`` are the times at which it follows the wave.

    What is written here is a ring of sites that stays where it is.
    """

    moves: frozenset[float] = frozenset()

    @property
    def mismatch(self) -> float:
        """Largest difference of y/eps between what was fed and the sites next to it."""
        return 0.0

    def start(self) -> Held:
        """The initial state."""

    def follow(self, state: Held) -> BlowUp | None:
        """Move to the sites that belong to ``state.t``; say what is wrong there, if anything.

        To be called at each of the ``moves``.
        """
        return None

    def fade(self, state: Held) -> None:
        """Change what can no longer reach a compared site, if that is of use.

        To be called wherever the march stops.
        """
        return

    def locate(self, found: BlowUp, state: Held) -> BlowUp:
        """``found``, with what the domain may have to do with it."""
        return found

    def memory(self) -> "Memory":
        """What has become of the domain on the way, for `recall`."""
        return {}

    def recall(self, memory: "Memory", t: float) -> None:
        """Be what the domain was, at a stop of the march at ``t``."""
        return

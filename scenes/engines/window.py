"""A window of cells that moves with a wave on a constant background.

Its cells are stored on a ring, so the kernels know one boundary only. What crosses the ring's seam
is wrong; the window keeps it away from the compared cells.

What it is fed with in front is the wave's initial far field, moved rigidly. In the frame that moves
with it this is one smooth function, wanted on few hundred cells over and over again. It is
therefore evaluated once, on Chebyshev points, and interpolated from there.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from longwave.lattice.state import BlowUp, Domain, Sites, State
from longwave.scenes.engines.domain_plan import (
    STRIDE,
    WATCHED,
    DomainPlan,
    fed_cells,
    least_window,
)
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.support.checkpoint import Memory
from longwave.support.compiled.jit import doubles, njit

Array = NDArray[np.float64]


class FedWave:
    """The wave of these domains as a window of ``size`` cells is fed with it.

    ``compared`` cells on either side of the frame's origin are compared for a ``duration`` from
    ``t0``. The far field moves at ``background_speed``. With ``nudged`` the last digits of the data
    are changed.
    """

    def __init__(self, domains: DomainPlan, size: int, nudged: bool = False) -> None:
        self.domains, self.size, self.nudged = domains, size, nudged
        wave, times = domains.wave, domains.times
        self.t0, self.duration = times[0], times[-1] - times[0]
        self.compared = domains.compared.reach[0]
        self.speed, self.scale, self.background_speed = wave.speed, wave.scale, wave.far_speed

    @property
    def fastest(self) -> float:
        """Largest group velocity of any wave far from the wave."""
        return self.domains.wave.far_fastest

    def first(self, t: float) -> int:
        """Return the first cell of a window whose middle is nearest to the frame's origin."""
        return self.domains.compared.middle(t) - self.size // 2

    @cached_property
    def ring(self) -> InitialCells:
        """The data, with the mean strain that their displacements keep from end to end."""
        first = self.first(self.t0)
        ring = self.domains.wave.ring(np.arange(first, first + self.size, dtype=float), self.t0)
        return ring.nudged() if self.nudged else ring

    def rigid_offsets(self, speed: float, sites: Sites, t: float) -> Array:
        """Cells at time t, from where the frame began, in one that moves at ``speed``."""
        begin = self.speed * self.t0
        return np.asarray((sites - begin) - speed * (t - self.t0), dtype=np.float64)

    def rigid_data(self, speed: float, offsets: Array) -> tuple[Array, Array]:
        """What deviates from the uniform far field, moving as it is at ``speed``."""
        wave = self.domains.wave
        f, slopes = wave.rigid(offsets, self.t0)
        return f, wave.far_rates[1][:, np.newaxis] - speed * slopes

    def uniform(self, sites: Sites, t: float) -> Array:
        """The uniform far field, less the mean strain, which the lattice's bonds hold."""
        wave, [mean] = self.domains.wave, self.ring.mean_strain
        growth, velocity = wave.far_rates
        left = growth - mean * np.array(wave.growth_shares)
        moved = np.multiply.outer(left, np.asarray(sites, dtype=np.float64))
        return np.asarray(moved + velocity[:, np.newaxis] * (t - self.t0))


SIZE_RATIO = 1.3
"""Size of a control run's window, in units of that of the run before."""

WINDOW_DECAY = 5.0
"""A window's error falls like its size to this power at least; measured: between 5.8 and 7.4."""

WINDOW_SAFETY = 3.0
"""Factor on the difference of two windows, enough where the error falls like 1/size^1.1. That of a
small one fell by a fifth only where it grew by 1.25: it had hardly left the wave, a rational one of
order 5."""

LARGEST_GROWTH = 4.0
"""Largest factor on a size from one choice to the next."""

SEEN = 16
"""Moves of a window at which runs are compared, beside the times that are asked for."""


def widened(sites: float, excess: float, decay: float) -> float:
    """The size of a window whose error, which falls like 1/size^decay, is smaller by ``excess``."""
    return sites * min(LARGEST_GROWTH, max(1.2, 1.05 * excess ** (1.0 / decay)))


def judged_times(wave: FedWave, exact: Sequence[float]) -> tuple[float, ...]:
    """The exact times and some of the stops that a window's moves make anyway."""
    moves = [t for t in window_moves(wave) if t < wave.t0 + wave.duration]
    return tuple(sorted({*moves[:: max(1, len(moves) // SEEN)], *exact}))


def window_moves(wave: FedWave) -> tuple[float, ...]:
    """The times, counted from t0, after which sound has gone ``STRIDE`` sites again."""
    stay = STRIDE / wave.speed
    count = math.ceil(wave.duration / stay)
    return tuple(wave.t0 + stay * move for move in range(1, count + 1))


DEGREES = (16, 32, 64, 128)
"""Degrees tried: Y2's far field takes the first of them."""

INTERPOLATION_ERROR = 1e-14
"""Largest error of the interpolation, of y/eps or of what is largest."""


def _chebyshev_sums(coefficients: Array, u: Array) -> Array:
    """Sums of coefficients[:, k] T_k(u), of shape (rows of ``coefficients``, u.size)."""
    found = np.empty((len(coefficients), u.size))
    _clenshaw(coefficients, u, found, np.empty_like(u))
    return found


@njit(
    cache=True,
    examples=[(doubles(2), doubles(1), doubles(2), doubles(1))],
    fastmath={"contract"},
)
def _clenshaw(coefficients: Array, u: Array, found: Array, work: Array) -> None:
    """Clenshaw's sums, all places a term at a time: the processor then takes several at once."""
    rows, terms = coefficients.shape
    for row in range(rows):
        found[row] = work[:] = 0.0
        for k in range(terms - 1, 0, -1):
            c = coefficients[row, k]
            for i in range(u.size):
                last = found[row, i]
                found[row, i] = c + 2.0 * u[i] * last - work[i]
                work[i] = last
        c = coefficients[row, 0]
        for i in range(u.size):
            found[row, i] = c + u[i] * found[row, i] - work[i]


@dataclass(frozen=True)
class Tail:
    """The initial wave that moves rigidly at ``speed``, on a stretch of its frame.

    ``low`` and ``high`` are offsets in cells from where the wave began.
    """

    wave: FedWave
    speed: float
    low: float
    high: float

    def at(self, sites: Sites, t: float) -> tuple[Array, Array]:
        """Fields and velocities (fields, cells) at time t in cells of the stretch."""
        offsets = self.wave.rigid_offsets(self.speed, sites, t)
        if self._coefficients is None:
            values = self._rows(offsets)
        else:
            values = _chebyshev_sums(self._coefficients, self._unit(offsets))
        f, v = np.split(values, 2)
        return f + self.wave.uniform(sites, t), v

    def _rows(self, offsets: Array) -> Array:
        """Fields, then velocities."""
        return np.concatenate(self.wave.rigid_data(self.speed, offsets))

    def _unit(self, offsets: Array) -> Array:
        """The stretch as -1 .. 1."""
        return (offsets - 0.5 * (self.low + self.high)) * (2.0 / (self.high - self.low))

    def _exact(self, u: Array) -> Array:
        offsets = 0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * u
        return self._rows(offsets)

    @cached_property
    def _coefficients(self) -> Array | None:
        """Those of fields and velocities; None if no degree gives what lies between its points."""
        for degree in DEGREES:
            points = chebyshev.chebpts1(degree + 1)
            values = self._exact(points)
            level = values[:, 0]  # small coefficients then have small roundings
            found = (values.T - level).T @ chebyshev.chebvander(points, degree) * 2.0 / points.size
            found[:, 0] = 0.5 * found[:, 0] + level
            between = np.concatenate([[-1.0], 0.5 * (points[1:] + points[:-1]), [1.0]])
            exact = self._exact(between)
            error = np.abs(_chebyshev_sums(found, between) - exact).max()
            if error <= INTERPOLATION_ERROR * max(self.wave.scale, np.abs(exact).max()):
                return found
        return None


LARGEST_MISFIT = 1e-5
"""Largest difference of feed and lattice in units of the scale; a sound one stays far below."""


@dataclass
class Window(Domain):
    """Cells about a wave on a constant background: front cells are fed, rear cells are dropped.

    It moves at fixed times, whatever the time step: two runs that differ in their step alone have
    the same error from the window, which cancels in their difference.

    The front is fed with the initial wave's own far field, moved at the background's speed of
    sound. Cells that the seam's signals can have reached since the last move are fed anew with it;
    the window outruns those at its rear. Each feed is compared with the cells behind it;
    ``mismatch`` is the largest difference so far, in units of the wave's scale. Raises ValueError
    for a wave without a constant background, and for compared cells too near the window's ends.
    """

    wave: FedWave
    size: int
    mismatch: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        if self.wave.background_speed is None:
            raise ValueError(
                f"domain must be 'ring' for {self.wave.domains.wave.name}, got 'window' "
                "(its far field is not that of a closed form on a constant background)"
            )
        self.background_speed = self.wave.background_speed
        self._ratio = self.wave.fastest / self.wave.speed
        drift = math.ceil(max(0.0, self.wave.fastest - self.wave.speed) * self.wave.duration)
        least = least_window(self.wave.compared + drift, self._ratio)
        if self.size < least:
            raise ValueError(
                f"sites must satisfy sites >= {least} in this window, got {self.size} "
                "(its ends would touch the compared sites; widen it)"
            )
        self.moves = frozenset(window_moves(self.wave))

    def memory(self) -> Memory:
        """The largest mismatch of a feed so far."""
        return {"mismatch": self.mismatch}

    def recall(self, memory: Memory, t: float) -> None:
        """Have seen that mismatch."""
        self.mismatch = memory["mismatch"]

    def start(self) -> State:
        """The initial state, centred on where the wave begins."""
        t, ring = self.wave.t0, self.wave.ring
        return stored_chain(t, self.wave.first(t), ring.f, ring.v)

    def follow(self, state: State) -> BlowUp | None:
        """Move with the wave, feeding the cells in front; a feed that does not fit is told."""
        left, cells = self.wave.first(state.t), state.f.shape[1]
        fed = fed_cells(left - state.left, self._ratio)
        state.left = left
        end = left + cells
        front = np.arange(end - fed - WATCHED, end)
        f, v = self._tail.at(front, state.t)
        fault = self._misfit(state, front[:WATCHED], f[:, :WATCHED])
        state.store(front[WATCHED:], f[:, WATCHED:], v[:, WATCHED:])
        return fault

    def _misfit(self, state: State, sites: Sites, feed: Array) -> BlowUp | None:
        """The fault in the first cell where feed and lattice differ too much, None if none does."""
        apart = np.abs(state.f.take(sites, axis=1, mode="wrap") - feed)
        misses = apart.max(axis=0) / self.wave.scale
        most = float(misses.max())
        self.mismatch = max(self.mismatch, most)
        if not most > LARGEST_MISFIT:
            return None
        criterion = (
            f"the window's feed misses the lattice by {most:.2g} eps, "
            f"more than {LARGEST_MISFIT:g} eps (the wave's far field is not what is fed)"
        )
        return BlowUp(criterion, state.t, int(sites[misses > LARGEST_MISFIT][0]))

    @cached_property
    def _tail(self) -> Tail:
        """The far field on all offsets from the background's sound at which moves feed or watch."""
        drift = (self.background_speed - self.wave.speed) * self.wave.duration
        end = (self.size + 1) // 2
        begin = end - (fed_cells(STRIDE + 1, self._ratio) + WATCHED)
        low, high = begin - 1 - max(0.0, drift), end + 1 - min(0.0, drift)
        return Tail(self.wave, self.background_speed, low, high)


def stored_chain(t: float, left: int, f: Array, v: Array) -> State:
    """A state of the cells from ``left`` on, (fields, cells), stored as a window has them."""
    return State(t, np.roll(f, left, axis=1), np.roll(v, left, axis=1), left)

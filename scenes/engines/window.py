"""Window of cells that moves with a wave on a constant background.

The cells are stored on a ring, so the kernels need only one kind of boundary. Signals that cross
the ring's seam are wrong; the window keeps them away from the compared cells.

New cells in front are filled with the wave's initial far field, moved rigidly. In the co-moving
frame this is one smooth function, needed on a few hundred cells at every move. It is therefore
evaluated once on Chebyshev points and interpolated.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from longwave.lattice.state import BlowUp, Domain, Sites, State
from longwave.scenes.engines.domain_plan import (
    CHECKED_CELLS,
    MOVE_CELLS,
    DomainPlan,
    fed_cells,
    least_window,
)
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.support.checkpoint import Memory
from longwave.support.compiled.jit import doubles, njit
from longwave.support.real_arrays import Array


class FedWave:
    """Wave that feeds a window of ``size`` cells.

    ``compared`` cells on either side of the frame's origin are compared for a ``duration`` from
    ``t0``. The far field moves at ``background_speed``, which is None without a constant
    background. With ``nudged`` the last digits of the initial data are changed.
    """

    def __init__(self, domains: DomainPlan, size: int, nudged: bool = False) -> None:
        self.domains, self.size, self.nudged = domains, size, nudged
        wave, times = domains.wave, domains.times
        self.t0, self.duration = times[0], times[-1] - times[0]
        self.compared = domains.compared.reach[0]
        self.speed, self.scale, self.background_speed = wave.speed, wave.scale, wave.far_speed

    def first(self, t: float) -> int:
        """Return the window's first cell after its move at time t."""
        return self.domains.compared.middle(t) - self.size // 2

    @cached_property
    def ring(self) -> InitialCells:
        """Initial data on the window's cells, with their mean strain from end to end."""
        first = self.first(self.t0)
        ring = self.domains.wave.ring(np.arange(first, first + self.size, dtype=float), self.t0)
        return ring.nudged() if self.nudged else ring

    def rigid_offsets(self, speed: float, sites: Sites, t: float) -> Array:
        """Return positions of sites in a frame at ``speed`` that starts with the wave's frame."""
        begin = self.speed * self.t0
        return np.asarray((sites - begin) - speed * (t - self.t0), dtype=np.float64)

    def rigid_data(self, speed: float, offsets: Array) -> tuple[Array, Array]:
        """Return fields and velocities of the initial wave if it moved rigidly at ``speed``.

        The `uniform` far field is subtracted from the fields.
        """
        wave = self.domains.wave
        f, slopes = wave.rigid_fields(offsets, self.t0)
        return f, wave.far_rates[1][:, np.newaxis] - speed * slopes

    def uniform(self, sites: Sites, t: float) -> Array:
        """Return the fields of the uniform far field, less the mean strain in the bonds."""
        wave, [mean] = self.domains.wave, self.ring.mean_strain
        growth, velocity = wave.far_rates
        slopes = growth - mean * np.array(wave.growth_shares)
        fields = np.multiply.outer(slopes, np.asarray(sites, dtype=np.float64))
        return np.asarray(fields + velocity[:, np.newaxis] * (t - self.t0))


SIZE_RATIO = 1.3
"""Ratio of the window's size in a control run to that in the run before it."""

WINDOW_DECAY = 5.0
"""Assumed power law: a window's error falls at least like size^-5 (measured: -5.8 to -7.4)."""

WINDOW_SAFETY = 3.0
"""Safety factor on the difference of two windows; it suffices if the error falls like 1/size^1.1.
The slowest fall met was by a fifth when the size grew by 1.25, in a window hardly larger than its
wave (rational, order 5)."""

MAX_SIZE_GROWTH = 4.0
"""Largest factor on a size from one choice to the next."""

COMPARED_MOVES = 16
"""Number of window moves at which runs are compared, in addition to the requested times."""


def widened(sites: float, excess: float, decay: float) -> float:
    """Return the window size that divides an error of law size^-``decay`` by ``excess``."""
    return sites * min(MAX_SIZE_GROWTH, max(1.2, 1.05 * excess ** (1.0 / decay)))


def judged_times(wave: FedWave, exact: Sequence[float]) -> tuple[float, ...]:
    """Return the times at which runs are compared: exact times and some of the window's moves."""
    moves = [t for t in window_moves(wave) if t < wave.t0 + wave.duration]
    return tuple(sorted({*moves[:: max(1, len(moves) // COMPARED_MOVES)], *exact}))


def window_moves(wave: FedWave) -> tuple[float, ...]:
    """Return the times of the window's moves, each ``MOVE_CELLS`` sites after the one before."""
    stay = MOVE_CELLS / wave.speed
    count = math.ceil(wave.duration / stay)
    return tuple(wave.t0 + stay * move for move in range(1, count + 1))


CHEBYSHEV_DEGREES = (16, 32, 64, 128)
"""Degrees tried for the interpolation; the first suffices for the far field of Y2."""

INTERPOLATION_ERROR = 1e-14
"""Largest interpolation error, in units of the wave's scale or of the largest value if larger."""


def _chebyshev_sums(coefficients: Array, u: Array) -> Array:
    """Return the Chebyshev sums of coefficients[:, k] T_k(u), shape (len(coefficients), u.size)."""
    sums = np.empty((len(coefficients), u.size))
    _clenshaw(coefficients, u, sums, np.empty_like(u))
    return sums


@njit(
    cache=True, examples=[(doubles(2), doubles(1), doubles(2), doubles(1))], fastmath={"contract"}
)
def _clenshaw(coefficients: Array, u: Array, found: Array, work: Array) -> None:
    """Write the sums of `_chebyshev_sums` to ``found``; ``work`` is scratch memory.

    The innermost loop of Clenshaw's rule is over the points, so that SIMD applies.
    """
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
    """Initial wave moving rigidly at ``speed``, interpolated on an interval of its frame.

    ``low`` and ``high`` are the interval's ends in cells relative to the wave's start.
    """

    wave: FedWave
    speed: float
    low: float
    high: float

    def at(self, sites: Sites, t: float) -> tuple[Array, Array]:
        """Return fields and velocities (fields, cells) at time t, in cells of the interval."""
        offsets = self.wave.rigid_offsets(self.speed, sites, t)
        if self._coefficients is None:
            values = self._rows(offsets)
        else:
            u = (offsets - 0.5 * (self.low + self.high)) * (2.0 / (self.high - self.low))
            values = _chebyshev_sums(self._coefficients, u)
        f, v = np.split(values, 2)
        return f + self.wave.uniform(sites, t), v

    def _rows(self, offsets: Array) -> Array:
        """Return fields and velocities at ``offsets`` in the moving frame, stacked in rows."""
        return np.concatenate(self.wave.rigid_data(self.speed, offsets))

    def _exact(self, u: Array) -> Array:
        """Return `_rows` at points u of the interval mapped to -1 .. 1."""
        return self._rows(0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * u)

    @cached_property
    def _coefficients(self) -> Array | None:
        """Chebyshev coefficients of fields and velocities; None if no degree is accurate enough."""
        for degree in CHEBYSHEV_DEGREES:
            points = chebyshev.chebpts1(degree + 1)
            values = self._exact(points)
            level = values[:, 0]  # subtracted so that small coefficients have small rounding errors
            sums = (values.T - level).T @ chebyshev.chebvander(points, degree)
            coefficients = sums * 2.0 / points.size
            coefficients[:, 0] = 0.5 * coefficients[:, 0] + level
            between = np.concatenate([[-1.0], 0.5 * (points[1:] + points[:-1]), [1.0]])
            exact = self._exact(between)
            error = np.abs(_chebyshev_sums(coefficients, between) - exact).max()
            if error <= INTERPOLATION_ERROR * max(self.wave.scale, np.abs(exact).max()):
                return coefficients
        return None


LARGEST_MISFIT = 1e-5
"""Largest accepted difference of feed and lattice, in units of the wave's scale."""


@dataclass
class Window(Domain):
    """Moving window about a wave on a constant background: it fills front cells, drops rear cells.

    The window moves at fixed times, whatever the time step. Two runs that differ only in their step
    thus have the same window error, which cancels in their difference.

    New front cells are filled with the initial wave's far field, moved at the background's speed of
    sound. So are the cells that signals from the seam can have reached since the last move; the
    window outruns the signals at its rear. Each feed is compared with the cells behind it;
    ``mismatch`` is the largest difference so far, in units of the wave's scale. Raises ValueError
    for a wave without a constant background, and if compared cells are too near the window's ends.
    """

    wave: FedWave
    mismatch: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        if self.wave.background_speed is None:
            raise ValueError(
                f"domain must be 'ring' for {self.wave.domains.wave.name}, got 'window' "
                "(its far field is not that of a closed form on a constant background)"
            )
        self.background_speed = self.wave.background_speed
        speed, fastest = self.wave.speed, self.wave.domains.wave.far_fastest
        self._ratio = fastest / speed
        drift = math.ceil(max(0.0, fastest - speed) * self.wave.duration)
        least = least_window(self.wave.compared + drift, self._ratio)
        if self.wave.size < least:
            raise ValueError(
                f"sites must satisfy sites >= {least} in this window, got {self.wave.size} "
                "(its ends would touch the compared sites; widen it)"
            )
        self.moves = frozenset(window_moves(self.wave))

    def memory(self) -> Memory:
        """Return the checkpoint state: the largest feed mismatch so far."""
        return {"mismatch": self.mismatch}

    def recall(self, memory: Memory, t: float) -> None:
        """Restore the mismatch from a checkpoint."""
        self.mismatch = memory["mismatch"]

    def start(self) -> State:
        """Return the initial state, centred on the wave's frame at t0."""
        t, ring = self.wave.t0, self.wave.ring
        return stored_chain(t, self.wave.first(t), ring.f, ring.v)

    def follow(self, state: State) -> BlowUp | None:
        """Move the window to the state's time, fill front cells, and return any feed mismatch."""
        left, cells = self.wave.first(state.t), state.f.shape[1]
        fed = fed_cells(left - state.left, self._ratio)
        state.left = left
        end = left + cells
        front = np.arange(end - fed - CHECKED_CELLS, end)
        f, v = self._tail.at(front, state.t)
        fault = self._misfit(state, front[:CHECKED_CELLS], f[:, :CHECKED_CELLS])
        state.store(front[CHECKED_CELLS:], f[:, CHECKED_CELLS:], v[:, CHECKED_CELLS:])
        return fault

    def _misfit(self, state: State, sites: Sites, feed: Array) -> BlowUp | None:
        """Return a `BlowUp` at the first cell where feed and lattice differ too much, else None."""
        differences = np.abs(state.f.take(sites, axis=1, mode="wrap") - feed)
        misses = differences.max(axis=0) / self.wave.scale
        most = float(misses.max())
        self.mismatch = max(self.mismatch, most)
        if not most > LARGEST_MISFIT:
            return None
        criterion = (
            f"the window's feed differs from the lattice by {most:.2g} eps, "
            f"more than {LARGEST_MISFIT:g} eps (the wave's far field does not move rigidly)"
        )
        return BlowUp(criterion, state.t, int(sites[misses > LARGEST_MISFIT][0]))

    @cached_property
    def _tail(self) -> Tail:
        """Far field on all offsets at which the window's moves fill or check cells."""
        drift = (self.background_speed - self.wave.speed) * self.wave.duration
        end = (self.wave.size + 1) // 2
        begin = end - (fed_cells(MOVE_CELLS + 1, self._ratio) + CHECKED_CELLS)
        low, high = begin - 1 - max(0.0, drift), end + 1 - min(0.0, drift)
        return Tail(self.wave, self.background_speed, low, high)


def stored_chain(t: float, left: int, f: Array, v: Array) -> State:
    """Return the state of a chain with first cell ``left``, stored cyclically as in a window."""
    return State(t, np.roll(f, left, axis=1), np.roll(v, left, axis=1), left)

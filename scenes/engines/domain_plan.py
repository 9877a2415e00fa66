"""Rings of cells about a wave, and windows that hold it: how many cells, and what a run costs.

A ring is causal: it holds every cell from which a signal reaches a compared one in time, so its
seam is never felt there. A long wave on a constant background takes a window that moves with it
where that has fewer cells.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.schemes import REDUCED_PHASE_6, Scheme, stability_limit
from longwave.lattice.seam import Fading
from longwave.lattice.state import GROWTH, BlowUp
from longwave.lattice.trial import DRIVEN_SHARE
from longwave.scenes.engines.ring_cost import (
    CELL_SECONDS,
    LARGE,
    SHARE,
    SHOWN,
    USUAL_RUNS,
    search_cost,
)
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.scenes.starts.lattice_wave import (
    LatticeWave,
    largest_group_velocity,
    nearest_cell,
)
from longwave.solutions.pieces import PIECE
from longwave.support.request_limits import ExpectedCost, check_request

Array = NDArray[np.float64]

SCHEME = REDUCED_PHASE_6

LIMIT_SHARE = 0.9
"""Longest step tried, in units of the stability limit at the stiffest bonds of the data."""

LAWFUL_TURN = 3.3
"""Longest step tried, in radians that a carrier turns in it: up to there what a linear wave is off
follows the law of the order within a tenth, and at 4.7 its amplitude's error changes its sign."""

WIDER = 64
"""Cells, along each axis, by which the ring of a control run is wider."""

GROWN = 0.05
"""Share by which a lattice's strains are taken to exceed those of the wave. Those that exceed it do
so on few cells for a short time, and carry no signal far."""

AROUND = 32
"""Cells beyond the compared ones on which is looked at what rounding has grown to."""


MARGIN = 64
"""Sites beyond the distance of sound that a window leaves for a signal's dispersive front."""

FRONT = 12.0
"""Airy lengths by which a signal's front runs ahead of the sound: Ai(12) is 1e-13."""

SIZE_MULTIPLE = 64
"""Sizes are multiples of this, which suits the kernels."""

STRIDE = 64
"""Most cells by which a window moves at once."""


WATCHED = 8
"""Cells next to the fed ones on which feed and lattice are compared."""


def front(speed: float, duration: float) -> float:
    """Sites by which the dispersive front of a signal of that speed is ahead of it."""
    return max(MARGIN, FRONT * (speed * duration / 8.0) ** (1.0 / 3.0))


def fed_cells(moved: int, ratio: float) -> int:
    """Cells that a window feeds when it has moved by so many.

    Signals from its seam, ``ratio`` times as fast as it, have reached them since the last move.
    """
    faster = math.ceil(ratio * moved) - MARGIN // 2  # the rest of the margin is their front
    return moved + max(moved, faster) + MARGIN


def least_window(reach: int, ratio: float = 1.0) -> int:
    """Fewest cells of a window whose ends keep away from the cells within ``reach``."""
    return 2 * (reach + max(2 * (STRIDE + MARGIN), fed_cells(STRIDE + 1, ratio) + WATCHED))


def round_up(sites: float) -> int:
    """The next multiple of ``SIZE_MULTIPLE``."""
    return SIZE_MULTIPLE * math.ceil(sites / SIZE_MULTIPLE)


@dataclass(frozen=True)
class ComparedCells:
    """The cells that are compared: within ``reach`` (one an axis) of where the frame is."""

    speed: float
    reach: tuple[int, ...]

    def middle(self, t: float) -> int:
        """The cell nearest to the frame's origin along the first axis."""
        return nearest_cell(self.speed, t)

    def cells(self, t: float) -> Array:
        """They themselves, (sites,) or (axes, *sites)."""
        ends = ((self.middle(t), self.reach[0]), *((0, reach) for reach in self.reach[1:]))
        return _grid([(middle - reach, middle + reach) for middle, reach in ends])

    def ring(self, times: Sequence[float], signals: Sequence[float], wider: int) -> list[Ends]:
        """First and last cell, along each axis, of a ring that no compared cell sees the end of.

        ``signals`` are the speeds of the fastest waves along each axis.
        """
        found = []
        for axis, (reach, speed) in enumerate(zip(self.reach, signals, strict=True)):
            rooms = [
                (
                    self.middle(t) if axis == 0 else 0,
                    reach + math.ceil(_signal(speed, t - times[0])),
                )
                for t in times
            ]
            low, high = (min(m - r for m, r in rooms), max(m + r for m, r in rooms))
            found.append((low - wider // 2, high + wider - wider // 2))
        return found

    def places(self, ring: Sequence[Ends], t: float, beyond: int = 0) -> tuple[slice, ...]:
        """Where they are on the ring, and so many cells beyond."""
        middles = (self.middle(t), *(0 for _ in self.reach[1:]))
        return tuple(
            slice(max(0, middle - reach - beyond - low), middle + reach + beyond - low + 1)
            for middle, reach, (low, _) in zip(middles, self.reach, ring, strict=True)
        )


Ends = tuple[int, int]
"""The first and the last cell of a ring along an axis."""


def _signal(speed: float, duration: float) -> float:
    """Cells that a signal and its dispersive front travel."""
    return speed * duration + front(speed, duration)


def _grid(ends: Sequence[Ends]) -> Array:
    axes = [np.arange(low, high + 1, dtype=np.float64) for low, high in ends]
    return axes[0] if len(axes) == 1 else np.stack(np.meshgrid(*axes, indexing="ij"))


def sites_of(ends: Sequence[Ends]) -> int:
    """The number of cells of a ring."""
    return math.prod(high - low + 1 for low, high in ends)


def _signal_speeds(lattice: NumericLattice, slopes: list[float]) -> list[float]:
    return [largest_group_velocity(lattice, slopes, axis) for axis in range(lattice.dimension)]


def expected_rings(
    wave: LatticeWave,
    compared: ComparedCells,
    times: Sequence[float],
    tolerance: float | None = None,
) -> ExpectedCost:
    """What a search is expected to take, by the lattice's waves about its rest.

    With a ``tolerance`` a window may be taken.
    """
    lattice = wave.lattice
    rest = lattice.rest_slopes()
    frequency, signals = lattice.highest_frequency(rest), _signal_speeds(lattice, rest)
    extent = _fed_extent(wave, times, tolerance)
    window = _window_size(wave, compared, times, signals, extent)
    room = wave.seam_room(times[0]) if wave.watches_strains else 0  # others' are short
    return _cost(wave, compared, times, frequency, signals, window, room)[1]


def _fed_extent(
    wave: LatticeWave, times: Sequence[float], tolerance: float | None
) -> tuple[float, float] | None:
    """The extent of a wave that a window can be fed with; None for another, or no tolerance."""
    lost = wave.disorder is not None or wave.losses is not None
    if tolerance is None or lost or wave.far_speed is None:
        return None
    return wave.extent(times, tolerance)


def _window_size(
    wave: LatticeWave,
    compared: ComparedCells,
    times: Sequence[float],
    signals: Sequence[float],
    extent: tuple[float, float] | None,
) -> int | None:
    """Fewest cells of a window that holds the wave's extent, None where a ring has fewer.

    Signals from its rear, which run through the far field, must not reach the compared cells. A
    wave that runs ahead of its frame makes a window so wide that a ring has fewer cells.
    """
    if extent is None:
        return None
    (low, high), fastest = extent, wave.far_fastest
    reach = max(float(compared.reach[0]), -low, high)
    drift = max(0.0, fastest - wave.speed) * (times[-1] - times[0])
    size = round_up(least_window(math.ceil(reach + drift), fastest / wave.speed))
    return size if size < sites_of(compared.ring(times, signals, 0)) else None


def _cost(
    wave: LatticeWave,
    compared: ComparedCells,
    times: Sequence[float],
    fastest: float,
    signals: Sequence[float],
    window: int | None,
    room: int,
) -> tuple[float, ExpectedCost]:
    """The cells of the widest ring, or of a window, and what the search takes."""
    more = WIDER + 2 * (wave.lattice.spread_within(times[-1] - times[0]) + room)
    cells = float(window or sites_of(compared.ring(times, signals, more)))
    shortest = max(
        fastest / (LIMIT_SHARE * stability_limit(SCHEME)),
        1.0 / (DRIVEN_SHARE * wave.lattice.driven_within(times[0], times[:2][-1])),
    )
    steps = (times[-1] - times[0]) * shortest
    kept = math.prod(2.0 * reach + 1.0 for reach in compared.reach) * len(times)
    part = part_of(wave, compared, times, signals)
    share = 1.0
    if part is not None and window is None:
        kept *= SHOWN
        share = sites_of(part.ring(times, signals, WIDER)) / cells + 1.0 / USUAL_RUNS
    found = search_cost(wave.lattice, cells, steps * share, SCHEME.stages, kept)
    return cells, replace(found, steps=steps)


FITTING = 64
"""Cells by which a ring is made wider at most, or by a wavelength, for a wave to close on it."""

MOST_FITTING = 4096
"""Most rings that are tried for that."""

CLOSED, BESIDE = 1e-6, 4
"""Share of itself by which a carrier may miss itself at a seam, in so many cells beside it."""

REPEATED = 100.0
"""X on either side of the frame, in which a wave that does not end has shown what it does."""


def part_of(
    wave: LatticeWave, compared: ComparedCells, times: Sequence[float], signals: Sequence[float]
) -> ComparedCells | None:
    """The compared cells of a large chain that stand for all, or None.

    Of a wave that ends they hold all that it may reach: elsewhere nothing happens.
    """
    [reach, *others] = compared.reach
    if others or 2 * reach < LARGE or wave.disorder is not None:
        return None
    ends = wave.support(times[0])
    reached = REPEATED / wave.eps
    if math.isfinite(ends[1] - ends[0]):
        reached = max(
            abs(end - wave.speed * t) + _signal(signals[0], t - times[0])
            for end in ends
            for t in times
        )
    elif wave.watches_strains:
        low, high = wave.extent(times, PART_TOLERANCE)
        travelled = _signal(wave.speed + signals[0], times[-1] - times[0])
        reached = max(reached, PERIODS * wave.seam_room(times[0]))
        reached += max(0.0, -low, high) + travelled
    part = math.ceil(reached)
    return replace(compared, reach=(part,)) if SHARE * part <= reach else None


PART_TOLERANCE = 1e-6
"""Deviation from a periodic background beyond which a part holds a wave at all times."""

PERIODS = 20
"""The same of a periodic background, in wavelengths."""


class DomainPlan:
    """The domains of one wave at ``times``, the first of which is the start: rings and windows.

    ``signals`` are the speeds of the fastest waves along each axis, ``fastest`` is the highest
    frequency of any; ``room`` cells at either end of a ring make its ends meet. ``window`` is the
    size of a window that has fewer cells, if there is one for a run to this ``tolerance``;
    ``extent`` is that of a wave which windows hold. Where they are not ``closed``, their ends are
    left as they are. A scene that ``is_stated`` says how many cells it takes. Raises ValueError,
    before anything large is made, for what would take too long or too much memory, and for an
    unstable lattice.
    """

    def __init__(
        self,
        wave: LatticeWave,
        compared: ComparedCells,
        times: Sequence[float],
        tolerance: float | None = None,
        closed: bool = True,
        is_stated: bool = False,
    ) -> None:
        self.wave, self.compared, self.times = wave, compared, tuple(times)
        self._is_stated = is_stated
        self.tolerance, self.extent = tolerance, _fed_extent(wave, times, tolerance)
        lattice = wave.lattice
        rest = lattice.rest_slopes()
        self.room = wave.seam_room(self.times[0]) if closed else 0
        self._check_cost(lattice.highest_frequency(rest), _signal_speeds(lattice, rest))
        near = wave.ring(compared.cells(self.times[0]), self.times[0])
        stiffest = [stiffest_slopes(near)]
        met = wave.stretch_range(self.times)
        if met is None:
            stiffest += map(stiffest_slopes, self._beside())
        else:
            met = (1.0 + GROWN) * met
            stiffest.append([lattice.steepest(place, met) for place in range(len(rest))])
        slopes = np.max(stiffest, axis=0).tolist()
        self.signals = [
            max(pair)
            for pair in zip(
                _signal_speeds(lattice, rest), _signal_speeds(lattice, slopes), strict=True
            )
        ]
        if not wave.watches_strains:
            check_rest(near.lattice, wave.rest_slopes(near))
        self.fastest = max(near.lattice.highest_frequency(slopes), lattice.highest_frequency(rest))
        self._check_cost(self.fastest, self.signals)
        self._spread = wave.lattice.spread_within(self.times[-1] - self.times[0])
        self._fitting: dict[int, int] = {}
        self.sizes = self._sizes(near)

    def _check_cost(self, fastest: float, signals: Sequence[float]) -> None:
        wave, compared, times = self.wave, self.compared, self.times
        self.window = _window_size(wave, compared, times, signals, self.extent)
        cells, self.expected = _cost(
            wave, compared, times, fastest, signals, self.window, self.room
        )
        if not self._is_stated:
            check_request(
                f"scene of {cells:.3g} cells, from which signals arrive in time,",
                self.expected,
                "take a larger eps, end earlier or compare fewer cells",
            )

    def _beside(self) -> Iterator[InitialCells]:
        """A chain's wave where it is at first, in pieces: it may run to the compared cells.

        A soliton outside them may be faster than any signal among them, and be left out.
        """
        low, high = self.wave.support(self.times[0])
        if self.wave.lattice.dimension > 1 or not math.isfinite(high - low):
            return
        check_request(
            f"wave that is {high - low:.3g} cells wide",
            ExpectedCost(CELL_SECONDS * (high - low)),
            "take a larger eps",
        )
        reach = self.wave.lattice.reach
        for first in range(math.floor(low), math.ceil(high) + 1, PIECE):
            last = min(first + PIECE, math.ceil(high)) + 2 * reach + 2
            yield self.wave.ring(np.arange(first, last, dtype=np.float64), self.times[0])

    def check_wider(self, window: int | None) -> None:
        """Refuse a wider window, or a ring, that takes too long or too much memory."""
        cells, expected = _cost(
            *(self.wave, self.compared, self.times, self.fastest, self.signals),
            *(window, self.room),
        )
        check_request(
            f"scene of {cells:.3g} cells, since no smaller window can be fed with its wave,",
            expected,
            "take a larger eps, end earlier or compare fewer cells",
        )

    def ends(self, wider: int = 0) -> list[Ends]:
        """The ends, along each axis, of a ring by so many cells wider than it must be.

        By a few more where a wave that does not end closes on that ring as it does not on less.
        """
        if self._fills_line and wider not in self._fitting:
            most = max(FITTING, self.room)
            tried = np.unique(np.linspace(0.0, most - 1.0, min(most, MOST_FITTING)).astype(int))
            gaps = self.gaps([self.plain_ends(wider + more)[0] for more in tried.tolist()])
            closed = np.flatnonzero(gaps <= CLOSED)
            self._fitting[wider] = int(tried[closed[0] if closed.size else np.argmin(gaps)])
        return self.plain_ends(wider + self._fitting.get(wider, 0))

    @property
    def _fills_line(self) -> bool:
        """Whether the wave is a periodic one that does not end, and a chain's ring has a seam."""
        wave = self.wave
        filled = math.isinf(max(map(abs, wave.support(self.times[0]))))
        is_periodic = wave.frequency or self.room
        return bool(filled and is_periodic and wave.lattice.dimension == 1)

    def gaps(self, domains: Sequence[Ends]) -> Array:
        """By how much a carrier misses itself at the seam of each ring, in units of itself."""
        beside = np.arange(-BESIDE, BESIDE + 1)
        sides = []
        for firsts in (
            np.array([low for low, _ in domains]),
            np.array([high + 1 for _, high in domains]),
        ):
            cells = np.arange(firsts.min() - BESIDE, firsts.max() + BESIDE + 1)
            f, v = self.wave.state(cells.astype(np.float64), self.times[0])
            places = firsts[:, np.newaxis] + beside - cells[0]
            sides.append(
                np.concatenate([np.diff(f[:, places]), v[:, places] / self.wave.turn], axis=2)
            )
        size = max(float(np.max(np.abs(sides[0]))), 1e-300)
        return np.asarray(np.abs(sides[0] - sides[1]).max(axis=(0, 2)) / size)

    def located(self, found: BlowUp, ends: Sequence[Ends]) -> BlowUp:
        """A blow-up, with its distance from a seam at which the wave does not close.

        None is told where no signal from there can have come in time.
        """
        if len(ends) > 1 or not self._is_open(ends):
            return found
        [(low, high)] = ends
        distance = min(found.site - low, high - found.site)
        reach = 2 * self.room + _signal(self.signals[0], found.t - self.times[0])
        return replace(found, from_seam=distance) if distance <= reach else found

    def _is_open(self, ends: Sequence[Ends]) -> bool:
        """Whether a chain's ring has a seam at which the wave does not close."""
        if self.wave.frequency and self._fills_line:
            return bool(self.gaps(ends)[0] > CLOSED)
        return not self.room and self.wave.seam_room(self.times[0]) > 0

    def plain_ends(self, wider: int) -> list[Ends]:
        """The same ends, whether or not a carrier closes there."""
        more = 2 * (self.room + self._spread) + wider
        return self.compared.ring(self.times, self.signals, more)

    def ring(self, ends: Sequence[Ends]) -> InitialCells:
        """The wave at the first time on the ring with these ends."""
        return self.wave.closed(self.wave.ring(_grid(ends), self.times[0]), self.room)

    def fading(self) -> Fading | None:
        """What fades cells of a closed ring from which no compared one can be reached any more."""
        return self.wave.fading(self.times[0], self.signals[0])

    def limit(self, ring: InitialCells) -> float:
        """The largest that may be seen of a run from this state, in units of the scale."""
        largest = max(float(np.max(sizes[0])) for sizes in (self.sizes, self._sizes(ring)))
        return GROWTH * largest / self.wave.scale

    def _sizes(self, ring: InitialCells) -> Array:
        """The largest that is seen of each quantity and rate on a ring, and step to the next cell.

        An array (2, 2, quantities).
        """
        cells, reach = ring.f.shape[-1], self.wave.lattice.reach
        if ring.cells.ndim > 1 or cells <= PIECE:
            return _largest(self.wave.seen(ring.f, ring.v, ring.mean_strain))
        ends = [*range(reach, cells - reach, PIECE), cells - reach]
        found = [
            _largest(self.wave.seen_at(ring.f, ring.v, ring.mean_strain, (slice(first, last),)))
            for first, last in itertools.pairwise(ends)
        ]
        return np.asarray(np.max(found, axis=0))


def _largest(seen: Array) -> Array:
    axes = tuple(range(2, seen.ndim))
    steps = np.abs(np.diff(seen, axis=2)).max(axis=axes, initial=0.0)
    return np.stack([np.abs(seen).max(axis=axes), steps])


def longest_step(fastest: float, carrier: float, scheme: Scheme = SCHEME) -> float:
    """The longest step tried where these are the frequencies of the fastest wave and the carrier.

    >>> longest_step(2.0, 0.5) == LIMIT_SHARE * stability_limit(SCHEME) / 2.0
    True
    >>> longest_step(2.0, 2.0) == LAWFUL_TURN / 2.0
    True
    """
    stable = LIMIT_SHARE * stability_limit(scheme) / fastest
    return min(stable, LAWFUL_TURN / carrier) if carrier else stable


def check_rest(lattice: NumericLattice, slopes: Sequence[float]) -> None:
    """Refuse a lattice that is unstable where its forces have these slopes, beside the wave."""
    if not lattice.is_stable(slopes):
        raise ValueError(
            f"constants must make waves of {lattice.name} stable, got one that grows at "
            "rest, beside the wave (take stiffer springs)"
        )


def stiffest_slopes(ring: InitialCells) -> list[float]:
    """The largest slope of each bond's force about the stretches of a state.

    Raises ValueError where a force is not defined, or a contact is open.
    """
    stretches = ring.lattice.stretches(ring.f)
    found = [ring.lattice.steepest(place, x) for place, x in enumerate(stretches)]
    is_open = any(
        bond.force.opening is not None and not bond.force.slope(x).all()
        for bond, x in zip(ring.lattice.bonds, stretches, strict=True)
    )
    if is_open or not all(map(math.isfinite, found)):
        raise ValueError(
            f"eps must leave every bond of {ring.lattice.name} within its force, got a wave that "
            "stretches one beyond what its force is for (take a smaller eps)"
        )
    return found

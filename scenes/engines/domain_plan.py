"""Computational domains of a wave, causal rings and moving windows: their cells and their cost.

A causal ring contains every cell whose signals can reach a compared cell during the run, so its
seam does not affect the comparison. A long wave on a constant background is run in a moving window
instead if the window has fewer cells.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import add, sub

import numpy as np

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.schemes import REDUCED_PHASE_6, Scheme, stability_limit
from longwave.lattice.state import GROWTH, BlowUp
from longwave.lattice.trial import DRIVEN_SHARE
from longwave.scenes.engines import ring_cost
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.scenes.starts.lattice_wave import LatticeWave, largest_group_velocity, nearest_cell
from longwave.solutions.pieces import PIECE
from longwave.support.real_arrays import Array
from longwave.support.request_limits import ExpectedCost, check_request

SCHEME = REDUCED_PHASE_6

LIMIT_FRACTION = 0.9
"""Longest step tried, in units of the stability limit at the stiffest bonds of the data."""

MAX_CARRIER_TURN = 3.3
"""Longest step tried, in radians of the carrier's phase. Up to this step the error of a linear wave
follows the scheme's order to within a tenth; at 4.7 the amplitude error changes its sign."""

EXTRA_CELLS = 64
"""Number of cells by which a control run's ring is longer along each axis."""

STRAIN_GROWTH = 0.05
"""Fraction by which strains on the lattice are assumed to exceed those of the wave. Larger strains
occur on few cells and for a short time, so their faster signals do not travel far."""

OUTER_CELLS = 32
"""Number of cells beyond the compared ones that are inspected for growth of rounding errors."""

FRONT_CELLS = 64
"""Cells that a window reserves for a signal's dispersive front, beyond the distance of sound."""

FRONT_AIRY_LENGTHS = 12.0
"""Distance by which a signal's front leads the sound, in Airy lengths: Ai(12) is 1e-13."""

SIZE_MULTIPLE = 64
"""Number of cells of which every window size is a multiple; it suits the kernels."""

MOVE_CELLS = 64
"""Maximum number of cells by which a window moves at once."""

REMEDY = "take a larger eps, end earlier or compare fewer cells"
"""Remedy in the message about a run that would cost too much."""

CHECKED_CELLS = 8
"""Number of cells next to the filled front cells in which the fed values are checked."""


def front(speed: float, duration: float) -> float:
    """Return the distance in cells by which the dispersive front of a signal leads the signal."""
    return max(FRONT_CELLS, FRONT_AIRY_LENGTHS * (speed * duration / 8.0) ** (1.0 / 3.0))


def fed_cells(moved: int, ratio: float) -> int:
    """Return the number of front cells that a window fills after it has ``moved`` by some cells.

    Signals from the seam, ``ratio`` times as fast as the window, may have reached these cells.
    """
    # the dispersive front takes the other half
    faster = math.ceil(ratio * moved) - FRONT_CELLS // 2
    return moved + max(moved, faster) + FRONT_CELLS


def least_window(reach: int, ratio: float = 1.0) -> int:
    """Return the fewest cells of a window whose ends do not affect the cells within ``reach``.

    ``ratio`` is the speed of the fastest signal divided by the speed of the window.
    """
    front_part = fed_cells(MOVE_CELLS + 1, ratio) + CHECKED_CELLS
    return 2 * (reach + max(2 * (MOVE_CELLS + FRONT_CELLS), front_part))


def round_up(sites: float) -> int:
    """Return the smallest multiple of `SIZE_MULTIPLE` that is at least ``sites``."""
    return SIZE_MULTIPLE * math.ceil(sites / SIZE_MULTIPLE)


@dataclass(frozen=True)
class ComparedCells:
    """Cells that are compared: those within ``reach`` (per axis) of a moving frame's origin."""

    speed: float
    reach: tuple[int, ...]

    def middle(self, t: float) -> int:
        """Return the cell nearest to the frame's origin along the first axis."""
        return nearest_cell(self.speed, t)

    def cells(self, t: float) -> Array:
        """Return the compared cells; shape (sites,) on a chain, (axes, *sites) on a plane."""
        ends = ((self.middle(t), self.reach[0]), *((0, reach) for reach in self.reach[1:]))
        return _grid([(middle - reach, middle + reach) for middle, reach in ends])

    def ring(self, times: Sequence[float], signals: Sequence[float], wider: int) -> list[Ends]:
        """Return the first and last cell, along each axis, of a causal ring.

        No signal from the ring's seam reaches a compared cell at any of ``times``. ``signals`` are
        the speeds of the fastest waves along each axis; ``wider`` is a number of additional cells.
        """
        ends = []
        for axis, (reach, speed) in enumerate(zip(self.reach, signals, strict=True)):
            middles = [self.middle(t) if axis == 0 else 0 for t in times]
            halves = [reach + math.ceil(_signal(speed, t - times[0])) for t in times]
            low, high = min(map(sub, middles, halves)), max(map(add, middles, halves))
            ends.append((low - wider // 2, high + wider - wider // 2))
        return ends

    def slices(self, ring: Sequence[Ends], t: float, beyond: int = 0) -> tuple[slice, ...]:
        """Return the slices of the compared cells on a ring, one an axis.

        ``ring`` holds its ends along each axis; ``beyond`` cells are added on every side.
        """
        middles = (self.middle(t), *(0 for _ in self.reach[1:]))
        return tuple(
            slice(max(0, middle - reach - beyond - low), middle + reach + beyond - low + 1)
            for middle, reach, (low, _) in zip(middles, self.reach, ring, strict=True)
        )


Ends = tuple[int, int]
"""First and last cell of a ring along an axis."""


def _signal(speed: float, duration: float) -> float:
    """Return the number of cells that a signal travels, its dispersive front included."""
    return speed * duration + front(speed, duration)


def _grid(ends: Sequence[Ends]) -> Array:
    axes = [np.arange(low, high + 1, dtype=np.float64) for low, high in ends]
    return axes[0] if len(axes) == 1 else np.stack(np.meshgrid(*axes, indexing="ij"))


def count_cells(ends: Sequence[Ends]) -> int:
    """Return the number of cells of a ring with these ends."""
    return math.prod(high - low + 1 for low, high in ends)


def _signal_speeds(lattice: NumericLattice, slopes: list[float]) -> list[float]:
    return [largest_group_velocity(lattice, slopes, axis) for axis in range(lattice.dimension)]


class DomainCost:
    """Size of the domain of one wave, and expected cost of the search for its time step.

    The run goes from the first to the last of ``times``. ``extent`` is the wave's extent (low,
    high), in cells from the frame's origin, if the wave can be run in a window to ``tolerance``;
    otherwise None. ``room`` is the number of cells at either end of a ring that are blended to
    close it; 0 if the domains are not ``closed``.
    """

    def __init__(
        self,
        wave: LatticeWave,
        compared: ComparedCells,
        times: Sequence[float],
        tolerance: float | None = None,
        closed: bool = True,
    ) -> None:
        self.wave, self.compared, self.times = wave, compared, tuple(times)
        self.tolerance, self.extent = tolerance, None
        is_perturbed = wave.disorder is not None or wave.losses is not None
        if not (tolerance is None or is_perturbed or wave.far_speed is None):
            self.extent = wave.extent(times, tolerance)
        self.room = wave.seam_room(self.times[0]) if closed else 0

    def at_rest(self) -> tuple[float, list[float]]:
        """Return the highest frequency and each axis's top speed of linear waves about rest."""
        lattice, rest = self.wave.lattice, self.wave.lattice.rest_slopes()
        return lattice.highest_frequency(rest), _signal_speeds(lattice, rest)

    @property
    def driven_step(self) -> float:
        """Longest step tried on a lattice with time-dependent parameters; infinite without them."""
        return DRIVEN_SHARE * self.wave.lattice.driven_within(self.times[0], self.times[:2][-1])

    def window_size(self, signals: Sequence[float]) -> int | None:
        """Return the size of the smallest window that holds the wave; None if a ring is smaller.

        ``signals`` are the top speeds along each axis. Signals from the window's rear, which travel
        through the far field, must not reach the compared cells. A wave that runs ahead of its
        frame needs so wide a window that a ring is smaller.
        """
        if self.extent is None:
            return None
        (low, high), fastest, speed = self.extent, self.wave.far_fastest, self.wave.speed
        reach = max(float(self.compared.reach[0]), -low, high)
        drift = max(0.0, fastest - speed) * (self.times[-1] - self.times[0])
        size = round_up(least_window(math.ceil(reach + drift), fastest / speed))
        return size if size < count_cells(self.compared.ring(self.times, signals, 0)) else None

    def cost(
        self, fastest: float, signals: Sequence[float], window: int | None
    ) -> tuple[float, ExpectedCost]:
        """Return the number of cells and the cost of a run in a ``window`` or, if None, on a ring.

        ``fastest`` is the highest frequency, ``signals`` are the top speeds along each axis.
        """
        wave, compared, times = self.wave, self.compared, self.times
        duration = times[-1] - times[0]
        more = EXTRA_CELLS + 2 * (wave.lattice.spread_within(duration) + self.room)
        cells = float(window or count_cells(compared.ring(times, signals, more)))
        limit = LIMIT_FRACTION * stability_limit(SCHEME)
        steps = duration * max(fastest / limit, 1.0 / self.driven_step)
        values = math.prod(2.0 * reach + 1.0 for reach in compared.reach) * len(times)
        part = representative_cells(wave, compared, times, signals)
        ratio = 1.0
        if part is not None and window is None:
            values *= ring_cost.SINGLE_RUN_FRACTION
            ratio = count_cells(part.ring(times, signals, EXTRA_CELLS)) / cells
            ratio += 1.0 / ring_cost.USUAL_RUNS
        cost = ring_cost.search_cost(wave.lattice, cells, steps * ratio, SCHEME.stages, values)
        return cells, replace(cost, steps=steps)


MAX_ADDED_CELLS = 64
"""Maximum number of cells, or one wavelength, added to close a periodic wave on a ring."""

MAX_RING_SIZES = 4096
"""Maximum number of ring sizes tried for a periodic wave to close on the ring."""

SEAM_TOLERANCE, SEAM_CELLS = 1e-6, 4
"""Largest relative mismatch of a carrier at a closed seam, and the number of cells on either side
of the seam in which it is measured."""

REPEAT_DISTANCE = 100.0
"""Distance in X from the frame's origin beyond which an infinite wave adds nothing new."""


def representative_cells(
    wave: LatticeWave, compared: ComparedCells, times: Sequence[float], signals: Sequence[float]
) -> ComparedCells | None:
    """Return fewer compared cells, which represent all those of a large chain; None if none do.

    For a wave of finite extent, they contain every cell that the wave can reach.
    """
    [reach, *others] = compared.reach
    if others or 2 * reach < ring_cost.LARGE_CELLS or wave.disorder is not None:
        return None
    ends = wave.support(times[0])
    reach_of_wave = REPEAT_DISTANCE / wave.eps
    if math.isfinite(ends[1] - ends[0]):
        paths = [(wave.speed * t, _signal(signals[0], t - times[0])) for t in times]
        reach_of_wave = max(abs(end - x) + signal for end in ends for x, signal in paths)
    elif wave.watches_strains:
        low, high = wave.extent(times, PART_TOLERANCE)
        path = _signal(wave.speed + signals[0], times[-1] - times[0])
        reach_of_wave = max(reach_of_wave, MIN_PERIODS * wave.seam_room(times[0]))
        reach_of_wave += max(0.0, -low, high) + path
    cells = math.ceil(reach_of_wave)
    return replace(compared, reach=(cells,)) if ring_cost.MIN_PART_RATIO * cells <= reach else None


PART_TOLERANCE = 1e-6
"""Deviation from a periodic background above which a cell belongs to the wave."""

MIN_PERIODS = 20
"""Minimum number of wavelengths of a periodic background among representative cells."""


class DomainPlan(DomainCost):
    """Computational domains, rings and windows, of one wave for a run over ``times``.

    ``signals`` are the speeds of the fastest waves along each axis, ``fastest`` is the highest
    frequency of all waves. ``window`` is the size of a window, or None if a ring is smaller. With
    ``is_stated`` the scene itself states the number of cells, and no cost is checked. Raises
    ValueError for an unstable lattice and, before any large array is made, for a run that would
    take too long or too much memory.
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
        super().__init__(wave, compared, times, tolerance, closed)
        self._is_stated, lattice = is_stated, wave.lattice
        frequency, rest_signals = self.at_rest()
        self._check_cost(frequency, rest_signals)
        near = wave.ring(compared.cells(self.times[0]), self.times[0])
        stiffest = [stiffest_slopes(near)]
        stretches = wave.stretch_range(self.times)
        if stretches is None:
            stiffest += map(stiffest_slopes, self._whole_wave())
        else:
            stretches = (1.0 + STRAIN_GROWTH) * stretches
            bonds = range(len(lattice.bonds))
            stiffest.append([lattice.steepest(i, stretches) for i in bonds])
        slopes = np.max(stiffest, axis=0).tolist()
        self.signals = list(map(max, rest_signals, _signal_speeds(lattice, slopes)))
        if not wave.watches_strains:
            check_rest(near.lattice, wave.rest_slopes(near))
        self.fastest = max(near.lattice.highest_frequency(slopes), frequency)
        self._check_cost(self.fastest, self.signals)
        self._spread = wave.lattice.spread_within(self.times[-1] - self.times[0])
        self._fitting: dict[int, int] = {}
        self.sizes = self._sizes(near)

    def _check_cost(self, fastest: float, signals: Sequence[float]) -> None:
        self.window = self.window_size(signals)
        cells, self.expected = self.cost(fastest, signals, self.window)
        if not self._is_stated:
            scene = f"scene of {cells:.3g} cells, from which signals arrive in time,"
            check_request(scene, self.expected, REMEDY)

    def _whole_wave(self) -> Iterator[InitialCells]:
        """Yield the initial data of the whole wave on a chain, piece by piece.

        A soliton that starts outside the compared cells may be faster than any signal inside them
        and reach them during the run.
        """
        low, high = self.wave.support(self.times[0])
        if self.wave.lattice.dimension > 1 or not math.isfinite(high - low):
            return
        cost = ExpectedCost(ring_cost.CELL_SECONDS * (high - low))
        check_request(f"wave that is {high - low:.3g} cells wide", cost, "take a larger eps")
        reach = self.wave.lattice.reach
        for first in range(math.floor(low), math.ceil(high) + 1, PIECE):
            last = min(first + PIECE, math.ceil(high)) + 2 * reach + 2
            yield self.wave.ring(np.arange(first, last, dtype=np.float64), self.times[0])

    def check_wider(self, window: int | None) -> None:
        """Raise ValueError if a run in this ``window`` (None: on a ring) would cost too much."""
        cells, expected = self.cost(self.fastest, self.signals, window)
        scene = f"scene of {cells:.3g} cells, since no smaller window can be fed with its wave,"
        check_request(scene, expected, REMEDY)

    def ends(self, wider: int = 0) -> list[Ends]:
        """Return the ends of a causal ring with ``wider`` more cells, fitted to a periodic wave."""
        if self._fills_line and wider not in self._fitting:
            most = max(MAX_ADDED_CELLS, self.room)
            tried = np.unique(np.linspace(0.0, most - 1.0, min(most, MAX_RING_SIZES)).astype(int))
            rings = [self.plain_ends(wider + more)[0] for more in tried.tolist()]
            mismatches = self.seam_mismatch(rings)
            closed = np.flatnonzero(mismatches <= SEAM_TOLERANCE)
            self._fitting[wider] = int(tried[closed[0] if closed.size else np.argmin(mismatches)])
        return self.plain_ends(wider + self._fitting.get(wider, 0))

    @property
    def _fills_line(self) -> bool:
        """Whether the wave is an infinite periodic wave on a chain."""
        wave = self.wave
        is_infinite = math.isinf(max(map(abs, wave.support(self.times[0]))))
        is_periodic = wave.frequency or self.room
        return bool(is_infinite and is_periodic and wave.lattice.dimension == 1)

    def seam_mismatch(self, rings: Sequence[Ends]) -> Array:
        """Return the wave's mismatch at the seam of each ring, relative to the values there."""
        near = np.arange(-SEAM_CELLS, SEAM_CELLS + 1)
        sides = []
        for firsts in np.array([(low, high + 1) for low, high in rings]).T:
            cells = np.arange(firsts.min() - SEAM_CELLS, firsts.max() + SEAM_CELLS + 1)
            f, v = self.wave.state(cells.astype(np.float64), self.times[0])
            indices = firsts[:, np.newaxis] + near - cells[0]
            rates = v[:, indices] / self.wave.rate_unit
            sides.append(np.concatenate([np.diff(f[:, indices]), rates], axis=2))
        largest = max(float(np.max(np.abs(sides[0]))), 1e-300)
        return np.asarray(np.abs(sides[0] - sides[1]).max(axis=(0, 2)) / largest)

    def with_seam_distance(self, blow_up: BlowUp, ends: Sequence[Ends]) -> BlowUp:
        """Return the blow-up, with its distance from the seam if the seam may have caused it."""
        if len(ends) > 1 or not self._is_open(ends):
            return blow_up
        [(low, high)] = ends
        distance = min(blow_up.site - low, high - blow_up.site)
        reach = 2 * self.room + _signal(self.signals[0], blow_up.t - self.times[0])
        return replace(blow_up, from_seam=distance) if distance <= reach else blow_up

    def _is_open(self, ends: Sequence[Ends]) -> bool:
        """Whether a chain's ring has a seam at which the wave does not close."""
        if self.wave.frequency and self._fills_line:
            return bool(self.seam_mismatch(ends)[0] > SEAM_TOLERANCE)
        return not self.room and self.wave.seam_room(self.times[0]) > 0

    def plain_ends(self, wider: int) -> list[Ends]:
        """Return the ends of a causal ring, without cells added to fit a periodic wave."""
        more = 2 * (self.room + self._spread) + wider
        return self.compared.ring(self.times, self.signals, more)

    def ring(self, ends: Sequence[Ends]) -> InitialCells:
        """Return the wave's initial data on the ring with these ends, blended at its seam."""
        return self.wave.closed_ring(self.wave.ring(_grid(ends), self.times[0]), self.room)

    def limit(self, ring: InitialCells) -> float:
        """Return the largest compared value, in units of the wave's scale, that a run may reach."""
        largest = max(float(np.max(sizes[0])) for sizes in (self.sizes, self._sizes(ring)))
        return GROWTH * largest / self.wave.scale

    def _sizes(self, ring: InitialCells) -> Array:
        """Return largest values and largest cell-to-cell differences on a ring, (2, 2, quantities).

        The second axis has the compared quantities and their rates.
        """
        cells, reach = ring.f.shape[-1], self.wave.lattice.reach
        if ring.cells.ndim > 1 or cells <= PIECE:
            return _largest(self.wave.values_and_rates(ring.f, ring.v, ring.mean_strain))
        ends = [*range(reach, cells - reach, PIECE), cells - reach]
        arrays = ring.f, ring.v, ring.mean_strain
        pieces = [
            _largest(self.wave.values_and_rates_at(*arrays, (slice(first, last),)))
            for first, last in itertools.pairwise(ends)
        ]
        return np.asarray(np.max(pieces, axis=0))


def _largest(values: Array) -> Array:
    axes = tuple(range(2, values.ndim))
    steps = np.abs(np.diff(values, axis=2)).max(axis=axes, initial=0.0)
    return np.stack([np.abs(values).max(axis=axes), steps])


def longest_step(fastest: float, carrier: float, scheme: Scheme = SCHEME) -> float:
    """Return the longest step tried, from the highest frequency and the carrier's frequency.

    >>> longest_step(2.0, 0.5) == LIMIT_FRACTION * stability_limit(SCHEME) / 2.0
    True
    >>> longest_step(2.0, 2.0) == MAX_CARRIER_TURN / 2.0
    True
    """
    stable = LIMIT_FRACTION * stability_limit(scheme) / fastest
    return min(stable, MAX_CARRIER_TURN / carrier) if carrier else stable


def check_rest(lattice: NumericLattice, slopes: Sequence[float]) -> None:
    """Raise ValueError if waves about rest grow; ``slopes`` are those of the forces at rest."""
    if not lattice.is_stable(slopes):
        raise ValueError(
            f"constants must make waves of {lattice.name} stable, got one that grows at "
            "rest, far from the wave (take stiffer springs)"
        )


def stiffest_slopes(ring: InitialCells) -> list[float]:
    """Return the largest slope of each bond's force; ValueError for undefined or open contacts."""
    stretches = ring.lattice.stretches(ring.f)
    slopes = [ring.lattice.steepest(i, x) for i, x in enumerate(stretches)]
    is_open = any(
        bond.force.opening is not None and not bond.force.slope(x).all()
        for bond, x in zip(ring.lattice.bonds, stretches, strict=True)
    )
    if is_open or not all(map(math.isfinite, slopes)):
        raise ValueError(
            f"eps must keep every bond of {ring.lattice.name} where its force is defined, got a "
            "wave that stretches one beyond (take a smaller eps)"
        )
    return slopes

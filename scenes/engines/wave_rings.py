"""Rings of cells about a wave, and runs of them for `lattice.refine` to judge by step and ring.

A ring is causal: it holds every cell from which a signal reaches a compared one in time, so its
seam is never felt there.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.schemes import (
    REDUCED_PHASE_6,
    Scheme,
    check_step,
    scheme_named,
    stability_limit,
)
from longwave.lattice.state import GROWTH, BlowUp, Sites, State
from longwave.lattice.stepper import LEAST_CHUNK, Stepper, StillRing
from longwave.lattice.trial import (
    DRIVEN_SHARE,
    Choices,
    Kind,
    Progress,
    StepSearch,
    StoppedTrial,
    Trial,
    rounding_error,
    shorter_step,
)
from longwave.scenes.chain.domain import front
from longwave.scenes.description.numerics import Discretisation
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.ring_cost import (
    LARGE,
    SHARE,
    SHOWN,
    USUAL_RUNS,
    cell_seconds,
    search_cost,
)
from longwave.scenes.engines.stated_run import run_from
from longwave.scenes.observed.recorders import Samples
from longwave.scenes.observed.run_record import RunRecord, UnfinishedRun
from longwave.scenes.observed.view import View
from longwave.scenes.starts.lattice_wave import CellRing, LatticeWave, largest_group_velocity
from longwave.solutions.pieces import PIECE
from longwave.support.request_limits import ExpectedCost, check_request

Array = NDArray[np.float64]

SCHEME = REDUCED_PHASE_6

LIMIT_SHARE = 0.9
"""Longest step tried, in units of the stability limit at the stiffest bonds of the data."""

LAWFUL_TURN = 3.3
"""Longest step tried, in radians that a carrier turns in it: up to there what a linear wave is off
follows the law of the order within a tenth, and at 4.7 its amplitude's error changes its sign."""

STEP_RATIO = 0.8
"""Step of a control run, in units of the one before it."""

WIDER = 64
"""Cells, along each axis, by which the ring of a control run is wider."""

AROUND = 32
"""Cells beyond the compared ones on which is looked at what rounding has grown to."""

LOOK_SECONDS = 0.02
"""Seconds between two stops, at which it is looked whether the state is finite; Ctrl-C waits."""


@dataclass(frozen=True)
class ComparedCells:
    """The cells that are compared: within ``reach`` (one an axis) of where the frame is."""

    speed: float
    reach: tuple[int, ...]

    def middle(self, t: float) -> int:
        """The cell nearest to the frame's origin along the first axis."""
        return round(self.speed * t)

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
    wave: LatticeWave, compared: ComparedCells, times: Sequence[float]
) -> ExpectedCost:
    """What a search is expected to take, by the lattice's waves about its rest."""
    lattice = wave.lattice
    rest = lattice.rest_slopes()
    frequency, signals = lattice.highest_frequency(rest), _signal_speeds(lattice, rest)
    return _cost(wave, compared, times, frequency, signals)[1]


def _cost(
    wave: LatticeWave,
    compared: ComparedCells,
    times: Sequence[float],
    fastest: float,
    signals: Sequence[float],
) -> tuple[float, ExpectedCost]:
    """The cells of the widest ring, and what the search takes."""
    spread = wave.lattice.spread_within(times[-1] - times[0])
    cells = float(sites_of(compared.ring(times, signals, WIDER + 2 * spread)))
    shortest = max(
        fastest / (LIMIT_SHARE * stability_limit(SCHEME)),
        1.0 / (DRIVEN_SHARE * wave.lattice.driven_within(*times[:2])),
    )
    steps = (times[-1] - times[0]) * shortest
    kept = math.prod(2.0 * reach + 1.0 for reach in compared.reach) * len(times)
    part = part_of(wave, compared, times, signals)
    share = 1.0
    if part is not None:
        kept *= SHOWN
        share = sites_of(part.ring(times, signals, WIDER)) / cells + 1.0 / USUAL_RUNS
    found = search_cost(wave.lattice, cells, steps * share, SCHEME.stages, kept)
    return cells, replace(found, steps=steps)


FITTING = 64
"""Cells by which a ring is made wider at most for a carrier to close on it."""

CLOSED, BESIDE = 1e-6, 4
"""Share of itself by which a carrier may miss itself at a seam, in so many cells beside it."""

ALIKE = 1e-3
"""By what share data may be larger or steeper elsewhere than on a part that stands for all."""

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
    part = math.ceil(reached)
    return replace(compared, reach=(part,)) if SHARE * part <= reach else None


class WaveRings:
    """Rings of one wave at ``times``, the first of which is the start.

    ``signals`` are the speeds of the fastest waves along each axis, ``fastest`` is the highest
    frequency of any; ``room`` cells at either end of a ring make its ends meet. Raises ValueError,
    before anything large is made, for what would take too long or too much memory, and for an
    unstable lattice.
    """

    def __init__(self, wave: LatticeWave, compared: ComparedCells, times: Sequence[float]) -> None:
        self.wave, self.compared, self.times = wave, compared, tuple(times)
        lattice = wave.lattice
        rest = lattice.rest_slopes()
        self._check_cost(lattice.highest_frequency(rest), _signal_speeds(lattice, rest))
        near = wave.ring(compared.cells(self.times[0]), self.times[0])
        slopes = stiffest_slopes(near)
        self.signals = [
            max(pair)
            for pair in zip(
                _signal_speeds(lattice, rest), _signal_speeds(lattice, slopes), strict=True
            )
        ]
        check_rest(near.lattice, wave.rest_slopes(near))
        self.fastest = max(near.lattice.highest_frequency(slopes), lattice.highest_frequency(rest))
        self._check_cost(self.fastest, self.signals)
        self.room = wave.seam_room(self.times[0])
        self._spread = wave.lattice.spread_within(self.times[-1] - self.times[0])
        self._turn = wave.frequency or lattice.highest_frequency(rest)
        self._fitting: dict[int, int] = {}
        self.sizes = self._sizes(near)

    def _check_cost(self, fastest: float, signals: Sequence[float]) -> None:
        cells, self.expected = _cost(self.wave, self.compared, self.times, fastest, signals)
        check_request(
            f"scene of {cells:.3g} cells, from which signals arrive in time,",
            self.expected,
            "take a larger eps, end earlier or compare fewer cells",
        )

    def ends(self, wider: int = 0) -> list[Ends]:
        """The ends, along each axis, of a ring by so many cells wider than it must be.

        By a few more where a carrier that does not end closes on that ring as it does not on less.
        """
        if self._fills_line and wider not in self._fitting:
            gaps = self.gaps([self.plain_ends(wider + more)[0] for more in range(FITTING)])
            closed = np.flatnonzero(gaps <= CLOSED)
            self._fitting[wider] = int(closed[0] if closed.size else np.argmin(gaps))
        return self.plain_ends(wider + self._fitting.get(wider, 0))

    @property
    def _fills_line(self) -> bool:
        """Whether the wave is a carrier that does not end, so that a chain's ring has a seam."""
        filled = math.isinf(max(map(abs, self.wave.support(self.times[0]))))
        return bool(filled and self.wave.frequency and self.wave.lattice.dimension == 1)

    def gaps(self, rings: Sequence[Ends]) -> Array:
        """By how much a carrier misses itself at the seam of each ring, in units of itself."""
        beside = np.arange(-BESIDE, BESIDE + 1)
        sides = []
        for firsts in (
            np.array([low for low, _ in rings]),
            np.array([high + 1 for _, high in rings]),
        ):
            cells = np.arange(firsts.min() - BESIDE, firsts.max() + BESIDE + 1)
            f, v = self.wave.state(cells.astype(np.float64), self.times[0])
            places = firsts[:, np.newaxis] + beside - cells[0]
            sides.append(np.concatenate([np.diff(f[:, places]), v[:, places] / self._turn], axis=2))
        size = max(float(np.max(np.abs(sides[0]))), 1e-300)
        return np.asarray(np.abs(sides[0] - sides[1]).max(axis=(0, 2)) / size)

    def located(self, found: BlowUp, ends: Sequence[Ends]) -> BlowUp:
        """A blow-up, with its distance from a seam at which the wave does not close.

        None is told where no signal from there can have come in time.
        """
        if not self._fills_line or self.gaps(ends)[0] <= CLOSED:
            return found
        [(low, high)] = ends
        distance = min(found.site - low, high - found.site)
        reach = 2 * self.room + _signal(self.signals[0], found.t - self.times[0])
        return replace(found, from_seam=distance) if distance <= reach else found

    def plain_ends(self, wider: int) -> list[Ends]:
        """The same ends, whether or not a carrier closes there."""
        more = 2 * (self.room + self._spread) + wider
        return self.compared.ring(self.times, self.signals, more)

    def ring(self, ends: Sequence[Ends]) -> CellRing:
        """The wave at the first time on the ring with these ends."""
        return self.wave.ring(_grid(ends), self.times[0]).smoothed(self.room)

    def limit(self, ring: CellRing) -> float:
        """The largest that may be seen of a run from this state, in units of the scale."""
        largest = max(float(np.max(sizes[0])) for sizes in (self.sizes, self._sizes(ring)))
        return GROWTH * largest / self.wave.scale

    def _sizes(self, ring: CellRing) -> Array:
        """The largest that is seen of each quantity and rate on a ring, and step to the next cell.

        An array (2, 2, quantities).
        """
        cells, reach = ring.f.shape[-1], self.wave.lattice.reach
        if ring.cells.ndim > 1 or cells <= PIECE:
            return _largest(self.seen(ring, ring.f, ring.v))
        ends = [*range(reach, cells - reach, PIECE), cells - reach]
        found = [
            _largest(self.seen_at(ring, ring.f, ring.v, (slice(first, last),)))
            for first, last in itertools.pairwise(ends)
        ]
        return np.asarray(np.max(found, axis=0))

    def seen(self, ring: CellRing, f: Array, v: Array) -> Array:
        """What is compared, in all cells of a ring, and its rate in the same unit."""
        rates = self.wave.measured(v, (0.0,) * len(ring.mean_strain)) / self._turn
        return np.stack([self.wave.measured(f, ring.mean_strain), rates])

    def seen_at(self, ring: CellRing, f: Array, v: Array, places: Sequence[slice]) -> Array:
        """The same in some of its cells, none of which is at its ends."""
        wide, inner = self.beside(places)
        return np.asarray(self.seen(ring, f[:, *wide], v[:, *wide])[:, :, *inner])

    def beside(self, places: Sequence[slice]) -> tuple[list[slice], list[slice]]:
        """These places with those that their bonds reach, and where they are among them."""
        reach = self.wave.lattice.reach
        wide = [slice(max(0, one.start - reach), one.stop + reach) for one in places]
        starts = [one.start - more.start for one, more in zip(places, wide, strict=True)]
        lengths = [one.stop - one.start for one in places]
        return wide, [slice(s, s + n) for s, n in zip(starts, lengths, strict=True)]


def _largest(seen: Array) -> Array:
    axes = tuple(range(2, seen.ndim))
    steps = np.abs(np.diff(seen, axis=2)).max(axis=axes, initial=0.0)
    return np.stack([np.abs(seen).max(axis=axes), steps])


class RingCells:
    """The cells of a ring as they are stepped, with the members that `ChainSites` has.

    The scene has times of the lattice. Its ring has as many sites as it says, unless its ``ends``
    are given. Raises ValueError for a ring that is too small.
    """

    def __init__(
        self,
        scene: Scene,
        rings: WaveRings,
        ends: list[Ends] | None = None,
        nudged: bool = False,
    ) -> None:
        self.scene, self.rings, self._nudged = scene, rings, nudged
        self.scale, self.reach = rings.wave.scale, rings.compared.reach
        if ends is None:
            least, sites = sites_of(rings.plain_ends(0)), scene.discretisation.sites
            if sites < least:
                raise ValueError(
                    f"sites must satisfy sites >= {least} on this ring, got {sites} (else signals "
                    "from the seam reach the compared sites; widen it or end earlier)"
                )
            ends = rings.plain_ends(sites - least)
        self.ends = ends

    @property
    def task(self) -> str:
        """Everything that its states follow from: scene, ring, whether last digits are changed."""
        return f"{self.scene.json()} on {self.ends}{' nudged' if self._nudged else ''}"

    @cached_property
    def ring(self) -> CellRing:
        """The data, until they are stepped: there is one copy of a large ring."""
        ring = self.rings.ring(self.ends)
        return ring.nudged() if self._nudged else ring

    def stepper(self, restart: State | None) -> tuple[Stepper, float]:
        """What steps the cells, and the largest stable step."""
        stated = self.scene.discretisation
        limit = check_step(stated.step, stated.table, self.rings.fastest)
        if restart is not None:
            self.ends = _ends_of(restart, self.rings.plain_ends(0))
        ring = self.ring
        state = State(ring.t, ring.f, ring.v)
        if restart is not None:
            shape = state.f.shape
            state = State(restart.t, restart.f.reshape(shape), restart.v.reshape(shape))
        domain = CellDomain(state, self.ends, self.rings)
        return ring_stepper(ring.lattice, domain, stated.table, stated.step), limit

    def view(self, state: State) -> CellView:
        """The compared cells."""
        return CellView(self, state)

    def refined(self, scene: Scene) -> RingCells:
        """The cells of a finer scene."""
        return RingCells(scene, self.rings)

    def told(self, stepper: Stepper) -> dict[str, Any]:
        """The sites of the ring, which on a plane the scene does not say."""
        return {"sites": sites_of(self.ends)}


def _ends_of(restart: State, needed: Sequence[Ends]) -> list[Ends]:
    """The ends of the ring that a state of a chain was kept on."""
    first, last = restart.left, restart.left + restart.f.shape[-1] - 1
    low, high = needed[0]
    if low < first or high > last:
        raise ValueError(
            f"snapshots must leave the state's ring wide enough, got {first} .. {last} where "
            f"signals come from {low} .. {high} (end earlier, or run the scene to the later time)"
        )
    return [(first, last)]


@dataclass
class CellDomain(StillRing):
    """A ring of cells with these ends."""

    ends: Sequence[Ends]
    rings: WaveRings

    def locate(self, found: BlowUp, state: State) -> BlowUp:
        """``found``, with the cell in the place of where it is stored."""
        columns = state.f[0].size // state.f.shape[1]
        site = self.ends[0][0] + found.site // columns
        return self.rings.located(replace(found, site=site), self.ends)


def ring_stepper(
    lattice: NumericLattice, domain: StillRing, scheme: Scheme, step: float
) -> Stepper:
    """What steps a ring, with a stop every ``LOOK_SECONDS``, of a chain or `LEAST_CHUNK` steps."""
    state = domain.state
    seconds = cell_seconds(lattice) * state.f[0].size
    least = LEAST_CHUNK if lattice.dimension == 1 else 1
    chunk = max(least, int(LOOK_SECONDS / (scheme.stages * seconds)))
    return Stepper(state, scheme, lattice, domain, step, None, chunk)


@dataclass(frozen=True)
class CellView(View):
    """A wave on any lattice, seen in the compared cells of a ring."""

    held: RingCells
    state: State

    @property
    def level(self) -> float:
        """The uniform strain that the wave is added to."""
        return float(self._wave.uniform()[0])

    @property
    def travelled(self) -> float:
        """At the speed of the wave's frame."""
        return self._wave.speed * self.t

    @property
    def crest_law(self) -> float | None:
        """That of the first quantity, by the wave's own law."""
        return self._wave.crest(self.t)

    @cached_property
    def sites(self) -> Sites:
        """The compared cells along the first axis."""
        cells = self._cells if self._cells.ndim == 1 else self._cells[0, :, 0]
        return cells.astype(np.int64)

    @cached_property
    def numerics(self) -> Array:
        """All quantities that are compared, of the run: a copy, for the state goes on."""
        wide, inner = self.held.rings.beside(self._places(self.held.rings.compared))
        found = self._wave.measured(self.state.f[:, *wide], self.held.ring.mean_strain)
        return np.array(found[:, *inner])

    @cached_property
    def analytics(self) -> Array:
        """The same of the wave."""
        return self._wave.strain(self._cells, self.t)

    @cached_property
    def backgrounds(self) -> Array:
        """The same of what it deviates from."""
        return np.asarray(self._wave.background(self._cells, self.t), dtype=np.float64)

    @property
    def also(self) -> dict[str, Any]:
        """The sup error in its unit, T, and all quantities if there are more than one."""
        apart = float(np.max(np.abs(self.numerics - self.analytics))) / self.held.scale
        found = {"sup_error": apart, "slow_time": self.t * self._wave.eps**self._wave.slow}
        if len(self.numerics) == 1:
            return found
        return found | {"strains": self.numerics, "analytics": self.analytics}

    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Wave, background and their slopes, which are differences."""
        at = [self._cells - shift + apart for apart in (0.0, SLOPE_APART, -SLOPE_APART)]
        found = []
        for made in (self._wave.strain, self._wave.background):
            value, ahead, behind = (np.asarray(made(cells, self.t)[0]) for cells in at)
            found += [value, (ahead - behind) / (2.0 * SLOPE_APART)]
        return found[0], found[2], found[1], found[3]

    @property
    def energy(self) -> float:
        """That of the ring of displacements."""
        with np.errstate(all="ignore"):
            return self.held.ring.lattice.energy(self.state.f, self.state.v)

    @property
    def means(self) -> tuple[float, float]:
        """Of the first quantity over the ring, and of the velocities of all masses."""
        lattice = self.held.ring.lattice
        strain = self._wave.measured(self.state.f, self.held.ring.mean_strain)[0]
        masses = np.array(lattice.masses)
        velocities = self.state.v.reshape(masses.size, -1).mean(axis=1)
        return float(np.mean(strain)), float(np.average(velocities, weights=masses))

    @property
    def stored(self) -> tuple[int, Array, Array]:
        """The periodic parts of the fields; without an axis for a single one."""
        f, v = (values[0] if len(values) == 1 else values for values in self.state.arrays)
        return self.held.ends[0][0], f.copy(), v.copy()

    def judged(self, beyond: int = 0, compared: ComparedCells | None = None) -> Array:
        """What is compared, in these cells and some beyond, and its rate, in units of the scale."""
        places = self._places(compared or self.held.rings.compared, beyond)
        seen = self.held.rings.seen_at(self.held.ring, *self.state.arrays, places)
        return seen / self.held.scale

    @property
    def _wave(self) -> LatticeWave:
        return self.held.rings.wave

    @cached_property
    def _cells(self) -> Array:
        return self.held.rings.compared.cells(self.t)

    def _places(self, compared: ComparedCells, beyond: int = 0) -> tuple[slice, ...]:
        return compared.places(self.held.ends, self.t, beyond)


SLOPE_APART = 1e-3
"""Cells on either side of which the difference is a slope: a wave is much longer."""


class SiteRingEngine(StepSearch):
    """Runs of a scene's wave on rings.

    The scene has times of the lattice. Values are what is compared, in units of the wave's scale,
    and its rate: an error that passes through 0 at one of the times does not seem to be none. The
    payload is a `RunRecord`; ``metered`` holds what the wave's meter gave, by step. Of the compared
    cells only those ``judged`` are, if they are given.
    """

    def __init__(self, scene: Scene, rings: WaveRings, judged: ComparedCells | None = None) -> None:
        self.scene, self.rings = scene, rings
        wave, self.times = rings.wave, rings.times
        self._scheme = scheme_named(scene.target.scheme) if scene.target.scheme else SCHEME
        self._fields = len(wave.lattice.fields)
        self.amplifies_rounding = math.isinf(max(map(abs, wave.support(self.times[0]))))
        self.judged = judged or rings.compared
        self.metered: dict[float, Array] = {}
        longest = longest_step(rings.fastest, wave.frequency, self._scheme)
        longest = min(longest, DRIVEN_SHARE * wave.lattice.driven_within(*self.times[:2]))
        sites = float(sites_of(rings.ends()))
        super().__init__(self._scheme.order, longest, np.array(self.times), sites)
        self.expected = rings.expected

    def run(self, choices: Choices, shown: bool, progress: Progress = lambda _: None) -> Trial:
        """A run on a ring as wide as it must be, or as much wider as the size is larger.

        Observables are always seen, but for nudged data: any run may become a control.
        """
        wave, ends = self.rings.wave, (self.times[0], self.times[-1])
        cells = self._cells(choices)
        judged = Samples(self.times, lambda view: view.judged(0, self.judged))
        around = Samples(ends[1:], lambda view: view.judged(AROUND, self.judged))
        energies = Samples(ends, lambda view: np.array(view.energy))
        witnesses = [judged, around, energies]
        limit, largest = self.rings.limit(cells.ring), float(np.max(np.abs(cells.ring.f)))
        metered = Samples(self.times)
        meter = wave.disorder.meter(cells.ring) if wave.disorder is not None else None
        if meter is not None:
            metered = Samples(self.times, lambda view: np.array(meter(*view.state.arrays)))
            witnesses.append(metered)
        try:
            run, stopped = run_from(cells, None, progress, witnesses), False
        except UnfinishedRun as stop:
            run, stopped = stop.record, True
        if not choices.nudged:
            self.metered[choices.step] = np.array(metered.samples)
        if metered.samples:
            tell_energies(run, float(metered.samples[0][-1]), float(metered.samples[-1][-1]))
        elif wave.lattice.conserves_energy and wave.losses is None:
            tell_energies(run, float(energies.samples[0]), float(energies.samples[-1]))
        values = np.array(judged.samples)
        done = len(values) == len(self.times) or stopped
        sound = done and bool(np.all(np.abs(values) <= limit))
        trial = Trial(
            choices,
            values if sound else None,
            self.work(choices),
            float(run.attrs["seconds"]),
            rounding_error(largest / wave.scale, run.attrs["force_evaluations"]),
            run,
            not choices.nudged,
            around=around.samples[0] if sound and not stopped else None,
        )
        if stopped:
            raise StoppedTrial(trial)
        return trial

    def parts(self) -> tuple[SiteRingEngine, SiteRingEngine] | None:
        """Engines of a part that stands for all cells, and of all of them, judged there.

        None where there is none: the data must be no larger, nor steeper, anywhere than there.
        """
        rings = self.rings
        part = part_of(rings.wave, rings.compared, rings.times, rings.signals)
        if part is None:
            return None
        inner = WaveRings(rings.wave, part, rings.times)
        if not np.all(rings.sizes <= (1.0 + ALIKE) * inner.sizes):
            return None
        within = SiteRingEngine(replace(self.scene, observables=()), inner)
        return within, SiteRingEngine(self.scene, rings, part)

    def _cells(self, choices: Choices) -> RingCells:
        wider = WIDER if choices.size > self._first.size else 0
        ends = self.rings.ends(wider)
        stated = Discretisation(choices.step, "ring", sites_of(ends), self._scheme.name)
        observables = () if choices.nudged else self.scene.observables
        plan = replace(self.scene, numerics=stated, observables=observables)
        return RingCells(plan, self.rings, ends, choices.nudged)

    def metered_before(self, step: float) -> Array:
        """What the meter gave in the run with the next longer step; nan where there is none."""
        longer = [one for one in self.metered if one > step]
        found = self.metered[min(longer)] if longer else np.empty(0)
        wanted = self.metered[step]
        return found if found.shape == wanted.shape else np.full_like(wanted, np.nan)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """A shorter step on a wider ring, or from that on the ring as it must be."""
        step = shorter_step(self._stops, choices.step, self.order, STEP_RATIO)
        wider = WIDER if choices.size == self._first.size else 0
        return replace(choices, step=step, size=self._first.size + wider)

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """A shorter step on the ring as it must be."""
        return replace(super().improved(choices, kind, excess), size=self._first.size)

    def work(self, choices: Choices) -> float:
        """Forces on fields of cells."""
        return super().work(choices) * self._scheme.stages * choices.size * self._fields


def tell_energies(run: RunRecord, begin: float, end: float) -> None:
    """Tell by how much an energy changed; nothing where it is none."""
    if math.isfinite(begin):
        run.attrs["energy_drift"] = abs(end - begin) / abs(begin) if begin else 0.0


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


def stiffest_slopes(ring: CellRing) -> list[float]:
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

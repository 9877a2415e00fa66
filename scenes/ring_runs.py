"""Runs of a scene's ring of cells, for `lattice.refine` to judge: step and ring are what is varied.

A ring is causal: it holds every cell from which a signal reaches a compared one in time, so its
seam is never felt there.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.dynamics import dynamics_of
from longwave.lattice.model import GROWTH
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.schemes import REDUCED_PHASE_6, stability_limit
from longwave.lattice.trial import (
    Choices,
    Kind,
    Progress,
    StepSearch,
    Trial,
    rounding_error,
    shorter_step,
)
from longwave.scenes.chain.domain import front
from longwave.scenes.lattice_wave import CellRing, LatticeWave, largest_group_velocity
from longwave.scenes.ring_cost import cell_seconds, search_cost
from longwave.support.checkpoint import Loop, Memory, begin_loop
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
"""Seconds between two looks at whether the state is finite; Ctrl-C waits for them."""


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
    cells = float(sites_of(compared.ring(times, signals, WIDER)))
    steps = (times[-1] - times[0]) * fastest / (LIMIT_SHARE * stability_limit(SCHEME))
    kept = math.prod(2.0 * reach + 1.0 for reach in compared.reach) * len(times)
    return cells, search_cost(wave.lattice, cells, steps, SCHEME.stages, kept)


@dataclass(frozen=True)
class RingRecord:
    """What a run on a ring left: what is compared at each time, its energies, its cost."""

    measured: list[Array]
    energies: tuple[float, float]
    sites: int
    step: float
    steps: int
    metered: Array
    """What the wave's meter gave at each time, (times, numbers); empty without one."""


class RingRuns(StepSearch):
    """Runs of one wave at ``times``, the first of which is the start.

    Values are what is compared, in units of the wave's scale, and its rate: an error that passes
    through 0 at one of the times does not seem to be none. Raises ValueError, before anything
    large is made, for what would take too long or too much memory, and for an unstable lattice.
    """

    def __init__(self, wave: LatticeWave, compared: ComparedCells, times: Sequence[float]) -> None:
        self.wave, self.compared, self.times = wave, compared, tuple(times)
        lattice = wave.lattice
        self._fields = len(lattice.fields)
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
        fastest = max(near.lattice.highest_frequency(slopes), lattice.highest_frequency(rest))
        self._check_cost(fastest, self.signals)
        longest = longest_step(fastest, wave.frequency)
        self.fragile = math.isinf(max(map(abs, wave.support(self.times[0]))))
        self._turn = wave.frequency or lattice.highest_frequency(rest)
        self._room = wave.seam_room(self.times[0])
        sites = sites_of(compared.ring(self.times, self.signals, 2 * self._room))
        self._metered: dict[float, Array] = {}
        self._least = float(np.max(np.abs(self._seen(near, near.f, near.v))))
        super().__init__(SCHEME.order, longest, np.array(self.times), float(sites))

    def _check_cost(self, fastest: float, signals: Sequence[float]) -> None:
        cells, self.expected = _cost(self.wave, self.compared, self.times, fastest, signals)
        check_request(
            f"scene of {cells:.3g} cells, from which signals arrive in time,",
            self.expected,
            "take a larger eps, end earlier or compare fewer cells",
        )

    def run(self, choices: Choices, shown: bool, progress: Progress = lambda _: None) -> Trial:
        """A run on a ring as wide as it must be, or as much wider as the size is larger."""
        loop = begin_loop(f"ring {choices}")
        wider = 2 * self._room + (WIDER if choices.size > self._first.size else 0)
        ends = self.compared.ring(self.times, self.signals, wider)
        ring = self.wave.ring(_grid(ends), self.times[0]).smoothed(self._room)
        if choices.nudged:
            ring = ring.nudged()
        energy = _energy(ring, ring.f, ring.v)
        meter = self.wave.meter(ring)
        march = March(ring, self.times, choices.step, loop)
        for t in march.through():
            seen = self._seen(ring, march.f, march.v) / self.wave.scale
            march.measured.append(seen[:, :, *self.compared.places(ends, t)])
            if meter is not None:
                march.metered.append(np.array(meter(march.f, march.v)))
            progress((t - self.times[0]) / (self.times[-1] - self.times[0]))
        measured, steps = march.measured, march.steps
        metered = np.array(march.metered)
        if not choices.nudged:
            self._metered[choices.step] = metered
        energies = energy, _energy(ring, march.f, march.v)
        if march.metered:
            energies = float(march.metered[0][-1]), float(march.metered[-1][-1])
        record = RingRecord(
            [row[0] for row in measured], energies, sites_of(ends), choices.step, steps, metered
        )
        values = np.array(measured)
        largest = float(np.max(np.abs(ring.f))) / self.wave.scale
        evaluations = steps * SCHEME.stages
        whole = float(np.max(np.abs(self._seen(ring, ring.f, ring.v))))
        limit = GROWTH * max(self._least, whole) / self.wave.scale
        around = self._seen(ring, march.f, march.v) / self.wave.scale
        sound = len(measured) == len(self.times) and bool(np.all(np.abs(values) <= limit))
        return Trial(
            choices,
            values if sound else None,
            self.work(choices),
            perf_counter() - loop.begun,
            rounding_error(largest, evaluations),
            record,
            around=around[:, :, *self.compared.places(ends, self.times[-1], AROUND)]
            if sound
            else None,
        )

    def _seen(self, ring: CellRing, f: Array, v: Array) -> Array:
        """What is compared, in all cells of a ring, and its rate in the same unit."""
        rates = self.wave.measured(v, (0.0,) * len(ring.mean_strain)) / self._turn
        return np.stack([self.wave.measured(f, ring.mean_strain), rates])

    def metered_before(self, record: RingRecord) -> Array:
        """What the meter gave in the run with the next longer step; nan where there is none."""
        longer = [step for step in self._metered if step > record.step]
        found = self._metered[min(longer)] if longer else np.empty(0)
        fits = found.shape == record.metered.shape
        return found if fits else np.full_like(record.metered, np.nan)

    def varied(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """A shorter step on a wider ring, or from that on the ring as it must be."""
        step = shorter_step(self._stops, choices.step, self.order, STEP_RATIO)
        wider = WIDER if choices.size == self._first.size else 0
        return replace(choices, step=step, size=self._first.size + wider)

    def better(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """A shorter step on the ring as it must be."""
        return replace(super().better(choices, kind, excess), size=self._first.size)

    def work(self, choices: Choices) -> float:
        """Forces on fields of cells."""
        return super().work(choices) * SCHEME.stages * choices.size * self._fields


def longest_step(fastest: float, carrier: float) -> float:
    """The longest step tried where these are the frequencies of the fastest wave and the carrier.

    >>> longest_step(2.0, 0.5) == LIMIT_SHARE * stability_limit(SCHEME) / 2.0
    True
    >>> longest_step(2.0, 2.0) == LAWFUL_TURN / 2.0
    True
    """
    stable = LIMIT_SHARE * stability_limit(SCHEME) / fastest
    return min(stable, LAWFUL_TURN / carrier) if carrier else stable


def _energy(ring: CellRing, f: Array, v: Array) -> float:
    with np.errstate(all="ignore"):
        return ring.lattice.energy(f, v)


def check_rest(lattice: NumericLattice, slopes: Sequence[float]) -> None:
    """Refuse a lattice that is unstable where its forces have these slopes, beside the wave."""
    if not lattice.is_stable(slopes):
        raise ValueError(
            f"constants must make waves of {lattice.name} stable, got one that grows at "
            "rest, beside the wave (take stiffer springs)"
        )


def stiffest_slopes(ring: CellRing) -> list[float]:
    """The largest slope of each bond's force about the stretches of a state.

    Raises ValueError where a force is not defined.
    """
    stretches = ring.lattice.stretches(ring.f)
    found = [ring.lattice.steepest(place, x) for place, x in enumerate(stretches)]
    if not all(map(math.isfinite, found)):
        raise ValueError(
            f"eps must leave every bond of {ring.lattice.name} within its force, got a wave that "
            "stretches one beyond what its force is for (take a smaller eps)"
        )
    return found


REMEMBERED = ("f", "v", "measured", "metered", "steps", "_done")
"""What a march is gone on with."""


class March:
    """A ring on its way: ``f`` and ``v`` when the last of the times passed that was still finite.

    ``measured`` and ``metered`` are its user's, a row for each of the times that was come to;
    ``steps`` lead there.
    """

    def __init__(
        self, ring: CellRing, times: Sequence[float], step: float, loop: Loop | None = None
    ) -> None:
        self.f, self.v = ring.f.copy(), ring.v.copy()
        self.measured: list[Any] = []
        self.metered: list[Array] = []
        self.steps = 0
        self._times, self._step, self._loop = times, step, loop or Loop()
        self._done = 0
        self._dynamics = dynamics_of(ring.lattice)
        self._step_seconds = cell_seconds(ring.lattice) * self.f[0].size
        if self._loop.memory is not None:
            for name in REMEMBERED:
                setattr(self, name, self._loop.memory[name])

    def through(self) -> Iterator[float]:
        """Each of the times still to come, and none after one that is not finite.

        What was not finite by then is not shown.
        """
        if not self.measured:
            yield self._times[0]
        for begin, end in list(pairwise(self._times))[len(self.measured) - 1 :]:
            if not self._advance(begin, end):
                return
            yield end
        self._loop.end(self._memory)

    def _advance(self, begin: float, end: float) -> bool:
        """Go from one of the times to the next; whether the ring is still finite there."""
        steps = max(1, math.ceil((end - begin) / self._step * (1.0 - 1e-12)))
        most = max(1, int(LOOK_SECONDS / (SCHEME.stages * self._step_seconds)))
        h = (end - begin) / steps
        while self._done < steps:
            with np.errstate(all="ignore"):
                self._dynamics.advance(SCHEME, self.f, self.v, h, min(most, steps - self._done))
            if not np.all(np.isfinite(self.f)):
                return False
            self._done = min(steps, self._done + most)
            self._loop.offer(self._memory)
        self.steps, self._done = self.steps + steps, 0
        return True

    def _memory(self) -> Memory:
        return {name: getattr(self, name) for name in REMEMBERED}

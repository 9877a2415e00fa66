"""A wave's way on spectral rings: one ring for each phase, seen on the compared sites at its times.

It can be gone on with from any pause of a ring, by a march that was made alike.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.trial import Progress
from longwave.scenes.chain.moving_wave import MovingWave
from longwave.support.checkpoint import Loop, Memory

if TYPE_CHECKING:
    from longwave.lattice.spectral.evolution import SpectralRing
    from longwave.lattice.spectral.field_ring import FieldRing

Array = NDArray[np.float64]
MakeRing: TypeAlias = "Callable[[FieldRing, float], SpectralRing]"
"""A ring from its state, with a step."""


class MarchPhase(NamedTuple):
    """A part of the way with a step of its own: its beginning, and the times in it."""

    start: float
    times: Sequence[float]
    step: float


class RingTally(NamedTuple):
    """What rings came to: the smallest and the largest strain, steps, evaluations."""

    strain: tuple[float, float]
    steps: int
    evaluations: int

    def with_ring(self, ring: SpectralRing | None) -> RingTally:
        """With that of one more ring."""
        if ring is None:
            return self
        (least, most), integrator = self.strain, ring.integrator
        strain = min(least, ring.strain[0]), max(most, ring.strain[1])
        steps, evaluations = self.steps + integrator.steps, self.evaluations
        return RingTally(strain, steps, evaluations + integrator.evaluations)


class RingMarch:
    """Takes a wave from ``state`` through its ``phases``; ``rows`` are its y/eps at their times."""

    def __init__(
        self, moving: MovingWave, state: FieldRing, phases: Sequence[MarchPhase], make: MakeRing
    ) -> None:
        self.rows: list[Array] = []
        self._moving, self._state, self._phases, self._make = moving, state, phases, make
        self._before = [0, *accumulate(len(phase.times) for phase in phases)]
        self._place = 0
        self._ring: SpectralRing | None = None
        self._left = RingTally((math.inf, -math.inf), 0, 0)

    @property
    def tally(self) -> RingTally:
        """That of all rings so far."""
        return self._left.with_ring(self._ring)

    def run(self, progress: Progress, loop: Loop) -> None:
        """Go to the end, from the beginning or from what the loop remembers.

        Raises what the rings raise.
        """
        if loop.memory is not None:
            self._recall(loop.memory)
        moving = self._moving
        begin, duration = moving.t0, moving.duration

        def pause() -> None:
            loop.offer(self._memory)

        while self._place < len(self._phases):
            phase = self._phases[self._place]
            if self._ring is None:
                self._ring = self._make(self._state, phase.step)
            for t in phase.times[len(self.rows) - self._before[self._place] :]:
                sites = moving.compared_sites(t)
                self.rows.append(self._ring.at(t, pause).at(sites)[0] / moving.eps)
                progress((t - begin) / duration if duration > 0 else 1.0)
            for following in self._phases[self._place + 1 : self._place + 2]:
                self._state = self._ring.at(following.start, pause)
            self._left, self._ring = self.tally, None
            self._place += 1
        loop.end(self._memory)

    def _memory(self) -> Memory:
        ring = None if self._ring is None else self._ring.memory()
        kept = {name: getattr(self, name) for name in ("rows", "_place")}
        return kept | {"left": tuple(self._left), "state": vars(self._state), "ring": ring}

    def _recall(self, memory: Memory) -> None:
        self.rows, self._place = memory["rows"], memory["_place"]
        self._left = RingTally(*memory["left"])
        self._state = replace(self._state, **memory["state"])
        if memory["ring"] is not None:
            self._ring = self._make(self._state, self._phases[self._place].step)
            self._ring.recall(memory["ring"])

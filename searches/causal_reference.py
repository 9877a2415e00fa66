"""The infinite lattice on those sites alone that can reach the compared ones in time.

No signal is faster than sqrt(max V'') about the strains that it meets, except that the front of a
dispersive one is an Airy function ahead of it. So what is wrong at the ends of the array, where
it closes to a ring, never reaches a compared site, and the array shrinks with the time that is
left. Where the data are constant nothing happens until the wave's own signals arrive, and nothing
is computed. The largest strain met is checked against the speed that was assumed; with more of it
the run is begun again.

This judges the planners of the paper's chain and shares nothing with them but the initial data
and the kernels.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.schemes import Scheme, scheme_named, stability_limit
from longwave.lattice.stepper import advance
from longwave.scenes.description.scene import Scene
from longwave.scenes.starts.moving_wave import moving_wave

__all__ = ["CausalReference", "CausalRun", "SoftenedError"]

Array = NDArray[np.float64]

SCHEME = "reduced_phase_6"
"""Fewest force evaluations in the table; its order is measured at every use."""

AIRY = 14.0
"""Airy lengths ahead of the sound where a signal is rounding: Ai(14) is 1e-16."""

SPARE = 64
"""Further sites."""

BLOCK = 160.0
"""Sites that the fastest signal goes between two changes of the array."""

QUIET = 1e-16
"""Largest difference, in units of the largest strain, between data that count as constant."""

ROOM = 4.0
"""In units of the speed of sound: a wave that is faster is looked for so far away. One that runs
above that speed comes from sites that sound cannot have come from."""

FASTER = 1.01
"""Factor on the speed in the data, for strains that grow on the way."""

LARGEST = 1e3
"""Growth of the largest strain beyond which a run is given up."""


class SoftenedError(ArithmeticError):
    """Waves cease to exist: V'' <= 0 about some strain, or it grew without bound."""


@dataclass(frozen=True)
class CausalRun:
    """Strains on the compared sites, shape (snapshots, sites), and what they took."""

    strain: Array
    steps: int
    evaluations: float


@dataclass(frozen=True)
class _Span:
    """The data on the sites ``first`` ... at one time."""

    first: int
    y: Array
    s: Array

    def part(self, first: int, last: int) -> tuple[Array, Array]:
        low, high = first - self.first, last - self.first + 1
        return self.y[low:high], self.s[low:high]


class CausalReference:
    """Runs of one scene with different steps, on the sites that matter.

    ``faster`` is the factor on the speed in the data that is tried at first.
    """

    def __init__(self, scene: Scene, faster: float = FASTER) -> None:
        self.scene = scene
        self._scheme: Scheme = scheme_named(SCHEME)
        self._faster = faster

    @cached_property
    def longest_step(self) -> float:
        """The stability limit about the data."""
        return stability_limit(self._scheme) / (2.0 * self._cone.fastest)

    def evaluations(self, step: float) -> float:
        """Force evaluations of a run with such steps, all sites counted."""
        times = np.linspace(self.scene.t0, self.scene.end, 17)
        ends = map(self._cone.needed, times.tolist())
        width = [last - first + 1 + 2.0 * self._cone.room for first, last in ends]
        return float(np.trapezoid(width, times)) / step * self._scheme.stages

    def run(self, step: float, check: Callable[[], None] = lambda: None) -> CausalRun:
        """Run with steps not longer than ``step``; ``check`` is called often and may raise.

        Raises SoftenedError.
        """
        while True:
            met = self._cone.fastest
            strains, steps, work = [], 0, 0.0
            for t, span, done in self._march(step):
                check()
                met = max(met, self._fastest(span.y))
                steps += done
                work += float(done) * span.y.size * self._scheme.stages
                if t in self.scene.snapshots:
                    sites = moving_wave(self.scene).compared_sites(t)
                    strains.append(span.part(int(sites[0]), int(sites[-1]))[0])
            if met <= self._cone.fastest:
                return CausalRun(np.array(strains), steps, work)
            self._faster *= FASTER * met / self._cone.fastest
            del self._cone

    @cached_property
    def _cone(self) -> "_Cone":
        """The sites that matter; the speed is that of the data within reach."""
        assumed = ROOM * self.scene.model.sound_speed()
        while True:
            first, last = _Cone(self.scene, assumed).needed(self.scene.t0)
            fastest = self._faster * self._fastest(self._data(first, last).y)
            if fastest <= assumed:
                break
            assumed = ROOM * fastest
        first, last = _Cone(self.scene, fastest).needed(self.scene.t0)
        data = self._data(first, last)
        small = QUIET * float(np.max(np.abs(data.y)))
        speed = self.scene.model.sound_speed()
        loud = [
            np.flatnonzero(np.maximum(np.abs(data.y - end), np.abs(data.s) / speed) > small)
            for end in (data.y[0], data.y[-1])
        ]
        quiet = [first + int(loud[0][0]) if loud[0].size else last,
                 first + int(loud[1][-1]) if loud[1].size else first]  # fmt: skip
        return _Cone(self.scene, fastest, min(quiet), max(quiet))

    def _data(self, first: int, last: int) -> _Span:
        moving = moving_wave(self.scene)
        return _Span(first, *np.concatenate(moving.state(np.arange(first, last + 1), moving.t0)))

    def _fastest(self, strain: Array) -> float:
        """Return the fastest signal about the strains, not slower than the frame."""
        constants = self.scene.model
        stiffness = constants.stiffness(strain)
        largest = float(np.max(np.abs(strain), initial=0.0))
        if not (np.all(stiffness > 0) and largest < LARGEST):
            raise SoftenedError("V'' <= 0, or a strain without bound")
        return max(math.sqrt(float(np.max(stiffness))), constants.sound_speed())

    def _march(self, step: float) -> Iterator[tuple[float, _Span, int]]:
        """Time, needed sites and steps done, after each block and at each snapshot."""
        scene, cone = self.scene, self._cone
        t = scene.t0
        span = self._data(*cone.needed(t))
        if t in scene.snapshots:
            yield t, span, 0
        for stop in scene.snapshots:
            begin, blocks = t, math.ceil((stop - t) / cone.block)
            for block in range(1, blocks + 1):
                until = stop if block == blocks else begin + (stop - begin) * block / blocks
                steps = math.ceil((until - t) / step)
                y, s = cone.closed(t, span.y, span.s)
                h = (until - t) / steps
                advance(self._scheme, y[None], s[None], h, steps, scene.model.lattice)
                span = _Span(span.first - cone.room, y, s)
                t = until
                first, last = cone.needed(t)
                span = _Span(first, *(part.copy() for part in span.part(first, last)))
                yield t, span, steps


@dataclass(frozen=True)
class _Cone:
    """Which sites matter when, for signals not faster than ``fastest``.

    At first the data are constant before ``left`` and after ``right``.
    """

    scene: Scene
    fastest: float
    left: float = -math.inf
    right: float = math.inf

    @property
    def block(self) -> float:
        """Time between two changes of the array."""
        return BLOCK / self.fastest

    @property
    def room(self) -> int:
        """Sites beyond the needed ones, which grow while signals from the ends come nearer."""
        return math.ceil(2.0 * BLOCK) + _front(BLOCK) + SPARE

    @property
    def _way(self) -> float:
        """Sites that the fastest signal goes during the scene."""
        return self.fastest * (self.scene.end - self.scene.t0)

    def needed(self, t: float) -> tuple[int, int]:
        """Return the first and last site that matter at ``t``."""
        scene = self.scene
        sites = moving_wave(scene).compared_sites(scene.end)
        front = _front(self._way)
        reach = math.ceil(self.fastest * (scene.end - t)) + front
        grown = math.ceil(self.fastest * (t - scene.t0)) + front
        compared = moving_wave(scene).compared_sites(t)
        first = max(int(sites[0]) - reach, self.left - grown)
        last = min(int(sites[-1]) + reach, self.right + grown)
        return int(min(first, compared[0])), int(max(last, compared[-1]))

    def closed(self, t: float, y: Array, s: Array) -> tuple[Array, Array]:
        """Return the data with room on either side, a multiple of eight in all.

        Where they are constant they go on like that. A wave goes on as its mirror image that runs
        the same way and fades: at rest it would run both ways and double the strains that it
        meets, which can be more than the lattice bears. The last sites lead from end to end.
        """
        left, right = self.room, self.room + (-(y.size + 2 * self.room) % 8)
        first, last = self.needed(t)
        grown = math.ceil(self.fastest * (t - self.scene.t0)) + _front(self._way)
        before = _continued(y[::-1], s[::-1], left, first <= self.left - grown)
        after = _continued(y, s, right, last >= self.right + grown)
        strain = np.concatenate([before[0][::-1], y, after[0]])
        strain[-SPARE:] = np.linspace(strain[-SPARE - 1], strain[0], SPARE)
        return strain, np.concatenate([before[1][::-1], s, after[1]])


def _continued(y: Array, s: Array, room: int, constant: bool) -> tuple[Array, Array]:
    """Return the strain and velocity on the sites after the data's end."""
    if constant:
        return np.full(room, y[-1]), np.zeros(room)
    fading = np.maximum(0.0, np.linspace(1.0, -SPARE / (room - SPARE), room))
    image = np.pad(y, (0, room), "symmetric")[-room:]
    mean = float(np.mean(image))
    velocity = -np.pad(s, (0, room), "symmetric")[-room:]
    return mean + fading * (image - mean), fading * velocity


def _front(distance: float) -> int:
    """Return sites by which a front is ahead after sound has gone that far."""
    return SPARE + math.ceil(AIRY * (max(distance, 1.0) / 8.0) ** (1.0 / 3.0))

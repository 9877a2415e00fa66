"""A run by the spectral engine, with the step, the sampling and the ring that a tolerance needs.

The choices are judged by `refine.py`: a control run has a shorter step, more points, a wider ring
with its seam elsewhere, and an absorber of half the strength. At all times the tail of the spectrum
is watched; where it rises above its bound, the run is begun again with more points. A ring that is
taken for causal is checked against the strains that were met on it.
"""

import math
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.refine import Announce, Refined, refine
from longwave.lattice.spectral.absorber import ABSORBER_STRENGTH
from longwave.lattice.spectral.crest_energy import (
    DENSITY,
    crest_energy_spread,
)
from longwave.lattice.spectral.evolution import (
    NotHyperbolicError,
    RunawayError,
    SpectralRing,
)
from longwave.lattice.spectral.field_ring import FieldRing, fast_count
from longwave.lattice.spectral.ring_search import TAIL_SHARE, SpectralRingSearch
from longwave.lattice.trial import (
    NUDGE,
    Choices,
    Kind,
    Progress,
    StoppedTrial,
    Trial,
    clock_error,
    rounding_error,
)
from longwave.scenes.engines.spectral_data import (
    SpectralDomain,
    first_density,
    first_step,
    rms_wavenumber,
    spectral_start,
    turning_time,
)
from longwave.scenes.starts.moving_wave import MovingWave
from longwave.support.checkpoint import Loop, Memory, begin_loop

Array = NDArray[np.float64]

SIZE_RATIO = 1.5
"""Circumference of a control run, in units of that of the run before it. Where the control's ring
would be causal, so is the first; a kink's always is."""

SHIFT = 0.07
"""By how much its middle moves, in circumferences."""

WEAKER = 0.5
"""Strength of its absorber, in units of that of the run before it."""

LARGEST_FACTOR = 3.0
"""Largest factor on a size, from one choice to the next."""

DENSER = 1.5
"""Points with which a run is begun again whose spectrum's tail rose."""

STARTED = 15.0
"""A start ends when sound has gone so many times 1/k, k the data's typical wave number."""

START = 0.1
"""Step of the start, in units of the time in which sound goes 1/k."""

STEEPEST = 0.65
"""Largest a |y|: beyond, a wave is as short as the distance of sites, and no step is long enough to
pay (a soliton's width in sites is 1/(a |y|))."""

SLENDER = 0.2
"""Up to this a |y| the energies of the ring's lattices differ by less than rounding."""

SPREAD = 2.2
"""The spread of energies with which the bound was measured, in units of `crest_energy_spread`: at
most, of solitons with a |y| from 0.35 to 0.6."""

RESOLVED = 2.5
"""Points per site that a steep wave takes."""

MOST_WORK = 4e9
"""Most work of a run with such steps, some ten seconds on the ring where no seam is felt: what a
steep wave radiates without end does not let a smaller one do."""

SHORTEST = 0.02
"""Shortest step, in units of the time in which sound goes a site: below it a run site by site takes
less."""

LEAST_POINTS = 256
"""Points on the smallest ring: the numbers that transform fast then lie so close that a control run
never has as many."""

MOST_POINTS = 2**20
"""Points on the largest ring: a run takes 510 bytes a point (measured)."""


class SpectralCost(NamedTuple):
    """What a run took: ``points``, and ``evaluations`` of the force.

    ``strain`` is the smallest and the largest that was met.
    """

    steps: int
    points: int
    evaluations: int
    circumference: float
    strain: tuple[float, float]


Stop: TypeAlias = tuple[float, float, bool]
"""A time, the step up to it, and whether the wave is seen there."""


class SpectralIntegration:
    """A wave's way from ``state`` on rings, with a new one wherever the step is another.

    ``rows`` are its y/eps on the compared sites at the ``stops`` where it is seen. It can be gone
    on with from any pause of a ring, by a march that was made alike.
    """

    def __init__(
        self,
        moving: MovingWave,
        state: FieldRing,
        stops: Sequence[Stop],
        make: Callable[[FieldRing, float], SpectralRing],
    ) -> None:
        self.rows: list[Array] = []
        self._moving, self._stops, self._make = moving, stops, make
        self._place, self._left = 0, [(math.inf, -math.inf, 0, 0)]
        self._begin(state, stops[0][1])

    def _begin(self, state: FieldRing, step: float) -> None:
        self._state, self._step, self._ring = state, step, self._make(state, step)

    def _tallies(self) -> list[tuple[float, float, int, int]]:
        """The smallest and the largest strain, steps and evaluations of all rings so far."""
        integrator = self._ring.integrator
        return [*self._left, (*self._ring.strain, integrator.steps, integrator.evaluations)]

    @property
    def cost(self) -> SpectralCost:
        """That of all rings so far."""
        least, most, steps, evaluations = zip(*self._tallies(), strict=True)
        points, length = self._state.f.size, self._state.circumferences[0]
        return SpectralCost(sum(steps), points, sum(evaluations), length, (min(least), max(most)))

    def run(self, progress: Progress, loop: Loop) -> None:
        """Go to the end, from the beginning or from what the loop remembers.

        Raises what the rings raise.
        """
        if loop.memory is not None:
            self._recall(loop.memory)
        moving, state = self._moving, self._state
        for t, step, is_seen in self._stops[self._place :]:
            if step != self._step:
                self._left = self._tallies()
                self._begin(state, step)
            state = self._ring.at(t, lambda: loop.offer(self._memory))
            if is_seen:
                self.rows.append(state.at(moving.compared_sites(t))[0] / moving.eps)
                progress((t - moving.t0) / moving.duration if moving.duration > 0 else 1.0)
            self._place += 1
        loop.end(self._memory)

    def _memory(self) -> Memory:
        kept = {name: getattr(self, name) for name in ("rows", "_place", "_left", "_step")}
        return kept | {"state": vars(self._state), "ring": self._ring.memory()}

    def _recall(self, memory: Memory) -> None:
        self.rows, self._place, self._left = (memory[k] for k in ("rows", "_place", "_left"))
        self._begin(replace(self._state, **memory["state"]), memory["_step"])
        self._ring.recall(memory["ring"])


def solve_on_rings(
    moving: MovingWave,
    tolerance: float,
    progress: Progress = lambda _: None,
    announce: Announce = lambda _: None,
    most_work: float = math.inf,
) -> Refined:
    """Run the wave to a sup error of y/eps on the compared sites at its times after t0.

    ``most_work`` is the most that the next runs may ever take, in points times their log2 times
    evaluations. ``progress`` and ``announce`` are as in `refine`. Raises ValueError if the
    tolerance needs too many points or too short steps, or is below what rounding leaves, and
    FloatingPointError if the lattice blows up.
    """
    if not tolerance > 0:
        raise ValueError(f"tolerance must satisfy tolerance > 0, got {tolerance:g} (1e-4 is usual)")
    engine = SpectralEngine(moving, tolerance, most_work)
    found = refine(engine, tolerance, progress, announce)
    if found.trial.values is None:
        step = found.trial.choices.step
        raise FloatingPointError(f"blow-up: steps down to {step:.3g} do not change it")
    progress(1.0)
    return found


class SpectralEngine(SpectralRingSearch):
    """Runs of a wave on rings, its initial data kept."""

    kinds: tuple[Kind, ...] = ("step", "sampling", "domain")
    safety = 4.0
    """What still comes round the ring was measured to fall as slowly as L^-1/2; what long steps
    average away, as step^1/2."""
    step_ratio = 0.6
    least_factor = 0.3
    amplifies_rounding = False
    """Waves so steep that rounding grows soon are refused."""

    def __init__(self, moving: MovingWave, tolerance: float, most_work: float) -> None:
        super().__init__(moving.t0, moving.duration, moving.speed, tolerance)
        self._moving, self.most_work = moving, most_work
        self._data = spectral_start(moving, tolerance)
        self.decay = 2.0 if self._data.periodic else 3.0
        steepness = self._steepness(self._data.bounds.strain)
        if steepness > STEEPEST:
            raise self._too_short(f"a wave longer than {1.0 / steepness:.2g} sites")
        self._density = first_density(moving)
        self._started = moving.t0
        self._rings: dict[tuple[float, float, bool], SpectralDomain] = {}
        self._states: dict[tuple[SpectralDomain, int], FieldRing] = {}
        self._soft: NotHyperbolicError | None = None

    def first(self) -> Choices:
        """The smallest ring, sampled by the wave's own scale, with a step of that scale."""
        choices = self._sized(Choices(1.0, 0.0, density=self._density), self._data.smallest)
        state, c = self._state(choices), self._moving.speed
        k = rms_wavenumber(state)
        turning = turning_time(self._moving.constants, state, k)
        step = first_step(c, self._duration, k, turning)
        self._lattice_spread = self._apart(self._duration / turning)
        if self._must_resolve:
            step = min(step, self._resolving)
            self._refuse_toil(step)
        length = 1.0 / (c * k)
        start = START * length if STARTED * length < self._duration else 0.0
        if not start:
            step = min(step, START * length)
        absorber = ABSORBER_STRENGTH if self._data.absorbed and not choices.causal else 0.0
        self._started = self._moving.t0 + STARTED * length
        return replace(choices, step=step, absorber=absorber, start=start)

    def _refuse_toil(self, step: float) -> None:
        """Refuse so short steps where a run site by site takes much less."""
        limit = self._data.causal
        widest = replace(Choices(step, limit.circumference), density=RESOLVED)
        if self.work(widest) > MOST_WORK:
            raise self._too_short(f"steps below {step:.2g} for so long")

    def _too_short(self, needed: str) -> ValueError:
        """What is said of a tolerance, or a wave, that needs shorter steps than pay."""
        return ValueError(
            f"engine must be 'stencil' for tolerance {self._tolerance:g}, got 'spectral': it needs "
            f"{needed} (the wave is hardly longer than the distance of sites)"
        )

    def _steepness(self, strain: Array) -> float:
        return self._moving.wave.numbers.a * float(np.max(np.abs(strain)))

    def _apart(self, turns: float) -> float:
        """Bound of y/eps by which the ring's lattices part in time (`crest_energy.py`)."""
        data, bounds = self._data, self._data.bounds
        if self._steepness(bounds.strain) <= SLENDER:
            return 0.0
        ring = data.ring(data.smallest)
        state = data.state(ring, self._fast_points(DENSITY * ring.circumference))
        chain = data.moving.constants.lattice
        spread = SPREAD * crest_energy_spread(chain, state, 0)
        return (1.0 + turns) * spread * float(np.max(np.abs(bounds.strain))) / data.moving.eps

    def _add_points(self, choices: Choices) -> bool:
        self._density = DENSER * self._dense(choices) / choices.finer
        return True

    def _handle_loss(self, error: RunawayError, step: float) -> None:
        """Raise it if waves cease to exist by themselves."""
        self._soft = error if isinstance(error, NotHyperbolicError) else None
        if self._soft and self._lost_again(error, step):
            raise error

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """A shorter step, more points, a wider ring with its seam elsewhere.

        More than the points that the run really has, where the fewest of a ring make them more.
        """
        dense = replace(choices, density=self._dense(choices) / choices.finer)
        choices = super().control(dense, kinds)
        if "domain" in kinds and not choices.causal:
            weaker = replace(choices, absorber=WEAKER * choices.absorber)
            wider = self._sized(weaker, SIZE_RATIO * choices.size)
            choices = replace(wider, shift=choices.shift + SHIFT)
        return choices

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """By the laws of the method's order and of the ring's size."""
        if kind == "step":
            shorter = self._shorter(choices, excess)
            if shorter.step * self._moving.speed < SHORTEST < self._duration:
                raise self._soft or self._too_short(f"steps below {choices.step:.2g}")
            return shorter
        if kind == "sampling":
            return replace(choices, density=1.4 * self._dense(choices))
        if choices.causal:
            return choices
        factor = min(LARGEST_FACTOR, max(1.3, excess ** (1.0 / self.decay)))
        return self._sized(choices, factor * choices.size)

    def points(self, choices: Choices) -> float:
        """The number of points that the choices mean."""
        return choices.size * self._dense(choices)

    def _dense(self, choices: Choices) -> float:
        """Points per site that the choices mean, by what is known of the spectrum now."""
        least = LEAST_POINTS / choices.size
        return choices.finer * max(choices.density, self._density, least)

    def _fast_points(self, wanted: float) -> int:
        """The next larger number of points that transforms fast."""
        if wanted > MOST_POINTS:
            raise ValueError(
                f"tolerance must be larger than {self._tolerance:g}: it needs a ring of more than "
                f"{MOST_POINTS} points (raise it, end earlier or compare fewer sites)"
            )
        return fast_count(wanted)

    def _sized(self, choices: Choices, size: float) -> Choices:
        limit = self._data.causal
        if self._data.kink or SIZE_RATIO * size >= limit.circumference:
            return replace(choices, size=limit.circumference, causal=True, absorber=0.0)
        return replace(choices, size=size)

    def _run(self, choices: Choices, progress: Progress) -> Trial:
        """A run, once more if the strains met were too fast for a causal ring."""
        trial = self._march(replace(choices, density=self._dense(choices), finer=1.0), progress)
        self._soft = None
        data = self._data
        strain = np.array([*trial.payload.strain, *data.bounds.strain])
        fastest = self._moving.constants.highest_frequency(strain)
        if not choices.causal or fastest <= 2.0 * data.fastest:
            return trial
        self._data = replace(data, bounds=replace(data.bounds, strain=strain))
        self._rings.clear()
        return self._run(self._sized(choices, math.inf), progress)

    def _march(self, choices: Choices, progress: Progress) -> Trial:
        moving = self._moving
        loop = begin_loop(f"spectral {choices}")
        state = self._state(choices)
        if choices.nudged:
            state = replace(state, f=(1.0 + NUDGE) * state.f)
        march = SpectralIntegration(
            moving, state, self._stops(choices), self._maker(choices, state)
        )
        stopped = False
        try:
            march.run(progress, loop)
        except KeyboardInterrupt:
            if not march.rows:
                raise
            stopped = True
        values = np.array(march.rows)
        cost = march.cost
        rounding = rounding_error(max(map(abs, cost.strain)) / moving.eps, cost.evaluations)
        rounding += clock_error(values, moving.speed, (moving.t0, moving.end))
        work = cost.evaluations * cost.points * math.log2(cost.points)
        seconds = time.perf_counter() - loop.begun
        trial = Trial(
            choices,
            values,
            work,
            seconds,
            rounding,
            cost,
            common_error=self._unresolved_error(choices),
        )
        if stopped:
            raise StoppedTrial(trial)
        return trial

    def _maker(self, choices: Choices, state: FieldRing) -> Callable[..., SpectralRing]:
        """What makes the rings of a run that begins with that state."""
        cutoff = short = 0.0
        if choices.absorber:
            cutoff, short = self._data.absorbed, self._data.short(*state.circumferences)
        return partial(
            SpectralRing,
            self._moving.constants,
            tail=TAIL_SHARE * self._tolerance * self._moving.eps,
            absorbed=cutoff,
            strength=choices.absorber,
            short=short,
        )

    def _stops(self, choices: Choices) -> list[Stop]:
        """Where the wave is seen, and the end of the start, if that has a step of its own.

        The ansatz is not quite a right-going wave. Steps that do not resolve how the rest of it
        leaves the wave would replace it by its mean, whatever their length.
        """
        times, began = self._moving.times[1:], self._started
        if not 0.0 < choices.start < choices.step:
            return [(t, choices.step, True) for t in times]
        early = [(t, choices.start, True) for t in times if t < began]
        late = [(t, choices.step, True) for t in times if t >= began]
        return [*early, (began, choices.start, False), *late]

    def _ring(self, choices: Choices) -> SpectralDomain:
        key = (choices.size, choices.shift, choices.causal)
        if key not in self._rings:
            size = math.inf if choices.causal else choices.size
            self._rings[key] = self._data.ring(size, choices.shift)
        return self._rings[key]

    def _state(self, choices: Choices) -> FieldRing:
        ring = self._ring(choices)
        points = self._fast_points(ring.circumference * choices.density)
        if (ring, points) not in self._states:
            self._states[ring, points] = self._data.state(ring, points)
        return self._states[ring, points]

"""Spectral engine that finds the step, the sampling and the ring that a tolerance needs.

`refine.py` judges the choices with control runs: a shorter step, more points, a wider ring with its
seam elsewhere, and an absorber of half the strength. The tail of the spectrum is monitored; if it
exceeds its bound, the run restarts with more points. A ring assumed to be causal is checked against
the strains met in the run.
"""

import math
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np

from longwave.lattice.refine import Announce, Refined, refine
from longwave.lattice.spectral import evolution
from longwave.lattice.spectral.absorber import ABSORBER_STRENGTH
from longwave.lattice.spectral.crest_energy import DENSITY, crest_energy_spread
from longwave.lattice.spectral.field_ring import FieldRing, fast_count
from longwave.lattice.spectral.ring_search import TAIL_SHARE, SpectralSearch
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
from longwave.scenes.engines import spectral_data
from longwave.scenes.starts.moving_wave import MovingWave
from longwave.support.checkpoint import Loop, Memory, begin_loop
from longwave.support.real_arrays import Array

SIZE_RATIO = 1.5
"""Ratio of a control run's circumference to that of the run before it. If the control run's ring
would be causal, the first run's ring is made causal, too; a kink's ring always is."""

RING_SHIFT = 0.07
"""Distance by which a control run's ring is shifted, in circumferences."""

ABSORBER_RATIO = 0.5
"""Ratio of the absorber's strength in a control run to that in the run before it."""

MAX_SIZE_FACTOR = 3.0
"""Largest factor by which the ring grows from one choice to the next."""

POINTS_GROWTH = 1.5
"""Factor on the number of points when a run restarts because the tail of its spectrum rose."""

START_LENGTH = 15.0
"""Length of the start phase, in units of the time in which sound travels 1/k, k being the typical
wavenumber of the data."""

START_STEP = 0.1
"""Time step of the start phase, in the unit of `START_LENGTH`."""

LARGEST_STEEPNESS = 0.65
"""Largest steepness a |y| accepted, for xi = a X. A steeper wave is as short as the distance
between sites (a soliton's width in sites is 1/(a |y|)), and no long step is possible."""

SMALL_STEEPNESS = 0.2
"""Largest a |y| at which the energies of a ring's interleaved lattices agree to rounding."""

ENERGY_SPREAD_FACTOR = 2.2
"""Largest ratio of the energy spread met to `crest_energy_spread`, for solitons with a |y| from
0.35 to 0.6."""

STEEP_DENSITY = 2.5
"""Points per site that a steep wave needs."""

MAX_STEEP_WORK = 4e9
"""Largest work of a run of a steep wave with short steps, about ten seconds on the causal ring. A
steep wave radiates all the time, so no smaller ring suffices."""

SHORTEST_STEP = 0.02
"""Shortest step, in units of a site over the speed of sound; below it the stencil is cheaper."""

LEAST_POINTS = 256
"""Minimum number of points on a ring. Above it the sizes that suit the FFT lie so close together
that a control run always has more points."""

MOST_POINTS = 2**20
"""Maximum number of points on a ring; a run needs 510 bytes a point (measured)."""


class SpectralCost(NamedTuple):
    """Cost of a run: its steps, points and force ``evaluations``, and its ring's circumference.

    ``strain`` holds the smallest and the largest strain of the run.
    """

    steps: int
    points: int
    evaluations: int
    circumference: float
    strain: tuple[float, float]


Stop: TypeAlias = tuple[float, float, bool]
"""Stop of a run: its time, the step up to it, and whether the wave is recorded there."""


class SpectralIntegration:
    """Integration of a wave from ``state``, on a new ring whenever the step changes.

    ``rows`` holds y/eps on the compared sites at each stop where the wave is recorded. Another
    instance with the same arguments can resume it from a checkpoint.
    """

    def __init__(
        self,
        moving: MovingWave,
        state: FieldRing,
        stops: Sequence[Stop],
        make: Callable[[FieldRing, float], evolution.SpectralRing],
    ) -> None:
        self.rows: list[Array] = []
        self._moving, self._stops, self._make = moving, stops, make
        self._place, self._left = 0, [(math.inf, -math.inf, 0, 0)]  # stop, tallies of past rings
        self._begin(state, stops[0][1])

    def _begin(self, state: FieldRing, step: float) -> None:
        self._state, self._step, self._ring = state, step, self._make(state, step)

    def _tallies(self) -> list[tuple[float, float, int, int]]:
        """Return (smallest strain, largest strain, steps, evaluations) of each ring used so far."""
        integrator = self._ring.integrator
        return [*self._left, (*self._ring.strain, integrator.steps, integrator.evaluations)]

    @property
    def cost(self) -> SpectralCost:
        """Total cost of all rings so far."""
        least, most, steps, evaluations = zip(*self._tallies(), strict=True)
        points, length = self._state.f.size, self._state.circumferences[0]
        return SpectralCost(sum(steps), points, sum(evaluations), length, (min(least), max(most)))

    def run(self, progress: Progress, loop: Loop) -> None:
        """Integrate to the last stop, from the start or from the checkpoint that ``loop`` holds.

        Raises the errors of `evolution.SpectralRing`.
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
        attributes = {name: getattr(self, name) for name in ("rows", "_place", "_left", "_step")}
        return attributes | {"state": vars(self._state), "ring": self._ring.memory()}

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
    """Run a wave on spectral rings to a tolerance on the sup error of y/eps at the compared sites.

    ``most_work`` limits the work of further runs, in points times log2(points) times evaluations.
    ``progress`` and ``announce`` are as in `refine`. Raises ValueError if the tolerance needs too
    many points or too short steps or is below the rounding error, OverBudgetError beyond
    ``most_work``, and FloatingPointError if the lattice blows up.
    """
    if not tolerance > 0:
        raise ValueError(f"tolerance must satisfy tolerance > 0, got {tolerance:g} (1e-4 is usual)")
    engine = SpectralEngine(moving, tolerance, most_work)
    result = refine(engine, tolerance, progress, announce)
    if result.trial.values is None:
        step = result.trial.choices.step
        raise FloatingPointError(f"blow-up with all steps down to {step:.3g}")
    progress(1.0)
    return result


class SpectralEngine(SpectralSearch):
    """Engine that runs a wave on spectral rings; it caches rings and initial states."""

    kinds: tuple[Kind, ...] = ("step", "sampling", "domain")
    safety = 4.0
    """Safety factor on the difference between two runs. The error from waves that circle the ring
    was measured to fall as slowly as L^-1/2, that of long steps as step^1/2."""
    step_ratio = 0.6
    least_factor = 0.3
    amplifies_rounding = False
    """False, because waves steep enough to amplify rounding quickly are refused."""

    def __init__(self, moving: MovingWave, tolerance: float, most_work: float) -> None:
        super().__init__(moving.t0, moving.duration, moving.speed, tolerance)
        self._moving, self.most_work = moving, most_work
        self._data = spectral_data.spectral_start(moving, tolerance)
        self.decay = 2.0 if self._data.periodic else 3.0
        steepness = self._steepness(self._data.bounds.strain)
        if steepness > LARGEST_STEEPNESS:
            raise self._too_short(
                f"a wave of width {1.0 / LARGEST_STEEPNESS:.2g} sites or more, this one has "
                f"{1.0 / steepness:.2g}"
            )
        self._density = spectral_data.first_density(moving)
        self._start_end = moving.t0
        self._rings: dict[tuple[float, float, bool], spectral_data.SpectralDomain] = {}
        self._states: dict[tuple[spectral_data.SpectralDomain, int], FieldRing] = {}
        self._soft: evolution.NotHyperbolicError | None = None

    def first(self) -> Choices:
        """Return the first choices: smallest ring, with sampling and step on the wave's scale."""
        choices = self._sized(Choices(1.0, 0.0, density=self._density), self._data.smallest)
        state, c = self._state(choices), self._moving.speed
        k = spectral_data.rms_wavenumber(state)
        turning = spectral_data.turning_time(self._moving.constants, state, k)
        step = spectral_data.first_step(c, self._duration, k, turning)
        self._lattice_spread = self._spread_over(self._duration / turning)
        if self._must_resolve:
            step = min(step, self._resolving)
            self._check_work(step)
        length = 1.0 / (c * k)
        start = START_STEP * length if START_LENGTH * length < self._duration else 0.0
        if not start:
            step = min(step, START_STEP * length)
        absorber = ABSORBER_STRENGTH if self._data.absorbed and not choices.causal else 0.0
        self._start_end = self._moving.t0 + START_LENGTH * length
        return replace(choices, step=step, absorber=absorber, start=start)

    def _check_work(self, step: float) -> None:
        """Raise ValueError if this ``step`` is so short that a run site by site is much cheaper."""
        limit = self._data.causal
        widest = replace(Choices(step, limit.circumference), density=STEEP_DENSITY)
        if self.work(widest) > MAX_STEEP_WORK:
            raise self._too_short(f"steps below {step:.2g} for so long")

    def _too_short(self, needed: str) -> ValueError:
        """Return the error that refuses a tolerance or wave; ``needed`` says what it would take."""
        return ValueError(
            f"engine must be 'stencil' for tolerance {self._tolerance:g}, got 'spectral': it needs "
            f"{needed} (the wave is hardly longer than the distance between sites)"
        )

    def _steepness(self, strain: Array) -> float:
        return self._moving.wave.numbers.a * float(np.max(np.abs(strain)))

    def _spread_over(self, turns: float) -> float:
        """Return a bound, in y/eps, on how far interleaved lattices diverge (`crest_energy.py`).

        ``turns`` is the duration over `spectral_data.turning_time`.
        """
        data, bounds = self._data, self._data.bounds
        if self._steepness(bounds.strain) <= SMALL_STEEPNESS:
            return 0.0
        ring = data.ring(data.smallest)
        state = data.state(ring, self._fast_points(DENSITY * ring.circumference))
        chain = data.moving.constants.lattice
        spread = ENERGY_SPREAD_FACTOR * crest_energy_spread(chain, state, 0)
        return (1.0 + turns) * spread * float(np.max(np.abs(bounds.strain))) / data.moving.eps

    def _add_points(self, choices: Choices) -> bool:
        self._density = POINTS_GROWTH * self._dense(choices) / choices.finer
        return True

    def _handle_loss(self, error: evolution.RunawayError, step: float) -> None:
        """Raise ``error`` if it recurs with every ``step``: then the lattice itself fails."""
        self._soft = error if isinstance(error, evolution.NotHyperbolicError) else None
        if self._soft and self._lost_again(error, step):
            raise error

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """Return the choices of a control run: shorter step, more points, wider and shifted ring.

        More points means more than the run really had, as `LEAST_POINTS` may have raised them.
        """
        dense = replace(choices, density=self._dense(choices) / choices.finer)
        choices = super().control(dense, kinds)
        if "domain" in kinds and not choices.causal:
            weaker = replace(choices, absorber=ABSORBER_RATIO * choices.absorber)
            wider = self._sized(weaker, SIZE_RATIO * choices.size)
            choices = replace(wider, shift=choices.shift + RING_SHIFT)
        return choices

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """Return choices that divide this ``kind`` of error by ``excess``, from its scaling law."""
        if kind == "step":
            shorter = self._shorter(choices, excess)
            if shorter.step * self._moving.speed < SHORTEST_STEP < self._duration:
                raise self._soft or self._too_short(f"steps below {choices.step:.2g}")
            return shorter
        if kind == "sampling":
            return replace(choices, density=1.4 * self._dense(choices))
        if choices.causal:
            return choices
        factor = min(MAX_SIZE_FACTOR, max(1.3, excess ** (1.0 / self.decay)))
        return self._sized(choices, factor * choices.size)

    def points(self, choices: Choices) -> float:
        """Return the number of points of a run with these choices."""
        return choices.size * self._dense(choices)

    def _dense(self, choices: Choices) -> float:
        """Return the points per site of a run with these choices, given the spectra seen so far."""
        least = LEAST_POINTS / choices.size
        return choices.finer * max(choices.density, self._density, least)

    def _fast_points(self, points: float) -> int:
        """Round up to a number of points that suits the FFT; ValueError beyond `MOST_POINTS`."""
        if points > MOST_POINTS:
            raise ValueError(
                f"tolerance must be larger than {self._tolerance:g}: it needs a ring of more than "
                f"{MOST_POINTS} points (raise it, end earlier or compare fewer sites)"
            )
        return fast_count(points)

    def _sized(self, choices: Choices, size: float) -> Choices:
        limit = self._data.causal
        if self._data.kink or SIZE_RATIO * size >= limit.circumference:
            return replace(choices, size=limit.circumference, causal=True, absorber=0.0)
        return replace(choices, size=size)

    def _run(self, choices: Choices, progress: Progress) -> Trial:
        """Run a trial; repeat it on a wider ring if signals were too fast for the causal ring."""
        trial = self._integrate(replace(choices, density=self._dense(choices), finer=1.0), progress)
        self._soft = None
        data = self._data
        strain = np.array([*trial.payload.strain, *data.bounds.strain])
        fastest = self._moving.constants.highest_frequency(strain)
        if not choices.causal or fastest <= 2.0 * data.fastest:
            return trial
        self._data = replace(data, bounds=replace(data.bounds, strain=strain))
        self._rings.clear()
        return self._run(self._sized(choices, math.inf), progress)

    def _integrate(self, choices: Choices, progress: Progress) -> Trial:
        moving = self._moving
        loop = begin_loop(f"spectral {choices}")
        state = self._state(choices)
        if choices.nudged:
            state = replace(state, f=(1.0 + NUDGE) * state.f)
        stops, maker, stopped = self._stops(choices), self._maker(choices, state), False
        integration = SpectralIntegration(moving, state, stops, maker)
        try:
            integration.run(progress, loop)
        except KeyboardInterrupt:
            if not integration.rows:
                raise
            stopped = True
        values, cost = np.array(integration.rows), integration.cost
        rounding = rounding_error(max(map(abs, cost.strain)) / moving.eps, cost.evaluations)
        rounding += clock_error(values, moving.speed, (moving.t0, moving.end))
        work = cost.evaluations * cost.points * math.log2(cost.points)
        seconds, common = time.perf_counter() - loop.begun, self._unresolved_error(choices)
        trial = Trial(choices, values, work, seconds, rounding, cost, common_error=common)
        if stopped:
            raise StoppedTrial(trial)
        return trial

    def _maker(self, choices: Choices, state: FieldRing) -> Callable[..., evolution.SpectralRing]:
        """Return a function that builds the spectral ring of a run from this ``state``."""
        tail = TAIL_SHARE * self._tolerance * self._moving.eps
        make = partial(evolution.SpectralRing, self._moving.constants, tail=tail)
        if not choices.absorber:
            return partial(make, absorbed=0.0, strength=choices.absorber, short=0.0)
        cutoff, short = self._data.absorbed, self._data.short(*state.circumferences)
        return partial(make, absorbed=cutoff, strength=choices.absorber, short=short)

    def _stops(self, choices: Choices) -> list[Stop]:
        """Return the stops of a run: its times, and the end of a start phase with shorter steps.

        The initial data are not exactly a right-going wave. Steps too long to resolve how the
        left-going rest separates would replace that rest by its mean.
        """
        times, began = self._moving.times[1:], self._start_end
        if not 0.0 < choices.start < choices.step:
            return [(t, choices.step, True) for t in times]
        early = [(t, choices.start, True) for t in times if t < began]
        late = [(t, choices.step, True) for t in times if t >= began]
        return [*early, (began, choices.start, False), *late]

    def _ring(self, choices: Choices) -> spectral_data.SpectralDomain:
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

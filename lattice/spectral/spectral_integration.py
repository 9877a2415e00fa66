"""Integration of any lattice on a ring of real circumferences through given times, to a tolerance.

`lattice.refine` estimates the error: the run is repeated with a shorter step and more points, and
with the last digits of its data changed. The tail of the spectrum is checked all the time; where it
exceeds its bound, the run is restarted with more points. Fewer points than the state's are used if
they resolve it, but not if its points are the sites of lattices that are all judged. A ring with
one point for each site of its one lattice is that lattice, and needs no more points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from longwave.lattice.integration import RING_SAFETY, Cost
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.refine import refine
from longwave.lattice.run_times import check_positive, checked_fields, checked_times
from longwave.lattice.spectral.crest_energy import crest_energy_spread
from longwave.lattice.spectral.evolution import RunawayError
from longwave.lattice.spectral.exponential import ORDER
from longwave.lattice.spectral.field_ring import FieldRing, fast_count
from longwave.lattice.spectral.lattice_ring import LatticeRing, ring_slopes, ring_stretches, whole
from longwave.lattice.spectral.ring_search import TAIL_SHARE, SpectralSearch
from longwave.lattice.trial import Choices, Kind, Progress, Trial, nudged, rounding_error
from longwave.support.checkpoint import Memory, begin_loop
from longwave.support.real_arrays import Array, real_array

Judged = Callable[[FieldRing], Array]

ROUNDED_TAIL = 2.0**-46
"""Spectrum's tail, as a fraction of the largest field, up to which it is rounding."""

DENSER = 1.4
"""Factor on the number of points of a run whose spectrum's tail rose, or whose control run needs
more."""

LEAST_POINTS = 8
"""Least number of points along an axis; a control run has ``DENSITY_RATIO`` times as many."""

MOST_POINTS = 2**22
"""Largest number of points on a ring; a run takes some 500 bytes per point and field."""


@dataclass(frozen=True)
class SpectralTrajectory:
    """Rings at all ``times``; ``error_estimate`` is an upper estimate for the judged quantity."""

    times: Array
    states: tuple[FieldRing, ...]
    error_estimate: float
    step: float
    cost: Cost


def spectral_integrate(
    lattice: NumericLattice,
    state: FieldRing,
    times: ArrayLike,
    tolerance: float,
    speed: float | tuple[float, ...] = 0.0,
    *,
    judged: Judged | None = None,
) -> SpectralTrajectory:
    """Integrate the lattice from ``state``, on its ring of real circumferences, to all ``times``.

    ``speed`` is that of the frame in which the waves are nearly still, one for each axis; it costs
    nothing and allows long steps. ``tolerance`` is the accepted error of ``judged(ring)``, an array
    whose shape does not depend on the ring's points; by default, of the stretches of all bonds at
    the state's own points. ``times`` increase from ``state.t`` on. Raises ValueError for invalid
    arguments, for a lattice that blows up before the last time, and for a tolerance that needs too
    many points or that rounding errors exceed.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> chain = numeric_lattice(LATTICES["fput"], {"K2": 1, "K3": 0, "K4": 0})
    >>> x, k = 20.5 / 64 * np.arange(64), 2 * np.pi / 20.5
    >>> ring = FieldRing(0.0, (0.0,), (20.5,), np.cos(k * x)[None], np.zeros((1, 64)))
    >>> run = spectral_integrate(chain, ring, [50.0], 1e-6, speed=1.0)
    >>> exact = np.cos(k * x) * np.cos(2 * np.sin(k / 2) * 50.0)
    >>> error = np.abs(run.states[0].at(x) - exact).max()
    >>> bool(error <= run.error_estimate <= 1e-6)
    True
    """
    state = _checked_ring(lattice, state)
    moments = checked_times(times, state.t)
    check_positive("tolerance", tolerance, "it is the accepted error of the judged quantity")
    frame = _frame(lattice, speed)
    started = perf_counter()
    comparison = None if judged is None else FieldComparison(judged)
    engine = FieldRingEngine(lattice, state, moments, frame, tolerance, comparison)
    refined = refine(engine, tolerance)
    trial = refined.trial
    if trial.values is None:
        raise ValueError(engine.refusal(float(moments[-1])))
    ring, rows = trial.payload
    states = tuple(FieldRing(**row) for row in rows)
    steps, evaluations = ring.integrator.steps, ring.integrator.evaluations
    cost = Cost(steps, evaluations, trial.seconds, perf_counter() - started)
    return SpectralTrajectory(moments, states, refined.error, trial.choices.step, cost)


def _checked_ring(lattice: NumericLattice, state: FieldRing) -> FieldRing:
    """Return the ring with arrays of doubles; raise ValueError if it does not fit the lattice."""
    if lattice.cellwise[1] is not None:
        raise ValueError(
            f"lattice must be the same in all cells, got disorder in {lattice.name} (a wave's "
            "points lie between cells; lattice.integrate runs it)"
        )
    f, v = checked_fields(lattice, state.f, state.v)
    ring = replace(state, f=f, v=v)
    for length in ring.circumferences:
        check_positive("circumference", length, "sites around the ring, any real number")
    if not len(ring.left) == len(ring.circumferences) == lattice.dimension:
        raise ValueError(
            f"state.left and state.circumferences must have {lattice.dimension} entries, got "
            f"{len(ring.left)} and {len(ring.circumferences)} (one for each axis)"
        )
    return ring


def _frame(lattice: NumericLattice, speed: float | tuple[float, ...]) -> tuple[float, ...]:
    """Return the frame's speed along each axis."""
    speeds = tuple(np.atleast_1d(real_array("every speed", speed)).tolist())
    if len(speeds) < lattice.dimension and not any(speeds):
        speeds = (0.0,) * lattice.dimension
    if len(speeds) != lattice.dimension or not all(map(math.isfinite, speeds)):
        raise ValueError(
            f"speed must have one finite entry for each of {lattice.dimension} axes, got {speed} "
            "(0 is a frame at rest)"
        )
    return speeds


@dataclass(frozen=True)
class FieldComparison:
    """Quantities of a ring: ``judged`` ones, in ``unit`` of the fields, and ``stored`` ones.

    ``at_sites``: they are taken at the sites of one lattice only, each a point of the state.
    ``stored`` returns what is saved at each time. Runs are also compared by ``around`` at the end.
    A run in which a judged value exceeds the ``limit`` has no values. ``wider`` returns lattice and
    state of a wider ring, used by every other run.
    """

    judged: Judged
    unit: float = 1.0
    at_sites: bool = False
    stored: Callable[[FieldRing], Memory] = vars
    around: Judged | None = None
    limit: float | None = None
    wider: Callable[[], tuple[NumericLattice, FieldRing]] | None = None


WIDER_SIZE = 2.0
"""`Choices.size` of a run on the wider ring; other runs have the size 1."""


class FieldRingEngine(SpectralSearch):
    """Runs of a ring of fields from a state, for `refine`.

    By default the stretches of all bonds are judged, at the state's points; ``sight`` gives another
    comparison. Steps tried are at most ``longer`` times the natural step of the ring's waves. A
    carrier is integrated exactly and allows longer steps.
    """

    kinds: tuple[Kind, ...] = ("step", "sampling")
    decay = math.inf
    safety = RING_SAFETY
    most_work = math.inf

    def __init__(
        self,
        lattice: NumericLattice,
        state: FieldRing,
        times: Array,
        speed: tuple[float, ...],
        tolerance: float,
        sight: FieldComparison | None = None,
        longer: float = 1.0,
    ) -> None:
        super().__init__(state.t, float(times[-1] - state.t), max(map(abs, speed)), tolerance)
        self.amplifies_rounding = not lattice.is_linear
        self._lattice, self._state, self._speed = lattice, state, speed
        counts = state.counts
        self._sight = sight or FieldComparison(
            lambda ring: np.array(ring_stretches(lattice, ring.sampled(counts)))
        )
        self._times, unit = times, self._sight.unit
        largest = float(np.max(np.abs(state.f)))
        least = rounding_error(largest / unit, 100)
        if tolerance < least:
            raise ValueError(
                f"tolerance must satisfy tolerance >= {least:.2g} here, got {tolerance:g} (less is "
                "rounding)"
            )
        self._tail = max(TAIL_SHARE * tolerance * unit, ROUNDED_TAIL * largest)
        self._is_lattice = sight is None and whole(state)
        self._density, self._needs_too_many = self._first_density(), False
        self._dense_state: dict[tuple[float, tuple[int, ...]], FieldRing] = {}
        self._first = self._first_choices(longer)

    def _first_density(self) -> float:
        """Return the least density of points, relative to the state's, that resolves the state."""
        if self._is_lattice:
            return 1.0
        density = 1.0
        while density > 0.02:
            counts = _fast_counts(self._state, 0.8 * density)
            fewer = self._state.sampled(counts)
            if fewer.tail() > 0.3 * self._tail or counts >= self._state.counts:
                break
            density *= 0.8
        return density

    def _first_choices(self, longer: float) -> Choices:
        """Return choices with the first step, from the rates of the part not integrated exactly."""
        T = self._duration
        ring = self._ring(Choices(T, 1.0), math.inf)
        moving, still = ring.typical_rates()
        slopes = ring_slopes(self._lattice, ring.start)
        slope_spread = self._lattice.highest_frequency([float(np.ptp(part)) for part in slopes])
        mean = self._lattice.highest_frequency([abs(float(np.mean(part))) for part in slopes])
        turning = 0.5 * still * slope_spread**2 / max(mean**2, 1e-300)
        values = self._sight.judged(self._state)
        size = float(np.ptp(values)) if values.size else 0.0
        turns = 1.0 + turning * T
        share = min(10.0 * self._tolerance / max(size, 1e-300) / turns, 1.0)
        rate = max(moving + turning, 1e-12 * still, 1e-300)
        step = min(share ** (1.0 / ORDER) / rate, 0.25 * T) or 1.0
        fast = [axis for axis, c in enumerate(self._speed) if c]
        if fast and T > 0.0:
            spread = max(crest_energy_spread(self._lattice, ring.start, axis) for axis in fast)
            self._lattice_spread = turns * spread * size
            if self._must_resolve:
                step = min(step, self._resolving)
        return Choices(min(longer * step, max(step, self._resolving)), 1.0)

    def first(self) -> Choices:
        """Return choices with the natural step of the waves."""
        return self._first

    def _add_points(self, choices: Choices) -> bool:
        self._density *= DENSER
        self._needs_too_many = not self._sight.at_sites and self.points(choices) > MOST_POINTS
        return not self._needs_too_many

    def _handle_loss(self, error: RunawayError, step: float) -> None:
        self._needs_too_many = False
        if self._lost_again(error, step):
            raise ValueError(self.refusal(float(self._times[-1])))

    def points(self, choices: Choices) -> float:
        """Return the number of points of a ring."""
        return math.prod(self._counts(choices))

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """Return choices with a shorter step (and the other of two rings), or with more points."""
        if "step" in kinds and self._sight.wider is not None:
            choices = replace(choices, size=WIDER_SIZE if choices.size == 1.0 else 1.0)
        return super().control(choices, kinds)

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """Return choices with a shorter step or more points, never on the wider ring."""
        if kind == "sampling":
            density = choices.density if self._is_unaliased(choices) else DENSER * choices.density
            return replace(choices, density=density, size=1.0)
        return replace(self._shorter(choices, excess), size=1.0)

    def refusal(self, end: float) -> str:
        """Return the message for a search in which no run reached the time ``end``."""
        if self._needs_too_many:
            return (
                f"tolerance must be larger than {self._tolerance:g}: it needs a ring of more than "
                f"{MOST_POINTS} points (raise it, end earlier or take smoother data)"
            )
        return (
            f"times must end before the fields of {self._lattice.name} run away, got {end:g} (no "
            "step follows them; end earlier or take smaller fields)"
        )

    def _initial_data(self, choices: Choices) -> tuple[NumericLattice, FieldRing]:
        """Return the lattice and the initial state of a run, before the state is resampled."""
        if choices.size > 1.0 and self._sight.wider is not None:
            return self._sight.wider()
        return self._lattice, self._state

    def _counts(self, choices: Choices) -> tuple[int, ...]:
        """Return the number of points along each axis."""
        _, state = self._initial_data(choices)
        if self._is_lattice:
            return state.counts
        counts = _fast_counts(state, self._density * choices.density, choices.finer)
        pairs = zip(counts, state.counts, strict=True)
        return state.counts if self._sight.at_sites and any(a >= b for a, b in pairs) else counts

    def _is_unaliased(self, choices: Choices) -> bool:
        """Return whether the ring's points are a lattice's sites, so that no modes are aliased."""
        _, state = self._initial_data(choices)
        at_sites = self._sight.at_sites and self._counts(choices) == state.counts
        return self._is_lattice or at_sites

    def _ring(self, choices: Choices, tail: float) -> LatticeRing:
        """Return the ring at the start of a run."""
        lattice, state = self._initial_data(choices)
        key = choices.size, self._counts(choices)
        if key not in self._dense_state:
            self._dense_state[key] = state.sampled(key[1])
        state = self._dense_state[key]
        if choices.nudged:
            f, v = nudged(state.f, state.v)
            state = replace(state, f=f, v=v)
        return LatticeRing(lattice, state, choices.step, self._duration, self._speed, tail)

    def _run(self, choices: Choices, progress: Progress) -> Trial:
        loop = begin_loop(f"spectral {choices} {self._counts(choices)}")
        ring = self._ring(choices, math.inf if self._is_unaliased(choices) else self._tail)
        rows: list[tuple[Array, Memory, Array | None]] = []
        sight, end = self._sight, self._times[-1]

        def memory() -> Memory:
            return {"rows": rows, "ring": ring.memory()}

        if loop.memory is not None:
            rows.extend(loop.memory["rows"])
            ring.recall(loop.memory["ring"])
        for t in self._times[len(rows) :]:
            state = ring.at(float(t), lambda: loop.offer(memory))
            around = sight.around(state) if sight.around and t == end else None
            rows.append((sight.judged(state), sight.stored(state), around))
            progress((float(t) - self._state.t) / (self._duration or 1.0))
        loop.end(memory)
        judged, stored, arounds = zip(*rows, strict=True)
        values = np.array(judged)
        sound = sight.limit is None or bool(np.all(np.abs(values) <= sight.limit))
        return Trial(
            choices,
            values if sound else None,
            self.work(choices),
            perf_counter() - loop.begun,
            rounding_error(ring.largest / sight.unit, ring.integrator.evaluations),
            (ring, stored),
            common_error=self._unresolved_error(choices),
            around=arounds[-1] if sound else None,
        )


def _fast_counts(state: FieldRing, density: float, finer: float = 1.0) -> tuple[int, ...]:
    """Return even counts with fast transforms, at least ``finer * density`` times the state's."""
    return tuple(fast_count(finer * max(density * n, LEAST_POINTS)) for n in state.counts)

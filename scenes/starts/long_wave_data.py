"""A long wave on a lattice: the fields of the ansatz at cells and times, by a reduction's numbers.

``f_j = background + eps^p (e_j W + G_j)``, and f_j', are polynomials in X-derivatives of the wave
(`long_wave_numbers`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.numeric_lattice import NumericLattice, place_text
from longwave.scenes.starts.damped_soliton import DampedSoliton
from longwave.scenes.starts.first_correction import FirstCorrection, JetWave
from longwave.scenes.starts.jet_polynomial import JetPolynomial
from longwave.scenes.starts.lattice_wave import (
    LatticeWave,
    largest_group_velocity,
    sound_speed,
)
from longwave.scenes.starts.wave_extent import extent, places_about, support_of, watched_times
from longwave.solutions import NumericWave
from longwave.solutions.pieces import PIECE

if TYPE_CHECKING:
    from longwave.solutions.numeric_wave import PlanarValues

Array = NDArray[np.float64]

FLAT = 1e-9
"""A wave has ended where it changes by less than that share of its size."""

FARTHEST = 400.0
"""A wave that has not ended so far in X fills the line."""


@dataclass(frozen=True)
class SlowFrame:
    """A slow variable ``eps**exponent (direction . cell - speed t)`` with numbers."""

    exponent: int
    direction: tuple[float, ...]
    speed: float


@dataclass(frozen=True)
class LongWaveNumbers:
    """Numbers of a reduction at values of the constants and eps: all that `LongWaveData` takes.

    ``lattice`` has no mean strain. The wave has the size ``eps**amplitude`` and ``T = eps**time
    t``; ``frames`` are those of X and, if there is one, Z. ``background`` is the uniform strain.
    ``shares`` are those of the fields in the wave. ``series`` holds each field and its time
    derivative in X-jets of the unknown: W on a lattice of ``is_displacement``, Y on one of strains.
    It is empty with Z. ``correction`` is the power of the first one, the flow of the reduced
    equation and the correction's own, None unless it is asked for.
    """

    lattice: NumericLattice
    frames: tuple[SlowFrame, ...]
    series: tuple[tuple[JetPolynomial, JetPolynomial], ...]
    correction: tuple[int, JetPolynomial, JetPolynomial] | None
    is_displacement: bool
    amplitude: int
    time: int
    background: float
    shares: tuple[float, ...]


class LongWaveData(LatticeWave):
    """The data and the theory of a wave on a lattice under one reduction.

    ``numbers`` are the reduction's (`long_wave_numbers`).  ``order``: "leading", the wave alone;
    "slaved", with the fields that follow it, as far as the reduction was taken; "corrected", with
    the reduced equation's first correction as well, see `FirstCorrection`.  ``interval``: of X, for
    the correction of a wave that does not end: many times its width, or whole periods, so that it
    closes.

    Raises ValueError for a correction of a wave that does not end or is too narrow.
    """

    def __init__(
        self,
        numbers: LongWaveNumbers,
        wave: JetWave,
        eps: float,
        order: str = "slaved",
        interval: tuple[float, float] | None = None,
    ) -> None:
        self.numbers, self.wave = numbers, wave
        self.eps, self.order = eps, order
        self._space = numbers.frames[0]
        self._is_displacement = numbers.is_displacement
        self.power = numbers.amplitude + self._space.exponent * self._is_displacement
        self.slow = numbers.time
        self._frame, self._direction = self._space.speed, self._space.direction
        self.speed = self._frame / self._direction[0]
        self.lattice = numbers.lattice
        self._planar: PlanarFields | None = None
        self.correction = self._correction(interval)
        if not numbers.series:
            self._planar = PlanarFields(numbers, cast(PlanarWave, wave), eps)
        self._series = numbers.series

    def strained(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """The lattice about this uniform strain."""
        return self.numbers.lattice.with_mean_strain(mean_strain, self.growth_shares)

    @property
    def growth_shares(self) -> tuple[float, ...]:
        """The shares of the fields in the wave, which alone grows from cell to cell."""
        return self.numbers.shares

    def _correction(self, interval: tuple[float, float] | None) -> FirstCorrection | None:
        if self.numbers.correction is None:
            return None
        power, flow, further = self.numbers.correction
        if interval is not None:
            return FirstCorrection(flow, further, self.wave, power, interval, repeats=True)
        low, high = wave_ends(lambda X: self._profile(X, 0.0))
        if math.isinf(low):
            raise ValueError(
                "interval must be given for the correction of a wave that does not end, got None "
                "(whole periods of X, or many times its width)"
            )
        if not low < high:
            raise ValueError(
                f"wave must be wide enough for its correction, got one between X = {low:g} and "
                f"{high:g} (take a smaller kappa)"
            )
        middle, half = (low + high) / 2.0, MARGIN * (high - low) / 2.0
        return FirstCorrection(flow, further, self.wave, power, (middle - half, middle + half))

    def crest(self, t: float) -> float | None:
        """The first quantity at a soliton's crest by the law of its losses."""
        if not isinstance(self.wave, DampedSoliton):
            return None
        share = self.growth_shares[0] * (self._direction[0] if self._is_displacement else 1.0)
        height = self.wave.crest(self.slow_time(t))
        return float(self.uniform()[0] + share * self.scale * height)

    def slow_time(self, t: float) -> float:
        """T at the time t."""
        return float(self.eps**self.slow * t)

    def slow_place(self, cells: ArrayLike, t: float) -> Array:
        """X at cells and a time."""
        places = np.asarray(cells, dtype=np.float64)
        axes = places if len(self._direction) > 1 else places[np.newaxis]
        along = sum(step * axis for step, axis in zip(self._direction, axes, strict=True))
        return np.asarray(self.eps**self._space.exponent * (along - self._frame * t))

    def start(self, t: float) -> None:
        """Let the corrected wave be the closed form at this time; nothing for other orders."""
        if self.correction is not None:
            self.correction.start(self.slow_time(t))

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Fields and their time derivatives, (fields, *sites)."""
        if self._planar is not None:
            return self._planar.state(cells, t)
        places, rates = zip(*self._series, strict=True)
        f, v = self._valued([places, rates], self.slow_place(cells, t), t)
        return f, v

    def _valued(
        self, groups: Sequence[Sequence[JetPolynomial]], place: Array, t: float
    ) -> list[Array]:
        """The values of groups of polynomials in the unknown, each (polynomials, *sites), at X.

        Jets are made for `PIECE` cells at a time, of which they take many times the memory.
        """
        X, T = place.ravel(), self.slow_time(t)
        highest = max(polynomial.highest for group in groups for polynomial in group)
        W = self._displacement(X, T) if self._is_displacement else None
        found = [np.empty((len(group), X.size)) for group in groups]
        for first in range(0, X.size, PIECE):
            piece = slice(first, first + PIECE)
            jets = self._unknown(X[piece], T, highest, None if W is None else W[piece])
            for values, group in zip(found, groups, strict=True):
                for row, polynomial in zip(values, group, strict=True):
                    row[piece] = polynomial(jets)
        return [values.reshape(-1, *place.shape) for values in found]

    def strain(self, cells: ArrayLike, t: float) -> Array:
        """The fields of strains; of displacements what they grow by along each axis of the wave."""
        if not self._is_displacement:
            return self._fields(cells, t)
        n = np.asarray(cells, dtype=np.float64)
        if n.ndim == 1 and n.size > PIECE and np.all(np.diff(n) == 1.0):
            return np.diff(self._fields(np.append(n, n[-1] + 1.0), t))
        here = self._fields(cells, t)
        rows = []
        for axis in self._axes:
            step = np.zeros(len(self._direction))
            step[axis] = 1.0
            places = np.asarray(cells, dtype=np.float64)
            shift = step.reshape(-1, *(1,) * (places.ndim - 1)) if step.size > 1 else step[0]
            rows.append(self._fields(places + shift, t) - here)
        return np.concatenate(rows)

    def _fields(self, cells: ArrayLike, t: float) -> Array:
        """The fields without their rates."""
        if self._planar is not None:
            return self._planar.state(cells, t)[0]
        return self._valued([[place for place, _ in self._series]], self.slow_place(cells, t), t)[0]

    @property
    def quantities(self) -> tuple[str, ...]:
        """What displacements grow by along the axes that the wave moves on, or the strains."""
        if not self._is_displacement:
            return super().quantities
        here = (0,) * self.lattice.dimension
        next_cells = (tuple(int(at == axis) for at in range(len(here))) for axis in self._axes)
        return tuple(
            f"{place_text(name, there)} - {place_text(name, here)}"
            for there in next_cells
            for name in self.lattice.fields
        )

    def measured(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """The same from the periodic parts of the fields on a ring with this mean strain."""
        fields = np.asarray(f, dtype=np.float64)
        if not self._is_displacement:
            return fields
        shares = np.reshape(self.growth_shares, (-1, *(1,) * (fields.ndim - 1)))
        rows = [
            np.roll(fields, -1, 1 + axis) - fields + shares * mean_strain[axis]
            for axis in self._axes
        ]
        return np.concatenate(rows)

    def uniform(self) -> Array:
        """The uniform strain that the wave is added to."""
        return np.full(self._quantities, self.numbers.background)

    def background(self, cells: ArrayLike, t: float) -> Array:
        """The uniform strain, with the bare wave that the wave deviates from, to leading order."""
        X = self.slow_place(cells, t)
        found = np.add.outer(self.uniform(), np.zeros(X.shape))
        if self._planar is None:
            bare = self.eps**self.power * self.wave.background(X, self.slow_time(t)).Y
            steps = [self._direction[axis] for axis in self._axes] if self._is_displacement else [1]
            shares = np.multiply.outer(steps, self.growth_shares).ravel()
            found += np.multiply.outer(shares, bare)
        return found

    def mean_strain(self, cells: Array, t: float) -> tuple[float, ...]:
        """What displacements grow by in a cell, on average over a ring of these cells.

        Of a wave in two dimensions, what it grows by from end to end is averaged over the ends.
        """
        if not self._is_displacement:
            return (0.0,) * self.lattice.dimension
        places = cells if len(self._direction) > 1 else cells[np.newaxis]
        slopes = [0.0] * len(self._direction)
        shares = self.growth_shares
        leader = next(j for j, share in enumerate(shares) if share)
        for axis in self._axes:
            first, last = (np.take(places, [end], 1 + axis) for end in (0, -1))
            last[axis] += 1.0
            low, high = (
                self._fields(end if len(slopes) > 1 else end[0], t) for end in (first, last)
            )
            grown = float(np.mean(high[leader] - low[leader])) / shares[leader]
            slopes[axis] = grown / places.shape[1 + axis]
        return tuple(slopes)

    def support(self, t: float) -> tuple[float, float]:
        """The cells between which there is a wave; infinite where it does not end."""
        T = self.slow_time(t)
        low, high = wave_ends(lambda X: self._profile(X, T))
        ends = sorted((X / self._unit + self.speed * t) for X in (low, high))
        return ends[0], ends[1]

    @cached_property
    def far_speed(self) -> float | None:
        """The speed of sound on the wave's constant background, if it has one along a chain."""
        wave = self.wave
        is_fed = isinstance(wave, NumericWave) and wave.constant_background is not None
        if not is_fed or self.lattice.dimension > 1 or self.correction:
            return None
        if self.speed <= 0.0 or self._unit <= 0.0:
            return None
        slopes = self._far_slopes
        return sound_speed(self.lattice, slopes, self.speed) if slopes else None

    @cached_property
    def far_fastest(self) -> float:
        """The largest group velocity about the wave's constant background."""
        return largest_group_velocity(self.lattice, self._far_slopes)

    @cached_property
    def _far_slopes(self) -> list[float]:
        """The slopes of forces on the constant background; none where one is not finite."""
        (f, _), middle = self._far_fields(), self.lattice.reach
        with np.errstate(all="ignore"):
            stretches = self.lattice.stretches(f)
        slopes = [float(slope[middle]) for slope in self.lattice.slopes(stretches)]
        return slopes if all(map(math.isfinite, slopes)) else []

    @cached_property
    def far_rates(self) -> tuple[Array, Array]:
        """What displacements grow by there, which move as a whole with it; of strains nothing."""
        (f, v), middle = self._far_fields(), self.lattice.reach
        return f[:, middle + 1] - f[:, middle], v[:, middle]

    def _far_fields(self) -> tuple[Array, Array]:
        """Fields and velocities of the constant background alone in a few cells."""
        cells = np.arange(2.0 * self.lattice.reach + 2.0)
        level = cast(NumericWave, self.wave).constant_background or 0.0
        highest = max(each.highest for pair in self._series for each in pair)
        jets = np.zeros((max(highest, 1) + 1, cells.size))
        jets[0] = level
        if self._is_displacement:
            jets[:2] = level * self._unit * cells, np.full(cells.size, level)
        f, v = (np.stack([each(jets) for each in rows]) for rows in zip(*self._series, strict=True))
        return f, v

    def extent(self, times: Sequence[float], tolerance: float) -> tuple[float, float]:
        """Cells from the frame's origin on which the wave deviates from its background."""
        wave, supports = cast(NumericWave, self.wave), []
        level = wave.constant_background or 0.0
        for T in map(self.slow_time, watched_times(times)):
            X = places_about(wave.slow_phase_zeros(T) or [0.0], 1.0 / abs(wave.numbers.a))
            supports.append(support_of(X, np.abs(wave(X, T).Y - level), tolerance))
        low, high = extent(supports)
        return low / self._unit, high / self._unit

    def rigid(self, offsets: Array, t: float) -> tuple[Array, Array]:
        """Fields without the growth of the background, and their slopes from cell to cell."""
        places = [place for place, _ in self._series]
        slopes = [place.slope() for place in places]
        f, moved = self._valued([places, slopes], self._unit * offsets, t)
        growth = self.far_rates[0][:, np.newaxis]
        return f - growth * (offsets + self.speed * t), self._unit * moved - growth

    @property
    def _unit(self) -> float:
        """X from cell to cell."""
        return float(self._direction[0] * self.eps**self._space.exponent)

    def seam_room(self, t: float) -> int:
        """Half a kink's width: where strains to its left and right met at once, they overshot."""
        low, high = self.support(t)
        if not self._is_displacement or len(self._direction) > 1 or math.isinf(high - low):
            return 0
        left, right = self.strain(np.array([low, high]), t)[0]
        return math.ceil((high - low) / 2.0) if abs(right - left) > FLAT * self.scale else 0

    def _profile(self, X: Array, T: float) -> Array:
        """The wave along X, where Z is 0."""
        if self._planar is not None:
            return cast(PlanarWave, self.wave)(X, T, Z=0.0).Y
        return self.wave.jets(X, T, 0)[0]

    @cached_property
    def _axes(self) -> list[int]:
        return [axis for axis, step in enumerate(self._direction) if step]

    @property
    def _quantities(self) -> int:
        return len(self.lattice.fields) * (len(self._axes) if self._is_displacement else 1)

    def _unknown(self, X: Array, T: float, highest: int, W: Array | None) -> Array:
        """The jets that the series are written in: of W, which is given, or of Y."""
        if W is None:
            return self._corrected(self.wave.jets(X, T, highest), X, T, highest)
        jets = np.empty((highest + 1, *X.shape))
        jets[0] = W
        if highest:
            found = self.wave.jets(X, T, highest - 1)
            jets[1:] = self._corrected(found, X, T, highest - 1)
        return jets

    def _displacement(self, X: Array, T: float) -> Array:
        """W with ``W_X = Y``."""
        W = self.wave.antiderivative(X, T)
        if self.correction is not None:
            W = W + self._share * self.correction.antiderivative(X, T)
        return W

    def _corrected(self, jets: Array, X: Array, T: float, highest: int) -> Array:
        if self.correction is None:
            return jets
        return np.asarray(jets + self._share * self.correction.jets(X, T, highest))

    @property
    def _share(self) -> float:
        assert self.correction is not None
        return float(self.eps**self.correction.power)


SAMPLES = 4097
"""Of a wave where its ends are looked for."""

MARGIN = 3.0
"""The interval of a correction, in units of the wave's."""


def wave_ends(profile: Callable[[Array], Array]) -> tuple[float, float]:
    """The places in X between which a function of X changes; infinite if it does not end."""
    reach = 1.0
    while reach <= FARTHEST:
        X = np.linspace(-2.0 * reach, 2.0 * reach, SAMPLES)
        Y = profile(X)
        left, right = np.abs(Y - Y[0]), np.abs(Y - Y[-1])
        level = FLAT * max(float(left.max()), float(right.max()))
        risen, fallen = np.flatnonzero(left > level), np.flatnonzero(right > level)
        if risen.size and fallen.size and -reach <= X[risen[0]] and X[fallen[-1]] <= reach:
            return float(X[risen[0]]), float(X[fallen[-1]])
        reach *= 2.0
    return -math.inf, math.inf


class PlanarWave(Protocol):
    """A solution of a reduced equation with Z, such as a `solutions.Wave` of KP."""

    def potential(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike) -> PlanarValues:
        """W with ``W_X = Y``, and its derivatives."""

    def __call__(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike) -> PlanarValues:
        """Y and its derivatives."""


class PlanarFields:
    """The one field of a wave with a slow variable across, and its time derivative.

    That is not local in jets: it is by the chain rule through X, Z and T.
    """

    def __init__(self, numbers: LongWaveNumbers, wave: PlanarWave, eps: float) -> None:
        self._wave, self._is_displacement = wave, numbers.is_displacement
        self._amplitude = eps**numbers.amplitude
        self._unit = eps**numbers.time
        self._frames = [(eps**f.exponent, f.direction, f.speed) for f in numbers.frames]

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """The field and its time derivative, (1, *sites)."""
        axes = np.asarray(cells, dtype=np.float64)
        X, Z = (
            unit * (sum(d * axis for d, axis in zip(steps, axes, strict=True)) - speed * t)
            for unit, steps, speed in self._frames
        )
        ask = self._wave.potential if self._is_displacement else self._wave
        values = ask(X, self._unit * t, Z=Z)
        (along, _, c), (across, _, drift) = self._frames
        moved = self._unit * values.Y_T - along * c * values.Y_X - across * drift * values.Y_Z
        return self._amplitude * values.Y[None], self._amplitude * moved[None]

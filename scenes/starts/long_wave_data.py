"""Long waves on a lattice: fields of the ansatz at cells and times, from a reduction's numbers.

``f_j = background + eps^p (e_j W + G_j)`` and its time derivative are polynomials in X-derivatives
of the wave (`long_wave_numbers`).
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
from longwave.scenes.starts.lattice_wave import LatticeWave, largest_group_velocity, sound_speed
from longwave.scenes.starts.wave_extent import extent, sample_points, sampled_times, support_of
from longwave.solutions import NumericWave
from longwave.solutions.pieces import PIECE

if TYPE_CHECKING:
    from longwave.solutions.numeric_wave import PlanarValues

Array = NDArray[np.float64]

END_LEVEL = 1e-9
"""Deviation of the profile, relative to its largest, below which a wave counts as ended."""

FARTHEST_X = 400.0
"""Distance in X at which a wave that has not ended counts as infinite."""


@dataclass(frozen=True)
class SlowFrame:
    """Slow variable ``eps**exponent (direction . cell - speed t)`` with numeric parameters."""

    exponent: int
    direction: tuple[float, ...]
    speed: float


@dataclass(frozen=True)
class LongWaveNumbers:
    """Numeric form of a reduction, at values of the constants and eps, as used by `LongWaveData`.

    ``lattice`` has no mean strain. The wave has size ``eps**amplitude`` and ``T = eps**time t``;
    ``frames`` are X and, if there is one, Z. ``background`` is the uniform strain. ``shares`` are
    the relative amplitudes of the fields in the wave. ``series`` holds each field and its time
    derivative as polynomials in X-derivatives of the unknown: W with ``is_displacement``, Y on a
    lattice of strains. ``series`` is empty if there is a Z. ``correction`` holds the power of the
    first correction, the flow of the reduced equation and that of the correction; None unless
    requested.
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
    """Long wave of a reduction on its lattice: initial data and reference values.

    ``numbers`` are those of `long_wave_numbers`.  The order "leading" is the wave alone;
    "slaved" adds the fields slaved to it, up to the order of the reduction; "corrected" also adds
    the first correction of the reduced equation, see `FirstCorrection`.  ``interval`` is the
    interval of X for the correction of an infinite wave: many widths or whole periods.

    Raises ValueError for a correction if the wave is too narrow, or infinite without an interval.
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
        self._series = numbers.series
        if not self._series:
            self._planar = PlanarFields(numbers, cast(PlanarWave, wave), eps)

    def strained_lattice(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """Return the lattice about this uniform strain."""
        return self.numbers.lattice.with_mean_strain(mean_strain, self.growth_shares)

    @property
    def growth_shares(self) -> tuple[float, ...]:
        """Growth of each field's displacement per cell, in units of the mean strain."""
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
                "(two ends in X that enclose whole periods, or many widths of the wave)"
            )
        if not low < high:
            raise ValueError(
                f"wave must be wide enough for its correction, got one between X = {low:g} and "
                f"{high:g} (take a smaller kappa)"
            )
        middle, half = (low + high) / 2.0, INTERVAL_FACTOR * (high - low) / 2.0
        return FirstCorrection(flow, further, self.wave, power, (middle - half, middle + half))

    def crest(self, t: float) -> float | None:
        """Return the first quantity at a damped soliton's crest by its law; None otherwise."""
        if not isinstance(self.wave, DampedSoliton):
            return None
        share = self.growth_shares[0] * (self._direction[0] if self._is_displacement else 1.0)
        height = self.wave.crest(self.slow_time(t))
        return float(self.uniform()[0] + share * self.scale * height)

    def slow_time(self, t: float) -> float:
        """Return the slow time T at time t."""
        return float(self.eps**self.slow * t)

    def slow_position(self, cells: ArrayLike, t: float) -> Array:
        """Return X at cells and time t."""
        positions = np.asarray(cells, dtype=np.float64)
        axes = positions if len(self._direction) > 1 else positions[np.newaxis]
        along = sum(step * axis for step, axis in zip(self._direction, axes, strict=True))
        return np.asarray(self.eps**self._space.exponent * (along - self._frame * t))

    def start(self, t: float) -> None:
        """Start the correction from 0 at time t; no effect in other orders than "corrected"."""
        if self.correction is not None:
            self.correction.start(self.slow_time(t))

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Return fields and their time derivatives at cells and a time, each (fields, *sites)."""
        if self._planar is not None:
            return self._planar.state(cells, t)
        fields, rates = zip(*self._series, strict=True)
        f, v = self._evaluate([fields, rates], self.slow_position(cells, t), t)
        return f, v

    def _evaluate(
        self, groups: Sequence[Sequence[JetPolynomial]], position: Array, t: float
    ) -> list[Array]:
        """Return each group's values at X = ``position`` and time t, (polynomials, *sites).

        Derivatives are computed for `PIECE` cells at a time, because they need many arrays.
        """
        X, T = position.ravel(), self.slow_time(t)
        highest = max(polynomial.highest for group in groups for polynomial in group)
        W = None
        if self._is_displacement:
            W = self.wave.antiderivative(X, T)
            if self.correction is not None:
                W = W + self._share * self.correction.antiderivative(X, T)
        results = [np.empty((len(group), X.size)) for group in groups]
        for first in range(0, X.size, PIECE):
            piece = slice(first, first + PIECE)
            jets = self._unknown(X[piece], T, highest, None if W is None else W[piece])
            for values, group in zip(results, groups, strict=True):
                for row, polynomial in zip(values, group, strict=True):
                    row[piece] = polynomial(jets)
        return [values.reshape(-1, *position.shape) for values in results]

    def strain(self, cells: ArrayLike, t: float) -> Array:
        """Return the compared quantities at cells and a time, (quantities, *sites).

        These are the fields if they are strains, or else the differences of displacements to the
        next cell along each axis in which the wave varies.
        """
        if not self._is_displacement:
            return self._fields(cells, t)
        n = np.asarray(cells, dtype=np.float64)
        if n.ndim == 1 and n.size > PIECE and np.all(np.diff(n) == 1.0):
            return np.diff(self._fields(np.append(n, n[-1] + 1.0), t))
        here = self._fields(n, t)
        rows = []
        for axis in self._axes:
            step = np.zeros(len(self._direction))
            step[axis] = 1.0
            shift = step.reshape(-1, *(1,) * (n.ndim - 1)) if step.size > 1 else step[0]
            rows.append(self._fields(n + shift, t) - here)
        return np.concatenate(rows)

    def _fields(self, cells: ArrayLike, t: float) -> Array:
        """Return the fields at cells and a time, without their time derivatives."""
        if self._planar is not None:
            return self._planar.state(cells, t)[0]
        fields = [field for field, _ in self._series]
        return self._evaluate([fields], self.slow_position(cells, t), t)[0]

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the compared quantities: differences of displacements, or the strain fields."""
        if not self._is_displacement:
            return super().quantities
        here = (0,) * self.lattice.dimension
        next_cells = (tuple(int(at == axis) for at in range(len(here))) for axis in self._axes)
        return tuple(
            f"{place_text(name, there)} - {place_text(name, here)}"
            for there in next_cells
            for name in self.lattice.fields
        )

    def quantity_values(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """Return the compared quantities of a ring with periodic fields and a mean strain."""
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
        """Return the uniform strain of each quantity, on which the wave is superposed."""
        rows = len(self._axes) if self._is_displacement else 1
        return np.full(rows * len(self.lattice.fields), self.numbers.background)

    def background(self, cells: ArrayLike, t: float) -> Array:
        """Return the background's compared quantities: uniform strain plus bare wave."""
        X = self.slow_position(cells, t)
        strain = np.add.outer(self.uniform(), np.zeros(X.shape))
        if self._planar is None:
            bare = self.eps**self.power * self.wave.background(X, self.slow_time(t)).Y
            steps = [self._direction[axis] for axis in self._axes] if self._is_displacement else [1]
            shares = np.multiply.outer(steps, self.growth_shares).ravel()
            strain += np.multiply.outer(shares, bare)
        return strain

    def mean_strain(self, cells: Array, t: float) -> tuple[float, ...]:
        """Return the mean growth of displacements per cell over a ring of these cells.

        On a plane, the growth along an axis is averaged over the other axis.
        """
        if not self._is_displacement:
            return (0.0,) * self.lattice.dimension
        positions = cells if len(self._direction) > 1 else cells[np.newaxis]
        slopes = [0.0] * len(self._direction)
        shares = self.growth_shares
        leader = next(j for j, share in enumerate(shares) if share)
        for axis in self._axes:
            first, last = (np.take(positions, [end], 1 + axis) for end in (0, -1))
            last[axis] += 1.0
            ends = (first, last) if len(slopes) > 1 else (first[0], last[0])
            low, high = (self._fields(end, t) for end in ends)
            growth = float(np.mean(high[leader] - low[leader])) / shares[leader]
            slopes[axis] = growth / positions.shape[1 + axis]
        return tuple(slopes)

    def support(self, t: float) -> tuple[float, float]:
        """Return the wave's first and last cell at time t; infinite for a wave without ends."""
        T = self.slow_time(t)
        low, high = wave_ends(lambda X: self._profile(X, T))
        ends = sorted((X / self._unit + self.speed * t) for X in (low, high))
        return ends[0], ends[1]

    @cached_property
    def far_speed(self) -> float | None:
        """Speed of sound on the wave's constant background on a chain; None for other waves."""
        wave = self.wave
        has_far_field = isinstance(wave, NumericWave) and wave.constant_background is not None
        if not has_far_field or self.lattice.dimension > 1 or self.correction:
            return None
        if self.speed <= 0.0 or self._unit <= 0.0:
            return None
        slopes = self._far_slopes
        return sound_speed(self.lattice, slopes, self.speed) if slopes else None

    @cached_property
    def far_fastest(self) -> float:
        """Largest group velocity about the wave's constant background."""
        return largest_group_velocity(self.lattice, self._far_slopes)

    @cached_property
    def _far_slopes(self) -> list[float]:
        """Slope of each bond's force on the constant background; empty if a slope is not finite."""
        (f, _), middle = self._far_fields(), self.lattice.reach
        with np.errstate(all="ignore"):
            stretches = self.lattice.stretches(f)
        slopes = [float(slope[middle]) for slope in self.lattice.slopes(stretches)]
        return slopes if all(map(math.isfinite, slopes)) else []

    @cached_property
    def far_rates(self) -> tuple[Array, Array]:
        """Growth per cell, and velocity, of each field on the constant background."""
        (f, v), middle = self._far_fields(), self.lattice.reach
        return f[:, middle + 1] - f[:, middle], v[:, middle]

    def _far_fields(self) -> tuple[Array, Array]:
        """Return fields and velocities of the constant background in a few cells."""
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
        """Return the wave's ends over all times, in cells from the frame's origin.

        (inf, -inf) if the wave never differs noticeably from its background.
        """
        wave, supports = cast(NumericWave, self.wave), []
        level = wave.constant_background or 0.0
        for T in map(self.slow_time, sampled_times(times)):
            X = sample_points(wave.slow_phase_zeros(T) or [0.0], 1.0 / abs(wave.numbers.a))
            supports.append(support_of(X, np.abs(wave(X, T).Y - level), tolerance))
        low, high = extent(supports)
        return low / self._unit, high / self._unit

    def rigid_fields(self, offsets: Array, t: float) -> tuple[Array, Array]:
        """Return fields and slopes per cell at ``offsets`` from the frame's origin at time t.

        The growth of the background from cell to cell is subtracted from both.
        """
        fields = [field for field, _ in self._series]
        derivatives = [field.slope() for field in fields]
        f, slopes = self._evaluate([fields, derivatives], self._unit * offsets, t)
        growth = self.far_rates[0][:, np.newaxis]
        return f - growth * (offsets + self.speed * t), self._unit * slopes - growth

    @property
    def _unit(self) -> float:
        """Change of X per cell."""
        return float(self._direction[0] * self.eps**self._space.exponent)

    def seam_room(self, t: float) -> int:
        """Return the number of blended cells at either end of a ring: half a kink's width, or 0.

        Without blending, the strains on both sides of a kink would overshoot at the seam.
        """
        low, high = self.support(t)
        if not self._is_displacement or len(self._direction) > 1 or math.isinf(high - low):
            return 0
        left, right = self.strain(np.array([low, high]), t)[0]
        return math.ceil((high - low) / 2.0) if abs(right - left) > END_LEVEL * self.scale else 0

    def _profile(self, X: Array, T: float) -> Array:
        """Return the wave's Y along X at T; on a plane at Z = 0."""
        if self._planar is not None:
            return cast(PlanarWave, self.wave)(X, T, Z=0.0).Y
        return self.wave.jets(X, T, 0)[0]

    @cached_property
    def _axes(self) -> list[int]:
        return [axis for axis, step in enumerate(self._direction) if step]

    def _unknown(self, X: Array, T: float, highest: int, W: Array | None) -> Array:
        """Return ``W`` or, if it is None, Y, with the X-derivatives up to order ``highest``."""
        if W is None:
            return self._corrected(self.wave.jets(X, T, highest), X, T, highest)
        jets = np.empty((highest + 1, *X.shape))
        jets[0] = W
        if highest:
            strains = self.wave.jets(X, T, highest - 1)
            jets[1:] = self._corrected(strains, X, T, highest - 1)
        return jets

    def _corrected(self, jets: Array, X: Array, T: float, highest: int) -> Array:
        if self.correction is None:
            return jets
        return np.asarray(jets + self._share * self.correction.jets(X, T, highest))

    @property
    def _share(self) -> float:
        assert self.correction is not None
        return float(self.eps**self.correction.power)


END_SAMPLES = 4097
"""Number of points in X at which a wave's ends are searched for."""

INTERVAL_FACTOR = 3.0
"""Length of the interval on which a correction is solved, in units of the wave's length."""


def wave_ends(profile: Callable[[Array], Array]) -> tuple[float, float]:
    """Return the ends in X of the region where a profile varies; infinite beyond `FARTHEST_X`."""
    reach = 1.0
    while reach <= FARTHEST_X:
        X = np.linspace(-2.0 * reach, 2.0 * reach, END_SAMPLES)
        Y = profile(X)
        left, right = np.abs(Y - Y[0]), np.abs(Y - Y[-1])
        level = END_LEVEL * max(float(left.max()), float(right.max()))
        risen, fallen = np.flatnonzero(left > level), np.flatnonzero(right > level)
        if risen.size and fallen.size and -reach <= X[risen[0]] and X[fallen[-1]] <= reach:
            return float(X[risen[0]]), float(X[fallen[-1]])
        reach *= 2.0
    return -math.inf, math.inf


class PlanarWave(Protocol):
    """Solution of a reduced equation with Z, such as a `solutions.Wave` of KP."""

    def potential(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike) -> PlanarValues:
        """Return W with ``W_X = Y``, and its first derivatives by X, T and Z."""

    def __call__(self, X: ArrayLike, T: ArrayLike, *, Z: ArrayLike) -> PlanarValues:
        """Return Y and its first derivatives by X, T and Z."""


class PlanarFields:
    """Field of a wave with a transverse slow variable Z, and its time derivative.

    The time derivative is computed by the chain rule through X, Z and T, because W_T is not a
    polynomial in X-derivatives of W.
    """

    def __init__(self, numbers: LongWaveNumbers, wave: PlanarWave, eps: float) -> None:
        self._wave, self._is_displacement = wave, numbers.is_displacement
        self._amplitude = eps**numbers.amplitude
        self._unit = eps**numbers.time
        self._frames = [(eps**f.exponent, f.direction, f.speed) for f in numbers.frames]

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Return the field and its time derivative, each (1, *sites)."""
        axes = np.asarray(cells, dtype=np.float64)
        X, Z = (
            unit * (sum(d * axis for d, axis in zip(steps, axes, strict=True)) - speed * t)
            for unit, steps, speed in self._frames
        )
        evaluate = self._wave.potential if self._is_displacement else self._wave
        values = evaluate(X, self._unit * t, Z=Z)
        (along, _, c), (across, _, drift) = self._frames
        rate = self._unit * values.Y_T - along * c * values.Y_X - across * drift * values.Y_Z
        return self._amplitude * values.Y[None], self._amplitude * rate[None]

"""Sampled fields and velocities of any lattice on a ring of real circumferences at one time.

Fields that are L-periodic in a real cell variable x and obey the lattice's equations with shifts
f(x) -> f(x + s) obey them at every x + n: such a ring is an exact quasi-periodic solution of the
infinite lattice, whatever L is. Each axis has its own circumference.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import ArrayLike

from longwave.support.real_arrays import Array, Complex

TAIL_DIVISOR = 8
"""The last 1/TAIL_DIVISOR of the spectrum counts as its tail."""

INTERPOLATION_ERROR = 1e-13
"""Accuracy of the interpolation, relative to the root mean square sum of the coefficients."""


def modes_of(values: Array) -> Complex:
    """Return Fourier coefficients over all axes but the first; only k >= 0 on the last axis."""
    axes = tuple(range(min(1, values.ndim - 1), values.ndim))
    return ducc0.fft.r2c(values, axes=axes, inorm=2, nthreads=1)


def values_of(modes: Complex, last: int, out: Array | None = None) -> Array:
    """Return the real functions with these coefficients, ``last`` points along the last axis."""
    axes = tuple(range(min(1, modes.ndim - 1), modes.ndim))
    return ducc0.fft.c2r(modes, axes=axes, lastsize=last, forward=False, out=out)


def fast_count(minimum: float) -> int:
    """Return the smallest even number >= ``minimum`` with a fast Fourier transform."""
    return 2 * int(ducc0.fft.good_size(math.ceil(minimum / 2.0), True))


@dataclass(frozen=True)
class FieldRing:
    """Samples of fields ``f`` and velocities ``v`` at time ``t``, shape (fields, *counts).

    Along each axis the points are ``left + j circumference/count``. For displacements that grow
    with the cell, the mean strain is in the lattice, and the fields here are periodic.

    >>> x = 7.5 / 16 * np.arange(16)
    >>> wave = np.cos(2 * np.pi * x / 7.5)[None]
    >>> ring = FieldRing(0.0, (0.0,), (7.5,), wave, 0 * wave)
    >>> ring.at(7.5 / 4 + 7.5 / 12).round(9)
    array([[-0.5]])
    """

    t: float
    left: tuple[float, ...]
    circumferences: tuple[float, ...]
    f: Array
    v: Array

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of points along each axis."""
        return self.f.shape[1:]

    def points(self, axis: int = 0) -> Array:
        """Return the sample points along an axis."""
        steps = np.arange(self.counts[axis], dtype=np.float64)
        return np.asarray(self.left[axis] + self.circumferences[axis] / steps.size * steps)

    def at(self, *x: ArrayLike) -> Array:
        """Return the fields, (fields, positions), at real positions ``x``: one array per axis."""
        return self._interpolated(self.f, x)

    def velocities_at(self, *x: ArrayLike) -> Array:
        """Return the velocities, (fields, positions), at real positions ``x``, as `at` does."""
        return self._interpolated(self.v, x)

    def sampled(self, counts: tuple[int, ...]) -> FieldRing:
        """Return the same functions, exactly, sampled at other numbers of points."""
        if counts == self.counts:
            return self
        f, v = (_sampled(values, counts) for values in (self.f, self.v))
        return replace(self, f=f, v=v)

    def tail(self) -> float:
        """Return a bound of the field contributed by the last 1/TAIL_DIVISOR of the spectrum."""
        return spectrum_tails(modes_of(self.f), self.counts)

    def _interpolated(self, values: Array, x: tuple[ArrayLike, ...]) -> Array:
        positions = [np.atleast_1d(np.asarray(part, dtype=np.float64)) for part in x]
        turns = [
            np.mod((position - left) / length, 1.0) * (2.0 * math.pi)
            for position, left, length in zip(
                positions, self.left, self.circumferences, strict=True
            )
        ]
        coordinates = np.stack(np.broadcast_arrays(*turns), axis=-1)
        result = [self._along(part, coordinates.reshape(-1, len(turns))) for part in values]
        return np.stack(result).reshape(len(values), *coordinates.shape[:-1])

    def _along(self, values: Array, turns: Array) -> Array:
        modes = np.fft.fftshift(np.fft.fftn(values, norm="forward"))
        padding = [(0, 1 - count % 2) for count in values.shape]
        modes = _with_both_ends(modes, padding)
        padded = [(0, 1 - count % 2) for count in modes.shape]
        values_at_turns = ducc0.nufft.u2nu(
            grid=np.pad(modes, padded),
            coord=turns,
            forward=False,
            epsilon=INTERPOLATION_ERROR,
            periodicity=2.0 * math.pi,
        )
        return np.ascontiguousarray(values_at_turns.real)


def _with_both_ends(modes: Complex, padding: list[tuple[int, int]]) -> Complex:
    """Return shifted coefficients, padded; an unpaired highest one is split between both ends."""
    modes = np.pad(modes, padding)
    for axis, (_, more) in enumerate(padding):
        if more:
            ends = [(slice(None),) * axis + (end,) for end in (0, -1)]
            modes[ends[0]] *= 0.5
            modes[ends[1]] = modes[ends[0]]
    return modes


def _sampled(values: Array, counts: tuple[int, ...]) -> Array:
    """Return the trigonometric interpolants at other numbers of points, axis by axis."""
    for axis, count in enumerate(counts, 1):
        before = values.shape[axis]
        if before == count:
            continue
        modes = np.moveaxis(np.fft.fft(values, axis=axis, norm="forward"), axis, 0)
        number = np.fft.fftfreq(before, 1.0 / before).astype(np.int64)
        resampled = np.zeros((count, *modes.shape[1:]), dtype=np.complex128)
        np.add.at(resampled, number % count, modes)
        if before % 2 == 0:
            half = 0.5 * modes[before // 2]
            resampled[-(before // 2) % count] -= half
            resampled[before // 2 % count] += half
        interpolated = np.fft.ifft(np.moveaxis(resampled, 0, axis), axis=axis, norm="forward")
        values = np.ascontiguousarray(interpolated.real)
    return values


def spectrum_tails(modes: Complex, counts: tuple[int, ...]) -> float:
    """Return an upper bound, for all fields, of the sum of the tail of the modes along any axis."""
    magnitudes = np.abs(modes)
    magnitudes[..., 1 : (counts[-1] + 1) // 2] *= 2.0
    inner = magnitudes
    for axis, count in enumerate(counts, 1):
        last = axis == len(counts)
        most = count // 2
        numbers = np.abs(np.fft.fftfreq(count, 1.0 / count)) if not last else np.arange(most + 1)
        is_inner = numbers < most + 1 - max((most + 1) // TAIL_DIVISOR, 1)
        inner = np.compress(is_inner, inner, axis=axis)
    axes = tuple(range(1, modes.ndim))
    outer = np.sum(magnitudes, axis=axes) - np.sum(inner, axis=axes)
    return float(np.max(np.maximum(outer, 0.0)))

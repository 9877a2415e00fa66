"""Any lattice on a ring of real circumferences, by exponential integration of its normal modes.

In the frame that moves at c, the characteristic variables of the normal coordinates a are

    p_-+ = a' -+ i w a,    p_-+' = i (c k -+ w) p_-+ + N.

The linear part about the mean slope of each bond's force is integrated exactly. N, the rest of the
forces, is computed point by point on a grid that does not move; only the integration uses the
moving frame. Waves that move at c are nearly still in it, so steps may be long. If the grid has a
whole number of points per site, shifts lead from point to point. Each point is then a site of a
lattice of its own, without aliasing.

The time, on which the frame's position depends, is stored as the last of the modes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.spectral.evolution import STEPS_PER_CHECK, RunawayError, SamplingError
from longwave.lattice.spectral.exponential import ExponentialAdams
from longwave.lattice.spectral.field_ring import FieldRing, modes_of, spectrum_tails, values_of
from longwave.lattice.spectral.normal_modes import multipliers, normal_modes
from longwave.support.compiled.jit import complexes, doubles, njit
from longwave.support.real_arrays import Array, Complex, Mask

if TYPE_CHECKING:
    from longwave.support.checkpoint import Memory

MIN_RUN_ANGLE = 0.03
"""Phase change over the whole run, in radians, of the lowest frequency; lower ones are raised to
it."""

PHASE_BLOCK = 64
"""Number of a chain's modes in a block: a phase is a factor for the block times one for the
mode."""

_jit = partial(njit, cache=True, fastmath={"contract"})
_PHASES_EXAMPLE = complexes(1), complexes(1)


@_jit(examples=[(complexes(2), complexes(3), *_PHASES_EXAMPLE, complexes(2))])
def _bend(p: Complex, lift: Complex, coarse: Complex, fine: Complex, out: Complex) -> None:
    """Compute into ``out`` the modes of the bonds' stretches, in the frame at rest."""
    bonds, branches, modes = lift.shape
    for bond in range(bonds):
        for k in range(modes):
            total = 0j
            for j in range(branches):
                total += lift[bond, j, k] * (p[1, j * modes + k] - p[0, j * modes + k])
            out[bond, k] = total * (coarse[k // fine.size] * fine[k % fine.size])


@_jit(examples=[(complexes(2), complexes(3), *_PHASES_EXAMPLE, complexes(1))])
def _drive(force: Complex, drive: Complex, coarse: Complex, fine: Complex, out: Complex) -> None:
    """Compute into ``out`` how bond forces drive the normal coordinates, in the moving frame."""
    branches, bonds, modes = drive.shape
    for k in range(modes):
        phase = (coarse[k // fine.size] * fine[k % fine.size]).conjugate()
        for j in range(branches):
            total = 0j
            for bond in range(bonds):
                total += drive[j, bond, k] * force[bond, k]
            out[j * modes + k] = total * phase


@_jit(examples=[(doubles(1), 0.0, doubles(1), 0.0)])
def _polynomial_residual(x: Array, offset: float, coefficients: Array, slope: float) -> None:
    """Replace x, in place, by the polynomial force at ``offset + x`` minus ``slope * x``."""
    degree = coefficients.size
    for i in range(x.size):
        stretch = offset + x[i]
        force = coefficients[degree - 1]
        for power in range(degree - 2, -1, -1):
            force = coefficients[power] + stretch * force
        x[i] = stretch * force - slope * x[i]


def _residual(x: Array, offset: float, force: ForceProgram, slope: float) -> None:
    """Replace x, in place, by the force at ``offset + x`` minus ``slope * x``."""
    if force.instructions:
        with np.errstate(all="ignore"):
            x[...] = force(x + offset) - slope * x
        return
    _polynomial_residual(x.reshape(-1), offset, np.array(force.coefficients), slope)


class LatticeRing:
    """A ring of fields that is advanced in steps of ``step``; `at` returns it at a time.

    ``duration`` is that of the run, ``speed`` that of the frame along each axis. At the start and
    every ``STEPS_PER_CHECK`` steps the fields are checked. SamplingError is raised when their
    spectrum's tail exceeds ``tail``, RunawayError when the fields are not finite or the tail
    exceeds their initial size. The tail also bounds the aliasing of products. ``start`` is the
    initial ring, ``largest`` the largest field met.
    """

    def __init__(
        self,
        lattice: NumericLattice,
        state: FieldRing,
        step: float,
        duration: float,
        speed: tuple[float, ...],
        tail: float = math.inf,
    ) -> None:
        self.start, self._bound = state, tail
        self.largest = 0.0
        k = wavenumbers(state)
        self._shape = tuple(len(part) for part in k)
        grid = np.stack(np.meshgrid(*k, indexing="ij"), axis=-1).reshape(-1, len(k))
        slopes = [float(np.mean(part)) for part in ring_slopes(lattice, state)]
        least = MIN_RUN_ANGLE / duration if duration > 0.0 else 1.0
        self.modes = normal_modes(lattice, grid, slopes, least)
        self._mode_mask = _symmetric_modes(state)
        self._prepare(lattice, grid, slopes)
        self._size = len(grid)
        self._turning = [-1j * c * part for c, part in zip(speed, k, strict=True)]
        frame = 1j * (grid @ np.array(speed))
        w = self.modes.w
        linear = np.stack([frame - 1j * w, frame + 1j * w]).reshape(2, -1)
        a, b = (self.modes.coordinates(self._masked_modes(values)) for values in (state.f, state.v))
        p = np.stack([b - 1j * w * a, b + 1j * w * a]).reshape(2, -1)
        self._divisor = (2j * w).reshape(-1)
        self._amplitude = _amplitude(state, float(np.max(np.abs(w))))
        self._first, self._linear = (np.pad(part, ((0, 0), (0, 1))) for part in (p, linear))
        self._step = step
        self._check(self._first, state.t)

    @cached_property
    def integrator(self) -> ExponentialAdams:
        """Integrator of the modes, created on first use."""
        return ExponentialAdams(self._linear, self._nonlinearity, self._first, self._step)

    def _prepare(self, lattice: NumericLattice, grid: Array, slopes: list[float]) -> None:
        """Set up the maps between modes and nonlinear bonds, and the raised frequencies."""
        fields, modes = len(lattice.fields), self.modes
        pairs = zip(lattice.bonds, slopes, strict=True)
        nonlinear = [  # nothing remains of a bond that is linear without a mean stretch
            (bond, slope) for bond, slope in pairs if bond.offset or not bond.force.is_linear
        ]
        self._bonds = [(bond.offset, bond.force, slope) for bond, slope in nonlinear]
        masses = np.array(lattice.masses)[:, None]
        stretch_maps = [multipliers(bond.stretch, grid, fields) for bond, _ in nonlinear]
        force_maps = [
            multipliers(bond.action, grid, fields) / masses * self._mode_mask
            for bond, _ in nonlinear
        ]
        shape = (0, fields, len(grid))
        self._lift = np.array(
            [
                np.einsum("ik,ijk->jk", part, modes.vectors) / (2j * modes.w)
                for part in stretch_maps
            ],
            dtype=np.complex128,
        ).reshape(-1, *shape[1:])
        drive = np.array([modes.coordinates(part) for part in force_maps], dtype=np.complex128)
        self._push = np.ascontiguousarray(drive.reshape(-1, *shape[1:]).swapaxes(0, 1))
        raised = np.flatnonzero(modes.excess)
        self._lifted = raised, (modes.excess / (2j * modes.w)).reshape(-1)[raised]

    def at(self, t: float, pause: Callable[[], None] = lambda: None) -> FieldRing:
        """Advance to time ``t``, not before the last one, and return the ring on the same points.

        ``pause`` is called after each check of the fields.
        """
        start, integrator = self.start, self.integrator
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(integrator.whole_steps(t - start.t)):
                integrator.step()
                if integrator.steps % STEPS_PER_CHECK == 0:
                    self._check(integrator.p, start.t + integrator.steps * integrator.h)
                    pause()
            p = integrator.solution_at(t - start.t)
        f = self._check(p, t)
        velocities = self._fields(0.5 * (p[0, :-1] + p[1, :-1]), p[0, -1].real)
        v = values_of(velocities, start.counts[-1])
        return FieldRing(t, start.left, start.circumferences, f, v)

    def memory(self) -> Memory:
        """Return the data from which `recall` resumes at a pause."""
        return {"largest": self.largest, "integrator": self.integrator.memory()}

    def recall(self, memory: Memory) -> None:
        """Restore the ring from the `memory` of one with the same arguments."""
        self.largest = memory["largest"]
        self.integrator.recall(memory["integrator"])

    def typical_rates(self) -> tuple[float, float]:
        """Return the rms frequency of the modes, in the moving frame and in the frame at rest.

        The fields' mean positions do not count: under a mean strain they rest away from 0.
        """
        p = self._first[:, :-1].copy()
        p[:, :: self._size] = np.mean(p[:, :: self._size], axis=0)
        weights = np.abs(p) ** 2
        total = float(np.sum(weights)) or 1.0
        moving_squares = np.abs(self._linear[:, :-1]) ** 2
        rest_squares = np.broadcast_to(np.abs(self._divisor / 2.0) ** 2, weights.shape)
        moving, at_rest = (
            math.sqrt(float(np.sum(weights * squares)) / total)
            for squares in (moving_squares, rest_squares)
        )
        return moving, at_rest

    def _masked_modes(self, values: Array) -> Complex:
        """Return the modes of values, (fields, modes), with 0 outside `_symmetric_modes`."""
        return modes_of(values).reshape(len(values), -1) * self._mode_mask

    def _phases(self, t: float) -> tuple[Complex, Complex]:
        """Return factors whose products take modes from the moving frame to the frame at rest."""
        if len(self._turning) == 2:
            coarse, fine = (np.exp(part * t) for part in self._turning)
            return coarse, fine
        (rates,) = self._turning
        step = rates[1] if rates.size > 1 else 0.0
        blocks = -(-rates.size // PHASE_BLOCK)
        fine = np.exp(step * t * np.arange(PHASE_BLOCK))
        return np.exp(step * t * PHASE_BLOCK * np.arange(blocks)), fine

    def _fields(self, coordinates: Complex, t: float) -> Complex:
        """Return the fields' modes in the frame at rest, in the shape of the Fourier transform."""
        coarse, fine = self._phases(t)
        phases = np.multiply.outer(coarse, fine).reshape(-1)[: self._size]
        fields = self.modes.fields(coordinates.reshape(-1, self._size)) * phases
        return fields.reshape(-1, *self._shape)

    def _check(self, p: Complex, t: float) -> Array:
        """Return the fields; raise RunawayError or SamplingError if the fields are not sound."""
        modes = self._fields((p[1, :-1] - p[0, :-1]) / self._divisor, p[0, -1].real)
        counts = self.start.counts
        f = values_of(modes, counts[-1])
        tail = spectrum_tails(modes, counts)
        self.largest = max(self.largest, float(np.max(np.abs(f))))
        if not (tail <= self._amplitude or math.isinf(self._bound)) or not np.all(np.isfinite(f)):
            raise RunawayError(t)
        if tail > self._bound:
            raise SamplingError(
                f"the spectrum's tail is {tail:.2g} at t = {t:g} (take more points)"
            )
        return f

    def _nonlinearity(self, p: Complex) -> Complex:
        out = np.zeros(p.shape[1], dtype=np.complex128)
        counts, bonds = self.start.counts, len(self._bonds)
        if bonds:
            coarse, fine = self._phases(p[0, -1].real)
            modes = np.empty((bonds, self._size), dtype=np.complex128)
            _bend(p, self._lift, coarse, fine, modes)
            x = values_of(modes.reshape(bonds, *self._shape), counts[-1])
            for values, bond in zip(x, self._bonds, strict=True):
                _residual(values, *bond)
            force = modes_of(x).reshape(bonds, -1)
            _drive(force, self._push, coarse, fine, out)
        raised, excess = self._lifted
        out[raised] += excess * (p[1, raised] - p[0, raised])
        out[-1] = 1.0
        return out


def _numbers(counts: tuple[int, ...]) -> list[Array]:
    """Return the integer wavenumbers of a real transform, axis by axis."""
    numbers = [np.asarray(np.fft.fftfreq(count, 1.0 / count)) for count in counts[:-1]]
    return [*numbers, np.arange(counts[-1] // 2 + 1, dtype=np.float64)]


def wavenumbers(state: FieldRing) -> list[Array]:
    """Return the wavenumbers of a real transform of the ring's fields, axis by axis."""
    lengths = state.circumferences
    numbers = _numbers(state.counts)
    return [2.0 * math.pi / length * part for length, part in zip(lengths, numbers, strict=True)]


def whole(state: FieldRing) -> bool:
    """Return whether shifts by a cell lead from point to point, so that points are sites."""
    return all(
        float(length).is_integer() and count % int(length) == 0
        for length, count in zip(state.circumferences, state.counts, strict=True)
    )


def _symmetric_modes(state: FieldRing) -> Mask:
    """Return a mask of the modes that stay modes of real functions when shifted.

    All modes are, or all but the highest.
    """
    numbers = _numbers(state.counts)
    mask = np.ones([part.size for part in numbers], dtype=np.bool_)
    if not whole(state):
        for axis, (part, count) in enumerate(zip(numbers, state.counts, strict=True)):
            inside = np.abs(part) < count / 2.0
            mask &= inside.reshape([-1 if other == axis else 1 for other in range(mask.ndim)])
    return mask.reshape(-1)


def ring_stretches(lattice: NumericLattice, state: FieldRing) -> list[Array]:
    """Return each bond's stretch, without its offset, at each point of the ring."""
    k = np.stack(np.meshgrid(*wavenumbers(state), indexing="ij"), axis=-1)
    flat = k.reshape(-1, k.shape[-1])
    modes = modes_of(state.f).reshape(len(state.f), -1)
    stretches = []
    for bond in lattice.bonds:
        stretch = np.sum(multipliers(bond.stretch, flat, len(state.f)) * modes, axis=0)
        stretches.append(values_of(stretch.reshape(1, *k.shape[:-1]), state.counts[-1])[0])
    return stretches


def ring_slopes(lattice: NumericLattice, state: FieldRing) -> list[Array]:
    """Return the slope of each bond's force at each point; raise ValueError if not finite."""
    result = []
    for bond, stretch in zip(lattice.bonds, ring_stretches(lattice, state), strict=True):
        with np.errstate(all="ignore"):
            slopes = bond.force.slope(stretch + bond.offset)
        if not np.all(np.isfinite(slopes)):
            raise ValueError(
                f"state must stretch the bonds of {lattice.name} to where forces are defined, "
                "got a stretch at which a slope is not (take smaller fields)"
            )
        result.append(slopes)
    return result


def _amplitude(state: FieldRing, highest: float) -> float:
    """Return the size of the fields: largest deviation plus velocity deviation over ``highest``."""
    axes = tuple(range(1, state.f.ndim))
    parts = [values - np.mean(values, axis=axes, keepdims=True) for values in (state.f, state.v)]
    still, moving = (float(np.max(np.abs(part))) for part in parts)
    return still + moving / highest

"""Any lattice on a ring of real circumferences, by exponential integration of its normal modes.

Of the normal coordinates a the characteristic variables in the frame that moves at c are

    p_-+ = a' -+ i w a,    p_-+' = i (c k -+ w) p_-+ + N.

The linear part about the mean slope of each bond's force is integrated exactly; N, what is left of
the forces, is formed point by point on a grid that stays where it is. So the frame is one of
integration alone: waves that move at c are nearly still in it, and steps may be long. Where the
grid has a whole number of points a site, shifts lead from point to point, and each point is a site
of a lattice of its own, which nothing is folded onto.

Time, which the frame's place depends on, is carried along as the last of the modes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import NumericBond, NumericLattice
from longwave.lattice.spectral.evolution import WATCH, RunawayError, SamplingError
from longwave.lattice.spectral.exponential import ExponentialAdams
from longwave.lattice.spectral.field_ring import FieldRing, modes_of, spectrum_tails, values_of
from longwave.lattice.spectral.normal_modes import multipliers, normal_modes
from longwave.support.compiled.jit import complexes, doubles, njit

if TYPE_CHECKING:
    from longwave.support.checkpoint import Memory

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STILL = 0.03
"""Frequencies below so many radians over the whole run are lifted to it."""

BLOCK = 64
"""Modes of a chain whose phases are products of a coarse and a fine one."""

_jit = partial(njit, cache=True, fastmath={"contract"})
_PHASES_EXAMPLE = complexes(1), complexes(1)


@_jit(examples=[(complexes(2), complexes(3), *_PHASES_EXAMPLE, complexes(2))])
def _bend(p: Complex, lift: Complex, coarse: Complex, fine: Complex, out: Complex) -> None:
    """The bonds' stretches in the frame that stands still."""
    bonds, branches, modes = lift.shape
    for bond in range(bonds):
        for k in range(modes):
            total = 0j
            for j in range(branches):
                total += lift[bond, j, k] * (p[1, j * modes + k] - p[0, j * modes + k])
            out[bond, k] = total * (coarse[k // fine.size] * fine[k % fine.size])


@_jit(examples=[(complexes(2), complexes(3), *_PHASES_EXAMPLE, complexes(1))])
def _drive(force: Complex, drive: Complex, coarse: Complex, fine: Complex, out: Complex) -> None:
    """What the bonds' forces do to the normal coordinates in the moving frame."""
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
    """Force at offset + x less the slope times x, in place."""
    degree = coefficients.size
    for i in range(x.size):
        stretch = offset + x[i]
        force = coefficients[degree - 1]
        for power in range(degree - 2, -1, -1):
            force = coefficients[power] + stretch * force
        x[i] = stretch * force - slope * x[i]


def _residual(x: Array, offset: float, force: ForceProgram, slope: float) -> None:
    """Force at offset + x less the slope times x, in place."""
    if force.instructions:
        with np.errstate(all="ignore"):
            x[...] = force(x + offset) - slope * x
        return
    _polynomial_residual(x.reshape(-1), offset, np.array(force.coefficients), slope)


class LatticeRing:
    """A ring of fields on its way, in steps of ``step``: ``at`` moves it and shows it.

    ``duration`` is the time that the run takes, ``speed`` that of the frame along each axis. At
    first and every ``WATCH`` steps the fields are looked at: SamplingError is raised when their
    spectrum's tail exceeds ``tail``, RunawayError when they are no numbers or the tail exceeds all
    that there was at first. What products fold back onto the modes is bounded by the tail, too.
    ``start`` is the ring at first, ``largest`` the largest field that was met.
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
        least = STILL / duration if duration > 0.0 else 1.0
        self.modes = normal_modes(lattice, grid, slopes, least)
        self._held = _held(state)
        self._prepare(lattice, grid, slopes)
        self._size = len(grid)
        self._turning = [-1j * c * part for c, part in zip(speed, k, strict=True)]
        frame = 1j * (grid @ np.array(speed))
        w = self.modes.w
        linear = np.stack([frame - 1j * w, frame + 1j * w]).reshape(2, -1)
        a, b = (self.modes.coordinates(self._kept(values)) for values in (state.f, state.v))
        p = np.stack([b - 1j * w * a, b + 1j * w * a]).reshape(2, -1)
        self._divisor = (2j * w).reshape(-1)
        self._amplitude = _amplitude(state, float(np.max(np.abs(w))))
        self._first, self._linear, self._step = _with_time(p), _with_time(linear), step
        self._watch(self._first, state.t)

    @cached_property
    def integrator(self) -> ExponentialAdams:
        """What moves the ring, begun when it is first asked for."""
        return ExponentialAdams(self._linear, self._nonlinearity, self._first, self._step)

    def _prepare(self, lattice: NumericLattice, grid: Array, slopes: list[float]) -> None:
        """What the nonlinear bonds take from the modes and give to them, and the lifted modes."""
        fields, modes = len(lattice.fields), self.modes
        pairs = zip(lattice.bonds, slopes, strict=True)
        bent = [(bond, slope) for bond, slope in pairs if not _is_exact(bond)]
        self._bonds = [(bond.offset, bond.force, slope) for bond, slope in bent]
        masses = np.array(lattice.masses)[:, None]
        lift = [multipliers(bond.stretch, grid, fields) for bond, _ in bent]
        push = [multipliers(bond.action, grid, fields) / masses * self._held for bond, _ in bent]
        shape = (0, fields, len(grid))
        self._lift = np.array(
            [np.einsum("ik,ijk->jk", part, modes.vectors) / (2j * modes.w) for part in lift],
            dtype=np.complex128,
        ).reshape(-1, *shape[1:])
        drive = np.array([modes.coordinates(part) for part in push], dtype=np.complex128)
        self._push = np.ascontiguousarray(drive.reshape(-1, *shape[1:]).swapaxes(0, 1))
        lifted = np.flatnonzero(modes.excess)
        self._lifted = lifted, (modes.excess / (2j * modes.w)).reshape(-1)[lifted]

    def at(self, t: float, pause: Callable[[], None] = lambda: None) -> FieldRing:
        """The ring at time ``t``, which must not lie before the last one; its points stay.

        ``pause`` is called on the way wherever the fields were looked at.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            p = self._moved(t - self.start.t, pause)
        f = self._watch(p, t)
        start = self.start
        velocities = self._fields(0.5 * (p[0, :-1] + p[1, :-1]), p[0, -1].real)
        v = values_of(velocities, start.counts[-1])
        return FieldRing(t, start.left, start.circumferences, f, v)

    def memory(self) -> Memory:
        """What `recall` needs at a pause."""
        return {"largest": self.largest, "integrator": self.integrator.memory()}

    def recall(self, memory: Memory) -> None:
        """Be where another ring, made alike, had that `memory`."""
        self.largest = memory["largest"]
        self.integrator.recall(memory["integrator"])

    def _moved(self, duration: float, pause: Callable[[], None]) -> Complex:
        integrator = self.integrator
        for _ in range(integrator.whole_steps(duration)):
            integrator.step()
            if integrator.steps % WATCH == 0:
                self._watch(integrator.p, self.start.t + integrator.steps * integrator.h)
                pause()
        return integrator.ahead(duration)

    def typical_rates(self) -> tuple[float, float]:
        """Mean frequency of what moves, in the frame that moves and in that which stands still.

        Where the fields' means are does not count: under a mean strain they rest away from 0.
        """
        p = self._first[:, :-1].copy()
        p[:, :: self._size] = np.mean(p[:, :: self._size], axis=0)
        share = np.abs(p) ** 2
        total = float(np.sum(share)) or 1.0
        moving = np.abs(self._linear[:, :-1]) ** 2
        still = np.broadcast_to(np.abs(self._divisor / 2.0) ** 2, share.shape)
        one, other = (math.sqrt(float(np.sum(share * rates)) / total) for rates in (moving, still))
        return one, other

    def _kept(self, values: Array) -> Complex:
        return modes_of(values).reshape(len(values), -1) * self._held

    def _phases(self, t: float) -> tuple[Complex, Complex]:
        """Factors whose products turn the modes from the moving frame back, by time ``t``."""
        if len(self._turning) == 2:
            coarse, fine = (np.exp(part * t) for part in self._turning)
            return coarse, fine
        (rates,) = self._turning
        step = rates[1] if rates.size > 1 else 0.0
        blocks = -(-rates.size // BLOCK)
        return np.exp(step * t * BLOCK * np.arange(blocks)), np.exp(step * t * np.arange(BLOCK))

    def _fields(self, coordinates: Complex, t: float) -> Complex:
        """The fields' modes in the frame that stands still, shaped as the transform wants them."""
        coarse, fine = self._phases(t)
        phases = np.multiply.outer(coarse, fine).reshape(-1)[: self._size]
        fields = self.modes.fields(coordinates.reshape(-1, self._size)) * phases
        return fields.reshape(-1, *self._shape)

    def _watch(self, p: Complex, t: float) -> Array:
        """The fields, if they are sound."""
        modes = self._fields((p[1, :-1] - p[0, :-1]) / self._divisor, p[0, -1].real)
        counts = self.start.counts
        f = values_of(modes, counts[-1])
        tail = spectrum_tails(modes, counts)
        self.largest = max(self.largest, float(np.max(np.abs(f))))
        if not (tail <= self._amplitude or math.isinf(self._bound)) or not np.all(np.isfinite(f)):
            raise RunawayError(t)
        if tail > self._bound:
            raise SamplingError(f"the spectrum's tail is {tail:.2g} at t = {t:g}")
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
        lifted, excess = self._lifted
        out[lifted] += excess * (p[1, lifted] - p[0, lifted])
        out[-1] = 1.0
        return out


def _is_exact(bond: NumericBond) -> bool:
    """Whether the linear part is all of it: a linear bond without a mean stretch."""
    return bond.force.is_linear and bond.offset == 0.0


def _with_time(values: Complex) -> Complex:
    return np.concatenate([values, np.zeros((2, 1), dtype=np.complex128)], axis=1)


def _numbers(counts: tuple[int, ...]) -> list[Array]:
    """The integer wave numbers of a real transform, axis by axis."""
    found = [np.asarray(np.fft.fftfreq(count, 1.0 / count)) for count in counts[:-1]]
    return [*found, np.arange(counts[-1] // 2 + 1, dtype=np.float64)]


def wavenumbers(state: FieldRing) -> list[Array]:
    """The wave numbers of a real transform of the ring's fields, axis by axis."""
    lengths = state.circumferences
    numbers = _numbers(state.counts)
    return [2.0 * math.pi / length * part for length, part in zip(lengths, numbers, strict=True)]


def whole(state: FieldRing) -> bool:
    """Whether shifts lead from point to point: then each point is a site of a lattice."""
    return all(
        float(length).is_integer() and count % int(length) == 0
        for length, count in zip(state.circumferences, state.counts, strict=True)
    )


def _held(state: FieldRing) -> NDArray[np.bool_]:
    """The modes that shifts take to modes of real functions: all, or all but the highest."""
    numbers = _numbers(state.counts)
    found = np.ones([part.size for part in numbers], dtype=np.bool_)
    if not whole(state):
        for axis, (part, count) in enumerate(zip(numbers, state.counts, strict=True)):
            inside = np.abs(part) < count / 2.0
            found &= inside.reshape([-1 if other == axis else 1 for other in range(found.ndim)])
    return found.reshape(-1)


def ring_stretches(lattice: NumericLattice, state: FieldRing) -> list[Array]:
    """What the fields add to each bond's stretch, point by point."""
    k = np.stack(np.meshgrid(*wavenumbers(state), indexing="ij"), axis=-1)
    flat = k.reshape(-1, k.shape[-1])
    modes = modes_of(state.f).reshape(len(state.f), -1)
    found = []
    for bond in lattice.bonds:
        stretch = np.sum(multipliers(bond.stretch, flat, len(state.f)) * modes, axis=0)
        found.append(values_of(stretch.reshape(1, *k.shape[:-1]), state.counts[-1])[0])
    return found


def ring_slopes(lattice: NumericLattice, state: FieldRing) -> list[Array]:
    """The slope of each bond's force, point by point; ValueError where there is none."""
    found = []
    for bond, stretch in zip(lattice.bonds, ring_stretches(lattice, state), strict=True):
        with np.errstate(all="ignore"):
            slopes = bond.force.slope(stretch + bond.offset)
        if not np.all(np.isfinite(slopes)):
            raise ValueError(
                f"state must stretch the bonds of {lattice.name} to where their forces exist, got "
                "a stretch without a slope (take smaller fields)"
            )
        found.append(slopes)
    return found


def _amplitude(state: FieldRing, highest: float) -> float:
    """A size of the fields that no tail of a sound spectrum reaches."""
    axes = tuple(range(1, state.f.ndim))
    parts = [values - np.mean(values, axis=axes, keepdims=True) for values in (state.f, state.v)]
    still, moving = (float(np.max(np.abs(part))) for part in parts)
    return still + moving / highest

"""The lattice on a ring of real circumference, by exponential integration in Fourier space.

If y(x, t) is L-periodic in the real variable x and obeys y_tt = D V'(y) with D f(x) = f(x + 1)
- 2 f(x) + f(x - 1), then y_n(t) = y(n, t) obeys the lattice equation at every integer n: a ring of
any real circumference L is an exact quasi-periodic solution of the infinite lattice. y is sampled
at M points of spacing L/M; shifts are Fourier multipliers.

In the frame that moves at c the characteristic variables

    p_-+ = s -+ i w y,    p_-+' = i (c k -+ w) p_-+ + N,    w = 2 sqrt(K2 + b) |sin(k/2)|

hold the right- and left-going waves. The linear part about the background, b = mean of V''(y) - K2,
is integrated exactly; N = D (V'(y) - (K2 + b) y) is what is left of the force. The mean of y, for
which w = 0, is kept in the place of p_-'s mode 0: it is driven by the constant mean of s.
"""

import math
from dataclasses import dataclass

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numba import njit
from numpy.typing import NDArray

from verify.exponential.adams import ExponentialAdams
from verify.lattice.constants import Constants

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

TAIL = 8
"""The spectrum's tail is its last 1/TAIL."""


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _strain_modes(p: Complex, inverse: Array, out: Complex) -> None:
    """y = (p_+ - p_-)/(2 i w), mode by mode."""
    out[0] = p[0, 0].real
    for k in range(1, p.shape[1]):
        difference = p[1, k] - p[0, k]
        out[k] = complex(difference.imag * inverse[k], -difference.real * inverse[k])


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _residual_force(y: Array, b: float, K3: float, K4: float) -> None:
    """V'(y) - (K2 + b) y, in place."""
    for i in range(y.size):
        y[i] *= y[i] * (K3 + K4 * y[i]) - b


@njit(cache=True, error_model="numpy")
def _bend(force: Complex, symbol: Array) -> None:
    for k in range(force.size):
        force[k] *= symbol[k]


def forward(values: Array) -> Complex:
    """Fourier coefficients 0 .. M/2 of a real periodic function, divided by M."""
    modes: Complex = ducc0.fft.r2c(values, inorm=2, nthreads=1)
    return modes


def backward(modes: Complex, count: int, out: Array | None = None) -> Array:
    """The real function with the coefficients ``modes`` at ``count`` points."""
    values: Array = ducc0.fft.c2r(modes, lastsize=count, forward=False, out=out, nthreads=1)
    return values


@dataclass(frozen=True)
class RingState:
    """Samples of strain and velocity at x = left + j L/M, j = 0 .. M - 1, at time ``t``."""

    t: float
    left: float
    circumference: float
    y: Array
    s: Array

    @property
    def points(self) -> Array:
        """The sample points."""
        steps = np.arange(self.y.size, dtype=np.float64)
        points: Array = self.left + self.circumference / self.y.size * steps
        return points

    def strain(self, x: Array) -> Array:
        """Strain at any real positions (trigonometric interpolation to 1e-12)."""
        modes = forward(self.y).astype(np.complex128)
        modes[1 : (self.y.size + 1) // 2] *= 2.0
        phase = (2.0 * math.pi / self.circumference) * (np.asarray(x, dtype=np.float64) - self.left)
        grid = np.concatenate([np.zeros(modes.size - 1), modes]).astype(np.complex128)
        values = ducc0.nufft.u2nu(
            grid=grid[:-1] if grid.size % 2 else grid,
            coord=np.mod(phase, 2.0 * math.pi)[:, None],
            forward=False,
            epsilon=1e-12,
            periodicity=2.0 * math.pi,
        )
        real: Array = np.ascontiguousarray(values.real, dtype=np.float64)
        return real

    def tail(self) -> float:
        """Largest modulus in the last 1/TAIL of the spectrum, against the largest of all."""
        modes = np.abs(forward(self.y))
        return float(modes[-(modes.size // TAIL) :].max() / modes.max())

    def at_rest(self) -> "RingState":
        """The same without mean velocity.

        Data cut off at a seam have one, of the order of the miss there; their mean would drift.
        """
        rest = self.s - float(np.mean(self.s))
        return RingState(self.t, self.left, self.circumference, self.y, rest)

    def resampled(self, count: int) -> "RingState":
        """The same function at ``count`` points."""
        y, s = (_resample(values, count) for values in (self.y, self.s))
        return RingState(self.t, self.left, self.circumference, y, s)


def _resample(values: Array, count: int) -> Array:
    modes = np.zeros(count // 2 + 1, dtype=np.complex128)
    source = forward(values)
    kept = min(modes.size, source.size) - 1
    modes[:kept] = source[:kept]
    return backward(modes, count)


class SpectralRing:
    """A ring on its way: `advance` moves it, `state` shows it.

    ``step`` is the first step to try. ``dealias`` drops the modes of the force above half of the
    highest one (exact for a cubic force); without it the tail of the spectrum bounds the aliasing.
    """

    def __init__(
        self, constants: Constants, state: RingState, step: float, dealias: bool = False
    ) -> None:
        self._constants = constants
        self._count = count = state.y.size
        self.left, self.circumference, self.t = state.left, state.circumference, state.t
        stiffness = float(np.mean(constants.stiffness(state.y)))
        k = 2.0 * math.pi / self.circumference * np.arange(count // 2 + 1)
        self._k, self._speed = k, constants.sound_speed()
        self._w = 2.0 * math.sqrt(stiffness) * np.abs(np.sin(k / 2.0))
        self._b = stiffness - constants.K2
        self._symbol = -4.0 * np.sin(k / 2.0) ** 2
        if dealias:
            self._symbol[k.size // 2 :] = 0.0
        self._inverse = np.zeros_like(k)
        np.divide(0.5, self._w, out=self._inverse, where=self._w > 1e-14)
        y, s = forward(state.y), forward(state.s)
        self._drift, self._origin = float(s[0].real), state.t
        self._modes = np.empty(k.size, dtype=np.complex128)
        self._values = np.empty(count)
        p = np.stack([s - 1j * self._w * y, s + 1j * self._w * y])
        p[:, 0] = y[0].real
        linear = 1j * np.stack([self._speed * k - self._w, self._speed * k + self._w])
        self.integrator = ExponentialAdams(linear, self._nonlinearity, p, self._norm, step)

    def advance(self, duration: float, rate: float) -> None:
        """Advance by ``duration``; ``rate`` is the error of y that is allowed per unit time."""
        self.integrator.advance(duration, rate)
        self.t += duration

    def state(self) -> RingState:
        """The ring at the present time; its points have moved with the frame."""
        p = self.integrator.p
        y = backward(self._strain(p), self._count)
        velocity = 0.5 * (p[0] + p[1])
        velocity[0] = self._drift
        s = backward(velocity, self._count)
        left = self.left + self._speed * (self.t - self._origin)
        return RingState(self.t, left, self.circumference, y, s)

    def _strain(self, p: Complex) -> Complex:
        _strain_modes(p, self._inverse, self._modes)
        return self._modes

    def _norm(self, change: Complex) -> float:
        """Sup norm of the strain that belongs to a change of p."""
        return float(np.max(np.abs(backward(self._strain(change), self._count, self._values))))

    def _nonlinearity(self, p: Complex) -> Complex:
        y = backward(self._strain(p), self._count, self._values)
        _residual_force(y, self._b, self._constants.K3, self._constants.K4)
        force = forward(y)
        _bend(force, self._symbol)
        force[0] = self._drift
        return force

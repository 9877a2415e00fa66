"""What a window is fed at its front: the wave's initial far field, moved rigidly.

In the frame that moves with it this is one smooth function, wanted on few hundred sites over and
over again. It is therefore evaluated once, on Chebyshev points, and interpolated from there.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from solutions import Wave
from solutions.jit import njit
from verify.lattice.initial import rigid_data, rigid_offsets
from verify.lattice.scene import Scene
from verify.lattice.state import Sites

Array = NDArray[np.float64]

DEGREES = (16, 32, 64, 128)
"""Degrees tried: Y2's far field takes the first of them."""

ROUNDING = 1e-14
"""Largest error of the interpolation, of y/eps or of what is largest."""

_jit = njit(cache=True, fastmath={"contract"}, error_model="numpy")


@_jit
def _clenshaw(coefficients: Array, u: Array) -> Array:
    """Sums of coefficients[:, k] T_k(u), of shape (rows of ``coefficients``, u.size)."""
    rows, terms = coefficients.shape
    found = np.empty((rows, u.size))
    for row in range(rows):
        c = coefficients[row]
        for i in range(u.size):
            one, two = 0.0, 0.0
            for k in range(terms - 1, 0, -1):
                one, two = c[k] + 2.0 * u[i] * one - two, one
            found[row, i] = c[0] + u[i] * one - two
    return found


@dataclass(frozen=True)
class Tail:
    """The initial strain that moves at ``speed``, and its velocity, on a stretch of its frame.

    ``low`` and ``high`` are offsets in sites from the place that began at c t0.
    """

    wave: Wave
    scene: Scene
    speed: float
    low: float
    high: float

    def at(self, sites: Sites, t: float) -> tuple[Array, Array]:
        """Strain and velocity at time t on the sites, which must be in the stretch by then."""
        offsets = rigid_offsets(self.scene, self.speed, sites, t)
        if self._coefficients is None:
            return rigid_data(self.wave, self.scene, self.speed, offsets)
        y, s = _clenshaw(self._coefficients, self._unit(offsets))
        return y, s

    def _unit(self, offsets: Array) -> Array:
        """The stretch as -1 .. 1."""
        return (offsets - 0.5 * (self.low + self.high)) * (2.0 / (self.high - self.low))

    def _exact(self, u: Array) -> Array:
        offsets = 0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * u
        return np.stack(rigid_data(self.wave, self.scene, self.speed, offsets))

    @cached_property
    def _coefficients(self) -> Array | None:
        """Those of strain and velocity; None if no degree gives what lies between its points."""
        for degree in DEGREES:
            points = chebyshev.chebpts1(degree + 1)
            values = self._exact(points)
            level = values[:, 0]  # small coefficients then have small roundings
            found = (values.T - level).T @ chebyshev.chebvander(points, degree) * 2.0 / points.size
            found[:, 0] = 0.5 * found[:, 0] + level
            between = np.concatenate([[-1.0], 0.5 * (points[1:] + points[:-1]), [1.0]])
            exact = self._exact(between)
            error = np.abs(_clenshaw(found, between) - exact).max()
            if error <= ROUNDING * max(self.scene.eps, np.abs(exact).max()):
                return found
        return None

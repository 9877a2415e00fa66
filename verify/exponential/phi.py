"""The phi functions of exponential integrators.

    phi_0(z) = exp(z),    phi_{m+1}(z) = (phi_m(z) - 1/m!)/z,    phi_m(0) = 1/m!

The recurrence loses digits where |z| < RADIUS. There each value is the mean of the recurrence over
a circle about z that keeps away from 0 (Kassam and Trefethen, SIAM J. Sci. Comput. 26 (2005) 1214).
"""

import math

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]

POINTS = 32
"""Points on the circle; the mean converges like 1/POINTS!."""

RADIUS = 2.0
"""From here outwards the recurrence is used; the circle has twice this radius."""


def phi_functions(z: Complex, highest: int) -> list[Complex]:
    """phi_0 .. phi_highest at the points ``z`` (any shape).

    >>> [round(float(value[0].real), 12) for value in phi_functions(np.zeros(1, complex), 2)]
    [1.0, 1.0, 0.5]
    """
    z = np.asarray(z, dtype=np.complex128)
    near = np.abs(z) < RADIUS
    values = _recurrence(np.where(near, RADIUS, z), highest)
    values[0] = np.exp(z)
    circle = 2.0 * RADIUS * np.exp(2j * np.pi * (np.arange(POINTS) + 0.5) / POINTS)
    for m, value in enumerate(_recurrence(z[near][..., None] + circle, highest)):
        values[m][near] = value.mean(axis=-1)
    return values


def _recurrence(z: Complex, highest: int) -> list[Complex]:
    values = [np.exp(z)]
    for m in range(highest):
        values.append((values[m] - 1.0 / math.factorial(m)) / z)
    return values


def moment_weights(z: Complex, nodes: NDArray[np.float64]) -> Complex:
    """Weights w_j(z) with int_0^1 exp((1 - u) z) f(u) du = sum_j w_j f(nodes_j).

    Exact for polynomials f of degree < len(nodes). Shape (len(nodes), *z.shape).
    """
    count = len(nodes)
    lagrange = np.linalg.inv(np.vander(nodes, count, increasing=True).T)
    functions = phi_functions(z, count)
    moments = np.stack([math.factorial(m) * functions[m + 1] for m in range(count)])
    return np.tensordot(lagrange, moments, axes=1)

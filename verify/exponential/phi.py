"""The phi functions of exponential integrators.

    phi_0(z) = exp(z),    phi_{m+1}(z) = (phi_m(z) - 1/m!)/z,    phi_m(0) = 1/m!

The recurrence loses digits near 0. Where |z| < RADIUS the highest function is summed as its power
series, and the others follow by the recurrence read backwards, which loses none.
"""

import math

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]

RADIUS = 2.0
"""From here outwards the recurrence is used."""

TERMS = 26
"""Terms of the series: RADIUS^TERMS/TERMS! is below the rounding."""


def phi_functions(z: Complex, highest: int) -> list[Complex]:
    """phi_0 .. phi_highest at the points ``z`` (any shape).

    >>> [round(float(value[0].real), 12) for value in phi_functions(np.zeros(1, complex), 2)]
    [1.0, 1.0, 0.5]
    """
    z = np.asarray(z, dtype=np.complex128)
    near = np.abs(z) < RADIUS
    values = _upwards(np.where(near, RADIUS, z), highest)
    for value, close in zip(values, _downwards(z[near], highest), strict=True):
        value[near] = close
    values[0] = np.exp(z)
    return values


def _upwards(z: Complex, highest: int) -> list[Complex]:
    values = [np.exp(z)]
    for m in range(highest):
        values.append((values[m] - 1.0 / math.factorial(m)) / z)
    return values


def _downwards(z: Complex, highest: int) -> list[Complex]:
    top = np.zeros_like(z)
    for j in reversed(range(TERMS)):
        top = top * z + 1.0 / math.factorial(highest + j)
    values = [top]
    for m in reversed(range(highest)):
        values.append(z * values[-1] + 1.0 / math.factorial(m))
    return values[::-1]


def moment_weights(z: Complex, nodes: NDArray[np.float64]) -> Complex:
    """Weights w_j(z) with int_0^1 exp((1 - u) z) f(u) du = sum_j w_j f(nodes_j).

    Exact for polynomials f of degree < len(nodes). Shape (len(nodes), *z.shape).
    """
    count = len(nodes)
    lagrange = np.linalg.inv(np.vander(nodes, count, increasing=True).T)
    functions = phi_functions(z, count)
    moments = np.stack([math.factorial(m) * functions[m + 1] for m in range(count)])
    return np.tensordot(lagrange, moments, axes=1)

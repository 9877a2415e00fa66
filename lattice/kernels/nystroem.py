"""Nystroem methods, such as RK4, on a ring of the strain FPUT lattice, compiled by numba.

    y_n' = s_n,    s_n' = D[K2 y + K3 y^2 + K4 y^3]_n,    D f_n = f_{n+1} - 2 f_n + f_{n-1}

(the paper's eq. (9), for the paper's eq. (4)). Site n is stored at index n mod N; which sites these
are is up to the caller.

A constant that is absent is passed as ``None``. Numba prunes branches on ``None`` by type, so each
combination of constants is compiled separately, without code for the absent terms.
"""

from itertools import product

import numpy as np

from longwave.support.compiled.jit import doubles, njit
from longwave.support.real_arrays import Array

_jit = njit(fastmath={"contract"})


@_jit
def force(y: float, K2: float, K3: float | None, K4: float | None) -> float:
    """Return V'(y) = K2 y + K3 y^2 + K4 y^3 (the paper's eq. (3)); absent constants are None."""
    if K4 is None:
        if K3 is None:
            return K2 * y
        return y * (K2 + K3 * y)
    if K3 is None:
        return y * (K2 + K4 * (y * y))
    return y * (K2 + y * (K3 + K4 * y))


@_jit
def _acceleration(y: Array, f: Array, g: Array, *constants: float | None) -> None:
    """Compute f = V'(y) and g = D f on the ring, in place."""
    size = y.size
    for i in range(size):
        f[i] = force(y[i], *constants)
    for i in range(size - 2):
        g[i + 1] = f[i] - 2.0 * f[i + 1] + f[i + 2]
    g[0] = f[size - 1] - 2.0 * f[0] + f[1]
    g[size - 1] = f[size - 2] - 2.0 * f[size - 1] + f[0]


@_jit
def _accumulate(total: Array, weight: float, term: Array) -> None:
    """Add ``weight * term`` to the array ``total``, in place."""
    if weight != 0.0:
        for i in range(total.size):
            total[i] += weight * term[i]


def advance_nystroem(
    y: Array, s: Array, table: tuple[Array, ...], h: float, steps: int, *constants: float | None
) -> None:
    """Advance the ring (y, s) in place by ``steps`` steps h of an explicit Nystroem method.

    ``table`` holds the method's nodes, inner and outer coefficients, and weights. Stage i is g_i =
    D V'(y + nodes_i h s + h^2 sum_j inner_ij g_j). Then y += h s + h^2 sum outer_i g_i and s += h
    sum weights_i g_i. The ring needs at least 3 sites.
    """
    space = np.empty((table[0].size + 2, y.size))
    _advance(y, s, table, h, steps, space, *constants)


_TABLE_EXAMPLE = doubles(1), doubles(2), doubles(1), doubles(1)
_EXAMPLES = [
    (doubles(1), doubles(1), _TABLE_EXAMPLE, 0.0, 0, doubles(2), 0.0, K3, K4)
    for K3, K4 in product((0.0, None), repeat=2)
]


@njit(cache=True, subnormals=False, examples=_EXAMPLES, fastmath={"contract"})
def _advance(
    y: Array,
    s: Array,
    table: tuple[Array, ...],
    h: float,
    steps: int,
    space: Array,
    *constants: float | None,
) -> None:
    """Advance as `advance_nystroem`; ``space`` is working memory, (stages + 2, sites)."""
    nodes, inner, outer, weights = table
    stages = nodes.size
    g, f, stage = space[:stages], space[stages], space[stages + 1]
    for _ in range(steps):
        for i in range(stages):
            for n in range(y.size):
                stage[n] = y[n]
            _accumulate(stage, nodes[i] * h, s)
            for j in range(i):
                _accumulate(stage, inner[i, j] * h * h, g[j])
            _acceleration(stage, f, g[i], *constants)
        _accumulate(y, h, s)
        for i in range(stages):
            _accumulate(y, outer[i] * h * h, g[i])
            _accumulate(s, weights[i] * h, g[i])

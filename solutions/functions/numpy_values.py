"""The Jacobi functions of (z, m) in NumPy, for `lambdify`.

Arguments are doubles; a `Wave` handles phases that are large or near k = 1.

>>> jacobi_sn([0.0, 1.0], 0.25).tolist()
[0.0, 0.8226355781298...]
"""

from functools import partial

import mpmath
import numpy as np
from numpy.typing import ArrayLike

from longwave.solutions.run.doubledouble import Array
from longwave.solutions.run.program import jacobi_program

_CONTEXT = mpmath.MPContext()


def _jacobi(index: int, z: ArrayLike, m: float) -> Array:
    """Return sn, cn, dn, zeta or Theta (``index`` 0 to 4) at z.

    Raises ValueError for m outside [0, 1], and for Theta at m = 1, where the nome is 1.
    """
    if not 0 <= m <= 1:
        raise ValueError(f"m must satisfy 0 <= m <= 1, got {m} (m = k*k for a modulus k <= 1)")
    arguments = np.asarray(z, dtype=float)
    phase = np.zeros((4, arguments.size))
    phase[0] = arguments.ravel()
    with _CONTEXT.workprec(1200):  # 1 - m is exact
        exact = _CONTEXT.mpf(m)
        program = jacobi_program(exact, 1 - exact, tuple(index == other for other in range(5)))
    return program(phase)[index, 0].reshape(arguments.shape)


jacobi_sn, jacobi_cn, jacobi_dn, jacobi_zeta, jacobi_theta = (partial(_jacobi, i) for i in range(5))


def jacobi_epsilon(z: ArrayLike, m: float) -> Array:
    """Return epsilon(z | m) = Z(z | m) + z E/K."""
    slope = float(_CONTEXT.ellipe(m) / _CONTEXT.ellipk(m)) if m < 1 else 0.0
    return jacobi_zeta(z, m) + slope * np.asarray(z)


def jacobi_eta(z: ArrayLike, m: float) -> Array:
    """Return H(z | m) = m^(1/4) sn Theta."""
    return np.sqrt(np.sqrt(m)) * jacobi_sn(z, m) * jacobi_theta(z, m)

"""The Jacobi functions of (z, m) for NumPy, under their SymPy names, as `lambdify` finds them.

They take m alone, and 1 - m loses digits near m = 1: what must be exact there takes an
`EllipticParameter` (`solutions.special.extended`).

>>> jacobi_sn([0.0, 1.0], 0.25).tolist()
[0.0, 0.8226355781298...]
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from solutions.special.arrays import Array
from solutions.special.extended import JacobiPairs, evaluate_pairs
from solutions.special.parameter import elliptic_parameter


def _values(z: ArrayLike, m: float) -> JacobiPairs:
    """sn, cn, dn, epsilon and zeta at z, and Theta where it exists."""
    return evaluate_pairs(elliptic_parameter(m, 1 - m), z, theta=m < 1)


def jacobi_sn(z: ArrayLike, m: float) -> Array:
    """Return sn(z | m)."""
    return _values(z, m).sn[0]


def jacobi_cn(z: ArrayLike, m: float) -> Array:
    """Return cn(z | m)."""
    return _values(z, m).cn[0]


def jacobi_dn(z: ArrayLike, m: float) -> Array:
    """Return dn(z | m)."""
    return _values(z, m).dn[0]


def jacobi_epsilon(z: ArrayLike, m: float) -> Array:
    """Return epsilon(z | m)."""
    return _values(z, m).epsilon[0]


def jacobi_zeta(z: ArrayLike, m: float) -> Array:
    """Return Z(z | m)."""
    return _values(z, m).zeta[0]


def jacobi_theta(z: ArrayLike, m: float) -> Array:
    """Return Theta(z | m) = theta_4(pi z / (2K), q).

    Raises:
        ValueError: at m = 1, where the nome is 1.
    """
    theta = evaluate_pairs(elliptic_parameter(m, 1 - m), z, theta=True).theta
    assert theta is not None
    return theta[0]


def jacobi_eta(z: ArrayLike, m: float) -> Array:
    """Return H(z | m) = m^(1/4) sn Theta.

    Raises:
        ValueError: at m = 1, where the nome is 1.
    """
    return np.sqrt(np.sqrt(m)) * jacobi_sn(z, m) * jacobi_theta(z, m)


def numpy_module() -> dict[str, Callable[..., Any]]:
    """Return the functions of (z, m) or m under their SymPy names, for `lambdify`.

    >>> from sympy import elliptic_e, lambdify, symbols
    >>> k = symbols("k")
    >>> f = lambdify(k, elliptic_e(k**2), [numpy_module(), "numpy"])
    >>> round(f(0.5), 12)
    1.467462209339
    """
    functions = (
        jacobi_sn,
        jacobi_cn,
        jacobi_dn,
        jacobi_epsilon,
        jacobi_zeta,
        jacobi_eta,
        jacobi_theta,
    )
    integrals = {
        "elliptic_k": lambda m: elliptic_parameter(m, 1 - m).K[0],
        "elliptic_e": lambda m: elliptic_parameter(m, 1 - m).E[0],
    }
    return {f.__name__: f for f in functions} | integrals

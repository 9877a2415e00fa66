"""A closed form as a plain NumPy function, and the Jacobi functions as `lambdify` finds them.

The functions take (z, m), m alone, and 1 - m loses digits near m = 1: what must be exact there
takes an `EllipticParameter` (`solutions.run.jacobi_pairs`).

>>> jacobi_sn([0.0, 1.0], 0.25).tolist()
[0.0, 0.8226355781298...]
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from solutions.compile.straight_line import StraightLine
from solutions.record import ClosedForm
from solutions.run.doubledouble import Array
from solutions.run.elliptic_parameter import elliptic_parameter
from solutions.run.jacobi_pairs import JacobiPairs, evaluate_pairs
from solutions.symbols import tau, xi


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


__all__ = ["numpy_function"]


@lru_cache(maxsize=64)
def numpy_function(form: ClosedForm) -> Callable[..., Any]:
    """``f(xi, tau, *parameters) -> (U, U_xi, U_tau)`` in NumPy, by `lambdify` of the stable form.

    Derivatives are SymPy's; common subexpressions are shared. The arguments are doubles as they
    come: a `Wave` forms its phases from (site, time, eps) in double-double and keeps its digits
    at large arguments and near k = 1, where this function does not.

    >>> from solutions import closed_form
    >>> U, U_xi, U_tau = numpy_function(closed_form("soliton_sech"))(0.0, 0.0, 2.0)
    >>> float(U), float(U_xi) == 0.0
    (2.0, True)
    """
    program = StraightLine()
    value = program.record(form.stable)
    outputs = [value, program.derivative(value, xi), program.derivative(value, tau)]
    arguments = [xi, tau, *(parameter.symbol for parameter in form.parameters)]
    modules = [numpy_module(), "numpy"]
    return sp.lambdify(arguments, outputs, modules, cse=lambda values: (program.lines, values))

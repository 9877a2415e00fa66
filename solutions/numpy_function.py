"""A closed form as a plain NumPy function, and the Jacobi functions as `lambdify` finds them.

The functions take (z, m), m alone, and their arguments are doubles: phases that are large or near
k = 1 are a `Wave`'s matter.

>>> jacobi_sn([0.0, 1.0], 0.25).tolist()
[0.0, 0.8226355781298...]
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from longwave.solutions.compile.tape import Tape
from longwave.solutions.record import ClosedForm
from longwave.solutions.run.doubledouble import Array
from longwave.solutions.run.program import jacobi_program

_CONTEXT = mpmath.MPContext()


def _jacobi(place: int, z: ArrayLike, m: float) -> Array:
    """sn, cn, dn, zeta or Theta (``place`` 0 to 4) at z.

    Raises ValueError for m outside [0, 1], and for Theta at m = 1, where the nome is 1.
    """
    if not 0 <= m <= 1:
        raise ValueError(f"m must satisfy 0 <= m <= 1, got {m} (m = k*k for a modulus k <= 1)")
    arguments = np.asarray(z, dtype=float)
    phase = np.zeros((4, arguments.size))
    phase[0] = arguments.ravel()
    with _CONTEXT.workprec(1200):  # 1 - m is exact
        exact = _CONTEXT.mpf(m)
        program = jacobi_program(exact, 1 - exact, tuple(place == other for other in range(5)))
    return program(phase)[place, 0].reshape(arguments.shape)


jacobi_sn, jacobi_cn, jacobi_dn, jacobi_zeta, jacobi_theta = (
    partial(_jacobi, place) for place in range(5)
)


def jacobi_epsilon(z: ArrayLike, m: float) -> Array:
    """Return epsilon(z | m) = Z(z | m) + z E/K."""
    slope = float(_CONTEXT.ellipe(m) / _CONTEXT.ellipk(m)) if m < 1 else 0.0
    return jacobi_zeta(z, m) + slope * np.asarray(z)


def jacobi_eta(z: ArrayLike, m: float) -> Array:
    """Return H(z | m) = m^(1/4) sn Theta."""
    return np.sqrt(np.sqrt(m)) * jacobi_sn(z, m) * jacobi_theta(z, m)


def numpy_module() -> dict[str, Callable[..., Any]]:
    """Return the functions of (z, m) or m under their SymPy names, for `lambdify`.

    >>> from sympy import elliptic_e, lambdify, symbols
    >>> k = symbols("k")
    >>> f = lambdify(k, elliptic_e(k**2), [numpy_module(), "numpy"])
    >>> round(f(0.5), 12)
    1.467462209339
    """
    return {
        "jacobi_sn": jacobi_sn,
        "jacobi_cn": jacobi_cn,
        "jacobi_dn": jacobi_dn,
        "jacobi_epsilon": jacobi_epsilon,
        "jacobi_zeta": jacobi_zeta,
        "jacobi_eta": jacobi_eta,
        "jacobi_theta": jacobi_theta,
        "elliptic_k": lambda m: float(_CONTEXT.ellipk(m)),
        "elliptic_e": lambda m: float(_CONTEXT.ellipe(m)),
    }


@lru_cache(maxsize=64)
def numpy_function(form: ClosedForm) -> Callable[..., Any]:
    """``f(xi, tau, *parameters) -> (U, U_xi, U_tau)`` in NumPy, by `lambdify` of the stable form.

    For KP it is ``f(xi, zeta, tau, *parameters) -> (U, U_xi, U_zeta, U_tau)``; a form that holds
    for either sign takes the sign s before the parameters.

    Derivatives are SymPy's; common subexpressions are shared. The arguments are doubles as they
    come: a `Wave` forms its phases from (site, time, eps) in double-double and keeps its digits
    at large arguments and near k = 1, where this function does not.

    >>> from longwave.solutions import closed_form
    >>> U, U_xi, U_tau = numpy_function(closed_form("soliton_sech"))(0.0, 0.0, 2.0)
    >>> float(U), float(U_xi) == 0.0
    (2.0, True)
    """
    program = Tape()
    value = program.record(form.stable)
    equation = form.equation
    outputs = [value, *(program.derivative(value, variable) for variable in equation.variables)]
    parameters = (parameter.symbol for parameter in form.parameters)
    arguments = [*equation.variables, *equation.free_sign, *parameters]
    modules = [numpy_module(), "numpy"]
    return sp.lambdify(arguments, outputs, modules, cse=lambda values: (program.lines, values))

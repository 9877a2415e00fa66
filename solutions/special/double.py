"""The Jacobi functions of (u, m) on NumPy arrays in double precision, for real u and 0 <= m <= 1.

The parameter comes as the pair m = k^2, m1 = (1 - k)(1 + k), because 1 - m loses digits near
m = 1; the argument may carry a low part, so that u + u_lo is a double-double phase.  Arguments
are reduced by K in double-double: 10^6 periods cost no digit that u + u_lo had.  Errors against
50 digits: below 6e-16 for sn, cn, dn and zeta (relative for cn and dn, at their zeros too where
u_lo is given), below 6e-16 max(1, |value|) for epsilon, below 1e-15 relative for H and Theta.

>>> sn, cn, dn, epsilon = jacobi([0.0, 1.0], 0.25, 0.75)
>>> sn.tolist()
[0.0, 0.8226355781298...]
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from solutions.special.arrays import Array, flat_pair
from solutions.special.kernels import elliptic_loop, series_constants, theta_loop
from solutions.special.parameter import EllipticParameter, elliptic_parameter


class JacobiValues(NamedTuple):
    """sn, cn, dn, epsilon and zeta at the same points, arrays of one shape.

    epsilon = u E / K + zeta; `EllipticParameter.slope` is E / K in double-double.
    """

    sn: Array
    cn: Array
    dn: Array
    epsilon: Array
    zeta: Array


class ThetaValues(NamedTuple):
    """H and Theta at the same points, arrays of one shape."""

    eta: Array
    theta: Array


Loop = Callable[[Array, Array, bool, Any, Array], None]


def _run(loop: Loop, rows: int, p: EllipticParameter, u: ArrayLike, u_lo: ArrayLike) -> Array:
    """Return the rows that `loop` fills, each of the broadcast shape of u and u_lo."""
    high, low, shape = flat_pair(u, u_lo)
    out = np.empty((rows, high.size))
    loop(high, low, p.circular, series_constants(p), out)
    return out.reshape(rows, *shape)


def evaluate(parameter: EllipticParameter, u: ArrayLike, u_lo: ArrayLike = 0.0) -> JacobiValues:
    """Return sn, cn, dn, epsilon and zeta at u + u_lo.

    Args:
        parameter: from `elliptic_parameter(m, m1)` or `parameter_of_modulus(k)`.
        u, u_lo: real arguments, broadcast together; u_lo is the low part of the sum.

    Returns:
        Arrays of the broadcast shape; NaN where u is not finite.
    """
    return JacobiValues(*_run(elliptic_loop, 5, parameter, u, u_lo))


def evaluate_thetas(
    parameter: EllipticParameter, u: ArrayLike, u_lo: ArrayLike = 0.0
) -> ThetaValues:
    """Return H and Theta at u + u_lo, not normalised: theta_1 and theta_4 of (pi u / (2K), q).

    Raises:
        ValueError: at m = 1, where the nome is 1.
    """
    if parameter.m1[0] == 0:
        raise ValueError("m1 must satisfy m1 > 0, got 0 (H and Theta have no limit as m -> 1)")
    return ThetaValues(*_run(theta_loop, 2, parameter, u, u_lo))


def jacobi(
    u: ArrayLike, m: float, m1: float, u_lo: ArrayLike = 0.0
) -> tuple[Array, Array, Array, Array]:
    """Return (sn, cn, dn, epsilon) at u + u_lo, for the scalar parameter m = 1 - m1.

    Raises:
        ValueError: unless 0 <= m <= 1 and m + m1 = 1 to rounding.
    """
    return evaluate(elliptic_parameter(m, m1), u, u_lo)[:4]


def zeta(u: ArrayLike, m: float, m1: float, u_lo: ArrayLike = 0.0) -> Array:
    """Return Jacobi's zeta, epsilon(u) - u E / K, of period 2K."""
    return evaluate(elliptic_parameter(m, m1), u, u_lo).zeta


def theta(u: ArrayLike, m: float, m1: float, u_lo: ArrayLike = 0.0) -> Array:
    """Return Jacobi's Theta(u) = theta_4(pi u / (2K), q)."""
    return evaluate_thetas(elliptic_parameter(m, m1), u, u_lo).theta


def eta(u: ArrayLike, m: float, m1: float, u_lo: ArrayLike = 0.0) -> Array:
    """Return Jacobi's H(u) = theta_1(pi u / (2K), q)."""
    return evaluate_thetas(elliptic_parameter(m, m1), u, u_lo).eta


def complete_k(m: float, m1: float) -> float:
    """Return the complete elliptic integral K; inf at m = 1."""
    return elliptic_parameter(m, m1).K[0]


def complete_e(m: float, m1: float) -> float:
    """Return the complete elliptic integral E."""
    return elliptic_parameter(m, m1).E[0]


def jacobi_sn(z: ArrayLike, m: float) -> Array:
    """Return sn(z | m), as SymPy's NumPy printer calls it; m1 is taken as 1 - m."""
    return evaluate(elliptic_parameter(m, 1 - m), z).sn


def jacobi_cn(z: ArrayLike, m: float) -> Array:
    """Return cn(z | m), as SymPy's NumPy printer calls it; m1 is taken as 1 - m."""
    return evaluate(elliptic_parameter(m, 1 - m), z).cn


def jacobi_dn(z: ArrayLike, m: float) -> Array:
    """Return dn(z | m), as SymPy's NumPy printer calls it; m1 is taken as 1 - m."""
    return evaluate(elliptic_parameter(m, 1 - m), z).dn


def jacobi_epsilon(z: ArrayLike, m: float) -> Array:
    """Return epsilon(z | m), as SymPy's NumPy printer calls it; m1 is taken as 1 - m."""
    return evaluate(elliptic_parameter(m, 1 - m), z).epsilon


def jacobi_zeta(z: ArrayLike, m: float) -> Array:
    """Return Z(z | m), as SymPy's NumPy printer calls it; m1 is taken as 1 - m."""
    return evaluate(elliptic_parameter(m, 1 - m), z).zeta


def jacobi_theta(z: ArrayLike, m: float) -> Array:
    """Return Theta(z | m), as SymPy's NumPy printer calls it; m1 is taken as 1 - m."""
    return evaluate_thetas(elliptic_parameter(m, 1 - m), z).theta


def jacobi_eta(z: ArrayLike, m: float) -> Array:
    """Return H(z | m), as SymPy's NumPy printer calls it; m1 is taken as 1 - m."""
    return evaluate_thetas(elliptic_parameter(m, 1 - m), z).eta


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
        "elliptic_k": lambda m: complete_k(m, 1 - m),
        "elliptic_e": lambda m: complete_e(m, 1 - m),
    }
    return {f.__name__: f for f in functions} | integrals

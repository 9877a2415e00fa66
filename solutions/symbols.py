"""Symbols of the closed forms.

``xi = a X``, ``tau = b T`` and, for plane lattices, ``zeta = e Z`` are the normal form's variables
(``derive.NormalForm``); ``s`` is its sign in a form that solves the equation with either.
``k`` is the elliptic modulus; the special functions take the parameter ``m = k**2``.
``alpha`` sets the dark breather's eigenvalue, ``X_0`` its centre (in units of ``xi``).
``A`` is the amplitude of a soliton or kink, ``kappa`` the inverse width of a soliton on a constant.
"""

import sympy as sp

xi, tau, zeta, s, X_0 = sp.symbols("xi tau zeta s X_0", real=True)
k, alpha, A, kappa = sp.symbols("k alpha A kappa", positive=True)

complementary_modulus: sp.Expr = sp.sqrt(1 - k**2)


def shift_symbol(index: int) -> sp.Symbol:
    """Return the free parameter ``tau_index`` of a rational solution (``index`` odd, at least 5).

    >>> shift_symbol(5)
    tau_5
    """
    return sp.Symbol(f"tau_{index}", real=True)

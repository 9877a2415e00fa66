"""The elliptic modulus as a parameter."""

import sympy as sp

from solutions.parameter import Bound, Parameter
from solutions.symbols import k

__all__ = ["modulus"]


def modulus(at_zero: str, at_one: str) -> Parameter:
    """``0 < k < 1`` with the limits at both ends in words."""
    return Parameter(k, lower=Bound(sp.S.Zero, at_zero), upper=Bound(sp.S.One, at_one))

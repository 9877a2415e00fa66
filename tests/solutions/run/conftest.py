"""Reference values of the Jacobi functions at 50 digits, computed once for all test files."""

from collections.abc import Callable
from functools import cache

import pytest
from mpmath import MPContext

from longwave.solutions.functions import multiprecision as mp

Reference = Callable[[float, float, float], tuple[object, ...]]


@pytest.fixture(scope="session")
def reference() -> Reference:
    """Return (sn, cn, dn, zeta) at u + u_lo for the modulus k, as 50-digit numbers."""
    ctx = MPContext()
    ctx.dps = 50

    @cache
    def values(k: float, u: float, u_lo: float) -> tuple[object, ...]:
        argument, m = ctx.mpf(u) + ctx.mpf(u_lo), ctx.mpf(k) ** 2
        functions = (mp.sn, mp.cn, mp.dn, mp.zeta)
        return tuple(f(ctx, argument, m) for f in functions)

    return values

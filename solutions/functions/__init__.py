"""Special functions SymPy lacks, as SymPy functions of (z, m) with m = k**2.

Their values: `solutions.functions.multiprecision` (any precision), `solutions.run.program`
(NumPy arrays, about 30 digits) and `solutions.numpy_function` (NumPy, as `lambdify` finds them).
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from longwave.solutions.functions.jacobi import (
        jacobi_cn,
        jacobi_dn,
        jacobi_epsilon,
        jacobi_eta,
        jacobi_sn,
        jacobi_theta,
        jacobi_zeta,
    )

__all__ = [
    "jacobi_cn",
    "jacobi_dn",
    "jacobi_epsilon",
    "jacobi_eta",
    "jacobi_sn",
    "jacobi_theta",
    "jacobi_zeta",
]

__getattr__, __dir__ = lazy_exports(
    __name__, {"longwave.solutions.functions.jacobi": " ".join(__all__)}
)

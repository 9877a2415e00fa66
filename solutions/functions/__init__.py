"""Special functions that SymPy lacks, as SymPy functions of (z, m) with m = k**2.

They are evaluated in `solutions.functions.multiprecision` (any precision), `solutions.run.program`
(NumPy arrays, about 30 digits) and `solutions.functions.numpy_values` (for `lambdify`).
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import declared_exports

if TYPE_CHECKING:
    from longwave.solutions.functions.jacobi import jacobi_cn as jacobi_cn
    from longwave.solutions.functions.jacobi import jacobi_dn as jacobi_dn
    from longwave.solutions.functions.jacobi import jacobi_epsilon as jacobi_epsilon
    from longwave.solutions.functions.jacobi import jacobi_eta as jacobi_eta
    from longwave.solutions.functions.jacobi import jacobi_sn as jacobi_sn
    from longwave.solutions.functions.jacobi import jacobi_theta as jacobi_theta
    from longwave.solutions.functions.jacobi import jacobi_zeta as jacobi_zeta

__getattr__, __dir__, __all__ = declared_exports(__name__)

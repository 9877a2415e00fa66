"""Special functions SymPy lacks, and their evaluation.

Exported here: the SymPy functions of (z, m) with m = k**2.  Beside them: `solutions.special.mp`
(any precision), `solutions.special.extended` (NumPy arrays, about 30 digits) and
`solutions.special.numpy_functions` (NumPy arrays, as `lambdify` finds them).
"""

from solutions.special.elliptic import jacobi_cn, jacobi_dn, jacobi_epsilon, jacobi_sn
from solutions.special.thetas import jacobi_eta, jacobi_theta, jacobi_zeta

__all__ = [
    "jacobi_cn",
    "jacobi_dn",
    "jacobi_epsilon",
    "jacobi_eta",
    "jacobi_sn",
    "jacobi_theta",
    "jacobi_zeta",
]

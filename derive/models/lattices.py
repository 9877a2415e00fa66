"""The catalogue of lattices: adding one is one entry here, a line in ``LATTICES``."""

from sympy import Integer

from derive.lattice import Bond, Lattice, Stencil
from derive.symbols import K2, K3, K4, x

FPUT_STRAIN = Lattice(
    name="fput_strain",
    title="FPUT lattice in the strain y_n = u_{n+1} - u_n",
    fields=("y",),
    masses=(Integer(1),),
    bonds=(
        Bond(
            stretch=(Stencil((0,)),),
            force=K2 * x + K3 * x**2 + K4 * x**3,
            action=(Stencil((1,)), Stencil((0,), -2), Stencil((-1,))),
        ),
    ),
)
"""The lattice of the paper's eqs. (2) and (3), in the strain: the paper's eq. (4)."""

LATTICES: dict[str, Lattice] = {lattice.name: lattice for lattice in (FPUT_STRAIN,)}

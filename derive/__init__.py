"""Derive the long-wave equation of a lattice by expansion in a small parameter.

>>> from derive import LATTICES, Scaling, reduce
>>> reduction = reduce(LATTICES["fput_strain"], Scaling())
>>> print(reduction.pde.text())
Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0
>>> print(reduction.conditions[0].text())
K3 = 0: order eps^4 reads K3 (Y^2)_XX = 0
"""

from typing import TYPE_CHECKING

from derive.lazy_face import lazy_face

if TYPE_CHECKING:
    from derive.dispersion import Dispersion, dispersion_relation
    from derive.equations import Coefficients, Condition, EvolutionEquation, OrderEquation
    from derive.lattice import Bond, Lattice, Stencil
    from derive.models.lattices import LATTICES
    from derive.models.mkdv import (
        initial_velocity,
        initial_velocity_latex,
        mkdv_normal_form,
        mkdv_reduction,
    )
    from derive.multiscale import ReductionError, reduce
    from derive.normal_form import NormalForm
    from derive.reduction import Reduction
    from derive.scaling import Scaling, SlowVariable

__all__ = [
    "LATTICES",
    "Bond",
    "Coefficients",
    "Condition",
    "Dispersion",
    "EvolutionEquation",
    "Lattice",
    "NormalForm",
    "OrderEquation",
    "Reduction",
    "ReductionError",
    "Scaling",
    "SlowVariable",
    "Stencil",
    "dispersion_relation",
    "initial_velocity",
    "initial_velocity_latex",
    "mkdv_normal_form",
    "mkdv_reduction",
    "reduce",
]

__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "derive.dispersion": "Dispersion dispersion_relation",
        "derive.equations": "Coefficients Condition EvolutionEquation OrderEquation",
        "derive.lattice": "Bond Lattice Stencil",
        "derive.models.lattices": "LATTICES",
        "derive.models.mkdv": "initial_velocity initial_velocity_latex mkdv_normal_form "
        "mkdv_reduction",
        "derive.multiscale": "ReductionError reduce",
        "derive.normal_form": "NormalForm",
        "derive.reduction": "Reduction",
        "derive.scaling": "Scaling SlowVariable",
    },
)

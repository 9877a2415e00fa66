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
    from derive.balances import find_scaling
    from derive.carrier import EnvelopeError
    from derive.carrier_envelope import Envelope, EnvelopeNumbers, envelope, modulation_map
    from derive.carrier_numbers import CarrierFields, CarrierTerm, CarrierTerms, carrier_fields
    from derive.checks import Check, checks_of_envelope, checks_of_reduction
    from derive.dispersion import Dispersion, dispersion_relation
    from derive.equations import Coefficients, Condition, EvolutionEquation, OrderEquation
    from derive.lattice import Bond, Lattice, Stencil, on_site, spring
    from derive.lattice_file import lattice_of, read_lattice
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
    "CarrierFields",
    "CarrierTerm",
    "CarrierTerms",
    "Check",
    "Coefficients",
    "Condition",
    "Dispersion",
    "Envelope",
    "EnvelopeError",
    "EnvelopeNumbers",
    "EvolutionEquation",
    "Lattice",
    "NormalForm",
    "OrderEquation",
    "Reduction",
    "ReductionError",
    "Scaling",
    "SlowVariable",
    "Stencil",
    "carrier_fields",
    "checks_of_envelope",
    "checks_of_reduction",
    "dispersion_relation",
    "envelope",
    "find_scaling",
    "initial_velocity",
    "initial_velocity_latex",
    "lattice_of",
    "mkdv_normal_form",
    "mkdv_reduction",
    "modulation_map",
    "on_site",
    "read_lattice",
    "reduce",
    "spring",
]

__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "derive.balances": "find_scaling",
        "derive.carrier": "EnvelopeError",
        "derive.checks": "Check checks_of_envelope checks_of_reduction",
        "derive.dispersion": "Dispersion dispersion_relation",
        "derive.carrier_envelope": "Envelope EnvelopeNumbers envelope modulation_map",
        "derive.carrier_numbers": "CarrierFields CarrierTerm CarrierTerms carrier_fields",
        "derive.equations": "Coefficients Condition EvolutionEquation OrderEquation",
        "derive.lattice": "Bond Lattice Stencil on_site spring",
        "derive.lattice_file": "lattice_of read_lattice",
        "derive.models.lattices": "LATTICES",
        "derive.models.mkdv": "initial_velocity initial_velocity_latex mkdv_normal_form "
        "mkdv_reduction",
        "derive.multiscale": "ReductionError reduce",
        "derive.normal_form": "NormalForm",
        "derive.reduction": "Reduction",
        "derive.scaling": "Scaling SlowVariable",
    },
)

"""Derive the long-wave equation of a lattice by expansion in a small parameter.

>>> from longwave.derive import LATTICES, Scaling, reduce
>>> reduction = reduce(LATTICES["fput_strain"], Scaling())
>>> print(reduction.pde.text())
Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0
>>> print(reduction.conditions[0].text())
K3 = 0: order eps^4 reads K3 (Y^2)_XX = 0
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from longwave.derive.balances import find_scaling
    from longwave.derive.carrier import EnvelopeError
    from longwave.derive.carrier_envelope import Envelope, EnvelopeNumbers, envelope, modulation_map
    from longwave.derive.carrier_numbers import (
        CarrierFields,
        CarrierTerm,
        CarrierTerms,
        carrier_fields,
    )
    from longwave.derive.checks import Check, checks_of_envelope, checks_of_reduction
    from longwave.derive.dispersion import Dispersion, dispersion_relation
    from longwave.derive.equations import Coefficients, Condition, EvolutionEquation, OrderEquation
    from longwave.derive.lattice import Bond, Lattice, Stencil, on_site, spring
    from longwave.derive.lattice_file import lattice_of, read_lattice
    from longwave.derive.models.lattices import LATTICES
    from longwave.derive.models.mkdv import (
        initial_velocity,
        initial_velocity_latex,
        mkdv_normal_form,
        mkdv_reduction,
    )
    from longwave.derive.multiscale import ReductionError, reduce
    from longwave.derive.normal_form import NormalForm
    from longwave.derive.reduction import Reduction
    from longwave.derive.scaling import Scaling, SlowVariable

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

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "longwave.derive.balances": "find_scaling",
        "longwave.derive.carrier": "EnvelopeError",
        "longwave.derive.checks": "Check checks_of_envelope checks_of_reduction",
        "longwave.derive.dispersion": "Dispersion dispersion_relation",
        "longwave.derive.carrier_envelope": "Envelope EnvelopeNumbers envelope modulation_map",
        "longwave.derive.carrier_numbers": "CarrierFields CarrierTerm CarrierTerms carrier_fields",
        "longwave.derive.equations": "Coefficients Condition EvolutionEquation OrderEquation",
        "longwave.derive.lattice": "Bond Lattice Stencil on_site spring",
        "longwave.derive.lattice_file": "lattice_of read_lattice",
        "longwave.derive.models.lattices": "LATTICES",
        "longwave.derive.models.mkdv": "initial_velocity initial_velocity_latex mkdv_normal_form "
        "mkdv_reduction",
        "longwave.derive.multiscale": "ReductionError reduce",
        "longwave.derive.normal_form": "NormalForm",
        "longwave.derive.reduction": "Reduction",
        "longwave.derive.scaling": "Scaling SlowVariable",
    },
)

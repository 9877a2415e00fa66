"""Derive the long-wave equation of a lattice by expansion in a small parameter.

>>> from longwave.derive import LATTICES, Scaling, reduce
>>> reduction = reduce(LATTICES["fput_strain"], Scaling())
>>> print(reduction.pde.text())
Y_T + (3 K4/(2 c)) Y^2 Y_X + (c/24) Y_XXX = 0
>>> print(reduction.conditions[0].text())
K3 = 0: order eps^4 reads K3 (Y^2)_XX = 0
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import declared_exports

if TYPE_CHECKING:
    from longwave.derive.balances import find_scaling as find_scaling
    from longwave.derive.carrier import EnvelopeError as EnvelopeError
    from longwave.derive.carrier_envelope import Envelope as Envelope
    from longwave.derive.carrier_envelope import EnvelopeNumbers as EnvelopeNumbers
    from longwave.derive.carrier_envelope import envelope as envelope
    from longwave.derive.carrier_envelope import modulation_map as modulation_map
    from longwave.derive.carrier_numbers import CarrierFields as CarrierFields
    from longwave.derive.carrier_numbers import CarrierTerm as CarrierTerm
    from longwave.derive.carrier_numbers import CarrierTerms as CarrierTerms
    from longwave.derive.carrier_numbers import carrier_fields as carrier_fields
    from longwave.derive.checks import Check as Check
    from longwave.derive.checks import checks_of_envelope as checks_of_envelope
    from longwave.derive.checks import checks_of_reduction as checks_of_reduction
    from longwave.derive.dispersion import Dispersion as Dispersion
    from longwave.derive.dispersion import dispersion_relation as dispersion_relation
    from longwave.derive.equations import Coefficients as Coefficients
    from longwave.derive.equations import Condition as Condition
    from longwave.derive.equations import EvolutionEquation as EvolutionEquation
    from longwave.derive.equations import OrderEquation as OrderEquation
    from longwave.derive.lattice import Bond as Bond
    from longwave.derive.lattice import Lattice as Lattice
    from longwave.derive.lattice import Stencil as Stencil
    from longwave.derive.lattice import on_site as on_site
    from longwave.derive.lattice import spring as spring
    from longwave.derive.lattice_file import lattice_of as lattice_of
    from longwave.derive.lattice_file import read_lattice as read_lattice
    from longwave.derive.models.lattices import LATTICES as LATTICES
    from longwave.derive.models.mkdv import initial_velocity as initial_velocity
    from longwave.derive.models.mkdv import initial_velocity_latex as initial_velocity_latex
    from longwave.derive.models.mkdv import mkdv_normal_form as mkdv_normal_form
    from longwave.derive.models.mkdv import mkdv_reduction as mkdv_reduction
    from longwave.derive.multiscale import ReductionError as ReductionError
    from longwave.derive.multiscale import reduce as reduce
    from longwave.derive.normal_form import NormalForm as NormalForm
    from longwave.derive.reduction import Reduction as Reduction
    from longwave.derive.scaling import Scaling as Scaling
    from longwave.derive.scaling import SlowVariable as SlowVariable

__getattr__, __dir__, __all__ = declared_exports(__name__)

"""Closed-form solutions of the reduced equations, each written once, and their evaluation.

``CATALOGUE`` and ``closed_form(name)`` give the records, ``rational(j)`` the rational solution of
any order; ``Wave`` evaluates a form at numbers. Formulas are in the variables of the normal form
(``solutions.symbols``); the lattice enters only through a ``derive.NormalForm``. Names are
imported on first use: reading the formulas needs no compiler, and double-double arithmetic no
formulas.
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import declared_exports

if TYPE_CHECKING:
    from longwave.solutions.catalogue import CATALOGUE as CATALOGUE
    from longwave.solutions.catalogue import closed_form as closed_form
    from longwave.solutions.data_store import kept_data as kept_data
    from longwave.solutions.equation import DEFOCUSING_MKDV as DEFOCUSING_MKDV
    from longwave.solutions.equation import FOCUSING_MKDV as FOCUSING_MKDV
    from longwave.solutions.equation import Equation as Equation
    from longwave.solutions.forms.rational import rational as rational
    from longwave.solutions.forms.tau_polynomials import rational_tau as rational_tau
    from longwave.solutions.numeric_wave import NumericWave as NumericWave
    from longwave.solutions.numeric_wave import Side as Side
    from longwave.solutions.numeric_wave import WaveValues as WaveValues
    from longwave.solutions.record import Bound as Bound
    from longwave.solutions.record import ClosedForm as ClosedForm
    from longwave.solutions.record import FarFields as FarFields
    from longwave.solutions.record import Parameter as Parameter
    from longwave.solutions.record import Reference as Reference
    from longwave.solutions.wave import Wave as Wave
    from longwave.solutions.wave_store import kept_wave as kept_wave

__getattr__, __dir__, __all__ = declared_exports(__name__)

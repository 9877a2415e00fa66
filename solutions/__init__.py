"""The closed-form solutions of the reduced equation, each once, and their evaluation.

``CATALOGUE`` and ``closed_form(name)`` give the records; ``rational(j)`` those of any order;
``Wave`` puts numbers in. Formulas are in the normal form's variables (``solutions.symbols``);
the lattice enters only through a ``derive.NormalForm``. Each noun is imported when it is first
asked for: reading the formulas needs no compiler, and double-double arithmetic no formulas.
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from longwave.solutions.catalogue import CATALOGUE, closed_form
    from longwave.solutions.data_store import kept_data
    from longwave.solutions.equation import DEFOCUSING_MKDV, FOCUSING_MKDV, Equation
    from longwave.solutions.forms.rational import rational
    from longwave.solutions.forms.tau_polynomials import rational_tau
    from longwave.solutions.numeric_wave import NumericWave, Side, WaveValues
    from longwave.solutions.record import Bound, ClosedForm, FarFields, Parameter, Reference
    from longwave.solutions.wave import Wave
    from longwave.solutions.wave_store import kept_wave

__all__ = [
    "CATALOGUE",
    "DEFOCUSING_MKDV",
    "FOCUSING_MKDV",
    "Bound",
    "ClosedForm",
    "Equation",
    "FarFields",
    "NumericWave",
    "Parameter",
    "Reference",
    "Side",
    "Wave",
    "WaveValues",
    "closed_form",
    "kept_data",
    "kept_wave",
    "rational",
    "rational_tau",
]

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "longwave.solutions.catalogue": "CATALOGUE closed_form",
        "longwave.solutions.equation": "DEFOCUSING_MKDV FOCUSING_MKDV Equation",
        "longwave.solutions.record": "Bound ClosedForm FarFields Parameter Reference",
        "longwave.solutions.forms.rational": "rational",
        "longwave.solutions.forms.tau_polynomials": "rational_tau",
        "longwave.solutions.data_store": "kept_data",
        "longwave.solutions.wave_store": "kept_wave",
        "longwave.solutions.numeric_wave": "NumericWave Side WaveValues",
        "longwave.solutions.wave": "Wave",
    },
)

"""The closed-form solutions of the reduced equation, each once, and their evaluation.

``CATALOGUE`` and ``closed_form(name)`` give the records; ``rational(j)`` those of any order;
``Wave`` puts numbers in. Formulas are in the normal form's variables (``solutions.symbols``);
the lattice enters only through a ``derive.NormalForm``. Each noun is imported when it is first
asked for: reading the formulas needs no compiler, and double-double arithmetic no formulas.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solutions.catalogue import CATALOGUE, closed_form
    from solutions.forms.rational import rational, rational_tau
    from solutions.parameter import Bound, Parameter
    from solutions.record import (
        DEFOCUSING_MKDV,
        FOCUSING_MKDV,
        ClosedForm,
        Equation,
        FarFields,
        Reference,
    )
    from solutions.wave import Side, Wave, WaveValues

__all__ = [
    "CATALOGUE",
    "DEFOCUSING_MKDV",
    "FOCUSING_MKDV",
    "Bound",
    "ClosedForm",
    "Equation",
    "FarFields",
    "Parameter",
    "Reference",
    "Side",
    "Wave",
    "WaveValues",
    "closed_form",
    "rational",
    "rational_tau",
]

_MODULES = {
    "catalogue": ("CATALOGUE", "closed_form"),
    "record": (
        "DEFOCUSING_MKDV",
        "FOCUSING_MKDV",
        "ClosedForm",
        "Equation",
        "FarFields",
        "Reference",
    ),
    "parameter": ("Bound", "Parameter"),
    "forms.rational": ("rational", "rational_tau"),
    "wave": ("Side", "Wave", "WaveValues"),
}
_MODULE_OF = {noun: module for module, nouns in _MODULES.items() for noun in nouns}


def __getattr__(name: str) -> object:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    noun = getattr(import_module(f"solutions.{_MODULE_OF[name]}"), name)
    globals()[name] = noun
    return noun

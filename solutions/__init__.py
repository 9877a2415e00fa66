"""The closed-form solutions of the reduced equation, each once, and their evaluation.

``CATALOGUE`` and ``closed_form(name)`` give the records; ``rational(j)`` those of any order;
``Wave`` puts numbers in. Formulas are in the normal form's variables (``solutions.symbols``);
the lattice enters only through a ``derive.NormalForm``. ``Wave`` is imported at first use, so
that reading the formulas needs no compiler.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from solutions.catalogue import CATALOGUE, closed_form
from solutions.closed_form import ClosedForm, FarFields, Reference
from solutions.equation import DEFOCUSING_MKDV, FOCUSING_MKDV, Equation
from solutions.parameter import Bound, Parameter
from solutions.rational import rational, rational_tau

if TYPE_CHECKING:
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

_EVALUATION = ("Side", "Wave", "WaveValues")


def __getattr__(name: str) -> object:
    if name in _EVALUATION:
        return getattr(import_module("solutions.wave"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

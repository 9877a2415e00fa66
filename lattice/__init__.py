"""The lattice with numbers: no symbols, no waves, no files.

``integrate(model, state, times, tolerance)`` is the room's face. Each noun is imported when it is
first asked for: a model needs no compiler.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lattice.integration import Cost, Trajectory, integrate
    from lattice.model import Model
    from lattice.schemes.catalogue import SCHEMES, scheme_named
    from lattice.schemes.order import check_order
    from lattice.schemes.scheme import Composition, RungeKutta, Scheme, Splitting, stability_limit
    from lattice.state import State, ring_energy

__all__ = [
    "SCHEMES",
    "Composition",
    "Cost",
    "Model",
    "RungeKutta",
    "Scheme",
    "Splitting",
    "State",
    "Trajectory",
    "check_order",
    "integrate",
    "ring_energy",
    "scheme_named",
    "stability_limit",
]

_MODULES = {
    "integration": ("Cost", "Trajectory", "integrate"),
    "model": ("Model",),
    "schemes.catalogue": ("SCHEMES", "scheme_named"),
    "schemes.order": ("check_order",),
    "schemes.scheme": ("Composition", "RungeKutta", "Scheme", "Splitting", "stability_limit"),
    "state": ("State", "ring_energy"),
}
_MODULE_OF = {noun: module for module, nouns in _MODULES.items() for noun in nouns}


def __getattr__(name: str) -> object:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    noun = getattr(import_module(f"lattice.{_MODULE_OF[name]}"), name)
    globals()[name] = noun
    return noun

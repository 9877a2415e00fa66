"""The lattice with numbers: no symbols, no waves, no files.

``integrate(model, state, times, tolerance)`` is the room's face. Each noun is imported when it is
first asked for: a model needs no compiler.
"""

from typing import TYPE_CHECKING

from derive.lazy_face import lazy_face

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

__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "lattice.integration": "Cost Trajectory integrate",
        "lattice.model": "Model",
        "lattice.schemes.catalogue": "SCHEMES scheme_named",
        "lattice.schemes.order": "check_order",
        "lattice.schemes.scheme": "Composition RungeKutta Scheme Splitting stability_limit",
        "lattice.state": "State ring_energy",
    },
)

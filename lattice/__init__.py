"""Numerical lattices and their time integration: no symbols, no waves, no files.

The entry point is ``integrate(lattice, state, times, tolerance)``. Names are imported on first use,
so that a model needs no compiler.
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from longwave.lattice.driving import DrivenChain, driven_chain
    from longwave.lattice.integration import Cost, Trajectory, integrate
    from longwave.lattice.model import Model
    from longwave.lattice.outer_forces import SiteForce
    from longwave.lattice.schemes import (
        SCHEMES,
        Composition,
        RungeKutta,
        Scheme,
        Splitting,
        check_order,
        scheme_named,
        stability_limit,
    )
    from longwave.lattice.spectral.field_ring import FieldRing
    from longwave.lattice.spectral.spectral_integration import (
        SpectralTrajectory,
        spectral_integrate,
    )
    from longwave.lattice.state import State

__all__ = [
    "SCHEMES",
    "Composition",
    "Cost",
    "DrivenChain",
    "FieldRing",
    "Model",
    "RungeKutta",
    "Scheme",
    "SiteForce",
    "SpectralTrajectory",
    "Splitting",
    "State",
    "Trajectory",
    "check_order",
    "driven_chain",
    "integrate",
    "scheme_named",
    "spectral_integrate",
    "stability_limit",
]

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "longwave.lattice.driving": "DrivenChain driven_chain",
        "longwave.lattice.outer_forces": "SiteForce",
        "longwave.lattice.integration": "Cost Trajectory integrate",
        "longwave.lattice.state": "State",
        "longwave.lattice.model": "Model",
        "longwave.lattice.schemes": "SCHEMES Composition RungeKutta Scheme Splitting "
        "check_order scheme_named stability_limit",
        "longwave.lattice.spectral.field_ring": "FieldRing",
        "longwave.lattice.spectral.spectral_integration": "SpectralTrajectory spectral_integrate",
    },
)

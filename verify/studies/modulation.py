"""Where plane carrier waves of the alpha+beta FPUT lattice are unstable, and how fast they grow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from sympy import Integer, lambdify

from derive import LATTICES, dispersion_relation, envelope
from derive.carrier_envelope import omega
from derive.symbols import K2, K3, k
from verify.processes import Job, Key

Array = NDArray[np.float64]

LARGEST_K3 = 1.5
"""Of the map; K2 = K4 = 1."""

POINTS = 240
"""Along each axis."""


@dataclass(frozen=True)
class ModulationPlane:
    """Over wavenumber (second axis) and K3 (first axis), for K2 = K4 = 1.

    ``product``: p q, positive where the envelope is focusing.  ``growth``: the largest growth rate
    in T of the plane wave |A| = 1, 0 where it is stable.
    """

    wavenumbers: Array
    quadratic: Array
    product: Array
    growth: Array


def modulation_plane(points: int = POINTS) -> ModulationPlane:
    """p q and the growth rate from the derived coefficients, at the middles of ``points`` cells.

    >>> plane = modulation_plane(4)
    >>> bool((plane.growth[plane.product < 0] == 0).all())
    True
    """
    lattice = LATTICES["fput_strain"]
    found = envelope(lattice, K2=1, K4=1)
    frequency = dispersion_relation(lattice).at(Integer(0)).omega_plus.subs(K2, 1)
    middles = (np.arange(points) + 0.5) / points
    wavenumbers, quadratic = np.pi * middles, LARGEST_K3 * middles
    at = np.meshgrid(wavenumbers, quadratic)
    p, q = (
        np.broadcast_to(
            lambdify((k, K3), found.expressions[name].subs(omega, frequency).subs("K4", 1))(*at),
            at[0].shape,
        )
        for name in ("p", "q")
    )
    product = p * q
    return ModulationPlane(wavenumbers, quadratic, product, np.where(product > 0, abs(q), 0.0))


def modulation_jobs() -> dict[Key, Job]:
    """The one plane of the report."""
    return {("modulation", "fput_strain"): Job(modulation_plane, (), 1.0)}

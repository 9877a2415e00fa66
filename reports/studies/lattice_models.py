"""Lattices in the tables of long waves and envelopes: the catalogue, and special cases of it.

A special case is a lattice of the catalogue with constants that are small or tied to each other,
about a mean strain, or with further springs.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from sympy import Expr, Integer, S, Symbol, pi

from longwave.derive import LATTICES, Lattice, Reduction, find_scaling, spring
from longwave.derive.models.lattices import L2, L3, L4, cubic
from longwave.derive.symbols import eps, ybar
from longwave.scenes.modulation import ModulationGrid, modulation_grid
from longwave.solutions import CATALOGUE

C2, D2, SMALL = Symbol("C2", positive=True), Symbol("d2", real=True), Symbol("k3", real=True)


@dataclass(frozen=True)
class LatticeModel:
    """A lattice whose long waves are derived, with constants set to ``values``, about a ``mean``.

    ``case`` describes what is special about it.
    """

    lattice: Lattice
    case: str = ""
    values: tuple[tuple[str, Expr], ...] = ()
    mean: Expr = S.Zero

    def reductions(self) -> tuple[Reduction, ...]:
        """Return the reductions with a normal form and conditions that can be met, if any."""
        try:
            scalings = find_scaling(self.lattice.with_values(dict(self.values)), self.mean)
        except ValueError:
            return ()
        return tuple(r for r in scalings if r.has_normal_form and _can_be_met(r))


def _can_be_met(reduction: Reduction) -> bool:
    """Return whether no condition of the reduction requires a nonzero expression to vanish."""
    defined = dict(reduction.lattice.definitions)
    expressions = (condition.expression.xreplace(defined) for condition in reduction.conditions)
    return not any(expression.is_zero is False for expression in expressions)


def lattice_models() -> Iterator[LatticeModel]:
    """Yield the lattices of the catalogue, then the special cases."""
    for lattice in LATTICES.values():
        yield LatticeModel(lattice)
    chain, next_nearest = LATTICES["fput_strain"], LATTICES["next_nearest"]
    yield LatticeModel(chain, "with a small quadratic force", (("K3", eps * SMALL),))
    yield LatticeModel(chain, "about a mean strain", mean=ybar)
    vanishing = (("K2", (4 * C2 - eps**2 * D2) / 3), ("L2", (eps**2 * D2 - C2) / 12))
    odd = (("K3", Integer(0)), ("L3", Integer(0)))
    yield LatticeModel(next_nearest, "nearly without dispersion", vanishing)
    yield LatticeModel(next_nearest, "nearly without dispersion, odd forces", (*vanishing, *odd))
    further = spring(cubic(L2, L3, L4), ((0, 0), 0), ((2, 0), 0))
    square = LATTICES["square"]
    square = replace(square, bonds=(*square.bonds, further))
    yield LatticeModel(square, "with springs to the next but one along n")


def closed_waves(reduction: Reduction) -> tuple[str, ...]:
    """Return the names of closed forms that solve the reduced equation; its known signs must match.

    >>> from longwave.derive import LATTICES, find_scaling
    >>> closed_waves(find_scaling(LATTICES["toda"])[0])
    ('kdv_soliton', 'kdv_two_soliton', 'kdv_cnoidal')
    """
    normal = reduction.normal_form()
    return tuple(
        form.name
        for form in CATALOGUE.of(normal.equation)
        if all(
            required == actual or not (isinstance(required, int) and S(actual).is_number)
            for required, actual in ((form.equation.s, normal.s), (form.equation.r, normal.r))
        )
    )


ENVELOPES: tuple[tuple[str, Expr | None], ...] = (
    ("fput_strain", None),
    ("toda", None),
    ("granular", None),
    ("next_nearest", pi),
    ("klein_gordon", pi),
    ("mass_dimer", pi),
)
"""(Lattice, carrier wavenumber or None for any) with short NLS coefficients, which are the same on
every branch."""


LARGEST_K3, POINTS = 1.5, 240
"""Largest K3 in the stability map of plane carrier waves, and number of points along each axis."""


def modulation_plane(points: int = POINTS) -> tuple[ModulationGrid, np.ndarray]:
    """Return the modulation grid of the alpha+beta FPUT lattice over (K3, k), and the values of K3.

    >>> grid, quadratic = modulation_plane(4)
    >>> grid.product.shape, quadratic.shape
    ((4, 4), (4, 4))
    """
    middles = (np.arange(points) + 0.5) / points
    k, K3 = np.meshgrid(np.pi * middles, LARGEST_K3 * middles)
    return modulation_grid(LATTICES["fput_strain"], k, K2=1, K3=K3, K4=1), K3

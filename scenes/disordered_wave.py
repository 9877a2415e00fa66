"""A wave of the ordered lattice sent into a disordered one, and what is left of it there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sympy import Expr

from longwave.lattice.disordered_lattice import DisorderedLattice, Variation, disordered, mass_kind
from longwave.lattice.force_program import ForceProgram, force_program
from longwave.lattice.random_sites import mean_inverse
from longwave.scenes.lattice_wave import CellRing, LatticeWave
from longwave.scenes.pulse_meter import PulseMeter
from longwave.scenes.scene_disorder import MASS, Disorder
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.derive.lattice import Lattice
    from longwave.lattice.numeric_lattice import NumericBond, NumericLattice

Array = NDArray[np.float64]


class DisorderedWave(LatticeWave):
    """``wave``, whose lattice is ordered, on rings of the same lattice with ``disorder``.

    Data and theory are the ordered lattice's. ``symbolic`` is its declaration and ``values`` are
    its constants. ``far``: what a long wave tends to on both sides, None of an envelope and of what
    does not end. Only a wave that tends to 0 has a crest, whose largest force is where it is.
    Raises ValueError in one line for a lattice without such a disorder, and for springs that differ
    where a background stretches them.
    """

    def __init__(
        self,
        wave: LatticeWave,
        disorder: Disorder,
        symbolic: Lattice,
        values: Mapping[str, Expr],
        far: float | None = 0.0,
    ) -> None:
        self._has_crest = far == 0.0
        self.disorder, self._wave = disorder, wave
        self.eps, self.order, self.power = wave.eps, wave.order, wave.power
        self.slow, self.speed = wave.slow, wave.speed
        self._ordered = wave.lattice
        self._variation = variation_of(disorder, symbolic, values, wave.lattice)
        self.lattice = self._with_cells(wave.lattice, np.zeros(0))
        self._rest = [
            0.0 if far is None else self._background_stretch(b) for b in self._ordered.bonds
        ]
        if not self._variation.masses and (far or any(self._rest)):
            raise ValueError(
                f"of in [disorder] must be {MASS} with a wave on a background, got "
                f"{disorder.of} (springs that differ would move where they are stretched alike)"
            )

    def _background_stretch(self, bond: NumericBond) -> float:
        uniform = self._wave.uniform()
        if not np.any(uniform):
            return 0.0
        return math.fsum(entry.weight * float(uniform[entry.field]) for entry in bond.stretch)

    def _with_cells(self, lattice: NumericLattice, cells: Array) -> DisorderedLattice:
        rows = range(self._variation.rows(len(lattice.fields)))
        deviations = [self.disorder.deviations(cells, row) for row in rows]
        return disordered(lattice, self._variation, deviations)

    def ring(self, cells: ArrayLike, t: float) -> CellRing:
        """The wave's state, on the cells of the disordered lattice."""
        ring = self._wave.ring(cells, t)
        lattice = self._with_cells(ring.lattice, ring.cells)
        return CellRing(lattice, ring.mean_strain, ring.cells, t, ring.f, ring.v)

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """As of the ordered lattice."""
        return self._wave.state(cells, t)

    def strain(self, cells: ArrayLike, t: float) -> Array:
        """As of the ordered lattice."""
        return self._wave.strain(cells, t)

    @property
    def quantities(self) -> tuple[str, ...]:
        """As of the ordered lattice."""
        return self._wave.quantities

    def measured(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """As of the ordered lattice."""
        return self._wave.measured(f, mean_strain)

    def support(self, t: float) -> tuple[float, float]:
        """As of the ordered lattice."""
        return self._wave.support(t)

    def strained(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """As of the ordered lattice."""
        return self._wave.strained(mean_strain)

    def start(self, t: float) -> None:
        """As of the ordered lattice."""
        self._wave.start(t)

    def background(self, cells: ArrayLike, t: float) -> Array:
        """As of the ordered lattice."""
        return self._wave.background(cells, t)

    def mean_strain(self, cells: Array, t: float) -> tuple[float, ...]:
        """As of the ordered lattice."""
        return self._wave.mean_strain(cells, t)

    def rest_slopes(self, ring: CellRing) -> list[float]:
        """As of the ordered lattice."""
        return self._wave.rest_slopes(ring)

    @property
    def growth_shares(self) -> tuple[float, ...]:
        """As of the ordered lattice."""
        return self._wave.growth_shares

    @property
    def frequency(self) -> float:
        """The carrier's."""
        return self._wave.frequency

    @property
    def effective_speed(self) -> float:
        """The speed of very long waves, in units of the ordered lattice's.

        ``1/sqrt(<m/m_n> <K/K_n>)``, means over the distribution: springs in series and masses add
        up. nan for a lattice with several bonds, whose springs are not all in series.
        """
        if self._variation.masses:
            return 1.0
        if len(self._ordered.bonds) > 1:
            return math.nan
        [part], [bond] = self._variation.forces, self._ordered.bonds
        assert part is not None
        rest = np.array(bond.offset)
        share = abs(float(part.slope(rest) / bond.force.slope(rest)))
        return mean_inverse(self.disorder.distribution, share * self.disorder.spread) ** -0.5

    def meter(self, ring: CellRing) -> PulseMeter | None:
        """What measures the crest on its way."""
        return PulseMeter(ring, self._rest) if self._has_crest else None


def variation_of(
    disorder: Disorder, symbolic: Lattice, values: Mapping[str, Expr], lattice: NumericLattice
) -> Variation:
    """What varies in the lattice under that disorder; ValueError in one line where nothing may."""
    name = disorder.of
    if lattice.dimension != 1:
        raise ValueError(
            f"disorder must be on a chain, got {lattice.name} of {lattice.dimension} axes (leave "
            "[disorder] out)"
        )
    if name == MASS:
        return Variation(disorder.spread, mass_kind(lattice))
    forces = {s for bond in symbolic.bonds for s in bond.force.free_symbols}
    constants = {str(s): s for s in symbolic.constants if s in forces}
    if name not in constants:
        raise ValueError(
            f"of in [disorder] must be mass or a constant of the springs of {lattice.name}, got "
            f"{shown(name)} (one of {', '.join((MASS, *constants))})"
        )
    symbol = constants[name]
    at = {s: values[str(s)] for s in symbolic.constants}
    parts: list[ForceProgram | None] = []
    for bond in symbolic.bonds:
        slope = bond.force.diff(symbol)
        if slope.has(symbol):
            raise ValueError(
                f"of in [disorder] must name a constant that forces are proportional to, got "
                f"{name} of {lattice.name} (take {MASS} or another)"
            )
        part = (symbol * slope).xreplace(at)
        parts.append(force_program(part) if part != 0 else None)
    if not any(parts):
        raise ValueError(
            f"of in [disorder] must name a constant that is not 0, got {name} = 0 (give it a value)"
        )
    return Variation(disorder.spread, None, tuple(parts))

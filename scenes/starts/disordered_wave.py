"""Disordered lattice on which a wave runs, and the meter that measures the wave there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from sympy import Expr

from longwave.lattice.disordered_lattice import DisorderedLattice, disordered, mass_kind
from longwave.lattice.force_program import ForceProgram, force_program
from longwave.lattice.random_sites import mean_inverse
from longwave.lattice.variation import Variation
from longwave.scenes.description.scene_disorder import MASS, Disorder
from longwave.scenes.starts.pulse_meter import PulseMeter
from longwave.support.known_names import one_of
from longwave.support.real_arrays import Array
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.derive.lattice import Lattice
    from longwave.lattice.numeric_lattice import NumericLattice
    from longwave.scenes.starts.initial_cells import InitialCells


class WaveDisorder:
    """Disorder of a wave's ``lattice``; initial data and theory are those of the ordered lattice.

    ``symbolic`` is the lattice's declaration and ``values`` are its constants. ``far`` is the
    constant background of a long wave; None for an envelope or an infinite wave. ``uniform`` is the
    uniform strain of each field. Only a wave that tends to 0 has a crest, which is where the force
    is largest. Raises ValueError for a lattice that does not admit the disorder, and for unequal
    springs that a background stretches.
    """

    def __init__(
        self,
        lattice: NumericLattice,
        disorder: Disorder,
        symbolic: Lattice,
        values: Mapping[str, Expr],
        uniform: Array,
        far: float | None,
    ) -> None:
        self._disorder, self._has_crest = disorder, far == 0.0
        self._bonds = lattice.bonds
        self._variation = variation_of(disorder, symbolic, values, lattice)
        self._rest = [
            math.fsum(entry.weight * float(uniform[entry.field]) for entry in bond.stretch)
            for bond in self._bonds
        ]
        if not self._variation.masses and (far or any(self._rest)):
            raise ValueError(
                f"of in [disorder] must be {MASS} with a wave on a background, got "
                f"{disorder.of} (a uniform stretch would set unequal springs in motion)"
            )

    def on(self, lattice: NumericLattice, cells: Array) -> DisorderedLattice:
        """Return the given ordered lattice with the deviations of these cells."""
        rows = range(self._variation.rows(len(lattice.fields)))
        deviations = [self._disorder.deviations(cells, row) for row in rows]
        return disordered(lattice, self._variation, deviations)

    @property
    def effective_speed(self) -> float:
        """Speed of very long waves, in units of the ordered lattice's speed.

        It is ``1/sqrt(<m_n/m> <K/K_n>)`` with means over the distribution, since masses and the
        compliances of springs in series add up. NaN for a lattice with several bonds, whose springs
        are not all in series.
        """
        if self._variation.masses:
            return 1.0
        if len(self._bonds) > 1:
            return math.nan
        [part], [bond] = self._variation.forces, self._bonds
        assert part is not None
        rest = np.array(bond.offset)
        share = abs(float(part.slope(rest) / bond.force.slope(rest)))
        return mean_inverse(self._disorder.distribution, share * self._disorder.spread) ** -0.5

    def meter(self, ring: InitialCells) -> PulseMeter | None:
        """Return a meter for runs that start on ``ring``; None for a wave without a crest."""
        return PulseMeter(ring, self._rest) if self._has_crest else None


def variation_of(
    disorder: Disorder, symbolic: Lattice, values: Mapping[str, Expr], lattice: NumericLattice
) -> Variation:
    """Return the variation of masses or forces by cell; ValueError for an invalid disorder."""
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
            f"{shown(name)} ({one_of(name, (MASS, *constants))})"
        )
    symbol = constants[name]
    substitutions = {s: values[str(s)] for s in symbolic.constants}
    parts: list[ForceProgram | None] = []
    for bond in symbolic.bonds:
        slope = bond.force.diff(symbol)
        if slope.has(symbol):
            raise ValueError(
                f"of in [disorder] must name a constant that forces are proportional to, got "
                f"{name} of {lattice.name} (take {MASS} or another)"
            )
        part = (symbol * slope).xreplace(substitutions)
        parts.append(force_program(part) if part != 0 else None)
    if not any(parts):
        raise ValueError(
            f"of in [disorder] must name a constant that is not 0, got {name} = 0 (give it a value)"
        )
    return Variation(disorder.spread, None, tuple(parts))

"""Which ansatz fits a lattice: the balances of nonlinearity and dispersion, found by trying."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from sympy import Expr, Integer, S

from longwave.derive.algebra.exact_numbers import instance
from longwave.derive.lattice import Lattice
from longwave.derive.multiscale import ReductionError, reduce
from longwave.derive.reduction import Reduction
from longwave.derive.scaling import Scaling, SlowVariable
from longwave.derive.symbols import c

AMPLITUDES, TIMES = (0, 1, 2, 3, 4), (3, 5)
"""Exponents that are tried."""


def find_scaling(
    lattice: Lattice,
    mean: Expr = S.Zero,
    further: int = 0,
    space: tuple[SlowVariable, ...] = (),
) -> tuple[Reduction, ...]:
    """The reductions of a lattice that balance nonlinearity and dispersion, about a uniform mean.

    Those with the fewest conditions on the constants stand first.  A lattice with two axes has the
    wave along its first one, and a slower variable Z across, unless ``space`` says which.  They are
    derived through ``further`` orders behind the equation.  Raises ReductionError if none fits.

    >>> from longwave.derive import LATTICES
    >>> [(r.pde.kind, r.scaling.amplitude) for r in find_scaling(LATTICES["fput_strain"])]
    [('KdV', 2), ('mKdV', 1)]
    """
    found = _Search(lattice, mean, further, space)
    return tuple(sorted(found.raising(), key=_rank))


def best_balance(
    lattice: Lattice,
    mean: Expr = S.Zero,
    further: int = 0,
    space: tuple[SlowVariable, ...] = (),
) -> Reduction:
    """The first of `find_scaling`; the search ends where no other could stand before it."""
    found: list[Reduction] = []
    for reduction in _Search(lattice, mean, further, space).raising():
        if not reduction.conditions:
            return reduction
        found.append(reduction)
    return min(found, key=_rank)


def _rank(reduction: Reduction) -> tuple[int, int]:
    return len(reduction.conditions), reduction.scaling.time


class _Search:
    """The balanced reductions of a lattice, and why there are no others."""

    def __init__(
        self, lattice: Lattice, mean: Expr, further: int, space: tuple[SlowVariable, ...]
    ) -> None:
        self.lattice = instance("lattice", lattice, Lattice, "LATTICES['fput_strain'] is one")
        self.mean, self.further = mean, further
        self.space = space or (SlowVariable("X", 1, (1, *(0,) * (lattice.dimension - 1)), c),)
        if lattice.dimension > 1 and not space:
            across = (0, 1, *(0,) * (lattice.dimension - 2))
            self.space += (SlowVariable("Z", 2, across, Integer(0)),)

    def raising(self) -> Iterator[Reduction]:
        """The reductions, those in T = eps^3 t first; ReductionError if there is none."""
        background = ((0, self.mean),) if self.mean else ()
        refused, found = "", False
        for time, amplitude in product(TIMES, AMPLITUDES):
            if self.mean and not amplitude:
                continue
            scaling = Scaling(amplitude, self.space, time, background)
            try:
                reduction = reduce(self.lattice, scaling, scaling.leading_order + self.further)
            except ValueError as error:
                refused = refused or str(error)
                continue
            if reduction.is_balanced:
                found = True
                yield reduction
        if not found:
            raise ReductionError(f"no scaling fits {self.lattice.name}: {refused}")

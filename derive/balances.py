"""Which ansatz fits a lattice: the balances of nonlinearity and dispersion, found by trying."""

from __future__ import annotations

from sympy import Expr, Integer, S

from derive.algebra.exact_numbers import instance
from derive.lattice import Lattice
from derive.multiscale import ReductionError, reduce
from derive.reduction import Reduction
from derive.scaling import Scaling, SlowVariable
from derive.symbols import c

AMPLITUDES, TIMES = (0, 1, 2, 3, 4), (3, 5)
"""Exponents that are tried."""


def find_scaling(lattice: Lattice, mean: Expr = S.Zero) -> tuple[Reduction, ...]:
    """The reductions of a lattice that balance nonlinearity and dispersion, about a uniform mean.

    Those with the fewest conditions on the constants stand first.  A lattice with two axes has the
    wave along its first one, and a slower variable Z across.  Raises ReductionError if none fits.

    >>> from derive import LATTICES
    >>> [(r.pde.kind, r.scaling.amplitude) for r in find_scaling(LATTICES["fput_strain"])]
    [('KdV', 2), ('mKdV', 1)]
    """
    instance("lattice", lattice, Lattice, "LATTICES['fput_strain'] is one")
    space = [SlowVariable("X", 1, (1, *(0,) * (lattice.dimension - 1)), c)]
    if lattice.dimension > 1:
        across = (0, 1, *(0,) * (lattice.dimension - 2))
        space.append(SlowVariable("Z", 2, across, Integer(0)))
    background = ((0, mean),) if mean else ()
    found: list[Reduction] = []
    refused: list[str] = []
    for time in TIMES:
        for amplitude in AMPLITUDES:
            if mean and not amplitude:
                continue
            scaling = Scaling(amplitude, tuple(space), time, background)
            try:
                reduction = reduce(lattice, scaling, scaling.leading_order)
            except ValueError as error:
                refused.append(str(error))
                continue
            if reduction.is_balanced:
                found.append(reduction)
    if not found:
        raise ReductionError(f"no scaling fits {lattice.name}: {refused[0] if refused else ''}")
    return tuple(sorted(found, key=lambda r: (len(r.conditions), r.scaling.time)))

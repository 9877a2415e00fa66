"""Search for an ansatz: balances of nonlinearity and dispersion, found by trying exponents."""

from collections.abc import Iterator, Mapping
from itertools import product

from sympy import Expr, Integer, S

from longwave.derive.algebra.exact_numbers import Number, instance
from longwave.derive.algebra.formula_expression import exact_value
from longwave.derive.lattice import Lattice
from longwave.derive.multiscale import ReductionError, reduce
from longwave.derive.reduction import Reduction
from longwave.derive.scaling import Scaling, SlowVariable
from longwave.derive.symbols import c, constant_value, eps

AMPLITUDES, TIMES = (0, 1, 2, 3, 4), (3, 5)
"""Exponents of eps that the search tries for the amplitude and for the slow time."""

LOSSY_TIMES = (*TIMES, 2)
"""Exponents of the slow time tried for a lattice with losses; with dashpots of order 1 it is 2."""


def find_scaling(
    lattice: Lattice,
    background: Number = 0,
    amplitude: int | None = None,
    time: int | None = None,
    *,
    further: int = 0,
    space: tuple[SlowVariable, ...] = (),
    **constants: Number,
) -> tuple[Reduction, ...]:
    """Find the reductions of a lattice that balance nonlinearity and dispersion.

    ``constants`` are substituted first: numbers, or formulas in text, which may contain eps.  The
    wave rides on a uniform ``background``, which may be a formula in the constants.  ``amplitude``
    and ``time``, exponents of eps, restrict the search.

    Reductions with the fewest conditions on the constants come first.  On a lattice with two axes
    the wave travels along the first axis, with a slower transverse variable Z, unless ``space``
    says otherwise.  ``further`` orders beyond the equation are derived.  Raises ReductionError if
    no ansatz fits, ValueError for invalid constants or background.

    >>> from longwave.derive import LATTICES
    >>> [(r.pde.kind, r.scaling.amplitude) for r in find_scaling(LATTICES["fput_strain"])]
    [('KdV', 2), ('mKdV', 1)]
    >>> print(find_scaling(LATTICES["fput_strain"], K2=1, K3="5*eps", K4=1)[0].pde.text())
    Y_T + (3/(2 c)) Y^2 Y_X + (5/c) Y Y_X + (1/(24 c)) Y_XXX = 0
    """
    instance("lattice", lattice, Lattice, "LATTICES['fput_strain'] is one")
    lattice, mean = about_mean(lattice, background, constants)
    reductions = _balanced(lattice, mean, further, space, amplitude, time)
    return tuple(sorted(reductions, key=_rank))


def best_balance(
    lattice: Lattice, mean: Expr, further: int = 0, space: tuple[SlowVariable, ...] = ()
) -> Reduction:
    """Return the first result of `find_scaling`; a result without conditions ends the search."""
    candidates: list[Reduction] = []
    for reduction in _balanced(lattice, mean, further, space):
        if not reduction.conditions:
            return reduction
        candidates.append(reduction)
    return min(candidates, key=_rank)


def about_mean(
    lattice: Lattice, background: Number, constants: Mapping[str, Number]
) -> tuple[Lattice, Expr]:
    """Return the lattice with constants substituted, and the mean of its fields.

    For a single displacement the background is a strain: the lattice is expanded about it, and the
    mean is 0.
    """
    mean = uniform_mean(lattice, background, constants)
    lattice = lattice.with_values(constants)
    if mean and len(lattice.fields) == 1 and lattice.is_displacement:
        return lattice.strained(mean), S.Zero
    return lattice, mean


def uniform_mean(lattice: Lattice, background: Number, constants: Mapping[str, Number]) -> Expr:
    """Return a background, a formula in eps and the lattice's constants, with values substituted.

    >>> from longwave.derive import LATTICES
    >>> uniform_mean(LATTICES["fput_strain"], "-K3/(3*K4)", {"K3": "eps/2"})
    -eps/(6*K4)
    """
    symbols = {str(symbol): symbol for symbol in lattice.constants}
    values = {name: constant_value(name, value) for name, value in constants.items()}
    return exact_value("background", background, {str(eps): eps, **symbols, **values})


def _rank(reduction: Reduction) -> tuple[int, int]:
    return len(reduction.conditions), reduction.scaling.time


def _balanced(
    lattice: Lattice,
    mean: Expr,
    further: int = 0,
    space: tuple[SlowVariable, ...] = (),
    amplitude: int | None = None,
    time: int | None = None,
) -> Iterator[Reduction]:
    """Yield the balanced reductions, T = eps^3 t first. Raises ReductionError if there is none."""
    if not space:
        space = (SlowVariable("X", 1, (1, *(0,) * (lattice.dimension - 1)), c),)
        if lattice.dimension > 1:
            transverse = (0, 1, *(0,) * (lattice.dimension - 2))
            space += (SlowVariable("Z", 2, transverse, Integer(0)),)
    background = ((0, mean),) if mean else ()
    first_refusal, any_balanced = "", False
    usual = LOSSY_TIMES if lattice.has_losses else TIMES
    times = usual if time is None else (time,)
    amplitudes = AMPLITUDES if amplitude is None else (amplitude,)
    for time_exponent, amplitude_exponent in product(times, amplitudes):
        if mean and not amplitude_exponent:
            continue
        scaling = Scaling(amplitude_exponent, space, time_exponent, background)
        try:
            reduction = reduce(lattice, scaling, scaling.leading_order + further)
        except ValueError as error:
            first_refusal = first_refusal or str(error)
            continue
        if reduction.is_balanced:
            any_balanced = True
            yield reduction
    if any_balanced:
        return
    if lattice.is_linear:
        raise ReductionError(
            f"forces must be nonlinear in the stretch x, got a linear lattice, {lattice.name} (add "
            "a term such as K3*x**2; its waves are in the dispersion relation alone)"
        )
    if (amplitude, time) == (None, None):
        raise ReductionError(f"no scaling fits {lattice.name}: {first_refusal}")
    balanced_scalings = (reduction.scaling for reduction in _balanced(lattice, mean, 0, space))
    known = "; ".join(f"amplitude {s.amplitude}, time {s.time}" for s in balanced_scalings)
    requested = (("amplitude", amplitude), ("time", time))
    got = ", ".join(f"{name} {value}" for name, value in requested if value is not None)
    raise ReductionError(
        f"amplitude and time must balance {lattice.name}, got {got} (what balances: {known})"
    )

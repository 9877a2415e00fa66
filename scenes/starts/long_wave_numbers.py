"""From a reduction to a long wave on its lattice: the fields of the ansatz with numbers in.

``f_j = background + eps^p (e_j W + G_j)``, and f_j' by the chain rule with time derivatives along
the reduced equation.  All of it is one series in eps of polynomials in X-derivatives of the wave.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from sympy import Expr, Symbol

from longwave.derive import Reduction
from longwave.derive.algebra.elimination import TimeElimination
from longwave.derive.algebra.exact_numbers import Number, exact
from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries, raised
from longwave.derive.expansion import Expansion
from longwave.derive.lattice import Lattice
from longwave.derive.symbols import eps as EPS
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.scenes.starts.first_correction import JetWave
from longwave.scenes.starts.jet_coefficients import with_numbers
from longwave.scenes.starts.jet_polynomial import JetPolynomial
from longwave.scenes.starts.long_wave_data import LongWaveData, LongWaveNumbers, SlowFrame

Values = Mapping[Symbol, Expr]


def long_wave(
    reduction: Reduction,
    constants: Mapping[str, Number],
    wave: JetWave,
    eps: float,
    order: str = "slaved",
    lattice: Lattice | None = None,
    interval: tuple[float, float] | None = None,
) -> LongWaveData:
    """Return a wave on a lattice under a reduction.

    ``constants``: their values.  ``lattice``: what is run, where the reduction expanded forces that
    are no polynomials.  The others are those of `LongWaveData`.

    Raises ValueError for constants without a value or not allowed, and where the reduction has no
    correction.
    """
    numbers = long_wave_numbers(reduction, constants, eps, order, lattice)
    return LongWaveData(numbers, wave, eps, order, interval)


def long_wave_numbers(
    reduction: Reduction,
    constants: Mapping[str, Number],
    eps: float,
    order: str,
    lattice: Lattice | None = None,
) -> LongWaveNumbers:
    """Return what `long_wave` takes of a reduction; errors are those of that."""
    values: Values = {**reduction.values(constants), EPS: exact("eps", eps)}
    shares = [share.as_expr().xreplace(values) for share, _ in reduction.slaved.values()]
    frames = [
        SlowFrame(
            variable.exponent,
            tuple(float(step.xreplace(values)) for step in variable.direction),
            float(variable.speed.xreplace(values)),
        )
        for variable in reduction.scaling.space
    ]
    background = sum(
        eps**power * float(value.xreplace(values)) for power, value in reduction.scaling.background
    )
    correction = _correction(reduction, values) if order == "corrected" else None
    return LongWaveNumbers(
        lattice=_lattice_at_rest(reduction, lattice or reduction.lattice, constants, values),
        frames=tuple(frames),
        series=_series(reduction, order, values, eps),
        correction=correction,
        is_displacement=reduction.is_displacement,
        amplitude=reduction.scaling.amplitude,
        time=reduction.scaling.time,
        background=float(background),
        shares=tuple(map(float, shares)),
    )


def _lattice_at_rest(
    reduction: Reduction, declared: Lattice, constants: Mapping[str, Number], values: Values
) -> NumericLattice:
    """Return the lattice that is run, without a mean strain and without losses."""
    small = {EPS: values[EPS]}
    bonds = tuple(replace(bond, force=bond.force.xreplace(small)) for bond in declared.bonds)
    lattice = replace(declared, bonds=bonds)
    lattice = lattice.with_losses() if lattice.has_losses else lattice
    known = {str(symbol) for symbol in lattice.constants}
    defined = {str(s): values[s] for s, _ in reduction.lattice.definitions}
    given = {name: value for name, value in {**constants, **defined}.items() if name in known}
    return numeric_lattice(lattice, given)


def _series(
    reduction: Reduction, order: str, values: Values, eps: float
) -> tuple[tuple[JetPolynomial, JetPolynomial], ...]:
    """Return the fields and their time derivatives in jets; none with a variable across."""
    if not reduction.pde.transverse:
        return tuple(
            (with_numbers(place, values, eps), with_numbers(change, values, eps))
            for place, change in FieldSeries(reduction, order).fields
        )
    if len(reduction.slaved) > 1 or len(reduction.scaling.space) != 2:
        raise ValueError(
            "a wave with a variable across must be one of one field and one such variable, got "
            f"{len(reduction.slaved)} fields and {len(reduction.scaling.space) - 1} variables "
            f"({reduction.lattice.name})"
        )
    return ()


def _correction(reduction: Reduction, values: Values) -> tuple[int, JetPolynomial, JetPolynomial]:
    """Return power, flow and correction; ValueError where none was derived."""
    powers = sorted(reduction.corrections)
    if not powers:
        ended = reduction.obstruction
        why = (
            f"its reduction to a one-way equation ends at eps^{ended[0]}, with a term that is "
            "no X-derivative"
            if ended
            else f"none was derived through eps^{reduction.highest_order}"
        )
        raise ValueError(
            f"order must be leading or slaved for {reduction.lattice.name}, got 'corrected' ({why})"
        )
    flow, further = (
        with_numbers(polynomial, values)
        for polynomial in (reduction.pde.flow, reduction.corrections[powers[0]])
    )
    return powers[0], flow, further


class FieldSeries:
    """Each field and its time derivative as series in eps of polynomials in X-jets of the unknown.

    The unknown is W on a lattice of displacements, Y on one of strains.
    """

    def __init__(self, reduction: Reduction, order: str) -> None:
        self._reduction = reduction
        series = next(iter(reduction.slaved.values()))[1]
        self._field, self._limit = series.field, series.limit
        self._expansion = Expansion(reduction.lattice, reduction.scaling, self._limit, self._field)
        self._order = order
        self._elimination = TimeElimination(self._flow(), len(reduction.scaling.axes))

    @property
    def fields(self) -> list[tuple[EpsSeries, EpsSeries]]:
        """For each field itself and its time derivative."""
        found = []
        for share, slaved in self._reduction.slaved.values():
            field = share * self._expansion.ansatz()
            field = field if self._order == "leading" else field + slaved
            moved = field.apply(self._expansion.time_derivative)
            found.append((self._elimination.series(field), self._elimination.series(moved)))
        return found

    def _flow(self) -> EpsSeries:
        """T-derivative of the unknown: of Y as the reduction has it, of W its antiderivative.

        A correction that has no local antiderivative is left out: it would change the velocity of
        displacements at its power and that of d/dT, which is of the next correction's size.
        """
        flows = {0: self._reduction.pde.flow}
        if self._order == "corrected":
            power = min(self._reduction.corrections)
            flows[power] = self._reduction.corrections[power]
        if self._reduction.is_displacement:
            found = {power: _of_displacement(flow) for power, flow in flows.items()}
            if found[0] is None:
                raise ValueError("the reduced equation must be a conservation law of the strain")
            flows = {power: flow for power, flow in found.items() if flow is not None}
        return EpsSeries(self._field, self._limit, flows)


def _of_displacement(flow: DifferentialPolynomial) -> DifferentialPolynomial | None:
    """W_T, from Y_T as a polynomial in jets of Y = W_X; None if it is not local."""
    items = ((tuple(sorted(raised(j, 0) for j in m)), value) for m, value in flow.terms.items())
    return DifferentialPolynomial.collect(flow.field, items).antiderivative()

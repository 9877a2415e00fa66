"""Numeric form of a reduction: the fields of the ansatz as polynomials with numeric coefficients.

``f_j = background + eps^p (e_j W + G_j)``; f_j' follows by the chain rule, with time derivatives
replaced by the reduced equation.  Both are series in eps of polynomials in X-derivatives of the
wave.
"""

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
    """Return a long wave of a reduction on its lattice.

    ``constants`` are the values of the lattice's constants.  ``lattice`` is the lattice to run; it
    must be given if the reduction expanded forces that are not polynomials.  The other arguments
    are those of `LongWaveData`.

    Raises ValueError for missing or invalid constants, and for the order "corrected" if the
    reduction has no correction.
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
    """Return the numeric form of a reduction for `long_wave`, which raises the same errors."""
    values: Values = {**reduction.values(constants), EPS: exact("eps", eps)}
    shares = [share.as_expr().xreplace(values) for share, _ in reduction.slaved.values()]
    frames = []
    for variable in reduction.scaling.space:
        direction = tuple(float(step.xreplace(values)) for step in variable.direction)
        speed = float(variable.speed.xreplace(values))
        frames.append(SlowFrame(variable.exponent, direction, speed))
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
    """Return the numeric lattice to run, without mean strain and losses."""
    small = {EPS: values[EPS]}
    bonds = tuple(replace(bond, force=bond.force.xreplace(small)) for bond in declared.bonds)
    lattice = replace(declared, bonds=bonds)
    lattice = lattice.with_losses() if lattice.has_losses else lattice
    names = {str(symbol) for symbol in lattice.constants}
    defined = {str(s): values[s] for s, _ in reduction.lattice.definitions}
    numbers = {name: value for name, value in {**constants, **defined}.items() if name in names}
    return numeric_lattice(lattice, numbers)


def _series(
    reduction: Reduction, order: str, values: Values, eps: float
) -> tuple[tuple[JetPolynomial, JetPolynomial], ...]:
    """Return each field and its time derivative as polynomials; () with a transverse variable.

    Raises ValueError for several fields or variables with a transverse variable.
    """
    if not reduction.pde.transverse:
        return tuple(
            (with_numbers(field, values, eps), with_numbers(rate, values, eps))
            for field, rate in FieldSeries(reduction, order).fields
        )
    if len(reduction.slaved) > 1 or len(reduction.scaling.space) != 2:
        raise ValueError(
            "a wave with a transverse variable must have one field and one such variable, got "
            f"{len(reduction.slaved)} fields and {len(reduction.scaling.space) - 1} variables "
            f"({reduction.lattice.name})"
        )
    return ()


def _correction(reduction: Reduction, values: Values) -> tuple[int, JetPolynomial, JetPolynomial]:
    """Return the first correction's power, the flow of the reduced equation and the correction's.

    Raises ValueError if no correction was derived.
    """
    powers = sorted(reduction.corrections)
    if not powers:
        obstruction = reduction.obstruction
        reason = (
            f"its reduction to a one-way equation ends at eps^{obstruction[0]}, with a term that "
            "is no X-derivative"
            if obstruction
            else f"no correction was derived through eps^{reduction.highest_order}"
        )
        raise ValueError(
            f"order must be leading or slaved for {reduction.lattice.name}, got 'corrected' "
            f"({reason})"
        )
    flow = with_numbers(reduction.pde.flow, values)
    return powers[0], flow, with_numbers(reduction.corrections[powers[0]], values)


class FieldSeries:
    """Series in eps of fields and their time derivatives, in X-derivatives of the unknown.

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
        """Pairs of series, one for each field: the field and its time derivative."""
        fields = []
        for share, slaved in self._reduction.slaved.values():
            field = share * self._expansion.ansatz()
            field = field if self._order == "leading" else field + slaved
            rate = field.apply(self._expansion.time_derivative)
            fields.append((self._elimination.series(field), self._elimination.series(rate)))
        return fields

    def _flow(self) -> EpsSeries:
        """Return the T-derivative of the unknown: Y_T of the reduction, or its antiderivative W_T.

        A correction without local antiderivative is neglected. It would change the velocity of
        displacements only by terms of the size of the next correction.
        """
        flows = {0: self._reduction.pde.flow}
        if self._order == "corrected":
            power = min(self._reduction.corrections)
            flows[power] = self._reduction.corrections[power]
        if self._reduction.is_displacement:
            integrated = {power: _displacement_flow(flow) for power, flow in flows.items()}
            if integrated[0] is None:
                raise ValueError("the reduced equation must be a conservation law of the strain")
            flows = {power: flow for power, flow in integrated.items() if flow is not None}
        return EpsSeries(self._field, self._limit, flows)


def _displacement_flow(flow: DifferentialPolynomial) -> DifferentialPolynomial | None:
    """Return W_T from Y_T, as a polynomial in derivatives of W; None if it is not local."""
    items = ((tuple(sorted(raised(j, 0) for j in m)), value) for m, value in flow.terms.items())
    return DifferentialPolynomial.collect(flow.field, items).antiderivative()

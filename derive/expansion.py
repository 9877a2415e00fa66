"""The equations of motion of a lattice under an ansatz, as series in eps.

The force is evaluated by Horner's rule on the stretch of the bond, so that differences cancel
before they are multiplied.

The fields of a cell move together in a long wave, ``f_j = eps^p (e_j W + G_j)``: e is the null
vector of the forces at wavenumber zero.  All rows of the equations of motion except one are solved
for the slaved parts G order by order; the rows weighted with the left null vector leave one
equation for W.  Shifts are exponentials, ``f_{n+s} = exp(s . sum eps^a d_X) f``, and time
derivatives follow the chain rule, ``d/dt = -sum speed eps^a d_X + eps^q d_T``.
"""

from collections.abc import Iterator, Sequence
from functools import cached_property

from sympy import Expr, S

from longwave.derive.algebra import small_matrices as matrices
from longwave.derive.algebra.exact_numbers import instance
from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries, Operator
from longwave.derive.algebra.rational_functions import RationalFunction, RationalFunctions
from longwave.derive.lattice import Bond, Cell, Lattice
from longwave.derive.scaling import Scaling
from longwave.derive.symbols import check_constants, powers_of_eps


class Expansion:
    """Long waves of ``lattice`` under ``scaling``, up to the power ``limit`` of eps.

    For a carrier wave, the j-th harmonic is multiplied by ``phase_factor**j`` from cell to cell and
    by ``-j rate`` by d/dt; a long wave has harmonic 0 only.
    """

    def __init__(
        self, lattice: Lattice, scaling: Scaling, limit: int, field: RationalFunctions
    ) -> None:
        self.lattice, self.scaling, self.limit, self.field = lattice, scaling, limit, field
        self.phase_factor, self.rate = field.one, field.zero

    def number(self, value: Expr) -> RationalFunction:
        """Return a constant as an element of `field`, the rational functions of the constants."""
        return self.field.from_expr(value)

    @property
    def time_derivative(self) -> Operator:
        """d/dt by the chain rule through the slow variables."""
        variables = enumerate(self.scaling.space)
        frame = tuple((axis, v.exponent, -self.number(v.speed)) for axis, v in variables)
        return (*frame, (len(frame), self.scaling.time, self.field.one))

    def shifted(self, series: EpsSeries, cell: Cell) -> EpsSeries:
        """Shift a series by whole cells, by Taylor's theorem."""
        operator = []
        for axis, v in enumerate(self.scaling.space):
            if step := sum(d * s for d, s in zip(v.direction, cell, strict=True)):
                operator.append((axis, v.exponent, self.number(step)))
        return series.exponential(tuple(operator))

    def ansatz(self) -> EpsSeries:
        """Return ``background + eps^amplitude W``."""
        mean = self.constant(S.Zero, self.limit)
        for power, value in self.scaling.background:
            mean = mean + self.constant(value, self.limit).delayed(power)
        jet = ((0,) * len(self.scaling.axes),)
        wave = {self.scaling.amplitude: DifferentialPolynomial.monomial(self.field, jet)}
        return EpsSeries.collect(self.field, self.limit, wave.items()) + mean

    def velocity(self) -> EpsSeries:
        """Return d/dt of the ansatz."""
        return self.rate_of(self.ansatz())

    def slaved_parts(self) -> list[EpsSeries]:
        """Solve for the parts G of the fields that follow the wave, with their powers of eps."""
        parts = [EpsSeries(self.field, self.limit, {})] * len(self.zero_mode[0])
        if len(parts) == 1:
            return parts
        for order in range(self.scaling.amplitude + 1, self.limit + 1):
            rows = [row.at(order) for row in self.rows(self._fields(parts, order), order)]
            for index, part in self.slaved(0, rows, self.zero_mode):
                parts[index] = parts[index].plus(order, part)
        return parts

    def residual(self, slaved: Sequence[EpsSeries] | None = None) -> EpsSeries:
        """Return the left-hand side of the wave's equation: the rows times the left null vector."""
        parts = self.slaved_parts() if slaved is None else slaved
        rows = self.rows(self._fields(parts, self.limit))
        return matrices.combined(self.zero_mode[1], rows, EpsSeries(self.field, self.limit, {}))

    def _fields(self, slaved: Sequence[EpsSeries], limit: int) -> list[EpsSeries]:
        wave, pairs = self.ansatz(), zip(self.zero_mode[0], slaved, strict=True)
        return [(weight * wave + part).upto(limit) for weight, part in pairs]

    def rows(self, fields: Sequence[EpsSeries], since: int = 0) -> list[EpsSeries]:
        """Return ``mass f'' + loss f' - forces`` of each field, from ``eps^since`` on."""
        rows = self.pulls(fields, since)
        fields_of_rows = zip(self.lattice.masses, self.lattice.site_losses, fields, strict=True)
        for i, (mass, loss, field) in enumerate(fields_of_rows):
            velocity = self.rate_of(field)
            inertia = self.constant(mass, field.limit) * self.rate_of(velocity)
            if loss:
                inertia = inertia + self.constant(loss, field.limit) * velocity
            rows[i] = inertia.upto(field.limit, since) + rows[i]
        return rows

    def rate_of(self, series: EpsSeries) -> EpsSeries:
        """Return the time derivative of a series."""
        return series.apply(self.time_derivative)

    def pulls(self, fields: Sequence[EpsSeries], since: int) -> list[EpsSeries]:
        """Return minus the force on each field, from ``eps^since`` on."""
        limit = fields[0].limit
        nothing = EpsSeries(self.field, limit, {})
        rows = [nothing] * len(fields)
        for bond in self.lattice.bonds:
            stretch, force = self.stretch(bond, fields), nothing
            for coefficient in bond.coefficients():
                force = force * stretch + self.constant(coefficient, limit)
            if bond.loss:
                force = force + self.constant(bond.loss, limit) * self.rate_of(stretch)
            for end in bond.action:
                pull = self.shifted(force, end.shift).upto(limit, since)
                rows[end.field] = rows[end.field] + self.field(-end.weight) * pull
        return rows

    def stretch(self, bond: Bond, fields: Sequence[EpsSeries]) -> EpsSeries:
        """Return the stretch of a bond as a series."""
        total = EpsSeries(self.field, fields[0].limit, {})
        for entry in bond.stretch:
            shifted = self.shifted(fields[entry.field], entry.shift)
            total = total + self.field(entry.weight) * shifted
        return total

    def constant(self, value: Expr, limit: int) -> EpsSeries:
        """Return a constant, which may be a polynomial in eps, as a series."""
        one = DifferentialPolynomial.monomial(self.field, ())
        parts = powers_of_eps(value).items()
        return EpsSeries.collect(self.field, limit, ((p, self.number(v) * one) for p, v in parts))

    def matrix(self, j: int) -> matrices.Matrix:
        """Return the linear part of ``mass d^2/dt^2 - forces`` at the j-th harmonic and eps = 0."""
        count = len(self.lattice.fields)
        means = (powers_of_eps(b).get(0, S.Zero) for p, b in self.scaling.background if p == 0)
        mean = sum(means, S.Zero)
        total = [[self.field.zero] * count for _ in range(count)]
        for i, mass in enumerate(self.lattice.masses):
            total[i][i] += self._leading(mass) * j**2 * self.rate**2
        for bond in self.lattice.bonds:
            about = sum(entry.weight for entry in bond.stretch) * mean
            slope = self._leading(bond.stiffness(about))
            for end in bond.action:
                for part in bond.stretch:
                    phase = self.phase_factor ** (j * (end.shift[0] + part.shift[0]))
                    total[end.field][part.field] -= end.weight * part.weight * slope * phase
        return total

    def _leading(self, value: Expr) -> RationalFunction:
        return self.number(powers_of_eps(value).get(0, S.Zero))

    def null_vectors(self, j: int) -> tuple[matrices.Column, matrices.Column]:
        """Return the right and left null vector of the j-th matrix, with first nonzero entry 1.

        Raises ValueError unless there is one of each.
        """
        matrix = self.matrix(j)
        null_spaces = [matrices.null_space(m) for m in (matrix, matrices.transposed(matrix))]
        if any(len(vectors) != 1 for vectors in null_spaces):
            count, no_wave = len(null_spaces[0]), "pinned: derive a carrier's envelope"
            raise ValueError(
                f"lattice must have one wave of vanishing frequency, got {count} "
                f"({'its fields move apart at no cost' if count > 1 else no_wave})"
            )
        return null_spaces[0][0], null_spaces[1][0]

    @cached_property
    def zero_mode(self) -> tuple[matrices.Column, matrices.Column]:
        """The null vectors at wavenumber zero, right and left: e and l."""
        return self.null_vectors(0)

    @cached_property
    def is_pinned(self) -> bool:
        """Whether on-site forces act, so that the mean follows from the wave."""
        return bool(matrices.determinant(self.matrix(0)))

    @cached_property
    def field_weights(self) -> matrices.Column:
        """Weight of each field in the zero mode; zeros if the lattice is pinned."""
        return [self.field.zero] * len(self.lattice.fields) if self.is_pinned else self.zero_mode[0]

    @cached_property
    def is_displacement(self) -> bool:
        """Whether no bond is stretched if all fields move with the zero mode's weights."""
        return not self.is_pinned and not any(
            sum((e.weight * self.field_weights[e.field] for e in bond.stretch), self.field.zero)
            for bond in self.lattice.bonds
        )

    def slaved(
        self,
        j: int,
        rows: Sequence[DifferentialPolynomial],
        wave: tuple[matrices.Column, matrices.Column] | None,
    ) -> Iterator[tuple[int, DifferentialPolynomial]]:
        """Solve for the parts of the fields that balance ``rows``, those of the j-th harmonic.

        Yields (field, part). If ``wave``, the harmonic's null vectors, is given, one field has no
        part and one row is left out. Raises ZeroDivisionError if the harmonic is another wave of
        the lattice.
        """
        column, row = (vector.index(1) for vector in wave) if wave else (None, None)
        part = matrices.without(self.matrix(j), row, column)
        others = [values for i, values in enumerate(rows) if i != row]
        fields = [index for index in range(len(rows)) if index != column]
        nothing = DifferentialPolynomial.zero(self.field)
        for index, weights in zip(fields, matrices.inverse(part) if part else [], strict=True):
            yield index, -matrices.combined(weights, others, nothing)


def expand(lattice: Lattice, scaling: Scaling, limit: int) -> Expansion:
    """Return the expansion of a lattice up to ``eps^limit``; non-polynomial forces are expanded.

    Raises ValueError for a scaling that does not fit the lattice.
    """
    instance("lattice", lattice, Lattice, "LATTICES['fput_strain'] is one")
    instance("scaling", scaling, Scaling, "Scaling() is the paper's")
    if len(lattice.fields) > 1 and scaling.background:
        raise ValueError(
            f"background must be left out with several fields, got {len(lattice.fields)} fields "
            "(put the static stretch of each bond into its force)"
        )
    for variable in scaling.space:
        if len(variable.direction) != lattice.dimension:
            raise ValueError(
                f"direction of {variable.name} must have {lattice.dimension} entries, one an axis "
                f"of {lattice.name}, got {variable.direction} ((1,) is along a chain)"
            )
    if scaling.frame_symbol in lattice.constants:
        raise ValueError(
            f"speed must not be a constant of {lattice.name}, got {scaling.speed} (the reduction "
            "finds it: take another symbol)"
        )
    if not lattice.is_polynomial:
        lattice = _polynomial(lattice, scaling, limit)
    scaling_constants = (symbol for symbol in scaling.constants if symbol not in lattice.constants)
    constants = (*scaling_constants, *lattice.constants)
    check_constants(constants)
    return Expansion(lattice, scaling, limit, RationalFunctions(constants))


def _polynomial(lattice: Lattice, scaling: Scaling, limit: int) -> Lattice:
    """Return the lattice with its forces expanded as far as ``eps^limit`` needs."""
    smallest = min(scaling.amplitude, *(power for power, _ in scaling.background), limit)
    if all(sum(entry.weight for entry in bond.stretch) == 0 for bond in lattice.bonds):
        smallest = scaling.amplitude + scaling.space[0].exponent
    if smallest < 1:
        raise ValueError(
            f"force must be a polynomial where the stretch is of order one, got amplitude "
            f"{scaling.amplitude} (take a larger amplitude exponent)"
        )
    return lattice.expanded(max(limit // smallest, 1))

"""The nonlinear Schroedinger equation of a carrier wave on a lattice, and its next order.

The fields are ``f = sum eps^m F_m``, each F a polynomial in the letters ``A, A_X, ...`` and their
conjugates; the harmonic j of a monomial is its number of A minus that of conjugates, and it has
the phase ``exp(i j (k n - omega t))``.  With ``z = exp(i k)`` and ``w = i omega`` a shift by s
cells is ``z^(j s) exp(eps s D)`` and the time derivative ``-j w - eps v D + eps^2 d_T``, with
D = d/dX: no i is left, and conjugation is z -> 1/z, w -> -w.  Coefficients are rational functions
of z, w and the lattice's constants except one, which the dispersion relation determines.

At each order, harmonic 0 gives the mean (by an X-integral if no on-site force pins the lattice),
harmonic 1 the group velocity, then ``A_T = G_0 + eps G_1``; the other harmonics are solved for.

Losses enter G_0 at eps^2.  They end the derivation there, because their effect on a mean is not
a local function of A.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from sympy import Expr, Symbol

from longwave.derive.algebra.formula_printing import text_of
from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries, Jet, Monomial
from longwave.derive.algebra.rational_functions import (
    Factor,
    RationalFunction,
    RationalFunctions,
    Terms,
)
from longwave.derive.algebra.small_matrices import Column, combined, determinant, without
from longwave.derive.expansion import Expansion
from longwave.derive.lattice import Bond, Cell, Lattice
from longwave.derive.scaling import Scaling

z, w = Symbol("exp(i k)"), Symbol("i omega")
"""Symbols of exp(i k) and i omega, with names that no constant of a lattice can have."""

LETTER, CONJUGATE, MEAN = 0, 1, 2
"""Second entry of a jet: A, its conjugate or the mean. The first entry counts X-derivatives."""

A: Jet = (0, LETTER)
MEAN_LETTER: Jet = (0, MEAN)

NLS, LAST = 3, 4
"""Orders in eps of the equations for G_0, the NLS equation, and for G_1, its correction."""

MAX_TERMS_PER_FIELD = 10
"""Bound on the terms of the second harmonic's determinant, for each field, with symbolic constants.
Three masses and equal springs have 30 and take 2 s, four masses with a symbol for one have 46 and
take 14 s, three masses and three springs 72 and did not finish within minutes."""

Rows = list[DifferentialPolynomial]


class EnvelopeError(ValueError):
    """Error for a carrier without an NLS equation; the message says why and what to try."""


def harmonic(monomial: Monomial) -> int:
    """Return the harmonic of a monomial: its number of A minus its number of conjugates of A.

    >>> harmonic(((0, 0), (0, 0), (1, 1)))
    1
    """
    return sum(1 - 2 * kind for _, kind in monomial if kind != MEAN)


def at_rest(at: str) -> str:
    """Return the message for a wave of frequency 0; ``at`` is "" or such as " at k = 0"."""
    return (
        f"k must have a carrier of frequency omega > 0, got omega = 0{at} (waves about k = 0 are "
        "long waves: leave --envelope out)"
    )


def _with_leading_mass(lattice: Lattice, leader: int) -> tuple[Lattice, tuple[Symbol]]:
    """Return the lattice with a symbol for the mass of the field ``leader``, and that symbol.

    The dispersion relation is linear in a mass, so it can be solved for the symbol.
    """
    symbol = Symbol(f"mass of {lattice.fields[leader]}", positive=True)
    masses = [symbol if i == leader else mass for i, mass in enumerate(lattice.masses)]
    definitions = (*lattice.definitions, (symbol, lattice.masses[leader]))
    return replace(lattice, masses=tuple(masses), definitions=definitions), (symbol,)


class Carrier(Expansion):
    """The expansion about one carrier wave, with the parts found so far.

    ``parts``: for each field the series without the mean.  ``mean``: the mean S, of the field or,
    for displacements, of a cell's strain; ``means`` are its orders.  ``flow``: G of ``A_T = G``.
    ``relation``: the dispersion relation, a polynomial in w^2; ``waves``: its factors, ``wave`` the
    one of this carrier, solved for its constant ``fixed``.  ``detuning``: what a constant mean adds
    to G_0, as a multiple of A.
    """

    values: dict[Symbol, Expr]
    images: dict[Symbol, RationalFunction]
    wave: RationalFunction
    fixed: Symbol

    def __init__(
        self,
        lattice: Lattice,
        *,
        turn: int | None = None,
        wave: int = 0,
        leader: int | None = None,
        values: Mapping[Symbol, Expr] | None = None,
    ) -> None:
        """Set up the expansion about a wave of the lattice.

        ``turn``: exp(i k), 1 or -1, if k is 0 or pi, else None.  ``wave``: number of the factor of
        the dispersion relation, if it has several.  ``leader``: field with amplitude A, by default
        the first that moves.  If ``leader`` is given, or if no constant can be solved for, the
        dispersion relation is solved for a field's mass.
        """
        lattice = lattice if lattice.is_polynomial else lattice.expanded(LAST)
        self._leader, self.turn = leader, turn
        if leader is not None:
            self._set_out(*_with_leading_mass(lattice, leader))
        elif not self._set_out(lattice, lattice.constants, wave):
            fields = range(len(lattice.fields))
            any(self._set_out(*_with_leading_mass(lattice, i), wave) for i in fields)
        self.values = {s: value for s, value in (values or {}).items() if s != self.fixed}
        value = self.number(self.wave.as_expr()).solved_for(self.fixed)
        if value is None:
            relation = f"{self.relation} = 0"
            raise EnvelopeError(f"{self.fixed} must be in the dispersion relation, got {relation}")
        self.images = {self.fixed: value}
        self._conjugates: dict[Factor, RationalFunction] = {}
        self.means: list[DifferentialPolynomial] = []
        self.group_velocity = self.detuning = self.field.zero
        self.flow = self._series({})
        self.mean = self._series({2: self._letter(MEAN_LETTER)})
        self.parts = [self._series({}) for _ in self.lattice.fields]
        for index, weight in enumerate(self.carried[0]):
            self._add(index, 1, weight * self._letter(A))

    def _set_out(self, lattice: Lattice, among: Sequence[Symbol], wave: int | None = None) -> bool:
        """Compute the dispersion relation; return whether a symbol in ``among`` can be solved for.

        ``wave``: number of the relation's factor, by default the first that can be solved.
        """
        turn = self.turn
        field = RationalFunctions((z, w, *lattice.constants))
        super().__init__(lattice, Scaling(time=2), LAST + 1, field)
        self.phase_factor, self.rate = field(z) if turn is None else field(turn), field(w)
        self.values, self.images = {}, {}
        self.linear = self.matrix(1)
        self.relation = determinant(self.linear)
        powers = [(factor, factor.powers_of(w)) for factor in self.relation.factors()]
        waves = [factor for factor, found in powers if 0 in found and len(found) > 1]
        if not waves:
            raise EnvelopeError(at_rest({1: " at k = 0", -1: " at k = pi"}.get(turn or 0, "")))
        is_stable = len(waves) > 1 and not any(i % 2 for f in waves for i in f.powers_of(w))
        self.waves = sorted(waves, key=self._first_moved) if is_stable else [self.relation]
        candidates = self.waves if wave is None else [self.waves[min(wave, len(self.waves) - 1)]]
        solvable_waves = (factor for factor in candidates if any(map(factor.solved_for, among)))
        self.wave = next(solvable_waves, candidates[0])
        solvable = [s for s in among if self.wave.solved_for(s)]
        solvable.sort(key=lambda s: self.relation.solved_for(s) is None)
        simple = (s for s in solvable if self.wave.diff(s).is_number)
        self.fixed = next(simple, next(iter(solvable), w))
        return bool(solvable)

    def _first_moved(self, wave: RationalFunction) -> int:
        """Return the first field that is not at rest in ``wave``, a factor of the relation."""
        fields = range(len(self.linear))
        minors = (determinant(without(self.linear, i, i)) for i in fields)
        pairs = zip(fields, minors, strict=True)
        return next((i for i, minor in pairs if wave not in minor.factors()), 0)

    def solve(self) -> None:
        """Solve for all parts up to G_1; with losses up to G_0."""
        self._check_losses()
        self._check_size()
        for order in (2, NLS) if self.lattice.has_losses else (2, NLS, LAST):
            if order > 2 and not self.is_pinned:
                self.detuning = self.detuning or self._flow_at(NLS).coefficient(A, MEAN_LETTER)
                self._solve_mean(order)
            self._solve_carrier(order)
            if order < LAST:
                for j in (0, 2):
                    self._solve_harmonic(order, j)

    def _check_size(self) -> None:
        """Raise EnvelopeError if the second harmonic's determinant is too large to compute soon."""
        fields, size = len(self.lattice.fields), (1 / self.second_harmonic).size
        unresolved = [s for s in self.lattice.constants if s not in {self.fixed, *self.values}]
        if self.turn is None and unresolved and fields > 2 and size > MAX_TERMS_PER_FIELD * fields:
            names = [str(s) for s in self.lattice.constants if s not in self.values]
            raise EnvelopeError(
                f"constants of a cell with {fields} fields must be few, got {', '.join(names)}: "
                f"the second harmonic's resonance has {size} terms, and {MAX_TERMS_PER_FIELD} for "
                f"each field are solved in symbols (give numbers, for all masses first, such as "
                f"{names[0]}=1)"
            )

    def _check_losses(self) -> None:
        for kind, (loss, power) in self.lattice.leading_losses.items():
            if power < NLS - 1:
                raise EnvelopeError(
                    f"{kind} loss must enter at the order of the NLS equation, eps^{NLS}, got "
                    f"{text_of(loss)}, which dominates at eps^{power + 1} (write eps^{NLS - 1} "
                    "times a constant)"
                )

    # orders of the expansion

    def _solve_mean(self, order: int) -> None:
        """Solve the rows of harmonic 0, combined by the left null vector, for the mean at
        ``eps^(order - 3)``."""
        rows = self._harmonic(order + (not self.is_displacement), 0)
        row = combined(self.zero_mode[1], rows, self._nothing)
        integrations = 1 if self.is_displacement else 2
        factor = row.coefficient((integrations, MEAN))
        known = row.select(lambda monomial: monomial != ((integrations, MEAN),))
        if not factor:
            raise EnvelopeError(
                "the group velocity must differ from the sound speed, got the same: the mean "
                "is then undetermined (take another wavenumber)"
            )
        for _ in range(integrations):
            integral = known.antiderivative()
            if integral is None:
                raise EnvelopeError(
                    f"the mean must be an X-integral, got none at eps^{order} (the forces conserve "
                    "no mean: there is no NLS equation)"
                )
            known = integral
        mean = (-1 / factor) * known
        self.means.append(mean)
        new_mean = self._series({0: mean, 1: self._letter(MEAN_LETTER)})
        self.mean, *self.parts = (
            series.replaced(lambda jet: new_mean.derivative(0, jet[0]) if jet[1] == MEAN else None)
            for series in (self.mean, *self.parts)
        )

    def _flow_at(self, order: int) -> DifferentialPolynomial:
        """Return the term of A_T that balances harmonic 1 at ``eps^order``; -v A_X at order 2."""
        right, left = self.carried
        row = combined(left, self._harmonic(order, 1), self._nothing)
        masses = map(self.number, self.lattice.masses)
        inertia = (a * mass * b for a, mass, b in zip(left, masses, right, strict=True))
        return (1 / (2 * self.rate * sum(inertia, self.field.zero))) * row

    def _solve_carrier(self, order: int) -> None:
        """Solve harmonic 1 for the group velocity (order 2) or a part of G, then for the fields."""
        flow = self._flow_at(order)
        if order == 2:
            self.group_velocity = -flow.coefficient((1, LETTER))
        else:
            self.flow = self.flow.plus(order - 3, flow)
        if order < LAST:
            self._solve_harmonic(order, 1)

    def _solve_harmonic(self, order: int, j: int) -> None:
        """Solve for the j-th harmonic at this order, up to multiples of a null vector."""
        wave = self.carried if j == 1 else None if j or self.is_pinned else self.zero_mode
        try:
            for index, part in self.slaved(j, self._harmonic(order, j), wave):
                self._add(index, order, part, real=j == 0)
        except ZeroDivisionError:
            raise EnvelopeError(
                f"harmonic {j} must not be a wave of the lattice, got a resonance: its frequency "
                "is on the dispersion relation (two waves interact: there is no NLS equation)"
            ) from None

    # the equations of motion

    def _harmonic(self, order: int, j: int) -> Rows:
        """Return the part of ``mass f'' - forces`` at this order and harmonic, for each field."""
        mean_part = self._series({}) if self.is_displacement else self.mean
        pairs = zip(self.parts, self.field_weights, strict=True)
        fields = [(part + weight * mean_part).upto(order) for part, weight in pairs]
        pulls = self.pulls(fields, order)
        rows = [pull.at(order).select(lambda m: harmonic(m) == j) for pull in pulls]
        drift = self._drift(order) if self.is_displacement and not j else self._nothing
        fields_of_rows = zip(self.lattice.masses, fields, self.field_weights, rows, strict=True)
        residuals = [
            self.number(mass) * (self._acceleration(field, order, j) + weight * drift) + row
            for mass, field, weight, row in fields_of_rows
        ]
        for index, loss in enumerate(self.lattice.losses):
            drag = (self.constant(loss, order) * self.rate_of(fields[index])).at(order)
            residuals[index] = residuals[index] + drag.select(lambda m: harmonic(m) == j)
        return residuals

    def _acceleration(self, series: EpsSeries, order: int, j: int) -> DifferentialPolynomial:
        """Return harmonic j of f'' at ``eps^order``; d/dt is ``-j w - eps v D + eps^2 d_T``."""
        rate, harmonic_part = j * self.rate, self._series({})
        for power in range(1, order + 1):
            selected = series.at(power).select(lambda m: harmonic(m) == j)
            harmonic_part = harmonic_part.plus(power, selected)
        advected = self.group_velocity * harmonic_part.derivative(0).delayed(1)
        total = rate**2 * harmonic_part.at(order) + 2 * rate * advected.at(order)
        total = total + self.group_velocity * advected.at(order - 1).derivative(0)
        return total + self.field(-2) * self._slow(rate * harmonic_part + advected, order - 2)

    def rate_of(self, series: EpsSeries) -> EpsSeries:
        """Return the time derivative used in loss terms, ``-j w`` times the j-th harmonic.

        The remainder, ``-eps v D + eps^2 d_T``, is beyond the last order with losses.
        """
        rotated = {}
        for order, part in series.parts.items():
            items = ((m, self.field(-harmonic(m)) * self.rate * v) for m, v in part.terms.items())
            rotated[order] = DifferentialPolynomial.collect(self.field, items)
        return self._series(rotated, series.limit)

    def _drift(self, order: int) -> DifferentialPolynomial:
        """Return, at this order, f'' of a displacement f whose X-derivative is the mean."""
        advected = self.group_velocity * self.mean.at(order - 1).derivative(0)
        return self.group_velocity * (advected + self.field(-2) * self._slow(self.mean, order - 2))

    def _slow(self, series: EpsSeries, order: int) -> DifferentialPolynomial:
        """Return the T-derivative of a series at ``eps^order``; A_T is replaced by ``flow``."""
        total = self._nothing
        for power, flow in self.flow.parts.items():
            rates = {LETTER: [flow], CONJUGATE: [self.conjugated(flow)]}
            for monomial, value in series.at(order - power).terms.items():
                for i, (count, kind) in enumerate(monomial):
                    if kind == MEAN:
                        continue
                    while len(rates[kind]) <= count:
                        rates[kind].append(rates[kind][-1].derivative(0))
                    others = {(*monomial[:i], *monomial[i + 1 :]): value}
                    total = total + DifferentialPolynomial(self.field, others) * rates[kind][count]
        return total

    def stretch(self, bond: Bond, fields: Sequence[EpsSeries]) -> EpsSeries:
        """Return the stretch of a bond by the fields and, for displacements, by the mean strain."""
        total = super().stretch(bond, fields)
        for entry in bond.stretch if self.is_displacement else ():
            gain = self._sum_over_cells(self.mean.upto(total.limit), entry.shift[0])
            total = total + (entry.weight * self.field_weights[entry.field]) * gain
        return total

    def _sum_over_cells(self, mean: EpsSeries, cells: int) -> EpsSeries:
        """Return the mean strain S summed over s cells: ``(exp(eps s D) - 1)/(eps D) S``."""
        total, power, count = self._series({}, mean.limit), mean, 1
        while cells and power.parts:
            power = self.field(cells) / count * power
            total = total + power
            power, count = power.derivative(0).delayed(1), count + 1
        return total

    def shifted(self, series: EpsSeries, cell: Cell) -> EpsSeries:
        """Shift a series by whole cells: harmonics by their phase, A and S by Taylor's theorem."""
        if not any(cell):
            return series
        rotated = {}
        for order, part in series.parts.items():
            phases = {m: self.phase_factor ** (harmonic(m) * cell[0]) for m in part.terms}
            terms = {m: v * phases[m] for m, v in part.terms.items()}
            rotated[order] = DifferentialPolynomial(self.field, terms)
        return super().shifted(self._series(rotated, series.limit), cell)

    def number(self, value: Expr) -> RationalFunction:
        """Return a constant in `field`; for `fixed`, its value by the dispersion relation."""
        return self.field.from_expr(value.xreplace(self.values), self.images)

    def null_vectors(self, j: int) -> tuple[Column, Column]:
        """Return the right and left null vector of harmonic j.

        Raises EnvelopeError unless each is unique.
        """
        try:
            return super().null_vectors(j)
        except ValueError:
            raise EnvelopeError(
                "the wave must be one wave of the lattice, got several of the same frequency "
                "(several waves interact: there is no single NLS equation)"
            ) from None

    @cached_property
    def second_harmonic(self) -> RationalFunction:
        """Inverse determinant of harmonic 2; infinite if that harmonic is a wave of the lattice."""
        return 1 / determinant(self.matrix(2))

    @cached_property
    def carried(self) -> tuple[Column, Column]:
        """The carrier's null vectors, right and left; the leading field has the entry 1."""
        right, left = self.null_vectors(1)
        if self._leader is None:
            return right, left
        leads = right[self._leader], left[self._leader]
        if not all(leads):
            raise EnvelopeError(f"{self.lattice.fields[self._leader]} must move, got it at rest")
        return [value / leads[0] for value in right], [value / leads[1] for value in left]

    @property
    def leader(self) -> int:
        """Index of the field whose amplitude is A."""
        return self.carried[0].index(1)

    @cached_property
    def singular(self) -> tuple[RationalFunction, RationalFunction]:
        """A pair of elements that are infinite where the formulas of this carrier do not hold.

        The first is infinite if the leader is at rest, the second if ``fixed`` has no solution.
        """
        others = without(self.linear, self.leader, self.leader)
        minor = determinant(others) if others else self.field.one
        return 1 / minor, 1 / self.wave.diff(self.fixed)

    @cached_property
    def mean_flow(self) -> EpsSeries:
        """The leading term in eps of the T-derivative of the mean's X-integral."""
        first = self._series({0: self.means[0]} if self.means else {})
        integral = self._slow(first, 0).antiderivative()
        if integral is None:
            raise EnvelopeError("the mean must be conserved, got none in A_T (take strains)")
        return self._series({2: integral})

    # algebra of the letters

    @property
    def _nothing(self) -> DifferentialPolynomial:
        return DifferentialPolynomial.zero(self.field)

    def _letter(self, jet: Jet) -> DifferentialPolynomial:
        return DifferentialPolynomial.monomial(self.field, (jet,))

    def _series(
        self, parts: Mapping[int, DifferentialPolynomial], limit: int = LAST + 1
    ) -> EpsSeries:
        return EpsSeries.collect(self.field, limit, parts.items())

    def _add(
        self, index: int, order: int, part: DifferentialPolynomial, *, real: bool = False
    ) -> None:
        """Add ``eps^order part`` to field ``index``, and its conjugate unless it is ``real``."""
        full_part = part if real else part + self.conjugated(part)
        self.parts[index] = self.parts[index].plus(order, full_part)

    def conjugated(self, polynomial: DifferentialPolynomial) -> DifferentialPolynomial:
        """Return the complex conjugate of a polynomial: z -> 1/z, w -> -w, A <-> its conjugate."""
        items = (
            (
                tuple(sorted((m, kind if kind == MEAN else 1 - kind) for m, kind in monomial)),
                value.mapped(self._reflect, self._conjugates),
            )
            for monomial, value in polynomial.terms.items()
        )
        return DifferentialPolynomial.collect(self.field, items)

    def _reflect(self, terms: Terms) -> RationalFunction:
        """Return the polynomial in z and w given by ``terms``, with 1/z for z and -w for w."""
        degree = max((exponents[0] for exponents, _ in terms), default=0)
        reflected = [
            ((degree - i, j, *others), -value if j % 2 else value)
            for (i, j, *others), value in terms
        ]
        return self.field.from_terms(reflected) / self.field(z) ** degree

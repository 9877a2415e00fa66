"""The nonlinear Schroedinger equation of a carrier wave on a lattice, and its next order.

The fields are ``f = sum eps^m F_m``, each F a polynomial in the letters ``A, A_X, ...`` and their
conjugates; a monomial's harmonic is the number of its A less that of its conjugates, and it carries
``exp(i j (k n - omega t))``.  With ``z = exp(i k)`` and ``w = i omega`` a shift by s cells is
``z^(j s) exp(eps s D)`` and the time derivative ``-j w - eps v D + eps^2 d_T``, with D = d/dX: no
i is left, and conjugation is z -> 1/z, w -> -w.  Coefficients are rational functions of z, w and
the lattice's constants but one, which the dispersion relation fixes.

Order by order harmonic 0 gives the mean (from an X-integral where nothing ties the lattice to its
place), harmonic 1 the group velocity, then ``A_T = G_0 + eps G_1``, and the others are solved for.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from sympy import Expr, S, Symbol

from longwave.derive.algebra.jets import DifferentialPolynomial, Jet, Monomial
from longwave.derive.algebra.rational_functions import (
    Exponents,
    RationalFunction,
    RationalFunctions,
)
from longwave.derive.algebra.series import EpsSeries
from longwave.derive.algebra.small_matrices import (
    Column,
    Matrix,
    determinant,
    inverse,
    null_space,
    transposed,
    without,
)
from longwave.derive.lattice import Bond, Lattice

z, w = Symbol("exp(i k)"), Symbol("i omega")
"""Under names that no constant of a lattice can have."""

LETTER, CONJUGATE, MEAN = 0, 1, 2
"""Second entry of a jet, behind the number of its X-derivatives."""

A: Jet = (0, LETTER)
MEAN_LETTER: Jet = (0, MEAN)

LAST = 4
"""The power of eps at which G_1 is found."""

Rows = tuple[DifferentialPolynomial, ...]
Terms = list[tuple[Exponents, int]]


class EnvelopeError(ValueError):
    """There is no NLS equation of this carrier; the message says why, and what may replace it."""


def harmonic(monomial: Monomial) -> int:
    """How many A a monomial has, less its conjugates.

    >>> harmonic(((0, 0), (0, 0), (1, 1)))
    1
    """
    return sum(1 - 2 * kind for _, kind in monomial if kind != MEAN)


class Carrier:
    """The expansion about one carrier wave, and the parts of it that are found so far.

    ``parts``: for each field the series without the mean.  ``mean``: the mean S, of the field or,
    in a lattice of displacements, of the strain of a cell; ``means`` are its orders.  ``flow``: G
    of ``A_T = G``.  ``relation``: the dispersion relation, a polynomial in w^2.  ``detuning``: what
    a constant mean adds to G_0, as a multiple of A.
    """

    def __init__(
        self, lattice: Lattice, *, at_pi: bool = False, values: Mapping[Symbol, Expr] | None = None
    ) -> None:
        self.lattice = lattice if lattice.is_polynomial else lattice.expanded(LAST)
        constants = self.lattice.constants
        self.field = RationalFunctions((z, w, *constants))
        self.turn = self.field(-1) if at_pi else self.field(z)
        self.values: dict[Symbol, Expr] = {}
        self.images: dict[Symbol, RationalFunction] = {}
        self.relation = determinant(self.matrix(1))
        solvable = [s for s in constants if self.relation.solved_for(s)]
        if not solvable:
            raise EnvelopeError(
                "the dispersion relation must be linear in one of the lattice's constants, got "
                f"none among {', '.join(map(str, constants))} (write a symbol for a number)"
            )
        self.fixed = next((s for s in solvable if self.relation.diff(s).is_number), solvable[0])
        self.values = {s: value for s, value in (values or {}).items() if s != self.fixed}
        value = determinant(self.matrix(1)).solved_for(self.fixed)
        if value is None:
            raise EnvelopeError(f"{self.fixed} must enter the dispersion relation, got it nowhere")
        self.images = {self.fixed: value}
        self.means: list[DifferentialPolynomial] = []
        self.velocity = self.detuning = self.field.zero
        self.flow = self._series({})
        self.mean = self._series({2: self._letter(MEAN_LETTER)})
        self.parts = [self._series({}) for _ in self.lattice.fields]
        for index, share in enumerate(self.carried[0]):
            self._add(index, 1, share * self._letter(A))

    def solve(self) -> None:
        """Find all parts up to G_1."""
        for order in (2, 3, LAST):
            if order > 2 and not self.is_pinned:
                self.detuning = self.detuning or self._detuning()
                self._solve_mean(order)
            self._solve_carrier(order)
            if order < LAST:
                for j in (0, 2):
                    self._solve_harmonic(order, j)

    # one order after the other

    def _solve_mean(self, order: int) -> None:
        """The mean at ``eps^(order - 3)``, from the row that the other fields leave."""
        row = self._weighted(self.uniform[1], self._rows(order + (not self.is_displacement), 0))
        times = 1 if self.is_displacement else 2
        factor = row.coefficient((times, MEAN))
        known = row.select(lambda monomial: monomial != ((times, MEAN),))
        if not factor:
            raise EnvelopeError("the mean must be slaved, got a group velocity equal to the sound")
        for _ in range(times):
            integral = known.antiderivative()
            if integral is None:
                raise EnvelopeError(f"the mean must be an X-integral, got none at eps^{order}")
            known = integral
        found = (-1 / factor) * known
        self.means.append(found)
        later = {0: found, 1: self._letter(MEAN_LETTER)}
        self.mean = self._with_mean(self.mean, later)
        self.parts = [self._with_mean(part, later) for part in self.parts]

    def _detuning(self) -> RationalFunction:
        """The coefficient of S A in ``A_T = G_0``, while the mean is free."""
        row = self._weighted(self.carried[1], self._rows(3, 1))
        return row.coefficient(A, MEAN_LETTER) / (2 * self.field(w) * self._inertia(self.carried))

    def _solve_carrier(self, order: int) -> None:
        """The group velocity or G at this order, then the rest of harmonic 1."""
        row = self._weighted(self.carried[1], self._rows(order, 1))
        inertia = self._inertia(self.carried)
        found = (1 / (2 * self.field(w) * inertia)) * row
        if order == 2:
            self.velocity = -found.coefficient((1, LETTER))
        else:
            self.flow = self._series({**self.flow.parts, order - 3: found})
        if order < LAST:
            self._solve_harmonic(order, 1)

    def _solve_harmonic(self, order: int, j: int) -> None:
        """The parts of the j-th harmonic at this order, but for multiples of a null vector."""
        matrix, rows = self.matrix(j), self._rows(order, j)
        count = len(rows)
        free = self.carried if j == 1 else self.uniform if j == 0 and not self.is_pinned else None
        places = [next(i for i, value in enumerate(v) if value) for v in free] if free else [-1, -1]
        kept_columns, kept_rows = ([i for i in range(count) if i != out] for out in places)
        if not kept_rows:
            return
        part = without(matrix, places[1], places[0])
        if not determinant(part):
            raise EnvelopeError(
                f"harmonic {j} must not be a wave of the lattice, got a resonance: its frequency "
                "is on the dispersion relation (two waves interact: there is no NLS equation)"
            )
        for index, weights in zip(kept_columns, inverse(part), strict=True):
            terms = (-weight * rows[i] for i, weight in zip(kept_rows, weights, strict=True))
            self._add(index, order, sum(terms, self._nothing), real=j == 0)

    # rows of the equations of motion

    def _rows(self, order: int, j: int) -> Rows:
        """The part of ``mass f'' - forces`` at this order and harmonic, for each field."""
        rows = [
            self.number(mass) * self._acceleration(index, order, j)
            for index, mass in enumerate(self.lattice.masses)
        ]
        for bond in self.lattice.bonds:
            force = self._series({}, order)
            stretch = self._stretch(bond, order)
            for coefficient in bond.coefficients():
                force = force * stretch + force.constant(self.number(coefficient))
            for end in bond.action:
                pull = self._shifted(force, end.shift[0])
                found = pull.parts.get(order, self._nothing).select(lambda m: harmonic(m) == j)
                rows[end.field] = rows[end.field] + self.field(-end.weight) * found
        return tuple(rows)

    def _acceleration(self, index: int, order: int, j: int) -> DifferentialPolynomial:
        """The j-th harmonic of f'' at this order; d/dt is ``-j w - eps v D + eps^2 d_T`` there."""
        own = self.parts[index]
        share = self.field.zero if self.is_pinned else self.uniform[0][index]
        if share and not self.is_displacement:
            own = own + share * self.mean

        def part(power: int) -> DifferentialPolynomial:
            return own.parts.get(power, self._nothing).select(lambda m: harmonic(m) == j)

        turn, v = j * self.field(w), self.velocity
        total = turn**2 * part(order)
        total = total + 2 * turn * v * part(order - 1).derivative(0)
        total = total + v**2 * part(order - 2).derivative(0).derivative(0)
        for power in self.flow.parts:
            total = total + -2 * turn * self._slow(part(order - 2 - power), power)
            total = total + -2 * v * self._slow(part(order - 3 - power), power).derivative(0)
        if share and self.is_displacement and j == 0:
            total = total + share * self._drift(order)
        return total

    def _drift(self, order: int) -> DifferentialPolynomial:
        """The second time derivative of a displacement whose X-derivative is the mean."""
        parts = self.mean.parts
        total = self.velocity**2 * parts.get(order - 1, self._nothing).derivative(0)
        for power in self.flow.parts:
            slow = self._slow(parts.get(order - 2 - power, self._nothing), power)
            total = total + -2 * self.velocity * slow
        return total

    def _slow(self, part: DifferentialPolynomial, power: int) -> DifferentialPolynomial:
        """d/dT along the flow, the term of ``eps^power``."""
        moved = {LETTER: [self.flow.parts[power]]}
        moved[CONJUGATE] = [self.conjugated(moved[LETTER][0])]
        for flows in moved.values():
            while len(flows) <= max((count for m in part.terms for count, _ in m), default=0):
                flows.append(flows[-1].derivative(0))
        total = self._nothing
        for monomial, value in part.terms.items():
            for i, (count, kind) in enumerate(monomial):
                if kind != MEAN:
                    rest = (*monomial[:i], *monomial[i + 1 :])
                    term = DifferentialPolynomial(self.field, {rest: value})
                    total = total + term * moved[kind][count]
        return total

    def _stretch(self, bond: Bond, order: int) -> EpsSeries:
        total = self._series({}, order)
        for entry in bond.stretch:
            field = self._series(self.parts[entry.field].parts, order)
            total = total + self.field(entry.weight) * self._shifted(field, entry.shift[0])
            share = self.field.zero if self.is_pinned else self.uniform[0][entry.field]
            mean = self._series(self.mean.parts, order)
            if share and self.is_displacement:
                mean = self._summed(mean, entry.shift[0])
            elif share:
                mean = self._shifted(mean, entry.shift[0])
            total = total + (entry.weight * share) * mean if share else total
        return total

    def _summed(self, mean: EpsSeries, cells: int) -> EpsSeries:
        """What a displacement gains over so many cells: ``(exp(eps s D) - 1)/(eps D)`` of S."""
        total, power, count = self._series({}, mean.limit), mean, 1
        while cells and power.parts:
            power = self.field(cells) / count * power
            total = total + power
            power, count = power.derivative(0).delayed(1), count + 1
        return total

    def _shifted(self, series: EpsSeries, cells: int) -> EpsSeries:
        if not cells:
            return series
        turned = EpsSeries.collect(
            self.field,
            series.limit,
            (
                (order, part.map_terms(lambda m, v: v * self.turn ** (harmonic(m) * cells)))
                for order, part in series.parts.items()
            ),
        )
        return turned.exponential(((0, 1, self.field(cells)),))

    # linear algebra at a harmonic

    def number(self, value: Expr) -> RationalFunction:
        """A constant; the one that the dispersion relation fixes is replaced."""
        return self.field.from_expr(value.xreplace(self.values), self.images)

    def matrix(self, j: int) -> Matrix:
        """``mass d^2/dt^2 - forces`` at the j-th harmonic and eps = 0."""
        count = len(self.lattice.fields)
        total = [[self.field.zero] * count for _ in range(count)]
        for i, mass in enumerate(self.lattice.masses):
            total[i][i] += self.number(mass) * j**2 * self.field(w) ** 2
        for bond in self.lattice.bonds:
            slope = self.number(bond.stiffness(S.Zero))
            for end in bond.action:
                for part in bond.stretch:
                    turn = self.turn ** (j * (end.shift[0] + part.shift[0]))
                    total[end.field][part.field] -= end.weight * part.weight * slope * turn
        return total

    @cached_property
    def second_harmonic(self) -> RationalFunction:
        """One over what vanishes where the second harmonic is a wave of the lattice."""
        return 1 / determinant(self.matrix(2))

    @cached_property
    def carried(self) -> tuple[Column, Column]:
        """The carrier's null vectors, right and left; 1 is the first entry that is not 0."""
        return _null_vectors(self.matrix(1))

    @cached_property
    def uniform(self) -> tuple[Column, Column]:
        """The same of a mean that nothing ties to its place."""
        return _null_vectors(self.matrix(0))

    @cached_property
    def is_pinned(self) -> bool:
        """Whether a force ties the lattice to its place: the mean is then slaved."""
        return bool(determinant(self.matrix(0)))

    @cached_property
    def is_displacement(self) -> bool:
        """Whether no bond feels the mean itself, but its X-derivative."""
        return not self.is_pinned and not any(
            sum((e.weight * self.uniform[0][e.field] for e in bond.stretch), self.field.zero)
            for bond in self.lattice.bonds
        )

    @cached_property
    def mean_flow(self) -> EpsSeries:
        """The T-derivative of the X-integral of the mean, at its first order."""
        first = self.means[0] if self.means else self._nothing
        integral = self._slow(first, 0).antiderivative()
        if integral is None:
            raise EnvelopeError("the mean must be conserved, got none in A_T (take strains)")
        return self._series({2: integral})

    def _inertia(self, vectors: tuple[Column, Column]) -> RationalFunction:
        masses = (self.number(mass) for mass in self.lattice.masses)
        return sum(
            (left * mass * right for right, left, mass in zip(*vectors, masses, strict=True)),
            self.field.zero,
        )

    # the algebra of letters

    @property
    def _nothing(self) -> DifferentialPolynomial:
        return DifferentialPolynomial.zero(self.field)

    def _letter(self, jet: Jet) -> DifferentialPolynomial:
        return DifferentialPolynomial.monomial(self.field, (jet,))

    def _series(
        self, parts: Mapping[int, DifferentialPolynomial], limit: int = LAST + 1
    ) -> EpsSeries:
        return EpsSeries.collect(self.field, limit, parts.items())

    def _weighted(self, weights: Column, rows: Rows) -> DifferentialPolynomial:
        terms = (a * row for a, row in zip(weights, rows, strict=True))
        return sum(terms, self._nothing)

    def _add(
        self, index: int, order: int, part: DifferentialPolynomial, *, real: bool = False
    ) -> None:
        """Add a part to a field, with its conjugate unless it is real."""
        whole = part if real else part + self.conjugated(part)
        self.parts[index] = self.parts[index] + self._series({order: whole})

    def conjugated(self, polynomial: DifferentialPolynomial) -> DifferentialPolynomial:
        """The complex conjugate."""
        items = (
            (
                tuple(sorted((m, kind if kind == MEAN else 1 - kind) for m, kind in monomial)),
                self._conjugated_number(value),
            )
            for monomial, value in polynomial.terms.items()
        )
        return DifferentialPolynomial.collect(self.field, items)

    def _conjugated_number(self, element: RationalFunction) -> RationalFunction:
        """The element at 1/z and -w."""
        both = [element.terms(), element.terms(below=True)]
        degree = max(exponents[0] for terms in both for exponents, _ in terms)
        above, below = (self.field.from_terms(_reflected(terms, degree)) for terms in both)
        return above / below

    def _with_mean(
        self, series: EpsSeries, letter: Mapping[int, DifferentialPolynomial]
    ) -> EpsSeries:
        """The series with another series in the place of the mean's letter."""
        total = self._series({})
        for order, part in series.parts.items():
            for monomial, value in part.terms.items():
                product = self._series({order: value * self._monomial(monomial, MEAN)})
                for count, kind in monomial:
                    if kind == MEAN:
                        product = product * self._series(letter).derivative(0, count)
                total = total + product
        return total

    def _monomial(self, monomial: Monomial, without: int) -> DifferentialPolynomial:
        return DifferentialPolynomial.monomial(self.field, (j for j in monomial if j[1] != without))


def _null_vectors(matrix: Matrix) -> tuple[Column, Column]:
    """The right and the left null vector."""
    found = (null_space(matrix), null_space(transposed(matrix)))
    if any(len(vectors) != 1 for vectors in found):
        raise EnvelopeError(
            "the wave must be one wave of the lattice, got several of the same frequency "
            "(several waves interact: there is no single NLS equation)"
        )
    return found[0][0], found[1][0]


def _reflected(terms: Terms, degree: int) -> Terms:
    """``z**degree`` times the polynomial at 1/z and -w."""
    return [
        ((degree - exponents[0], *exponents[1:]), -value if exponents[1] % 2 else value)
        for exponents, value in terms
    ]

"""Waves of a linear chain: its dispersion relation and its branches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sympy import Expr, Poly, Rational, S, Symbol, expand, factor, pi, sin, sqrt

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.formula_printing import Printed, text_of
from longwave.derive.carrier import Carrier, w
from longwave.derive.lattice import Lattice
from longwave.derive.sines import cosine, in_sines, omega, sine
from longwave.derive.symbols import k, values_of

TABLE_WAVENUMBERS = tuple(pi * Rational(i, 4) for i in range(5))
"""Wavenumbers of `LinearWaves.table`, in radians a cell."""

REST_TOLERANCE = 1e-9
"""Fraction of the largest omega^2 below which an omega^2 counts as 0 (the wave is at rest), and the
difference of two omega^2 counts as 0 (two branches meet)."""

Row = tuple[Expr, list[tuple[float, float | None]]]


@dataclass(frozen=True)
class LinearWaves:
    """Dispersion relation ``sum coefficients[j] omega^(2 j) = 0``, in k and the constants.

    The last coefficient is 1.

    >>> from longwave.derive import LATTICES
    >>> LinearWaves.of(LATTICES["fput"]).branches
    (4*K2*sin(k/2)**2,)
    """

    lattice: Lattice
    coefficients: tuple[Expr, ...]

    @classmethod
    def of(cls, lattice: Lattice) -> LinearWaves:
        """Compute the waves of a chain without losses. Raises ValueError if omega^2 is not real."""
        carrier = Carrier(lattice)
        powers = carrier.relation.powers_of(w)
        highest, coefficients = max(powers), []
        actual = {sine: sin(k / 2), cosine: sqrt(1 - sin(k / 2) ** 2)}
        defined = dict(carrier.lattice.definitions)
        for power in range(0, highest + 2, 2):
            ratio = powers.get(power, carrier.field.zero) / powers[highest]
            real, imaginary = in_sines(ratio)
            if imaginary != 0:
                raise ValueError(
                    f"omega^2 must be real, got a complex dispersion relation of {lattice.name} "
                    "(its forces have no energy: let each action be minus its stretch's mirror)"
                )
            sign = (-1) ** ((highest - power) // 2)
            coefficients.append(factor(sign * real.subs(actual)).xreplace(defined))
        return cls(lattice, tuple(coefficients))

    @property
    def branches(self) -> tuple[Expr, ...]:
        """omega^2 of each branch, lowest first; empty for more than two branches."""
        if len(self.coefficients) == 2:
            return (factor(-self.coefficients[0]),)
        if len(self.coefficients) > 3:
            return ()
        last, middle = self.coefficients[:2]
        inner = factor(expand(middle**2 / 4 - last))
        outer, inside = S.One, S.One
        for base, power in inner.as_powers_dict().items():
            is_square = power.is_integer and power % 2 == 0 and base.is_positive
            factor_ = base**power
            outer, inside = (outer * factor_, inside) if is_square else (outer, inside * factor_)
        root = sqrt(outer) * sqrt(expand(inside))
        return tuple(factor(-middle / 2) + sign * root for sign in (-1, 1))

    @property
    def _omega(self) -> Symbol:
        return Symbol("omega~") if omega.name in self.lattice.names else omega

    def relation(self, printed: Printed = text_of) -> str:
        """Return the dispersion relation in one line, as text or LaTeX."""
        terms = (v * self._omega ** (2 * j) for j, v in enumerate(self.coefficients))
        return f"{printed(sum(terms, S.Zero))} = 0"

    def lines(self, printed: Printed = text_of) -> Iterator[str]:
        """Yield ``omega^2 = ...`` of all `branches`, lowest first; without them, the `relation`."""
        if not self.branches:
            yield self.relation(printed)
        yield from (f"{printed(self._omega**2)} = {printed(value)}" for value in self.branches)

    def table(self, constants: Mapping[str, Number]) -> list[Row]:
        """Return omega and group velocity of each branch, lowest first, at `TABLE_WAVENUMBERS`.

        The velocity is None where two branches meet.  Raises ValueError for constants that are
        missing or make a wave unstable.
        """
        names = {str(symbol): symbol for symbol in self.lattice.basic_constants}
        values = self.lattice.with_defined(values_of(constants, names, self.lattice.name))
        square = Symbol("square")
        terms = sum((v * square**j for j, v in enumerate(self.coefficients)), S.Zero)
        relation = terms.xreplace(values)
        if missing := sorted(map(str, relation.free_symbols - {k, square})):
            name = missing[0]
            raise ValueError(f"{name} must be given, got none (a number, such as {name}=1)")
        slopes = [relation.diff(k), relation.diff(square), relation.diff(k, 2)]
        rows: list[Row] = []
        for angle in TABLE_WAVENUMBERS:
            roots = Poly(relation.subs(k, angle).evalf(40), square).nroots(n=30)
            squares = sorted(map(float, roots))
            if squares[0] < -REST_TOLERANCE * squares[-1]:
                raise ValueError(
                    f"constants must make waves stable, got omega^2 = {squares[0]:.6g} at k = "
                    f"{angle} (take positive stiffnesses)"
                )
            branches = range(len(squares))
            rows.append((angle, [_wave(slopes, square, angle, squares, i) for i in branches]))
        return rows


def _wave(
    slopes: list[Expr], square: Symbol, angle: Expr, squares: list[float], branch: int
) -> tuple[float, float | None]:
    """Return omega and d omega/dk of a branch, from the derivatives of the relation."""
    value, largest = max(squares[branch], 0.0), max(squares[-1], 1e-300)
    if value < REST_TOLERANCE * largest:
        value = 0.0
    k_slope, square_slope, k_curvature = (float(s.subs({k: angle, square: value})) for s in slopes)
    others = [other for i, other in enumerate(squares) if i != branch]
    if any(abs(other - squares[branch]) < REST_TOLERANCE * largest for other in others):
        return value**0.5, None
    if value:
        return value**0.5, 0.0 - k_slope / (square_slope * 2 * value**0.5)
    return 0.0, max(-k_curvature / (2 * square_slope), 0.0) ** 0.5

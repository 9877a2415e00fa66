"""The waves of a linear chain: its dispersion relation and its branches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sympy import Expr, Poly, Rational, S, Symbol, expand, factor, pi, sin, sqrt

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.carrier import Carrier, w
from longwave.derive.lattice import Lattice
from longwave.derive.output.notation import Printed, text_of
from longwave.derive.sines import cosine, in_sines, omega, sine
from longwave.derive.symbols import k, values_of

SAMPLES = tuple(pi * Rational(i, 4) for i in range(5))
"""Wavenumbers of the table."""

NONE = 1e-9
"""A frequency so small, beside the largest, is none; two that differ by less are one."""

Row = tuple[Expr, list[tuple[float, float | None]]]


@dataclass(frozen=True)
class LinearWaves:
    """``sum coefficients[j] omega^(2 j) = 0``, in the wavenumber k and the constants.

    The last coefficient is 1.

    >>> from longwave.derive import LATTICES
    >>> LinearWaves.of(LATTICES["fput"]).branches
    (4*K2*sin(k/2)**2,)
    """

    lattice: Lattice
    coefficients: tuple[Expr, ...]

    @classmethod
    def of(cls, lattice: Lattice) -> LinearWaves:
        """Those of a chain without losses."""
        carrier = Carrier(lattice)
        powers = carrier.relation.powers_of(w)
        highest, found = max(powers), []
        actual = {sine: sin(k / 2), cosine: sqrt(1 - sin(k / 2) ** 2)}
        defined = dict(carrier.lattice.definitions)
        for power in range(0, highest + 2, 2):
            part = powers.get(power, carrier.field.zero) / powers[highest]
            real, imaginary = in_sines(part)
            if imaginary != 0:
                raise ValueError(
                    f"omega^2 must be real, got a complex dispersion relation of {lattice.name} "
                    "(its forces have no energy: let each action be minus its stretch's mirror)"
                )
            sign = (-1) ** ((highest - power) // 2)
            found.append(factor(sign * real.subs(actual)).xreplace(defined))
        return cls(lattice, tuple(found))

    @property
    def branches(self) -> tuple[Expr, ...]:
        """omega^2 from below, of one field or two; nothing for more."""
        if len(self.coefficients) == 2:
            return (factor(-self.coefficients[0]),)
        if len(self.coefficients) > 3:
            return ()
        last, middle = self.coefficients[:2]
        inner = factor(expand(middle**2 / 4 - last))
        outer, rest = S.One, S.One
        for base, power in inner.as_powers_dict().items():
            is_square = power.is_integer and power % 2 == 0 and base.is_positive
            outer, rest = (outer * base**power, rest) if is_square else (outer, rest * base**power)
        root = sqrt(outer) * sqrt(expand(rest))
        return tuple(factor(-middle / 2) + sign * root for sign in (-1, 1))

    def relation(self, printed: Printed = text_of) -> str:
        """The relation in one line."""
        own = Symbol("omega~") if omega.name in self.lattice.names else omega
        terms = sum((v * own ** (2 * j) for j, v in enumerate(self.coefficients)), S.Zero)
        return f"{printed(terms)} = 0"

    def lines(self, printed: Printed = text_of) -> Iterator[str]:
        """The branches from below, or the relation."""
        own = Symbol("omega~") if omega.name in self.lattice.names else omega
        if not self.branches:
            yield self.relation(printed)
        yield from (f"{printed(own**2)} = {printed(value)}" for value in self.branches)

    def table(self, constants: Mapping[str, Number]) -> list[Row]:
        """omega and the group velocity of each branch at `SAMPLES`, from below.

        None stands for the velocity where two branches meet.  Raises ValueError for constants that
        are missing or make a wave grow.
        """
        names = {str(symbol): symbol for symbol in self.lattice.basic_constants}
        values = self.lattice.with_defined(values_of(constants, names, self.lattice.name))
        square = Symbol("square")
        terms = sum((v * square**j for j, v in enumerate(self.coefficients)), S.Zero)
        left = terms.xreplace(values)
        if missing := sorted(map(str, left.free_symbols - {k, square})):
            raise ValueError(f"{missing[0]} must be given, got none (a number, as {missing[0]}=1)")
        slopes = [left.diff(k), left.diff(square), left.diff(k, 2)]
        rows: list[Row] = []
        for at in SAMPLES:
            squares = sorted(
                float(r) for r in Poly(left.subs(k, at).evalf(40), square).nroots(n=30)
            )
            if squares[0] < -NONE * squares[-1]:
                raise ValueError(
                    f"constants must make waves stable, got omega^2 = {squares[0]:.6g} at k = {at}"
                )
            rows.append((at, [_wave(slopes, square, at, squares, i) for i in range(len(squares))]))
        return rows


def _wave(
    slopes: list[Expr], square: Symbol, at: Expr, squares: list[float], branch: int
) -> tuple[float, float | None]:
    """omega and d omega/dk of a branch, from the derivatives of the relation."""
    size, largest = max(squares[branch], 0.0), max(squares[-1], 1e-300)
    if size < NONE * largest:
        size = 0.0
    along, across, bend = (float(s.subs({k: at, square: size})) for s in slopes)
    others = [other for i, other in enumerate(squares) if i != branch]
    if any(abs(other - squares[branch]) < NONE * largest for other in others):
        return size**0.5, None
    if size:
        return size**0.5, 0.0 - along / (across * 2 * size**0.5)
    return 0.0, max(-bend / (2 * across), 0.0) ** 0.5

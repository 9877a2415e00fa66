"""Checks of a reduction and an envelope that do not use the expansion.

Constants are set to rational numbers chosen here. The lattice itself is evaluated at 60 digits,
and the remainder of an expansion must fall with eps at the promised power.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import cycle
from typing import Any

import mpmath
from sympy import Expr, Rational, S, Symbol, pi, primerange, solve, sqrt

from longwave.derive.algebra.jets import DifferentialPolynomial
from longwave.derive.carrier_envelope import Envelope, evaluated
from longwave.derive.equations import Coefficients
from longwave.derive.lattice import Bond, Lattice, Stencil
from longwave.derive.reduction import Reduction
from longwave.derive.scaling import SlowVariable
from longwave.derive.symbols import eps

DIGITS = 60
"""Working digits of the checks."""

EPS_VALUES = ("1e-4", "1e-5")
"""The two values of eps from whose remainders the exponent of the remainder is measured."""

EXPONENT_TOLERANCE = 0.05
"""Amount by which a measured exponent may be below the promised one, because eps is finite."""

Values = Mapping[Symbol, Any]
Wave = Callable[..., Any]


@dataclass(frozen=True)
class Check:
    """One comparison: its name, what was compared, and whether it agreed."""

    name: str
    detail: str
    passed: bool

    def text(self) -> str:
        """Return the check in one line."""
        return f"{'agrees' if self.passed else 'DIFFERS'}: {self.name} ({self.detail})"


def numbers(symbols: Sequence[Symbol]) -> dict[Symbol, Rational]:
    """Return a positive rational number for each symbol.

    >>> numbers([Symbol("a"), Symbol("b")])
    {a: 30/23, b: 41/29}
    """
    denominators = (23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79)
    return {s: Rational(30 + 11 * i % 31, denominators[i % 14]) for i, s in enumerate(symbols)}


def simple_numbers(symbols: Sequence[Symbol]) -> dict[Symbol, Rational]:
    """Return a small prime for each symbol, so that few terms cancel.

    >>> simple_numbers([Symbol("a"), Symbol("b")])
    {a: 2, b: 3}
    """
    return dict(zip(symbols, cycle(map(Rational, primerange(44))), strict=False))


def checks_of_reduction(reduction: Reduction) -> list[Check]:
    """Check a plane wave, a manufactured wave and, for a chain, stress law and losses."""
    promised = reduction.highest_order + 1
    with mpmath.workdps(DIGITS):
        point = _Point(reduction)
        checks = [
            _falling("dispersion determinant", point.linear_remainder, promised),
            _falling("manufactured wave", point.manufactured_remainder, promised),
        ]
        if _has_static_law(reduction):
            checks.append(_static(reduction))
        if reduction.lattice.has_losses and reduction.lattice.dimension == 1:
            checks.append(_complex_frequency(reduction))
    return checks


def checks_of_envelope(envelope: Envelope) -> Iterator[Check]:
    """Yield a check of the decay, if there are losses, and of identities, unless k is fixed at pi.

    The identities p = omega''/2, a3 = omega'''/6 and a1 + a2 = -dq/dk hold exactly, as rational
    functions; the last two are checked only without losses.
    """
    if envelope.lattice.has_losses:
        with mpmath.workdps(DIGITS):
            yield _complex_carrier(envelope)
    if envelope.wavenumber == pi:
        return
    parts, carrier = envelope.parts, envelope.carrier
    z, w = carrier.field.symbols[:2]

    def slope(value: Any) -> Any:
        """Return -i times the k-derivative of ``value`` along the branch: d omega/dk = v."""
        return carrier.field(z) * value.diff(z) + parts["v"] * value.diff(w)

    identities = [("p = omega''/2", -2 * parts["p"], slope(parts["v"]))]
    if not envelope.lattice.has_losses:
        identities += [
            ("a3 = omega'''/6", 3 * parts["a3"], slope(parts["p"])),
            ("a1 + a2 = -dq/dk", parts["a1"] + parts["a2"], -slope(parts["q"])),
        ]
    for name, left, right in identities:
        yield Check(name, "exactly, for all k and constants", left == right)


def _complex_carrier(envelope: Envelope) -> Check:
    """Compare the complex frequencies of a carrier in the lattice and in the envelope equation."""
    lattice = envelope.carrier.lattice
    free = [s for s in lattice.basic_constants if s not in envelope.constants]
    basic = {**numbers(free), **envelope.constants}
    angle = 1 if envelope.wavenumber is None else None
    point = envelope.point(angle, None, {str(symbol): value for symbol, value in basic.items()})
    undamped, loss = -point["i omega"], evaluated(envelope.parts["loss"], point)
    values = lattice.with_defined(basic)

    def remainder(small: Any) -> Any:
        known = undamped - small**2 * loss
        phase = mpmath.mpc(0, 1) * point["k"]
        return _growth_near(known, lattice, values, small, phase) - known

    return _falling("complex frequency", remainder, 3)


def _falling(name: str, remainder: Callable[[Any], Any], promised: int) -> Check:
    first, second = map(mpmath.mpf, EPS_VALUES)
    remainders = abs(remainder(first)), abs(remainder(second))
    if not all(remainders):
        return Check(name, "nothing is left", passed=True)
    exponent = float(mpmath.log(remainders[0] / remainders[1]) / mpmath.log(first / second))
    detail = f"what is left falls as eps^{exponent:.2f}, promised {promised}"
    return Check(name, detail, exponent > promised - EXPONENT_TOLERANCE)


class _Point:
    """The lattice and its expansion at chosen constants; the caller sets the precision."""

    def __init__(self, reduction: Reduction) -> None:
        self.reduction = reduction
        self.lattice, self.scaling = reduction.lattice, reduction.scaling
        self.values = numbers(reduction.pde.flow.field.symbols)
        self.weights = {n: self._number(w.as_expr()) for n, (w, _) in reduction.slaved.items()}
        self.left = [self._number(value.as_expr()) for value in reduction.left]
        self.row, self.column = self.left.index(1), [*self.weights.values()].index(1)
        axes = range(len(self.scaling.axes))
        self.rates = [[Rational(3 + i, 7 + 2 * j) * (-1) ** (i * j) for j in axes] for i in (0, 1)]

    def _number(self, value: Expr, small: Any = 0) -> Any:
        return _number(value, self.values, small)

    def slow(self, cell: Sequence[int], time: Any, small: Any) -> list[Any]:
        """Return the slow variables at a cell and a time, for eps = ``small``."""
        slow = [
            small**v.exponent * (self._along(v, cell) - self._number(v.speed) * time)
            for v in self.scaling.space
        ]
        return [*slow, small**self.scaling.time * time]

    def _along(self, variable: SlowVariable, cell: Sequence[int]) -> Any:
        """Return the scalar product of a cell's position and a slow variable's direction."""
        steps = zip(variable.direction, cell, strict=True)
        return mpmath.fsum(self._number(d) * s for d, s in steps)

    def polynomial(self, part: DifferentialPolynomial, at: Sequence[Any]) -> Any:
        """Evaluate a polynomial in jets on the manufactured wave, at the slow variables ``at``."""
        rates = [[mpmath.mpf(r.p) / r.q for r in rate] for rate in self.rates]
        modes = [mpmath.exp(mpmath.fdot(rate, at)) / (2 + i) for i, rate in enumerate(rates)]

        def jet(counts: Sequence[int]) -> Any:
            return mpmath.fsum(
                mode * mpmath.fprod(r**n for r, n in zip(rate, counts, strict=True))
                for mode, rate in zip(modes, rates, strict=True)
            )

        return mpmath.fsum(
            self._number(value.as_expr()) * mpmath.fprod(jet(counts) for counts in monomial)
            for monomial, value in part.terms.items()
        )

    def field(self, name: str, cell: Sequence[int], time: Any, small: Any) -> Any:
        """Return the lattice field ``name`` in the manufactured wave at eps = ``small``."""
        at = self.slow(cell, time, small)
        background = self.scaling.background
        mean = mpmath.fsum(small**power * self._number(v, small) for power, v in background)
        zero = (0,) * len(self.scaling.axes)
        one = DifferentialPolynomial.monomial(self.reduction.pde.flow.field, (zero,))
        wave = small**self.scaling.amplitude * self.weights[name] * self.polynomial(one, at)
        parts = self.reduction.slaved[name][1].parts.items()
        return mean + wave + mpmath.fsum(small**o * self.polynomial(part, at) for o, part in parts)

    def manufactured_remainder(self, small: Any) -> Any:
        """Return the manufactured wave's largest residual in the equations of motion, eps = small.

        The derived orders are subtracted from the row that gives the reduced equation.
        """
        origin = (0,) * self.lattice.dimension
        names = self.lattice.fields
        rows = []
        for name, *values in zip(names, self.lattice.masses, self.lattice.site_losses, strict=True):
            mass, loss = (self._number(value, small) for value in values)

            def displacement(time: Any, name: str = name) -> Any:
                return self.field(name, origin, time, small)

            rows.append(mass * mpmath.diff(displacement, 0, 2))
            if loss:
                rows[-1] += loss * mpmath.diff(displacement, 0)
        for bond in self.lattice.bonds:
            loss = self._number(bond.loss, small)
            coefficients = [self._number(value, small) for value in bond.coefficients()]
            for end in bond.action:

                def stretch(time: Any, bond: Bond = bond, end: Stencil = end) -> Any:
                    return self._stretch(bond, end, time, small)

                force = mpmath.polyval(coefficients, stretch(0))
                if loss:
                    force += loss * mpmath.diff(stretch, 0)
                rows[end.field] -= end.weight * force
        at = self.slow(origin, 0, small)
        orders = self.reduction.orders.items()
        known = mpmath.fsum(small**order * self.polynomial(e.polynomial, at) for order, e in orders)
        remainder = mpmath.fdot(self.left, rows) - known
        return max([abs(remainder), *(abs(row) for i, row in enumerate(rows) if i != self.row)])

    def _stretch(self, bond: Bond, end: Stencil, time: Any, small: Any) -> Any:
        """Return the stretch of the bond whose force acts on cell 0 through ``end``."""
        names = self.lattice.fields
        cells = ([i + j for i, j in zip(e.shift, end.shift, strict=True)] for e in bond.stretch)
        pairs = zip(bond.stretch, cells, strict=True)
        return mpmath.fsum(e.weight * self.field(names[e.field], c, time, small) for e, c in pairs)

    def linear_remainder(self, small: Any) -> Any:
        """Return the plane wave's determinant in the linear lattice minus its derived expansion."""
        rates = [mpmath.mpc(0, 1) * mpmath.mpf(rate.p) / rate.q for rate in self.rates[0]]
        growth = rates[-1] * small**self.scaling.time
        pairs = zip(rates, self.scaling.space, strict=False)
        scaled = [(rate * small**v.exponent, v) for rate, v in pairs]
        for rate, variable in scaled:
            growth -= rate * self._number(variable.speed)

        def turn(steps: Sequence[int]) -> Any:
            return mpmath.fsum(rate * self._along(v, steps) for rate, v in scaled)

        count = len(self.lattice.fields)
        number = partial(_number, values=self.values, small=small)
        matrix = _matrix(self.lattice, number, growth, turn, self.scaling.mean)
        sign = (-1) ** (self.row + self.column)
        minor = mpmath.mpf(1)
        if count > 1:
            rows, columns = ([i for i in range(count) if i != o] for o in (self.row, self.column))
            minor = mpmath.det(mpmath.matrix([[matrix[i, j] for j in columns] for i in rows]))
        ratio = sign * mpmath.det(matrix) / minor * small**self.scaling.amplitude
        linear = mpmath.fsum(
            small**order
            * self._number(value.as_expr())
            * mpmath.fprod(r**n for r, n in zip(rates, monomial[0], strict=True))
            for order, equation in self.reduction.orders.items()
            for monomial, value in equation.polynomial.terms.items()
            if len(monomial) == 1
        )
        return ratio - linear


def _number(value: Expr, values: Values, small: Any = 0) -> Any:
    """Evaluate an expression at the ``values`` of its symbols and eps = ``small``."""
    number = value.xreplace(dict(values))
    powers = number.as_poly(eps).all_coeffs() if number.has(eps) else [number]
    return mpmath.polyval([mpmath.mpf(power.evalf(DIGITS)) for power in powers], small)


def _matrix(
    lattice: Lattice, number: Callable[[Expr], Any], growth: Any, turn: Wave, mean: Expr = S.Zero
) -> Any:
    """Return the matrix of the linear lattice about a mean, at a plane wave ``exp(growth t)``.

    A shift by ``steps`` cells along the axes multiplies the wave by ``exp(turn(steps))``;
    ``number`` evaluates constants of the lattice.
    """
    pairs = zip(lattice.masses, lattice.site_losses, strict=True)
    inertia = [number(mass) * growth**2 + number(loss) * growth for mass, loss in pairs]
    matrix = mpmath.diag(inertia)
    for bond in lattice.bonds:
        about = mean * sum(entry.weight for entry in bond.stretch)
        slope = number(bond.stiffness(about).expand()) + number(bond.loss) * growth
        for end in bond.action:
            for part in bond.stretch:
                steps = [i + j for i, j in zip(end.shift, part.shift, strict=True)]
                force = end.weight * part.weight * slope * mpmath.exp(turn(steps))
                matrix[end.field, part.field] -= force
    return matrix


def _complex_frequency(reduction: Reduction) -> Check:
    """Compare the complex frequencies of a long wave in the lattice and in the reduced equation."""
    values, coefficients = _admissible(reduction)
    scaling = reduction.scaling
    rate = mpmath.mpc(0, 1) * mpmath.mpf(3) / 7
    linear = {name: m[0][0] for name, m in coefficients.monomials.items() if len(m) == 1}
    values_of_terms = ((coefficients.terms[name].evalf(DIGITS), n) for name, n in linear.items())
    slow = -mpmath.fsum(mpmath.mpf(value) * rate**count for value, count in values_of_terms)
    [variable] = scaling.space
    [direction] = variable.direction

    def remainder(small: Any) -> Any:
        along = rate * small**variable.exponent
        known = small**scaling.time * slow - along * mpmath.mpf(coefficients.c.evalf(DIGITS))
        phase = along * direction
        return _growth_near(known, reduction.lattice, values, small, phase, scaling.mean) - known

    return _falling("complex frequency", remainder, scaling.time + 1)


def _growth_near(
    near: Any, lattice: Lattice, values: Values, small: Any, phase: Any, mean: Expr = S.Zero
) -> Any:
    """Return the growth rate close to ``near`` of a wave with the factor exp(phase) per cell."""

    def determinant(growth: Any) -> Any:
        def turn(steps: Sequence[int]) -> Any:
            return phase * steps[0]

        number = partial(_number, values=values, small=small)
        return mpmath.det(_matrix(lattice, number, growth, turn, mean))

    steps = (near, near * (1 + mpmath.mpf("1e-20")))
    return mpmath.findroot(determinant, steps, tol=mpmath.mpf(10) ** -DIGITS, verify=False)


def _has_static_law(reduction: Reduction) -> bool:
    """Return whether a chain has a static stress that depends on the strain only, not on eps."""
    definitions = dict(reduction.lattice.definitions)
    forces = (value for bond in reduction.lattice.bonds for value in bond.coefficients())
    scaled = any(value.xreplace(definitions).has(eps) for value in forces)
    return reduction.lattice.dimension == 1 and not reduction.scaling.background and not scaled


def _static(reduction: Reduction) -> Check:
    """Compare the speeds of long waves on a uniform strain in the lattice and in the equation."""
    values, coefficients = _admissible(reduction)
    powers = {"Y_X": 0, "Y Y_X": 1, "Y^2 Y_X": 2}
    shifts = {powers[name]: value for name, value in coefficients.terms.items() if name in powers}
    highest = max(shifts, default=0)

    def remainder(strain: Any) -> Any:
        waves = _sound(reduction.lattice, values, strain)
        terms = (mpmath.mpf(v.evalf(DIGITS)) * strain**power for power, v in shifts.items())
        return waves - (mpmath.mpf(coefficients.c.evalf(DIGITS)) + mpmath.fsum(terms))

    return _falling("static stress law", remainder, highest + 1)


def _admissible(reduction: Reduction) -> tuple[dict[Symbol, Expr], Coefficients]:
    """Return constants that meet the conditions, and the equation's coefficients for them."""
    constants, definitions = reduction.lattice.basic_constants, dict(reduction.lattice.definitions)
    chosen: dict[Symbol, Expr] = dict(numbers(constants))
    for condition in reduction.conditions:
        speed = {reduction.scaling.frame_symbol: sqrt(reduction.speed_squared)}
        vanishing = condition.expression.xreplace(speed).xreplace(definitions)
        candidates = [symbol for symbol in constants if vanishing.has(symbol)]
        if candidates:
            others = {s: value for s, value in chosen.items() if s != candidates[-1]}
            chosen[candidates[-1]] = solve(vanishing.xreplace(others), candidates[-1])[0]
    coefficients = reduction.coefficients(**{str(symbol): v for symbol, v in chosen.items()})
    return reduction.lattice.with_defined(chosen), coefficients


def _sound(lattice: Lattice, values: Values, strain: Any) -> Any:
    """Return the speed of long waves on a uniform ``strain``, from the static stress-strain law."""
    masses = [mpmath.mpf(mass.xreplace(dict(values)).evalf(DIGITS)) for mass in lattice.masses]
    forces = [_law(bond, values) for bond in lattice.bonds]
    if any(sum(entry.weight for entry in bond.stretch) for bond in lattice.bonds):
        return mpmath.sqrt(
            mpmath.fsum(
                entry.weight * end.weight * mpmath.mpf(entry.shift[0] + end.shift[0]) ** 2 / 2
                * mpmath.diff(law, strain * sum(e.weight for e in bond.stretch))
                for bond, law in zip(lattice.bonds, forces, strict=True)
                for end in bond.action
                for entry in bond.stretch
            )
            / masses[0]
        )  # fmt: skip

    def stretch(bond: Bond, size: Any, inner: Sequence[Any]) -> Any:
        positions = [mpmath.mpf(0), *inner]
        ends = bond.stretch
        return mpmath.fsum(e.weight * (size * e.shift[0] + positions[e.field]) for e in ends)

    def unbalanced(size: Any, inner: Sequence[Any]) -> list[Any]:
        rows = [mpmath.mpf(0)] * len(masses)
        for bond, law in zip(lattice.bonds, forces, strict=True):
            for end in bond.action:
                rows[end.field] += end.weight * law(stretch(bond, size, inner))
        return rows[1:]

    def stress(size: Any) -> Any:
        inner: list[Any] = []
        if len(masses) > 1:
            start = [mpmath.mpf(0)] * (len(masses) - 1)
            inner = list(mpmath.findroot(lambda *found: unbalanced(size, found), start))
        return mpmath.fsum(
            law(stretch(bond, size, inner)) * sum(e.weight * e.shift[0] for e in bond.stretch)
            for bond, law in zip(lattice.bonds, forces, strict=True)
        )

    return mpmath.sqrt(mpmath.diff(stress, strain) / mpmath.fsum(masses))


def _law(bond: Bond, values: Values) -> Wave:
    """Return the force of a bond as a function of its stretch, at ``values`` of the constants."""
    exact_coefficients = [c.xreplace(dict(values)) for c in bond.coefficients()]
    coefficients = [mpmath.mpf(value.evalf(DIGITS)) for value in exact_coefficients]
    return lambda stretch: mpmath.polyval(coefficients, stretch)

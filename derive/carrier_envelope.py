"""The envelope equation of a carrier wave: ``i A_T + p A_XX + q |A|^2 A = 0``, and its next order.

``f_n = eps (A(X, T) exp(i (k n - omega t)) + c.c.) + ...`` with ``X = eps (n - v t)`` and
``T = eps^2 t``; A is the amplitude of the lattice's first field that the carrier moves.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from math import nan
from typing import Any

import mpmath
from sympy import Expr, I, S, Symbol, cos, pi, simplify, sin, sqrt

from longwave.derive.algebra.exact_numbers import Number, instance, parse_rational
from longwave.derive.algebra.formula_expression import exact_value
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.derive.amplitude_law import AmplitudeLaw, amplitude_law
from longwave.derive.carrier import NLS, Carrier, EnvelopeError, at_rest, w, z
from longwave.derive.lattice import Lattice
from longwave.derive.normal_form import NormalForm, normal_form_of
from longwave.derive.output.notation import Displayed, Printed, idle_loss, latex_of, text_of
from longwave.derive.sines import cosine, frequency, in_sines, omega, sine
from longwave.derive.symbols import k, values_of
from longwave.support.user_files import shown

DIGITS = 60
"""Of the numbers at a given wavenumber, before they are rounded."""

GUARD = 20
"""Further digits that are carried; a cancellation costs some."""

RESONANT = 1e-40
"""A denominator so small, beside the sum of its terms without their signs, is taken for 0."""

ROUNDING = 1e-12
"""An imaginary part so small, beside the whole, is none."""

TURNS = {S.Zero: 1, pi: -1}
"""exp(i k) of the wavenumbers that it is a whole number of."""

MOST_TERMS = 2500
"""Terms of a coefficient that is written as a formula. One of 1900 took 2 s and has 36 000
characters; one of 27 000, a dimer's with eight symbols, took minutes."""

MOST_SIMPLIFIED = 1000
"""Terms of a coefficient in which the sines of a fraction of pi are multiplied out."""

NEXT_ORDER = ("a3", "a1", "a2")
"""Coefficients of the order behind the NLS equation."""

_MAPPED = ("v", "p", "q")
"""The coefficients that the normal form depends on."""

IMAGINARY = ("p", "q", "detuning")
"""Coefficients that stand behind an i in ``A_T = i p A_XX + i q |A|^2 A + i detuning S A``."""


@dataclass(frozen=True)
class EnvelopeNumbers:
    """The coefficients at one wavenumber.

    ``omega`` and ``v``: frequency and group velocity.  ``p``, ``q``: those of the NLS equation.
    ``mean``: the mean is ``eps^2 mean |A|^2`` (in a lattice of displacements, that of the strain of
    a cell).  ``second``: the second harmonic is ``eps^2 second A^2``, complex where it is shifted
    against the carrier.  ``detuning``: a mean ``eps^2 S`` of the lattice's own adds
    ``detuning S A`` to the left of the NLS equation; 0 where the lattice is tied to its place.
    ``a3``, ``a1``, ``a2``: those of
    ``G1 = a3 A_3 + a1 |A|^2 A_1 + a2 A^2 conj(A_1)`` with ``A_m = (-i d/dX)^m A``, in
    ``i A_T = p A_2 - q |A|^2 A + eps G1``; nan with losses.  ``loss``: the rate at which these damp
    a plane wave, ``A_T = -loss A + ...``.
    """

    omega: float
    v: float
    p: float
    q: float
    mean: float
    second: complex
    a3: float
    a1: complex
    a2: complex
    detuning: float
    loss: float = 0.0

    @property
    def is_focusing(self) -> bool:
        """Whether the plane wave is unstable and bright solitons exist: p q > 0."""
        return self.p * self.q > 0

    def growth_rate(self, amplitude: float) -> float:
        """The largest growth rate in T of the plane wave |A| = amplitude; 0 where it is stable."""
        return abs(self.q) * amplitude**2 if self.is_focusing else 0.0


@dataclass(frozen=True, repr=False)
class Envelope(Displayed):
    """The envelope equation of a carrier, in k, omega and the lattice's constants.

    The dispersion relation has been used to eliminate one of them, ``carrier.fixed``.
    """

    lattice: Lattice
    wavenumber: Expr
    branch: int
    constants: Mapping[Symbol, Expr]
    carrier: Carrier = field(compare=False)

    @cached_property
    def parts(self) -> Mapping[str, RationalFunction]:
        """The coefficients as rational functions of z and w; p and q times i."""
        found = self.carrier
        A, B, A_X, B_X, A_XX, A_XXX = (0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (3, 0)
        first, second = (found.flow.at(power) for power in (0, 1))
        squared = found.parts[found.leader].at(2)
        mean = found.means[0] if found.means else squared
        for part, known in (
            (first, {(A,), (A_XX,), (A, A, B)}),
            (second, {(A_XXX,), (A, B, A_X), (A, A, B_X)}),
        ):
            if not part.terms.keys() <= known:
                raise EnvelopeError(f"G must be that of an NLS equation, got {part.terms.keys()}")
        next_order = {
            "a3": second.coefficient(A_XXX),
            "a1": -second.coefficient(A, B, A_X),
            "a2": second.coefficient(A, A, B_X),
        }
        return {
            "v": found.group_velocity,
            "p": first.coefficient(A_XX),
            "q": first.coefficient(A, A, B),
            "mean": mean.coefficient(A, B),
            "second": squared.coefficient(A, A),
            **({} if self.lattice.has_losses else next_order),
            "detuning": found.detuning,
            **({"loss": -first.coefficient(A)} if self.lattice.has_losses else {}),
        }

    @property
    def leading_field(self) -> str:
        """The field whose amplitude is A."""
        return self.lattice.fields[self.carrier.leader]

    @property
    def waves(self) -> int:
        """The number of factors of the dispersion relation, of which the formulas solve one."""
        return len(self.carrier.waves)

    def frequency_text(self, printed: Printed = text_of) -> str:
        """The factor of the dispersion relation that the formulas solve, an equation of omega."""
        parts = self.carrier.wave.powers_of(w)
        squared = frequency**2 if omega in self.lattice.constants else omega**2
        if parts.keys() == {0, 2}:
            value = (parts[0] / parts[2]).factored().xreplace(self.constants)
            return f"{printed(squared)} = {printed(value)}"
        rest = sum((v.as_expr() * (-squared) ** (power // 2) for power, v in parts.items()), S.Zero)
        return f"{printed(rest.xreplace(self.constants))} = 0"

    @property
    def equation(self) -> str:
        """The equation in plain text."""
        return f"i A_T + p A_XX + q |A|^2 A{' + i loss A' if self.lattice.has_losses else ''} = 0"

    @property
    def equation_latex(self) -> str:
        """The equation in LaTeX, without delimiters."""
        return self.equation.replace("A_XX", "A_{XX}").replace("loss", COEFFICIENT_LATEX["loss"])

    @property
    def amplitude_law(self) -> AmplitudeLaw:
        """The decay of a bright soliton's crest |A|, in the coefficient ``loss``."""
        return amplitude_law(2, S.One, Symbol("loss", positive=True), S.Zero)

    @property
    def idle_losses(self) -> tuple[str, ...]:
        """The losses without a term in the equation, a line for each kind."""
        losses = self.lattice.leading_losses.items()
        return tuple(idle_loss(kind, value) for kind, (value, power) in losses if power > NLS - 1)

    @cached_property
    def expressions(self) -> Mapping[str, Expr]:
        """The coefficients in sin(k/2), cos(k/2), omega and the lattice's constants."""
        return self.expressions_of(self.parts)

    def expressions_of(self, names: Iterable[str]) -> dict[str, Expr]:
        """Some of them; EnvelopeError where one has more than `MOST_TERMS`."""
        sizes = {name: self.parts[name].size for name in names}
        longest = max(sizes, key=sizes.__getitem__)
        if sizes[longest] > MOST_TERMS:
            short = all(sizes[name] <= MOST_TERMS for name in sizes if name not in NEXT_ORDER)
            unknown = [str(s) for s in self.lattice.constants if s not in self.constants]
            raise EnvelopeError(
                f"formulas must have at most {MOST_TERMS} terms, got {sizes[longest]} in "
                f"{longest} (give numbers for some of {', '.join(unknown)}, as {unknown[0]}=1"
                f"{', or take --order 3, without the next order' if short else ''})"
            )
        return {
            name: self._expression(self.parts[name]) * (-I if name in IMAGINARY else 1)
            for name in sizes
        }

    def _expression(self, element: RationalFunction) -> Expr:
        angle = k if self.wavenumber is None else self.wavenumber
        actual = {sine: sin(angle / 2), cosine: cos(angle / 2), **self.constants}
        if omega.name not in map(str, self.lattice.constants):
            actual[frequency] = omega
        real, imaginary = (part.subs(actual) for part in in_sines(element))
        found = real + I * imaginary
        is_exact = self.wavenumber is None or self.wavenumber in TURNS
        algebraic = not is_exact and (self.wavenumber / pi).is_Rational
        return simplify(found) if algebraic and element.size <= MOST_SIMPLIFIED else found

    def coefficients(
        self, k: Number | None = None, branch: str | int | None = None, **constants: Number
    ) -> EnvelopeNumbers:
        """The coefficients at a wavenumber and values of all constants.

        Raises EnvelopeError (a ValueError) at a resonance, and ValueError for a wavenumber outside
        of 0 <= k <= pi, constants that are missing or unknown, and an unstable lattice.
        """
        found = self.regular(k, branch, **constants)._numbers(k, branch, constants)
        numbers = {name: _plain(value) for name, value in found.items()}
        return EnvelopeNumbers(**{**dict.fromkeys(NEXT_ORDER, nan), **numbers})

    def normal_form(
        self, k: Number | None = None, branch: str | int | None = None, **constants: Number
    ) -> NormalForm:
        """The map to ``i U_tau + U_xixi + 2 s |U|^2 U = 0``; arguments as for coefficients.

        With one field in a cell the values are exact, with several they are those of the lattice to
        `DIGITS` digits.  Without a wavenumber and constants they are expressions in those.  Raises
        what coefficients does, and ValueError where q vanishes.

        >>> from longwave.derive import LATTICES
        >>> envelope(LATTICES["fput_strain"], k=pi).normal_form(K2=1, K3=0, K4=1)
        NormalForm(a=1, b=-1/4, s=1, c=0, equation=NLS, h=sqrt(6)/6)
        """
        if self.lattice.has_losses:
            raise EnvelopeError(
                f"lattice must have no losses for a normal form, got {self.equation} (what damps "
                "the wave cannot be scaled away: take the lattice without them)"
            )
        if self.wavenumber is None and k is None and not constants and not self.constants:
            return _nls_form(self.expressions_of(_MAPPED))
        regular = self.regular(k, branch, **constants)
        found = regular._numbers(k, branch, constants)
        if abs(found["q"]) <= RESONANT:
            return _nls_form({**dict.fromkeys(_MAPPED, S.One), "q": S.Zero})
        if len(self.lattice.fields) == 1:
            chosen = self.wavenumber if k is None else wavenumber(k)
            return _nls_form(regular._exact_numbers(chosen, regular._values(constants)))
        texts = {name: mpmath.nstr(found[name].real, DIGITS) for name in _MAPPED}
        return _nls_form({n: parse_rational(n, text) for n, text in texts.items()}, DIGITS)

    @property
    def in_constants(self) -> dict[str, Expr]:
        """omega and the real coefficients in k and the lattice's constants, of one field in a cell.

        >>> from longwave.derive import LATTICES
        >>> envelope(LATTICES["beta_fput"], k=pi).in_constants["q"]
        -12*K4/sqrt(K2)
        """
        angle = k if self.wavenumber is None else self.wavenumber
        return self._exact_numbers(angle, self.carrier.lattice.with_defined(self.constants))

    def _exact_numbers(self, angle: Expr, values: Mapping[Symbol, Expr]) -> dict[str, Expr]:
        """omega and the real coefficients where the dispersion relation is linear in omega^2."""
        relation = self.carrier.relation.powers_of(w)
        at = {sine: sin(angle / 2), cosine: cos(angle / 2), **values}
        at[frequency] = sqrt(in_sines(relation[0] / relation[2])[0].subs(at))
        found = {"omega": at[frequency]}
        for name, value in self.parts.items():
            real, imaginary = (part.subs(at) for part in in_sines(value))
            if (real if name in IMAGINARY else imaginary) == 0:
                found[name] = imaginary if name in IMAGINARY else real
        return found

    def _values(self, constants: Mapping[str, Number]) -> dict[Symbol, Expr]:
        lattice = self.carrier.lattice
        known = {*self.lattice.constants, *lattice.basic_constants}
        names = {str(s): s for s in sorted(known, key=str)}
        given = {str(symbol): value for symbol, value in self.constants.items()} | {**constants}
        values = values_of(given, names, self.lattice.name)
        lattice.check_values({symbol: value for symbol, value in values.items() if value == 0})
        used = names.keys() - {str(s) for s, _ in lattice.definitions}
        missing = sorted(used - given.keys())
        if missing:
            raise ValueError(f"{missing[0]} must be given, got none (a number, as {missing[0]}=1)")
        return lattice.with_defined(values)

    def point(
        self, k: Number | None, branch: str | int | None, constants: Mapping[str, Number]
    ) -> dict[str, mpmath.mpc]:
        """exp(i k), i omega, k and the constants by name, to `DIGITS` digits."""
        chosen = self.wavenumber if k is None else wavenumber(k)
        if chosen is None:
            raise ValueError("k must be given, got none (a wavenumber, as 1 or pi)")
        values = self._values(constants)
        number = self.branch if branch is None else _branch(branch, self.lattice)
        with mpmath.workdps(DIGITS + GUARD):
            angle = mpmath.mpf(chosen.evalf(DIGITS + GUARD))
            point = {str(s): mpmath.mpf(v.evalf(DIGITS + GUARD)) for s, v in values.items()}
            point[str(z)] = mpmath.mpc(TURNS.get(chosen) or mpmath.expj(angle))
            point["k"] = angle
            return {**point, str(w): 1j * _frequency(self.carrier, point, number)}

    def regular(
        self, k: Number | None = None, branch: str | int | None = None, **constants: Number
    ) -> Envelope:
        """The envelope in the amplitude of the first field that moves; arguments as `coefficients`.

        It is this one, unless its first field is at rest at this point, or its formulas are those
        of another wave or 0/0 there.  Raises EnvelopeError where two branches meet.
        """
        point = self.point(k, branch, constants)
        if self._holds(point):
            return self
        chosen = self.wavenumber if k is None else wavenumber(k)
        values = {s: v for s, v in self._values(constants).items() if v.is_Rational}
        for leader in range(len(self.lattice.fields)):
            found = replace(self, carrier=_led(self.lattice, chosen, leader, values))
            if found._holds(point := found.point(k, branch, constants)):
                found.carrier.solve()
                return found
        raise EnvelopeError(_meeting(f"k = {mpmath.nstr(point['k'], 8)}"))

    def _holds(self, point: Mapping[str, mpmath.mpc]) -> bool:
        """Whether the formulas are those of the point's wave, and its leading field moves."""
        with mpmath.workdps(DIGITS + GUARD):
            is_wave = evaluated(1 / self.carrier.wave, point) is None
            return is_wave and all(evaluated(s, point) is not None for s in self.carrier.singular)

    def _numbers(
        self, k: Number | None, branch: str | int | None, constants: Mapping[str, Number]
    ) -> dict[str, mpmath.mpc]:
        """omega and all coefficients at a wavenumber, to `DIGITS` digits."""
        with mpmath.workdps(DIGITS + GUARD):
            return self._at(self.point(k, branch, constants))

    def _at(self, point: Mapping[str, mpmath.mpc]) -> dict[str, mpmath.mpc]:
        """The same at these values; the digits are set.

        A sum that vanishes leaves the rounding of its terms, which is 0: the group velocity where
        a band is flat, at k = 2 pi/3 of a chain with springs to the next but one, say.
        """
        if evaluated(self.carrier.second_harmonic, point) is None:
            raise EnvelopeError(_resonance("4 omega(k)^2 = omega(2k)^2", point))
        found: dict[str, mpmath.mpc] = {"omega": point[str(w)].imag}
        for name, element in self.parts.items():
            value = evaluated(element, point)
            if value is None:
                raise EnvelopeError(_resonance("the group velocity is the sound speed", point))
            is_none = abs(value) < mpmath.mpf(10) ** -DIGITS * abs(point[str(w)])
            found[name] = 0 * value if is_none else value / 1j if name in IMAGINARY else value
        if abs(found["p"]) < ROUNDING * abs(point[str(w)]):
            raise EnvelopeError(
                f"k must be no zero of the dispersion p, got {mpmath.nstr(point['k'], 8)} "
                "(there the third derivative of omega takes its place)"
            )
        return found

    def text(self) -> str:
        """The equation and p and q, in plain text."""
        p, q = map(text_of, self.expressions_of(("p", "q")).values())
        return f"{self.lattice.name}: {self.equation}, p = {p}, q = {q}"

    def latex(self) -> str:
        """The equation and its coefficients in LaTeX, without delimiters."""
        rows = [self.equation_latex]
        rows += [
            f"{COEFFICIENT_LATEX[name]} = {latex_of(value)}"
            for name, value in self.expressions.items()
        ]
        return r",\quad ".join(rows)


COEFFICIENT_LATEX = {
    "omega": r"\omega", "v": "v", "p": "p", "q": "q", "mean": "b_0", "second": "b_2",
    "a3": "a_3", "a1": "a_1", "a2": "a_2", "detuning": r"\delta", "loss": r"\lambda",
}  # fmt: skip


def _nls_form(found: Mapping[str, Expr], digits: int | None = None) -> NormalForm:
    v, p, q = (found[name] for name in _MAPPED)
    return normal_form_of(v, {"A_XX": p, "|A|^2 A": q}, digits)


def envelope(
    lattice: Lattice, k: Number | None = None, branch: str | int = 0, **constants: Number
) -> Envelope:
    """The envelope equation of a chain's carrier waves.

    ``k`` is the wavenumber in radians a cell, 0 <= k <= pi; without it the coefficients are
    functions of k.  ``branch`` is "acoustic", "optical" or its number from below.  Constants that
    are given are put in beforehand, which is faster.  Raises EnvelopeError (a ValueError) where
    there is no NLS equation.

    >>> from longwave.derive import LATTICES
    >>> found = envelope(LATTICES["fput_strain"], k=pi)
    >>> found.expressions["p"], found.expressions["v"]
    (-omega/8, 0)
    """
    instance("lattice", lattice, Lattice, "LATTICES['fput_strain'] is one")
    if lattice.dimension != 1:
        raise ValueError(f"lattice must have one axis, got {lattice.dimension} (take a chain)")
    chosen = None if k is None else wavenumber(k)
    number = _branch(branch, lattice)
    names = {str(symbol): symbol for symbol in lattice.constants}
    values = values_of(constants, names, lattice.name)
    carrier = Carrier(lattice, turn=TURNS.get(chosen), wave=number, values=values)
    carrier.solve()
    return Envelope(lattice, chosen, number, values, carrier)


def _led(
    lattice: Lattice, chosen: Expr | None, leader: int, values: Mapping[Symbol, Expr]
) -> Carrier:
    """The carrier of a field's amplitude, not yet solved."""
    return Carrier(lattice, turn=TURNS.get(chosen), leader=leader, values=values)


def modulation_map(
    lattice: Lattice,
    wavenumbers: Sequence[Number],
    branch: str | int = 0,
    amplitude: float = 1.0,
    **constants: Number,
) -> list[tuple[float, EnvelopeNumbers | None, float]]:
    """For each wavenumber: k, the coefficients, and the largest growth rate of the plane wave.

    The coefficients are None at a resonance.
    """
    found = envelope(lattice, branch=branch, **constants)
    rows: list[tuple[float, EnvelopeNumbers | None, float]] = []
    for given in wavenumbers:
        try:
            numbers: EnvelopeNumbers | None = found.coefficients(given, branch, **constants)
        except EnvelopeError:
            numbers = None
        rate = numbers.growth_rate(amplitude) if numbers else 0.0
        rows.append((float(wavenumber(given)), numbers, rate))
    return rows


def wavenumber(k: Number) -> Expr:
    """A wavenumber exactly; ValueError unless it is in 0 <= k <= pi."""
    value = exact_value("k", k)
    if value.free_symbols or not 0 <= value <= pi:
        raise ValueError(f"k must satisfy 0 <= k <= pi, got {shown(k)} (radians a cell)")
    return value


def _branch(branch: str | int, lattice: Lattice) -> int:
    count = len(lattice.fields)
    number = (
        {"acoustic": 0, "optical": count - 1}.get(branch) if isinstance(branch, str) else branch
    )
    if number is None or isinstance(number, bool) or not 0 <= number < count:
        raise ValueError(
            f"branch must be acoustic, optical or a number below {count}, got {shown(branch)} "
            f"({lattice.name} has {count} {'branch' if count == 1 else 'branches'})"
        )
    return number


def _frequency(carrier: Carrier, at: Mapping[str, mpmath.mpc], number: int) -> mpmath.mpf:
    """omega of the branch at a wavenumber, from the determinant, a polynomial in omega^2."""
    powers = carrier.relation.powers_of(w).items()
    parts: dict[int, Any] = {power: evaluated(part, at) for power, part in powers}
    highest = max(parts)
    phase = mpmath.conj(parts[highest]) / abs(parts[highest])
    polynomial = [
        (parts.get(power, mpmath.mpf(0)) * phase * (-1) ** ((highest - power) // 2)).real
        for power in range(highest, -1, -2)
    ]
    at_k = f"k = {mpmath.nstr(mpmath.arg(at[str(z)]), 8)}"
    try:
        roots = sorted(mpmath.polyroots(polynomial, maxsteps=200, extraprec=200), key=mpmath.re)
    except mpmath.mp.NoConvergence:  # of roots that are the same
        raise ValueError(_meeting(at_k)) from None
    found = roots[number]
    if abs(found) <= RESONANT * abs(roots[-1]):
        raise EnvelopeError(at_rest(f" at {at_k}"))
    if abs(found.imag) > ROUNDING * abs(found) or found.real <= 0:
        raise ValueError(
            f"constants must give a real frequency, got omega^2 = {mpmath.nstr(found, 8)} at "
            f"{at_k} (the lattice must be stable)"
        )
    return mpmath.sqrt(found.real)


def _meeting(at: str) -> str:
    return (
        f"k must leave the branches apart, got {at}, where two have one frequency (take another "
        "k, or constants that part them)"
    )


def _plain(value: mpmath.mpc) -> Any:
    """A float where the imaginary part is a rounding error; a real part that is one is 0."""
    least = ROUNDING * abs(value)
    number = mpmath.mpc(value)
    real, imaginary = (part if abs(part) > least else 0 for part in (number.real, number.imag))
    return complex(real, imaginary) if imaginary else float(real)


def evaluated(element: RationalFunction, at: Mapping[str, mpmath.mpc]) -> mpmath.mpc | None:
    """The element at a point; None where its denominator vanishes."""
    gens = [str(symbol) for symbol in element.field.symbols]
    power = cache(lambda name, exponent: at[name] ** exponent)  # one stands in many terms
    sums = []
    for line in (False, True):
        terms = [
            mpmath.fprod(power(g, e) for g, e in zip(gens, exponents, strict=True) if e) * value
            for exponents, value in element.terms(below=line)
        ]
        size = mpmath.fsum(terms, absolute=True)
        total = mpmath.fsum(terms)
        sums.append((total, abs(total) <= RESONANT * size))
    (above, _), (below, vanishes) = sums
    return None if vanishes else above / below


def _resonance(words: str, point: Mapping[str, mpmath.mpc]) -> str:
    return (
        f"k must be no resonance, got {mpmath.nstr(point['k'], 8)}, where {words} "
        "(the two waves interact at the order of the envelope: take another wavenumber)"
    )

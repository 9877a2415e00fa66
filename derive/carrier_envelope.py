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
from longwave.derive.algebra.formula_printing import Printed, latex_of, text_of
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.derive.amplitude_law import AmplitudeLaw, amplitude_law
from longwave.derive.carrier import NLS, Carrier, EnvelopeError, at_rest, w, z
from longwave.derive.lattice import Lattice
from longwave.derive.normal_form import NormalForm, normal_form_of
from longwave.derive.output.notation import Displayed, idle_loss
from longwave.derive.sines import cosine, frequency, in_sines, omega, sine
from longwave.derive.symbols import k, values_of
from longwave.support.user_files import shown

DIGITS, GUARD_DIGITS = 60, 20
"""Digits of the numbers at a given wavenumber, before they are rounded to doubles, and additional
working digits, some of which may be lost to cancellation."""

ZERO_TOLERANCE = 1e-40
"""Magnitude below which a denominator counts as 0, relative to the sum of its terms' magnitudes."""

IMAGINARY_TOLERANCE = 1e-12
"""Magnitude below which an imaginary part counts as 0, relative to the complex number's."""

INTEGER_PHASES = {S.Zero: 1, pi: -1}
"""Wavenumber k -> exp(i k), for those k at which exp(i k) is an integer."""

MOST_TERMS = 2500
"""Most terms of a coefficient that is written as a formula. One of 1900 took 2 s and has 36 000
characters; one of 27 000, a dimer's with eight symbols, took minutes."""

MOST_SIMPLIFIED = 1000
"""Largest number of terms of a coefficient in which sines of fractions of pi are simplified."""

NEXT_ORDER = ("a3", "a1", "a2")
"""Names of the coefficients in G1, the order beyond the NLS equation."""

_NORMAL_FORM_NAMES = ("v", "p", "q")
"""Coefficients that determine the normal form."""

IMAGINARY = ("p", "q", "detuning")
"""Coefficients with a factor i in ``A_T = i p A_XX + i q |A|^2 A + i detuning S A``."""


@dataclass(frozen=True)
class EnvelopeNumbers:
    """Coefficients of the envelope equation at one wavenumber.

    ``omega``, ``v``: frequency and group velocity.  ``p``, ``q``: coefficients of the NLS equation.
    ``mean``: the mean is ``eps^2 mean |A|^2`` (for displacements, the mean of a cell's strain).
    ``second``: the second harmonic is ``eps^2 second A^2``, complex if its phase differs from the
    carrier's.  ``detuning``: an independent mean ``eps^2 S`` adds ``detuning S A`` to the left of
    the NLS equation; 0 if the lattice is pinned.  ``a3``, ``a1``, ``a2``: the next order, ``i A_T =
    p A_2 - q |A|^2 A + eps (a3 A_3 + a1 |A|^2 A_1 + a2 A^2 conj(A_1))`` with ``A_m = (-i d/dX)^m
    A``; nan with losses.  ``loss``: the decay rate of a plane wave by losses, ``A_T = -loss A +
    ...``.
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
        """Return the plane wave's largest growth rate in T for |A| = amplitude; 0 if stable."""
        return abs(self.q) * amplitude**2 if self.is_focusing else 0.0


@dataclass(frozen=True, repr=False)
class Envelope(Displayed):
    """The envelope equation of a carrier: coefficients in k, omega and the lattice's constants.

    The dispersion relation has been used to eliminate one constant, ``carrier.fixed``.
    """

    lattice: Lattice
    wavenumber: Expr
    branch: int
    constants: Mapping[Symbol, Expr]
    carrier: Carrier = field(compare=False)

    @cached_property
    def parts(self) -> Mapping[str, RationalFunction]:
        """The coefficients as rational functions of z and w, those in `IMAGINARY` times i."""
        carrier = self.carrier
        A, B, A_X, B_X, A_XX, A_XXX = (0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (3, 0)
        first, second = (carrier.flow.at(power) for power in (0, 1))
        squared = carrier.parts[carrier.leader].at(2)
        mean = carrier.means[0] if carrier.means else squared
        for part, jets in (
            (first, {(A,), (A_XX,), (A, A, B)}),
            (second, {(A_XXX,), (A, B, A_X), (A, A, B_X)}),
        ):
            if not part.terms.keys() <= jets:
                raise EnvelopeError(f"G must have the terms of NLS only, got {part.terms.keys()}")
        next_order = {
            "a3": second.coefficient(A_XXX),
            "a1": -second.coefficient(A, B, A_X),
            "a2": second.coefficient(A, A, B_X),
        }
        return {
            "v": carrier.group_velocity,
            "p": first.coefficient(A_XX),
            "q": first.coefficient(A, A, B),
            "mean": mean.coefficient(A, B),
            "second": squared.coefficient(A, A),
            **({} if self.lattice.has_losses else next_order),
            "detuning": carrier.detuning,
            **({"loss": -first.coefficient(A)} if self.lattice.has_losses else {}),
        }

    def frequency_text(self, printed: Printed = text_of) -> str:
        """Return the carrier's dispersion relation: ``omega^2 = ...``, or a polynomial ``= 0``."""
        parts = self.carrier.wave.powers_of(w)
        squared = frequency**2 if omega in self.lattice.constants else omega**2
        if parts.keys() == {0, 2}:
            value = (parts[0] / parts[2]).factored().xreplace(self.constants)
            return f"{printed(squared)} = {printed(value)}"
        terms = (v.as_expr() * (-squared) ** (power // 2) for power, v in parts.items())
        return f"{printed(sum(terms, S.Zero).xreplace(self.constants))} = 0"

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
        """The decay of a bright soliton's crest |A|, in terms of the coefficient ``loss``."""
        return amplitude_law(2, S.One, Symbol("loss", positive=True), S.Zero)

    @property
    def idle_losses(self) -> tuple[str, ...]:
        """Messages on losses without a term in the equation, one for each kind of loss."""
        losses = self.lattice.leading_losses.items()
        return tuple(idle_loss(kind, value) for kind, (value, power) in losses if power > NLS - 1)

    @cached_property
    def expressions(self) -> Mapping[str, Expr]:
        """The coefficients in sin(k/2), cos(k/2), omega and the lattice's constants."""
        return self.expressions_of(self.parts)

    def expressions_of(self, names: Iterable[str]) -> dict[str, Expr]:
        """Return the named coefficients. Raises EnvelopeError beyond `MOST_TERMS` terms."""
        sizes = {name: self.parts[name].size for name in names}
        longest = max(sizes, key=sizes.__getitem__)
        if sizes[longest] > MOST_TERMS:
            short = all(sizes[name] <= MOST_TERMS for name in sizes if name not in NEXT_ORDER)
            unknown = [str(s) for s in self.lattice.constants if s not in self.constants]
            raise EnvelopeError(
                f"formulas must have at most {MOST_TERMS} terms, got {sizes[longest]} in "
                f"{longest} (give numbers for some of {', '.join(unknown)}, such as {unknown[0]}=1"
                f"{', or take --order 3, without the next order' if short else ''})"
            )
        factors = {name: -I if name in IMAGINARY else 1 for name in sizes}
        return {name: self._expression(self.parts[name]) * factors[name] for name in sizes}

    def _expression(self, element: RationalFunction) -> Expr:
        angle = k if self.wavenumber is None else self.wavenumber
        actual = {sine: sin(angle / 2), cosine: cos(angle / 2), **self.constants}
        if omega.name not in map(str, self.lattice.constants):
            actual[frequency] = omega
        real, imaginary = (part.subs(actual) for part in in_sines(element))
        value = real + I * imaginary
        is_exact = self.wavenumber is None or self.wavenumber in INTEGER_PHASES
        algebraic = not is_exact and (self.wavenumber / pi).is_Rational
        return simplify(value) if algebraic and element.size <= MOST_SIMPLIFIED else value

    def coefficients(
        self, k: Number | None = None, branch: str | int | None = None, **constants: Number
    ) -> EnvelopeNumbers:
        """Return the coefficients at a wavenumber and values of all constants.

        Raises EnvelopeError (a ValueError) at a resonance, and ValueError for a wavenumber outside
        0 <= k <= pi, missing or unknown constants, and an unstable lattice.
        """
        precise = self.regular(k, branch, **constants)._numbers(k, branch, constants)
        numbers = {name: _float_or_complex(value) for name, value in precise.items()}
        return EnvelopeNumbers(**{**dict.fromkeys(NEXT_ORDER, nan), **numbers})

    def normal_form(
        self, k: Number | None = None, branch: str | int | None = None, **constants: Number
    ) -> NormalForm:
        """Return the map to ``i U_tau + U_xixi + 2 s |U|^2 U = 0``; arguments as for coefficients.

        With one field in a cell the values are exact, with several they are computed to `DIGITS`
        digits.  Without a wavenumber and constants they are symbolic.  Raises as `coefficients`
        does, and ValueError if q vanishes.

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
            return _nls_form(self.expressions_of(_NORMAL_FORM_NAMES))
        regular = self.regular(k, branch, **constants)
        numbers = regular._numbers(k, branch, constants)
        if abs(numbers["q"]) <= ZERO_TOLERANCE:
            return _nls_form({**dict.fromkeys(_NORMAL_FORM_NAMES, S.One), "q": S.Zero})
        if len(self.lattice.fields) == 1:
            angle = self.wavenumber if k is None else wavenumber(k)
            return _nls_form(regular._exact_numbers(angle, regular._values(constants)))
        texts = {name: mpmath.nstr(numbers[name].real, DIGITS) for name in _NORMAL_FORM_NAMES}
        return _nls_form({n: parse_rational(n, text) for n, text in texts.items()}, DIGITS)

    @property
    def in_constants(self) -> dict[str, Expr]:
        """Omega and the real coefficients as formulas in k and the constants, for one field a cell.

        >>> from longwave.derive import LATTICES
        >>> envelope(LATTICES["beta_fput"], k=pi).in_constants["q"]
        -12*K4/sqrt(K2)
        """
        angle = k if self.wavenumber is None else self.wavenumber
        return self._exact_numbers(angle, self.carrier.lattice.with_defined(self.constants))

    def _exact_numbers(self, angle: Expr, values: Mapping[Symbol, Expr]) -> dict[str, Expr]:
        """Return omega and the real coefficients at the wavenumber ``angle``, for one field."""
        relation = self.carrier.relation.powers_of(w)
        images = {sine: sin(angle / 2), cosine: cos(angle / 2), **values}
        images[frequency] = sqrt(in_sines(relation[0] / relation[2])[0].subs(images))
        coefficients = {"omega": images[frequency]}
        for name, value in self.parts.items():
            real, imaginary = (part.subs(images) for part in in_sines(value))
            if (real if name in IMAGINARY else imaginary) == 0:
                coefficients[name] = imaginary if name in IMAGINARY else real
        return coefficients

    def _values(self, constants: Mapping[str, Number]) -> dict[Symbol, Expr]:
        lattice = self.carrier.lattice
        known = {*self.lattice.constants, *lattice.basic_constants}
        names = {str(s): s for s in sorted(known, key=str)}
        given = {str(symbol): value for symbol, value in self.constants.items()} | {**constants}
        values = values_of(given, names, self.lattice.name)
        lattice.check_values({symbol: value for symbol, value in values.items() if value == 0})
        required = names.keys() - {str(s) for s, _ in lattice.definitions}
        missing = sorted(required - given.keys())
        if missing:
            name = missing[0]
            raise ValueError(f"{name} must be given, got none (a number, such as {name}=1)")
        return lattice.with_defined(values)

    def point(
        self, k: Number | None, branch: str | int | None, constants: Mapping[str, Number]
    ) -> dict[str, mpmath.mpc]:
        """Return the numbers exp(i k), i omega, k and the constants by name, to `DIGITS` digits."""
        exact_k = self.wavenumber if k is None else wavenumber(k)
        if exact_k is None:
            raise ValueError("k must be given, got none (a wavenumber, such as 1 or pi)")
        values = self._values(constants)
        number = self.branch if branch is None else _branch(branch, self.lattice)
        with mpmath.workdps(DIGITS + GUARD_DIGITS):
            angle = mpmath.mpf(exact_k.evalf(DIGITS + GUARD_DIGITS))
            point = {str(s): mpmath.mpf(v.evalf(DIGITS + GUARD_DIGITS)) for s, v in values.items()}
            point[str(z)] = mpmath.mpc(INTEGER_PHASES.get(exact_k) or mpmath.expj(angle))
            point["k"] = angle
            return {**point, str(w): 1j * _frequency(self.carrier, point, number)}

    def regular(
        self, k: Number | None = None, branch: str | int | None = None, **constants: Number
    ) -> Envelope:
        """Return an envelope whose formulas hold at a point; arguments as for `coefficients`.

        It is ``self`` if possible, else one with another leading field: at the point, the leader
        of ``self`` may be at rest, and its formulas may be 0/0 or belong to another wave.  Raises
        EnvelopeError where two branches meet.
        """
        point = self.point(k, branch, constants)
        if self._is_valid_at(point):
            return self
        exact_k = self.wavenumber if k is None else wavenumber(k)
        values = {s: v for s, v in self._values(constants).items() if v.is_Rational}
        for leader in range(len(self.lattice.fields)):
            turn = INTEGER_PHASES.get(exact_k)
            carrier = Carrier(self.lattice, turn=turn, leader=leader, values=values)
            candidate = replace(self, carrier=carrier)
            if candidate._is_valid_at(point := candidate.point(k, branch, constants)):
                candidate.carrier.solve()
                return candidate
        raise EnvelopeError(_degeneracy_message(f"k = {mpmath.nstr(point['k'], 8)}"))

    def _is_valid_at(self, point: Mapping[str, mpmath.mpc]) -> bool:
        """Return whether the carrier is the wave at ``point`` and its formulas are finite there."""
        with mpmath.workdps(DIGITS + GUARD_DIGITS):
            is_wave = evaluated(1 / self.carrier.wave, point) is None
            return is_wave and all(evaluated(s, point) is not None for s in self.carrier.singular)

    def _numbers(
        self, k: Number | None, branch: str | int | None, constants: Mapping[str, Number]
    ) -> dict[str, mpmath.mpc]:
        """Return omega and all coefficients at a wavenumber, to `DIGITS` digits."""
        with mpmath.workdps(DIGITS + GUARD_DIGITS):
            return self._evaluated_at(self.point(k, branch, constants))

    def _evaluated_at(self, point: Mapping[str, mpmath.mpc]) -> dict[str, mpmath.mpc]:
        """Return omega and all coefficients at ``point``; the caller sets the precision.

        A sum below the rounding of its terms is replaced by 0: for instance the group velocity
        where a band is flat, as at k = 2 pi/3 of a chain with next-nearest springs.
        """
        if evaluated(self.carrier.second_harmonic, point) is None:
            raise EnvelopeError(_resonance_message("4 omega(k)^2 = omega(2k)^2", point))
        numbers: dict[str, mpmath.mpc] = {"omega": point[str(w)].imag}
        for name, element in self.parts.items():
            value = evaluated(element, point)
            if value is None:
                reason = "the group velocity is the sound speed"
                raise EnvelopeError(_resonance_message(reason, point))
            is_none = abs(value) < mpmath.mpf(10) ** -DIGITS * abs(point[str(w)])
            numbers[name] = 0 * value if is_none else value / 1j if name in IMAGINARY else value
        if abs(numbers["p"]) < IMAGINARY_TOLERANCE * abs(point[str(w)]):
            raise EnvelopeError(
                f"k must not be a zero of the dispersion p, got {mpmath.nstr(point['k'], 8)} "
                "(the third derivative of omega takes its place there: take another wavenumber)"
            )
        return numbers

    def text(self) -> str:
        """Return the equation with p and q, in plain text."""
        p, q = map(text_of, self.expressions_of(("p", "q")).values())
        return f"{self.lattice.name}: {self.equation}, p = {p}, q = {q}"

    def latex(self) -> str:
        """Return the equation and its coefficients in LaTeX, without delimiters."""
        values = self.expressions.items()
        rows = (f"{COEFFICIENT_LATEX[name]} = {latex_of(value)}" for name, value in values)
        return r",\quad ".join((self.equation_latex, *rows))


COEFFICIENT_LATEX = {
    "omega": r"\omega", "v": "v", "p": "p", "q": "q", "mean": "b_0", "second": "b_2",
    "a3": "a_3", "a1": "a_1", "a2": "a_2", "detuning": r"\delta", "loss": r"\lambda",
}  # fmt: skip


def _nls_form(form_values: Mapping[str, Expr], digits: int | None = None) -> NormalForm:
    v, p, q = (form_values[name] for name in _NORMAL_FORM_NAMES)
    return normal_form_of(v, {"A_XX": p, "|A|^2 A": q}, digits)


def envelope(
    lattice: Lattice, k: Number | None = None, branch: str | int = 0, **constants: Number
) -> Envelope:
    """Derive the envelope equation of a chain's carrier waves.

    ``k`` is the wavenumber in radians a cell, 0 <= k <= pi; without it the coefficients are
    functions of k.  ``branch`` is "acoustic", "optical" or its number from below.  Constants are
    substituted first, which is faster.  Raises EnvelopeError (a ValueError) if there is no NLS
    equation.

    >>> from longwave.derive import LATTICES
    >>> found = envelope(LATTICES["fput_strain"], k=pi)
    >>> found.expressions["p"], found.expressions["v"]
    (-omega/8, 0)
    """
    instance("lattice", lattice, Lattice, "LATTICES['fput_strain'] is one")
    if lattice.dimension != 1:
        raise ValueError(f"lattice must have one axis, got {lattice.dimension} (take a chain)")
    exact_k = None if k is None else wavenumber(k)
    number = _branch(branch, lattice)
    names = {str(symbol): symbol for symbol in lattice.constants}
    values = values_of(constants, names, lattice.name)
    carrier = Carrier(lattice, turn=INTEGER_PHASES.get(exact_k), wave=number, values=values)
    carrier.solve()
    return Envelope(lattice, exact_k, number, values, carrier)


def modulation_map(
    lattice: Lattice,
    wavenumbers: Sequence[Number],
    branch: str | int = 0,
    amplitude: float = 1.0,
    **constants: Number,
) -> list[tuple[float, EnvelopeNumbers | None, float]]:
    """Return k, the coefficients and the plane wave's largest growth rate for each wavenumber.

    The coefficients are None at a resonance. The plane wave has |A| = ``amplitude``.
    """
    derived = envelope(lattice, branch=branch, **constants)
    rows: list[tuple[float, EnvelopeNumbers | None, float]] = []
    for angle in wavenumbers:
        try:
            numbers: EnvelopeNumbers | None = derived.coefficients(angle, branch, **constants)
        except EnvelopeError:
            numbers = None
        rate = numbers.growth_rate(amplitude) if numbers else 0.0
        rows.append((float(wavenumber(angle)), numbers, rate))
    return rows


def wavenumber(k: Number) -> Expr:
    """Return the wavenumber ``k`` as an exact number. Raises ValueError unless 0 <= k <= pi."""
    value = exact_value("k", k)
    if value.free_symbols or not 0 <= value <= pi:
        raise ValueError(f"k must satisfy 0 <= k <= pi, got {shown(k)} (radians a cell)")
    return value


def _branch(branch: str | int, lattice: Lattice) -> int:
    count = len(lattice.fields)
    by_name = {"acoustic": 0, "optical": count - 1}
    number = by_name.get(branch) if isinstance(branch, str) else branch
    if number is None or isinstance(number, bool) or not 0 <= number < count:
        raise ValueError(
            f"branch must be acoustic, optical or a number below {count}, got {shown(branch)} "
            f"({lattice.name} has {count} {'branch' if count == 1 else 'branches'})"
        )
    return number


def _frequency(carrier: Carrier, point: Mapping[str, mpmath.mpc], number: int) -> mpmath.mpf:
    """Return omega of branch ``number`` at a point, from the determinant's roots omega^2."""
    powers = carrier.relation.powers_of(w).items()
    parts: dict[int, Any] = {power: evaluated(part, point) for power, part in powers}
    highest = max(parts)
    phase = mpmath.conj(parts[highest]) / abs(parts[highest])
    polynomial = [
        (parts.get(power, mpmath.mpf(0)) * phase * (-1) ** ((highest - power) // 2)).real
        for power in range(highest, -1, -2)
    ]
    where = f"k = {mpmath.nstr(mpmath.arg(point[str(z)]), 8)}"
    try:
        roots = sorted(mpmath.polyroots(polynomial, maxsteps=200, extraprec=200), key=mpmath.re)
    except mpmath.mp.NoConvergence:  # because of multiple roots
        raise ValueError(_degeneracy_message(where)) from None
    squared = roots[number]
    if abs(squared) <= ZERO_TOLERANCE * abs(roots[-1]):
        raise EnvelopeError(at_rest(f" at {where}"))
    if abs(squared.imag) > IMAGINARY_TOLERANCE * abs(squared) or squared.real <= 0:
        raise ValueError(
            f"constants must give a real frequency, got omega^2 = {mpmath.nstr(squared, 8)} at "
            f"{where} (the lattice must be stable)"
        )
    return mpmath.sqrt(squared.real)


def _degeneracy_message(at: str) -> str:
    return (
        f"k must separate the branches, got {at}, where two have the same frequency (take "
        "another k, or constants that separate them)"
    )


def _float_or_complex(value: mpmath.mpc) -> Any:
    """Return a float, or a complex if the imaginary part is more than a rounding error."""
    threshold = IMAGINARY_TOLERANCE * abs(value)
    number = mpmath.mpc(value)
    real, imaginary = (part if abs(part) > threshold else 0 for part in (number.real, number.imag))
    return complex(real, imaginary) if imaginary else float(real)


def evaluated(element: RationalFunction, point: Mapping[str, mpmath.mpc]) -> mpmath.mpc | None:
    """Return the value of a rational function at a point; None if its denominator is 0 there."""
    gens = [str(symbol) for symbol in element.field.symbols]
    power = cache(lambda name, exponent: point[name] ** exponent)  # shared by many terms
    numerator, denominator = (
        [
            mpmath.fprod(power(g, e) for g, e in zip(gens, exponents, strict=True) if e) * value
            for exponents, value in element.terms(below=below)
        ]
        for below in (False, True)
    )
    total, size = mpmath.fsum(denominator), mpmath.fsum(denominator, absolute=True)
    return None if abs(total) <= ZERO_TOLERANCE * size else mpmath.fsum(numerator) / total


def _resonance_message(reason: str, point: Mapping[str, mpmath.mpc]) -> str:
    return (
        f"k must not be a resonance, got {mpmath.nstr(point['k'], 8)}, where {reason} "
        "(the two waves interact at the order of the envelope: take another wavenumber)"
    )

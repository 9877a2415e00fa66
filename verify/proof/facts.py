"""Exact facts about the rational solutions: peak, background, degree, symmetry, no pole.

With ``D = A**2 + B**2`` and ``N = D - 2 (A B_x - A_x B)`` the solution of order j is
``(-1)**j N/D``.  Each fact is an identity of polynomials with integer coefficients, in x, t and
the shifts that are kept.

No pole.  Let f = A + i B vanish at a real point, of order r >= 1 in x; at fixed t and shifts f is
no zero polynomial in x, since its leading coefficient is a constant.  With ``f ~ c s**r`` the
first bilinear equation (`bilinear`) has ``-2 r |c|**2 s**(2r-2)`` on the left and O(s**(2r)) on
the right: a contradiction.  So ``D > 0`` for all real x, t and shifts.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import fmpq, fmpq_mpoly, fmpz

from solutions.forms.rational import rational_tau
from solutions.forms.tau_polynomials import RationalTau
from verify.verdict import Outcome

from .bilinear import bilinear_verdict


@dataclass(frozen=True)
class RationalFacts:
    """What holds exactly for the rational solution of ``order`` with the shifts ``free`` kept.

    ``peak`` is the value at the origin for shifts 0, ``background`` the limit for large |x|,
    ``degree`` that of the denominator in x.  ``reduced``: numerator and denominator have no common
    factor.  ``symmetric``: the solution stays the same when x, t and all shifts change sign.
    ``positive``: the denominator has no real zero.
    """

    order: int
    free: tuple[int, ...]
    peak: Fraction
    background: Fraction
    degree: int
    reduced: bool
    symmetric: bool
    positive: bool


def rational_facts(order: int, free: tuple[int, ...] = ()) -> RationalFacts:
    """The facts, each computed; raises ValueError as `solutions.forms.rational.rational_tau` does.

    >>> rational_facts(2)
    RationalFacts(order=2, free=(), peak=Fraction(5, 1), background=Fraction(1, 1), degree=6,
        reduced=True, symmetric=True, positive=True)
    """
    family = rational_tau(order, free)
    A, B = family.A, family.B
    D = A * A + B * B
    N = D - 2 * (A * B.derivative("x") - A.derivative("x") * B)
    sign = (-1) ** order
    origin = [fmpq(0)] * len(family.symbols)
    leading, top = leading_in_x(D)
    return RationalFacts(
        order,
        family.free,
        peak=sign * as_fraction(N(*origin) / D(*origin)),
        background=sign * as_fraction(limit(N, leading, top)),
        degree=top,
        reduced=_is_reduced(N, D),
        symmetric=all(reflected(part) == part for part in (N, D)),
        positive=_has_no_pole(family),
    )


def leading_in_x(polynomial: fmpq_mpoly) -> tuple[fmpq_mpoly, int]:
    """The coefficient of the highest power of x, in the other generators, and that power."""
    top = int(polynomial.degrees()[0])
    return coefficient_in_x(polynomial, top), top


def coefficient_in_x(polynomial: fmpq_mpoly, power: int) -> fmpq_mpoly:
    """The coefficient of ``x**power``, a polynomial in the other generators."""
    terms = {(0, *e[1:]): c for e, c in polynomial.terms() if e[0] == power}
    return polynomial.context().from_dict(terms)


def limit(N: fmpq_mpoly, leading: fmpq_mpoly, top: int) -> fmpq:
    """The limit of ``N/D`` for large |x|, D with the constant leading coefficient ``leading``.

    Raises ValueError if N grows faster or the limit depends on another generator.
    """
    if N.degrees()[0] > top:
        raise ValueError(
            "the solution must be bounded, got a numerator of higher degree "
            "(take a rational solution)"
        )
    ratio = coefficient_in_x(N, top) / leading
    if not ratio.is_constant():
        raise ValueError(
            "the background must be constant, got one that depends on t or a shift "
            "(take a rational solution)"
        )
    return ratio.leading_coefficient()


def reflected(polynomial: fmpq_mpoly) -> fmpq_mpoly:
    """``polynomial`` with the sign of every generator changed."""
    terms = {e: c * (-1) ** (int(sum(e)) % 2) for e, c in polynomial.terms()}
    return polynomial.context().from_dict(terms)


def as_fraction(value: fmpq) -> Fraction:
    """A rational number of python-flint as Python's."""
    return Fraction(int(value.p), int(value.q))


def _is_reduced(N: fmpq_mpoly, D: fmpq_mpoly) -> bool:
    """No common factor at t = 1, shifts 0; D is monic in x up to a constant, so none at all."""
    others: dict[str | int, int | fmpz | fmpq] = dict.fromkeys(D.context().names()[1:], 0)
    others["t"] = 1
    leading, _ = leading_in_x(D)
    return bool(leading.is_constant() and N.subs(others).gcd(D.subs(others)).is_constant())


def _has_no_pole(family: RationalTau) -> bool:
    """The premises of the argument at the head of this file; the equation by the checker."""
    (leading, top), (_, other) = leading_in_x(family.A), leading_in_x(family.B)
    verdict = bilinear_verdict(f"rational_{family.order}", family.A, family.B)
    return bool(leading.is_constant() and top > other and verdict.outcome is Outcome.PROVED)

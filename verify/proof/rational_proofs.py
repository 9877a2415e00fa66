"""Prove the rational solutions of any order, and compute exact facts, from their two polynomials.

In ``x = xi - 6 tau`` and ``t = tau`` the solution of order j is ``(-1)**j N/D`` with integer
polynomials A and B, ``D = A**2 + B**2`` and ``N = D - 2 (A B_x - A_x B)``.  Proved are:

The equation: the certificate contains A and B, and the checker proves the equation at more values
of t than the residual's degree.

The bilinear equations of the tau function ``f = A + i B``, with ``f*`` its conjugate:

    D_x**2 f.f* = 2 i D_x f.f*,    (D_t + D_x**3) f.f* = 0,

where ``D_x**n f.g`` is the Hirota derivative.  The first is real, the second imaginary, so each is
one identity between A and B.

Peak, background, degree and symmetry: identities of polynomials with integer coefficients in x, t
and the free shifts.  No pole: let f vanish at a real point, of order r >= 1 in x.  At fixed t and
shifts f is not the zero polynomial in x, since its leading coefficient is a constant.  With
``f ~ c s**r`` the first bilinear equation has ``-2 r |c|**2 s**(2r-2)`` on the left and O(s**(2r))
on the right: a contradiction.  So ``D > 0`` for all real x, t and shifts.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import product

import sympy as sp
from flint import fmpq, fmpq_mpoly, fmpz

from longwave.solutions.equation import FOCUSING_MKDV
from longwave.solutions.forms.tau_polynomials import RationalTau, rational_tau
from longwave.solutions.symbols import tau, xi
from longwave.verify.kernel import CertificateError, check_certificate
from longwave.verify.verdict import Outcome, ProofVerdict, timed

from .certificate_writer import Certificate, NodeTable, ProofWriter
from .text_writer import Written
from .typed_statement import StatementTexts

METHOD = "exact at more points than the degree"

WITNESS = 5
"""Largest coordinate tried in the search for a witness."""

SPACE = "A*A_xx + B*B_xx - A_x**2 - B_x**2 - 2*A_x*B + 2*A*B_x"
"""Half of ``D_x**2 f.f* - 2 i D_x f.f*`` as text, an equation in A and B."""

TIME = "A*B_t - A_t*B + A*B_xxx - A_xxx*B - 3*A_x*B_xx + 3*A_xx*B_x"
"""``(D_t + D_x**3) f.f*`` divided by ``2 i`` as text, an equation in A and B."""


@timed
def prove_rational(order: int) -> ProofVerdict:
    """Decide whether the rational solution of a positive ``order``, without shifts, is right.

    >>> prove_rational(3).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    family = rational_tau(order)
    return rational_verdict(order, family.A, family.B)


def rational_verdict(order: int, A: fmpq_mpoly, B: fmpq_mpoly) -> ProofVerdict:
    """Prove the formula with A and B in x and t, or refute it at integers x and t."""
    verdict = partial(ProofVerdict, f"rational_{order}", FOCUSING_MKDV.name, METHOD)
    certificate = rational_certificate(order, A, B)
    try:
        check_certificate(certificate)
    except CertificateError as error:
        witness = nonzero_residual(A, B)
        if witness is None:
            return verdict(Outcome.UNDECIDED, str(error))
        detail = "the residual is not 0 at x = xi - 6 tau, t = tau"
        return verdict(Outcome.REFUTED, detail, witness=witness)
    values = 4 * int((A * A + B * B).degrees()[1]) + 1
    detail, scope = f"0 at {values} values of tau, accepted by the checker", "for all real xi, tau"
    accepted = partial(verdict, residual=0.0, assumptions=(scope,), certificate=certificate)
    return accepted(Outcome.PROVED, detail)


def rational_texts(order: int, A: fmpq_mpoly, B: fmpq_mpoly) -> StatementTexts:
    """Return the statement texts of the solution of ``order`` with polynomials A and B."""
    table = NodeTable()
    space, time_ = table.place(xi), table.place(tau)
    shift = table.place(-6 * tau)
    x = table.add("Add", space, shift)
    parts = A, B, A.derivative("x"), B.derivative("x")
    a, b, a_x, b_x = (table.polynomial(part, [x, time_]) for part in parts)
    one, add = table.add("number", "1"), table.add
    slope = add("Add", add("Mul", a, b_x), add("Mul", add("number", "-1"), a_x, b))
    below = add("Add", add("Pow", a, "2"), add("Pow", b, "2"))
    change = add("Mul", add("number", "-2"), slope, add("Pow", below, "-1"))
    formula = add("Mul", add("number", str((-1) ** order)), add("Add", one, change))
    written = Written(table.nodes, [formula], ["U"], ["xi", "tau"])
    return StatementTexts(
        ("xi", "tau"),
        ("diff(U, tau) + 6*U**2*diff(U, xi) + diff(U, xi, xi, xi)",),
        (f"U = {written.text(formula)}",),
        tuple(f"{name} = {text}" for name, text in written.named.items()),
    )


def rational_certificate(order: int, A: fmpq_mpoly, B: fmpq_mpoly) -> Certificate:
    """Return the certificate for the solution of ``order`` with polynomials A and B."""
    statement = rational_texts(order, A, B)
    table = NodeTable()
    space, time_, shift = (table.place(part) for part in (xi, tau, -6 * tau))
    one = table.add("number", "1")
    proof = ProofWriter(table)
    proof.atom(time_)
    proof.generators.append(["forms", [space], [[[one], shift]]])
    point = {xi: sp.Rational(1, 3), tau: sp.Rational(1, 5)}
    return Certificate.signed(f"rational_{order}", table, statement, proof.data(point))


def nonzero_residual(A: fmpq_mpoly, B: fmpq_mpoly) -> dict[str, str] | None:
    """Return small integers x and t at which the residual is not 0; None if none are found."""
    points = product(range(-WITNESS, WITNESS + 1), repeat=2)
    return next(({"x": str(x), "t": str(t)} for t, x in points if residual_at(A, B, x, t)), None)


def residual_at(A: fmpq_mpoly, B: fmpq_mpoly, x: int, t: int) -> fmpq:
    """Return ``D**4`` times ``U_t + 6 (U**2 - 1) U_x + U_xxx`` at a point, with shifts 0."""
    D = A * A + B * B
    N = D - 2 * (A * B.derivative("x") - A.derivative("x") * B)
    others: dict[str | int, int | fmpz | fmpq] = dict.fromkeys(D.context().names()[1:], 0)
    others["t"] = t
    n, d, n_t, d_t = (p.subs(others) for p in (N, D, N.derivative("t"), D.derivative("t")))
    numerators, d_x = [n], d.derivative("x")
    for power in (1, 2, 3):
        last = numerators[-1]
        numerators.append(last.derivative("x") * d - power * last * d_x)
    _, first, _, third = numerators
    residual = (n_t * d - n * d_t) * d * d + 6 * (n * n - d * d) * first + third
    return residual(x, *[0] * len(others))


def bilinear_certificate(name: str, A: fmpq_mpoly, B: fmpq_mpoly) -> Certificate:
    """Return the certificate of the bilinear equations as two equations in the real A and B."""
    table = NodeTable()
    symbols = [sp.Symbol(symbol, real=True) for symbol in A.context().names()]
    places = [table.place(symbol) for symbol in symbols]
    formulas = [table.polynomial(part, places) for part in (A, B)]
    names = [symbol.name for symbol in symbols]
    written = Written(table.nodes, formulas, ["A", "B"], names[:2])
    statement = StatementTexts(
        tuple(names[:2]),
        (SPACE, TIME),
        tuple(f"{u} = {written.text(f)}" for u, f in zip("AB", formulas, strict=True)),
        tuple(f"{name} = {text}" for name, text in written.named.items()),
    )
    table = NodeTable()
    places = [table.place(symbol) for symbol in symbols]
    proof = ProofWriter(table)
    for place in places:
        proof.atom(place)
    point = dict.fromkeys(symbols, sp.S.Zero)
    return Certificate.signed(f"{name} bilinear", table, statement, proof.data(point))


@dataclass(frozen=True)
class RationalFacts:
    """Exact facts about the rational solution of ``order`` with the free shifts ``free``.

    ``peak`` is the value at the origin, ``background`` the limit for large |x|, and ``degree`` that
    of the denominator in x.  ``reduced``: numerator and denominator have no common factor.
    ``symmetric``: changing the signs of x, t and all shifts leaves the solution unchanged.
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
    """Compute the facts; raises ValueError as `tau_polynomials.rational_tau` does.

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
        peak=sign * Fraction(str(N(*origin) / D(*origin))),
        background=sign * Fraction(str(limit(N, leading, top))),
        degree=top,
        reduced=_is_reduced(N, D),
        symmetric=all(reflected(part) == part for part in (N, D)),
        positive=_has_no_pole(family),
    )


def leading_in_x(polynomial: fmpq_mpoly) -> tuple[fmpq_mpoly, int]:
    """Return the coefficient of the highest power of x, in the other generators, and that power."""
    top = int(polynomial.degrees()[0])
    return coefficient_in_x(polynomial, top), top


def coefficient_in_x(polynomial: fmpq_mpoly, power: int) -> fmpq_mpoly:
    """Return the coefficient of ``x**power``, a polynomial in the other generators."""
    terms = {(0, *e[1:]): c for e, c in polynomial.terms() if e[0] == power}
    return polynomial.context().from_dict(terms)


def limit(N: fmpq_mpoly, leading: fmpq_mpoly, top: int) -> fmpq:
    """Return the limit of ``N/D`` for large |x| if it is a number; raises ValueError otherwise."""
    if N.degrees()[0] > top:
        got = "a numerator of higher degree (take a rational solution)"
        raise ValueError(f"the solution must be bounded, got {got}")
    ratio = coefficient_in_x(N, top) / leading
    if not ratio.is_constant():
        got = "one that depends on t or a shift (take a rational solution)"
        raise ValueError(f"the background must be constant, got {got}")
    return ratio.leading_coefficient()


def reflected(polynomial: fmpq_mpoly) -> fmpq_mpoly:
    """Return ``polynomial`` with the sign of every generator changed."""
    terms = {e: c * (-1) ** (int(sum(e)) % 2) for e, c in polynomial.terms()}
    return polynomial.context().from_dict(terms)


def _is_reduced(N: fmpq_mpoly, D: fmpq_mpoly) -> bool:
    """Return whether N and D are coprime at t = 1, shifts 0, hence everywhere for D monic in x."""
    others: dict[str | int, int | fmpz | fmpq] = dict.fromkeys(D.context().names()[1:], 0)
    others["t"] = 1
    leading, _ = leading_in_x(D)
    return bool(leading.is_constant() and N.subs(others).gcd(D.subs(others)).is_constant())


def _has_no_pole(family: RationalTau) -> bool:
    """Return whether the premises of the no-pole argument (module docstring) are proved."""
    (leading, top), (_, other) = leading_in_x(family.A), leading_in_x(family.B)
    try:
        check_certificate(bilinear_certificate(f"rational_{family.order}", family.A, family.B))
    except CertificateError:
        return False
    return bool(leading.is_constant() and top > other)

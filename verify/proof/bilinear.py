"""The bilinear equations of the rational solutions' tau functions, as polynomial identities.

With ``f = A + i B``, real A and B, and ``f*`` its conjugate (each order is a finite identity):

    D_x**2 f.f* = 2 i D_x f.f*,    (D_t + D_x**3) f.f* = 0,

where ``D_x**n f.g`` is the Hirota derivative.  The first is real, the second imaginary, so each is
one identity between A and B.
"""

from __future__ import annotations

import time
from itertools import count

from flint import fmpq_mpoly

from solutions.forms.rational import rational_tau
from verify.verdict import Outcome

from .certificate import signed
from .checker import CertificateError, check_certificate
from .draft import Data
from .tree import NodeTable
from .verdict import ProofVerdict

METHOD = "bilinear identities"
EQUATION = "D_x^2 f.f* = 2i D_x f.f*, (D_t + D_x^3) f.f* = 0"


def prove_bilinear(order: int, free: tuple[int, ...] = ()) -> ProofVerdict:
    """Decide the bilinear equations of the rational tau function of ``order``.

    ``free`` lists the shifts tau_5, tau_7, ... kept symbolic.  Raises ValueError as
    `solutions.forms.rational.rational_tau` does.

    >>> prove_bilinear(2).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    start = time.perf_counter()
    family = rational_tau(order, free)
    verdict = bilinear_verdict(f"rational_{order}", family.A, family.B)
    return verdict.timed(time.perf_counter() - start)


def bilinear_verdict(name: str, A: fmpq_mpoly, B: fmpq_mpoly) -> ProofVerdict:
    """Decide the bilinear equations for ``f = A + i B``; x and t are among the generators.

    A residual that is not the zero polynomial is refuted by a rational point at which it is not 0.
    """
    for label, residual in (("space", space_residual(A, B)), ("time", time_residual(A, B))):
        if not residual.is_zero():
            point = nonzero_point(residual)
            witness = dict(zip(residual.context().names(), map(str, point), strict=True))
            detail = f"the {label} equation leaves {residual(*point)} at the witness"
            return ProofVerdict(name, EQUATION, METHOD, Outcome.REFUTED, detail, witness=witness)
    certificate = bilinear_certificate(name, A, B)
    try:
        check_certificate(certificate)
    except CertificateError as error:
        return ProofVerdict(name, EQUATION, METHOD, Outcome.UNDECIDED, str(error))
    return ProofVerdict(
        name,
        EQUATION,
        METHOD,
        Outcome.PROVED,
        "both vanish identically, accepted by the checker",
        residual=0.0,
        certificate=certificate,
    )


def bilinear_certificate(name: str, A: fmpq_mpoly, B: fmpq_mpoly) -> Data:
    """The certificate of the bilinear equations as two equations of real polynomials A and B."""
    table = NodeTable()
    symbols = [table.made("symbol", symbol, "real") for symbol in A.context().names()]
    formulas = [table.polynomial(part, symbols) for part in (A, B)]
    statement = {
        "variables": symbols[:2],
        "unknowns": [["A", formulas[0]], ["B", formulas[1]]],
        "equations": [
            [[factor, [], [list(jet) for jet in jets]] for factor, jets in terms]
            for terms in (SPACE, TIME)
        ],
        "domain": [],
    }
    proof = {
        "generators": [["atom", symbol] for symbol in symbols],
        **{hint: [] for hint in ("sums", "values", "logs", "signs", "parts")},
        "point": [[symbol, "0"] for symbol in symbols],
    }
    return signed(f"{name} bilinear", table, statement, proof)


Jet = tuple[int, list[int]]
Terms = list[tuple[str, list[Jet]]]

_A, _A_x, _A_xx, _A_xxx, _A_t = ((0, orders) for orders in ([0, 0], [1, 0], [2, 0], [3, 0], [0, 1]))
_B, _B_x, _B_xx, _B_xxx, _B_t = ((1, orders) for orders in ([0, 0], [1, 0], [2, 0], [3, 0], [0, 1]))

SPACE: Terms = [
    ("1", [_A, _A_xx]),
    ("1", [_B, _B_xx]),
    ("-1", [_A_x, _A_x]),
    ("-1", [_B_x, _B_x]),
    ("-2", [_A_x, _B]),
    ("2", [_A, _B_x]),
]
"""Half of ``D_x**2 f.f* - 2 i D_x f.f*``."""

TIME: Terms = [
    ("1", [_B_t, _A]),
    ("-1", [_B, _A_t]),
    ("1", [_B_xxx, _A]),
    ("-1", [_B, _A_xxx]),
    ("-3", [_B_xx, _A_x]),
    ("3", [_B_x, _A_xx]),
]
"""``(D_t + D_x**3) f.f*`` divided by ``2 i``."""


def nonzero_point(polynomial: fmpq_mpoly) -> tuple[int, ...]:
    """Integers at which ``polynomial``, which is not 0, does not vanish.

    One generator after the other is set to the first integer that leaves a polynomial that is
    not 0; of any degree + 1 integers one does.
    """
    point: list[int] = []
    names = polynomial.context().names()
    for name in names:
        value = next(n for n in count(1) if not polynomial.subs({name: n}).is_zero())
        polynomial = polynomial.subs({name: value})
        point.append(value)
    return tuple(point)


def space_residual(A: fmpq_mpoly, B: fmpq_mpoly) -> fmpq_mpoly:
    """Half of ``D_x**2 f.f* - 2 i D_x f.f*`` (a real polynomial in x, t, ...)."""
    A_x, B_x = A.derivative("x"), B.derivative("x")
    A_xx, B_xx = A_x.derivative("x"), B_x.derivative("x")
    return A * A_xx + B * B_xx - A_x * A_x - B_x * B_x - 2 * (A_x * B - A * B_x)


def time_residual(A: fmpq_mpoly, B: fmpq_mpoly) -> fmpq_mpoly:
    """``(D_t + D_x**3) f.f*`` divided by ``2 i``."""
    A_x, B_x = A.derivative("x"), B.derivative("x")
    A_xx, B_xx = A_x.derivative("x"), B_x.derivative("x")
    third = B_xx.derivative("x") * A - B * A_xx.derivative("x") - 3 * (B_xx * A_x - B_x * A_xx)
    return B.derivative("t") * A - B * A.derivative("t") + third

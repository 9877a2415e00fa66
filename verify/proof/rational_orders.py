"""Proofs for the rational solution of any order, from its two polynomials.

In ``x = xi - 6 tau`` and ``t = tau`` the solution is ``(-1)**j [1 - 2 (A B_x - A_x B)/(A**2 +
B**2)]`` with integer polynomials A and B.  The certificate holds these, and the checker proves the
equation at more values of t than the residual's degree.
"""

from __future__ import annotations

import time
from typing import Any

from flint import fmpq_mpoly

from solutions.forms.rational import rational_tau
from solutions.record import FOCUSING_MKDV
from solutions.symbols import tau, xi
from verify.verdict import Outcome

from .certificate import signed
from .checker import CertificateError, check_certificate
from .draft import Data
from .tree import NodeTable
from .verdict import ProofVerdict

METHOD = "exact at more points than the degree"


def prove_rational(order: int) -> ProofVerdict:
    """Decide whether the rational solution of ``order``, without free shifts, is a solution.

    Raises ValueError if ``order`` is no positive integer.

    >>> prove_rational(3).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    start = time.perf_counter()
    family = rational_tau(order)
    verdict = rational_verdict(order, family.A, family.B)
    return verdict.timed(time.perf_counter() - start)


def rational_verdict(order: int, A: fmpq_mpoly, B: fmpq_mpoly) -> ProofVerdict:
    """Decide whether the formula with A and B, polynomials in x and t, is a solution.

    A formula that is none is refuted by integers x and t at which the residual is not 0.
    """
    name, equation = f"rational_{order}", FOCUSING_MKDV.name
    certificate = rational_certificate(order, A, B)
    try:
        check_certificate(certificate)
    except CertificateError as error:
        witness = nonzero_point(A, B)
        if witness is None:
            return ProofVerdict(name, equation, METHOD, Outcome.UNDECIDED, str(error))
        detail = "the residual is not 0 at x = xi - 6 tau, t = tau"
        return ProofVerdict(name, equation, METHOD, Outcome.REFUTED, detail, witness=witness)
    detail = f"0 at {_values(A, B)} values of tau, accepted by the checker"
    return ProofVerdict(
        name,
        equation,
        METHOD,
        Outcome.PROVED,
        detail,
        residual=0.0,
        assumptions=("for all real xi, tau",),
        certificate=certificate,
    )


def rational_certificate(order: int, A: fmpq_mpoly, B: fmpq_mpoly) -> Data:
    """The certificate for the solution of ``order`` made of A and B."""
    table = NodeTable()
    space, time_ = table.place(xi), table.place(tau)
    shift = table.place(-6 * tau)
    x = table.made("Add", space, shift)
    a, b, a_x, b_x = (
        table.polynomial(part, [x, time_]) for part in (A, B, A.derivative("x"), B.derivative("x"))
    )
    one = table.made("number", "1")
    slope = table.made(
        "Add",
        table.made("Mul", a, b_x),
        table.made("Mul", table.made("number", "-1"), a_x, b),
    )
    below = table.made("Add", table.made("Pow", a, "2"), table.made("Pow", b, "2"))
    inverse = table.made("Pow", below, "-1")
    change = table.made("Mul", table.made("number", "-2"), slope, inverse)
    wave = table.made("Add", one, change)
    formula = table.made("Mul", table.made("number", str((-1) ** order)), wave)
    mkdv: list[list[Any]] = [
        ["1", [], [[0, [0, 1]]]],
        ["6", [], [[0, [0, 0]], [0, [0, 0]], [0, [1, 0]]]],
        ["1", [], [[0, [3, 0]]]],
    ]
    statement = {
        "variables": [space, time_],
        "unknowns": [["U", formula]],
        "equations": [mkdv],
        "domain": [],
    }
    proof = {
        "generators": [["atom", time_], ["forms", [space], [[[one], shift]]]],
        **{name: [] for name in ("sums", "values", "logs", "signs", "parts")},
        "point": [[space, "1/3"], [time_, "1/5"]],
    }
    return signed(f"rational_{order}", table, statement, proof)


def nonzero_point(A: fmpq_mpoly, B: fmpq_mpoly) -> dict[str, str] | None:
    """Small integers x and t at which the residual of the formula with A and B is not 0."""
    for t in range(-WITNESS, WITNESS + 1):
        for x in range(-WITNESS, WITNESS + 1):
            if residual_at(A, B, x, t) != 0:
                return {"x": str(x), "t": str(t)}
    return None


WITNESS = 5
"""Integers up to this are tried in search of a witness."""


def residual_at(A: fmpq_mpoly, B: fmpq_mpoly, x: int, t: int) -> Any:
    """``D**4`` times the residual ``U_t + 6 (U**2 - 1) U_x + U_xxx`` at a point.

    The numerators are those of a truncated Taylor series in x, computed from A and B there.
    """
    D = A * A + B * B
    N = D - 2 * (A * B.derivative("x") - A.derivative("x") * B)

    def at(polynomial: fmpq_mpoly) -> Any:
        return polynomial(x, t, *[0] * (polynomial.context().nvars() - 2))

    n, d = [N], [D]
    for _ in range(3):
        n.append(n[-1].derivative("x"))
        d.append(d[-1].derivative("x"))
    n0, n1, n2, n3 = map(at, n)
    d0, d1, d2, d3 = map(at, d)
    first = n1 * d0 - n0 * d1
    second = (n2 * d0 - n0 * d2) * d0 - 2 * first * d1
    third = (
        ((n3 * d0 + n2 * d1 - n1 * d2 - n0 * d3) * d0 + (n2 * d0 - n0 * d2) * d1) * d0
        - 2 * (n2 * d0 - n0 * d2) * d1 * d0
        - 2 * first * d2 * d0
        - 3 * second * d1
    )
    slope = at(N.derivative("t")) * d0 - n0 * at(D.derivative("t"))
    return slope * d0 * d0 + 6 * (n0 * n0 - d0 * d0) * first + third


def _values(A: fmpq_mpoly, B: fmpq_mpoly) -> int:
    D = A * A + B * B
    return 4 * int(D.degrees()[1]) + 1

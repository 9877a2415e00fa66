"""The tie of elliptic waves to the modified KdV equation for all small eps: its certificates."""

from __future__ import annotations

from typing import Any

import numpy as np
from flint import arb, ctx, fmpq

from longwave.waves.certificates import (
    contracting_radius,
    decimal_text,
    intervals,
    lattice_record,
    proved_pieces,
)
from longwave.waves.kernel.cosine_series import entry
from longwave.waves.kernel.elliptic_pins import NearWave
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic import Spring
from longwave.waves.kernel.reading import Record
from longwave.waves.kernel.tie import TiePiece, tie_contraction
from longwave.waves.kernel.tie_claim import TieClaim

BITS = 96
WEIGHTS = tuple(fmpq(1, n) for n in (300, 150, 75, 40, 20, 10, 5, 2, 1))
"""Weights of the speed sigma in the norm that are tried; the least bound decides."""

FIRST_PIECES, HALVINGS = 48, 7
"""Number of pieces of eps^2 at first, and how often one is halved."""

LEAST_TOP, MOST_TOP = 8, 96
MODE_CUT = 1e-11
"""Size of the modes of Y from which on they are bounded as a tail."""


def tie_certificate(spring: Spring, form: str, k: fmpq, eps: fmpq) -> dict[str, Any]:
    """Return the certificate that ties a wave to the modified KdV equation for 0 < eps' <= eps.

    Raises CertificateError with the inequality that failed.
    """
    with ctx.workprec(BITS):
        return _certificate(spring, form, k, eps)


def _certificate(spring: Spring, form: str, k: fmpq, eps: fmpq) -> dict[str, Any]:
    if spring.force.polynomial is None:
        raise CertificateError("the tie is proved for a polynomial force")
    wave = NearWave(form, k, fmpq(1), spring.force)
    top = LEAST_TOP
    while float(abs(wave.mode(top + 1)) + abs(wave.mode(top + 2))) > MODE_CUT and top < MOST_TOP:
        top += 2
    weight = _best_weight(wave, top, eps * eps)
    data: dict[str, Any] = {
        "kind": "tie",
        "version": 1,
        "lattice": lattice_record([spring]),
        "near": {"form": form, "k": str(k)},
        "eps": str(eps),
        "bits": BITS,
        "weight": str(weight),
    }
    ends = [eps * eps * i / FIRST_PIECES for i in range(FIRST_PIECES + 1)]
    data["pieces"] = proved_pieces(
        ends, lambda first, last: _piece(wave, arb(weight), top, first, last), HALVINGS
    )
    data["claims"] = intervals(TieClaim(Record(data, "certificate")).prove())
    return data


def _best_weight(wave: NearWave, top: int, square: fmpq) -> fmpq:
    """Return the weight with the least bound on the last piece. Raises CertificateError."""
    bounds: dict[float, fmpq] = {}
    failure = CertificateError("no weight is left")
    for weight in WEIGHTS:
        try:
            piece = _piece(wave, arb(weight), top, square * 47 / 48, square)
        except CertificateError as reason:
            failure = reason
        else:
            bounds[float(piece["bound"])] = weight
    if not bounds:
        raise failure
    return bounds[min(bounds)]


def _piece(wave: NearWave, weight: arb, top: int, first: fmpq, last: fmpq) -> dict[str, Any]:
    correction = _correction(wave, weight, top, (first + last) / 2)
    square = arb(first).union(arb(last))
    piece = TiePiece(wave, square, [arb(c) for c in correction], weight, arb("0.01"))
    bound = contracting_radius(tie_contraction(piece))
    texts = [decimal_text(arb(c)) for c in correction]
    return {"square": str(last), "bound": bound, "correction": texts}


def _correction(wave: NearWave, weight: arb, top: int, square: fmpq) -> list[float]:
    """Return sigma_1 and the modes 2 ... N of y_1 = -J^-1 R at eps^2 = ``square``, as floats."""
    piece = TiePiece(wave, arb(square), [arb(0)] * top, weight, arb("0.01"))
    known = np.array([float(c) for c in piece.stiffness[0]])
    known = np.pad(known, (0, max(0, 2 * top + 1 - len(known))))
    order = np.arange(1, top + 1)
    mobility = np.array([float(piece.mobility(int(j))) for j in order])
    linear = np.array([float(piece.linear(int(j))) for j in order])
    matrix = np.diag(linear) - mobility[:, None] * (
        known[np.abs(order[:, None] - order)] + known[order[:, None] + order]
    )
    matrix[:, 0] = [float(piece.modes[j]) for j in order]
    higher, _ = piece.higher
    defect = [
        float(piece.defect(j) - piece.mobility(j) * entry(higher, j)) for j in range(1, top + 1)
    ]
    solution: list[float] = np.linalg.solve(matrix, -np.array(defect)).tolist()
    return solution

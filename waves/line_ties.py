"""The tie of solitary waves to solitons for all small eps: its certificates."""

from __future__ import annotations

import math
from typing import Any

from flint import arb, arb_mat, ctx, fmpq

from longwave.waves.certificates import (
    contracting_radius,
    decimal_text,
    intervals,
    lattice_record,
    proved_pieces,
)
from longwave.waves.kernel.cosine_series import Series, entry
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.line_block import LineBlock
from longwave.waves.kernel.line_tie import (
    LineTiePiece,
    Soliton,
    defect,
    line_tie_contraction,
    tie_block,
)
from longwave.waves.kernel.line_tie_claim import LineTieClaim
from longwave.waves.kernel.periodic import Spring
from longwave.waves.kernel.reading import Record

BITS = 80
HALF_LENGTH, KAPPA = "7", "2.9"
"""Half-length of the computed interval and decay rate of the kernel, in the soliton's variable."""

BLOCKS, COUNTS = {2: 40, 3: 50}, {2: 80, 3: 150}
"""Highest mode of the inverted block and of the correction, by the power of the force."""

STEPS = 20
ACCURACY = 1e-5
"""Largest change of the correction in the last step of its computation."""

LARGEST_BOUND = fmpq(1, 2)
"""Largest norm of the remainder that is tried."""

PIECE, LEAST_PIECES, FIRST_PIECES, HALVINGS = fmpq(1, 4000), 4, 40, 5
"""Width of a piece of eps^2 at first, if it gives 4 to 40 pieces; how often one is halved."""


def line_tie_certificate(spring: Spring, eps: fmpq) -> dict[str, Any]:
    """Return the certificate that ties solitary waves to the soliton for 0 < eps' <= eps.

    Raises CertificateError with the inequality that failed.
    """
    with ctx.workprec(BITS):
        return _certificate(spring, Soliton.of(spring.force), eps)


def _certificate(spring: Spring, soliton: Soliton, eps: fmpq) -> dict[str, Any]:
    data: dict[str, Any] = {
        "kind": "line_tie",
        "version": 1,
        "lattice": lattice_record([spring]),
        "eps": str(eps),
        "bits": BITS,
        "half_length": HALF_LENGTH,
        "kappa": KAPPA,
        "block": BLOCKS[soliton.power],
    }
    data["pieces"] = Corrections(soliton).pieces(eps * eps)
    claim = LineTieClaim(Record(data, "certificate"))
    data["claims"] = intervals(claim.numbers(claim.read()))
    return data


class Corrections:
    """Corrections of a soliton on pieces of eps^2; each starts from the one before."""

    def __init__(self, soliton: Soliton) -> None:
        self.soliton = soliton
        self.modes: Series = [arb(0)] * (COUNTS[soliton.power] + 1)
        self.block: LineBlock | None = None

    def pieces(self, square: fmpq) -> list[dict[str, Any]]:
        """Return pieces that cover eps^2 = 0 ... ``square``; one whose proof fails is halved."""
        line_tie_contraction(self.at(arb(square)))  # refuses a large eps at once
        count = min(max(LEAST_PIECES, math.ceil(float(square / PIECE))), FIRST_PIECES)
        ends = [square * i / count for i in range(count + 1)]
        self._piece(square * (1 - fmpq(1, count << HALVINGS)), square)  # the hardest piece
        return proved_pieces(ends, self._piece, HALVINGS)

    def _piece(self, first: fmpq, last: fmpq) -> dict[str, Any]:
        self.solve(arb((first + last) / 2))
        piece = self.at(arb(first).union(arb(last)))
        bound = contracting_radius(line_tie_contraction(piece))
        correction = [decimal_text(c) for c in self.modes]
        return {"square": str(last), "bound": bound, "correction": correction}

    def at(self, square: arb) -> LineTiePiece:
        """Return the piece with the present correction for eps^2 in the ball ``square``."""
        return LineTiePiece(
            self.soliton,
            square,
            arb(HALF_LENGTH),
            arb(KAPPA),
            self.modes,
            BLOCKS[self.soliton.power],
            arb(LARGEST_BOUND),
        )

    def solve(self, square: arb) -> None:
        """Compute the correction at eps^2 = ``square`` by chord steps. Raises CertificateError."""
        for _ in range(STEPS):
            piece = self.at(square)
            block = self.block = self.block or tie_block(piece)[0]
            residual = defect(piece)
            change = _image(block, [entry(residual, n).mid() for n in range(len(self.modes))])
            self.modes = [arb(float(a - b)) for a, b in zip(self.modes, change, strict=True)]
            if max(abs(float(c)) for c in change) < ACCURACY:
                return
        raise CertificateError("the correction of the soliton was not found (take a smaller eps)")


def _image(block: LineBlock, f: Series) -> Series:
    """Return A f for the cosine series f."""
    count, root = block.count, arb(2).sqrt()
    scaled = [f[0] / root, *f[1:count]]
    inside = (block.inverse * arb_mat(count, 1, scaled)).entries()
    return [inside[0] * root, *inside[1:], *f[count:]]

"""Statement of a tie for all small eps: what its certificate claims, and what is proved."""

from __future__ import annotations

from flint import arb, fmpq

from .chain_reading import nearest_force, springs_of
from .cosine_series import largest, least, upper
from .elliptic_pins import NearWave
from .limits import MAX_MODES, CertificateError, decimal
from .reading import Ends, Record, pieces_to
from .tie import TiePiece, scaled_distance, tie_contraction

MAX_PIECES = 5000


class TieClaim:
    """The statement of a certificate for all small eps, and its pieces of the range of eps^2."""

    def __init__(self, record: Record) -> None:
        self.force = nearest_force(springs_of(record.record("lattice")), "the tie")
        near = record.record("near")
        name, k = near.text("form"), near.number("k")
        near.close()
        self.eps = record.number("eps")
        if not (self.eps > 0 and self.force.polynomial is not None):
            raise CertificateError("the tie is proved for eps > 0 and a polynomial force")
        self.wave = NearWave(name, k, fmpq(1), self.force)
        self.weight = arb(record.number("weight"))
        self.pieces = record.items("pieces", MAX_PIECES)

    def prove(self) -> dict[str, Ends]:
        """Return the proved constants for all eps. Raises CertificateError if a piece fails."""
        low, high, speed = [], [], []
        for item, first, last in pieces_to(self.eps * self.eps, self.pieces):
            piece, bound = _tie_piece(item, self.wave, self.weight, first, last)
            tie_contraction(piece).require(bound)
            change = abs(piece.correction[0]) + bound / self.weight
            square = upper(piece.square)
            if not piece.k2 - square * (abs(piece.sigma) + square * change) > 0:
                raise CertificateError("v^2 > 0 is not proved")
            ends = scaled_distance(piece, bound)
            low.append(ends[0])
            high.append(ends[1])
            speed.append(upper(change))
        return {
            self.distance: (least(low), largest(high)),
            "speed_over_eps4": (arb(0), largest(speed)),
        }

    @property
    def distance(self) -> str:
        """Name of the scaled distance sup |f - eps^p Y|/eps^(p + 2)."""
        return f"distance_over_eps{self.wave.form.order + 2}"

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        return (
            f"For every 0 < eps <= {self.eps} the chain of unit masses with V'(r) = "
            f"{self.force.text} has a smooth even periodic strain f(n - v t) with period, mean and "
            f"first mode of {self.wave.scaled}, Y the {self.wave.name} wave of the "
            f"{self.wave.equation} with k = {self.wave.k}. Here {self.distance} is sup |f - "
            f"{self.wave.scaled}|/eps^{self.wave.form.order + 2}, and "
            "speed_over_eps4 is |v^2 - K2 - sigma_0 eps^2|/eps^4."
        )


def _tie_piece(
    item: Record, wave: NearWave, weight: arb, first: fmpq, last: fmpq
) -> tuple[TiePiece, arb]:
    """Read the piece of eps^2 from ``first`` to ``last``; return it and its bound c."""
    bound = arb(item.number("bound"))
    correction = [arb(decimal(c)) for c in item.items("correction", MAX_MODES)]
    item.close()
    if not bound > 0 or not weight > 0 or len(correction) < 2:
        raise CertificateError("bound > 0, weight > 0 and at least two modes must hold")
    square = arb(first).union(arb(last))
    return TiePiece(wave, square, correction, weight, upper(bound * arb(last))), bound

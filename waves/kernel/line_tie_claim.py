"""Statement of a tie to a soliton for all small eps: what its certificate claims."""

from __future__ import annotations

from collections.abc import Iterator

from flint import arb

from .chain_reading import nearest_force, springs_of
from .cosine_series import largest, least, upper
from .limits import MAX_MODES, CertificateError, decimal
from .line_tie import LineTiePiece, Soliton, line_tie_contraction
from .reading import Ends, Record, pieces_to
from .tie_claim import MAX_PIECES


class LineTieClaim:
    """The statement of a certificate for all small eps, and its pieces of the range of eps^2."""

    def __init__(self, record: Record) -> None:
        self.force = nearest_force(springs_of(record.record("lattice")), "the tie")
        self.eps = record.number("eps")
        if not self.eps > 0:
            raise CertificateError(f"eps must be > 0, got {self.eps}")
        self.soliton = Soliton.of(self.force)
        self.half_length = arb(record.number("half_length"))
        self.kappa = arb(record.number("kappa"))
        self.block = record.integer("block", 1, MAX_MODES)
        self.pieces = record.items("pieces", MAX_PIECES)

    def prove(self) -> dict[str, Ends]:
        """Return the proved constants for all eps. Raises CertificateError if a piece fails."""
        return self.numbers(self._proved())

    def _proved(self) -> Iterator[LineTiePiece]:
        for piece in self.read():
            line_tie_contraction(piece).require(piece.bound)
            if not upper(piece.square) * piece.distance[1] < piece.soliton.crest:
                raise CertificateError("the wave is not proved to differ from 0")
            yield piece

    def read(self) -> Iterator[LineTiePiece]:
        """Yield the pieces. Raises CertificateError unless they cover 0 < eps^2 <= its largest."""
        for item, first, last in pieces_to(self.eps * self.eps, self.pieces):
            correction = [arb(decimal(c)) for c in item.items("correction", MAX_MODES)]
            bound = arb(item.number("bound"))
            item.close()
            square = arb(first).union(arb(last))
            yield LineTiePiece(
                self.soliton, square, self.half_length, self.kappa, correction, self.block, bound
            )

    def numbers(self, pieces: Iterator[LineTiePiece]) -> dict[str, Ends]:
        """Return the bounds of the distance on proved ``pieces``."""
        low, high = zip(*(piece.distance for piece in pieces), strict=True)
        scale = self.soliton.amplitude
        return {self.distance: ((least(low) * scale).lower(), upper(largest(high) * scale))}

    @property
    def order(self) -> int:
        """Power of eps of the strain: 2 for KdV, 1 for the modified KdV equation."""
        return 2 if self.soliton.power == 2 else 1

    @property
    def distance(self) -> str:
        """Name of the scaled distance."""
        return f"distance_over_eps{self.order + 2}"

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        soliton = self.soliton
        if self.order == 2:
            name, equation = "eps^2 Y", "KdV equation"
            wave = f"eps^2 ({3 * soliton.scale / 2}) sech(3^(1/2) eps x)^2"
        else:
            name, equation = "eps Y", "modified KdV equation"
            wave = f"eps ({2 * soliton.scale})^(1/2) sech(12^(1/2) eps x)"
        return (
            f"For every 0 < eps <= {self.eps} the chain of unit masses with V'(r) = "
            f"{self.force.text} has a smooth even solitary strain f(n - v t), f in L^2 and not 0, "
            f"with v^2 = K2 (1 + eps^2), K2 = {soliton.stiffness}, next to {name}(x) = {wave}, "
            f"the soliton of the {equation}. Here {self.distance} is the supremum of |f - {name}| "
            f"over eps^{self.order + 2}."
        )

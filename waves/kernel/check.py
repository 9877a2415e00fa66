"""Check a certificate of a wave: read the statement, repeat its proof, and say what it proves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from flint import ctx

from .exponent_claim import ExponentClaim
from .limits import MAX_BITS, MIN_BITS, VERSION, CertificateError
from .line_tie_claim import LineTieClaim
from .orbit_claim import BreatherClaim, OrbitClaim
from .periodic_claim import PeriodicClaim
from .reading import Ends, Record, check_claims
from .ring_claim import RingClaim
from .solitary_claim import SolitaryClaim
from .tie_claim import TieClaim


class WaveClaim(Protocol):
    """A statement read from a certificate."""

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""

    def prove(self) -> dict[str, Ends]:
        """Return the bounds of each number. Raises CertificateError if the proof fails."""


CLAIMS: Mapping[str, Callable[[Record], WaveClaim]] = {
    "periodic": PeriodicClaim,
    "solitary": SolitaryClaim,
    "exponent": ExponentClaim,
    "ring": RingClaim,
    "tie": TieClaim,
    "line_tie": LineTieClaim,
    "orbit": OrbitClaim,
    "breather": BreatherClaim,
}
"""Statements that can be proved, by the kind of their certificate."""


def check_certificate(data: object) -> str:
    """Return what a certificate proves, in words. Raises CertificateError if it proves nothing."""
    record = Record(data, "certificate")
    kind = record.text("kind")
    if kind not in CLAIMS:
        raise CertificateError(f"kind must be one of {', '.join(CLAIMS)}, got {kind[:40]!r}")
    if record.integer("version", 1, VERSION) != VERSION:
        raise CertificateError(f"version must be {VERSION}")
    bits = record.integer("bits", MIN_BITS, MAX_BITS)
    try:
        with ctx.workprec(bits):
            claim = CLAIMS[kind](record)
            lines = check_claims(record.record("claims"), claim.prove())
            record.close()
            return "\n".join([claim.statement, *lines])
    except (ValueError, ZeroDivisionError, OverflowError, RecursionError) as error:
        raise CertificateError(str(error) or type(error).__name__) from error

"""Numbers of certificates: radii that contract, decimals, and intervals rounded outwards."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any, Protocol

from flint import arb, ctx, fmpq

from longwave.waves.kernel.limits import CertificateError, decimal
from longwave.waves.kernel.periodic import Contraction, Spring
from longwave.waves.kernel.reading import Ends

DIGITS = 40
"""Significant digits of the numbers in a certificate."""

LEAST_RADIUS = 1e-38

MOST_PIECES = 4096
"""Largest number of pieces of a range of eps^2."""


class ClaimOfRadius(Protocol):
    """A statement that holds within a radius of its centre."""

    radius: arb

    def prove(self) -> dict[str, Ends]:
        """Return the bounds of each number. Raises CertificateError if the proof fails."""


def lattice_record(springs: Sequence[Spring]) -> dict[str, Any]:
    """Return the lattice of a certificate."""
    return {"springs": [{"neighbour": s.neighbour, "force": s.force.text} for s in springs]}


def completed(data: Mapping[str, Any], claim: ClaimOfRadius, bounds: Contraction) -> dict[str, Any]:
    """Return a certificate with a radius that contracts, and with what ``claim`` proves for it.

    Raises CertificateError.
    """
    radius = contracting_radius(bounds)
    claim.radius = arb(decimal(radius))
    return {**data, "radius": radius, "claims": intervals(claim.prove())}


def proved_pieces(
    ends: Iterable[fmpq], prove: Callable[[fmpq, fmpq], dict[str, Any]], halvings: int
) -> list[dict[str, Any]]:
    """Return certificates of the pieces between ``ends``; a piece whose proof fails is halved.

    Raises the CertificateError of a piece that was halved ``halvings`` times.
    """
    remaining = [(first, last, halvings) for first, last in pairwise(ends)][::-1]
    pieces: list[dict[str, Any]] = []
    while remaining:
        first, last, left = remaining.pop()
        try:
            pieces.append(prove(first, last))
        except CertificateError:
            if not left or len(pieces) + len(remaining) >= MOST_PIECES:
                raise
            middle = (first + last) / 2
            remaining += [(middle, last, left - 1), (first, middle, left - 1)]
    return pieces


def contracting_radius(bounds: Contraction) -> str:
    """Return a radius, rounded up, of a ball that the map with these ``bounds`` contracts.

    Raises CertificateError with the inequality that fails for every radius.
    """
    gap = 1 - bounds.z0 - bounds.z1
    if not gap > 0:
        raise CertificateError(f"Z < 1 fails: {(1 - gap).str(4, radius=False)} (take more modes)")
    root = gap * gap - 2 * bounds.y0 * bounds.z2
    if not root > 0:
        raise CertificateError(
            f"2 Y0 Z2 < (1 - Z)^2 fails: Y0 = {bounds.y0.str(4, radius=False)}, "
            f"Z2 = {bounds.z2.str(4, radius=False)} (take more modes)"
        )
    radius = 2 * bounds.y0 / (gap + root.sqrt())
    return f"{max(float(radius.upper()), LEAST_RADIUS) * 1.001:.4e}"


def decimal_text(value: arb) -> str:
    """Return the midpoint of a ball as a decimal."""
    return str(value.mid().str(DIGITS, radius=False))


def intervals(numbers: Mapping[str, Ends]) -> dict[str, list[str]]:
    """Return the ends of each number as decimals, rounded outwards."""
    return {name: interval(ends) for name, ends in numbers.items()}


def interval(ends: Ends) -> list[str]:
    """Return the lower and the upper end of an interval as decimals, rounded outwards."""
    return [_rounded(ends[0], -1), _rounded(ends[1], 1)]


def _rounded(end: arb, direction: int) -> str:
    if end.is_zero():
        return "0"
    step = arb(2) ** (8 - min(ctx.prec, 120))
    return decimal_text(end + direction * (abs(end) + 1) * step)

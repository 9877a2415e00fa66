"""Numbers of certificates: radii that contract, decimals, and intervals rounded outwards."""

from __future__ import annotations

from flint import arb, ctx

from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic import Contraction

DIGITS = 40
"""Significant digits of the numbers in a certificate."""

LEAST_RADIUS = 1e-38


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


def interval(ends: tuple[arb, arb]) -> list[str]:
    """Return the lower and the upper end of an interval as decimals, rounded outwards."""
    return [_rounded(ends[0], -1), _rounded(ends[1], 1)]


def _rounded(end: arb, direction: int) -> str:
    if end.is_zero():
        return "0"
    step = arb(2) ** (8 - min(ctx.prec, 120))
    return decimal_text(end + direction * (abs(end) + 1) * step)

"""Format of certificates, limits on their cost, and the error for one that is rejected."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

FORMAT = "longwave proof 4"

FILE_BYTES = 8_000_000
"""Largest file of certificates; the largest certificate of the catalogue has 0.2 MB."""

NODES, DEPTH = 20_000, 500
GENERATORS, ORDER = 64, 12
DIGITS, EXPONENT, NAME, SHIFT = 2_000, 1_000, 60, 1_000

NESTING = 60
"""Deepest nesting of brackets in one text; deeper formulas refer to named parts."""

FORMS, PARTS = 4, 8
"""Most linear forms in one group, and most equal parts on which a proof may rest."""

WORK = 50_000_000
"""Most products of terms in all polynomial multiplications; the catalogue needs a tenth."""

HEIGHT = 1_000_000
"""Most bits of a coefficient of a power; those of the catalogue have at most a few hundred."""

DEGREE = 3_000
"""Highest total degree of a polynomial."""

BRANCHES = 64
"""Most branches of roots and absolute values on which a denominator is tested."""

FACTOR_TERMS, FACTOR_DEGREE = 400, 100
"""Most terms, and highest total degree, of a denominator that is split into irreducible factors."""


class CertificateError(ValueError):
    """Raised for a certificate that does not prove its statement; the message gives the reason."""


def within(what: str, got: int, limit: int) -> int:
    """Return ``got``, or raise CertificateError if it exceeds ``limit``; ``what`` names it."""
    if got > limit:
        raise CertificateError(f"{what} must be at most {limit}, got {got} (prove less at once)")
    return got


def digest(body: Mapping[str, Any]) -> str:
    """Return a checksum of all entries but "digest", which detects accidental changes."""
    plain = {key: value for key, value in body.items() if key != "digest"}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()

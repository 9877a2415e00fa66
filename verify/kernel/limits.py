"""The outer form of a certificate, how much it may cost, and the error of one that is refused."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

FORMAT = "longwave proof 4"

FILE_BYTES = 8_000_000
"""The largest certificate of the catalogue has 0.2 MB."""

NODES, DEPTH = 20_000, 500
GENERATORS, ORDER = 64, 12
DIGITS, EXPONENT, NAME, SHIFT = 2_000, 1_000, 60, 1_000

NESTING = 60
"""Brackets in brackets in one text; what is deeper has names."""

FORMS, PARTS = 4, 8
"""Most linear forms that belong together, and most equal parts that a proof may rest on."""

WORK = 50_000_000
"""Most products of terms in all polynomial multiplications; the catalogue needs a tenth."""

HEIGHT = 1_000_000
"""Bits of the coefficients of a power; the catalogue's have at most some hundred."""

DEGREE = 3_000
"""Total degree of a polynomial."""

BRANCHES = 64
"""Branches of roots and absolute values that a denominator is tried on."""

FACTOR_TERMS, FACTOR_DEGREE = 400, 100
"""A denominator beyond either is not split into irreducible factors."""


class CertificateError(ValueError):
    """A certificate does not prove what it says; the message says where it fails."""


def within(what: str, got: int, limit: int) -> int:
    """``got`` if it is at most ``limit``; raises CertificateError otherwise."""
    if got > limit:
        raise CertificateError(f"{what} must be at most {limit}, got {got} (prove less at once)")
    return got


def digest(body: Mapping[str, Any]) -> str:
    """Return a checksum of everything but itself, against slips of the pen."""
    plain = {key: value for key, value in body.items() if key != "digest"}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()

"""Error of the checker, sizes it accepts, and exact numbers from text."""

from __future__ import annotations

import re

from flint import fmpq

VERSION = 1
"""Version of the certificates' format."""

MAX_MODES, MAX_BITS, MIN_BITS = 2000, 1024, 53
FILE_BYTES = 20_000_000
MAX_ENTRIES = 1_500_000
"""Maximum number of matrix entries of a linear problem, or of symbols evaluated for a force."""
MAX_DIGITS = 400


class CertificateError(ValueError):
    """Error raised for a certificate that is malformed or does not prove what it claims."""


def preview(value: object) -> str:
    """Return the first characters of a value; of an integer that is too long, its size.

    >>> preview(10**5000)
    'an integer of 16610 bits'
    """
    if isinstance(value, int) and value.bit_length() > 400:
        return f"an integer of {value.bit_length()} bits"
    return str(value)[:40]


def require_size(entries: int) -> None:
    """Raise CertificateError for a linear problem that is too large."""
    if entries > MAX_ENTRIES:
        raise CertificateError(f"the problem must have at most {MAX_ENTRIES} entries, {entries=}")


_NUMBER = re.compile(r"([-+]?\d+)(?:\.(\d*))?(?:[eE]([-+]?\d{1,4}))?(?:/(\d+))?", re.ASCII)


def decimal(text: object) -> fmpq:
    """Return the exact value of a decimal or a fraction of integers. Raises CertificateError.

    >>> decimal("2.50"), decimal("-1/3"), decimal("1e-2")
    (5/2, -1/3, 1/100)
    """
    match = _NUMBER.fullmatch(text) if isinstance(text, str) and len(text) <= MAX_DIGITS else None
    if not match or (match[4] and (match[2] is not None or match[3])) or match[4] == "0":
        raise CertificateError(f"a number must be a decimal or a fraction, got {preview(text)!r}")
    whole, digits, power, below = match.groups()
    value = fmpq(int(whole + (digits or "")), int(below or 1))
    return value * fmpq(10) ** (int(power or 0) - len(digits or ""))

"""A second opinion on a certificate, with arithmetic of its own.

Nothing of the prover's reduction is used here.  By balls (`meanings`), at the certificate's point
and at one it did not choose: meanings, slopes, relations and images fit together, and no
denominator vanishes.  By exact polynomial arithmetic (`identity`): the numerator of the residual
is 0 modulo the relations.
"""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

import sympy as sp
from flint import ctx

from .balls import Point
from .digest import FORMAT, digest
from .identity import Identity
from .meanings import CertificateError, Meanings
from .tree import expressions, rational

BITS = 400
SHIFT = 1009
"""The second point is off by a part in about this many, in each coordinate."""


def check_certificate(data: Mapping[str, Any]) -> None:
    """Repeat the proof in ``data``; raises CertificateError if any part of it fails."""
    try:
        _check(data)
    except CertificateError:
        raise
    except KeyError as error:
        raise CertificateError(f"the certificate lacks {error}") from error
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError) as error:
        raise CertificateError(f"the certificate cannot be read: {error}") from error


def _check(data: Mapping[str, Any]) -> None:
    if data["format"] != FORMAT:
        raise CertificateError(f"format must be {FORMAT!r}, got {data['format']!r}")
    if digest(data) != data["digest"]:
        raise CertificateError("the digest does not match the content")
    identity = Identity(data)
    found = expressions(data["nodes"])
    point = {found[place]: rational(value) for place, value in data["point"]}
    with ctx.workprec(BITS):
        for place in (point, nearby(point, data["digest"])):
            Meanings(data, identity, found, place).check()
    if not identity.residual(data["equation"]).is_zero():
        raise CertificateError("the numerator of the residual is not 0")


def nearby(point: Point, seed: str) -> Point:
    """A point close by that the certificate did not choose.

    What is an identity of analytic functions holds there too; what only fits the numbers of the
    certificate's point does not.
    """
    draw = random.Random(seed)
    return {
        symbol: value * (1 + sp.Rational(draw.randint(1, SHIFT), SHIFT**2))
        for symbol, value in sorted(point.items(), key=str)
    }

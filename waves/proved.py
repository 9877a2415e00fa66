"""Motions of a lattice with a proof: the verdict, and each number as an interval."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from flint import fmpq

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.formula_expression import exact_value
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.springs import Refused


class Existence(StrEnum):
    """Verdict on a wave: EXISTS if proved, REFUSED if no theorem applies, else NOT_PROVED."""

    EXISTS = "EXISTS"
    NOT_PROVED = "NOT PROVED"
    REFUSED = "REFUSED"


@dataclass(frozen=True)
class Interval:
    """A proved interval; its ends are decimals, rounded outwards."""

    lower: str
    upper: str

    @classmethod
    def around(cls, value: Fraction) -> Interval:
        """Return an interval with decimal ends that contains an exact number."""
        scaled = value * 10**40
        low = scaled.numerator // scaled.denominator
        high = -(-scaled.numerator // scaled.denominator)
        return cls(f"{low}e-40", f"{high}e-40")

    @property
    def value(self) -> float:
        """Midpoint of the interval."""
        return float((Fraction(self.lower) + Fraction(self.upper)) / 2)

    @property
    def error(self) -> float:
        """Half of the interval's width, rounded up."""
        width = float((Fraction(self.upper) - Fraction(self.lower)) / 2)
        return float(np.nextafter(width, np.inf))

    def __str__(self) -> str:
        return f"{self.lower} ... {self.upper}"


@dataclass(frozen=True)
class Proved:
    """Motion of a lattice, with the verdict on its existence and its proved numbers.

    ``reason`` says what failed if the motion is not proved. ``statement`` is the theorem in words.
    """

    verdict: Existence
    reason: str = ""
    statement: str = ""
    certificate: Mapping[str, Any] = field(default_factory=dict, repr=False)

    @property
    def radius(self) -> float:
        """Bound of the distance between the motion and the certificate's series."""
        return float(self.certificate["radius"])

    @property
    def numbers(self) -> dict[str, Interval]:
        """Proved numbers by name."""
        claims = self.certificate.get("claims", {})
        return {name: Interval(*ends) for name, ends in claims.items()}

    def save(self, path: str | Path) -> None:
        """Write the certificate, for ``longwave check`` and for scenes."""
        Path(path).write_text(json.dumps(self.certificate, indent=1) + "\n", encoding="utf-8")

    def to_json(self) -> dict[str, Any]:
        """Return verdict, reason, the radius of one wave, and both ends of each number."""
        numbers = {n: {"lower": i.lower, "upper": i.upper} for n, i in self.numbers.items()}
        radius = {name: self.certificate[name] for name in ("radius",) if name in self.certificate}
        return {"verdict": str(self.verdict), "reason": self.reason, **radius, **numbers}


Motion = TypeVar("Motion", bound=Proved)


def proved(find: Callable[[], dict[str, Any]], motion: type[Motion]) -> Motion:
    """Check the certificate that ``find`` returns, and return the motion with the verdict."""
    try:
        certificate = find()
        statement = check_certificate(certificate)
    except Refused as refusal:
        return motion(Existence.REFUSED, str(refusal))
    except (CertificateError, ArithmeticError) as failure:
        return motion(Existence.NOT_PROVED, str(failure))
    return motion(Existence.EXISTS, statement=statement, certificate=certificate)


def rational(name: str, value: Number) -> fmpq:
    """Return an exact rational number. Raises ValueError for any other value."""
    number = exact_value(name, value)
    if not number.is_Rational:
        raise ValueError(f"{name} must be a rational number, got {value} (such as 3/5)")
    return fmpq(int(number.p), int(number.q))

"""Stability of a periodic wave on a ring: all its Floquet exponents, or one that grows, proved."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

import numpy as np
from flint import acb, arb, ctx, fmpq

from longwave.waves.certificates import contracting_radius, decimal_text
from longwave.waves.exponents import (
    LEAST_COMPONENTS,
    RADIUS_BOUND,
    Components,
    approximate_centre,
    approximate_exponents,
    exponent_certificate,
    refined,
)
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.exponent import ExponentCentre, Stiffness, exponent_contraction
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic_claim import PeriodicClaim
from longwave.waves.kernel.reading import Record
from longwave.waves.kernel.ring_claim import MAX_WAVELENGTHS
from longwave.waves.proved import Interval

VISIBLE_GROWTH = 1e-7
"""Growth of an approximate exponent, over v, from which on an instability is to be proved."""

ZERO = 1e-4
"""Distance from 0 over v below which an approximate exponent at Bloch number 0 counts as 0."""

SEPARATION = 1e-9
"""Distance of approximate exponents over 2 pi v below which they count as one."""


class Stability(StrEnum):
    """Verdict on a ring: STABLE and UNSTABLE are proved."""

    STABLE = "STABLE"
    UNSTABLE = "UNSTABLE"
    NOT_PROVED = "NOT PROVED"


@dataclass(frozen=True)
class RingStability:
    """Verdict on the stability of a wave on a ring of ``wavelengths``, with its certificate.

    ``growth`` is the largest approximate growth rate, without an error; ``bloch`` is its Bloch
    number. ``reason`` says why nothing is proved.
    """

    verdict: Stability
    wavelengths: int
    growth: float
    bloch: fmpq
    reason: str = ""
    statement: str = ""
    certificate: Mapping[str, Any] = field(default_factory=dict, repr=False)

    @property
    def proved_growth(self) -> Interval | None:
        """Growth rate of the certificate; None if none is proved."""
        claims = self.certificate.get("claims")
        return Interval(*claims["growth"]) if claims else None

    def to_json(self) -> dict[str, Any]:
        """Return the verdict, the Bloch number, and the growth as two decimals or as computed."""
        proved = self.proved_growth
        return {
            "wavelengths": self.wavelengths,
            "verdict": str(self.verdict),
            "bloch": str(self.bloch),
            "growth": vars(proved) if proved else f"{self.growth:.3e}",
            "proved": proved is not None,
        }


def ring_stability(certificate: Mapping[str, Any], wavelengths: int) -> RingStability:
    """Decide whether a periodic wave is spectrally stable on a ring of its wavelengths.

    Raises ValueError for a number of wavelengths outside 1 ... 256 or a period that is not an
    integer.
    """
    if not 1 <= wavelengths <= MAX_WAVELENGTHS:
        raise ValueError(f"wavelengths must be 1 to {MAX_WAVELENGTHS}, got {wavelengths}")
    with ctx.workprec(int(certificate["bits"])):
        wave = PeriodicClaim(Record(dict(certificate), "certificate"))
        if wave.cells is None or wave.cells.q != 1:
            raise ValueError(
                "a ring needs a wave whose period is an integer number of cells (give period=10 "
                "instead of eps)"
            )
        stiffness = wave.stiffness
        blochs = [fmpq(m, wavelengths) for m in range(wavelengths // 2 + 1)]
        spectra = [_spectrum(stiffness, bloch) for bloch in blochs]
        worst = max(range(len(blochs)), key=lambda m: _growth(spectra[m]))
        growth, speed = _growth(spectra[worst]), float(stiffness.speed)
        known = RingStability(Stability.NOT_PROVED, wavelengths, growth, blochs[worst])
        try:
            if growth > VISIBLE_GROWTH * speed:
                return _unstable(known, certificate, spectra[worst])
            return _stable(known, certificate, stiffness, blochs, spectra)
        except CertificateError as reason:
            return replace(known, reason=str(reason))


Spectrum = list[tuple[complex, Components]]
"""Approximate exponents, one of each class modulo 2 pi i v, with their vectors."""


def _growth(spectrum: Spectrum) -> float:
    return max((value.real for value, _ in spectrum), default=0.0)


def _spectrum(stiffness: Stiffness, bloch: fmpq) -> Spectrum:
    """Return approximations of the exponents at a Bloch number, without those that are 0."""
    cells, turn = float(stiffness.period), 2 * math.pi * float(stiffness.speed)
    top = math.ceil(cells / 2) + LEAST_COMPONENTS
    values, vectors = approximate_exponents(stiffness, bloch, top)
    centres = np.abs(np.argmax(np.abs(vectors), axis=0) - top + float(bloch))
    chosen: Spectrum = []
    for index in np.argsort(centres):
        value = complex(values[index])
        fold = value.imag / turn - round(value.imag / turn)
        if bloch == 0 and abs(complex(value.real, fold * turn)) < ZERO * turn:
            continue
        if all(_distance(value, other, turn) > SEPARATION for other, _ in chosen):
            chosen.append((value, vectors[:, index]))
        if len(chosen) == 2 * round(cells) - (0 if bloch else 4):
            break
    return chosen


def _distance(value: complex, other: complex, turn: float) -> float:
    difference = (value - other) / turn
    return abs(complex(difference.real, difference.imag - round(difference.imag)))


def _unstable(
    known: RingStability, certificate: Mapping[str, Any], spectrum: Spectrum
) -> RingStability:
    value, vector = max(spectrum, key=lambda pair: pair[0].real)
    found = exponent_certificate(certificate, known.bloch, value, vector)
    statement = check_certificate(found)
    if not arb(found["claims"]["growth"][0]) > 0:
        return replace(known, reason="the largest growth is not proved to be positive")
    return replace(known, verdict=Stability.UNSTABLE, statement=statement, certificate=found)


def _stable(
    known: RingStability,
    certificate: Mapping[str, Any],
    stiffness: Stiffness,
    blochs: list[fmpq],
    spectra: list[Spectrum],
) -> RingStability:
    data = {
        "kind": "ring",
        "version": 1,
        "bits": certificate["bits"],
        "wave": dict(certificate),
        "wavelengths": known.wavelengths,
        "radius_bound": RADIUS_BOUND,
        "spectra": [
            [_enclosure(stiffness, bloch, *pair) for pair in spectrum]
            for bloch, spectrum in zip(blochs, spectra, strict=True)
        ],
        "claims": {"growth": ["0", "0"]},
    }
    statement = check_certificate(data)
    return replace(known, verdict=Stability.STABLE, statement=statement, certificate=data)


def _enclosure(
    stiffness: Stiffness, bloch: fmpq, exponent: complex, vector: Components
) -> dict[str, Any]:
    """Return the entry of an imaginary exponent in a ring's certificate."""
    centre = refined(approximate_centre(stiffness, bloch, 1j * exponent.imag, vector))
    texts = [decimal_text(w.real) for w in centre.vector]
    frequency = decimal_text(centre.exponent.imag)
    real = ExponentCentre(
        stiffness,
        bloch,
        acb(arb(0), arb(frequency)),
        [acb(arb(text)) for text in texts],
        centre.fixed,
        centre.radius_bound,
    )
    radius = contracting_radius(exponent_contraction(real))
    return {"frequency": frequency, "fixed": centre.fixed, "radius": radius, "vector": texts}

"""Profiles of exact waves in double precision, from their certificates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from flint import ctx
from numpy.typing import NDArray

from longwave.waves.kernel.periodic_claim import PeriodicClaim
from longwave.waves.kernel.reading import Record
from longwave.waves.kernel.solitary_claim import SolitaryClaim

Vector = NDArray[np.float64]


def strain(certificate: Mapping[str, Any], x: Vector) -> Vector:
    """Return the strain f(x) of a certificate's wave; its crest or trough is at x = 0."""
    modes, length, inside = _series(certificate)
    angle = 2 * np.pi * x / length
    order = np.arange(len(modes))
    values = np.cos(np.multiply.outer(angle, order)) @ (modes * np.where(order, 2, 1))
    return np.where(np.abs(x) <= length / 2, values, 0.0) if inside else values


def _series(certificate: Mapping[str, Any]) -> tuple[Vector, float, bool]:
    """Return the cosine modes, the period of the series, and whether the wave is solitary."""
    with ctx.workprec(int(certificate["bits"])):
        record = Record(dict(certificate), "certificate")
        if record.text("kind") == "solitary":
            centre = SolitaryClaim(record).centre
            modes = np.array([float(c) for c in centre.strain])
            return modes, 2 * float(centre.half_length), True
        wave = PeriodicClaim(record).centre
        return np.array([float(c) for c in wave.modes]), float(wave.period), False

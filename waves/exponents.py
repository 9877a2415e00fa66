"""Floquet exponents of periodic waves: approximations by an eigenvalue problem, then proofs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from flint import acb, acb_mat, arb, ctx, fmpq
from numpy.typing import NDArray

from longwave.waves.certificates import completed, decimal_text
from longwave.waves.kernel.exponent import ExponentCentre, Stiffness, exponent_contraction
from longwave.waves.kernel.exponent_claim import ExponentClaim
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic_claim import PeriodicClaim
from longwave.waves.kernel.reading import Record

Components = NDArray[np.complex128]

COMPONENTS_PER_CELL, LEAST_COMPONENTS = 1.2, 12
RADIUS_BOUND = "1e-6"
"""Largest radius of an exponent's enclosure, in the norm of exponent and vector."""


def approximate_exponents(
    stiffness: Stiffness, bloch: fmpq, top: int
) -> tuple[Components, NDArray[np.complex128]]:
    """Return the Floquet exponents at wavenumber 2 pi ``bloch``/period, and vectors as columns.

    ``stiffness`` is that of a wave (`wave_stiffness`). The vectors are cut to the components
    -``top`` ... ``top``; exponents with a large imaginary part are therefore wrong.
    """
    modes = np.array([float(c) for c in stiffness.modes])
    modes = np.pad(modes, (0, max(0, 2 * top + 1 - len(modes))))
    order = np.arange(-top, top + 1)
    wavenumbers = 2 * np.pi * (float(bloch) + order) / float(stiffness.period)
    drift = np.diag(1j * float(stiffness.speed) * wavenumbers)
    matrix = 4 * np.sin(wavenumbers / 2)[:, None] ** 2 * modes[np.abs(order[:, None] - order)]
    identity = np.eye(2 * top + 1)
    values, vectors = np.linalg.eig(np.block([[drift, identity], [-matrix, drift]]))
    return values, vectors[: 2 * top + 1]


def exponent_certificate(
    certificate: Mapping[str, Any], bloch: fmpq, exponent: complex, vector: Components
) -> dict[str, Any]:
    """Return the certificate of an exponent, from its approximation and that of its ``vector``.

    Raises CertificateError if the proof fails.
    """
    with ctx.workprec(int(certificate["bits"])):
        return _prove(certificate, bloch, exponent, vector)


def most_unstable(certificate: Mapping[str, Any], bloch: fmpq) -> dict[str, Any]:
    """Return the certificate of the exponent with the largest growth.

    Raises CertificateError if the proof fails.

    A wave number kappa and kappa + 2 pi are the same on the lattice; the vector's largest component
    is in the first Brillouin zone.
    """
    stiffness = wave_stiffness(certificate)
    period = float(stiffness.period)
    top = max(LEAST_COMPONENTS, math.ceil(COMPONENTS_PER_CELL * period))
    values, vectors = approximate_exponents(stiffness, bloch, top)
    largest = np.argmax(np.abs(vectors), axis=0) - top
    inside = np.nonzero(np.abs(largest + float(bloch)) <= period / 2)[0]
    index = inside[int(np.argmax(values[inside].real))]
    return exponent_certificate(certificate, bloch, values[index], vectors[:, index])


def wave_stiffness(certificate: Mapping[str, Any]) -> Stiffness:
    """Return V''(f) of a periodic wave from its certificate."""
    return PeriodicClaim(Record(dict(certificate), "certificate")).stiffness


def _prove(
    certificate: Mapping[str, Any], bloch: fmpq, exponent: complex, vector: Components
) -> dict[str, Any]:
    data: dict[str, Any] = {
        "kind": "exponent",
        "version": 1,
        "wave": dict(certificate),
        "bits": certificate["bits"],
        "bloch": str(bloch),
        "fixed": int(np.argmax(np.abs(vector))) - len(vector) // 2,
        "radius_bound": RADIUS_BOUND,
        "radius": RADIUS_BOUND,
    }
    stiffness = wave_stiffness(certificate)
    centre = refined(approximate_centre(stiffness, bloch, exponent, vector))
    data |= {
        "growth": decimal_text(centre.exponent.real),
        "frequency": decimal_text(centre.exponent.imag),
        "vector": [[decimal_text(w.real), decimal_text(w.imag)] for w in centre.vector],
    }
    claim = ExponentClaim(Record(dict(data), "certificate"))
    return completed(data, claim, exponent_contraction(claim.centre))


def approximate_centre(
    stiffness: Stiffness, bloch: fmpq, exponent: complex, vector: Components
) -> ExponentCentre:
    """Return a centre from an approximate exponent; its vector's largest component is set to 1."""
    fixed = int(np.argmax(np.abs(vector)))
    scaled = [acb(complex(c)) for c in vector / vector[fixed]]
    scaled[fixed] = acb(1)
    top = len(vector) // 2
    return ExponentCentre(
        stiffness, bloch, acb(complex(exponent)), scaled, fixed - top, arb(RADIUS_BOUND)
    )


def refined(centre: ExponentCentre) -> ExponentCentre:
    """Return the centre after chord iterations in ball arithmetic."""
    inverse = acb_mat(_float_inverse(centre))
    place = centre.fixed + centre.top
    for _ in range(5):
        rows = range(-centre.top, centre.top + 1)
        step = inverse * acb_mat([[centre.residual(j).mid()] for j in rows])
        vector = [(w - step[i, 0]).mid() for i, w in enumerate(centre.vector)]
        exponent, vector[place] = (centre.exponent - step[place, 0]).mid(), acb(1)
        centre = replace(centre, exponent=exponent, vector=vector)
        if max(float(abs(step[i, 0]).mid()) for i in range(len(vector))) < 1e-28:
            break
    return centre


def _float_inverse(centre: ExponentCentre) -> list[list[complex]]:
    top = centre.top
    order = np.arange(-top, top + 1)
    modes = np.array([float(c) for c in centre.stiffness.modes])
    modes = np.pad(modes, (0, max(0, 2 * top + 1 - len(modes))))
    rates = np.array([complex(centre.rate(int(j))) for j in order])
    rows = np.array([float(centre.couplings[int(j)]) for j in order])
    matrix = rows[:, None] * modes[np.abs(order[:, None] - order)] + np.diag(rates**2)
    matrix[:, centre.fixed + top] = 2 * rates * np.array([complex(w) for w in centre.vector])
    if not np.isfinite(matrix).all():
        raise CertificateError("the exponent's equations are not finite here")
    inverse: list[list[complex]] = np.linalg.inv(matrix).tolist()
    return inverse

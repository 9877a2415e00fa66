"""Spectral stability of a periodic wave on a ring of wavelengths, proved by counting exponents.

For a period of P cells and kappa = 2 pi m/(M P), the perturbations y with
y_{n+P} = exp(i kappa P) y_n are a space of dimension 2 P. The map that moves them by one cell in
the time 1/v has the eigenvalues exp(lambda/v), lambda a Floquet exponent. So there are 2 P
exponents modulo 2 pi i v, and exponents with disjoint enclosures are all of them once there are
2 P. At kappa = 0, four are 0: two as sum y and sum dy/dt change as in free motion; on the subspace
in which both are 0 the map is symplectic and has the fixed vector f', so that the multiplicity of 0
is even and at least 2.

With (lambda, W), also (-conj(lambda), conj(W)) is a solution; the ball of a centre with imaginary
lambda and real W is mapped to itself. Its only solution has an imaginary exponent. For -kappa, the
exponents are the conjugates.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from flint import acb, arb, fmpq

from .exponent import ExponentCentre, exponent_contraction
from .limits import MAX_MODES, CertificateError, decimal
from .periodic_claim import proved_wave
from .reading import Ends, Record

MAX_WAVELENGTHS, MAX_EXPONENTS = 256, 4000


class RingClaim:
    """The statement of a ring's certificate: its wave, and enclosures of all exponents."""

    def __init__(self, record: Record) -> None:
        self.wave = proved_wave(record.record("wave"))
        cells = self.wave.cells
        if cells is None or cells.q != 1:
            raise CertificateError("a ring needs a wave whose period is stated as an integer")
        self.cells = int(cells.p)
        self.wavelengths = record.integer("wavelengths", 1, MAX_WAVELENGTHS)
        self.radius_bound = arb(record.number("radius_bound"))
        self.spectra = record.items("spectra", MAX_WAVELENGTHS)
        exponents = 2 * self.cells * (self.wavelengths // 2 + 1)
        if len(self.spectra) != self.wavelengths // 2 + 1 or exponents > MAX_EXPONENTS:
            raise CertificateError(
                f"spectra must have {self.wavelengths // 2 + 1} lists, one for each Bloch number, "
                f"and at most {MAX_EXPONENTS} exponents"
            )

    def prove(self) -> dict[str, Ends]:
        """Return that no perturbation grows. Raises CertificateError if a proof fails."""
        for m, items in enumerate(self.spectra):
            self._require_spectrum(m, items)
        return {"growth": (arb(0), arb(0))}

    def _require_spectrum(self, m: int, items: object) -> None:
        """Raise CertificateError unless ``items`` enclose every exponent at m wavelengths."""
        zeros = 0 if m else 4
        if not isinstance(items, list) or len(items) != 2 * self.cells - zeros:
            raise CertificateError(
                f"Bloch number {m}/{self.wavelengths} must have {2 * self.cells - zeros} exponents"
            )
        bloch = fmpq(m, self.wavelengths)
        angles = [self._angle(bloch, Record(item, "exponent")) for item in items]
        _require_disjoint([*angles, arb(0)] if zeros else angles)

    def _angle(self, bloch: fmpq, record: Record) -> arb:
        """Return a proved frequency over 2 pi v, as a ball."""
        frequency, radius = record.number("frequency"), arb(record.number("radius"))
        vector = [acb(arb(decimal(w))) for w in record.items("vector", 2 * MAX_MODES + 1)]
        fixed = record.integer("fixed", -MAX_MODES, MAX_MODES)
        record.close()
        exponent = acb(arb(0), arb(frequency))
        stiffness = self.wave.stiffness
        centre = ExponentCentre(stiffness, bloch, exponent, vector, fixed, self.radius_bound)
        exponent_contraction(centre).require(radius, self.radius_bound)
        return (arb(frequency) + arb(0, radius)) / (2 * arb.pi() * stiffness.speed)

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        return "\n".join(
            [
                self.wave.statement,
                f"On a ring of {self.wavelengths} wavelengths it is spectrally STABLE: all Floquet "
                "exponents are imaginary, so that no perturbation grows exponentially.",
            ]
        )


def _require_disjoint(angles: Sequence[arb]) -> None:
    """Raise CertificateError unless the balls are pairwise disjoint modulo 1."""
    folded: list[Any] = [angle - angle.mid().floor() for angle in angles]
    folded.sort(key=lambda angle: float(angle.mid()))
    for lower, higher in zip(folded, [*folded[1:], folded[0] + 1], strict=True):
        if not lower < higher:
            raise CertificateError("two exponents are too close: their enclosures may be of one")

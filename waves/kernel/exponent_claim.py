"""Statement of a Floquet exponent: what its certificate claims, and what is proved."""

from __future__ import annotations

from flint import acb, arb

from .exponent import ExponentCentre, exponent_contraction
from .limits import MAX_MODES, CertificateError, decimal
from .periodic_claim import proved_wave
from .reading import Ends, Record, ends_of


class ExponentClaim:
    """The statement and the numbers of an exponent's certificate, with its wave's."""

    def __init__(self, record: Record) -> None:
        self.wave = proved_wave(record.record("wave"))
        self.bloch = record.number("bloch")
        self.radius = arb(record.number("radius"))
        parts = [record.number(name) for name in ("growth", "frequency")]
        vector = record.items("vector", 2 * MAX_MODES + 1)
        if len(vector) % 2 == 0:
            raise CertificateError("the vector must have an odd number of components")
        self.centre = ExponentCentre(
            self.wave.stiffness,
            self.bloch,
            acb(arb(parts[0]), arb(parts[1])),
            [_complex(item) for item in vector],
            record.integer("fixed", -MAX_MODES, MAX_MODES),
            arb(record.number("radius_bound")),
        )

    def prove(self) -> dict[str, Ends]:
        """Return the parts of the exponent. Raises CertificateError if it is not proved."""
        exponent_contraction(self.centre).require(self.radius, self.centre.radius_bound)
        return self.numbers()

    def numbers(self) -> dict[str, Ends]:
        """Return real and imaginary part of a proved exponent."""
        error = arb(0, self.radius)
        exponent = self.centre.exponent
        return {
            "growth": ends_of(exponent.real + error),
            "frequency": ends_of(exponent.imag + error),
        }

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        growth = self.numbers()["growth"][0]
        verdict = "It is UNSTABLE: perturbations grow as exp(growth t)." if growth > 0 else ""
        return "\n".join(
            filter(
                None,
                [
                    self.wave.statement,
                    "It has a Floquet exponent growth + i frequency at kappa P/(2 pi) = "
                    f"{self.bloch}.",
                    verdict,
                ],
            )
        )


def _complex(item: object) -> acb:
    if not isinstance(item, list) or len(item) != 2:
        raise CertificateError("a component of the vector must be [real, imaginary]")
    return acb(arb(decimal(item[0])), arb(decimal(item[1])))

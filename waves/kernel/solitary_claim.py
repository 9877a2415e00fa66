"""Statement of a solitary wave: what its certificate claims, and what is proved."""

from __future__ import annotations

from flint import arb

from .chain_reading import springs_of
from .cosine_series import upper
from .limits import MAX_MODES, CertificateError, decimal
from .reading import Ends, Record, ends_of
from .solitary import SolitaryCentre, solitary_contraction


class SolitaryClaim:
    """The statement and the numbers of a solitary wave's certificate."""

    def __init__(self, record: Record) -> None:
        self.springs = springs_of(record.record("lattice"))
        if [spring.neighbour for spring in self.springs] != [1]:
            raise CertificateError("a solitary wave is proved for nearest neighbours only")
        self.speed = record.number("speed")
        self.radius = arb(record.number("radius"))
        self.centre = SolitaryCentre(
            force=self.springs[0].force,
            speed_squared=arb(self.speed * self.speed),
            half_length=arb(record.number("half_length")),
            kappa=arb(record.number("kappa")),
            modes=[arb(decimal(m)) for m in record.items("modes", MAX_MODES)],
            radius_bound=arb(record.number("radius_bound")),
            degree=record.integer("degree", 2, 64),
            range_bound=arb(record.number("range_bound")),
        )

    def prove(self) -> dict[str, Ends]:
        """Return the bounds of each number. Raises CertificateError if no wave is proved."""
        solitary_contraction(self.centre).require(self.radius, self.centre.radius_bound)
        if not self.radius < self.centre.size_below:
            raise CertificateError(
                "the radius must be less than the centre's norm: g = 0 is no wave"
            )
        centre = self.centre
        strain = centre.strain
        error = centre.embedding * self.radius + centre.periodic_error * centre.edge
        crest = strain[0] + 2 * sum(strain[1:], arb(0)) + arb(0, upper(error))
        return {"crest": ends_of(crest)}

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        return (
            f"The chain of unit masses with V'(r) = {self.springs[0].force.text} has a smooth even "
            f"solitary strain f(n - v t), f in L^2 and not 0, with the speed v = {self.speed}."
        )

"""Statement of a periodic wave: what its certificate claims, and what is proved."""

from __future__ import annotations

from functools import cached_property

from flint import arb, fmpq

from .chain_reading import nearest_force, springs_of, springs_text, strip_of
from .cosine_series import Series, supremum, upper, value_at_zero
from .elliptic_pins import NearWave
from .exponent import Stiffness
from .limits import MAX_BITS, MAX_MODES, MIN_BITS, VERSION, CertificateError, decimal
from .periodic import PeriodicCentre, Spring, contraction, energy
from .reading import Ends, Record, check_claims, ends_of


class PeriodicClaim:
    """The statement and the numbers of a periodic wave's certificate."""

    def __init__(self, record: Record) -> None:
        self.springs = springs_of(record.record("lattice"))
        self.cells: fmpq | None = None
        self.near = _near(record.record("near"), self.springs) if "near" in record else None
        if self.near:
            self.period, pins = self.near.period, self.near.modes(1)
            self.pins = (
                f"period, mean and first mode of {self.near.eps**self.near.form.order} Y, Y the "
                f"{self.near.name} wave of the {self.near.equation} with k = {self.near.k}"
            )
        else:
            given = [record.number(name) for name in ("period", "mean", "first_mode")]
            self.cells = given[0]
            self.period, pins = arb(given[0]), [arb(given[1]), arb(given[2])]
            self.pins = "period {}, mean {}, first mode {}".format(*given)
        modes = [arb(decimal(m)) for m in record.items("modes", MAX_MODES)]
        self.radius = arb(record.number("radius"))
        self.centre = PeriodicCentre(
            springs=self.springs,
            period=self.period,
            modes=[*pins, *modes],
            speed_squared=arb(record.number("speed_squared")),
            nu=arb(record.number("nu")),
            weight=arb(record.number("weight")),
            radius_bound=arb(record.number("radius_bound")),
            strip=strip_of(record),
        )

    def prove(self) -> dict[str, Ends]:
        """Return the bounds of each number. Raises CertificateError if no wave is proved."""
        self.require()
        return self.numbers()

    def require(self) -> None:
        """Raise CertificateError unless a wave is proved: not constant, of positive speed."""
        contraction(self.centre).require(self.radius, self.centre.radius_bound)
        if not self.speed_squared > 0:
            raise CertificateError("the speed squared is not proved positive")
        if not abs(self.centre.modes[1]) > 0:
            raise CertificateError("the first mode must not be 0: P would not be the least period")

    @cached_property
    def speed_squared(self) -> arb:
        """Squared speed v^2 of the proved wave, as a ball."""
        return self.centre.speed_squared + arb(0, self.radius / self.centre.weight)

    @property
    def stiffness(self) -> Stiffness:
        """V''(f) of the proved wave, for nearest neighbours."""
        nearest_force(self.springs, "an exponent")
        _, law = self.centre.laws[0]
        rest = upper(law.stiffness_rest + law.third * self.radius)
        return Stiffness(law.stiffness, rest, self.speed_squared.sqrt(), self.period)

    def numbers(self) -> dict[str, Ends]:
        """Return the bounds of each number of a proved wave, by its name in the claims."""
        modes, error = self.centre.modes, arb(0, self.radius)
        numbers = {
            "speed": ends_of(self.speed_squared.sqrt()),
            "crest": ends_of(value_at_zero(modes) + error),
        }
        nearest = [spring.neighbour for spring in self.springs] == [1]
        if nearest and self.springs[0].force.polynomial is not None:
            numbers["energy"] = ends_of(energy(self.centre, self.radius))
        if self.near:
            numbers["distance"] = _distance(self.near, modes, self.radius)
        return numbers

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        return (
            f"The chain of unit masses with {springs_text(self.springs)} has a smooth even "
            f"periodic strain f(n - v t) with {self.pins}."
        )


def proved_wave(record: Record) -> PeriodicClaim:
    """Read the certificate of a periodic wave inside another one, and repeat its proof."""
    if record.text("kind") != "periodic" or record.integer("version", 1, VERSION) != VERSION:
        raise CertificateError("an exponent is proved for a periodic wave")
    record.integer("bits", MIN_BITS, MAX_BITS)
    wave = PeriodicClaim(record)
    check_claims(record.record("claims"), wave.prove())
    record.close()
    return wave


def _near(record: Record, springs: tuple[Spring, ...]) -> NearWave:
    force = nearest_force(springs, "a wave near an elliptic one")
    name, k, eps = record.text("form"), record.number("k"), record.number("eps")
    record.close()
    return NearWave(name, k, eps, force)


def _distance(near: NearWave, modes: Series, radius: arb) -> Ends:
    """Return bounds of sup |f - eps^p Y|/eps^p, for the wave f within ``radius`` of ``modes``."""
    top = len(modes) - 1
    low, high = supremum([a - b for a, b in zip(modes, near.modes(top), strict=True)])
    error, size = radius + near.rest(top), near.size
    return ((low - error) / size).max(arb(0)).lower(), upper((high + error) / size)

"""Statements of time-periodic orbits: what their certificates claim, and what is proved."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

from flint import arb, fmpq

from .chain_reading import springs_of, springs_text, strip_of
from .cosine_series import largest, upper, value_at_zero
from .limits import MAX_MODES, CertificateError, decimal
from .monodromy import Monodromy, Multiplier, multipliers
from .orbit import OrbitCentre, energy_at_start, orbit_contraction
from .periodic import Contraction
from .reading import Ends, Record, ends_of

MAX_SITES, MAX_STEPS, MAX_ORDER = 200, 1000, 200


class _Claim:
    """Lattice and numbers that the certificates of all orbits have."""

    def __init__(self, record: Record, energy: fmpq | None, frequency_squared: fmpq) -> None:
        springs = springs_of(record.record("lattice"), 0)
        modes = [_numbers(site) for site in record.items("modes", MAX_SITES)]
        if not modes or len({len(site) for site in modes}) != 1 or not modes[0]:
            raise CertificateError("modes must have a list of the same length for each site")
        margin, block_top = _block(record)
        centre = OrbitCentre(
            springs=springs,
            modes=modes,
            frequency_squared=arb(frequency_squared),
            energy=None if energy is None else arb(energy),
            nu=arb(record.number("nu")),
            weight=arb(record.number("weight")),
            radius_bound=arb(record.number("radius_bound")),
            strip=strip_of(record),
            margin=margin,
            block_top=block_top,
        )
        if centre.is_odd:
            modes = [[c for mode in site for c in (arb(0), mode)] for site in modes]
            centre = replace(centre, modes=modes)
        self.centre = centre
        self.radius = arb(record.number("radius"))

    @cached_property
    def contraction(self) -> Contraction:
        """Bounds of the map whose fixed point is the orbit. Raises CertificateError."""
        return orbit_contraction(self.centre)

    def require(self) -> None:
        """Raise CertificateError unless an orbit is proved that moves with the harmonic 1."""
        centre = self.centre
        self.contraction.require(self.radius, centre.radius_bound)
        first = 2 * centre.nu * sum((abs(modes[1]) for modes in centre.modes), arb(0))
        if not first > self.radius:
            raise CertificateError("the first harmonic must be above the radius: q = 0 is no orbit")

    def amplitude(self) -> Ends:
        """Return bounds of the largest |q_n| at t = 0."""
        sizes = [abs(value_at_zero(modes)) + arb(0, self.radius) for modes in self.centre.modes]
        low = arb(0)
        for size in sizes:
            low = low.max(size.lower())
        return low.lower(), upper(largest(sizes))


def _block(record: Record) -> tuple[int, int]:
    """Read the margin and the largest harmonic of a smaller block."""
    if "block" not in record:
        return 0, MAX_MODES
    inner = record.record("block")
    margin, top = inner.integer("margin", 0, MAX_SITES), inner.integer("top", 1, MAX_MODES)
    inner.close()
    return margin, top


def _numbers(items: object) -> list[arb]:
    if not isinstance(items, list) or len(items) > MAX_MODES:
        raise CertificateError(f"a site must have a list of at most {MAX_MODES} modes")
    return [arb(decimal(item)) for item in items]


class OrbitClaim(_Claim):
    """The statement and the numbers of a certificate of an orbit of a finite chain."""

    def __init__(self, record: Record) -> None:
        self.energy = record.number("energy")
        super().__init__(record, self.energy, record.number("frequency_squared"))
        self.monodromy: Monodromy | None = None
        if "multipliers" in record:
            inner = record.record("multipliers")
            steps, order = (
                inner.integer("steps", 1, MAX_STEPS),
                inner.integer("order", 2, MAX_ORDER),
            )
            inner.close()
            self.monodromy = Monodromy(self.centre, self.radius, steps, order)
        self._multipliers: list[Multiplier] = []

    def prove(self) -> dict[str, Ends]:
        """Return the bounds of each number. Raises CertificateError if no orbit is proved."""
        self.require()
        # Z2 >= 1/(Omega^2 weight) and Z2 radius < 1, so this is positive
        squared = self.centre.frequency_squared_within(self.radius)
        numbers = {
            "period": ends_of(2 * arb.pi() / squared.sqrt()),
            "amplitude": self.amplitude(),
        }
        if self.monodromy:
            self._multipliers = multipliers(self.monodromy.half())
        for i, pair in enumerate(self._multipliers):
            numbers[f"multiplier_{i + 1}_real"] = ends_of(pair.value.real)
            numbers[f"multiplier_{i + 1}_imaginary"] = ends_of(pair.value.imag)
        return numbers

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        count = len(self.centre.sites)
        text = (
            f"The chain of {count} unit masses with {springs_text(self.centre.springs)} and q = 0 "
            "beyond its ends has a time-periodic orbit q_n(t), even in t and not constant, with "
            f"the energy {self.energy}. The period is its least period."
        )
        if not self.monodromy:
            return text
        if not all(pair.is_on_circle for pair in self._multipliers):
            return text + " It is UNSTABLE: a Floquet multiplier has a modulus above 1."
        return text + (
            " It is spectrally stable: all Floquet multipliers have modulus 1; 1 is double, the "
            "others are simple."
        )


class BreatherClaim(_Claim):
    """The statement and the numbers of a certificate of a breather of an infinite chain."""

    def __init__(self, record: Record) -> None:
        self.frequency = record.number("frequency")
        super().__init__(record, None, self.frequency * self.frequency)

    def prove(self) -> dict[str, Ends]:
        """Return the bounds of each number. Raises CertificateError if no breather is proved."""
        if not self.frequency > 0:
            raise CertificateError("frequency > 0 must hold")
        self.require()
        return {
            "period": ends_of(2 * arb.pi() / arb(self.frequency)),
            "amplitude": self.amplitude(),
            "energy": ends_of(energy_at_start(self.centre, self.radius)),
        }

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        return (
            f"The infinite chain of unit masses with {springs_text(self.centre.springs)} has a "
            "breather: a time-periodic orbit q_n(t), even in t and not 0, with the frequency "
            f"{self.frequency} and a finite sum of sup |q_n|. The period is its least period."
        )

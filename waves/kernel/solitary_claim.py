"""Statement of a solitary wave: what its certificate claims, and what is proved."""

from __future__ import annotations

from functools import cached_property

from flint import arb

from .chain_reading import springs_of, springs_text, strip_of
from .cosine_series import Series
from .limits import MAX_MODES, CertificateError, decimal
from .periodic import Contraction
from .reading import Ends, Record, ends_of
from .solitary import SolitaryCentre, nonlinear_springs, solitary_contraction
from .solitary_numbers import SolitaryNumbers
from .solitary_sign import proved_sign

SIGNS = {1: ", f > 0 everywhere,", -1: ", f < 0 everywhere,", 0: ""}


class SolitaryClaim:
    """The statement and the numbers of a solitary wave's certificate."""

    def __init__(self, record: Record) -> None:
        self.springs = springs_of(record.record("lattice"))
        count = len(nonlinear_springs(self.springs))
        if not count:
            raise CertificateError(
                "a solitary wave needs a nonlinear force, and a speed above the speed of sound"
            )
        self.speed = record.number("speed")
        self.radius = arb(record.number("radius"))
        self.centre = SolitaryCentre(
            springs=self.springs,
            speed_squared=arb(self.speed * self.speed),
            half_length=arb(record.number("half_length")),
            kappa=arb(record.number("kappa")),
            modes=_modes(record, "modes", count),
            block=record.integer("block", 1, MAX_MODES),
            radius_bound=arb(record.number("radius_bound")),
            strip=strip_of(record),
        )
        has_slope = "slope_modes" in record
        self.slope_modes = _modes(record, "slope_modes", count) if has_slope else ()
        if has_slope and len(self.slope_modes[0]) != len(self.centre.modes[0]):
            raise CertificateError("slope_modes must be as many as modes")

    @cached_property
    def bounds(self) -> Contraction:
        """Bounds of the contraction at the centre."""
        if not (self.speed > 0 and self.centre.line.gap > 0):
            raise CertificateError("speed must be above the speed of sound")
        return solitary_contraction(self.centre)

    @property
    def numbers(self) -> SolitaryNumbers:
        """Numbers of the wave."""
        return SolitaryNumbers(self.centre, self.bounds, self.radius)

    def prove(self) -> dict[str, Ends]:
        """Return the bounds of each number. Raises CertificateError if no wave is proved."""
        self.bounds.require(self.radius, self.centre.radius_bound)
        if not self.radius < self.centre.size(self.centre.modes).lower():
            raise CertificateError(
                "the radius must be less than the centre's norm: g = 0 is no wave"
            )
        numbers = self.numbers
        proved = {
            "crest": numbers.crest,
            "energy": numbers.energy,
            "momentum": -arb(self.speed) * numbers.stretch,
        }
        if self.slope_modes:
            proved["energy_slope"] = numbers.energy_slope(self.slope_modes)
        return {name: ends_of(value) for name, value in proved.items()}

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves, once `prove` has returned."""
        return (
            f"The chain of unit masses with {springs_text(self.springs)} has a smooth even "
            f"solitary strain f(n - v t), f in L^2 and not 0{SIGNS[proved_sign(self.numbers)]} "
            f"with the speed v = {self.speed}."
        )


def _modes(record: Record, name: str, count: int) -> tuple[Series, ...]:
    """Read the modes of ``count`` functions, one after the other."""
    modes = [arb(decimal(m)) for m in record.items(name, MAX_MODES)]
    size, rest = divmod(len(modes), count)
    if rest or not size:
        raise CertificateError(f"{name} must be as many for each of the {count} nonlinear springs")
    return tuple(modes[i * size : (i + 1) * size] for i in range(count))

"""Check a certificate of a wave: read the statement, repeat its proof, and say what it proves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property

from flint import acb, arb, ctx, fmpq

from .composition import Strip
from .cosine_series import Series, largest, supremum, upper
from .elliptic_pins import NearWave
from .exponent import ExponentCentre, Stiffness, exponent_contraction
from .force_text import read_force
from .limits import MAX_BITS, MAX_MODES, MIN_BITS, CertificateError, decimal
from .periodic import Contraction, PeriodicCentre, Spring, contraction, energy
from .reading import Ends, Record, check_claims, ends_of
from .solitary import SolitaryCentre, solitary_contraction
from .tie import TiePiece, distance_over_cube, tie_contraction

VERSION = 1
MAX_NEIGHBOUR, MAX_PIECES = 8, 5000


def check_certificate(data: object) -> str:
    """Return what a certificate proves, in words. Raises CertificateError if it proves nothing."""
    record = Record(data, "certificate")
    kind = record.text("kind")
    if kind not in CHECKS:
        raise CertificateError(f"kind must be one of {', '.join(CHECKS)}, got {kind[:40]!r}")
    if record.integer("version", 1, VERSION) != VERSION:
        raise CertificateError(f"version must be {VERSION}")
    before = ctx.prec
    ctx.prec = record.integer("bits", MIN_BITS, MAX_BITS)
    try:
        return CHECKS[kind](record)
    except (ValueError, ZeroDivisionError, OverflowError, RecursionError) as error:
        raise CertificateError(str(error) or type(error).__name__) from error
    finally:
        ctx.prec = before


def _check_periodic(record: Record) -> str:
    wave = PeriodicClaim(record)
    wave.require_statement(contraction(wave.centre))
    lines = check_claims(record.record("claims"), wave.proved())
    record.close()
    return "\n".join([wave.statement, *lines])


class PeriodicClaim:
    """The statement and the numbers of a periodic wave's certificate."""

    def __init__(self, record: Record) -> None:
        self.springs = _springs(record.record("lattice"))
        self.near = _near(record.record("near"), self.springs) if "near" in record else None
        if self.near:
            self.period, pins = self.near.period, self.near.modes(1)
            self.pins = (
                f"period, mean and first mode of {self.near.eps} Y, Y the {self.near.form} wave of "
                f"the modified KdV equation with k = {self.near.k}"
            )
        else:
            given = [record.number(name) for name in ("period", "mean", "first_mode")]
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
            strip=_strip(record.record("strip")) if "strip" in record else None,
        )

    def require_statement(self, bounds: Contraction) -> None:
        """Raise CertificateError unless a wave is proved: not constant, of positive speed."""
        bounds.require(self.radius)
        if not 0 < self.radius <= self.centre.radius_bound:
            raise CertificateError("0 < radius <= radius_bound must hold")
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
        if [spring.neighbour for spring in self.springs] != [1]:
            raise CertificateError("exponents are proved for nearest neighbours only")
        _, law = self.centre.laws[0]
        rest = upper(law.stiffness_rest + law.third * self.radius)
        return Stiffness(law.stiffness, rest, self.speed_squared.sqrt(), self.period)

    def proved(self) -> dict[str, Ends]:
        """Return the proved bounds of each number, by its name in the claims."""
        modes, error = self.centre.modes, arb(0, self.radius)
        numbers = {
            "speed": ends_of(self.speed_squared.sqrt()),
            "crest": ends_of(modes[0] + 2 * sum(modes[1:], arb(0)) + error),
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
        springs = " and ".join(
            f"V'(r) = {s.force.text}" + (f" (neighbour {s.neighbour})" if s.neighbour > 1 else "")
            for s in self.springs
        )
        return (
            f"The chain of unit masses with {springs} has a smooth even periodic strain f(n - v t) "
            f"with {self.pins}."
        )


def _check_solitary(record: Record) -> str:
    wave = SolitaryClaim(record)
    wave.require_statement(solitary_contraction(wave.centre))
    lines = check_claims(record.record("claims"), wave.proved())
    record.close()
    return "\n".join([wave.statement, *lines])


class SolitaryClaim:
    """The statement and the numbers of a solitary wave's certificate."""

    def __init__(self, record: Record) -> None:
        self.springs = _springs(record.record("lattice"))
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

    def require_statement(self, bounds: Contraction) -> None:
        """Raise CertificateError unless a wave is proved that is not 0."""
        bounds.require(self.radius)
        if not 0 < self.radius <= self.centre.radius_bound:
            raise CertificateError("0 < radius <= radius_bound must hold")
        if not self.radius < self.centre.size_below:
            raise CertificateError(
                "the radius must be less than the centre's norm: g = 0 is no wave"
            )

    def proved(self) -> dict[str, Ends]:
        """Return the proved bounds of each number, by its name in the claims."""
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


def _check_exponent(record: Record) -> str:
    claim = ExponentClaim(record)
    claim.require_statement(exponent_contraction(claim.centre))
    lines = check_claims(record.record("claims"), claim.proved())
    record.close()
    return "\n".join([claim.statement, *lines])


class ExponentClaim:
    """The statement and the numbers of an exponent's certificate, with its wave's."""

    def __init__(self, record: Record) -> None:
        wave = record.record("wave")
        if wave.text("kind") != "periodic" or wave.integer("version", 1, VERSION) != VERSION:
            raise CertificateError("an exponent is proved for a periodic wave")
        wave.integer("bits", MIN_BITS, MAX_BITS)
        self.wave = PeriodicClaim(wave)
        self.wave.require_statement(contraction(self.wave.centre))
        check_claims(wave.record("claims"), self.wave.proved())
        wave.close()
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

    def require_statement(self, bounds: Contraction) -> None:
        """Raise CertificateError unless the exponent is proved."""
        bounds.require(self.radius)
        if not 0 < self.radius <= self.centre.radius_bound:
            raise CertificateError("0 < radius <= radius_bound must hold")

    def proved(self) -> dict[str, Ends]:
        """Return real and imaginary part of the exponent."""
        error = arb(0, self.radius)
        exponent = self.centre.exponent
        return {
            "growth": ends_of(exponent.real + error),
            "frequency": ends_of(exponent.imag + error),
        }

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        growth = self.proved()["growth"][0]
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


def _check_tie(record: Record) -> str:
    tie = TieClaim(record)
    lines = check_claims(record.record("claims"), tie.proved())
    record.close()
    return "\n".join([tie.statement, *lines])


class TieClaim:
    """The statement of a certificate for all small eps, and its pieces of the range of eps^2."""

    def __init__(self, record: Record) -> None:
        springs = _springs(record.record("lattice"))
        near = record.record("near")
        form, k = near.text("form"), near.number("k")
        near.close()
        self.eps, self.force = record.number("eps"), springs[0].force
        cubic = len(self.force.polynomial or ()) == 4
        if not (self.eps > 0 and cubic and [s.neighbour for s in springs] == [1]):
            raise CertificateError("the tie is proved for eps > 0 and a force K2 r + K4 r^3")
        self.wave = NearWave(form, k, fmpq(1), self.force)
        self.weight = arb(record.number("weight"))
        self.pieces = record.items("pieces", MAX_PIECES)

    def proved(self) -> dict[str, Ends]:
        """Return the proved constants for all eps. Raises CertificateError if a piece fails."""
        low, high, speed, reached = [], [], [], fmpq(0)
        for item in self.pieces:
            piece, bound, last = _tie_piece(Record(item, "piece"), self.wave, self.weight, reached)
            if not reached < last:
                raise CertificateError("the pieces of eps^2 must rise from 0")
            tie_contraction(piece).require(bound)
            change = abs(piece.correction[0]) + bound / self.weight
            square = upper(piece.square)
            if not piece.constants[0] - square * (abs(piece.sigma) + square * change) > 0:
                raise CertificateError("v^2 > 0 is not proved")
            ends = distance_over_cube(piece, bound)
            low.append(-ends[0])
            high.append(ends[1])
            speed.append(upper(change))
            reached = last
        if reached != self.eps * self.eps:
            raise CertificateError("the pieces of eps^2 must end at the square of eps")
        least = -_greatest(low)
        return {
            "distance_over_eps3": (least.max(arb(0)).lower(), largest(high)),
            "speed_over_eps4": (arb(0), largest(speed)),
        }

    @property
    def statement(self) -> str:
        """Text of the theorem that the certificate proves."""
        return (
            f"For every 0 < eps <= {self.eps} the chain of unit masses with V'(r) = "
            f"{self.force.text} has a smooth even periodic strain f(n - v t) with period, mean and "
            f"first mode of eps Y, Y the {self.wave.form} wave of the modified KdV equation with "
            f"k = {self.wave.k}. Here distance_over_eps3 is sup |f - eps Y|/eps^3, and "
            "speed_over_eps4 is |v^2 - K2 - sigma_0 eps^2|/eps^4."
        )


def _greatest(values: Sequence[arb]) -> arb:
    result = values[0]
    for value in values[1:]:
        result = result.max(value)
    return result.upper()


def _tie_piece(
    item: Record, wave: NearWave, weight: arb, reached: fmpq
) -> tuple[TiePiece, arb, fmpq]:
    """Read the piece of the range of eps^2 from ``reached`` on; return it, its bound c, its end."""
    last, bound = item.number("square"), arb(item.number("bound"))
    correction = [arb(decimal(c)) for c in item.items("correction", MAX_MODES)]
    item.close()
    if not bound > 0 or not weight > 0 or len(correction) < 2:
        raise CertificateError("bound > 0, weight > 0 and at least two modes must hold")
    square = arb(reached).union(arb(last))
    return TiePiece(wave, square, correction, weight, upper(bound * arb(last))), bound, last


def _complex(item: object) -> acb:
    if not isinstance(item, list) or len(item) != 2:
        raise CertificateError("a component of the vector must be [real, imaginary]")
    return acb(arb(decimal(item[0])), arb(decimal(item[1])))


def _springs(lattice: Record) -> tuple[Spring, ...]:
    items = [Record(item, "spring") for item in lattice.items("springs", MAX_NEIGHBOUR)]
    lattice.close()
    springs = tuple(map(_spring, items))
    if not springs or len({spring.neighbour for spring in springs}) != len(springs):
        raise CertificateError("springs must have one force for each neighbour")
    return springs


def _spring(item: Record) -> Spring:
    spring = Spring(item.integer("neighbour", 1, MAX_NEIGHBOUR), read_force(item.text("force")))
    item.close()
    return spring


def _strip(record: Record) -> Strip:
    strip = Strip(
        arb(record.number("rho")),
        arb(record.number("margin")),
        record.integer("samples", 4, 32 * MAX_MODES),
    )
    record.close()
    return strip


def _near(record: Record, springs: tuple[Spring, ...]) -> NearWave:
    if [spring.neighbour for spring in springs] != [1]:
        raise CertificateError("near needs a chain with nearest neighbours only")
    form, k, eps = record.text("form"), record.number("k"), record.number("eps")
    record.close()
    return NearWave(form, k, eps, springs[0].force)


def _distance(near: NearWave, modes: Series, radius: arb) -> Ends:
    """Return bounds of sup |f - eps Y|/eps, for the wave f within ``radius`` of ``modes``."""
    top = len(modes) - 1
    low, high = supremum([a - b for a, b in zip(modes, near.modes(top), strict=True)])
    error, eps = radius + near.rest(top), arb(near.eps)
    return ((low - error) / eps).max(arb(0)).lower(), upper((high + error) / eps)


CHECKS: Mapping[str, Callable[[Record], str]] = {
    "periodic": _check_periodic,
    "solitary": _check_solitary,
    "exponent": _check_exponent,
    "tie": _check_tie,
}

"""Exact waves of a lattice: the verdict on one, with every number as an interval."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np
from flint import fmpq
from numpy.typing import ArrayLike, NDArray

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.lattice import Lattice
from longwave.waves.kernel.chain_reading import nearest_force
from longwave.waves.kernel.elliptic_pins import FORMS, NearWave
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.line_tie import Soliton
from longwave.waves.kernel.periodic import Spring
from longwave.waves.line_ties import line_tie_certificate
from longwave.waves.periodic_waves import PeriodicProblem, periodic_certificate
from longwave.waves.proved import Interval, Proved, proved, rational
from longwave.waves.small_waves import tie_certificate
from longwave.waves.solitary_waves import solitary_certificate
from longwave.waves.springs import Refused, chain_springs

if TYPE_CHECKING:
    from longwave.waves.rings import RingStability

__all__ = ["ExactWave", "Exponent", "exact_wave", "waves_of_all_eps"]

SOLITONS = {"soliton": (2, 3), "soliton_sech": (3,), "kdv_soliton": (2,)}
"""Names of solitons, each with the powers of the force that have it: 2 for KdV, 3 for mKdV."""


@dataclass(frozen=True)
class Exponent:
    """A proved Floquet exponent growth + i frequency, with its certificate."""

    growth: Interval
    frequency: Interval
    certificate: Mapping[str, Any] = field(repr=False)

    @property
    def is_unstable(self) -> bool:
        """Whether the growth is proved to be positive."""
        return Fraction(self.growth.lower) > 0


@dataclass(frozen=True)
class ExactWave(Proved):
    """Wave of a lattice, with the verdict on its existence and its proved numbers."""

    @property
    def numbers(self) -> dict[str, Interval]:
        """Proved numbers by name, such as speed, crest, energy, momentum, distance."""
        numbers = super().numbers
        if "speed" in self.certificate:
            speed = Fraction(self.certificate["speed"])
            numbers = {"speed": Interval.around(speed), **numbers}
        return numbers

    @property
    def speed(self) -> Interval:
        """Speed in cells per unit of time."""
        return self.numbers["speed"]

    @property
    def crest(self) -> Interval:
        """Strain f(0) at the wave's crest or trough."""
        return self.numbers["crest"]

    @property
    def energy(self) -> Interval | None:
        """Energy of a solitary wave, or of a period at zero mean momentum; None if not proved."""
        return self.numbers.get("energy")

    @property
    def momentum(self) -> Interval | None:
        """Total momentum, -v times the integral of the strain, of a solitary wave; else None."""
        return self.numbers.get("momentum")

    @property
    def distance(self) -> Interval | None:
        """Bounds of sup |f - eps Y|/eps; None unless the wave f was found near an elliptic Y."""
        return self.numbers.get("distance")

    def exponent(self, bloch: Number) -> Exponent:
        """Return the Floquet exponent with the largest growth at wavenumber 2 pi ``bloch``/period.

        Raises ValueError unless this is a periodic wave that is proved to exist, and
        CertificateError if no exponent is proved.
        """
        from longwave.waves.exponents import most_unstable

        if self.certificate.get("kind") != "periodic":
            raise ValueError("exponents need a periodic wave that exists, got another")
        certificate = most_unstable(self.certificate, rational("bloch", bloch))
        claims = certificate["claims"]
        return Exponent(Interval(*claims["growth"]), Interval(*claims["frequency"]), certificate)

    def ring(self, wavelengths: int) -> RingStability:
        """Decide whether the wave is spectrally stable on a ring of ``wavelengths`` wavelengths.

        Raises ValueError unless this is a periodic wave that is proved to exist, whose period is
        stated as an integer number of cells.
        """
        from longwave.waves.rings import ring_stability

        if self.certificate.get("kind") != "periodic":
            raise ValueError("a ring needs a periodic wave that exists, got another")
        return ring_stability(self.certificate, wavelengths)

    def at(self, x: ArrayLike) -> NDArray[np.float64]:
        """Return the strain f(x) in double precision; its proved error is `radius`.

        For a solitary wave it is the periodic series on the certificate's interval, and 0 outside;
        its proved error is the upper end of the number ``profile_error``.
        """
        from longwave.waves.profiles import strain

        return strain(self.certificate, np.asarray(x, dtype=float))


def exact_wave(
    lattice: Lattice,
    *,
    near: str = "",
    k: Number = 0,
    eps: Number = 0,
    period: Number = 0,
    mean: Number = 0,
    first_mode: Number = 0,
    speed: Number = 0,
    error: float = 1e-10,
) -> ExactWave:
    """Find a wave of a chain and prove that it exists.

    A periodic wave is given by its ``period`` in cells, ``mean`` and ``first_mode`` f_1 of
    f_0 + 2 (f_1 cos + ...); or by ``near``, ``k`` and ``eps``, with period, mean and first mode of
    that wave: "dn", "cn" or "sn" of the modified KdV equation, "cnoidal" of KdV. With ``near`` and
    ``period`` eps is that of the period, and mean and first mode are rounded to 30 digits. A
    solitary wave is given by its ``speed``. ``error`` is the largest error of the strain that is
    accepted.

    Raises ValueError for arguments that state no wave. If the proof fails or no theorem applies,
    the verdict says so.

    >>> from longwave.derive import LATTICES
    >>> chain = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 1, "K4": 0})
    >>> wave = exact_wave(chain, period=15, first_mode="1/50")
    >>> print(wave.verdict, f"{wave.speed.value:.15f}")
    EXISTS 1.001492829789224
    """
    choices = {"near": near, "period": period, "speed": speed}
    given = [name for name, value in choices.items() if value]
    if given == ["near", "period"]:
        if eps or mean or first_mode:
            raise ValueError("near and period must not be given with eps, mean or first_mode")
    elif len(given) != 1:
        raise ValueError(
            f"one of near, period and speed must be given, got {', '.join(given) or 'none'} "
            "(near='dn', k='3/5', eps='2/25')"
        )
    exact = {"k": k, "eps": eps, "mean": mean, "first_mode": first_mode}
    exact |= {"period": period, "speed": speed}
    numbers = {name: rational(name, value) for name, value in exact.items()}
    return proved(lambda: _certificate(lattice, near, numbers, error), ExactWave)


def waves_of_all_eps(lattice: Lattice, *, near: str, k: Number = 0, eps: Number) -> ExactWave:
    """Prove that a chain has a wave next to that of its reduced equation for all 0 < e <= ``eps``.

    Y is the "dn", "cn" or "sn" wave of the modified KdV equation with modulus ``k``, for an odd
    polynomial force; the chain's wave, of strain f and speed v, has the period, mean and first mode
    of e Y. For all e the interval ``distance_over_eps3`` contains sup |f - e Y|/e^3, and
    ``speed_over_eps4`` contains |v^2 - K2 - sigma_0 e^2|/e^4, where sigma_0 is the speed of Y.

    For a polynomial force with r^2, Y is the "cnoidal" wave of KdV, f is next to e^2 Y, and
    ``distance_over_eps4`` contains sup |f - e^2 Y|/e^4.

    With ``near`` "soliton" the wave is solitary, with v^2 = K2 (1 + e^2), and ``k`` is not given. Y
    is the soliton sech^2 of KdV for a polynomial force with r^2, and the soliton sech of the
    modified KdV equation for an odd one with K4 > 0. ``near`` may be "kdv_soliton" or
    "soliton_sech", as in the catalogue.

    >>> from longwave.derive import LATTICES
    >>> chain = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    >>> wave = waves_of_all_eps(chain, near="dn", k="3/5", eps="1/10")
    >>> print(wave.verdict, wave.numbers["distance_over_eps3"].lower[:7])
    EXISTS 0.01615
    """
    exact = {"k": rational("k", k), "eps": rational("eps", eps)}

    def certificate() -> dict[str, Any]:
        if near in SOLITONS:
            return _soliton_certificate(lattice, near, exact["k"], exact["eps"])
        springs = _nearest_neighbours(lattice, near)
        _check_near(springs, near, exact["k"], exact["eps"])
        return tie_certificate(springs[0], near, exact["k"], exact["eps"])

    return proved(certificate, ExactWave)


def _soliton_certificate(lattice: Lattice, near: str, k: fmpq, eps: fmpq) -> dict[str, Any]:
    if k:
        raise ValueError(f"k must not be given with near {near}, got {k} (a soliton has none)")
    if not eps > 0:
        raise ValueError(f"eps must be > 0, got {eps}")
    springs = chain_springs(lattice)
    try:
        power = Soliton.of(nearest_force(springs, "a wave near a soliton")).power
    except CertificateError as reason:
        raise Refused(str(reason)) from reason
    if power not in SOLITONS[near]:
        raise ValueError(
            f"near must be {'kdv_soliton' if power == 2 else 'soliton_sech'} for this force, "
            f"got {near!r}"
        )
    return line_tie_certificate(springs[0], eps)


def _certificate(
    lattice: Lattice, near: str, numbers: Mapping[str, fmpq], error: float
) -> dict[str, Any]:
    springs = chain_springs(lattice)
    if numbers["speed"]:
        return solitary_certificate(springs, numbers["speed"], error)
    if near:
        springs = _nearest_neighbours(lattice, near)
        if numbers["period"]:
            _check_near(springs, near, numbers["k"], fmpq(1))
            problem = PeriodicProblem.of_period(springs, near, numbers["k"], numbers["period"])
            return periodic_certificate(problem, error)
        _check_near(springs, near, numbers["k"], numbers["eps"])
        problem = PeriodicProblem.near_elliptic(springs, near, numbers["k"], numbers["eps"])
        return periodic_certificate(problem, error)
    period, first_mode = numbers["period"], numbers["first_mode"]
    if not period > 2:
        raise ValueError(f"period must be more than 2 cells, got {period}")
    if not first_mode:
        raise ValueError(
            "first_mode must not be 0, got 0 (the wave would be constant; 1/50 is a small wave)"
        )
    problem = PeriodicProblem.of(springs, period, numbers["mean"], first_mode)
    return periodic_certificate(problem, error)


def _nearest_neighbours(lattice: Lattice, near: str) -> tuple[Spring, ...]:
    if near in SOLITONS:
        raise ValueError(
            f"near {near} is proved for all eps at once (--every-eps-to 7/100), not for one eps; "
            "one solitary wave is given by its speed"
        )
    if near not in FORMS:
        raise ValueError(f"near must be one of {', '.join(FORMS)}, got {near!r}")
    springs = chain_springs(lattice)
    try:
        nearest_force(springs, "a wave near an elliptic one")
    except CertificateError as reason:
        raise Refused(str(reason)) from reason
    return springs


def _check_near(springs: tuple[Spring, ...], near: str, k: fmpq, eps: fmpq) -> None:
    """Raise ValueError for a form, modulus or eps that states no elliptic wave of the chain."""
    try:
        NearWave(near, k, eps, springs[0].force)
    except CertificateError as reason:
        raise ValueError(str(reason)) from reason

"""Exact waves of a lattice: the verdict on one, with every number as an interval."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from flint import fmpq
from numpy.typing import ArrayLike, NDArray

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.lattice import Lattice
from longwave.waves.kernel.elliptic_pins import FORMS, NearWave
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.kernel.periodic import Spring
from longwave.waves.periodic_waves import PeriodicProblem, periodic_certificate
from longwave.waves.proved import Existence, Interval, Proved, proved, rational
from longwave.waves.small_waves import tie_certificate
from longwave.waves.solitary_waves import solitary_certificate
from longwave.waves.springs import Refused, chain_springs

__all__ = ["ExactWave", "Existence", "Exponent", "Interval", "exact_wave", "waves_of_all_eps"]


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
    f_0 + 2 (f_1 cos + ...); or by ``near`` ("dn", "cn", "sn"), ``k`` and ``eps``, with period, mean
    and first mode of that wave of the modified KdV equation. A solitary wave is given by its
    ``speed``. ``error`` is the largest error of the strain that is accepted.

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
    if len(given) != 1:
        raise ValueError(
            f"one of near, period and speed must be given, got {', '.join(given) or 'none'} "
            "(near='dn', k='3/5', eps='2/25')"
        )
    exact = {"k": k, "eps": eps, "mean": mean, "first_mode": first_mode}
    exact |= {"period": period, "speed": speed}
    numbers = {name: rational(name, value) for name, value in exact.items()}
    return _verdict(lambda: _certificate(lattice, near, numbers, error))


def waves_of_all_eps(lattice: Lattice, *, near: str, k: Number, eps: Number) -> ExactWave:
    """Prove that a chain K2 r + K4 r^3 has a wave next to eps' Y for every 0 < eps' <= ``eps``.

    Y is the "dn", "cn" or "sn" wave of the modified KdV equation with modulus ``k``; the chain's
    wave, of strain f and speed v, has the period, mean and first mode of eps' Y. For all eps' the
    interval ``distance_over_eps3`` contains sup |f - eps' Y|/eps'^3, and ``speed_over_eps4``
    contains |v^2 - K2 - sigma_0 eps'^2|/eps'^4, where sigma_0 is the speed of Y.

    >>> from longwave.derive import LATTICES
    >>> chain = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    >>> wave = waves_of_all_eps(chain, near="dn", k="3/5", eps="1/10")
    >>> print(wave.verdict, wave.numbers["distance_over_eps3"].lower[:7])
    EXISTS 0.01615
    """
    exact = {"k": rational("k", k), "eps": rational("eps", eps)}

    def certificate() -> dict[str, Any]:
        springs = _nearest_neighbours(lattice, near)
        _check_near(springs, near, exact["k"], exact["eps"])
        return tie_certificate(springs[0], near, exact["k"], exact["eps"])

    return _verdict(certificate)


def _verdict(find: Callable[[], dict[str, Any]]) -> ExactWave:
    """Check the certificate that ``find`` returns, and return the wave with the verdict."""
    return proved(find, ExactWave)


def _certificate(
    lattice: Lattice, near: str, numbers: Mapping[str, fmpq], error: float
) -> dict[str, Any]:
    springs = chain_springs(lattice)
    if numbers["speed"]:
        return solitary_certificate(springs, numbers["speed"], error)
    if near:
        springs = _nearest_neighbours(lattice, near)
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
    if near not in FORMS:
        raise ValueError(f"near must be one of {', '.join(FORMS)}, got {near!r}")
    springs = chain_springs(lattice)
    if [spring.neighbour for spring in springs] != [1]:
        raise Refused("a wave near one of mKdV is proved for nearest neighbours only")
    return springs


def _check_near(springs: tuple[Spring, ...], near: str, k: fmpq, eps: fmpq) -> None:
    """Raise ValueError for a form, modulus or eps that states no elliptic wave of the chain."""
    try:
        NearWave(near, k, eps, springs[0].force)
    except CertificateError as reason:
        raise ValueError(str(reason)) from reason

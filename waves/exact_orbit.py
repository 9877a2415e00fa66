"""Exact time-periodic orbits of a chain: the verdict on one, with every number as an interval."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, ctx, fmpq
from numpy.typing import ArrayLike, NDArray

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.lattice import Lattice
from longwave.waves.certificates import interval
from longwave.waves.kernel.cosine_series import value_at_zero
from longwave.waves.kernel.orbit import OrbitCentre
from longwave.waves.kernel.orbit_claim import BreatherClaim, OrbitClaim
from longwave.waves.kernel.reading import Record, ends_of
from longwave.waves.orbits import breather_certificate, orbit_certificate
from longwave.waves.proved import Interval, Proved, proved, rational
from longwave.waves.springs import Refused, chain_forces

MOST_SITES = 64


@dataclass(frozen=True)
class Multiplier:
    """A proved Floquet multiplier z = real + i imaginary of a pair z, 1/z."""

    real: Interval
    imaginary: Interval

    @property
    def is_unstable(self) -> bool:
        """Whether the modulus is proved to be above 1."""
        parts = [(Fraction(p.lower), Fraction(p.upper)) for p in (self.real, self.imaginary)]
        least = (0 if low <= 0 <= high else min(low * low, high * high) for low, high in parts)
        return sum(least) > 1


@dataclass(frozen=True)
class ExactOrbit(Proved):
    """Time-periodic orbit of a chain, with the verdict on its existence and its proved numbers.

    All sites are at rest at t = 0.
    """

    @property
    def numbers(self) -> dict[str, Interval]:
        """Proved numbers by name: period, energy, amplitude, parts of the multipliers."""
        numbers = super().numbers
        if "energy" in self.certificate:
            energy = Interval.around(Fraction(self.certificate["energy"]))
            numbers = {"period": numbers.pop("period"), "energy": energy, **numbers}
        return numbers

    @property
    def period(self) -> Interval:
        """Least period."""
        return self.numbers["period"]

    @property
    def energy(self) -> Interval:
        """Energy for unit masses, 0 in a chain with all q_n = 0."""
        return self.numbers["energy"]

    @property
    def amplitude(self) -> Interval:
        """Largest displacement at t = 0."""
        return self.numbers["amplitude"]

    @property
    def multipliers(self) -> tuple[Multiplier, ...]:
        """One Floquet multiplier of each pair z, 1/z but 1, 1; empty if they are not proved."""
        numbers = self.numbers
        result: list[Multiplier] = []
        while (name := f"multiplier_{len(result) + 1}") + "_real" in numbers:
            parts = (numbers[f"{name}_{part}"] for part in ("real", "imaginary"))
            result.append(Multiplier(*parts))
        return tuple(result)

    @property
    def start(self) -> tuple[Interval, ...]:
        """Displacement of each site at t = 0; of a breather, of the sites about the middle."""
        error = arb(0, arb(str(self.certificate["radius"])).upper())
        with ctx.workprec(int(self.certificate["bits"])):
            sums = [value_at_zero(modes) + error for modes in self._centre.modes]
            return tuple(Interval(*interval(ends_of(total))) for total in sums)

    def at(self, t: ArrayLike) -> NDArray[np.float64]:
        """Return the displacements (times, sites) in double precision."""
        modes = np.array([[float(c) for c in site] for site in self._centre.modes])
        order = np.arange(modes.shape[1])
        phases = 2 * np.pi / self.period.value * np.multiply.outer(np.asarray(t, float), order)
        return np.asarray(np.cos(phases) @ (modes * np.where(order, 2, 1)).T)

    def to_json(self) -> dict[str, Any]:
        """Return verdict, reason, radius, and the lower and upper end of each number."""
        data = {k: v for k, v in super().to_json().items() if not k.startswith("multiplier_")}
        pairs = [{"real": vars(z.real), "imaginary": vars(z.imaginary)} for z in self.multipliers]
        return {**data, "multipliers": pairs} if pairs else data

    @cached_property
    def _centre(self) -> OrbitCentre:
        with ctx.workprec(int(self.certificate["bits"])):
            record = Record(dict(self.certificate), "certificate")
            claim = OrbitClaim if self.certificate["kind"] == "orbit" else BreatherClaim
            return claim(record).centre


def exact_orbit(
    lattice: Lattice,
    *,
    sites: int = 0,
    mode: int = 1,
    energy: Number = 0,
    frequency: Number = 0,
    error: float = 1e-10,
) -> ExactOrbit:
    """Find a time-periodic orbit of a chain and prove that it exists.

    With ``sites`` the chain is finite and q = 0 beyond its ends. The orbit continues its linear
    ``mode``, 1 for the lowest frequency, up to an ``energy``. With a ``frequency`` the chain is
    infinite and the orbit is a breather. Masses are 1: forces and energies are divided by the mass.
    ``error`` is the largest error of the displacements that is accepted.

    Raises ValueError for arguments that state no orbit. If the proof fails or no theorem applies,
    the verdict says so.

    >>> from longwave.derive import LATTICES
    >>> chain = LATTICES["alpha_fput"].with_values({"K2": 1, "K3": "1/5"})
    >>> orbit = exact_orbit(chain, sites=3, energy="1/10")
    >>> print(orbit.verdict, f"{orbit.period.value:.12f}", len(orbit.multipliers))
    EXISTS 8.201623167483 2
    """
    if bool(sites) == bool(frequency):
        got = "both" if sites else "none"
        raise ValueError(f"one of sites and frequency must be given, got {got} (sites=5)")
    given = {"energy": rational("energy", energy), "frequency": rational("frequency", frequency)}
    if sites:
        _check_finite(sites, mode, given["energy"])
    elif not given["frequency"] > 0 or given["energy"]:
        raise ValueError("frequency must be positive, and given without an energy")

    def certificate() -> dict[str, Any]:
        springs = chain_forces(lattice)
        if sites:
            return orbit_certificate(springs, sites, mode, given["energy"], error)
        if springs[0].neighbour:
            raise Refused("a breather is proved for a chain with a force on each site")
        return breather_certificate(springs, given["frequency"], error)

    return proved(certificate, ExactOrbit)


def _check_finite(sites: int, mode: int, energy: fmpq) -> None:
    if not 1 <= sites <= MOST_SITES:
        raise ValueError(f"sites must be from 1 to {MOST_SITES}, got {sites}")
    if not 1 <= mode <= sites:
        raise ValueError(f"mode must be from 1 to the number of sites, got {mode}")
    if not energy > 0:
        raise ValueError(f"energy must be positive, got {energy} (1/2)")

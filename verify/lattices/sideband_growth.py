"""How fast a perturbed plane wave grows on a lattice, against its envelope equation.

The perturbation ``1 + delta (x + i y) cos(kappa X)`` of a plane wave of amplitude a grows with the
rate sigma in T, ``sigma^2 = p kappa^2 (2 q a^2 - p kappa^2)`` (Benjamin and Feir, J. Fluid Mech. 27
(1967) 417); on the lattice two sidebands beside the carrier grow.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sympy import Expr

from derive.algebra.exact_numbers import Number
from derive.carrier_envelope import Envelope
from lattice import FieldState, integrate
from verify.lattices.envelope_data import EnvelopeData
from verify.lattices.envelope_study import closing_count

Array = NDArray[np.float64]

SIZE = 1e-6
"""Of the perturbation at first."""

SPAN = (1.5, 5.0)
"""Times between which growth is measured, in units of 1/sigma: what decays has gone, and the
perturbation is still small."""

STEP = 0.25
"""Of the run, in units of 1/omega of the carrier; half of it in the control run."""


@dataclass(frozen=True)
class GrowthRate:
    """The growth rate in T on the lattice and in theory, and what half the step changes of it."""

    eps: float
    measured: float
    theory: float
    discretisation: float

    @property
    def difference(self) -> float:
        """Of the two, relative to the theory."""
        return self.measured / self.theory - 1.0


@dataclass(frozen=True)
class _PerturbedPlane:
    """The plane wave of amplitude ``a`` with the perturbation that grows."""

    a: float
    p: float
    q: float
    kappa: float

    @property
    def growth(self) -> float:
        return float(np.sqrt(self.p * self.kappa**2 * self._rest))

    @property
    def _rest(self) -> float:
        return 2 * self.q * self.a**2 - self.p * self.kappa**2

    def jets(self, X: Array, T: float, highest: int) -> Any:
        mixed = 1 + 1j * self.growth / (self.p * self.kappa**2)
        size = SIZE * mixed / abs(mixed) * np.exp(self.growth * T)
        wave = np.exp(1j * self.kappa * np.asarray(X))
        found = [
            size / 2 * ((1j * self.kappa) ** m * wave + (-1j * self.kappa) ** m / wave)
            for m in range(highest + 1)
        ]
        found[0] = found[0] + 1
        return self.a * np.exp(1j * self.q * self.a**2 * T) * np.array(found)


def sideband_growth(
    found: Envelope,
    constants: Mapping[str, Number],
    k: Expr,
    amplitude: float,
    eps: float,
    share: float = 1.0,
) -> GrowthRate:
    """The growth on a ring of one wavelength of the perturbation, with slaved data.

    ``share`` is kappa in units of that which grows fastest, between 0 and sqrt(2).  Raises
    ValueError where plane waves are stable.
    """
    numbers = found.coefficients(k, None, **constants)
    if not numbers.is_focusing:
        raise ValueError(
            f"k must be that of an unstable wave, p q > 0, got p = {numbers.p:g} and "
            f"q = {numbers.q:g} (take another k or other constants)"
        )
    fastest = amplitude * np.sqrt(numbers.q / numbers.p)
    cells = closing_count(2 * np.pi / (share * fastest * eps), k, np.ones(2, dtype=complex))
    kappa = 2 * np.pi / (cells * eps)
    wave = _PerturbedPlane(amplitude, numbers.p, numbers.q, kappa)
    data = EnvelopeData(found, constants, wave, eps, "slaved", k=k)
    begin, end = (units / wave.growth / eps**2 for units in SPAN)
    ring = data.ring(np.arange(float(cells)), 0.0)
    rates = []
    for step in (STEP / numbers.omega, STEP / numbers.omega / 2):
        state = FieldState(0.0, ring.f, ring.v)
        run = integrate(ring.lattice, state, [begin, end], step=step, measure_error=False)
        pairs = zip(run.f, run.v, strict=True)
        first, last = (_sidebands(f, v, float(k), numbers.omega) for f, v in pairs)
        rates.append(float(np.log(last / first)) / (end - begin) / eps**2)
    return GrowthRate(eps, rates[1], wave.growth, abs(rates[1] - rates[0]))


def _sidebands(f: Array, v: Array, k: float, omega: float) -> float:
    """The size of the two waves beside the carrier, of those that move as it does."""
    spectrum = np.fft.fft(f[0] + 1j * v[0] / omega)
    place = round(k * f.shape[1] / (2 * np.pi))
    return float(np.hypot(*np.abs(spectrum[[place - 1, (place + 1) % f.shape[1]]])))

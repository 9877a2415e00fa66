"""The fields of a carrier wave with numbers: what the lattice holds for a given amplitude A.

A field is ``sum value eps^power product of jets``, each product turning with its harmonic; a jet is
the m-th X-derivative of A or of its conjugate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import mpmath

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.jets import EpsSeries, Monomial, raised
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.derive.carrier import LAST, EnvelopeError, harmonic
from longwave.derive.carrier_envelope import DIGITS, GUARD, Envelope, evaluated


class CarrierTerm(NamedTuple):
    """``value eps^power`` times the jets (m, 0) of A and (m, 1) of its conjugate."""

    power: int
    jets: Monomial
    value: complex

    @property
    def harmonic(self) -> int:
        """The number of A, less that of its conjugates."""
        return harmonic(self.jets)


CarrierTerms = tuple[CarrierTerm, ...]


@dataclass(frozen=True)
class CarrierFields:
    """The ansatz of an envelope at one wavenumber, through eps^3.

    ``parts``: of each field the harmonics from 0 up; the complex conjugates of those above 0 are
    left out.  ``mean``: the mean S, of which field j holds ``shares[j]`` times; in a lattice of
    displacements (``is_displacement``) the X-integral of S over eps, for which ``mean_slope`` is
    S_X and ``mean_flow`` the T-derivative of the integral at the first order.  A lattice that is
    tied to its place has no such mean: its own is harmonic 0 of ``parts``.  ``flow``: A_T and its
    X-derivatives, as many as there are jets in the rest.
    """

    k: float
    omega: float
    v: float
    parts: tuple[CarrierTerms, ...]
    mean: CarrierTerms
    mean_slope: CarrierTerms
    mean_flow: CarrierTerms
    shares: tuple[float, ...]
    is_displacement: bool
    flow: tuple[CarrierTerms, ...]

    @property
    def highest_jet(self) -> int:
        """The most X-derivatives of A in fields and their time derivatives."""
        every = (self.mean, self.mean_slope, self.mean_flow, *self.parts, *self.flow)
        return max(m for terms in every for term in terms for m, _ in term.jets)


def carrier_fields(
    envelope: Envelope, k: Number | None = None, branch: str | int | None = None, **given: Number
) -> CarrierFields:
    """The fields at a wavenumber and values of all constants, as for `Envelope.coefficients`.

    Raises what that raises.

    >>> from longwave.derive import LATTICES, envelope
    >>> found = carrier_fields(envelope(LATTICES["fput_strain"]), 1, K2=1, K3=0, K4=1)
    >>> found.parts[0][0]
    CarrierTerm(power=1, jets=((0, 0),), value=(1+0j))
    """
    envelope = envelope.regular(k, branch, **given)
    numbers = envelope.coefficients(k, branch, **given)
    point = envelope.point(k, branch, given)
    carrier = envelope.carrier
    free = not carrier.is_pinned
    with mpmath.workdps(DIGITS + GUARD):
        parts = tuple(_numeric(part, point) for part in carrier.parts)
        mean = _numeric(carrier.mean, point) if free else ()
        shares = tuple(float(_value(share, point).real) for share in carrier.shares)
        highest = 1 + max(m for terms in (*parts, mean) for t in terms for m, _ in t.jets)
        flow = [_numeric(carrier.flow, point)]
        for _ in range(highest):
            flow.append(_slope(flow[-1]))
        return CarrierFields(
            float(point["k"]),
            numbers.omega,
            numbers.v,
            parts,
            mean,
            _slope(mean),
            _numeric(carrier.mean_flow, point) if carrier.is_displacement else (),
            shares,
            carrier.is_displacement,
            tuple(flow),
        )


def _numeric(series: EpsSeries, point: Mapping[str, mpmath.mpc]) -> CarrierTerms:
    """The terms through the last complete order, without harmonics below 0."""
    return tuple(
        CarrierTerm(power, jets, complex(_value(value, point)))
        for power, part in series.parts.items()
        for jets, value in part.terms.items()
        if power < LAST and harmonic(jets) >= 0
    )


def _slope(terms: CarrierTerms) -> CarrierTerms:
    """The X-derivative."""
    total: dict[tuple[int, Monomial], complex] = {}
    for power, jets, value in terms:
        for i, jet in enumerate(jets):
            key = power, tuple(sorted((*jets[:i], raised(jet, 0), *jets[i + 1 :])))
            total[key] = total.get(key, 0.0) + value
    return tuple(CarrierTerm(*key, value) for key, value in total.items())


def _value(element: RationalFunction, point: Mapping[str, mpmath.mpc]) -> mpmath.mpc:
    found = evaluated(element, point)
    if found is None:
        raise EnvelopeError(
            f"k must be no resonance, got {mpmath.nstr(point['k'], 8)}, where a harmonic of "
            "the carrier is a wave of the lattice (take another wavenumber)"
        )
    return found

"""Fields of a carrier wave as numbers: the ansatz for a given amplitude A.

A field is ``sum value eps^power product of jets``, each product with the phase of its harmonic; a
jet is the m-th X-derivative of A or of its conjugate.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import mpmath

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.jets import EpsSeries, Monomial, raised
from longwave.derive.algebra.rational_functions import RationalFunction
from longwave.derive.carrier import LAST, EnvelopeError, harmonic
from longwave.derive.carrier_envelope import DIGITS, GUARD_DIGITS, Envelope, evaluated


class CarrierTerm(NamedTuple):
    """``value eps^power`` times jets: (m, 0) is the m-th derivative of A, (m, 1) its conjugate."""

    power: int
    jets: Monomial
    value: complex

    @property
    def harmonic(self) -> int:
        """The number of jets of A minus the number of jets of its conjugate."""
        return harmonic(self.jets)


CarrierTerms = tuple[CarrierTerm, ...]


@dataclass(frozen=True)
class CarrierFields:
    """The ansatz of an envelope at one wavenumber, through eps^3.

    ``parts``: harmonics from 0 up of each field; complex conjugates of those above 0 are omitted.
    ``mean``: the mean S, which enters field j ``shares[j]`` times; for displacements
    (``is_displacement``) it is the X-integral of S over eps, with ``mean_slope`` S_X and
    ``mean_flow`` the T-derivative of the integral at the first order.  A pinned lattice has no such
    mean: its mean is harmonic 0 of ``parts``.  ``flow``: A_T and its X-derivatives, as many as the
    other terms need.
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
        """Largest number of X-derivatives of A in fields and their time derivatives."""
        every = (self.mean, self.mean_slope, self.mean_flow, *self.parts, *self.flow)
        return max(m for terms in every for term in terms for m, _ in term.jets)


def carrier_fields(
    envelope: Envelope,
    k: Number | None = None,
    branch: str | int | None = None,
    **constants: Number,
) -> CarrierFields:
    """Return the ansatz's fields at a wavenumber and values of all constants.

    Arguments and errors are those of `Envelope.coefficients`.

    >>> from longwave.derive import LATTICES, envelope
    >>> found = carrier_fields(envelope(LATTICES["fput_strain"]), 1, K2=1, K3=0, K4=1)
    >>> found.parts[0][0]
    CarrierTerm(power=1, jets=((0, 0),), value=(1+0j))
    """
    envelope = envelope.regular(k, branch, **constants)
    numbers = envelope.coefficients(k, branch, **constants)
    point = envelope.point(k, branch, constants)
    carrier = envelope.carrier
    free = not carrier.is_pinned
    with mpmath.workdps(DIGITS + GUARD_DIGITS):
        parts = tuple(_numeric(part, point) for part in carrier.parts)
        mean = _numeric(carrier.mean, point) if free else ()
        shares = tuple(float(_value(weight, point).real) for weight in carrier.field_weights)
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
    """Return a series' terms with numerical values at a point, to eps^3, of harmonics from 0 up."""
    return tuple(
        CarrierTerm(power, jets, complex(_value(value, point)))
        for power, part in series.parts.items()
        for jets, value in part.terms.items()
        if power < LAST and harmonic(jets) >= 0
    )


def _slope(terms: CarrierTerms) -> CarrierTerms:
    """Return the X-derivative of a sum of terms."""
    total: dict[tuple[int, Monomial], complex] = {}
    for power, jets, value in terms:
        for i, jet in enumerate(jets):
            key = power, tuple(sorted((*jets[:i], raised(jet, 0), *jets[i + 1 :])))
            total[key] = total.get(key, 0.0) + value
    return tuple(CarrierTerm(*key, value) for key, value in total.items())


def _value(element: RationalFunction, point: Mapping[str, mpmath.mpc]) -> mpmath.mpc:
    number = evaluated(element, point)
    if number is None:
        raise EnvelopeError(
            f"k must not be a resonance, got {mpmath.nstr(point['k'], 8)}, where a harmonic of "
            "the carrier is a wave of the lattice (take another wavenumber)"
        )
    return number

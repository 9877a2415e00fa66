"""The power of eps that theory has for the error of a wave on its lattice, from the expansion.

The error at fixed slow time is that of the first thing that is left out: of the equation, its next
order that does not vanish; of the data, the fields that follow the wave.
"""

from __future__ import annotations

from collections.abc import Mapping

from longwave.derive import CarrierTerms, Envelope, Lattice, Reduction, carrier_fields, reduce
from longwave.derive.algebra.exact_numbers import Number
from longwave.scenes.lattice_derivation import derivation
from longwave.scenes.scene import Scene

SEEN = 4
"""Orders behind the reduced equation in which the second that does not vanish is looked for: the
even ones alone are there for cells that look alike from both sides."""

ZERO = 1e-12
"""A coefficient that small, of numbers of order one with 60 digits, is 0."""


def long_wave_rate(reduction: Reduction, lattice: Lattice, order: str) -> int | None:
    """The power of the strain's error for data of that order; None where theory names none.

    That is so for leading data of several fields, whose free waves no expansion follows, and where
    no order behind the equation is found.

    >>> from sympy import S
    >>> from longwave.derive import LATTICES
    >>> chain = LATTICES["fput_strain"].with_values({"K2": S.One, "K3": S.Zero, "K4": S.One})
    >>> found = reduce(chain)
    >>> [long_wave_rate(found, chain, order) for order in ("leading", "corrected")]
    [3, 5]
    """
    scaling = reduction.scaling
    if order == "leading" and len(lattice.fields) > 1:
        return None
    least = scaling.leading_order
    further = reduce(lattice, scaling, least + SEEN).orders
    gaps = sorted(found - least for found in further if found > least)
    place = order == "corrected"
    if len(gaps) <= place:
        return None
    strain = scaling.amplitude + scaling.space[0].exponent * reduction.is_displacement
    left = min(gaps[1], 2 * gaps[0]) if place else gaps[0]
    return strain + left


def envelope_rate(envelope: Envelope, numbers: Mapping[str, Number], order: str) -> int:
    """The power of the error of a carrier wave with data of that order.

    >>> from longwave.derive import LATTICES, envelope
    >>> found = envelope(LATTICES["fput_strain"], 1)
    >>> envelope_rate(found, {"K2": 1, "K3": 0, "K4": 1}, "slaved")
    2
    """
    fields = carrier_fields(envelope, None, None, **numbers)
    is_further = _has(fields.flow[0], 1)
    follows = any(_has(terms, 2) for terms in (*fields.parts, fields.mean))
    return 2 if order != "corrected" and (is_further or (order == "leading" and follows)) else 3


def _has(terms: CarrierTerms, power: int) -> bool:
    """Whether there is a term in eps to that power."""
    return any(term.power == power and abs(term.value) > ZERO for term in terms)


def scene_rate(scene: Scene) -> int | None:
    """The power of eps for the error of a scene; None where theory names none.

    So it is, too, where masses or springs deviate: the waves that these scatter are no part of it.
    """
    if scene.disorder:
        return None
    found = derivation(scene)
    if isinstance(found.source, Reduction):
        return long_wave_rate(found.source, found.lattice, scene.order)
    return envelope_rate(found.source, found.numbers, scene.order)

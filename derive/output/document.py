"""Reductions as JSON.

A polynomial is ``{"text": ..., "terms": [...]}``; a term holds its jets and its coefficient as
numerator and denominator, each a list of [exponents, "p/q"] over the document's ``generators``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from sympy import QQ
from sympy.polys.fields import FracElement, FracField
from sympy.polys.rings import PolyElement

from derive.algebra.exact_numbers import Number, parse_rational
from derive.algebra.jets import DifferentialPolynomial
from derive.output.notation import Notation, text_of

if TYPE_CHECKING:
    from derive.reduction import Reduction

Data = dict[str, Any]


def reduction_data(reduction: Reduction, constants: Mapping[str, Number] | None = None) -> Data:
    """The document: ansatz, orders, conditions, reduced equation, corrections, normal form.

    Coefficients and normal form are those at ``constants`` (names to values).
    """
    notation, obstruction = reduction.notation, reduction.obstruction

    def data(part: DifferentialPolynomial) -> Data:
        return polynomial_data(part, notation)

    sound = reduction.sound_condition
    return {
        "lattice": reduction.lattice.name,
        "scaling": _scaling_data(reduction),
        "generators": [str(symbol) for symbol in reduction.pde.flow.field.symbols],
        "orders": {str(o): data(e.polynomial) for o, e in reduction.orders.items()},
        "sound_condition": f"{text_of(sound.lhs)} = {text_of(sound.rhs)}",
        "conditions": [
            {"order": item.order, "vanishes": text_of(item.expression), "reason": item.reason}
            for item in reduction.conditions
        ],
        "pde": {"equation": reduction.pde.text(), **data(reduction.pde.polynomial)},
        "remainders": {str(o): data(part) for o, part in reduction.remainders.items()},
        "corrections": {str(p): data(part) for p, part in reduction.corrections.items()},
        "obstruction": {str(obstruction[0]): data(obstruction[1])} if obstruction else {},
        **_number_data(reduction, constants or {}),
    }


def _scaling_data(reduction: Reduction) -> Data:
    scaling = reduction.scaling
    return {
        "amplitude": scaling.amplitude,
        "time": scaling.time,
        "space": [
            {
                "name": v.name,
                "exponent": v.exponent,
                "direction": list(v.direction),
                "speed": text_of(v.speed),
            }
            for v in scaling.space
        ],
        "background": [[exponent, text_of(value)] for exponent, value in scaling.background],
    }


def _number_data(reduction: Reduction, constants: Mapping[str, Number]) -> Data:
    """The coefficients at ``constants``, and the normal form if the equation is mKdV."""
    data: Data = {"constants": {name: str(value) for name, value in constants.items()}}
    values = reduction.coefficients(**constants)
    terms = {name: text_of(value) for name, value in values.terms.items()}
    data["coefficients"] = {"c": text_of(values.c), "terms": terms}
    if reduction.pde.is_mkdv:
        form = reduction.normal_form(**constants)
        data["normal_form"] = {
            item.name: text_of(getattr(form, item.name)) for item in fields(form)
        }
    return data


def polynomial_data(polynomial: DifferentialPolynomial, notation: Notation) -> Data:
    """One polynomial as JSON-ready data."""
    return {
        "text": notation.text(polynomial),
        "terms": [
            {
                "jets": [list(jet) for jet in monomial],
                "numerator": _ring_data(coefficient.numer),
                "denominator": _ring_data(coefficient.denom),
            }
            for monomial, coefficient in polynomial.terms.items()
        ],
    }


def polynomial_from_data(data: Data, field: FracField) -> DifferentialPolynomial:
    """The polynomial that polynomial_data wrote, over the same field.

    Raises ValueError for a coefficient that is no rational number.
    """
    return DifferentialPolynomial.collect(
        field,
        (
            (
                tuple(tuple(jet) for jet in term["jets"]),
                _element(term["numerator"], field) / _element(term["denominator"], field),
            )
            for term in data["terms"]
        ),
    )


def _ring_data(element: PolyElement) -> list[list[Any]]:
    return [[list(exponents), str(number)] for exponents, number in element.terms()]


def _element(data: list[list[Any]], field: FracField) -> FracElement:
    total = field.ring.zero
    for exponents, number in data:
        value = QQ.from_sympy(parse_rational("coefficient", number))
        total += field.ring.term_new(tuple(exponents), value)
    return field.new(total)

"""A reduction as text, LaTeX and JSON.

In JSON a polynomial is ``{"text": ..., "terms": [...]}``; a term has its jets and its coefficient
as numerator and denominator, each a list of [exponents, "p/q"] over the document's ``generators``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from sympy import Symbol

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.algebra.jets import DifferentialPolynomial
from longwave.derive.normal_form import NORMAL_EQUATIONS, NormalForm
from longwave.derive.output.notation import Notation, aligned, latex_of, power_of, text_of
from longwave.derive.output.own_names import marked, unused
from longwave.derive.symbols import eps

if TYPE_CHECKING:
    from longwave.derive.lattice import Lattice
    from longwave.derive.reduction import Reduction
    from longwave.derive.scaling import Scaling

Data = dict[str, Any]


def text_lines(reduction: Reduction) -> Iterator[str]:
    """Yield ansatz, orders, conditions, reduced equation and corrections as lines of text."""
    yield from head_lines(reduction.lattice)
    yield f"ansatz: {reduction.scaling.text(reduction.lattice.fields[0], reduction.wave)}"
    yield from (f"  {line}" for line in _slaved_lines(reduction))
    if reduction.is_displacement:
        yield f"  {reduction.units}"
    yield ""
    yield "orders of the lattice equation:"
    for order in range(min(reduction.orders), reduction.highest_order + 1):
        equation = reduction.orders.get(order)
        yield f"  eps^{order}: {equation.text() if equation else '0 = 0'}"
    yield ""
    sound = reduction.sound_condition
    yield f"sound condition: {text_of(sound.lhs)} = {text_of(sound.rhs)}"
    yield from (f"condition: {condition.text()}" for condition in reduction.conditions)
    yield f"reduced equation (order eps^{reduction.scaling.leading_order}), {reduction.pde.kind}:"
    yield f"  {reduction.pde.text()}"
    yield from (f"  {line}" for line in reduction.idle_losses)
    for symbol, value in reduction.lattice.definitions:
        if value.is_zero is not True and reduction.pde.flow.field.symbols.count(symbol):
            yield f"  {symbol} = {text_of(value)}"
    yield from _beyond(reduction)


def head_lines(lattice: Lattice) -> Iterator[str]:
    """Yield title, equations of motion, and messages on forces without an energy."""
    yield lattice.title
    yield from (f"  {line}" for line in lattice.equations())
    yield from (f"  not an energy: {line}" for line in lattice.missing_energies)


def _slaved_lines(reduction: Reduction) -> Iterator[str]:
    """Yield the first slaved term of each field after the first."""
    notation = replace(reduction.notation, unknown=reduction.wave)
    field = reduction.pde.flow.field
    unit = DifferentialPolynomial.monomial(field, ((0,) * len(notation.axes),))
    small = partial(power_of, eps, printed=text_of)
    for name, (weight, series) in list(reduction.slaved.items())[1:]:
        first = next(iter(series.parts.items()), None)
        wave_text = small(reduction.scaling.amplitude) + notation.text(weight * unit)
        text = f" + {small(first[0])}({notation.text(first[1])}) + ..." if first else ""
        yield f"{name} = {wave_text}{text}"


def _beyond(reduction: Reduction) -> Iterator[str]:
    notation = reduction.notation
    for order, part in reduction.remainders.items():
        yield f"left in the lattice equation at eps^{order} by an exact solution of it:"
        yield f"  {reduction.label('R', order)} = {notation.text(part)}"
    for power, part in reduction.corrections.items():
        name = reduction.label("G", power)
        yield f"correction of the reduced equation, Y_T = ... + eps^{power} {name}:"
        yield f"  {name} = {notation.text(part)}"
    if reduction.obstruction:
        power, part = reduction.obstruction
        yield f"no local correction at eps^{power}: this is not an X-derivative:"
        yield f"  {notation.text(part)}"


def latex_report(reduction: Reduction, constants: Mapping[str, Number]) -> str:
    """Return orders, conditions, reduced equation and coefficients as one ``aligned`` block."""
    rows = [(rf"\epsilon^{{{order}}}:", e.latex()) for order, e in reduction.orders.items()]
    rows.append((r"\text{sound}:", latex_of(reduction.sound_condition)))
    rows += [(r"\text{condition}:", condition.latex()) for condition in reduction.conditions]
    rows.append((r"\text{reduced}:", reduction.pde.latex()))
    rows += [("", reduction.latex_remainder(order)) for order in reduction.remainders]
    rows += [("", reduction.latex_correction(power)) for power in reduction.corrections]
    values = reduction.coefficients(**constants)
    rows += [("", f"{latex_of(reduction.scaling.speed)} = {latex_of(values.c)}")]
    if constants:
        for name, value in values.terms.items():
            term = reduction.notation.monomial(values.monomials[name], latex_of)
            rows.append((rf"\text{{of }} {term}:", latex_of(value)))
    if reduction.has_normal_form:
        form = reduction.normal_form(**constants)
        taken = reduction.lattice.names
        equation = marked(NORMAL_EQUATIONS[form.equation].latex, "srU", taken)
        rows.append((r"\text{normal form}:", re.sub(r"(\w)~", r"\\tilde{\1}", equation)))
        values_by_label = {latex_of(Symbol(unused(n, taken))): v for n, v in form.values.items()}
        rows += [("", f"{label} = {latex_of(value)}") for label, value in values_by_label.items()]
    return aligned(rows)


def reduction_data(reduction: Reduction, constants: Mapping[str, Number]) -> Data:
    """Return the document: ansatz, orders, conditions, reduced equation, corrections, normal form.

    Coefficients and normal form are those at ``constants`` (names to values).
    """
    notation, obstruction = reduction.notation, reduction.obstruction
    losses: Data = {}
    if reduction.lattice.has_losses:
        law = reduction.amplitude_law(**constants)
        texts = law and {"rate": text_of(law.rate), "solution": text_of(law.solution)}
        losses = {"idle_losses": list(reduction.idle_losses), "amplitude_law": texts}

    def data(part: DifferentialPolynomial) -> Data:
        return polynomial_data(part, notation)

    sound = reduction.sound_condition
    return {
        "lattice": reduction.lattice.name,
        "equations": list(reduction.lattice.equations()),
        "missing_energies": list(reduction.lattice.missing_energies),
        "scaling": _scaling_data(reduction.scaling),
        "generators": [str(symbol) for symbol in reduction.pde.flow.field.symbols],
        "orders": {str(o): data(e.polynomial) for o, e in reduction.orders.items()},
        "sound_condition": f"{text_of(sound.lhs)} = {text_of(sound.rhs)}",
        "conditions": [
            {"order": item.order, "vanishes": text_of(item.expression), "reason": item.reason}
            for item in reduction.conditions
        ],
        "kind": reduction.pde.kind,
        **losses,
        "units": reduction.units,
        "definitions": {str(s): text_of(value) for s, value in reduction.lattice.definitions},
        "pde": {"equation": reduction.pde.text(), **data(reduction.pde.polynomial)},
        "remainders": {str(o): data(part) for o, part in reduction.remainders.items()},
        "corrections": {str(p): data(part) for p, part in reduction.corrections.items()},
        "obstruction": {str(obstruction[0]): data(obstruction[1])} if obstruction else {},
        **_number_data(reduction, constants),
    }


def _scaling_data(scaling: Scaling) -> Data:
    return {
        "amplitude": scaling.amplitude,
        "time": scaling.time,
        "space": [
            {
                "name": v.name,
                "exponent": v.exponent,
                "direction": [int(d) if d.is_Integer else text_of(d) for d in v.direction],
                "speed": text_of(v.speed),
            }
            for v in scaling.space
        ],
        "background": [[exponent, text_of(value)] for exponent, value in scaling.background],
    }


def _number_data(reduction: Reduction, constants: Mapping[str, Number]) -> Data:
    """Return the coefficients at ``constants``, and the normal form if the equation has one."""
    values = reduction.coefficients(**constants)
    terms = {name: text_of(value) for name, value in values.terms.items()}
    has_form = reduction.has_normal_form
    return {
        "constants": {name: str(value) for name, value in constants.items()},
        "coefficients": {"c": text_of(values.c), "terms": terms},
        **({"normal_form": form_data(reduction.normal_form(**constants))} if has_form else {}),
    }


def form_data(form: NormalForm) -> Data:
    """Return a normal form as JSON-ready data."""
    return {
        "equation": form.equation,
        "normal_form": NORMAL_EQUATIONS[form.equation].text,
        "map": form.map_text,
        **{name: text_of(value) for name, value in {**form.values, "c": form.c}.items()},
    }


def polynomial_data(polynomial: DifferentialPolynomial, notation: Notation) -> Data:
    """Return one polynomial as JSON-ready data."""
    return {
        "text": notation.text(polynomial),
        "terms": [
            {
                "jets": [list(jet) for jet in monomial],
                **{
                    name: [[list(exponents), str(n)] for exponents, n in value.terms(below=below)]
                    for name, below in (("numerator", False), ("denominator", True))
                },
            }
            for monomial, value in polynomial.terms.items()
        ],
    }

"""What ``longwave derive`` prints: a reduction, the linear waves, coefficients at given numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal

from derive.algebra.exact_numbers import Number, parse_rational
from derive.command_line import fail
from derive.dispersion import agrees_with_reduction, dispersion_relation
from derive.models.lattices import FPUT_STRAIN
from derive.models.mkdv import initial_velocity, initial_velocity_latex
from derive.multiscale import reduce
from derive.output.notation import aligned, text_of
from derive.reduction import Reduction

MOST_ORDERS = 13

Form = Literal["text", "latex", "json"]


def print_reduction(constants: Mapping[str, str | None], orders: str | None, form: Form) -> int:
    """Print the reduction in that form; returns the exit status (2 for wrong input).

    ``constants`` are values as text by name, None where a constant stays a symbol; ``orders`` is
    the highest power of eps as text, None for the default.
    """
    try:
        values: dict[str, Number] = {
            name: parse_rational(name, text) for name, text in constants.items() if text is not None
        }
        reduction = reduce(FPUT_STRAIN, orders=None if orders is None else _orders(orders))
        numbers = list(_number_lines(reduction, values))
    except ValueError as error:
        return fail(error)
    if form == "json":
        print(reduction.json(**values))
    elif form == "latex":
        print("\n".join([reduction.latex(**values), _linear_latex(reduction)]))
    else:
        print("\n".join([reduction.text(), *_linear_lines(reduction), *numbers]))
    return 0


def _orders(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 4 and int(text) <= MOST_ORDERS):
        raise ValueError(
            f"--orders must be an integer <= {MOST_ORDERS}, got {text!r} (leave it for the default)"
        )
    return int(text)


def _linear_lines(reduction: Reduction) -> Iterator[str]:
    relation = dispersion_relation(reduction.lattice)
    yield ""
    yield "linear waves about the uniform strain ybar:"
    yield f"  omega^2 = {text_of(relation.omega_squared)}"
    yield f"  omega_+ = {text_of(relation.omega_plus)}"
    yield f"          = {text_of(relation.long_wave())} + O(k^5)"
    agrees = agrees_with_reduction(reduction.lattice, reduction)
    yield f"  same as the reduced equation's linear part to k^3: {'yes' if agrees else 'NO'}"
    yield f"initial velocity: s = {text_of(initial_velocity())}"


def _linear_latex(reduction: Reduction) -> str:
    rows = [*dispersion_relation(reduction.lattice).latex(), initial_velocity_latex()]
    return aligned([("", row) for row in rows])


def _number_lines(reduction: Reduction, values: dict[str, Number]) -> Iterator[str]:
    coefficients = reduction.coefficients(**values)
    form = reduction.normal_form(**values)
    given = ", ".join(f"{name} = {value}" for name, value in values.items())
    yield ""
    yield f"coefficients{' at ' + given if given else ''}:"
    yield f"  c = {text_of(coefficients.c)}"
    yield from (f"  of {name}: {text_of(value)}" for name, value in coefficients.terms.items())
    yield "normal form U_tau + 6 s U^2 U_xi + U_xixixi = 0, Y(X, T) = U(a X, b T):"
    yield f"  a = {text_of(form.a)}"
    yield f"  b = {text_of(form.b)}"
    yield f"  s = {text_of(form.s)}"

"""Random admissible points of a closed form: exact rationals, the same for the same seed."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

import sympy as sp

from solutions.parameter import Bound, Parameter
from solutions.record import ClosedForm

Point = dict[sp.Symbol, sp.Rational]
"""A value for each variable and parameter of a closed form."""

HALF_WIDTH = 4
"""A variable is drawn between plus and minus this; a domain without an end is cut this far beyond
0 and its other end."""

DENOMINATOR = 1009
"""A prime, so that no drawn value is exact in binary and every one tests the precision."""

MARGIN = sp.Rational(1, 20)
"""Share of a bounded domain left out at each end, where the neighbouring limit takes over."""


def sample_points(form: ClosedForm, count: int, seed: int) -> list[Point]:
    """``count`` points with parameters inside their domains and xi, tau within +-4.

    A form's points depend on its name, the seed and nothing else.
    """
    draw = random.Random(f"{form.name}:{seed}")
    return [_point(form, draw) for _ in range(count)]


def _point(form: ClosedForm, draw: random.Random) -> Point:
    point: Point = {}
    for parameter in in_order_of_dependence(form.parameters):
        low, high = _interval(parameter, point)
        point[parameter.symbol] = low + (high - low) * _fraction(draw)
    for variable in (form.equation.xi, form.equation.tau):
        point[variable] = HALF_WIDTH * (2 * _fraction(draw) - 1)
    return point


def _fraction(draw: random.Random) -> sp.Rational:
    """A rational strictly between 0 and 1."""
    return sp.Rational(draw.randint(1, DENOMINATOR - 1), DENOMINATOR)


def in_order_of_dependence(parameters: Sequence[Parameter]) -> list[Parameter]:
    """The parameters with each one after those that its bounds contain."""
    ordered: list[Parameter] = []
    waiting = list(parameters)
    while waiting:
        known = {parameter.symbol for parameter in ordered}
        ready = [p for p in waiting if _bound_symbols(p) <= known]
        if not ready:
            names = ", ".join(p.name for p in waiting)
            raise ValueError(
                f"bounds must not depend on each other, got those of {names} (fix the record)"
            )
        ordered += ready
        waiting = [p for p in waiting if p not in ready]
    return ordered


def _bound_symbols(parameter: Parameter) -> set[sp.Symbol]:
    bounds = (bound for bound in (parameter.lower, parameter.upper) if bound is not None)
    return {symbol for bound in bounds for symbol in bound.value.free_symbols}


def _interval(
    parameter: Parameter, known: Mapping[sp.Symbol, sp.Rational]
) -> tuple[sp.Rational, ...]:
    """The ends between which the parameter is drawn; a margin short of each bound."""
    lower, upper = (_end(bound, known) for bound in (parameter.lower, parameter.upper))
    if lower is None:
        lower = min(sp.S.Zero if upper is None else upper, sp.S.Zero) - HALF_WIDTH
    if upper is None:
        upper = max(lower, sp.S.Zero) + HALF_WIDTH
    margin = MARGIN * (upper - lower)
    return lower + margin, upper - margin


def _end(bound: Bound | None, known: Mapping[sp.Symbol, sp.Rational]) -> sp.Rational | None:
    """A rational close to the bound; the margin covers the difference."""
    if bound is None or bound.value in (sp.oo, -sp.oo):
        return None
    value = bound.value.subs(known)
    return value if value.is_Rational else sp.Rational(str(sp.N(value, 10)))

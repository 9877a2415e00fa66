"""What a proof takes for granted, in words."""

from __future__ import annotations

import sympy as sp

from verify.tree import distinct_nodes

from .balls import Point
from .compilation import Compilation

CONJUGATION = "conjugation takes I to -I: symbols, roots and functions of real arguments are real"


def assumptions(compiled: Compilation, point: Point) -> tuple[str, ...]:
    """The reading of the formulas under which the proof holds."""
    at = ", ".join(f"{symbol} = {value}" for symbol, value in sorted(point.items(), key=str))
    lines = [
        "an identity of analytic functions of the variables and parameters; it holds wherever "
        "the formula is analytic and connected to the point below",
        f"no denominator vanishes identically: shown by balls at {at}",
    ]
    meanings = [generator.meaning for generator in compiled.field.generators]
    roots = [m for m in meanings if isinstance(m, sp.Pow) and m.exp.is_Rational]
    lines += [f"{root} is one branch throughout" for root in roots]
    conjugated = (sp.conjugate, sp.re, sp.im, sp.Abs)
    nodes = (node for expression in compiled.expressions for node in distinct_nodes(expression))
    if any(isinstance(node, conjugated) for node in nodes):
        lines.append(CONJUGATION)
    return tuple(lines)

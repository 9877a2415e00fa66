"""Poles, jumps and branch points that a formula may have inside its domains, in words.

A verdict speaks of the points at which a formula is smooth.  What is named here is not shown to
be smooth everywhere: a denominator not shown to be different from 0, a root or logarithm of what
is not shown to be positive, an absolute value or a sign of what is not shown to be different from
0, an inverse function at an end of its cuts.
"""

from __future__ import annotations

from collections.abc import Iterable

import sympy as sp

from verify.tree import abbreviated, distinct_nodes

from .domain import Domains
from .domain_signs import Signs
from .ranges import Range

POLES = {sp.tan: sp.cos, sp.sec: sp.cos, sp.cot: sp.sin, sp.csc: sp.sin}
HYPERBOLIC_POLES = (sp.coth, sp.csch)
DEPTH = 3
"""Levels of a subexpression that a line shows."""


def singularities(expressions: Iterable[sp.Expr], domains: Domains) -> tuple[str, ...]:
    """One line for each place where ``expressions`` may fail to be smooth on ``domains``.

    >>> x = sp.Symbol("x", real=True)
    >>> singularities([sp.sqrt(x) / (1 + x**2)], {})
    ('branch point where x is not positive',)
    """
    signs = Signs(domains)
    nodes = (node for expression in expressions for node in distinct_nodes(expression))
    found = (line for node in nodes for line in _lines(node, signs))
    return tuple(dict.fromkeys(found))


def _lines(node: sp.Expr, signs: Signs) -> list[str]:
    if not node.free_symbols:
        return []
    lines = []
    if node.is_Pow and node.exp.could_extract_minus_sign() and not signs.is_nonzero(node.base):
        lines.append(f"pole where {_short(node.base)} = 0")
    is_root = node.is_Pow and not node.exp.is_Integer
    if (is_root or isinstance(node, sp.log)) and not signs.is_positive(node.args[0]):
        lines.append(f"branch point where {_short(node.args[0])} is not positive")
    if isinstance(node, sp.Abs | sp.sign) and not signs.is_nonzero(node.args[0]):
        lines.append(f"jump or corner where {_short(node.args[0])} = 0")
    if node.func in POLES:
        lines.append(f"pole where {_short(POLES[node.func](node.args[0]))} = 0")
    if isinstance(node, HYPERBOLIC_POLES) and not signs.is_nonzero(node.args[0]):
        lines.append(f"pole where {_short(sp.sinh(node.args[0]))} = 0")
    if isinstance(node, sp.asin | sp.acos | sp.atanh | sp.acosh) and not _is_inside(node, signs):
        lines.append(f"branch point of {_short(node)}")
    if isinstance(node, sp.atan | sp.asinh) and not signs.is_real(node.args[0]):
        lines.append(f"branch point of {_short(node)}")
    return lines


def _is_inside(node: sp.Expr, signs: Signs) -> bool:
    """Whether the argument is shown to be off the ends of the cuts."""
    inner = signs.range(node.args[0])
    if inner is None:
        return False
    one = signs.range(sp.S.One) or Range()
    if isinstance(node, sp.acosh):
        return (inner + -one).is_positive
    return (one + inner).is_positive and (one + -inner).is_positive


def _short(expression: sp.Expr) -> str:
    return abbreviated(expression, DEPTH)

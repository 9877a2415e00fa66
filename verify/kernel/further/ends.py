"""Elliptic functions and integrals at the ends 0 and 1 of their parameter, by their definitions."""

from __future__ import annotations

from collections.abc import Mapping

from ..axioms import FUNCTIONS
from ..field import Field, rule
from ..ring import Element

ENDS: Mapping[str, tuple[str, str]] = {
    "jacobi_sn": ("sin(z)", "tanh(z)"),
    "jacobi_cn": ("cos(z)", "sech(z)"),
    "jacobi_dn": ("1", "sech(z)"),
    "jacobi_epsilon": ("z", "tanh(z)"),
    "elliptic_k": ("pi/2", ""),
    "elliptic_e": ("pi/2", "1"),
}
"""What they are at m = 0 and m = 1; K has a pole there."""


@rule(*ENDS, first=True)
def at_end(field: Field, node: int) -> Element | None:
    """A function of a parameter whose image is 0 or 1."""
    name, *arguments = field.nodes.all[node]
    m = field.image(arguments[-1])
    if not (m.is_zero or (m - field.one).is_zero):
        return None
    text = ENDS[name][0 if m.is_zero else 1]
    return field.read(text, **FUNCTIONS[name].arguments(*arguments)) if text else None

"""Which formulas are evidently analytic, or without poles and jumps, on a whole domain."""

from __future__ import annotations

from .images import Images
from .signs import BELOW_ONE

UNBOUNDED = ("coth", "csch", "tan", "cot", "sec", "csc", "log", "sign")
"""Functions with poles or jumps at real arguments."""

CLEAN = ("number", "symbol", "I", "pi", "Add", "Mul", "poly", "exp", "elliptic_k", "elliptic_e")
"""Analytic functions, besides those of Jacobi."""


def is_clean(images: Images, node: int) -> bool:
    """Whether a formula is analytic on the whole domain but for isolated poles."""
    for inner in images.nodes.below([node]):
        name = images.nodes.all[inner][0]
        if name == "Pow":
            base, exponent = images.nodes.all[inner][1:]
            if exponent.q != 1 and not (images.signs.positive(base) and is_bounded(images, base)):
                return False
        elif name in BELOW_ONE:
            if not is_bounded(images, images.nodes.all[inner][-1]):
                return False
        elif name not in CLEAN and not name.startswith("jacobi_"):
            return False
    return True


def is_bounded(images: Images, node: int) -> bool:
    """Whether a formula, with the witnesses of its sign, has evidently no poles or jumps.

    Then it is positive at every point if it is shown to be; 1/(1 + 1/x**2) is 0 at 0.
    """
    todo, seen = [node], set()
    while todo:
        for inner in images.nodes.below([todo.pop()]):
            if inner in seen:
                continue
            seen.add(inner)
            name, *arguments = images.nodes.all[inner]
            if name == "Pow" and arguments[1] < 0 and 0 in images.signs.sign(arguments[0]):
                return False
            complex_jacobi = name.startswith("jacobi_") and not images.signs.is_real(inner)
            if complex_jacobi or name in (*UNBOUNDED, *BELOW_ONE):
                return False
            if inner in images.hints.signs:
                todo.append(images.hints.signs[inner])
    return True

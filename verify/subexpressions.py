"""Walks over SymPy trees that visit each distinct subexpression once.

A formula that repeats a long subexpression has few distinct subexpressions but a very large tree;
SymPy's own traversals walk the tree.
"""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

DEPTH = 4
"""Nesting depth to which an abbreviation shows a subexpression."""


def distinct_nodes(expression: sp.Expr) -> list[sp.Expr]:
    """Return the distinct subexpressions, outer ones first.

    >>> x = sp.Symbol("x")
    >>> distinct_nodes(sp.sin(x) + sp.sin(x) ** 2)
    [sin(x)**2 + sin(x), sin(x)**2, sin(x), x, 2]
    """
    return _walked(expression, lambda node: True)


def outer_nodes(expression: sp.Expr) -> list[sp.Expr]:
    """Return the `distinct_nodes` outside of function arguments and roots.

    >>> x = sp.Symbol("x")
    >>> outer_nodes(sp.sin(2 * x) + x**2)
    [x**2 + sin(2*x), x**2, x, 2, sin(2*x)]
    """
    return _walked(
        expression,
        lambda node: bool(node.is_Add or node.is_Mul or (node.is_Pow and node.exp.is_Integer)),
    )


def _walked(expression: sp.Expr, enters: Callable[[sp.Expr], bool]) -> list[sp.Expr]:
    """Return the subexpressions that are reached through nodes for which ``enters`` is true."""
    reached: dict[sp.Expr, None] = {}
    waiting = [expression]
    while waiting:
        node = waiting.pop()
        if node not in reached:
            reached[node] = None
            waiting += reversed(node.args) if enters(node) else ()
    return list(reached)


def rebuilt(
    expression: sp.Expr,
    build: Callable[[sp.Expr, list[sp.Expr]], sp.Expr],
    images: dict[sp.Expr, sp.Expr] | None = None,
) -> sp.Expr:
    """Fold ``build(node, images of its arguments)``, once per node; extend ``images``."""
    images = {} if images is None else images

    def image(node: sp.Expr) -> sp.Expr:
        if node not in images:
            images[node] = build(node, [image(argument) for argument in node.args])
        return images[node]

    return image(expression)


def replaced(expression: sp.Expr, target: sp.Expr, replacement: sp.Expr) -> sp.Expr:
    """Replace ``target`` throughout an expression; each subexpression is visited once."""

    def build(node: sp.Expr, arguments: list[sp.Expr]) -> sp.Expr:
        same = all(new is old for new, old in zip(arguments, node.args, strict=True))
        return node if same else node.func(*arguments)

    return rebuilt(expression, build, {target: replacement})


def abbreviated(expression: sp.Expr, depth: int = DEPTH) -> str:
    """Return an expression as text, with dots for parts deeper than ``depth``.

    >>> x = sp.Symbol("x")
    >>> abbreviated(sp.sin(1 + sp.cos(x**2 + 3)), depth=2)
    'sin(... + 1)'
    """
    return str(_shallow(expression, depth))


def _shallow(expression: sp.Expr, depth: int) -> sp.Expr:
    if not expression.args:
        return expression
    if depth == 0:
        return sp.Symbol("...")
    arguments = (_shallow(argument, depth - 1) for argument in expression.args)
    return expression.func(*arguments, evaluate=False)

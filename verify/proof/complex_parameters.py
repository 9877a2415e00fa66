"""Parameters that may be complex: values of them at which what was typed fails."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice, product

from .statement_problem import all_domains
from .typed_statement import Statement
from .typed_values import TypedValues

VALUES = ("2/3 + 5/7*I", "-3/5 + 4/9*I", "-7/8 - 3/4*I", "5/4*I", "11/7")
"""In every quarter of the plane, and on its axes."""

MOST = 25
"""Choices of values."""


def failing_values(statement: Statement) -> dict[str, str] | None:
    """Values of all symbols at which an equation fails; None if none was found."""
    if statement.trees is None:
        return None
    for chosen in _choices(statement.complexes):
        trees = statement.trees.with_values(chosen)
        failing = TypedValues(trees, all_domains(statement, *statement.equations)).failure()
        if failing is not None:
            return {k: str(v) for k, v in failing.items() if k not in chosen} | chosen
    return None


def _choices(names: Sequence[str]) -> Iterator[dict[str, str]]:
    for values in islice(product(VALUES, repeat=len(names)), MOST):
        yield dict(zip(names, values, strict=True))

"""Statements, and the texts of them as they were typed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import sympy as sp
from sympy.core.function import AppliedUndef

from .domains import Domain


@dataclass(frozen=True)
class StatementTexts:
    """What was typed, part by part; a certificate holds these texts and no others."""

    variables: tuple[str, ...]
    equations: tuple[str, ...]
    solutions: tuple[str, ...]
    parameters: tuple[str, ...] = ()
    domain: tuple[str, ...] = ()

    def with_values(self, values: Mapping[str, str]) -> StatementTexts:
        """The texts with parameters that stand for formulas in the place of any values.

        >>> texts = StatementTexts(("x",), ("u_x - b",), ("u = x",), ("b: b>0",))
        >>> texts.with_values({"b": "1"}).parameters
        ('b = 1',)
        """
        kept = (
            p
            for p in self.parameters
            if p.replace("=", ":").partition(":")[0].strip() not in values
        )
        made = (f"{name} = {text}" for name, text in values.items())
        return replace(self, parameters=(*made, *kept))


@dataclass(frozen=True)
class Statement:
    """Do the ``solutions`` make every one of the ``equations`` vanish on the ``domains``?

    ``equations`` are left-hand sides in the applied unknowns; ``solutions`` has each of these with
    its formula.  ``domains`` has every variable and parameter that is not all real numbers;
    ``divisors`` is what the texts divide by or take the logarithm of; ``wanted`` are parameters of
    which the values are asked for, rather than taken as any.  ``texts`` are what was typed.
    ``complexes`` are parameters that may have complex values; the symbols of all are real, and a
    proof is one for complex values only if the checker accepts it for them.  ``functions`` are the
    names of arbitrary functions.
    """

    name: str
    equations: tuple[sp.Expr, ...]
    solutions: Mapping[AppliedUndef, sp.Expr]
    domains: Mapping[sp.Symbol, Domain]
    divisors: tuple[sp.Expr, ...] = ()
    wanted: tuple[sp.Symbol, ...] = ()
    texts: StatementTexts | None = field(default=None, compare=False)
    complexes: tuple[str, ...] = ()
    functions: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[sp.Symbol, ...]:
        """The independent variables."""
        return tuple(next(iter(self.solutions)).args)

"""The terms of an equation as products of a field and its derivatives."""

from __future__ import annotations

from typing import Any, Protocol

import sympy as sp


class FieldEquation(Protocol):
    """What a check needs of an equation: its name, its variables and its residual."""

    @property
    def name(self) -> str:
        """The name, as ``focusing mKdV``."""

    @property
    def xi(self) -> sp.Symbol:
        """The space variable."""

    @property
    def tau(self) -> sp.Symbol:
        """The time variable."""

    def residual(self, U: sp.Expr) -> sp.Expr:
        """The left-hand side with ``U`` for the field; zero for a solution."""


def residual_terms(equation: FieldEquation) -> tuple[tuple[sp.Expr, ...], sp.Expr]:
    """The terms of the residual for an unspecified field, and that field.

    The field is an undefined function of ``equation.xi`` and ``equation.tau``; its derivatives
    stand unevaluated in the terms.
    """
    field = sp.Function("U")(equation.xi, equation.tau)
    return sp.Add.make_args(sp.expand(equation.residual(field))), field


def field_derivatives(terms: tuple[sp.Expr, ...], field: Any) -> tuple[sp.Expr, ...]:
    """The field and those of its derivatives that occur in ``terms``, in a fixed order."""
    found = {
        atom for term in terms for atom in term.atoms(sp.Derivative, type(field)) if atom.has(field)
    }
    return tuple(sorted(found, key=sp.default_sort_key))

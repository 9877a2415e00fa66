"""Places where a typed statement may not be smooth, found before SymPy cancels ``0/x``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import sympy as sp

from longwave.derive.algebra.formula_tree import (
    Call,
    FormulaTree,
    Name,
    Number,
    Power,
    Product,
    mapped,
    plain_text,
)

from .domain_signs import CORNER, DomainSigns, rough_places
from .domains import Domain, Domains
from .statement_problem import typed_domains
from .typed_hints import Typed, typed_nodes
from .typed_statement import Statement

DEPTH = 5
"""Nesting depth to which a printed line shows a formula."""


def typed_places(statement: Statement) -> tuple[str, ...]:
    """Return a line for each place where a formula may not be smooth; an integer zero is a place.

    >>> from longwave.verify.proof.statement_text import read_statement as read
    >>> typed_places(read("u_x - 1", "u = x + 0/x"))
    ('pole where x = 0',)
    >>> typed_places(read("u[n] - 1", "u = sign(2*n - 6)**2"))
    ('jump or corner at the site n = 3',)
    """
    domains = typed_domains(statement)
    signs = DomainSigns(domains)
    trees = statement.trees.changed(lambda formula: mapped(formula, _smooth))
    variables = {str(variable) for variable in statement.variables}
    lines = [
        line
        for equation in trees.equations
        for node in typed_nodes(replace(statement, trees=trees), equation)
        for line in _lines(node, signs, domains, variables)
    ]
    if names := ", ".join(statement.complexes):
        lines.append(f"poles and branch points where {names} is not real")
    return tuple(dict.fromkeys(lines))


def _smooth(node: FormulaTree) -> FormulaTree | None:
    """Rewrite an even power of a modulus, which has no corner, by the conjugate."""
    match node:
        case Power(parts=(Call(parts=(inner,), name="abs"), Number(value=power))) if not power % 2:
            inner = mapped(inner, _smooth)
            return Power((Product((inner, Call((inner,), "conjugate"))), Number(power / 2)))
    return None


def _lines(node: Typed, signs: DomainSigns, domains: Domains, variables: set[str]) -> Iterator[str]:
    for words, argument in rough_places(node.plain, signs):
        part = node.tree if argument is None else node.tree.inner()[argument]
        sites = _sites(node.plain.args[argument], domains) if words.endswith(ZERO) else None
        if argument is None or sites is None:
            part = _base(part) if words.endswith(ZERO) else part
            yield words.format(plain_text(_shallow(part, DEPTH)))
            continue
        for place in sites:
            at = "at the site" if place.partition(" ")[0] in variables else "at"
            yield words.removesuffix(ZERO).replace("where", f"{at} {place}")


DOTS = "..."
"""Replacement for a part of a formula that is nested too deeply."""

ZERO = " {} = 0"


def corner_line(argument: FormulaTree) -> str:
    """Return the line for abs or sign of a formula that may be 0."""
    return CORNER.format(plain_text(_shallow(_base(argument), DEPTH)))


def _base(formula: FormulaTree) -> FormulaTree:
    """Return the base of a positive power, which has the same zeros; else the formula."""
    match formula:
        case Power(parts=(base, Number(value=power))) if power > 0:
            return _base(base)
    return formula


def _sites(argument: sp.Expr, domains: Domains) -> list[str] | None:
    """Return the integer zeros of a polynomial in one integer symbol; None for anything else."""
    symbol = next(iter(argument.free_symbols), None)
    domain = domains.get(symbol, Domain())
    if argument.free_symbols != {symbol} or not argument.is_polynomial():
        return None
    polynomial = sp.Poly(argument, symbol)
    rational = all(c.is_Rational for c in polynomial.all_coeffs())
    if not (rational and domain.integer) or domain.symbols:
        return None
    whole = [root for root in sp.roots(polynomial.as_expr(), symbol) if root.is_Integer]
    return [f"{symbol} = {root}" for root in sorted(whole) if domain.contains(root, {})]


def _shallow(formula: FormulaTree, depth: int) -> FormulaTree:
    """Return the formula with dots for parts nested deeper than ``depth``."""
    if not formula.inner() or depth > 0:
        parts = tuple(_shallow(part, depth - 1) for part in formula.inner())
        return formula.made_of(parts) if parts else formula
    return Name(DOTS)

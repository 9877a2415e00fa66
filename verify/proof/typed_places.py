"""Places where a typed statement may not be smooth; SymPy would cancel ``0/x`` first."""

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
"""Levels of a formula that a line shows."""


def typed_places(statement: Statement) -> tuple[str, ...]:
    """Return one line for each place where the formulas or an equation may fail to be smooth.

    At a lattice's sites, smooth or not, the formula may have another value than elsewhere.

    >>> from longwave.verify.proof.statement_text import read_statement as read
    >>> typed_places(read("u_x - 1", "u = x + 0/x"))
    ('pole where x = 0',)
    >>> typed_places(read("u[n] - 1", "u = sign(2*n - 6)**2"))
    ('jump or corner at the site n = 3',)
    """
    domains = typed_domains(statement)
    signs = DomainSigns(domains)
    trees = statement.trees
    trees = replace(
        trees,
        equations=tuple(mapped(equation, _smooth) for equation in trees.equations),
        solutions={name: mapped(formula, _smooth) for name, formula in trees.solutions.items()},
        definitions={name: mapped(formula, _smooth) for name, formula in trees.definitions.items()},
    )
    variables = {str(variable) for variable in statement.variables}
    found = [
        line
        for equation in trees.equations
        for node in typed_nodes(replace(statement, trees=trees), equation)
        for line in _lines(node, signs, domains, variables)
    ]
    if names := ", ".join(statement.complexes):
        found.append(f"poles and branch points where {names} is not real")
    return tuple(dict.fromkeys(found))


def _smooth(node: FormulaTree) -> FormulaTree | None:
    """Return an even power of a modulus, which has no corner, without it."""
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
"""What stands for a part of a formula that lies too deep."""

ZERO = " {} = 0"


def corner_line(argument: FormulaTree) -> str:
    """Return the line on abs or sign of a formula that may be 0."""
    return CORNER.format(plain_text(_shallow(_base(argument), DEPTH)))


def _base(formula: FormulaTree) -> FormulaTree:
    """Return the part that is 0 where the formula is."""
    match formula:
        case Power(parts=(base, Number(value=power))) if power > 0:
            return _base(base)
    return formula


def _sites(argument: sp.Expr, domains: Domains) -> list[str] | None:
    """Return the integers at which a polynomial in one of them is 0; None for anything else."""
    symbols = argument.free_symbols
    if len(symbols) != 1 or not argument.is_polynomial():
        return None
    (symbol,) = symbols
    domain = domains.get(symbol, Domain())
    if not domain.integer or domain.symbols:
        return None
    roots = sp.Poly(argument, symbol)
    if not all(c.is_Rational for c in roots.all_coeffs()):
        return None
    whole = [root for root in sp.roots(roots.as_expr(), symbol) if root.is_Integer]
    return [f"{symbol} = {root}" for root in sorted(whole) if domain.contains(root, {})]


def _shallow(formula: FormulaTree, depth: int) -> FormulaTree:
    """Return the formula with dots for what lies deeper."""
    if not formula.inner() or depth > 0:
        parts = tuple(_shallow(part, depth - 1) for part in formula.inner())
        return formula.made_of(parts) if parts else formula
    return Name(DOTS)

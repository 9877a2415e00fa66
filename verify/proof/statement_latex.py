"""Statements in LaTeX."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy.core.function import AppliedUndef

from .domains import Domain
from .typed_statement import Statement


def statement_latex(statement: Statement) -> str:
    """The statement in LaTeX: equations, formulas, and the domains that are not all numbers."""
    domains = ", ".join(_domain_latex(symbol, d) for symbol, d in statement.domains.items())
    words = rf"{equations_latex(statement)} \quad\Leftarrow\quad {formulas_latex(statement)}"
    return words + (rf" \qquad ({domains})" if domains else "")


def scope_latex(statement: Statement) -> str:
    """For which values a statement is."""
    formulas = (*statement.equations, *statement.solutions.values())
    complexes = statement.complexes
    symbols = {s for formula in formulas for s in formula.free_symbols} | set(statement.variables)
    listed = sorted(symbols, key=str)
    names = ", ".join(sp.latex(symbol) for symbol in listed if str(symbol) not in complexes)
    domains = ", ".join(_domain_latex(symbol, d) for symbol, d in statement.domains.items())
    others = f" and complex ${', '.join(map(sp.latex, map(sp.Symbol, complexes)))}$"
    words = f"for all real ${names}$" + (others if complexes else "")
    return words + (f" with ${domains}$" if domains else "")


def equations_latex(statement: Statement) -> str:
    """The equations of a statement."""
    return r",\quad ".join(f"{_latex(equation)} = 0" for equation in statement.equations)


def formulas_latex(statement: Statement) -> str:
    """The unknowns with their formulas."""
    pairs = statement.solutions.items()
    return r",\quad ".join(f"{_latex(unknown)} = {_latex(f)}" for unknown, f in pairs)


def _latex(expression: sp.Expr) -> str:
    """An expression with jets as u_{xxt} and sites as q_{n+1}."""
    jets = {d: sp.Symbol(_jet_latex(d.expr, d.variables)) for d in expression.atoms(sp.Derivative)}
    plain = expression.xreplace(jets)
    sites = {f: sp.Symbol(_jet_latex(f, ())) for f in plain.atoms(AppliedUndef)}
    return sp.latex(plain.xreplace(sites))


def _jet_latex(unknown: sp.Expr, variables: Sequence[sp.Symbol]) -> str:
    if not isinstance(unknown, AppliedUndef):
        return rf"\left({_latex(unknown)}\right)_{{{''.join(map(str, variables))}}}"
    variables = sorted(variables, key=unknown.args.index)
    index = "".join(str(a).replace(" ", "") for a in unknown.args if a.is_integer)
    below = ", ".join(part for part in (index, "".join(map(str, variables))) if part)
    name = sp.latex(sp.Symbol(unknown.func.__name__))
    return f"{name}_{{{below}}}" if below else name


def _domain_latex(symbol: sp.Symbol, domain: Domain) -> str:
    name = sp.latex(symbol)
    chain = domain.chain(name, sp.latex, ("<", r"\le"))
    if chain != name:
        return chain
    return rf"{name} \ne 0" if domain.nonzero else name + r" \in \mathbb{Z}" * domain.integer

"""What a refuted statement may have meant: one change at a time, and the first that is proved.

Tried are modulus and parameter of elliptic functions exchanged, another speed, a sign or a factor 2
at a term of the formula, and at a term of the equation.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice

import sympy as sp

from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.solutions.functions.jacobi import JacobiFunction
from longwave.verify.subexpressions import distinct_nodes, replaced
from longwave.verify.verdict import Outcome

from .statement_verdict import StatementVerdict, decide_statement
from .typed_statement import Statement

VARIANTS = 150
"""Most variants that are tried."""

SHOWN = 60
"""Characters of a term in a hint."""

FACTORS = (sp.Integer(-1), sp.Integer(2), sp.S.Half)

SPEEDS = tuple(map(sp.Rational, ("4", "1/4", "3", "1/3", "3/2", "2/3", "6", "1/6")))
"""Factors of a speed beyond `FACTORS`."""


@dataclass(frozen=True)
class NearMiss:
    """A statement that differs from another by one change, in words."""

    words: str
    statement: Statement


def with_hint(statement: Statement, verdict: StatementVerdict) -> StatementVerdict:
    """The verdict; a refuted one with what holds instead, if it is found.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> wrong = read_statement("u_t + u_x", "u = exp(x + t)")
    >>> with_hint(wrong, decide_statement(wrong)).hint
    'it holds with -t in the place of t'
    """
    if verdict.outcome is not Outcome.REFUTED or statement.wanted:
        return verdict
    for miss in islice(near_misses(statement), VARIANTS):
        if decide_statement(miss.statement).outcome is Outcome.PROVED:
            return replace(verdict, hint=f"it holds with {miss.words}")
    return verdict


def near_misses(statement: Statement) -> Iterator[NearMiss]:
    """Statements with one change, each once; what is no longer a function of all variables apart.

    >>> from longwave.verify.proof.statement_text import read_statement
    >>> wrong = read_statement("u_x - 1", "u = jacobi_sn(x, m)")
    >>> next(near_misses(wrong)).words
    'm**2 in the place of m as the parameter of elliptic functions'
    """
    seen = {(statement.equations, tuple(statement.solutions.values()))}
    for miss in _changes(statement):
        key = (miss.statement.equations, tuple(miss.statement.solutions.values()))
        if key not in seen:
            seen.add(key)
            yield miss


def _changes(statement: Statement) -> Iterator[NearMiss]:
    plain, equations = replace(statement, texts=None, trees=None), statement.equations
    for unknown, formula in statement.solutions.items():
        variables = formula.free_symbols & set(statement.variables)
        changes = chain(_moduli(formula), _speeds(formula, statement), _coefficients(formula))
        for words, changed in changes:
            if variables <= changed.free_symbols:
                solutions = {**statement.solutions, unknown: changed}
                yield NearMiss(words, replace(plain, solutions=solutions))
    for place, equation in enumerate(equations):
        for words, changed in _terms(equation):
            others = (*equations[:place], changed, *equations[place + 1 :])
            yield NearMiss(f"{words} in the equation", replace(plain, equations=others))


Change = tuple[str, sp.Expr]


def _instead(new: sp.Expr, old: sp.Expr) -> str:
    return f"{_short(new)} in the place of {_short(old)}"


def _short(expression: sp.Expr) -> str:
    text = formula_as_text(expression)
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}..."


def _moduli(formula: sp.Expr) -> Iterator[Change]:
    """The parameters of all elliptic functions squared, or their roots taken."""
    kinds = (JacobiFunction, sp.elliptic_k, sp.elliptic_e)
    elliptic = [f for f in distinct_nodes(formula) if isinstance(f, kinds)]
    for old in dict.fromkeys(f.args[-1] for f in elliptic):
        if not old.free_symbols:
            continue
        root = old.base if old.is_Pow and old.exp == 2 else sp.sqrt(old)
        for new in (old**2, root):
            changed = formula
            for f in reversed(elliptic):
                if f.args[-1] == old:
                    changed = replaced(changed, f, f.func(*f.args[:-1], new))
            yield f"{_instead(new, old)} as the parameter of elliptic functions", changed


def _coefficients(formula: sp.Expr) -> Iterator[Change]:
    """The formula, its terms, its numeric factors and the arguments, times -1, 2 and 1/2."""
    for node in distinct_nodes(formula):
        if node.is_Add:
            for words, changed in _terms(node):
                yield words, replaced(formula, node, changed)
        elif node == formula or (node.is_Mul and node.args[0].is_Number):
            for factor in FACTORS:
                yield _instead(factor * node, node), replaced(formula, node, factor * node)
        elif node.is_Function and not node.args[0].is_Add:
            for factor in FACTORS:
                new = node.func(factor * node.args[0], *node.args[1:])
                yield _instead(factor * node.args[0], node.args[0]), replaced(formula, node, new)


def _terms(total: sp.Expr) -> Iterator[Change]:
    for factor in FACTORS:
        for term in sp.Add.make_args(total):
            yield _instead(factor * term, term), total - term + factor * term


def _speeds(formula: sp.Expr, statement: Statement) -> Iterator[Change]:
    """The terms with the time times other numbers, and times powers of the parameters."""
    times = [v for v in statement.variables if str(v) == "t"]
    if not times:
        return
    (t,) = times
    parameters = sorted(formula.free_symbols - set(statement.variables), key=str)
    factors = (*FACTORS, *SPEEDS, *(p**e for p in parameters for e in (1, -1, 2, -2)))
    nodes = distinct_nodes(formula)
    targets = [(node, node) for node in nodes if node.is_Mul and t in node.args]
    targets += [(t, node) for node in nodes if node.is_Add and t in node.args]
    for term, node in targets:
        for factor in factors:
            new = node - term + factor * term if node.is_Add else factor * term
            yield _instead(factor * term, term), replaced(formula, node, new)

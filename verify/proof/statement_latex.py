"""Write statements in LaTeX, from the trees of the typed texts."""

from __future__ import annotations

import re

from longwave.derive.algebra.formula_latex import formula_latex, name_latex
from longwave.derive.algebra.formula_tree import FormulaTree, Sum, Unknown, mapped

from .statement_scope import COMPARED, conditions, scope
from .typed_statement import Statement, StatementTrees, tree_of

KINDS = {
    "real": "",
    "integer": r"\in \mathbb{Z}",
    "complex": r"\in \mathbb{C}",
    "function": r"\colon \mathbb{R} \to \mathbb{R}",
}

SIGNS = {"<=": r"\le", ">=": r"\ge", "!=": r"\ne"}


def statement_latex(statement: Statement) -> str:
    """Return the statement in LaTeX: equations, formulas, and the restricted domains."""
    domains = ", ".join(conditions_latex(statement))
    words = rf"{equations_latex(statement)} \quad\Leftarrow\quad {formulas_latex(statement)}"
    return words + (rf" \qquad ({domains})" if domains else "")


def conditions_latex(statement: Statement) -> tuple[str, ...]:
    """Return the conditions on parameters and variables in LaTeX, none for a name that is real."""
    return tuple(filter(None, map(_condition, conditions(statement.texts))))


def scope_latex(statement: Statement) -> str:
    """Return the values for which a statement is made, in words and LaTeX formulas."""
    own = scope(statement)
    kinds = [f"{kind} ${', '.join(map(name_latex, names))}$" for kind, names in own.kinds.items()]
    words = f"for all {own.listed(kinds)}"
    domains = ", ".join(map(_condition, own.conditions))
    return words + (f" with ${domains}$" if domains else "")


def equations_latex(statement: Statement) -> str:
    """Return the equations of a statement in LaTeX."""
    trees = statement.trees
    pairs = zip(statement.texts.equations, trees.equations, strict=True)
    return r",\quad ".join(_equation(trees, text, left) for text, left in pairs)


def formulas_latex(statement: Statement) -> str:
    """Return the unknowns and their formulas in LaTeX, with defined names expanded."""
    trees = statement.trees
    heads = {node for left in trees.equations for node in left.nodes() if isinstance(node, Unknown)}
    sites = {head.name: head.site for head in heads}
    return r",\quad ".join(
        f"{formula_latex(Unknown(name, site=sites.get(name, '')))} = {_latex(trees, formula)}"
        for name, formula in trees.solutions.items()
    )


def _equation(trees: StatementTrees, text: str, left: FormulaTree) -> str:
    """Return an equation in LaTeX with both typed sides; its tree is left side minus right side."""
    if "=" in text and isinstance(left, Sum):
        first, second = left.parts
        return f"{_latex(trees, first)} = {_latex(trees, second.inner()[1])}"
    return f"{_latex(trees, left)} = 0"


def _latex(trees: StatementTrees, formula: FormulaTree) -> str:
    return formula_latex(mapped(formula, trees.meaning))


def _condition(text: str) -> str:
    """Return a chain of inequalities, or a name with its kind; "" for a real name."""
    name, _, kind = text.partition(": ")
    if kind:
        symbol = KINDS[kind]
        return symbol and f"{name_latex(name)} {symbol}"
    parts = re.split(f"({COMPARED})", text)
    sides = [formula_latex(tree_of(side)) for side in parts[::2]]
    signs = [SIGNS.get(sign, sign) for sign in parts[1::2]]
    return sides[0] + "".join(f" {s} {t}" for s, t in zip(signs, sides[1:], strict=True))

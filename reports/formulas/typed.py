"""Statements of the library, and sentences with formulas, in LaTeX that breaks into lines."""

from __future__ import annotations

import re

import sympy as sp

from longwave.derive.algebra.foreign_characters import GREEK
from longwave.derive.algebra.formula_latex import CONSTANTS, formula_latex, name_latex
from longwave.derive.algebra.formula_text import FormulaError, Parser, Vocabulary, tokens
from longwave.derive.algebra.formula_tree import Unknown
from longwave.reports.latex import escape
from longwave.verify.proof.statement_latex import SIGNS, conditions_latex
from longwave.verify.proof.text_names import FUNCTIONS
from longwave.verify.proof.typed_statement import Statement


def typed_text_latex(text: str) -> str:
    r"""Return the LaTeX of a formula's text. Raises FormulaError if it cannot be parsed.

    >>> print(typed_text_latex("3*c**2/(1 - c**2)*sech(c*x/2)**2"))
    \frac{3 c^{2} \operatorname{sech}^{2}\bigl(\frac{c x}{2}\bigr)}{1 - c^{2}}
    """
    fields = {letter: sp.Function(letter)(*sp.symbols("x y z t")) for letter in "uvw"}
    variables = dict(zip("xyzt", sp.symbols("x y z t"), strict=True))
    words = Vocabulary(FUNCTIONS, variables=variables, fields=fields, unknown_name=sp.Symbol)
    return formula_latex(Parser(text, tokens(text), words, "formula").whole(), breakable=True)


def statement_parts(statement: Statement) -> tuple[tuple[str, ...], ...]:
    """Return a statement's equations, each with "= 0", its solutions and its conditions, in LaTeX.

    The definitions of named parts follow the solutions.
    """
    trees = statement.trees
    equations = tuple(f"{formula_latex(tree, breakable=True)} = 0" for tree in trees.equations)
    nodes = (node for equation in trees.equations for node in equation.nodes())
    site = "_{n}" if any(isinstance(node, Unknown) and node.site for node in nodes) else ""
    named = [(name_latex(name) + site, tree) for name, tree in trees.solutions.items()]
    named += [(name_latex(name), tree) for name, tree in trees.definitions.items()]
    solutions = tuple(f"{name} = {formula_latex(f, breakable=True)}" for name, f in named)
    return equations, solutions, conditions_latex(statement)


_RELATION = re.compile(r"(<=|>=|!=|<|>|=)")

_WORD = re.compile(r"\S+")
_RAISED = re.compile(r"(\w+)\*\*(\w+)")


def prose_latex(text: str) -> str:
    r"""Return a sentence as LaTeX; the longest pieces that parse as formulas are set as formulas.

    >>> print(prose_latex("k**2 for 3*k**2 in the speed, a copy"))
    $k^{2}$ for $3 k^{2}$ in the speed, a copy
    """
    words = [(match.start(), match.end()) for match in _WORD.finditer(text)]
    latex, position, first = "", 0, 0
    while first < len(words):
        start = words[first][0]
        latex += escape(text[position:start])
        position, last = start, first
        for last in range(min(len(words) - 1, first + 12), first - 1, -1):
            piece = text[start : words[last][1]]
            formula_text = piece.rstrip(",.;:")
            formula = _formula_or_none(formula_text)
            if formula:
                latex += f"${formula}$" + piece[len(formula_text) :]
                break
        else:
            piece = text[start : words[first][1]]
            parts = _RAISED.split(piece)
            raised = [
                rf"$\mathrm{{{a}}}^{{{b}}}$" for a, b in zip(parts[1::3], parts[2::3], strict=True)
            ]
            parts[::3] = (part.replace("*", " ") for part in parts[::3])
            latex += "".join(escape(p) + r for p, r in zip(parts[::3], [*raised, ""], strict=True))
            last = first
        position, first = words[last][1], last + 1
    return latex + escape(text[position:])


_BESIDE = re.compile(r"(?<=[\w)])\s+(?=[\w(])")
"""Pattern of the blanks that stand for a product between two factors."""


MODULAR = ("sn", "cn", "dn")
"""Jacobi functions that a sentence calls sn, cn, dn instead of jacobi_sn and so on."""

_DERIVED = re.compile(r"\(([^()]*)\)_([xyzt])$")
"""Pattern of an expression in brackets with a derivative's subscript: (u^2)_x."""


def _formula_or_none(text: str) -> str | None:
    """Return the LaTeX of a piece of text that is a formula or relation, else None."""
    names = [name.partition("_")[0] for name in re.findall(r"[A-Za-z_]+", text)]
    symbols = [name for name in names if name not in FUNCTIONS]
    if text in ("a", "I", "A") or not (symbols or "/" in text or names):
        return None
    known = (*GREEK, *CONSTANTS, *MODULAR, "diff")
    if any(len(name) > 1 and name not in known for name in symbols):
        return None
    try:
        sides = _RELATION.split(_BESIDE.sub("*", _DERIVED.sub(r"diff(\1, \2)", text)))
        return " ".join(_side(side) for side in sides)
    except FormulaError:
        return None


def _side(text: str) -> str:
    """Return the LaTeX of one piece of a relation: its left or right side, or its sign."""
    return SIGNS.get(text) or (text if _RELATION.fullmatch(text) else typed_text_latex(text))

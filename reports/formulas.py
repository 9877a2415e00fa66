r"""Formulas on the page: SymPy expressions as LaTeX displays that fit the line.

A wide expression is shortened by naming what occurs often in it, then its widest factors; a wide
sum is broken at its terms.
"""

from collections import Counter
from collections.abc import Iterator
from functools import cache

import sympy as sp

LINE = 88
"""Widest display line, in characters of SymPy's two-dimensional text form."""

OFTEN = 3
"""A sum or square root that occurs this many times in a wide formula gets a name."""

SHORT = 6
"""Parts up to this width are left as they are."""

HUGE = 300
"""An expression of more nodes than this is wide; it is not printed to find out."""


def width(expression: sp.Expr) -> int:
    """Return how many characters wide the expression is when it is set in two dimensions.

    >>> x, y = sp.symbols("x y")
    >>> width(x / (x + y))
    5
    """
    text = sp.pretty(expression, use_unicode=True, wrap_line=False)
    return max(len(line) for line in text.splitlines())


def is_wide(expression: sp.Expr) -> bool:
    """Tell whether the expression needs more than one line."""
    return size(expression) > HUGE or width(expression) > LINE


@cache
def size(expression: sp.Expr) -> int:
    """Return the number of nodes of the expression's tree."""
    return 1 + sum(size(arg) for arg in expression.args)


class Formula:
    """A formula in rows: the expression first, then the parts of it that were given names.

    `rows` holds the expressions, `names` the symbols of all rows but the first. Putting the
    parts back into the first row restores the expression (`whole`).
    """

    def __init__(self, expression: sp.Expr) -> None:
        self.rows = [expression]
        self.names: list[sp.Symbol] = []
        if is_wide(expression):
            self._name_what_is_frequent()
            for place, row in enumerate(self.rows):
                self.rows[place] = self._shorten(row)

    def whole(self) -> sp.Expr:
        """Return the expression with all named parts put back."""
        parts = dict(zip(self.names, self.rows[1:], strict=True))
        expression = self.rows[0]
        while expression.free_symbols & set(parts):
            expression = expression.xreplace(parts)
        return expression

    def latex(self, left: str) -> str:
        r"""Return the display as an `align*` environment; `left` is the left-hand side's LaTeX.

        >>> x = sp.Symbol("x")
        >>> print(Formula(2 * x + 1).latex("U"))
        \begin{align*}
        U &= 2 x + 1
        \end{align*}
        """
        lefts = [left, *(sp.latex(name) for name in self.names)]
        lines = [line for pair in zip(lefts, self.rows, strict=True) for line in _lines(*pair)]
        return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}"

    def _name(self, part: sp.Expr) -> sp.Symbol:
        """Return the part's name; a part without one becomes a new row."""
        if part in self.rows[1:]:
            return self.names[self.rows.index(part, 1) - 1]
        self.names.append(sp.Symbol(f"A_{len(self.names) + 1}", real=True))
        self.rows.append(part)
        return self.names[-1]

    def _name_what_is_frequent(self) -> None:
        """Name sums and square roots that occur often, the widest first, in all rows."""
        for part in sorted(_frequent(self.rows[0]), key=size, reverse=True):
            if sum(_occurrences(row)[part] for row in self.rows) >= OFTEN:
                name = sp.Symbol(f"A_{len(self.names) + 1}", real=True)
                self.rows = [row.xreplace({part: name}) for row in self.rows]
                self.names.append(name)
                self.rows.append(part)

    def _shorten(self, expression: sp.Expr) -> sp.Expr:
        """Name factors, arguments and powers' bases of the expression until its lines can fit."""
        if not expression.args or not is_wide(expression):
            return expression
        short = expression.xreplace({arg: self._shorten(arg) for arg in expression.args})
        if short.is_Add:
            return short
        for part in sorted(_nameable(short), key=size, reverse=True):
            if not is_wide(short):
                break
            short = short.xreplace({part: self._name(part)})
        return short


def _frequent(expression: sp.Expr) -> list[sp.Expr]:
    """Return the sums and square roots of sums that occur often in the expression."""
    counted = _occurrences(expression).items()
    return [part for part, times in counted if times >= OFTEN and not _is_short(part)]


def _is_short(expression: sp.Expr) -> bool:
    """Tell whether a name would save nothing."""
    return size(expression) <= HUGE and width(expression) <= SHORT


@cache
def _occurrences(expression: sp.Expr) -> Counter[sp.Expr]:
    """Count the sums and square roots in the expression that depend on something."""
    found: Counter[sp.Expr] = Counter()
    for arg in expression.args:
        found.update(_occurrences(arg))
    root = expression.is_Pow and expression.exp == sp.Rational(1, 2)
    if expression.free_symbols and (expression.is_Add or root):
        found[expression] += 1
    return found


def _nameable(expression: sp.Expr) -> Iterator[sp.Expr]:
    """Yield the parts of a product, power or function that deserve a name."""
    for arg in expression.args:
        base = arg.base if arg.is_Pow else arg
        if base.args and not base.is_number:
            yield base


def _lines(left: str, expression: sp.Expr) -> Iterator[str]:
    """Yield the lines of `left = expression`, a wide sum broken at its terms."""
    first, *rest = broken(expression)
    yield f"{left} &= {first}"
    for line in rest:
        yield rf"&\quad {line}"


def broken(expression: sp.Expr) -> list[str]:
    """Return the expression's LaTeX in lines, a sum being broken before a term's sign."""
    if not expression.is_Add or not is_wide(expression):
        return [sp.latex(expression)]
    lines: list[list[sp.Expr]] = [[]]
    room = LINE
    for term in expression.as_ordered_terms():
        room -= width(term) + 3
        if room < 0 and lines[-1]:
            lines.append([])
            room = LINE - width(term) - 3
        lines[-1].append(term)
    first, *rest = [_sum_latex(terms) for terms in lines]
    return [first, *(line if line.startswith("-") else f"+ {line}" for line in rest)]


def _sum_latex(terms: list[sp.Expr]) -> str:
    """Return the LaTeX of the terms, in the order given."""
    texts = [sp.latex(term) for term in terms]
    tail = (text if text.startswith("-") else f"+ {text}" for text in texts[1:])
    return " ".join([texts[0], *tail])

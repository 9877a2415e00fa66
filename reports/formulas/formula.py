r"""Formulas on the page: SymPy expressions as LaTeX displays that fit the line.

What functions take as arguments is named first (phases $\phi$, exponents $\eta$), then the
complementary modulus and the elliptic functions of a common phase. Of what is still too wide, the
repeated parts are named, then the fraction's numerator $N$ and denominator $D$. Every row is
written out of nested fractions, as a product where that is shorter, and broken at its terms.
"""

from collections import Counter
from collections.abc import Iterator
from functools import cached_property

import sympy as sp

from reports.formulas.latex import joined, latex, sum_latex
from reports.formulas.naming import Naming
from reports.formulas.order import FUNCTION_ORDER, ordered_terms
from reports.formulas.tidy import LINE, is_wide, tidied, width
from solutions.functions.jacobi import JacobiFunction

STATED = 45.0
"""Widest phase that is stated in the sentence behind the display."""

MARK = "MARK"


class Formula:
    """A formula in rows: the expression first, then the parts of it that were given names.

    `stated` holds the parts by their names; putting them back into its first row restores the
    expression. What is printed is `tidied` row by row, the same rational function of the names
    and functions in it.
    """

    def __init__(self, expression: sp.Expr) -> None:
        self.stated = Naming(expression)

    def latex(self, left: str) -> str:
        r"""Return the display and, if parts are short, a sentence; `left` is the left-hand side.

        >>> x = sp.Symbol("x")
        >>> print(Formula(2 * x + 1).latex("U"))
        \begin{align*}
        U &= 1 + 2 x
        \end{align*}
        """
        rows = [(left, self.printed_first)]
        short, functions = [], []
        for name, (letter, shown) in self.printed_parts.items():
            part = self.stated.parts[name]
            if isinstance(part, JacobiFunction):
                functions.append((letter, shown))
            elif name.name not in "NDP" and width(part) < STATED:
                short.append(f"${latex(letter)} = {latex(shown)}$")
            else:
                rows.append((latex(letter), shown))
        lines = [line for row in rows for line in _lines(*row)]
        clauses = [", ".join(short), *_functions_stated(functions)]
        where = "; ".join(filter(None, clauses))
        return joined(lines) + (f"\nwhere {where}." if where else "")

    @property
    def printed_first(self) -> sp.Expr:
        """What is printed for the expression."""
        return tidied(self.stated.first).xreplace(self.letters)

    @property
    def printed_parts(self) -> dict[sp.Dummy, tuple[sp.Dummy, sp.Expr]]:
        """Return for each part its printed name and what is printed for it, in reading order."""
        return {
            name: (self.letters[name], tidied(part).xreplace(self.letters))
            for name, part in self._in_reading_order()
        }

    @cached_property
    def letters(self) -> dict[sp.Dummy, sp.Dummy]:
        """The names as printed: numbered where a letter stands for several parts.

        A letter that the expression has as a symbol gets a hat.
        """
        order = [name for name, _ in self._in_reading_order()]
        counts = Counter(name.name for name in order)
        taken = {symbol.name for symbol in self.stated.whole().free_symbols}
        seen: Counter[str] = Counter()
        letters = {}
        for name in order:
            letter = name.name
            seen[letter] += 1
            index = f"_{seen[letter]}" if counts[letter] > 1 else ""
            hat = rf"\hat{{{letter}}}" if letter + index in taken else letter
            letters[name] = sp.Dummy(hat + index)
        return letters

    def _in_reading_order(self) -> Iterator[tuple[sp.Dummy, sp.Expr]]:
        """Yield the parts in the order in which a reader meets their names."""
        met: list[sp.Dummy] = []
        rows = [self.stated.first]
        while rows:
            row = rows.pop(0)
            found = [name for name in self.stated.parts if name not in met and row.has(name)]
            found.sort(key=lambda name: _place(name, row))
            met += found
            rows += [self.stated.parts[name] for name in found]
        yield from ((name, self.stated.parts[name]) for name in met)


def _functions_stated(functions: list[tuple[sp.Dummy, sp.Expr]]) -> list[str]:
    """Return which functions are taken at which argument."""
    arguments = dict.fromkeys(function.args[0] for _, function in functions)
    ordered = sorted(functions, key=lambda pair: FUNCTION_ORDER.index(pair[0].name))
    return [
        ", ".join(f"${latex(name)}$" for name, function in ordered if function.args[0] == argument)
        + f" are taken at $({latex(argument)};k)$"
        for argument in arguments
    ]


def _place(name: sp.Dummy, row: sp.Expr) -> int:
    """Return where the name stands in the printed row."""
    marked = latex(tidied(row).xreplace({name: sp.Dummy(MARK)}))
    return marked.index(MARK)


def _lines(left: str, expression: sp.Expr) -> Iterator[str]:
    """Yield the lines of `left = expression`, a wide sum broken at its terms."""
    first, *rest = broken(expression)
    yield f"{left} &= {first}"
    for line in rest:
        yield rf"&\quad {line}"


def broken(expression: sp.Expr) -> list[str]:
    """Return the expression's LaTeX in lines, a sum being broken before a term's sign."""
    if not expression.is_Add or not is_wide(expression):
        return [latex(expression)]
    lines: list[list[sp.Expr]] = [[]]
    room = LINE
    for term in ordered_terms(expression):
        room -= width(term) + 2
        if room < 0 and lines[-1]:
            lines.append([])
            room = LINE - width(term) - 2
        lines[-1].append(term)
    first, *rest = [sum_latex(terms) for terms in lines]
    return [first, *(line if line.startswith("-") else f"+ {line}" for line in rest)]

"""Names for the parts of a formula: arguments, the modulus, repeated parts, what is too wide."""

from collections import Counter

import sympy as sp

from reports.formulas.latex import latex
from reports.formulas.measure import nesting
from reports.formulas.order import function_name, is_phase
from reports.formulas.parts import (
    OFTEN,
    atoms,
    based,
    divided,
    is_worth_a_name,
    occurrences,
    product_roots,
    shared_arguments,
    sums,
    uses,
    with_phase,
)
from reports.formulas.tidy import is_wide, size, tidied
from solutions.functions.jacobi import JacobiFunction
from solutions.symbols import complementary_modulus, k

HEAVY = 55.0
"""A formula with a row wider than this has its repeated parts named."""

COMPANION = 25.0
"""A denominator wider than this is named where the numerator is, and the other way about."""

EXPONENTIALS = (sp.exp, sp.sinh, sp.cosh, sp.tanh, sp.sech)

ARGUMENTS = {"phi": (JacobiFunction, sp.sin, sp.cos), "eta": EXPONENTIALS}
"""The letters of the arguments of functions."""


class Naming:
    """An expression in which parts have names: `first`, and `parts` by their names.

    The names are dummies, called after the letter of their kind: phi and eta for what functions
    take as arguments, k' for the complementary modulus, N and D for a numerator and denominator,
    z for a phase that is repeated, P for any other part, and the elliptic functions' own.
    """

    def __init__(self, expression: sp.Expr) -> None:
        self.first = expression
        self.parts: dict[sp.Dummy, sp.Expr] = {}
        if is_wide(expression) or shared_arguments(expression):
            self._name_modulus()
            self._name_arguments()
        if any(is_wide(row, HEAVY) or is_wide(tidied(row)) for row in self.rows):
            self._name_functions()
            self._name_what_is_repeated()
            self._name_common_factors()
            self._name_what_is_wide()
            self._inline()

    @property
    def rows(self) -> list[sp.Expr]:
        """The expression and the named parts."""
        return [self.first, *self.parts.values()]

    def whole(self) -> sp.Expr:
        """Return the expression with all named parts put back."""
        expression = self.first
        while expression.free_symbols & set(self.parts):
            expression = expression.xreplace(self.parts)
        return expression

    def _substitute(self, changes: dict[sp.Expr, sp.Expr]) -> None:
        self.first = self.first.xreplace(changes)
        self.parts = {name: part.xreplace(changes) for name, part in self.parts.items()}

    def _name(self, part: sp.Expr, letter: str) -> sp.Dummy:
        """Return the part's name in that letter; a part without one becomes a new row."""
        for name, known in self.parts.items():
            if known == part:
                return name
        name = sp.Dummy(letter, real=True)
        self.parts[name] = part
        return name

    def _name_modulus(self) -> None:
        """Put k' for the square root of 1 - k**2, and its powers for those of 1 - k**2."""
        if not self.first.has(complementary_modulus):
            return
        name = sp.Dummy("k'", positive=True)
        bare = 1 - k**2
        powers = [node for node in self.first.atoms(sp.Pow) if node.base == bare]
        self._substitute({node: name ** (2 * node.exp) for node in powers} | {bare: name**2})
        self.parts[name] = complementary_modulus

    def _name_arguments(self) -> None:
        """Name what functions take as arguments, up to sign and a constant shift."""
        for letter, kinds in ARGUMENTS.items():
            changes: dict[sp.Expr, sp.Expr] = {}
            bases: list[sp.Expr] = []
            for node in sorted(atoms(self.first, *kinds), key=lambda node: size(node.args[0])):
                base, change = based(node, bases)
                if base.args:
                    bases += [] if base in bases else [base]
                    changes[node] = change(self._name(base, letter))
            self.first = self.first.xreplace(changes)
            for base in filter(is_phase, bases):
                self._name_phase_in_sums(base, self._name(base, letter))

    def _name_phase_in_sums(self, phase: sp.Expr, name: sp.Dummy) -> None:
        """Put the name for number multiples of the phase that are parts of sums."""
        while changes := {
            total: changed
            for total in self.first.atoms(sp.Add)
            if (changed := with_phase(total, phase, name)) is not None
        }:
            self.first = self.first.xreplace(changes)

    def _name_functions(self) -> None:
        """Name the elliptic functions of which each kind has one argument."""
        nodes = list(
            dict.fromkeys(node for row in self.rows for node in atoms(row, JacobiFunction))
        )
        kinds = Counter(node.func for node in nodes)
        names = {
            node: sp.Dummy(function_name(node), real=True)
            for node in nodes
            if kinds[node.func] == 1
        }
        self._substitute(names)
        self.parts |= {name: node for node, name in names.items()}

    def _name_what_is_repeated(self) -> None:
        """Name the sums and roots that occur often, the widest first, in all rows."""
        while True:
            counted: Counter[sp.Expr] = Counter()
            for row in self.rows:
                counted.update(occurrences(row))
                counted[row] -= 1
            often = [part for part, times in counted.items() if times >= OFTEN]
            part = max(filter(is_worth_a_name, often), key=size, default=None)
            if part is None:
                return
            name = sp.Dummy("z" if is_phase(part) else "P", real=True)
            self._substitute({part: name})
            self.parts[name] = part

    def _name_common_factors(self) -> None:
        """Name products of sums that occur as a power and as factors of other products."""
        for product in dict.fromkeys(root for row in self.rows for root in product_roots(row)):
            name = sp.Dummy("P", real=True)
            changes = {
                node: changed
                for row in self.rows
                for node in atoms(row, sp.Mul)
                if (changed := divided(node, product, name)) is not None
            }
            if len(changes) >= OFTEN:
                self._substitute(changes)
                self.parts[name] = product

    def _name_what_is_wide(self) -> None:
        """Name wide numerators, denominators and factors until every term fits the line."""
        self.first = self._shorten(self.first)
        done: set[sp.Dummy] = set()
        while rest := [name for name in self.parts if name not in done]:
            for name in rest:
                self.parts[name] = self._shorten(self.parts[name])
                done.add(name)

    def _shorten(self, expression: sp.Expr) -> sp.Expr:
        terms = sp.Add.make_args(expression)
        if not any(is_wide(tidied(term), HEAVY) for term in terms):
            return expression
        return sp.Add(*(self._shortened_term(term) for term in terms))

    def _shortened_term(self, term: sp.Expr) -> sp.Expr:
        """Name the term's sums, the widest first, until it fits; N and D in a fraction."""
        below = sp.fraction(term, exact=True)[1]
        for part in sorted(sums(term), key=size, reverse=True):
            whole_fraction = below != 1 and is_wide(part, COMPANION) and term.atoms(sp.Dummy)
            if is_wide(tidied(term), HEAVY) or whole_fraction:
                letter = "D" if below.has(part) else "N" if below != 1 else "P"
                term = term.xreplace({part: self._name(part, letter)})
        return term

    def _inline(self) -> None:
        """Put back what is used once and leaves its row on one line."""
        for name in [name for name in self.parts if name.name == "P"]:
            users = [row for row in self.rows if row.has(name)]
            if len(users) == 1 and uses(users[0], name) == 1:
                changed = users[0].xreplace({name: self.parts[name]})
                if not is_wide(tidied(changed)) and nesting(latex(tidied(changed))) < 2:
                    part = self.parts.pop(name)
                    self._substitute({name: part})

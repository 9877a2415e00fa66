r"""SymPy expressions as LaTeX displays that fit the line.

Arguments of functions are named first (phases $\phi$, exponents $\eta$), then the complementary
modulus and the elliptic functions of a common phase. If that is still too wide, repeated parts are
named, then the fraction's numerator $N$ and denominator $D$. Every row is written without nested
fractions, as a product if that is shorter, and broken at its terms.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache, cached_property

import sympy as sp

from longwave.derive.algebra.latex_width import nesting
from longwave.reports.formulas.printing import (
    FUNCTION_ORDER,
    LINE,
    function_name,
    is_phase,
    is_wide,
    joined,
    latex,
    ordered_terms,
    runs_left,
    size,
    sum_latex,
    tidied,
    width,
)
from longwave.solutions.functions.jacobi import JacobiFunction
from longwave.solutions.symbols import complementary_modulus, k, xi

HEAVY = 55.0
"""Row width, in characters, above which repeated parts of a formula get names."""

COMPANION = 25.0
"""Width above which a denominator gets a name if the numerator has one, and vice versa."""

STATED = 45.0
"""Width up to which a phase is defined in the sentence after the display, not in a row."""

MARK = "MARK"

EXPONENTIALS = (sp.exp, sp.sinh, sp.cosh, sp.tanh, sp.sech)

ARGUMENTS = {"phi": (JacobiFunction, sp.sin, sp.cos), "eta": EXPONENTIALS}
"""Letter for a named argument -> the functions whose arguments it names."""

OFTEN = 2
"""Least number of occurrences for which a part of a wide formula gets a name."""

WORTH = 10.0
"""Least width, in characters, of a repeated part that gets a name."""


class Naming:
    """An expression with named parts: `first` is the whole, `parts` maps names to parts.

    The names are dummies, called by the letter of their kind: phi and eta for arguments of
    functions, k' for the complementary modulus, N and D for a numerator and denominator, z for a
    repeated phase, P for any other part; elliptic functions keep their own names.
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
        """The expression, followed by the named parts."""
        return [self.first, *self.parts.values()]

    def whole(self) -> sp.Expr:
        """Return the expression with all names replaced by their parts."""
        expression = self.first
        while expression.free_symbols & set(self.parts):
            expression = expression.xreplace(self.parts)
        return expression

    def _substitute(self, changes: dict[sp.Expr, sp.Expr]) -> None:
        self.first = self.first.xreplace(changes)
        self.parts = {name: part.xreplace(changes) for name, part in self.parts.items()}

    def _name(self, part: sp.Expr, letter: str) -> sp.Dummy:
        """Return the name of a part, with that letter; a part without a name becomes a new row."""
        for name, known in self.parts.items():
            if known == part:
                return name
        name = sp.Dummy(letter, real=True)
        self.parts[name] = part
        return name

    def _name_modulus(self) -> None:
        """Write powers of 1 - k**2 as powers of k', the name of the square root of 1 - k**2."""
        if not self.first.has(complementary_modulus):
            return
        name = sp.Dummy("k'", positive=True)
        bare = 1 - k**2
        powers = [node for node in self.first.atoms(sp.Pow) if node.base == bare]
        self._substitute({node: name ** (2 * node.exp) for node in powers} | {bare: name**2})
        self.parts[name] = complementary_modulus

    def _name_arguments(self) -> None:
        """Name the arguments of functions, up to sign and a constant shift."""
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
        """Replace numerical multiples of a phase within sums by multiples of its name."""
        while changes := {
            total: changed
            for total in self.first.atoms(sp.Add)
            if (changed := with_phase(total, phase, name)) is not None
        }:
            self.first = self.first.xreplace(changes)

    def _name_functions(self) -> None:
        """Replace each elliptic function that always has the same argument by its name, as sn."""
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
        """Name sums and roots that occur at least `OFTEN` times in all rows, the largest first."""
        while True:
            counted: Counter[sp.Expr] = Counter()
            for row in self.rows:
                counted.update(occurrences(row))
                counted[row] -= 1
            repeated = (part for part, count in counted.items() if count >= OFTEN)
            wide_enough = (part for part in repeated if is_wide(part, WORTH) or is_phase(part))
            part = max(wide_enough, key=size, default=None)
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
        finished: set[sp.Dummy] = set()
        while rest := [name for name in self.parts if name not in finished]:
            for name in rest:
                self.parts[name] = self._shorten(self.parts[name])
                finished.add(name)

    def _shorten(self, expression: sp.Expr) -> sp.Expr:
        terms = sp.Add.make_args(expression)
        if not any(is_wide(tidied(term), HEAVY) for term in terms):
            return expression
        return sp.Add(*(self._shortened_term(term) for term in terms))

    def _shortened_term(self, term: sp.Expr) -> sp.Expr:
        """Name the term's sums, the widest first, until it fits a line: N and D in a fraction."""
        denominator = sp.fraction(term, exact=True)[1]
        for part in sorted(sums(term), key=size, reverse=True):
            whole_fraction = denominator != 1 and is_wide(part, COMPANION) and term.atoms(sp.Dummy)
            if is_wide(tidied(term), HEAVY) or whole_fraction:
                letter = "D" if denominator.has(part) else "N" if denominator != 1 else "P"
                term = term.xreplace({part: self._name(part, letter)})
        return term

    def _inline(self) -> None:
        """Remove names that occur once if the row with the part written out still fits one line."""
        for name in [name for name in self.parts if name.name == "P"]:
            users = [row for row in self.rows if row.has(name)]
            if len(users) == 1 and list(sp.preorder_traversal(users[0])).count(name) == 1:
                changed = users[0].xreplace({name: self.parts[name]})
                if not is_wide(tidied(changed)) and nesting(latex(tidied(changed))) < 2:
                    part = self.parts.pop(name)
                    self._substitute({name: part})


def shared_arguments(expression: sp.Expr) -> bool:
    """Return whether several functions have the same argument, which is more than a symbol."""
    counted = Counter(
        node.args[0] for node in expression.atoms(sp.Function, sp.exp) if not node.args[0].is_Atom
    )
    return any(count >= OFTEN for count in counted.values())


Change = Callable[[sp.Dummy], sp.Expr]
"""A callable that takes the name of a function's argument and returns the function of it."""


def based(node: sp.Expr, bases: Iterable[sp.Expr]) -> tuple[sp.Expr, Change]:
    """Return the part to name in a function's argument, and a callable: name -> the function of it.

    The argument of ``node``, the function, is a multiple of that part plus a constant. One of
    ``bases`` is taken as the part if possible.
    """
    argument, *rest = node.args
    shifts = ((base, sign, argument - sign * base) for base in bases for sign in (1, -1))
    number, factor = argument.as_coeff_Mul()
    if runs_left(factor):
        number, factor = -number, -factor
    unshifted = factor, number, sp.S.Zero
    base, number, shift = next(
        (shift_option for shift_option in shifts if not shift_option[2].has(xi)), unshifted
    )
    return base, lambda name: node.func(number * name + shift, *rest)


def atoms(expression: sp.Expr, *kinds: type[sp.Expr]) -> list[sp.Expr]:
    """Return the parts of the expression whose types are in ``kinds``, in a reproducible order."""
    return sorted(expression.atoms(*kinds), key=sp.default_sort_key)


def with_phase(total: sp.Expr, phase: sp.Expr, name: sp.Dummy) -> sp.Expr | None:
    """Return the sum with a multiple of the phase replaced by its name; None if it has none."""
    number = total.coeff(xi)
    scaled = {number * term for term in sp.Add.make_args(phase)}
    if not number or not number.is_number or not scaled <= set(total.args):
        return None
    return sp.Add(number * name, *(term for term in total.args if term not in scaled))


@cache
def occurrences(expression: sp.Expr) -> Counter[sp.Expr]:
    """Count the sums and square roots in the expression that contain symbols."""
    counts: Counter[sp.Expr] = Counter()
    for arg in expression.args:
        counts.update(occurrences(arg))
    root = expression.is_Pow and expression.exp == sp.Rational(1, 2)
    if expression.free_symbols and (expression.is_Add or root):
        counts[expression] += 1
    return counts


def sums(term: sp.Expr) -> list[sp.Expr]:
    """Return the sums that are factors of the term, or bases of powers that are factors."""
    bases = (factor.base if factor.is_Pow else factor for factor in sp.Mul.make_args(term))
    return [base for base in bases if base.is_Add]


def product_roots(row: sp.Expr) -> Iterator[sp.Expr]:
    """Yield the products of at least two sums of which a power occurs in the row."""
    for node in atoms(row, sp.Mul):
        powers = node.as_coeff_Mul()[1].as_powers_dict()
        exponents = set(powers.values())
        named = [base for base in powers if base.is_Add or isinstance(base, sp.Dummy)]
        sums = any(base.is_Add for base in named)
        if len(exponents) == 1 and min(exponents) > 1 and sums and len(named) >= OFTEN:
            yield sp.Mul(*powers)


def divided(node: sp.Expr, product: sp.Expr, name: sp.Dummy) -> sp.Expr | None:
    """Return the node with its factor product**p replaced by name**p; None if it has none."""
    powers = node.as_powers_dict()
    exponents = {powers.get(base, sp.S.Zero) for base in sp.Mul.make_args(product)}
    if len(exponents) != 1 or not (power := exponents.pop()).is_positive:
        return None
    return node / product**power * name**power


class Formula:
    """A formula in rows: the expression first, then its named parts.

    `stated` is the `Naming`; substituting its parts into its first row restores the expression.
    Each row is printed in an equal form, which `tidied` returns.
    """

    def __init__(self, expression: sp.Expr) -> None:
        self.stated = Naming(expression)

    def latex(self, left: str) -> str:
        r"""Return the display and a sentence that defines short parts; `left` is the left side.

        >>> x = sp.Symbol("x")
        >>> print(Formula(2 * x + 1).latex("U"))
        \begin{align*}
        U &= 1 + 2 x
        \end{align*}
        """
        rows = [(left, self.printed_first)]
        short, functions = [], []
        for name, (letter, expression) in self.printed_parts.items():
            part = self.stated.parts[name]
            if isinstance(part, JacobiFunction):
                functions.append((letter, expression))
            elif name.name not in "NDP" and width(part) < STATED:
                short.append(f"${latex(letter)} = {latex(expression)}$")
            else:
                rows.append((latex(letter), expression))
        lines = [line for row in rows for line in _lines(*row)]
        clauses = [", ".join(short), *_functions_stated(functions)]
        where = "; ".join(filter(None, clauses))
        return joined(lines) + (f"\nwhere {where}." if where else "")

    @property
    def printed_first(self) -> sp.Expr:
        """The expression as it is printed, with its named parts as letters."""
        return tidied(self.stated.first).xreplace(self.letters)

    @property
    def printed_parts(self) -> dict[sp.Dummy, tuple[sp.Dummy, sp.Expr]]:
        """Return name -> (printed letter, printed expression) of each part, in reading order."""
        return {
            name: (self.letters[name], tidied(part).xreplace(self.letters))
            for name, part in self._in_reading_order()
        }

    @cached_property
    def letters(self) -> dict[sp.Dummy, sp.Dummy]:
        """Printed letters of the names, numbered if a letter names several parts.

        A letter that is also a symbol of the expression gets a hat.
        """
        order = [name for name, _ in self._in_reading_order()]
        counts = Counter(name.name for name in order)
        taken = {symbol.name for symbol in self.stated.whole().free_symbols}
        used: Counter[str] = Counter()
        letters = {}
        for name in order:
            letter = name.name
            used[letter] += 1
            index = f"_{used[letter]}" if counts[letter] > 1 else ""
            hat = rf"\hat{{{letter}}}" if letter + index in taken else letter
            letters[name] = sp.Dummy(hat + index)
        return letters

    def _in_reading_order(self) -> Iterator[tuple[sp.Dummy, sp.Expr]]:
        """Yield names and parts in the order in which a reader meets the names."""
        ordered: list[sp.Dummy] = []
        rows = [self.stated.first]
        while rows:
            row = rows.pop(0)
            new_names = [
                name for name in self.stated.parts if name not in ordered and row.has(name)
            ]
            new_names.sort(key=lambda name: _place(name, row))
            ordered += new_names
            rows += [self.stated.parts[name] for name in new_names]
        yield from ((name, self.stated.parts[name]) for name in ordered)


def _functions_stated(functions: list[tuple[sp.Dummy, sp.Expr]]) -> list[str]:
    """Return one LaTeX clause for each argument: "sn, cn are taken at (argument; k)"."""
    arguments = dict.fromkeys(function.args[0] for _, function in functions)
    ordered = sorted(functions, key=lambda pair: FUNCTION_ORDER.index(pair[0].name))
    return [
        ", ".join(f"${latex(name)}$" for name, function in ordered if function.args[0] == argument)
        + f" are taken at $({latex(argument)};k)$"
        for argument in arguments
    ]


def _place(name: sp.Dummy, row: sp.Expr) -> int:
    """Return the character position at which the name first occurs in the row's LaTeX."""
    marked = latex(tidied(row).xreplace({name: sp.Dummy(MARK)}))
    return marked.index(MARK)


def _lines(left: str, expression: sp.Expr) -> Iterator[str]:
    """Yield the lines of `left = expression`; a wide sum is broken at its terms."""
    first, *rest = broken(expression)
    yield f"{left} &= {first}"
    for line in rest:
        yield rf"&\quad {line}"


def broken(expression: sp.Expr) -> list[str]:
    """Return the expression's LaTeX in lines; a sum is broken before the sign of a term."""
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

"""Formulas as trees: read from text, written as text, differentiated, changed.

The grammar is that of statements in text, read once more: a mistake of the prover's own reader is
not repeated here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction

_WORD = re.compile(r"\s*(?:(\d+(?:\.\d+)?)|([A-Za-z][A-Za-z0-9_]*)|(\*\*|[-+*/()\[\],]))")

DERIVED = "xyzt"
"""The variables that a derivative may be by."""


@dataclass(frozen=True, slots=True)
class Tree:
    """A formula: what stands at its top, and below.

    ``head`` is ``number`` (``value`` a Fraction), ``name`` (its text), ``jet`` (an unknown with
    the letters of its derivatives and the shift of its site, or None), ``+``, ``*``, ``**``,
    ``diff`` (``value`` its letters) or the name of a function.
    """

    head: str
    args: tuple[Tree, ...] = ()
    value: Fraction | str | tuple[str, str, int | None] | None = None

    def __add__(self, other: Tree | int) -> Tree:
        return Tree("+", (self, as_tree(other)))

    def __mul__(self, other: Tree | int) -> Tree:
        return Tree("*", (self, as_tree(other)))

    def __pow__(self, exponent: Tree | int) -> Tree:
        return Tree("**", (self, as_tree(exponent)))

    def __neg__(self) -> Tree:
        return as_tree(-1) * self

    def __sub__(self, other: Tree | int) -> Tree:
        return self + -as_tree(other)

    def __truediv__(self, other: Tree | int) -> Tree:
        return self * as_tree(other) ** -1

    def __str__(self) -> str:
        return _text(self)

    def nodes(self) -> Iterator[Tree]:
        """The tree and everything below."""
        yield self
        for argument in self.args:
            yield from argument.nodes()

    def names(self) -> set[str]:
        """The names in it, those of unknowns left out."""
        return {str(node.value) for node in self.nodes() if node.head == "name"}

    def size(self) -> int:
        """How many nodes there are."""
        return sum(1 for _ in self.nodes())

    @property
    def number(self) -> Fraction:
        """The value of a number."""
        assert isinstance(self.value, Fraction)
        return self.value

    @property
    def jet(self) -> tuple[str, str, int | None]:
        """The unknown, its derivatives and its shift."""
        assert isinstance(self.value, tuple)
        return self.value


def as_tree(given: Tree | Fraction | int | str) -> Tree:
    """A number or text as a tree.

    >>> str(as_tree("-x**2/4") + Fraction(1, 2))
    '-x**2/4 + (1/2)'
    """
    if isinstance(given, Tree):
        return given
    if isinstance(given, str):
        return read(given)
    return Tree("number", value=Fraction(given))


def name(text: str) -> Tree:
    """A variable or a parameter."""
    return Tree("name", value=text)


def call(function: str, *arguments: Tree | int) -> Tree:
    """A function of arguments."""
    return Tree(function, tuple(map(as_tree, arguments)))


def total(*terms: Tree) -> Tree:
    """A sum of any number of terms."""
    return Tree("+", terms) if len(terms) > 1 else terms[0] if terms else as_tree(0)


# text


def read(text: str, unknowns: tuple[str, ...] = ()) -> Tree:
    """The formula that ``text`` spells, with jets for the ``unknowns``; ValueError if none.

    >>> read("u_xt - k*u[n+1]**2", ("u",)).args[0].value
    ('u', 'xt', None)
    """
    return _Reader(text, unknowns).whole()


class _Reader:
    def __init__(self, text: str, unknowns: tuple[str, ...]) -> None:
        self.words: list[str] = []
        place = 0
        while text[place:].strip():
            match = _WORD.match(text, place)
            if match is None:
                raise ValueError(f"formulas must follow the grammar, got {text[place:]!r}")
            self.words.append(match[match.lastindex or 0])
            place = match.end()
        self.words.append("")
        self.unknowns = unknowns
        self.place = 0

    def whole(self) -> Tree:
        found = self.sum()
        self.expect("")
        return found

    def take(self) -> str:
        self.place += 1
        return self.words[self.place - 1]

    def takes(self, *words: str) -> str:
        return self.take() if self.words[self.place] in words else ""

    def expect(self, word: str) -> None:
        if self.take() != word:
            raise ValueError(f"expected {word!r} in {' '.join(self.words)}")

    def sum(self) -> Tree:
        terms = [self.product()]
        while sign := self.takes("+", "-"):
            term = self.product()
            terms.append(-term if sign == "-" else term)
        return total(*terms)

    def product(self) -> Tree:
        found = self.signed()
        while sign := self.takes("*", "/"):
            other = self.signed()
            found = found / other if sign == "/" else found * other
        return found

    def signed(self) -> Tree:
        if sign := self.takes("+", "-"):
            found = self.signed()
            return -found if sign == "-" else found
        base = self.operand()
        return base ** self.signed() if self.takes("**") else base

    def operand(self) -> Tree:
        word = self.take()
        if word == "(":
            found = self.sum()
            self.expect(")")
            return found
        if word[:1].isdigit():
            return as_tree(Fraction(word))
        if not word[:1].isalpha():
            raise ValueError(f"expected an operand, got {word!r} in {' '.join(self.words)}")
        base, _, steps = word.partition("_")
        if base in self.unknowns:
            return Tree("jet", value=(base, steps, self.site()))
        return self.call(word) if self.takes("(") else name(word)

    def site(self) -> int | None:
        if not self.takes("["):
            return None
        shift = 0
        self.expect("n")
        if sign := self.takes("+", "-"):
            shift = int(sign + self.take())
        self.expect("]")
        return shift

    def call(self, function: str) -> Tree:
        arguments = [self.sum()]
        while self.takes(","):
            arguments.append(self.sum())
        self.expect(")")
        if function != "diff":
            return Tree(function, tuple(arguments))
        return Tree("diff", (arguments[0],), "".join(map(str, arguments[1:])))


def _text(tree: Tree) -> str:
    if tree.head == "number":
        value = tree.number
        plain = str(value)
        return plain if value.denominator == 1 and value >= 0 else f"({plain})"
    if tree.head == "name":
        return str(tree.value)
    if tree.head == "jet":
        unknown, steps, shift = tree.jet
        index = "" if shift is None else f"[n{shift:+d}]" if shift else "[n]"
        plain = f"{unknown}{index}"
        if index and steps:
            return f"diff({plain}, {', '.join(steps)})"
        return f"{plain}_{steps}" if steps else plain
    if tree.head == "diff":
        return f"diff({_text(tree.args[0])}, {', '.join(str(tree.value))})"
    if tree.head == "+":
        return _sum_text(tree)
    if tree.head == "*":
        return _product_text(tree)
    if tree.head == "**":
        base, exponent = tree.args
        return f"{_bracketed(base, '+', '*', '**')}**{_bracketed(exponent, '+', '*', '**')}"
    return f"{tree.head}({', '.join(map(_text, tree.args))})"


def _bracketed(tree: Tree, *heads: str) -> str:
    return f"({_text(tree)})" if tree.head in heads else _text(tree)


def _sum_text(tree: Tree) -> str:
    found = ""
    for term in tree.args:
        if term.head == "*" and term.args[0] == MINUS:
            plain = _bracketed(term.args[1], "+")
            found = f"{found} - {plain}" if found else f"-{plain}"
        else:
            plain = _bracketed(term, "+")
            found = f"{found} + {plain}" if found else plain
    return found


def _product_text(tree: Tree) -> str:
    left, right = tree.args
    if left == MINUS:
        return f"-{_bracketed(right, '+')}"
    over = right.head == "**" and right.args[1] == MINUS
    behind = _bracketed(right.args[0], "+", "*", "**") if over else _bracketed(right, "+", "*")
    return f"{_bracketed(left, '+')}{'/' if over else '*'}{behind}"


MINUS = Tree("number", value=Fraction(-1))

# changes


def mapped(tree: Tree, image: Callable[[Tree], Tree | None]) -> Tree:
    """The tree with ``image`` of a node in its place, from the top; None leaves it."""
    found = image(tree)
    if found is not None:
        return found
    if not tree.args:
        return tree
    return Tree(tree.head, tuple(mapped(argument, image) for argument in tree.args), tree.value)


def put(tree: Tree, images: Mapping[str, Tree]) -> Tree:
    """The tree with formulas in the places of names.

    >>> str(put(read("x**2 + n"), {"n": read("n + 1")}))
    'x**2 + (n + 1)'
    """
    return mapped(tree, lambda node: images.get(str(node.value)) if node.head == "name" else None)


def changed_at(tree: Tree, place: int, image: Callable[[Tree], Tree]) -> Tree:
    """The tree with one node changed, the one of this number in the order of `Tree.nodes`."""
    if place == 0:
        return image(tree)
    place -= 1
    arguments = list(tree.args)
    for index, argument in enumerate(arguments):
        size = argument.size()
        if place < size:
            arguments[index] = changed_at(argument, place, image)
            return Tree(tree.head, tuple(arguments), tree.value)
        place -= size
    raise IndexError(f"a tree must have the node, got number {place} beyond its end")


# derivatives


def derivative(tree: Tree, letter: str) -> Tree:
    """The derivative by a variable, with the plainest simplifications.

    >>> str(derivative(read("k*sin(2*x) + x**3"), "x"))
    'k*(cos(2*x)*2) + 3*x**2'
    """
    if tree.head in ("number", "jet"):
        return ZERO
    if tree.head == "name":
        return ONE if tree.value == letter else ZERO
    if letter not in tree.names():
        return ZERO
    if tree.head == "+":
        return total(*(d for a in tree.args if (d := derivative(a, letter)) != ZERO))
    if tree.head == "*":
        left, right = tree.args
        slopes = derivative(left, letter), derivative(right, letter)
        parts = (_times(slopes[0], right), _times(left, slopes[1]))
        return total(*(part for part in parts if part != ZERO))
    if tree.head == "**":
        return _power_slope(tree, letter)
    inner = derivative(tree.args[0], letter)
    return _times(SLOPES[tree.head](*tree.args), inner)


def _power_slope(tree: Tree, letter: str) -> Tree:
    base, exponent = tree.args
    if letter in exponent.names():
        return _times(tree, derivative(exponent * call("log", base), letter))
    if exponent.head == "number":
        lower = as_tree(exponent.number - 1)
        power = base if lower == ONE else base**lower
        return _times(_times(exponent, power), derivative(base, letter))
    return _times(_times(exponent, base ** (exponent - 1)), derivative(base, letter))


def _times(left: Tree, right: Tree) -> Tree:
    if ZERO in (left, right):
        return ZERO
    if left == ONE:
        return right
    return left if right == ONE else left * right


ZERO, ONE = as_tree(0), as_tree(1)

SLOPES: Mapping[str, Callable[..., Tree]] = {
    "exp": lambda z: call("exp", z),
    "log": lambda z: z**-1,
    "sqrt": lambda z: as_tree(Fraction(1, 2)) / call("sqrt", z),
    "sin": lambda z: call("cos", z),
    "cos": lambda z: -call("sin", z),
    "tan": lambda z: call("sec", z) ** 2,
    "cot": lambda z: -(call("csc", z) ** 2),
    "sec": lambda z: call("sec", z) * call("tan", z),
    "csc": lambda z: -(call("csc", z) * call("cot", z)),
    "sinh": lambda z: call("cosh", z),
    "cosh": lambda z: call("sinh", z),
    "tanh": lambda z: call("sech", z) ** 2,
    "coth": lambda z: -(call("csch", z) ** 2),
    "sech": lambda z: -(call("sech", z) * call("tanh", z)),
    "csch": lambda z: -(call("csch", z) * call("coth", z)),
    "asin": lambda z: call("sqrt", ONE - z**2) ** -1,
    "acos": lambda z: -(call("sqrt", ONE - z**2) ** -1),
    "atan": lambda z: (z**2 + 1) ** -1,
    "asinh": lambda z: call("sqrt", z**2 + 1) ** -1,
    "acosh": lambda z: (call("sqrt", z - 1) * call("sqrt", z + 1)) ** -1,
    "atanh": lambda z: (ONE - z**2) ** -1,
    "jacobi_sn": lambda z, m: call("jacobi_cn", z, m) * call("jacobi_dn", z, m),
    "jacobi_cn": lambda z, m: -(call("jacobi_sn", z, m) * call("jacobi_dn", z, m)),
    "jacobi_dn": lambda z, m: -(m * call("jacobi_sn", z, m) * call("jacobi_cn", z, m)),
}

"""A judge of words: formulas in text and in LaTeX, read and evaluated in mpmath by code of its own.

It shares nothing with the prover: its own parsers make tuples, its derivatives are differences at
high precision, and its arbitrary functions are fixed smooth ones.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import mpmath
from mpmath import mp

Tree = tuple[Any, ...]
Point = Mapping[str, Any]

DIGITS = 40
SMALL = mpmath.mpf(10) ** -12
"""Relative size below which a residual is 0 here."""

NEAR = mpmath.mpf(10) ** -9
"""Distance from a jump or a pole below which nothing is said."""


class CannotJudge(ValueError):
    """A place at which no value is to be trusted."""


# texts

_WORDS = re.compile(r"\s*(\d+\.?\d*|[A-Za-z][A-Za-z0-9_]*|\*\*|[-+*/()\[\],=])")


def text_tree(text: str, variables: str, unknowns: Collection[str]) -> Tree:
    """Return the tree of a formula, or of left - right of an equation, in the prover's grammar."""
    return _Text(_WORDS.findall(text), variables, unknowns).equation()


class _Words:
    def __init__(self, words: Sequence[str]) -> None:
        self.words, self.at = [*words, ""], 0

    def take(self, *signs: str) -> str:
        word = self.words[self.at]
        if word not in signs or not word:
            return ""
        self.at += 1
        return word

    def next(self) -> str:
        self.at += 1
        return self.words[self.at - 1]

    def expect(self, sign: str) -> None:
        if not self.take(sign):
            raise ValueError(f"expected {sign!r} at {self.words[self.at :][:8]}")

    def listed(self, sign: str, part: Callable[[], Tree]) -> list[Tree]:
        found = [part()]
        while self.take(sign):
            found.append(part())
        return found

    def sum(self) -> Tree:
        raise NotImplementedError

    def equation(self) -> Tree:
        left = self.sum()
        if self.take("="):
            left = ("+", left, ("*", ("num", -1), self.sum()))
        if self.words[self.at]:
            raise ValueError(f"left over: {self.words[self.at :]}")
        return left


class _Text(_Words):
    def __init__(self, words: Sequence[str], variables: str, unknowns: Collection[str]) -> None:
        super().__init__(words)
        self.variables, self.unknowns = variables, unknowns

    def sum(self) -> Tree:
        found = self.product()
        while sign := self.take("+", "-"):
            term = self.product()
            found = ("+", found, ("*", ("num", -1), term) if sign == "-" else term)
        return found

    def product(self) -> Tree:
        found = self.signed()
        while sign := self.take("*", "/"):
            other = self.signed()
            found = ("*", found, ("^", other, ("num", -1)) if sign == "/" else other)
        return found

    def signed(self) -> Tree:
        if sign := self.take("-", "+"):
            inner = self.signed()
            return ("*", ("num", -1), inner) if sign == "-" else inner
        base = self.atom()
        return ("^", base, self.signed()) if self.take("**") else base

    def atom(self) -> Tree:
        word = self.next()
        if word == "(":
            found = self.sum()
            self.expect(")")
            return found
        if word[0].isdigit():
            return "num", Fraction(word)
        if word == "diff":
            self.expect("(")
            inner, *steps = self.listed(",", self.sum)
            self.expect(")")
            names: list[str] = []
            for step in steps:
                times = int(step[1]) - 1 if step[0] == "num" else 0
                names += [names[-1]] * times if step[0] == "num" else [step[1]]
            return "diff", inner, tuple(names)
        base, _, steps_text = word.partition("_")
        if base in self.unknowns:
            return "unknown", base, tuple(steps_text), self.shift()
        if self.take("("):
            parts = self.listed(",", self.sum)
            self.expect(")")
            return "call", word, *parts
        return "name", word

    def shift(self) -> int:
        if not self.take("["):
            return 0
        self.expect("n")
        sign = self.take("+", "-")
        found = int(self.next()) * (-1 if sign == "-" else 1) if sign else 0
        self.expect("]")
        return found


# LaTeX

_LATEX = re.compile(r"\s*(\\left[(|]|\\right[)|]|\\[A-Za-z]+|\\.|\d+|[A-Za-z]|[-+^_{}(),=<>:;])")
_PLAIN = {"re": "Re", "im": "Im"}
_NAMED = {f"\\{n}": n for n in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "coth", "log")}
_NAMED |= {r"\arctan": "atan"}
_GREEK = re.compile(r"\\(alpha|beta|gamma|delta|kappa|lambda|mu|nu|omega|psi|phi|Omega)")


def latex_tree(
    text: str, variables: str, unknowns: Collection[str], functions: Collection[str]
) -> Tree:
    """Return the tree of a formula, or of left - right of an equation, in LaTeX."""
    return _Latex(_LATEX.findall(text), variables, unknowns, functions).equation()


class _Latex(_Words):
    def __init__(
        self,
        words: Sequence[str],
        variables: str,
        unknowns: Collection[str],
        functions: Collection[str],
    ) -> None:
        super().__init__(words)
        self.variables, self.unknowns, self.functions = variables, unknowns, functions

    def sum(self) -> Tree:
        sign = self.take("-")
        found = self.product()
        found = ("*", ("num", -1), found) if sign else found
        while sign := self.take("+", "-"):
            term = self.product()
            found = ("+", found, ("*", ("num", -1), term) if sign == "-" else term)
        return found

    def product(self) -> Tree:
        found = self.power()
        while True:
            if self.take(r"\cdot") or (self.words[self.at] and not self.ends()):
                found = ("*", found, self.power())
            else:
                return found

    def ends(self) -> bool:
        word = self.words[self.at]
        return word in ("+", "-", "=", ",", "}", r"\mid") or word.startswith("\\right")

    def power(self) -> Tree:
        base = self.atom()
        return ("^", base, self.braced()) if self.take("^") else base

    def braced(self) -> Tree:
        self.expect("{")
        found = self.sum()
        self.expect("}")
        return found

    def raw(self) -> str:
        self.expect("{")
        found = ""
        while not self.take("}"):
            found += self.next()
        return found.replace("\\_", "_")

    def atom(self) -> Tree:
        word = self.next()
        if word.isdigit():
            return "num", Fraction(word)
        if word == r"\left(":
            found = self.sum()
            self.expect(r"\right)")
            return ("diff", found, tuple(self.raw())) if self.take("_") else found
        if word == r"\left|":
            found = self.sum()
            self.expect(r"\right|")
            return "call", "abs", found
        if word == r"\frac":
            above = self.braced()
            return "*", above, ("^", self.braced(), ("num", -1))
        if word in (r"\sqrt", r"\overline"):
            return "call", "sqrt" if word == r"\sqrt" else "conjugate", self.braced()
        if word == r"\pi":
            return "name", "pi"
        if word == r"\operatorname":
            raw = self.raw()
            return self.call({v: k for k, v in _PLAIN.items()}.get(raw, raw))
        if word in _NAMED:
            return self.call(_NAMED[word])
        if word == r"\mathrm":
            name = self.raw()
            if name == "e" and self.take("^"):
                return "call", "exp", self.braced()
            return ("name", "I") if name == "i" else self.named(name)
        if match := _GREEK.fullmatch(word):
            return self.named(match[1])
        if len(word) == 1 and word.isalpha():
            return self.named(word)
        raise ValueError(f"no formula begins with {word!r}")

    def named(self, name: str) -> Tree:
        if name in self.functions:
            return self.call(name)
        below = self.raw() if self.take("_") else ""
        if name not in self.unknowns:
            return "name", name + below
        shift, steps = 0, below
        if below.startswith("n"):
            index, _, steps = below.partition(",")
            shift = int(index[1:] or 0)
        return "unknown", name, tuple(steps), shift

    def call(self, name: str) -> Tree:
        power = self.braced() if self.take("^") else None
        self.expect(r"\left(")
        parts = self.listed(",", self.sum)
        self.expect(r"\right)")
        found = "call", name, *parts
        return found if power is None else ("^", found, power)


# values


def _sign(z: Any) -> Any:
    size = abs(z)
    if 0 < size < NEAR:
        raise CannotJudge("near a jump")
    return z / size if size else mp.mpf(0)


def _modulus(z: Any) -> Any:
    if 0 < abs(z) < NEAR:
        raise CannotJudge("near a corner")
    return abs(z)


def _off_cut(z: Any) -> Any:
    z = mp.mpc(z)
    if abs(z) < NEAR or (z.real < 0 and 0 < abs(z.imag) < NEAR):
        raise CannotJudge("near a cut")
    return z


FUNCTIONS: dict[str, Callable[..., Any]] = {
    **{n: getattr(mp, n) for n in ("exp", "sin", "cos", "tan", "sinh", "cosh", "tanh", "sech")},
    "atan": mp.atan,
    "log": lambda z: mp.log(_off_cut(z)),
    "sqrt": lambda z: mp.sqrt(_off_cut(z)) if z else mp.mpf(0),
    "abs": _modulus,
    "sign": _sign,
    "re": lambda z: mp.mpc(z).real,
    "im": lambda z: mp.mpc(z).imag,
    "conjugate": mp.conj,
    "f": lambda z: mp.sin(mp.mpf(13) / 10 * z) + z * z / 5 + 1,
    "g": lambda z: mp.exp(z / 3) + mp.cos(z),
}


@dataclass
class Reading:
    """Equations, and what unknowns and defined names stand for."""

    equations: Sequence[Tree]
    solutions: Mapping[str, Tree]
    definitions: Mapping[str, Tree] = field(default_factory=dict)
    _cached: dict[tuple[Any, ...], list[tuple[Any, Any]]] = field(default_factory=dict, repr=False)

    def residuals(self, point: Point) -> list[tuple[Any, Any]]:
        """Return for each equation its residual at a point, and the size of its largest term."""
        key = tuple(point.items())
        if key not in self._cached:
            self._cached[key] = self._computed(point)
        return self._cached[key]

    def _computed(self, point: Point) -> list[tuple[Any, Any]]:
        with mp.workdps(DIGITS):
            found = []
            for equation in self.equations:
                terms = [self.value(term, point) for term in _terms(equation)]
                found.append((sum(terms), 1 + max(map(abs, terms))))
            return found

    def holds(self, point: Point) -> bool:
        """Return whether all residuals are small."""
        return all(abs(value) < SMALL * size for value, size in self.residuals(point))

    def value(self, tree: Tree, point: Point) -> Any:
        """Return the value of a formula."""
        match tree:
            case ("num", number):
                return mp.mpf(number.numerator) / number.denominator
            case ("name", "I"):
                return mp.mpc(0, 1)
            case ("name", "pi"):
                return +mp.pi
            case ("name", name):
                known = self.definitions.get(name)
                return point[name] if known is None else self.value(known, point)
            case ("+", left, right):
                return self.value(left, point) + self.value(right, point)
            case ("*", left, right):
                return self.value(left, point) * self.value(right, point)
            case ("^", base, exponent):
                return self.power(self.value(base, point), self.value(exponent, point))
            case ("call", name, *parts):
                return FUNCTIONS[name](*(self.value(part, point) for part in parts))
            case ("unknown", name, steps, shift):
                moved = {**point, "n": point["n"] + shift} if shift else point
                return self.slope(self.solutions[name], steps, moved)
            case ("diff", inner, steps):
                return self.slope(inner, steps, point)
        raise TypeError(f"no tree: {tree}")

    def slope(self, tree: Tree, steps: Sequence[str], point: Point) -> Any:
        """Return a derivative of a formula by differences."""
        if not steps:
            return self.value(tree, point)
        names = sorted({*steps})
        orders = tuple(steps.count(name) for name in names)

        def at(*values: Any) -> Any:
            return self.value(tree, {**point, **dict(zip(names, values, strict=True))})

        place = tuple(point[name] for name in names)
        if len(names) == 1:
            return mp.diff(at, place[0], orders[0])
        return mp.diff(at, place, orders)

    @staticmethod
    def power(base: Any, exponent: Any) -> Any:
        """Return a principal power; whole ones of anything but 1/0."""
        if mp.isint(exponent) and abs(exponent) < 1000:
            if exponent < 0 and abs(base) < NEAR:
                raise CannotJudge("near a pole")
            return mp.mpmathify(base) ** int(mp.re(exponent))
        if base == 0:
            raise CannotJudge("a power of 0")
        return mp.exp(exponent * mp.log(_off_cut(base)))


def _terms(tree: Tree) -> Iterator[Tree]:
    if tree[0] == "+":
        yield from _terms(tree[1])
        yield from _terms(tree[2])
    else:
        yield tree


KINDS = ("num", "name", "+", "*", "^", "call", "unknown", "diff")


def names_in(trees: Sequence[Tree]) -> set[str]:
    """Return the names in trees, with those of functions that are arbitrary."""
    found: set[str] = set()
    for tree in trees:
        if tree[0] == "name" or (tree[0] == "call" and tree[1] in ("f", "g")):
            found.add(tree[1])
        parts = [part for part in tree[1:] if isinstance(part, tuple) and part]
        found |= names_in([part for part in parts if part[0] in KINDS])
    return found - {"I", "pi"}

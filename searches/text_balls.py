"""Balls around the texts of a statement, by one walk over their words: a second reader.

It shares nothing with the kernel but FLINT.  Every function is written in exp, log, sqrt and theta
functions, by the definitions in ``docs/trust.md``; a derivative is a coefficient of the power
series along its variable.  What has no sharp value raises `CannotJudge`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache, reduce
from itertools import combinations
from math import factorial
from typing import Any

from flint import acb, acb_series, arb, ctx, fmpq

BITS = 160
WORD = re.compile(r"\s*([0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?|\.[0-9]+|[A-Za-z_]\w*|\*\*|[<>!]=|\S)")

Value = Any
"""A ball, or a power series of balls."""

Values = Mapping[str, Value]


class CannotJudge(ValueError):
    """A text has no value at a point, or none that is known sharply enough."""


@cache
def words(text: str) -> tuple[str, ...]:
    """Return the words of a text."""
    return tuple(WORD.findall(text))


@cache
def number(word: str) -> acb:
    """Return a decimal number."""
    found = Fraction(word if word[0] != "." else f"0{word}")
    with ctx.workprec(BITS):
        return acb(arb(fmpq(found.numerator, found.denominator)))


class TextBalls:
    """The texts of a statement as functions of its symbols."""

    def __init__(self, statement: Mapping[str, Sequence[str]]) -> None:
        self.variables = tuple(statement["variables"])
        named = (words(text) for text in statement["parameters"])
        self.named = {found[0]: found[2:] for found in named if found[1] == "="}
        solved = [words(text) for text in statement["solutions"]]
        self.solutions = {found[0]: found[found.index("=") + 1 :] for found in solved}

    def value(self, text: str | Sequence[str], values: Values) -> acb:
        """Return the ball of a formula, or of the difference of the sides of an equation."""
        found = words(text) if isinstance(text, str) else tuple(text)
        try:
            with ctx.workprec(BITS):
                values = {name: _ball(value) for name, value in values.items()}
                if "=" in found:
                    place = found.index("=")
                    sides = found[:place], found[place + 1 :]
                    left, right = (Walk(self, side, values).whole() for side in sides)
                    return _sharp(left - right)
                return _sharp(Walk(self, found, values).whole())
        except (ZeroDivisionError, OverflowError, RecursionError) as error:
            raise CannotJudge(str(error)) from error

    def holds(self, text: str, values: Values) -> bool:
        """Return whether a chain of inequalities is shown to hold strictly; != says nothing."""
        found, ends, signs = words(text), [0], list[str]()
        for place, word in enumerate(found):
            if word in ("<", ">", "<=", ">=", "!="):
                ends += [place, place + 1]
                signs.append(word)
        parts = [found[a:b] for a, b in zip(ends[::2], [*ends[1::2], len(found)], strict=True)]
        balls = [self.value(part, values) for part in parts]
        for sign, left, right in zip(signs, balls, balls[1:], strict=False):
            gap = (right - left) if sign[0] == "<" else (left - right)
            if sign != "!=" and not (gap.imag == 0 and gap.real > 0):
                return False
        return True


class Walk:
    """One walk over words, from the left to the right."""

    def __init__(self, texts: TextBalls, found: Sequence[str], values: Values) -> None:
        self._texts, self._words, self._values, self._at = texts, (*found, ""), values, 0

    def whole(self) -> Value:
        """Return the value of all words."""
        found = self._sum()
        if self._words[self._at]:
            raise KeyError(f"{self._words[self._at]} in {' '.join(self._words)}")
        return found

    def _take(self, *expected: str) -> str:
        word = self._words[self._at]
        self._at += word in expected
        return word if word in expected else ""

    def _sum(self) -> Value:
        total = self._product()
        while sign := self._take("+", "-"):
            total = total + self._product() if sign == "+" else total - self._product()
        return total

    def _product(self) -> Value:
        total = self._signed()
        while sign := self._take("*", "/"):
            other = self._signed()
            total = total * other if sign == "*" else total * inverse(other)
        return total

    def _signed(self) -> Value:
        if self._take("-"):
            return -self._signed()
        base = self._atom()
        return power(base, self._signed()) if self._take("**") else base

    def _atom(self) -> Value:
        word = self._words[self._at]
        self._at += 1
        if word == "(":
            found = self._sum()
            self._take(")")
            return found
        if word[0].isdigit() or word[0] == ".":
            return number(word)
        if self._words[self._at] == "(":
            return self._function(word, self._arguments(")"))
        if self._words[self._at] == "[":
            moves = [Walk(self._texts, part, self._values).whole() for part in self._arguments("]")]
            along = [v for v in self._texts.variables if v == "n"]
            along = along if len(along) == len(moves) else list(self._texts.variables)
            moved = {**self._values, **dict(zip(along, moves, strict=True))}
            return Walk(self._texts, self._texts.solutions[word], moved).whole()
        return self._name(word)

    def _name(self, word: str) -> Value:
        if word in self._values:
            return self._values[word]
        if word in ("I", "pi"):
            return acb(0, 1) if word == "I" else acb.pi()
        if found := self._texts.named.get(word) or self._texts.solutions.get(word):
            return Walk(self._texts, found, self._values).whole()
        unknown, _, steps = word.partition("_")
        return self._derivative((unknown,), list(steps))

    def _arguments(self, closing: str) -> list[tuple[str, ...]]:
        self._at += 1
        found, depth, start = list[tuple[str, ...]](), 0, self._at
        while depth or self._words[self._at] != closing:
            word = self._words[self._at]
            depth += (word in ("(", "[")) - (word in (")", "]"))
            self._at += 1
            if word == "," and not depth:
                found.append(self._words[start : self._at - 1])
                start = self._at
        self._at += 1
        return [*found, self._words[start : self._at - 1]]

    def _function(self, name: str, parts: list[tuple[str, ...]]) -> Value:
        if name == "diff":
            return self._derivative(parts[0], ["".join(part) for part in parts[1:]])
        values = [Walk(self._texts, part, self._values).whole() for part in parts]
        if name.startswith("jacobi_"):
            return jacobi(name.removeprefix("jacobi_"), *values)
        return FUNCTIONS[name](*values)

    def _derivative(self, inner: Sequence[str], steps: Sequence[str]) -> Value:
        """Return D_1 ... D_k f as a sum over subsets of +-(D_a + D_b + ...)**k f / k!."""
        order = len(steps)
        if any(isinstance(value, acb_series) for value in self._values.values()):
            raise CannotJudge("a derivative in a derivative")
        if len(set(steps)) == 1:
            return self._along(inner, {steps[0]: 1}, order)
        total = acb(0)
        for size in range(1, order + 1):
            for chosen in combinations(steps, size):
                weights = {step: chosen.count(step) for step in chosen}
                total += (-1) ** (order - size) * self._along(inner, weights, order)
        return total / factorial(order)

    def _along(self, inner: Sequence[str], weights: Mapping[str, int], order: int) -> acb:
        cap, ctx.cap = ctx.cap, order + 1
        try:
            moved = {v: acb_series([self._values[v], acb(w)]) for v, w in weights.items()}
            found = Walk(self._texts, inner, {**self._values, **moved}).whole()
            return found[order] * factorial(order) if isinstance(found, acb_series) else acb(0)
        finally:
            ctx.cap = cap


def _ball(value: Value) -> Value:
    if isinstance(value, complex):
        return acb(value)
    return acb(arb(value)) if isinstance(value, fmpq) else value


def _sharp(value: acb) -> acb:
    if not value.is_finite() or value.rad() > 2.0**-50 * (1 + float(abs(value).mid())):
        raise CannotJudge("a value is not sharp")
    return value


def head(value: Value) -> acb:
    """Return the value at the point itself."""
    return value[0] if isinstance(value, acb_series) else value


def inverse(value: Value) -> Value:
    """Return 1 over a value that is not 0."""
    if head(value).contains(0):
        raise CannotJudge("1/0")
    return 1 / value


def power(base: Value, exponent: Value) -> Value:
    """Return a principal power."""
    whole = None
    if isinstance(exponent, acb) and exponent.imag == 0:
        whole = exponent.real.unique_fmpz()
    if whole is not None and abs(int(whole)) <= 1000 and exponent == acb(whole):
        count = abs(int(whole))
        found = reduce(lambda a, b: a * b, [base] * count, acb(1))
        return found if int(whole) >= 0 else inverse(found)
    if isinstance(base, acb) and base == 0 and isinstance(exponent, acb) and exponent.real > 0:
        return acb(0)
    return (exponent * log(base)).exp()


def log(value: Value) -> Value:
    """Return the principal logarithm, off its cut or exactly on it."""
    first = head(value)
    if first.contains(0) or (first.real < 0 and first.imag.contains(0) and first.imag != 0):
        raise CannotJudge("a logarithm on its cut")
    return value.log()


def root(value: Value) -> Value:
    """Return the principal square root."""
    return power(value, acb(0.5))


def conjugate(value: Value) -> Value:
    """Return the conjugate for real variables."""
    if isinstance(value, acb_series):
        return acb_series([acb(c.real, -c.imag) for c in value.coeffs()])
    return acb(value.real, -value.imag)


def size(value: Value) -> Value:
    """Return the absolute value."""
    return acb(abs(value)) if isinstance(value, acb) else root(value * conjugate(value))


def sine(z: Value) -> Value:
    """Return the sine."""
    return ((I * z).exp() - (-I * z).exp()) / acb(0, 2)


def cosine(z: Value) -> Value:
    """Return the cosine."""
    return ((I * z).exp() + (-I * z).exp()) / 2


def sinh(z: Value) -> Value:
    """Return the hyperbolic sine."""
    return (z.exp() - (-z).exp()) / 2


def cosh(z: Value) -> Value:
    """Return the hyperbolic cosine."""
    return (z.exp() + (-z).exp()) / 2


def asin(z: Value) -> Value:
    """Return the inverse sine."""
    return -I * log(I * z + root(1 - z * z))


I = acb(0, 1)  # noqa: E741
FUNCTIONS = {
    "exp": lambda z: z.exp(),
    "log": log,
    "sqrt": root,
    "conjugate": conjugate,
    "abs": size,
    "sign": lambda z: z * inverse(size(z)),
    "re": lambda z: (z + conjugate(z)) / 2,
    "im": lambda z: (z - conjugate(z)) / acb(0, 2),
    "sin": sine,
    "cos": cosine,
    "tan": lambda z: sine(z) * inverse(cosine(z)),
    "cot": lambda z: cosine(z) * inverse(sine(z)),
    "sec": lambda z: inverse(cosine(z)),
    "csc": lambda z: inverse(sine(z)),
    "sinh": sinh,
    "cosh": cosh,
    "tanh": lambda z: sinh(z) * inverse(cosh(z)),
    "coth": lambda z: cosh(z) * inverse(sinh(z)),
    "sech": lambda z: inverse(cosh(z)),
    "csch": lambda z: inverse(sinh(z)),
    "atan": lambda z: (log(1 + I * z) - log(1 - I * z)) / acb(0, 2),
    "asin": asin,
    "acos": lambda z: acb.pi() / 2 - asin(z),
    "asinh": lambda z: log(z + root(1 + z * z)),
    "acosh": lambda z: log(z + root(z - 1) * root(z + 1)),
    "atanh": lambda z: (log(1 + z) - log(1 - z)) / 2,
    "elliptic_k": lambda m: m.elliptic_k(),
    "elliptic_e": lambda m: m.elliptic_e(),
}


def jacobi(name: str, z: Value, m: Value) -> Value:
    """Return a Jacobi function of a number m, 0 < m < 1, by theta functions and their series."""
    if not isinstance(m, acb) or not (m.imag == 0 and 0 < m.real < 1):
        raise CannotJudge("m must be a number between 0 and 1")
    first, second = m.elliptic_k(), m.elliptic_e()
    tau = I * (1 - m).elliptic_k() / first
    scaled = z / (2 * first)
    order = ctx.cap if isinstance(z, acb_series) else 1
    rows = [acb.modular_theta(head(scaled), tau, r) for r in range(order + 1)]

    def series(place: int, slope: int = 0) -> Value:
        step, total = scaled - head(scaled), acb(0)
        for r in range(order - 1, -1, -1):
            total = total * step / (r + 1) + rows[r + slope][place]
        return total

    _, two, three, four = acb.modular_theta(acb(0), tau)
    below = inverse(series(3))
    zeta = series(3, 1) * below / (2 * first)
    return {
        "sn": lambda: three / two * series(0) * below,
        "cn": lambda: four / two * series(1) * below,
        "dn": lambda: four / three * series(2) * below,
        "zeta": lambda: zeta,
        "epsilon": lambda: zeta + z * second / first,
        "theta": lambda: series(3),
        "eta": lambda: series(0),
    }[name]()


def symbols(texts: Sequence[str]) -> set[str]:
    """Return the names in texts that are no functions."""
    found = (word for text in texts for word in words(text))
    names = {w for w in found if w[0].isalpha() and not w.startswith("jacobi_")}
    return names - {*FUNCTIONS, "I", "pi", "diff"}

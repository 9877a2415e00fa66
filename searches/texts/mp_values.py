"""Values of formulas in text by mpmath, at points: no code of the prover, and no ball arithmetic.

Derivatives are differences of 30 digits, so that moduli, signs and conjugates of functions of real
variables are differentiated as anything else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

from mpmath import MPContext

from searches.texts.trees import Tree, read

DIGITS = 30

CLOSE, FAR = 1e-12, 1e-6
"""Relative residuals below the first vanish, above the second do not."""

Values = Mapping[str, Any]

mp = MPContext()
mp.dps = DIGITS

NAMED = (
    *("exp", "log", "sqrt", "sin", "cos", "tan", "cot", "sec", "csc", "erf"),
    *("sinh", "cosh", "tanh", "coth", "sech", "csch"),
    *("asin", "acos", "atan", "asinh", "acosh", "atanh"),
)
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    **{name: getattr(mp, name) for name in NAMED},
    "abs": abs,
    "sign": mp.sign,
    "re": mp.re,
    "im": mp.im,
    "conjugate": mp.conj,
}


class Residuals:
    """The residuals of equations for unknowns that stand for formulas."""

    def __init__(self, equations: Sequence[str], solutions: Sequence[str]) -> None:
        sides = [text.replace("[n]", "", 1).split("=", 1) for text in solutions]
        self._formulas = {left.strip(): read(right) for left, right in sides}
        self._equations = [read(text, tuple(self._formulas)) for text in equations]

    def largest(self, point: Values) -> Any:
        """The largest residual, relative to the terms that it is a sum of."""
        return max(self._relative(equation, point) for equation in self._equations)

    def _relative(self, equation: Tree, point: Values) -> Any:
        terms = equation.args if equation.head == "+" else (equation,)
        values = [self.value(term, point) for term in _flat(terms)]
        return abs(sum(values)) / (1 + max(map(abs, values)))

    def value(self, tree: Tree, point: Values) -> Any:
        """The value of a formula, which may contain unknowns and their derivatives."""
        match tree.head:
            case "number":
                return mp.mpf(tree.number.numerator) / tree.number.denominator
            case "name":
                return _constant(str(tree.value), point)
            case "jet":
                unknown, letters, shift = tree.jet
                moved = {**point, "n": point["n"] + shift} if shift else point
                return self._slope(self._formulas[unknown], letters, moved)
            case "diff":
                return self._slope(tree.args[0], str(tree.value), point)
            case "+":
                return mp.fsum(self.value(argument, point) for argument in tree.args)
            case "*":
                return mp.fprod(self.value(argument, point) for argument in tree.args)
        values = [self.value(argument, point) for argument in tree.args]
        return _power(*values) if tree.head == "**" else _called(tree.head, values)

    def _slope(self, tree: Tree, letters: str, point: Values) -> Any:
        if not letters:
            return self.value(tree, point)
        names = sorted(set(letters))

        def along(*coordinates: Any) -> Any:
            return self.value(tree, {**point, **dict(zip(names, coordinates, strict=True))})

        at, orders = tuple(point[name] for name in names), tuple(map(letters.count, names))
        return mp.diff(along, at if len(at) > 1 else at[0], orders if len(at) > 1 else orders[0])


def value(text: str, point: Values) -> Any:
    """The value of a text without unknowns."""
    return _PLAIN.value(_read(text), point)


def holds(words: str, point: Values) -> bool | None:
    """Whether a condition holds, such as ``a - b >= 0``; None for words that are none."""
    for relation in (">=", "<=", "!=", "=", ">", "<"):
        left, sign, right = words.partition(f" {relation} ")
        if sign:
            try:
                difference = mp.mpmathify(value(left, point) - value(right, point))
            except ValueError:
                return None
            return _compared(difference, relation)
    for kind in ("real", "integer"):
        if words.endswith(f" is {kind}"):
            found = mp.mpmathify(value(words.removesuffix(f" is {kind}"), point))
            near = found.real if kind == "real" else mp.nint(found.real)
            return bool(abs(found - near) < CLOSE)
    return None


def _compared(difference: Any, relation: str) -> bool:
    is_zero = bool(abs(difference) < CLOSE)
    if relation in ("=", "!="):
        return is_zero == (relation == "=")
    if abs(mp.im(difference)) > CLOSE:
        return False
    if is_zero:
        return relation in (">=", "<=")
    return bool((mp.re(difference) > 0) == (relation[0] == ">"))


def _flat(terms: Sequence[Tree]) -> list[Tree]:
    return [part for term in terms for part in (_flat(term.args) if term.head == "+" else [term])]


def _constant(name: str, point: Values) -> Any:
    if name in ("pi", "I"):
        return +mp.pi if name == "pi" else mp.mpc(0, 1)
    return point[name]


def _power(base: Any, exponent: Any) -> Any:
    whole = mp.nint(mp.re(exponent))
    if exponent == whole:
        return base ** int(whole)
    return mp.exp(exponent * mp.log(base))


def _called(name: str, values: Sequence[Any]) -> Any:
    if name.startswith("jacobi_"):
        return mp.ellipfun(name.removeprefix("jacobi_"), values[0], m=values[1])
    return FUNCTIONS[name](*values)


@lru_cache(maxsize=500)
def _read(text: str) -> Tree:
    return read(text)


_PLAIN = Residuals((), ())

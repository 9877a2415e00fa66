"""Random formula texts of the kernel's grammar, conditions, and points of a statement's domain."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from random import Random

from flint import fmpq

from searches.text_balls import CannotJudge, TextBalls, Values, symbols, words

KINDS = ("integer", "complex", "real", "nonzero")
ONE_PLACE = (
    *("exp", "sin", "cos", "tanh", "sech", "cosh", "sinh", "abs", "sign", "re", "im", "conjugate"),
    *("sqrt", "log", "atan", "tan", "coth", "csch", "sec", "csc", "cot"),
    *("asin", "acos", "asinh", "acosh", "atanh"),
)
JACOBI = ("sn", "cn", "dn", "epsilon", "zeta", "theta", "eta")
NUMBERS = ("0", "1", "2", "3", "5", "1/2", "2/3", "0.25", "1e-1", ".5", "7/4", "10")
POWERS = ("2", "3", "-1", "-2", "1/2", "(1/3)", "(-1/2)", "(2/3)", "4", "-3", "(3/2)", "0", "2**2")


class RandomText:
    """Formulas in ``names``; ``parts`` are those that others were made of."""

    def __init__(self, rng: Random, names: Sequence[str], functions: Sequence[str]) -> None:
        self._rng, self._names, self._functions = rng, names, functions
        self.parts: list[str] = []

    def formula(self, depth: int) -> str:
        """Return a formula in brackets, or an atom."""
        found = self._formula(depth)
        self.parts.append(found)
        return found

    def _formula(self, depth: int) -> str:
        rng = self._rng
        kind = rng.random()
        if depth == 0 or kind < 0.1:
            return rng.choice(self._names) if rng.random() < 0.75 else f"({rng.choice(NUMBERS)})"
        if kind < 0.45:
            signs = [rng.choice(("+", "-", "*", "*", "/", "- -", "*-")) for _ in range(2)]
            left, middle, right = (self.formula(depth - 1) for _ in range(3))
            end = f" {signs[1]} {right}" if rng.random() < 0.4 else ""
            return f"({'-' if rng.random() < 0.2 else ''}{left} {signs[0]} {middle}{end})"
        if kind < 0.5:
            return f"({rng.choice(('sign', 'abs', 'sqrt', 'log'))}({self.formula(depth - 1)})**2)"
        if kind < 0.6:
            return f"({self.formula(depth - 1)}**{self._power()})"
        if kind < 0.66 and "n" in self._names:
            turn = rng.choice(
                ("n", "(n+1)", "(2*n)", "(3*n - 2)", "(-n)", "-n", "(j*n)", "(2 - 1)")
            )
            base = rng.choice(("(-1)", "(-1)", "(-2)", "(-1/2)"))
            return f"({base}**{turn if 'j' in self._names else turn.replace('j*', '')})"
        if kind < 0.72 and "jacobi" in self._functions:
            return f"jacobi_{rng.choice(JACOBI)}({self.formula(depth - 1)}, 1/{rng.choice('23')})"
        name = rng.choice([f for f in self._functions if f != "jacobi"])
        return f"{name}({self.formula(depth - 1)})"

    def _power(self) -> str:
        return self._rng.choice(POWERS) if self._rng.random() < 0.9 else self.formula(1)


def condition(rng: Random, names: Sequence[str]) -> str:
    """Return a condition on some of the names: mostly linear."""
    a, b = rng.choice(names), rng.choice(names)
    low, high = sorted(rng.sample((-3, -2, -1, 0, 1, 2, 5), 2))
    return rng.choice(
        (
            *(
                f"{a} > 0",
                f"{low} < {a} < {high}",
                f"{a} < {high}",
                f"{low} <= {a}",
                f"-{a} > {low}",
            ),
            *(
                f"{a} > {b} + {high}",
                f"{a}**2 < {abs(high) + 1}",
                f"{a}*{b} > {low}",
                f"-(-{a}) > 0",
            ),
            *(
                f"1 - {a}**2 > 0",
                f"abs({a}) > {abs(low)}",
                f"exp({a}) > {b}",
                f"2*{a} - 1 >= {low}",
            ),
            *(f"-{a} > {low}", f"-(-{a}) > 0", f"2*{a} - 1 >= {low}"),
            *(f"{a}/2 + {b} > {low}", f"0 < {a}*(-1)*(-1)", f"{a} != 0", f"(-1)**3*{a} < {high}"),
        )
    )


def conditions_of(statement: Mapping[str, Sequence[str]]) -> tuple[dict[str, str], list[str]]:
    """Return the kinds of names, and the inequalities, of a statement."""
    kinds, found = {"n": "integer"} if "n" in statement["variables"] else {}, []
    for text in statement["parameters"]:
        name, colon, limits = text.partition(":")
        if not colon:
            continue
        for part in map(str.strip, limits.split(",")):
            if part in KINDS:
                kinds[name.strip()] = part
            elif part in ("positive", "negative"):
                found.append(f"{name} {'>' if part == 'positive' else '<'} 0")
            else:
                found.append(part)
    for text in statement["domain"]:
        found += text.split(",") if "(" not in text else [text]
    return kinds, found


def drawn(rng: Random, kind: str) -> fmpq | complex:
    """Return a value of a symbol: small, near 0, or extreme."""
    if kind == "integer":
        return fmpq(rng.choice((-3, -2, -1, 0, 1, 2, 3, 4, rng.randint(-50, 50))))
    value = fmpq(rng.randint(-4000, 4000), rng.choice((997, 1009, 1999)))
    value *= fmpq(rng.choice((1, 1, 1, 1, 5)), rng.choice((1, 1, 1, 4, 10**6)))
    if kind == "complex":
        return complex(rng.randint(-40, 40) / 16, rng.randint(-40, 40) / 16)
    return value


def points(
    rng: Random, statement: Mapping[str, Sequence[str]], count: int, names: Sequence[str] = ()
) -> Iterator[Values]:
    """Yield at most ``count`` points of the domain."""
    balls = TextBalls(statement)
    kinds, found = conditions_of(statement)
    texts = [*statement["equations"], *map(" ".join, balls.solutions.values())]
    texts += [*map(" ".join, balls.named.values()), *found, *names]
    known = {*balls.named, *balls.solutions}
    letters = {w for w in symbols(texts) - known if w.split("_")[0] not in balls.solutions}
    letters |= set(balls.variables)
    chains = [text for text in found if set("<>!") & set("".join(words(text)))]
    for _ in range(count * 6):
        point = {name: drawn(rng, kinds.get(name, "real")) for name in sorted(letters)}
        try:
            if all(balls.holds(text, point) for text in chains):
                yield point
                count -= 1
        except CannotJudge:
            continue
        if not count:
            return

"""The opponent of words: statements that SymPy reads otherwise, and all that is printed of them.

The statements are made of what SymPy simplifies while it builds (signs, moduli, real parts, powers
of negative numbers, shifts, parities, functions), and of its reading as the other side.  Verdicts,
residuals, hints, scopes, places and LaTeX are read back and evaluated by `searches.word_judge`.

    python -m searches.words [--count 100000] [--minutes 60] [--seed 0] [--hints 8] [--solves 0]

With ``--solves 5`` every fifth statement is solved for a constant (`searches.word_solves`).

Prints what is false, with the statement, and a table; the exit status is 1 if anything is.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import re
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any

from mpmath import mp

from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.derive.algebra.formula_text import FormulaError
from longwave.support.processes import OutOfTime, time_limit
from longwave.verify.proof.conditions import ConditionalVerdict
from longwave.verify.proof.mistyped_statements import split_outside
from longwave.verify.proof.near_misses import with_hint
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import (
    StatementVerdict,
    decide_statement,
    verified_sentence,
)
from longwave.verify.proof.stored_verdict import checked_again, verdict_record
from longwave.verify.proof.text_prover import prove
from longwave.verify.proof.typed_statement import Statement
from searches.word_judge import NEAR, CannotJudge, Point, Reading, latex_tree, names_in, text_tree
from searches.word_solves import Solved, faults, solved

LIMIT = 20.0
"""Seconds for a statement; what takes longer is counted."""

POINTS, TRIES = 3, 12
"""Points at which a formula is evaluated, and how many are drawn for them."""

RESUMED = 10
"""Every so many verdicts one is written to a file and taken from it again, with lies beside it."""

RANGES = {
    "": (-3, 3),
    "real": (-3, 3),
    "positive": (0, 3),
    "negative": (-3, 0),
    "{0}>0": (0, 3),
    "{0}<0": (-3, 0),
    "0<{0}<1": (0, 1),
    "-2<={0}<-1": (-2, -1),
    "{0}!=0": (-3, 3),
}
"""Domains in the grammar with the least and largest value that are drawn."""

HOSTILE = (
    *("sign(exp(I*{z}))**2", "sign(1 + I*{z})**2", "sign(exp(I*{z}))*sign(exp(-I*{z}))"),
    *("abs(exp(I*{z}))", "abs({m})/{m}", "sign({m})", "sign({m})**2", "sign({z})**2"),
    *("sqrt({z}**2)", "sqrt({m}**2*{z}**2)", "({z}**2)**(1/2)", "({z}**3)**(1/3)"),
    *("(-{m})**(1/2)", "((-1)**{k})**2", "(-1)**(2*{k})", "(-1)**{k}", "cos(pi*{k})"),
    *("re(exp(I*{z}))", "im(exp(I*{z}))", "conjugate(exp(I*{z}))", "re({z} + I*{m})"),
    *("log(exp(I*{z}))", "log({z}**2)", "exp(log({z}))", "abs({z})**2", "abs({z})*sign({z})"),
    *("0/{z}", "0*tanh({z})", "{z}/{z}", "0*sqrt({z})", "0*log({z}) + 1", "im({z})", "1**{z}"),
    *("sign({k} - 3)**2", "abs({k} - 2)", "sign(2*{k} - 1)**2", "1/({k} - 1)*({k} - 1)"),
    *("exp(I*pi*{k})", "sqrt(-{m}**2)", "abs({m}*{z})/abs({m})", "sign({m}*{z})*sign({z})"),
    *("abs(f({z}))**2", "conjugate(f({z}))", "f(abs({z}))", "sign(f({z}))**2", "atan(tan({z}))"),
    *("(exp(I*{z}))**(1/2)", "(-1)**({k} + 1)", "abs(sign({z}))", "sqrt(exp(2*{z}))"),
)
"""What SymPy makes simpler, rightly or not."""

BASES = (
    ("u_t + {m}*u_x", "exp({x} - {m}*{t})"),
    ("u_t + u_x", "sin(x - t)"),
    ("u_x + 1", "-x"),
    ("u_x - {m}*u", "exp({m}*x)"),
    ("u_t - u_xx", "exp(x + t)"),
    ("u_tt - u_xx", "f(x - t)"),
    ("I*u_t + u_xx", "exp(I*(x - t))"),
    ("u_t + 6*u*u_x + u_xxx", "2*{m}**2*sech({m}*(x - 4*{m}**2*t))**2"),
    ("diff(u[n], t) - u[n+1] + u[n]", "n + t"),
    ("u[n+1] - 2*u[n]", "2**n"),
    ("u[n+1] + u[n]", "(-1)**n"),
    ("diff(u[n], t, 2) - u[n+1] + 2*u[n] - u[n-1]", "cos(pi*n)*sin(2*t)"),
    ("u[n+1] - u[n] - 1", "abs(n)"),
)
"""Equations with solutions, into which hostile factors and terms are put."""


@dataclass(frozen=True)
class Made:
    """A statement in text, with a range and a kind for each name."""

    equation: str
    solution: str
    parameters: str
    domain: str
    ranges: dict[str, tuple[int, int]]
    kinds: dict[str, str]

    @property
    def words(self) -> str:
        """The statement as arguments of `prove`."""
        texts = (self.equation, self.solution, self.parameters, self.domain)
        return ", ".join(map(repr, texts))

    def read(self) -> Statement:
        """Return the prover's reading of the texts."""
        return _read(self.equation, self.solution, self.parameters, self.domain)

    def point(self, draw: random.Random) -> dict[str, Any]:
        """Return a random admissible point."""
        found: dict[str, Any] = {}
        for name, (low, high) in self.ranges.items():
            if self.kinds[name] == "integer":
                found[name] = mp.mpf(draw.randint(low + 1, high - 1) if high - low > 1 else low)
                continue
            found[name] = mp.mpf(low) + (high - low) * mp.mpf(draw.randint(1, 996)) / 997
            if self.kinds[name] == "complex":
                found[name] = mp.mpc(found[name], mp.mpf(draw.randint(-900, 900)) / 613)
        return found


@lru_cache(maxsize=4)
def _read(equation: str, solution: str, parameters: str, domain: str) -> Statement:
    """Read texts once: a statement is read where it is drawn and where it is decided."""
    return read_statement(equation, solution, parameters, domain)


def random_statement(seed: int, index: int) -> Made:
    """Return the statement of a number, the same each time."""
    draw = random.Random(f"words:{seed}:{index}")
    while True:
        found = _drawn(draw)
        if found is not None:
            return found


def _drawn(draw: random.Random) -> Made | None:
    lattice = draw.random() < 0.3
    bases = [base for base in BASES if ("[" in base[0]) == lattice]
    equation, base = draw.choice(bases)
    letters = {"x": "x", "t": "t", "m": draw.choice("mac"), "z": "x"}

    def hostile() -> str:
        site = "n" if lattice else "k"
        argument = draw.choice(("x", "t", "x - t", "2*x", "-x", letters["m"], "x*t"))
        argument = draw.choice(("n", "t", "n - 2", "-n", "n*t")) if lattice else argument
        text = draw.choice(HOSTILE)
        filled = {**letters, "z": f"({argument})", "k": draw.choice((site, "k"))}
        return text.format(**filled)

    equation, base = equation.format(**letters), base.format(**letters)
    kind = draw.random()
    if kind < 0.35:  # SymPy's reading as the other side
        solution = " ".join(
            ("u =", draw.choice(("{0}*{1}", "{0} + {1}", "{1}")).format(base, hostile()))
        )
        if draw.random() < 0.4:
            solution += draw.choice((f" + {hostile()}", f"*{hostile()}"))
        return _with_reading(solution, lattice, draw, letters)
    shape = draw.choice(
        ("{0}*{1}", "{0} + 0*{1}", "{0} + {1} - {1}", "{0}*{1}**2", "{0}/{1}", "{1}*({0})")
    )
    solution = f"u = {shape.format(f'({base})', hostile())}"
    if draw.random() < 0.25:
        solution = _misprinted(solution, draw)
    return _stated(equation, solution, draw, letters["m"])


def _misprinted(text: str, draw: random.Random) -> str:
    return draw.choice(
        (
            text.replace(" - ", " + ", 1),
            text.replace("**2", "**3", 1),
            text.replace("2*", "", 1),
            text.replace("4*", "", 1),
            text.replace("u = ", "u = -", 1),
        )
    )


def _with_reading(
    solution: str, lattice: bool, draw: random.Random, letters: dict[str, str]
) -> Made | None:
    unknown = "u[n]" if lattice else "u"
    first = _stated(f"{unknown} - 1", solution, draw, letters["m"])
    if first is None:
        return None
    try:
        formula = next(iter(first.read().solutions.values()))
        text = formula_as_text(formula)
        if draw.random() < 0.3 and not lattice:
            unknown, text = "u_x", formula_as_text(formula.diff("x"))
        ranges, kinds = {"x": (-3, 3)} | first.ranges, {"x": "real"} | first.kinds
        if unknown == "u_x":
            first = replace(first, ranges=ranges, kinds=kinds)
        made_again = replace(first, equation=f"{unknown} - ({text})")
        made_again.read()
    except (ValueError, TypeError, RecursionError):
        return None
    return made_again


def _stated(equation: str, solution: str, draw: random.Random, letter: str) -> Made | None:
    texts = f"{equation} {solution}"
    names = {*re.findall(r"\b[a-z]\b", texts)} - {"u", "f"} | {*re.findall(r"u_([xt])", texts)}
    names |= set() if names & {*"xtn"} else {"x"}
    ranges, kinds, stated, limits = {}, {}, [], []
    for name in sorted(names):
        domain = draw.choice([*RANGES])
        ranges[name], kinds[name] = RANGES[domain], "real"
        if name in "xtn":
            kinds[name] = "integer" if name == "n" else "real"
            if "{0}" in domain and "!=" not in domain and (name != "n" or "1" not in domain):
                limits.append(domain.format(name))
            else:
                ranges[name] = (-3, 3)
        elif name == "k":
            kinds[name], ranges[name] = "integer", (-6, 7)
            stated.append("k: integer")
        elif draw.random() < 0.12:
            kinds[name], ranges[name] = "complex", (-3, 3)
            stated.append(f"{name}: complex")
        elif domain:
            stated.append(f"{name}: {domain.format(name)}")
        if name == "n":
            ranges[name] = {(0, 3): (0, 8), (-3, 0): (-8, 0)}.get(ranges[name], (-7, 8))
    if "f(" in texts:
        stated.append("f: function")
    found = Made(equation, solution, "; ".join(stated), "; ".join(limits), ranges, kinds)
    try:
        found.read()
    except (ValueError, TypeError, RecursionError):
        return None
    return found


# the judgement


class Judgement:
    """Faults in all that is said of one statement."""

    def __init__(self, given: Made, statement: Statement, seed: int, index: int) -> None:
        self.given, self.statement, self.draw = given, statement, random.Random(f"{seed}.{index}")
        self.typed = self._text_reading([given.equation], given.solution)
        self.drawn = [*self.points(self.typed)]
        self.shown: set[tuple[str, str]] = set()
        self.faults: list[str] = []

    def _text_reading(self, equations: list[str], solution: str) -> Reading:
        _, _, formula = solution.partition("=")
        trees = [text_tree(text, "xtn", ("u",)) for text in equations]
        return Reading(trees, {"u": text_tree(formula, "xtn", ("u",))})

    def points(self, reading: Reading, count: int = POINTS) -> Iterator[Point]:
        """Yield points at which a reading can be judged."""
        left = count
        for _ in range(TRIES):
            point = self.given.point(self.draw)
            try:
                reading.residuals(point)
            except (CannotJudge, ZeroDivisionError, ValueError, OverflowError):
                continue
            yield point
            left -= 1
            if not left:
                return

    def look(self, verdict: StatementVerdict) -> list[str]:
        """Judge the verdict and everything that is printed of it."""
        match verdict.outcome.value:
            case "PROVED":
                self._look_at_proof(verdict)
            case "REFUTED":
                self._look_at_witness(verdict)
        sentence = verified_sentence(self.statement, verdict)
        displayed = re.findall(r"\\\[ (.*?) \\\]", sentence)
        if displayed:
            self._look_at_latex(displayed[0], displayed[1], "sentence")
        if verdict.outcome.value == "PROVED":
            self._look_at_scope(_plain_scope(sentence.splitlines()[-1]), "sentence")
            self._look_at_scope(verdict.assumptions[0], "scope")
        equations, _, rest = verdict.statement.partition(r" \quad\Leftarrow\quad ")
        self._look_at_latex(rest.partition(r" \qquad (")[0], equations, "statement")
        self._look_at_hint(verdict)
        return self.faults

    def _look_at_proof(self, verdict: StatementVerdict) -> None:
        for point in [*self.drawn, *self._sites(self.typed), *self._zeros(self.typed)]:
            if not (self.typed.holds(point) or self._is_named(verdict, point)):
                self.faults.append(f"PROVED, but it fails at {_shown(point)}")

    def _is_named(self, verdict: StatementVerdict, point: Point) -> bool:
        """Return whether a verdict says that it says nothing at a point."""
        words = (*verdict.singularities, verdict.sides)
        named = {*re.findall(r"(?:at|the site|apart from|,) (\w+) = (-?\d+)", " ".join(words))}
        rough = any(" where " in line for line in verdict.singularities) or " more" in verdict.sides
        at = {(name, str(int(point[name]))) for name in {"n", "k"} & point.keys()}
        if at & named or ("n" in point and rough) or " more" in verdict.sides:
            return True
        return any(self._is_at(place, point) for place in _places(verdict))

    def _is_at(self, place: str, point: Point) -> bool:
        """Return whether a point is at a place in words; where that is not known it is."""
        left, sign, right = place.partition(" = ")
        if not sign or "..." in place:
            return True
        try:
            sides = [text_tree(text, "xtn", ("u",)) for text in (left, right)]
            low, high = (self.typed.value(tree, point) for tree in sides)
        except (CannotJudge, ValueError, IndexError, KeyError, ZeroDivisionError):
            return True
        return bool(abs(low - high) < NEAR)

    def _zeros(self, reading: Reading) -> Iterator[Point]:
        """Yield points at which one name is 0."""
        for name in sorted(self.given.ranges.keys() - {"n", "k"}):
            point = self.given.point(self.draw) | {name: mp.mpf(0)}
            with suppress(CannotJudge, ZeroDivisionError, ValueError, OverflowError):
                if self._admits(point):
                    reading.residuals(point)
                    yield point

    def _sites(self, reading: Reading) -> Iterator[Point]:
        """Yield a point at every site that is looked at."""
        low, high = self.given.ranges.get("n", (0, 0))
        for site in range(low + 1, high):
            point = self.given.point(self.draw) | {"n": mp.mpf(site)}
            with suppress(CannotJudge, ZeroDivisionError, ValueError, OverflowError):
                reading.residuals(point)
                yield point

    def _look_at_witness(self, verdict: StatementVerdict) -> None:
        point = {name: _number(text) for name, text in (verdict.witness or {}).items()}
        for name, (low, high) in self.given.ranges.items():
            wide = (low, high) if (low, high) in (RANGES["0<{0}<1"], RANGES["-2<={0}<-1"]) else None
            value = _real_part((verdict.witness or {})[name])
            ends = wide or (0 if low == 0 else -math.inf, 0 if high == 0 else math.inf)
            if not ends[0] <= value <= ends[1]:
                self.faults.append(f"the witness {name} = {value} is outside of its range")
        try:
            value, size = _with_own_function(self.typed, point, verdict).residuals(point)[0]
        except (CannotJudge, ZeroDivisionError, ValueError):
            return
        middle, error = _residual(verdict.detail)
        if abs(value - middle) > error + mp.mpf(10) ** -20 * size:
            self.faults.append(f"{verdict.detail}, but the residual is {mp.nstr(value, 10)}")

    def _look_at_latex(self, formula: str, equation: str, where: str) -> None:
        if (formula, equation) in self.shown:
            return
        self.shown.add((formula, equation))
        functions = ("f",) if "f(" in self.given.solution else ()
        try:
            _, _, right = formula.partition("=")
            displayed = Reading(
                [latex_tree(equation, "xtn", ("u",), functions)],
                {"u": latex_tree(right, "xtn", ("u",), functions)},
            )
        except (ValueError, IndexError, KeyError) as error:
            self.faults.append(
                f"LaTeX of the {where} cannot be read ({error}): {equation} {formula}"
            )
            return
        for point in self.drawn:
            pairs = zip(displayed.residuals(point), self.typed.residuals(point), strict=True)
            far = any(abs(a - b) > mp.mpf(10) ** -15 * size for (a, _), (b, size) in pairs)
            values = [r.value(r.solutions["u"], point) for r in (displayed, self.typed)]
            if far or abs(values[0] - values[1]) > mp.mpf(10) ** -15 * (1 + abs(values[1])):
                self.faults.append(f"LaTeX of the {where} differs: {equation} {formula}")
                return

    def _look_at_scope(self, text: str, where: str) -> None:
        """Compare kinds and names with those declared, and conditions by the values they admit."""
        text = text.removeprefix("for all ").partition(", wherever")[0]
        names, _, conditions = text.partition(" with ")
        names = names.replace(" that are real at real arguments", "")
        kinds: dict[str, str] = {}
        for group in re.split(r"; | and (?=functions)", names):
            kind, _, listed = group.partition(" ")
            kinds |= dict.fromkeys(listed.split(", "), kind.removesuffix("s"))
        needed = names_in([*self.typed.equations, *self.typed.solutions.values()])
        expected = {name: self.given.kinds.get(name, "function") for name in needed}
        expected |= {n: k for n, k in self.given.kinds.items() if n in "xtn"}
        if kinds != expected:
            self.faults.append(f"{where}: names are {kinds}, not {expected}")
        for _ in range(20):
            point = {n: mp.mpf(self.draw.randint(-40, 40)) / 13 for n in self.given.ranges}
            inside = all(_meets(c, point) for c in conditions.split(", ") if c)
            if inside != self._admits(point):
                self.faults.append(f"{where}: {conditions} at {_shown(point)}")
                return

    def _admits(self, point: Point) -> bool:
        typed = [part.partition(":")[::2] for part in self.given.parameters.split("; ")]
        texts = [_signed(name, c.strip()) for name, c in typed if c]
        return all(_meets(c, point) for c in (*texts, *self.given.domain.split("; ")) if c)

    def _look_at_hint(self, verdict: StatementVerdict) -> None:
        if not verdict.hint:
            return
        _, _, text = verdict.hint.rpartition(": ")
        if " in the equation" in verdict.hint:
            reading = self._text_reading([text.removesuffix(" = 0")], self.given.solution)
        else:
            reading = self._text_reading([self.given.equation], text)
        proof = verdict.hint_verdict
        left = () if proof is None else (proof.restriction, *proof.nonsmooth_lines)
        for words in left:
            if words not in verdict.hint:
                self.faults.append(f"hint {verdict.hint!r} leaves out: {words}")
        for point in [*self.points(reading), *self._sites(reading), *self._zeros(reading)]:
            if not (reading.holds(point) or (proof and self._is_named(proof, point))):
                self.faults.append(f"hint {verdict.hint!r} fails at {_shown(point)}")
                return

    def look_again(self, verdict: StatementVerdict) -> list[str]:
        """Judge what is shown of a record with lies in the place of words."""
        lies: dict[str, Any] = {
            "hint": "a lie",
            "assumptions": ["a lie"],
            "singularities": ["a lie"],
        }
        lies |= {"statement": "a lie", "seconds": 1e9}
        if verdict.outcome.value != "UNDECIDED":
            lies["reason"] = "a lie"
        record = json.loads(json.dumps(verdict_record(verdict))) | lies
        again = checked_again(self.statement, record)
        if again is None:
            self.faults.append("a verdict is not taken again")
        elif "a lie" in json.dumps(again.json()) or again.outcome != verdict.outcome:
            self.faults.append("a lie is shown on resumption")
        elif (again.hint, again.assumptions) != (verdict.hint, verdict.assumptions):
            self.faults.append(f"on resumption: {again.hint}, {again.assumptions}")
        return self.faults


def _places(verdict: StatementVerdict) -> Iterator[str]:
    """Yield the places at which a proof says nothing, in words."""
    for line in verdict.singularities:
        yield re.sub(r"^.*? (?:at the site|at|where|of) ", "", line)
    for part in re.split("^| and (?=apart)", verdict.sides):
        listed = re.sub(r"^(?:on each side of|apart from) |, nothing said .*$", "", part)
        yield from (text.strip() for text in split_outside(listed, ",") if text.strip())


def _plain_scope(text: str) -> str:
    """Return the scope of a sentence in LaTeX in the signs of the other one."""
    text = text.partition("; nothing is said")[0].partition(" at which it is smooth")[0]
    signs = {"$": "", r"\le": "<=", r"\ge": ">=", r"\ne": "!="}
    for sign, plain in signs.items():
        text = text.replace(sign, plain)
    return text


def _signed(name: str, condition: str) -> str:
    words = {"positive": f"{name}>0", "negative": f"{name}<0"}
    plain = condition in ("real", "integer", "complex", "function")
    return "" if plain else words.get(condition, condition)


def _meets(condition: str, point: Point) -> bool:
    """Return whether a chain of inequalities holds."""
    parts = re.split(r"\s*(<=|>=|!=|<|>)\s*", condition.strip())
    values = [point[side] if side in point else mp.mpf(int(side)) for side in parts[::2]]
    tests = {
        "<": lambda a, b: a < b,
        "<=": lambda a, b: a <= b,
        ">": lambda a, b: a > b,
        ">=": lambda a, b: a >= b,
        "!=": lambda a, b: a != b,
    }
    pairs = zip(values, parts[1::2], values[1:], strict=False)
    return all(tests[sign](left, right) for left, sign, right in pairs)


def _real_part(text: str) -> Fraction:
    """Return the real part of a number as it is printed, without rounding."""
    parts = [part.replace(" ", "") for part in re.split(r" (?=[-+] )", text) if part]
    return sum((Fraction(part) for part in parts if not part.endswith("I")), Fraction(0))


def _number(text: str) -> Any:
    if "gamma" in text:
        return text
    parts = [part for part in re.split(r" (?=[-+] )", text) if part]
    total = mp.mpc(0)
    for part in parts:
        plain = part.replace(" ", "").removesuffix("*I")
        value = Fraction(plain)
        number = mp.mpf(value.numerator) / value.denominator
        total += mp.mpc(0, number) if part.endswith("I") else number
    return total if "I" in text else total.real


def _residual(detail: str) -> tuple[Any, Any]:
    """Return the middle and the error of a printed residual."""
    text = detail.partition("residual ")[2].partition(" excludes")[0]
    middle, error = mp.mpc(0), mp.mpf(0)
    for found in re.finditer(r"\[(\S+) \+/- (\S+)\](j?)|(-?[\d.]+(?:e[-+]?\d+)?)(j?)", text):
        value = mp.mpf(found[1] or found[4])
        middle += mp.mpc(0, 1) * value if found[3] or found[5] else value
        error += mp.mpf(found[2]) if found[2] else abs(value) * mp.mpf(10) ** -5
    return middle, error


def _with_own_function(
    reading: Reading, point: dict[str, Any], verdict: StatementVerdict
) -> Reading:
    """Return the reading with the function of a witness as the judge's."""
    text = str(point.pop("f", ""))
    if not text:
        return reading
    shift = Fraction(text.partition("+ ")[2].removesuffix(")"))

    class Own(Reading):
        def value(self, tree: Any, at: Point) -> Any:
            if tree[:2] == ("call", "f"):
                return mp.rgamma(
                    self.value(tree[2], at) + mp.mpf(shift.numerator) / shift.denominator
                )
            return super().value(tree, at)

    return Own(reading.equations, reading.solutions)


def _shown(point: Point) -> str:
    return ", ".join(f"{name} = {mp.nstr(value, 6)}" for name, value in point.items())


def judged(seed: int, index: int, hints: int) -> tuple[str, Made, list[str]]:
    """Return the outcome for a statement, and what is false."""
    given = random_statement(seed, index)
    try:
        with time_limit(LIMIT):
            statement = given.read()
            verdict = decide_statement(statement)
            if hints and verdict.outcome.value == "REFUTED" and not index % hints:
                verdict = with_hint(statement, verdict)
            judgement = Judgement(given, statement, seed, index)
            found = judgement.look(verdict)
            if not index % RESUMED:
                found = judgement.look_again(verdict)
    except OutOfTime:
        return "slow", given, []
    except FormulaError as error:
        return "unread", given, [f"cannot be read: {error}"]
    except Exception as error:  # a crash is a finding, not the end of the search
        return "error", given, [f"{type(error).__name__}: {error}"]
    kind = f"{verdict.outcome.value}{' with a hint' if verdict.hint else ''}"
    return kind, given, found


def solve_judged(seed: int, index: int) -> tuple[str, Solved, list[str]]:
    """Return the outcome of a solve, and what is false."""
    given = solved(seed, index)
    try:
        with time_limit(LIMIT):
            verdict = prove(given.equation, given.solution, solve=given.sought)
            assert isinstance(verdict, ConditionalVerdict)
            found = [*faults(given, verdict)]
    except OutOfTime:
        return "slow", given, []
    except Exception as error:  # a crash is a finding, not the end of the search
        return "error", given, [f"{type(error).__name__}: {error}"]
    return f"{verdict.outcome.value} solved", given, found


def main() -> int:
    """Read the options, search, print; 1 if anything is false."""
    parser = argparse.ArgumentParser(description="The opponent of words.")
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--minutes", type=float, default=60.0, help="where it stops, done or not")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--hints", type=int, default=8, help="every so many have a hint looked for")
    parser.add_argument("--solves", type=int, default=0, help="every so many are solves; 0: none")
    options = parser.parse_args()
    start, counts, false = time.monotonic(), Counter[str](), 0
    for index in range(options.count):
        if time.monotonic() - start > 60 * options.minutes:
            break
        given: Made | Solved
        if options.solves and not index % options.solves:
            outcome, given, found = solve_judged(options.seed, index)
        else:
            outcome, given, found = judged(options.seed, index, options.hints)
        counts[outcome] += 1
        false += bool(found)
        for fault in found:
            print(f"{options.seed} {index}: {fault}\n    {given.words}", flush=True)
    minutes = (time.monotonic() - start) / 60
    print(f"{counts.total()} statements in {minutes:.1f} min: {dict(counts)}; {false} false")
    return int(false > 0)


if __name__ == "__main__":
    sys.exit(main())

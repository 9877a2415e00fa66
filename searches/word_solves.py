"""Judgement of solved constants: each case holds, and "only if" leaves nothing out."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from mpmath import mp

from longwave.verify.proof.conditions import ConditionalVerdict
from searches.word_judge import DIGITS, CannotJudge, Reading, text_tree

LETTERS = "abckmw"

POINTS = 4
"""Points at which a case is looked at, and a value that would hold beside the cases."""

SAME = mp.mpf(10) ** -8

SOLVED = (
    ("u_x - 2*I*u/(1 + x**2)", "a*sign(1 + I*x)**2", "a"),
    ("I*u_t + w*u", "exp(I*c*t)*({h})", "w"),
    ("I*u_t + u_xx - b*u", "exp(I*(k*x - w*t))*({h})", "w"),
    ("I*u_t + u_xx + 2*abs(u)**2*u", "a*sech(a*x)*({h})*exp(I*w*t)", "w"),
    ("I*u_t + u_xx + 2*abs(u)**2*u", "a*sech(a*(x - 4*t))*({h})*exp(I*w*t)", "w"),
    ("u_t + c*u_x", "exp(k*x - w*t)*({h})", "w"),
    ("u_tt - c*u_xx", "cos(k*x - w*t)*({h})", "c"),
    ("u_t + c*u_x", "abs(x - w*t)*({h})", "c"),
    ("u_x - b*u", "a*exp(c*x)*({h})", "c"),
    ("u_x - b", "a*x*({h})", "a"),
    ("u_t - b*u_xx", "exp(c*t)*sin(k*x)*({h})", "c"),
    ("u - b", "a*({h})", "a"),
    ("u_x - b*sign(x)", "a*abs(x)*({h})", "a"),
)
"""Equations, formulas with a place for what SymPy misreads, and what is to be solved for."""

PLACES = (
    *("1", "sign(exp(I*x))**2", "sign(exp(I*t))**2", "sign(exp(2*I*t))", "abs(exp(I*x))"),
    *("sign(1 + I*x)**2", "sign(k)**2", "abs(m)/m", "sqrt(x**2)", "sign(x)", "re(exp(I*t))"),
    *("conjugate(exp(I*t))", "0*x + 1", "1 + 0/x", "sign(exp(I*x))*sign(exp(-I*x))"),
)


@dataclass(frozen=True)
class Solved:
    """A statement with a constant to be solved for."""

    equation: str
    solution: str
    sought: str

    @property
    def words(self) -> str:
        """The statement as arguments of `prove`."""
        return f"{self.equation!r}, {self.solution!r}, solve={self.sought!r}"

    @property
    def reading(self) -> Reading:
        """The judge's reading of the texts."""
        formula = self.solution.partition("=")[2]
        trees = (text_tree(text, "xtn", ("u",)) for text in (self.equation, formula))
        equation, solution = trees
        return Reading([equation], {"u": solution})


def solved(seed: int, index: int) -> Solved:
    """Return the statement of a number, the same each time."""
    draw = random.Random(f"solves:{seed}:{index}")
    equation, formula, sought = draw.choice(SOLVED)
    return Solved(equation, f"u = {formula.format(h=draw.choice(PLACES))}", sought)


def faults(given: Solved, verdict: ConditionalVerdict, seed: int = 0) -> Iterator[str]:
    """Yield false cases, and values that hold although the answer excludes them."""
    draw = random.Random(f"{given.words}{seed}")
    cases = [case.json() for case in verdict.cases if case.proved or case.trivial]
    reading = given.reading
    for case in cases:
        if not case["unsolved"]:
            yield from _of_case(reading, case, draw)
    answer = " ".join(verdict.lines())
    is_all = "only if" in answer or "no value" in answer
    if (
        is_all
        and verdict.outcome.value != "UNDECIDED"
        and not (verdict.left_out or verdict.unknown)
    ):
        yield from _left_out(given, cases, draw)


def _of_case(reading: Reading, case: Mapping[str, Any], draw: random.Random) -> Iterator[str]:
    values = {name: text_tree(text, "", ()) for name, text in case["values"].items()}
    own = Reading(reading.equations, reading.solutions, values)
    for _ in range(3 * POINTS):
        point = _point(draw)
        try:
            if all(_holds(own, text, point) for text in case["where"]) and not own.holds(point):
                yield f"the case {case['values']} fails at {point}"
                return
        except (CannotJudge, ValueError, ZeroDivisionError, OverflowError):
            continue


def _holds(reading: Reading, condition: str, point: Mapping[str, Any]) -> bool:
    if " is " in condition:
        raise CannotJudge(condition)
    left, sign, right = re.split(r"\s*(<=|>=|!=|<|>)\s*", condition, maxsplit=1)
    gap = reading.value(text_tree(f"({left}) - ({right})", "", ()), point)
    return {"<": gap < 0, ">": gap > 0, "<=": gap <= 0, ">=": gap >= 0, "!=": gap != 0}[sign]


def _left_out(
    given: Solved, cases: Sequence[Mapping[str, Any]], draw: random.Random
) -> Iterator[str]:
    """Yield a real value with which the residual vanishes at all points, and which no case has."""
    reading, fixed = given.reading, _point(draw)
    points = [{**fixed, "x": p["x"], "t": p["t"]} for p in (_point(draw) for _ in range(POINTS))]
    for start in map(mp.mpf, (-3.5, -1, -0.25, 0.25, 1, 2, 3.5)):
        with suppress(CannotJudge, ValueError, ZeroDivisionError, OverflowError, TypeError):
            value = _root(reading, points[0], given.sought, start)
            real = abs(value.imag) < SAME and all(
                reading.holds({**point, given.sought: value.real}) for point in points
            )
            if real and not any(_is(case, given.sought, value.real, fixed) for case in cases):
                words = ", ".join(f"{name} = {mp.nstr(v, 6)}" for name, v in fixed.items())
                yield f"{given.sought} = {mp.nstr(value.real, 8)} is in no case, for {words}"
                return


def _root(reading: Reading, point: Mapping[str, Any], sought: str, start: Any) -> Any:
    """Return a value of the constant near one with which the residual is 0 at a point."""
    if reading.holds({**point, sought: start}):
        return mp.mpc(start)

    def residual(value: Any) -> Any:
        return reading.residuals({**point, sought: value})[0][0]

    with mp.workdps(DIGITS):
        return mp.mpc(mp.findroot(residual, (start, start + 0.1), maxsteps=60))


def _is(case: Mapping[str, Any], sought: str, value: Any, fixed: Mapping[str, Any]) -> bool:
    """Return whether a point with a value is in a case; where that is not known it is."""
    point = {**fixed, sought: value}
    if case["unsolved"]:
        return True
    values = {name: text_tree(text, "", ()) for name, text in case["values"].items()}
    gaps = (Reading([], {}).value(tree, point) - point[name] for name, tree in values.items())
    return all(abs(gap) < SAME * (1 + abs(value)) for gap in gaps)


def _point(draw: random.Random) -> dict[str, Any]:
    return {name: mp.mpf(draw.randint(-499, 499) or 1) / 211 for name in (*LETTERS, "x", "t")}

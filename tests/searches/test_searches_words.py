"""The opponent of words finds what was false once, and nothing today."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
import sympy as sp
from mpmath import mp

from longwave.verify.proof import statement_verdict, stored_verdict
from longwave.verify.proof.conditions import ConditionalVerdict
from longwave.verify.proof.near_misses import with_hint
from longwave.verify.proof.seams import seams
from longwave.verify.proof.statement_scope import scope
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import (
    StatementVerdict,
    decide_statement,
    verified_sentence,
)
from longwave.verify.proof.text_prover import prove
from longwave.verify.proof.typed_statement import Statement
from longwave.verify.verdict import Outcome
from searches import word_solves, words
from searches.word_judge import Reading, latex_tree, text_tree
from searches.word_solves import Solved
from searches.words import Made, judged, random_statement

COUNT = 12


def stated(equation: str, solution: str, parameters: str = "", **ranges: tuple[int, int]) -> Made:
    kinds = {name: "integer" if name in "nk" else "real" for name in ranges}
    return Made(equation, solution, parameters, "", ranges, kinds)


@pytest.mark.parametrize("index", range(COUNT))
def test_nothing_is_false_today(index: int) -> None:
    outcome, given, faults = judged(3, index, 4)
    assert outcome != "error", given
    assert not faults


def test_a_jump_where_an_arbitrary_function_of_a_parameter_is_0_is_in_the_sentence() -> None:
    """Catches: places read without the declared functions, a FormulaError instead of a sentence."""
    statement = read_statement("u_x - 1", "u = x*sign(f(m))**2", "m: m<0; f: function")
    verdict = decide_statement(statement)
    assert verdict.outcome == "PROVED"
    last = verified_sentence(statement, verdict).splitlines()[-1]
    assert last.endswith(r"nothing is said at $f\left(m\right) = 0$.")


def test_a_statement_is_the_same_each_time() -> None:
    assert random_statement(3, 5) == random_statement(3, 5)


READINGS = [
    ("-x**2/4 + 2*x*(t - 1)", r"-\frac{x^{2}}{4} + 2 x \left(t - 1\right)"),
    (
        "sech(k1*x)**2*exp(-I*x)",
        r"\operatorname{sech}^{2}\left(k_{1} x\right) \mathrm{e}^{-\mathrm{i} x}",
    ),
    ("abs(x)**3/sqrt(1 + x**2)", r"\frac{\left|x\right|^{3}}{\sqrt{1 + x^{2}}}"),
    ("2**x*conjugate(x + I)", r"2^{x} \overline{x + \mathrm{i}}"),
]


@pytest.mark.parametrize(("text", "latex"), READINGS)
def test_both_readings_have_the_same_values(text: str, latex: str) -> None:
    trees = text_tree(text, "xt", ()), latex_tree(latex, "xt", (), ())
    point = {"x": mp.mpf(7) / 5, "t": mp.mpf(2) / 3, "k1": mp.mpf(3) / 7}
    left, right = (Reading([], {}).value(tree, point) for tree in trees)
    assert abs(left - right) < 1e-12


def test_derivatives_and_sites_are_read() -> None:
    equation = text_tree("u_xx - diff(u, x, 2) + u_t", "xtn", ("u",))
    reading = Reading([equation], {"u": text_tree("x**2*t", "xtn", ("u",))})
    ((value, _),) = reading.residuals({"x": mp.mpf(3), "t": mp.mpf(2)})
    assert abs(value - 9) < 1e-12
    shown = latex_tree(r"u_{n+1, t} - u_{n}", "xtn", ("u",), ())
    ((value, _),) = Reading([shown], {"u": text_tree("n*t", "xtn", ("u",))}).residuals(
        {"n": mp.mpf(4), "t": mp.mpf(3)}
    )
    assert abs(value - (5 - 12)) < 1e-12


def test_residuals_follow_a_point_that_is_changed() -> None:
    reading = Reading([text_tree("u", "xtn", ("u",))], {"u": text_tree("x**2", "xtn", ("u",))})
    point = {"x": mp.mpf(2)}
    assert [reading.residuals(point)[0][0] for _ in range(2)] == [4, 4]
    point["x"] = mp.mpf(3)
    assert reading.residuals(point)[0][0] == 9


def as_sympy_reads(statement: Statement) -> str:
    return ", ".join(f"u = {sp.latex(f)}" for f in statement.solutions.values())


def real_names(statement: Statement) -> Any:
    symbols = {s.name for f in statement.solutions.values() for s in f.free_symbols} | {"x"}
    return replace(scope(statement), kinds={"real": sorted(symbols)})


REFUTED = statement_verdict.refuted


def of_sympy(statement: Statement, witness: Any) -> StatementVerdict | None:
    found = REFUTED(statement, witness)
    return found and replace(found, detail="residual 2.00000 excludes 0")


def unproved(statement: Statement, verdict: StatementVerdict) -> StatementVerdict:
    return replace(verdict, hint="it holds with -x in the place of x: u = -x*sign(exp(I*x))**2")


def everywhere(statement: Statement, verdict: StatementVerdict) -> StatementVerdict:
    found = with_hint(statement, verdict)
    front, text = found.hint.partition(", on")[0], found.hint.rpartition(": ")[2]
    return replace(found, hint=f"{front}: {text}")


def seams_alone(statement: Statement) -> Any:
    return seams(statement), ()


def believed(statement: Statement, record: Any) -> StatementVerdict:
    found = stored_verdict.undecided(statement, "as it was")
    return replace(
        found, outcome=Outcome(record["verdict"]), witness=record["witness"], hint=record["hint"],
        assumptions=tuple(record["assumptions"]), certificate={},
    )  # fmt: skip


MISREAD = stated("u_x + 1", "u = x*sign(exp(I*x))**2", x=(-3, 3))
CANCELS = stated("u - 1", "u = abs(m)/m + 0*x", "m: m>0", m=(0, 3), x=(-3, 3))
PARITY = stated("diff(u[n], t)", "u = (-1)**n", n=(-7, 8), t=(-3, 3))
MOVING = stated("u_t + u_x", "u = abs(x + t)", t=(-3, 3), x=(-3, 3))
FACTOR = stated("u - 1", "u = sign(m*x)**2", m=(-3, 3), x=(-3, 3))
ONCE: dict[str, tuple[Made, list[tuple[Any, str, Callable[..., Any]]]]] = {
    "LaTeX": (MISREAD, [(statement_verdict, "formulas_latex", as_sympy_reads)]),
    "names": (CANCELS, [(statement_verdict, "scope", real_names)]),
    "sites": (PARITY, [(statement_verdict, "scope", real_names)]),
    "residual": (MISREAD, [(statement_verdict, "refuted", of_sympy)]),
    "hint": (MISREAD, [(words, "with_hint", unproved)]),
    "open hint": (MOVING, [(words, "with_hint", everywhere)]),
    "factor": (FACTOR, [(statement_verdict, "left_open", seams_alone)]),
    "resumption": (CANCELS, [(words, "checked_again", believed)]),
    "places": (
        stated("u[n] - 1", "u = sign(n - 3)**2", n=(2, 4)),
        [(statement_verdict, "left_open", lambda _: ((), ()))],
    ),
}
"""What was false once: a statement, and what makes it so again."""


@pytest.mark.parametrize("fault", ONCE)
def test_what_was_false_is_found_when_it_is_put_back(
    fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    given, changes = ONCE[fault]
    monkeypatch.setattr(words, "random_statement", lambda seed, index: given)
    outcome, _, faults = judged(0, 0, 1)
    assert outcome.split()[0] in ("PROVED", "REFUTED")
    assert not faults
    for module, name, wrong in changes:
        monkeypatch.setattr(module, name, wrong)
    assert judged(0, 0, 1)[2]


@pytest.mark.parametrize(
    ("equation", "solution", "wanted"),
    [
        ("u_t + c*u_x", "u = exp(k*x - w*t)", "w"),
        ("u_x - b*u", "u = a*exp(c*x)*sign(1 + x**2)", "c"),
        ("I*u_t + u_xx - b*u", "u = exp(I*(k*x - w*t))", "w"),
    ],
)
def test_a_case_that_is_left_out_or_wrong_is_found(
    equation: str, solution: str, wanted: str
) -> None:
    given = Solved(equation, solution, wanted)
    verdict = prove(equation, solution, solve=wanted)
    assert isinstance(verdict, ConditionalVerdict)
    assert verdict.outcome == "PROVED"
    assert not [*word_solves.faults(given, verdict)]
    nothing = replace(verdict, cases=tuple(c for c in verdict.cases if c.trivial))
    nothing = replace(nothing, detail=nothing.words())
    assert "is in no case" in " ".join(word_solves.faults(given, nothing))
    (first, *_) = verdict.cases
    wrong = replace(first, values={s: value + 1 for s, value in first.values.items()})
    (fault, *_) = word_solves.faults(given, replace(verdict, cases=(wrong,)))
    assert fault.startswith("the case")


def test_a_hint_in_the_equation_is_read_with_what_it_leaves_open() -> None:
    """Catches: an equation of a hint that is read as a solution where places are named before."""
    outcome, given, faults = judged(401, 5432, 1)
    assert (outcome, given.equation, faults) == (
        "REFUTED with a hint",
        "u[n+1] - u[n] - 1",
        [],
    )

"""The search for wrong verdicts, and that it sees the wrong ones."""

import random
from collections.abc import Callable
from dataclasses import replace

import pytest
import sympy as sp

from longwave.verify.verdict import Outcome, ProofVerdict
from searches import verdict_search as verdicts
from searches.statements.library import statement
from searches.statements.random_statement import RandomStatement, SymbolRange, Truth
from searches.verdict_search import (
    HEADINGS,
    Judgement,
    Mark,
    judge,
    judgements,
    tallies,
)

x = sp.Symbol("x", real=True)
u = sp.Function("u")(x)
UNDECIDED_SHARE = 0.02
"""Measured: 0.016 (seed 6, 4000 statements)."""

RIGHT = RandomStatement(
    "by hand", Truth.TRUE, u.diff(x) - u, sp.exp(x), (x,), (SymbolRange(x),), unknown=u
)
FALSE = replace(RIGHT, truth=Truth.FALSE, left=u.diff(x) - 2 * u, counterexample={x: sp.S.One})
VOID = replace(RIGHT, truth=Truth.VOID, right=1 / (sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1))


def findings(found: list[Judgement]) -> list[str]:
    bad = [j for j in found if j.mark in (Mark.WRONG, Mark.ERROR, Mark.SLOW)]
    return [f"{j.mark}: {j.words}\n{statement(j.seed, j.index).script()}" for j in bad]


def test_no_verdict_on_thirty_statements_is_wrong() -> None:
    assert findings(list(judgements(2, range(30)))) == []


@pytest.mark.slow
@pytest.mark.parametrize("start", range(0, 2000, 1000))
def test_no_verdict_on_many_statements_is_wrong(start: int) -> None:
    found = list(judgements(1, range(start, start + 300)))
    assert findings(found) == []
    total = tallies(found)[-1]
    assert total.undecided_supported <= UNDECIDED_SHARE * total.supported


def test_the_judge_knows_right_from_wrong() -> None:
    assert judge(RIGHT).mark is Mark.RIGHT
    assert judge(FALSE).mark is Mark.RIGHT
    assert judge(VOID).mark is Mark.RIGHT
    assert judge(replace(RIGHT, truth=Truth.FALSE)).mark is Mark.WRONG
    assert judge(replace(FALSE, truth=Truth.TRUE)).mark is Mark.WRONG
    assert judge(replace(RIGHT, truth=Truth.VOID)).mark is Mark.WRONG


def answer(outcome: Outcome, **rest: object) -> Callable[[RandomStatement], ProofVerdict]:
    verdict = ProofVerdict("by hand", "by hand", "none", outcome, "none", **rest)  # type: ignore[arg-type]
    return lambda given: verdict


@pytest.mark.parametrize(
    ("given", "said", "mark"),
    [
        (FALSE, answer(Outcome.REFUTED, witness={"x": "1/3"}), Mark.RIGHT),
        (FALSE, answer(Outcome.PROVED, certificate={"format": "none"}), Mark.WRONG),
        (VOID, answer(Outcome.PROVED, certificate={"format": "none"}), Mark.WRONG),
        (VOID, answer(Outcome.REFUTED, witness={"x": "1/3"}), Mark.WRONG),
        (VOID, answer(Outcome.UNDECIDED), Mark.RIGHT),
        (RIGHT, answer(Outcome.UNDECIDED), Mark.UNDECIDED),
        (RIGHT, answer(Outcome.REFUTED, witness={"x": "1/3"}), Mark.WRONG),
        (
            replace(FALSE, ranges=(SymbolRange(x, sp.S.Zero),)),
            answer(Outcome.REFUTED, witness={"x": "-1/3"}),
            Mark.WRONG,
        ),
        (
            replace(FALSE, left=u.diff(x) - u + x - sp.Rational(1, 3)),
            answer(Outcome.REFUTED, witness={"x": "1/3"}),
            Mark.WRONG,
        ),
    ],
)
def test_an_answer_has_its_mark(
    monkeypatch: pytest.MonkeyPatch,
    given: RandomStatement,
    said: Callable[[RandomStatement], ProofVerdict],
    mark: Mark,
) -> None:
    monkeypatch.setattr(verdicts, "ask", said)
    assert judge(given).mark is mark


def test_a_prover_with_the_words_exchanged_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each true statement REFUTED, each other one PROVED, and all of them reported."""

    def liar(given: RandomStatement) -> ProofVerdict:
        if given.truth is Truth.TRUE:
            point = given.point(random.Random(given.index))
            witness = {str(symbol): str(value) for symbol, value in point.items()}
            return answer(Outcome.REFUTED, witness=witness)(given)
        return answer(Outcome.PROVED, certificate={"format": "none"})(given)

    monkeypatch.setattr(verdicts, "ask", liar)
    found = list(judgements(2, range(30)))
    assert {j.mark for j in found} == {Mark.WRONG}
    assert not [j.words for j in found if "against the label" in j.words]


def test_a_refutation_at_a_point_without_a_residual_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    nearly = replace(FALSE, left=u.diff(x) - u + (x - sp.Rational(1, 3)) / 10**200)
    for place, mark in (("1/3", Mark.WRONG), ("1/2", Mark.RIGHT)):
        monkeypatch.setattr(verdicts, "ask", answer(Outcome.REFUTED, witness={"x": place}))
        assert judge(nearly).mark is mark


def test_a_wrong_label_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(verdicts, "ask", answer(Outcome.REFUTED, witness={"x": "1/3"}))
    found = judge(replace(FALSE, truth=Truth.TRUE))
    assert found.mark is Mark.WRONG
    assert "against the label: the residual" in found.words


def test_a_crash_and_a_hang_are_findings(monkeypatch: pytest.MonkeyPatch) -> None:
    def crash(given: RandomStatement) -> ProofVerdict:
        raise IndexError("list index out of range")

    def hang(given: RandomStatement) -> ProofVerdict:
        while True:
            pass

    monkeypatch.setattr(verdicts, "ask", crash)
    assert judge(RIGHT).mark is Mark.ERROR
    monkeypatch.setattr(verdicts, "ask", hang)
    assert judge(RIGHT, limit=0.1).mark is Mark.SLOW


def test_the_table_counts_by_kind() -> None:
    found = [
        Judgement("branch: one", Truth.TRUE, 0, 0, Mark.RIGHT, True, "", 0.01),
        Judgement("branch: two", Truth.TRUE, 0, 1, Mark.UNDECIDED, True, "no", 0.03),
        Judgement("source", Truth.TRUE, 0, 2, Mark.UNDECIDED, False, "no", 0.02),
    ]
    rows = [dict(zip(HEADINGS, made.cells(), strict=True)) for made in tallies(found)]
    assert [row["kind"] for row in rows] == ["branch", "source", "all"]
    assert [row["undecided"] for row in rows] == ["1", "1", "2"]
    assert [row["% undecided of supported"] for row in rows] == ["50.0", "0.0", "50.0"]
    assert rows[-1]["max ms"] == "30"

"""The search for wrong verdicts on text, and that it sees the wrong ones."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import pytest

from longwave.verify.verdict import Outcome, ProofVerdict
from searches import text_search
from searches.text_search import (
    HEADINGS,
    SEARCH_KINDS,
    Judgement,
    Mark,
    digest,
    judge_text,
    judged,
    kind_of,
    tallies,
)
from searches.texts.drafts import letter_of
from searches.texts.text_statement import TextStatement, Truth

FINDINGS = (Mark.WRONG, Mark.ERROR, Mark.SLOW)

X = (letter_of("x"),)
RIGHT = TextStatement("by hand", Truth.TRUE, ("u_x - u",), ("u = exp(x)",), X)
FALSE = replace(
    RIGHT, truth=Truth.FALSE, equations=("u_x - 2*u",), counterexample={"x": Fraction(1)}
)
VOID = replace(RIGHT, truth=Truth.VOID, solutions=("u = 1/(sin(x)**2 + cos(x)**2 - 1)",))


@pytest.mark.parametrize("kind", SEARCH_KINDS)
def test_no_verdict_on_a_few_texts_is_wrong(kind: str) -> None:
    found = [judged(kind, 2, index) for index in range(4)]
    assert [(j.index, j.words) for j in found if j.mark in FINDINGS] == []
    assert {kind_of(judgement) for judgement in found} == {kind}


@pytest.mark.slow
@pytest.mark.parametrize("kind", SEARCH_KINDS)
def test_no_verdict_on_many_texts_is_wrong(kind: str) -> None:
    found = [judged(kind, 3, index) for index in range(100)]
    wrong = [j for j in found if j.mark in (Mark.WRONG, Mark.ERROR)]
    assert [(j.index, j.mark, j.words) for j in wrong] == []


def test_the_search_knows_right_from_wrong() -> None:
    assert judge_text(RIGHT).mark is Mark.RIGHT
    assert judge_text(FALSE).mark is Mark.RIGHT
    assert judge_text(VOID).mark is Mark.RIGHT
    assert judge_text(replace(RIGHT, truth=Truth.FALSE)).mark is Mark.WRONG
    assert judge_text(replace(RIGHT, truth=Truth.VOID)).mark is Mark.WRONG
    assert judge_text(replace(FALSE, truth=Truth.TRUE)).mark is Mark.ERROR
    assert judge_text(replace(RIGHT, equations=("u_x ^ u",))).mark is Mark.UNDECIDED


def answer(outcome: Outcome, **rest: object) -> Callable[[TextStatement], ProofVerdict]:
    verdict = ProofVerdict("by hand", "by hand", "none", outcome, "none", **rest)  # type: ignore[arg-type]
    return lambda given: verdict


@pytest.mark.parametrize(
    ("given", "said", "mark"),
    [
        (FALSE, answer(Outcome.REFUTED, witness={"x": "1/3"}), Mark.RIGHT),
        (FALSE, answer(Outcome.REFUTED, witness={}), Mark.RIGHT),
        (FALSE, answer(Outcome.PROVED, certificate={"format": "none"}), Mark.WRONG),
        (VOID, answer(Outcome.PROVED, certificate={"format": "none"}), Mark.WRONG),
        (VOID, answer(Outcome.REFUTED, witness={"x": "1/3"}), Mark.WRONG),
        (VOID, answer(Outcome.UNDECIDED), Mark.RIGHT),
        (RIGHT, answer(Outcome.UNDECIDED), Mark.UNDECIDED),
        (RIGHT, answer(Outcome.REFUTED, witness={"x": "1/3"}), Mark.WRONG),
        (
            replace(FALSE, letters=(letter_of("x>0"),)),
            answer(Outcome.REFUTED, witness={"x": "-1/3"}),
            Mark.WRONG,
        ),
        (
            replace(FALSE, equations=("u_x - u + x - 1/3",)),
            answer(Outcome.REFUTED, witness={"x": "1/3"}),
            Mark.WRONG,
        ),
        (
            replace(FALSE, solutions=("u = abs(x)",)),
            answer(Outcome.REFUTED, witness={"x": "0"}),
            Mark.UNJUDGED,
        ),
    ],
)
def test_an_answer_has_its_mark(
    monkeypatch: pytest.MonkeyPatch,
    given: TextStatement,
    said: Callable[[TextStatement], ProofVerdict],
    mark: Mark,
) -> None:
    monkeypatch.setattr(text_search, "ask_text", said)
    assert judge_text(given).mark is mark


def test_a_crash_and_a_long_thought_are_findings(monkeypatch: pytest.MonkeyPatch) -> None:
    def crash(given: TextStatement) -> ProofVerdict:
        raise RecursionError("by hand")

    def think(given: TextStatement) -> ProofVerdict:
        while True:
            pass

    monkeypatch.setattr(text_search, "ask_text", crash)
    assert judge_text(RIGHT).mark is Mark.ERROR
    monkeypatch.setattr(text_search, "ask_text", think)
    assert judge_text(RIGHT, limit=0.1).mark is Mark.SLOW


def test_the_digest_is_of_what_was_found_not_of_its_order() -> None:
    found = [judged(kind, 0, index) for kind in SEARCH_KINDS[:2] for index in range(2)]
    assert digest(found) == digest(list(reversed(found)))
    other = [replace(found[0], mark=Mark.SLOW), *found[1:]]
    assert digest(found) != digest(other)


def test_the_table_counts_by_kind() -> None:
    found = [
        Judgement("branch: one", Truth.TRUE, 0, 0, Mark.RIGHT, "", 0.01),
        Judgement("branch: two", Truth.TRUE, 0, 1, Mark.UNDECIDED, "no", 0.03),
        Judgement("source", Truth.TRUE, 0, 2, Mark.RIGHT, "", 0.02),
    ]
    rows = [dict(zip(HEADINGS, made.cells(), strict=True)) for made in tallies(found)]
    assert [row["kind"] for row in rows] == ["branch", "source", "all"]
    assert [row["undecided"] for row in rows] == ["1", "0", "1"]
    assert [row["% undecided"] for row in rows] == ["50.0", "0.0", "33.3"]
    assert rows[-1]["max ms"] == "30"

"""The search for wrong verdicts on roots and special values: its judge, and a short run."""

from random import Random

import pytest

from longwave.verify.kernel import root_rules
from searches.known_values import BASES, KnownValue, search

X, ONE_MORE, ONE_LESS = BASES[0], BASES[2], BASES[4]


def judged(statement: KnownValue) -> bool:
    return statement.is_true(Random("points"))


@pytest.mark.parametrize(("domain", "holds"), [("", False), ("x > 1", True), ("x < -1", False)])
def test_the_judge_knows_on_which_side_a_product_of_roots_is_one(domain: str, holds: bool) -> None:
    left = ONE_MORE.power(1, 2) * ONE_LESS.power(1, 2)
    right = (ONE_MORE * ONE_LESS).power(1, 2)
    assert judged(KnownValue("roots", left, right, "a: real", domain)) is holds


def test_the_judge_tells_a_sign_and_a_branch() -> None:
    sides = (X.power(1, 4).power(2, 1), X.power(1, 2)), (X.power(2, 1).power(1, 2), X)
    assert judged(KnownValue("roots", *sides[0], "a: real", ""))
    assert not judged(KnownValue("roots", *sides[1], "a: real", ""))
    assert not judged(KnownValue("roots", X, -X, "a: real", "x > 0"))


@pytest.mark.slow
def test_no_verdict_is_wrong() -> None:
    counts, wrong, _ = search(30, 7)
    assert not wrong
    assert counts["roots", "true", "checker True"] > 0


@pytest.mark.slow
def test_the_search_finds_a_root_without_its_branch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a search that could not find what it looks for."""
    monkeypatch.setattr(root_rules, "is_branch", lambda *_: True)
    _, wrong, _ = search(60, 3)
    assert any("ACCEPTED" in line for line in wrong)

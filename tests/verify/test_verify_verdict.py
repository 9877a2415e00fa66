"""Verdict record: a refutation has a witness, an undecided verdict a reason."""

import json

import pytest

from longwave.verify.verdict import Outcome, Verdict


def _verdict(outcome: Outcome, **fields: object) -> Verdict:
    return Verdict("kink", "defocusing mKdV", "residual", outcome, **fields)


def test_only_proved_and_checked_pass() -> None:
    fields = {"detail": "0.1", "witness": {"xi": "1/3"}}
    passed = {outcome for outcome in Outcome if _verdict(outcome, **fields).passed}
    assert passed == {Outcome.PROVED, Outcome.CHECKED}


def test_a_refutation_needs_a_witness() -> None:
    with pytest.raises(ValueError, match="witness must name the point"):
        _verdict(Outcome.REFUTED, detail="0.1")


def test_undecided_needs_a_reason() -> None:
    with pytest.raises(ValueError, match="detail must give the reason"):
        _verdict(Outcome.UNDECIDED, detail="")


def test_json_survives_a_round_trip() -> None:
    verdict = _verdict(Outcome.REFUTED, detail="0.1", residual=0.1, witness={"xi": "1/3"})
    record = json.loads(json.dumps(verdict.json()))
    assert record["outcome"] == "REFUTED"
    assert Verdict(**record | {"outcome": Outcome(record["outcome"])}) == verdict

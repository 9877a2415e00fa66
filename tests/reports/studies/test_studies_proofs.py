"""The records of the report: proofs, certificates; misprints and why some of them solve."""

import json

import pytest

from longwave.reports.studies import proofs
from longwave.reports.studies.proofs import proof_record
from longwave.solutions import closed_form
from longwave.verify.evidence.mutations import count_mutants, solution_reason
from longwave.verify.proof import CertificateError
from longwave.verify.verdict import Outcome
from tests.families import family


def test_a_record_has_the_proof_and_its_check() -> None:
    record = proof_record("wave_sn")
    assert record.outcome is Outcome.PROVED
    assert record.accepted is True
    assert record.certificate_bytes is not None
    assert record.check_seconds is not None
    assert record.method == "differential algebra"


def test_misprints_are_counted() -> None:
    count = count_mutants(closed_form("wave_sn"))
    assert (count.refuted, count.proved) == (18, 1)
    assert json.loads(json.dumps(count.json()))["undecided"] == 0


def test_a_proof_of_the_rational_family_is_checked_as_well() -> None:
    record = proof_record("rational_4")
    assert record.outcome is Outcome.PROVED
    assert record.accepted is True
    assert record.certificate_bytes is not None


def test_a_rejected_certificate_is_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    def reject(data: object) -> None:
        raise CertificateError("no")

    monkeypatch.setattr(proofs, "check_certificate", reject)
    assert proof_record("kink").accepted is False


@pytest.mark.parametrize(
    ("name", "reasons"),
    family(
        [
            ("kink", {"symmetry U to -U"}),
            ("wave_sn", {"symmetry U to -U"}),
            ("soliton_dn", {"bare wave"}),
            ("rational_1", {"constant"}),
        ],
        slow=("soliton_dn",),
    ),
)
def test_a_misprint_that_solves_has_a_reason(name: str, reasons: set[str]) -> None:
    assert {survivor.reason for survivor in count_mutants(closed_form(name)).survivors} == reasons


def test_a_shift_is_another_value_of_its_symbol() -> None:
    form = closed_form("breather_sn")
    shift = next(p.symbol for p in form.parameters if p.name == "X_0")
    moved = form.expression.subs(shift, -shift)
    assert solution_reason(form, moved) == "another value of X_0"

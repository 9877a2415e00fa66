"""What the proofs cost: verdict, certificate, seconds to prove and to check, mutants."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from typing import Any

from verify.evidence.mutations import MutationCount, count_mutants
from verify.proof import CertificateError, check_certificate
from verify.proof.catalogue_proofs import NAMES, named_form, prove_named
from verify.verdict import Outcome


@dataclass(frozen=True)
class ProofRecord:
    """One form's proof.  Sizes in bytes of JSON; None where there is no certificate.

    ``accepted`` is the separate checker's answer; ``mutations`` is None if they were not asked for.
    """

    name: str
    equation: str
    method: str
    outcome: Outcome
    detail: str
    prove_seconds: float
    certificate_bytes: int | None
    check_seconds: float | None
    accepted: bool | None
    mutations: MutationCount | None

    def json(self) -> dict[str, Any]:
        """The record as plain data."""
        mutations = None if self.mutations is None else self.mutations.json()
        return asdict(self) | {"mutations": mutations}


def proof_record(name: str, *, mutations: bool = False) -> ProofRecord:
    """Prove the form called ``name`` and check its certificate; raises ValueError as `prove_named`.

    >>> record = proof_record("kink")
    >>> print(record.outcome, record.accepted)
    PROVED True
    """
    verdict = prove_named(name)
    text = verdict.certificate_text()
    accepted, seconds = (None, None) if text is None else _checked(text)
    return ProofRecord(
        name=verdict.name,
        equation=verdict.equation,
        method=verdict.method,
        outcome=verdict.outcome,
        detail=verdict.detail,
        prove_seconds=verdict.seconds,
        certificate_bytes=verdict.certificate_bytes,
        check_seconds=seconds,
        accepted=accepted,
        mutations=count_mutants(named_form(name)) if mutations else None,
    )


def proof_records(
    names: Iterable[str] = NAMES, *, mutations: bool = False
) -> Iterator[ProofRecord]:
    """The records of the forms called ``names``, one after the other as they are made."""
    for name in names:
        yield proof_record(name, mutations=mutations)


def _checked(certificate: str) -> tuple[bool, float]:
    """The checker's answer on the text of a certificate, and the seconds it took."""
    start = time.perf_counter()
    try:
        check_certificate(json.loads(certificate))
    except CertificateError:
        return False, time.perf_counter() - start
    return True, time.perf_counter() - start

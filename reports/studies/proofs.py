"""What the proofs cost: verdict, certificate, seconds to prove and to check."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass

from longwave.support.processes import Job, Key
from longwave.verify.proof import CertificateError, check_certificate
from longwave.verify.proof.catalogue_proofs import NAMES, prove_named
from longwave.verify.verdict import Outcome


@dataclass(frozen=True)
class ProofRecord:
    """One form's proof.  Sizes in bytes of JSON; None where there is no certificate.

    ``accepted`` is the separate checker's answer.
    """

    name: str
    method: str
    outcome: Outcome
    prove_seconds: float
    certificate_bytes: int | None
    check_seconds: float | None
    accepted: bool | None


def proof_record(name: str) -> ProofRecord:
    """Prove the form called ``name`` and check its certificate; raises ValueError as `prove_named`.

    >>> record = proof_record("kink")
    >>> print(record.outcome, record.accepted)
    PROVED True
    """
    verdict = prove_named(name)
    found = verdict.certificate
    accepted, seconds = (None, None) if found is None else _checked(json.dumps(found))
    return ProofRecord(
        verdict.name,
        verdict.method,
        verdict.outcome,
        verdict.seconds,
        verdict.certificate_bytes,
        seconds,
        accepted,
    )


def _checked(certificate: str) -> tuple[bool, float]:
    """The checker's answer on the text of a certificate, and the seconds it took."""
    start = time.perf_counter()
    try:
        check_certificate(json.loads(certificate))
    except CertificateError:
        return False, time.perf_counter() - start
    return True, time.perf_counter() - start


def proof_jobs() -> dict[Key, Job]:
    """Every proof of the report."""
    return {("proof", name): Job(proof_record, (name,), 0.5) for name in NAMES}

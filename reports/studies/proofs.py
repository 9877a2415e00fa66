"""Cost of proving the closed forms, and verdicts on the library of published solutions."""

from __future__ import annotations

import json
import time
from contextlib import suppress
from dataclasses import dataclass

from longwave.reports.formulas.typed import statement_parts
from longwave.support.processes import Job, Key, OutOfTime, time_limit
from longwave.verify.problem_file import ProblemText
from longwave.verify.proof import CertificateError, check_certificate
from longwave.verify.proof.catalogue_proofs import NAMES, prove_named
from longwave.verify.proof.statement_verdict import decide_statement
from longwave.verify.published import chosen, published
from longwave.verify.verdict import Outcome


@dataclass(frozen=True)
class ProofRecord:
    """Proof of one form: times in seconds, size in bytes of JSON; None without a certificate.

    ``accepted`` is the answer of the separate checker.
    """

    name: str
    method: str
    outcome: Outcome
    prove_seconds: float
    certificate_bytes: int | None
    check_seconds: float | None
    accepted: bool | None


def proof_record(name: str) -> ProofRecord:
    """Prove the form called ``name`` and check its certificate. Raises as `prove_named` does.

    >>> record = proof_record("kink")
    >>> print(record.outcome, record.accepted)
    PROVED True
    """
    verdict = prove_named(name)
    certificate = verdict.certificate
    accepted, seconds = (None, None) if certificate is None else _checked(json.dumps(certificate))
    proof = verdict.name, verdict.method, verdict.outcome, verdict.seconds
    return ProofRecord(*proof, verdict.certificate_bytes, seconds, accepted)


def _checked(certificate: str) -> tuple[bool, float]:
    """Return whether the checker accepts a certificate's text, and the seconds it took."""
    start, accepted = time.perf_counter(), False
    with suppress(CertificateError):
        check_certificate(json.loads(certificate))
        accepted = True
    return accepted, time.perf_counter() - start


def proof_jobs() -> dict[Key, Job]:
    """Return the jobs of every proof in the report."""
    return {("proof", name): Job(proof_record, (name,), 0.5) for name in NAMES}


LIMIT = 60.0
"""Time limit for one statement, in processor seconds."""

STATEMENT_WEIGHT = 0.1
"""Expected seconds for deciding one statement (343 took 37 s with 8 processes on 2 cores)."""


@dataclass(frozen=True)
class PublishedVerdict:
    """Statement of the library with its verdict; equations, formulas and conditions in LaTeX."""

    text: ProblemText
    outcome: Outcome
    seconds: float
    equations: tuple[str, ...] = ()
    formulas: tuple[str, ...] = ()
    conditions: tuple[str, ...] = ()

    @property
    def expected(self) -> bool:
        """Whether the verdict is the one that the library expects."""
        return self.outcome == self.text.expect


def published_verdicts(equation_name: str) -> list[PublishedVerdict]:
    """Decide the library's statements on one equation. Raises as `chosen` does.

    >>> found = published_verdicts("thin film")
    >>> [(verdict.text.name, verdict.expected) for verdict in found]
    [('thin_film_source', True), ('thin_film_source_factor', True)]
    """
    return [_decided(text) for text in chosen([equation_name])]


def _decided(text: ProblemText) -> PublishedVerdict:
    statement = text.problem().statement
    outcome, seconds = Outcome.UNDECIDED, LIMIT
    with suppress(OutOfTime), time_limit(LIMIT):
        verdict = decide_statement(statement)
        outcome, seconds = verdict.outcome, verdict.seconds
    return PublishedVerdict(text, outcome, seconds, *statement_parts(statement))


def library_jobs() -> dict[Key, Job]:
    """Return the jobs that decide the library, one for each equation."""
    names = [text.equation_name for text in published()]
    return {
        ("library", name): Job(published_verdicts, (name,), STATEMENT_WEIGHT * names.count(name))
        for name in dict.fromkeys(names)
    }

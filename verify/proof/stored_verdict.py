"""Store verdicts as plain data, and read them back only as far as they can be checked again.

A proof's certificates are checked again and must state the statement's own texts.  At a
refutation's witness a ball around the residual must exclude 0 again.  The details of both, and the
hint of a refutation, are computed again from the statement.  The reason of an undecided verdict is
copied from the record, and says so.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import sympy as sp

from longwave.verify.kernel.check import check_certificate
from longwave.verify.kernel.limits import CertificateError
from longwave.verify.verdict import Outcome

from .certificate_writer import as_data
from .near_misses import near_misses
from .statement_problem import typed_domains
from .statement_verdict import StatementVerdict, proved, refuted, undecided
from .typed_statement import Statement, StatementTexts

FROM_FILE = "as an earlier run said, not decided again: "


def verdict_record(verdict: StatementVerdict) -> dict[str, Any]:
    """Return the verdict as plain data, with its certificates."""
    names = "certificates", "hint_certificates"
    return verdict.json() | {name: list(getattr(verdict, name)) for name in names}


def checked_again(statement: Statement, record: Mapping[str, Any]) -> StatementVerdict | None:
    """Return a stored verdict, checked again; None if invalid, weak or solved for parameters."""
    start = time.perf_counter()
    try:
        verdict = _checked(statement, record)
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError, CertificateError):
        return None
    return verdict and replace(verdict, seconds=time.perf_counter() - start)


def _checked(statement: Statement, record: Mapping[str, Any]) -> StatementVerdict | None:
    if statement.weak or statement.solve_for:
        return None
    match Outcome(record["verdict"]):
        case Outcome.PROVED:
            certificates = record["certificates"]
            accepted = is_proof_of(statement.texts, certificates)
            return proved(statement, certificates) if accepted else None
        case Outcome.REFUTED:
            return _refuted_again(statement, record)
        case Outcome.UNDECIDED:
            reason = "".join(c for c in record["reason"] if c.isprintable() or c.isspace())
            return undecided(statement, FROM_FILE + " ".join(reason.split()))
    return None


def is_proof_of(texts: StatementTexts, certificates: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether valid certificates state the texts, one per equation; raises if invalid."""
    if len(certificates) != len(texts.equations):
        return False
    for equation, certificate in zip(texts.equations, certificates, strict=True):
        if certificate["statement"] != as_data(replace(texts, equations=(equation,))):
            return False
        check_certificate(certificate)
    return True


def _refuted_again(statement: Statement, record: Mapping[str, Any]) -> StatementVerdict | None:
    domains, witness = typed_domains(statement), record["witness"]
    names = {*map(str, domains)} - {*statement.complexes}
    values = {s: sp.Rational(str(witness[str(s)])) for s in domains if str(s) in names}
    if not all(domains[s].contains(value, values) for s, value in values.items()):
        return None
    verdict = refuted(statement, witness)
    certificates = record["hint_certificates"]
    if verdict is None or not certificates:
        return verdict
    for miss in near_misses(statement):
        if certificates[0]["statement"]["solutions"] != list(miss.texts.solutions):
            continue
        if is_proof_of(miss.texts, certificates):
            return miss.hint(verdict, proved(miss.statement(statement.name), certificates))
    return verdict

"""Verdicts as plain data that outlive their process; taken again only as far as they are checked.

A proof's certificates are checked once more, and must be of the statement's own texts; at a
refutation's witness a ball around the residual must exclude 0 again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

import sympy as sp

from longwave.verify.kernel.check import check_certificate
from longwave.verify.kernel.limits import CertificateError
from longwave.verify.verdict import Outcome

from .certificate_writer import as_data
from .statement_problem import all_domains
from .statement_verdict import StatementVerdict, said_of
from .typed_statement import Statement
from .typed_values import TypedValues


def kept_record(verdict: StatementVerdict) -> dict[str, Any]:
    """The verdict as plain data, with its certificates."""
    return verdict.json() | {"certificates": list(verdict.certificates)}


def taken_again(statement: Statement, record: Mapping[str, Any]) -> StatementVerdict | None:
    """The verdict in a record of `kept_record`; None where it cannot be checked again.

    That is so for weak solutions, for values that are solved for, for complex ones, and for
    arbitrary functions.
    """
    if statement.weak:
        return None
    try:
        verdict = _of_record(statement, record)
        holds = {
            Outcome.PROVED: _is_proved,
            Outcome.REFUTED: _is_refuted,
            Outcome.UNDECIDED: lambda *_: True,
        }[verdict.outcome]
        return verdict if holds(statement, verdict) else None
    except (LookupError, TypeError, ValueError, AttributeError, CertificateError):
        return None


def _of_record(statement: Statement, record: Mapping[str, Any]) -> StatementVerdict:
    certificates = tuple(record["certificates"])
    return StatementVerdict(
        **said_of(statement),
        outcome=Outcome(record["verdict"]),
        detail=str(record["reason"]),
        witness=record["witness"],
        seconds=float(record["seconds"]),
        hint=str(record["hint"]),
        certificate=certificates[0] if certificates else None,
        certificates=certificates,
        assumptions=tuple(map(str, record["assumptions"])),
        singularities=tuple(map(str, record["singularities"])),
    )


def _is_proved(statement: Statement, verdict: StatementVerdict) -> bool:
    texts = statement.texts
    if texts is None or statement.wanted or len(verdict.certificates) != len(texts.equations):
        return False
    for equation, certificate in zip(texts.equations, verdict.certificates, strict=True):
        if certificate["statement"] != as_data(replace(texts, equations=(equation,))):
            return False
        check_certificate(certificate)
    return True


def _is_refuted(statement: Statement, verdict: StatementVerdict) -> bool:
    if statement.trees is None or statement.wanted or statement.complexes or statement.functions:
        return False
    domains = all_domains(statement, *statement.equations)
    witness = {name: Fraction(value) for name, value in (verdict.witness or {}).items()}
    values = {s: sp.Rational(str(witness[str(s)])) for s in domains}
    inside = all(domain.contains(values[s], values) for s, domain in domains.items())
    return inside and bool(TypedValues(statement.trees, domains).fails_at(witness))

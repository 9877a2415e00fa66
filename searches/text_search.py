"""The search for wrong verdicts on text: systems, complex fields, compositions, shifts.

The prover gets the texts alone, as a person would type them; what it answers is compared with what
the statement is by construction, and a witness with the residual that the judge finds there.
"""

from __future__ import annotations

import hashlib
import random
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from longwave.derive.algebra.formula_text import FormulaError
from longwave.verify.proof.text_prover import prove
from longwave.verify.verdict import Outcome, ProofVerdict
from searches.statements.library import statement
from searches.statements.random_statement import RandomStatement, Truth
from searches.texts.ball_judge import CannotJudge, Judge
from searches.texts.text_library import TEXT_KINDS, text_statement
from searches.texts.text_statement import TextStatement
from searches.verdict_search import LIMIT, Judgement, Mark, judge, marked_answer

SEARCH_KINDS = ("real", *TEXT_KINDS)
"""``real``: one real unknown, equations and formulas as SymPy objects."""


def ask_text(given: TextStatement) -> ProofVerdict:
    """Return the prover's verdict on the texts."""
    return prove(
        list(given.equations),
        list(given.solutions),
        parameters=given.parameters,
        domain=given.domain,
    )


def judge_text(given: TextStatement, limit: float = LIMIT) -> Judgement:
    """Ask the prover and compare with the truth; every error is caught and told."""

    def refused(error: Exception) -> tuple[Mark, str] | None:
        if not isinstance(error, FormulaError):
            return None
        mark = Mark.RIGHT if given.truth is Truth.VOID else Mark.UNDECIDED
        return mark, f"refused: {error}"

    mark, words, seconds = marked_answer(
        lambda: ask_text(given), lambda verdict: marked_text(given, verdict), refused, limit
    )
    return Judgement(given.kind, given.truth, given.seed, given.index, mark, True, words, seconds)


def marked_text(given: TextStatement, verdict: ProofVerdict) -> tuple[Mark, str]:
    """Return whether a verdict is right, and why not."""
    outcome, truth = verdict.outcome, given.truth
    if outcome is Outcome.UNDECIDED:
        return (Mark.RIGHT if truth is Truth.VOID else Mark.UNDECIDED), verdict.detail
    if outcome is Outcome.PROVED:
        failure = "" if truth is Truth.VOID else f", but it fails at {point_text(given)}"
        return (Mark.RIGHT, "") if truth is Truth.TRUE else (Mark.WRONG, f"PROVED{failure}")
    witness = dict(verdict.witness or {})
    if truth is Truth.VOID:
        return Mark.WRONG, f"REFUTED at {witness}, where nothing is defined"
    return _witnessed(given, witness)


def point_text(given: TextStatement) -> str:
    """Return the counterexample of a false statement in words."""
    return ", ".join(f"{key} = {value}" for key, value in (given.counterexample or {}).items())


def _witnessed(given: TextStatement, witness: dict[str, str]) -> tuple[Mark, str]:
    """Return the worth of a refutation, by the residual at its witness.

    A letter that the witness leaves out may have any value of its range.
    """
    point = {**given.point(random.Random(given.index)), **_shown(given, witness)}
    if not given.holds_at(point):
        return Mark.WRONG, f"REFUTED at {witness}, which is not in the domain"
    try:
        fails = Judge(given).fails_at(point)
    except CannotJudge as reason:
        return Mark.UNJUDGED, f"REFUTED at {witness}; the judge cannot say: {reason}"
    if not fails:
        return Mark.WRONG, f"REFUTED at {witness}, where the residual is 0 as far as can be seen"
    if given.truth is Truth.TRUE:
        return Mark.ERROR, f"called true, but it fails at {witness}"
    return Mark.RIGHT, ""


def _shown(given: TextStatement, witness: dict[str, str]) -> dict[str, Fraction]:
    names = {letter.name for letter in given.letters} & witness.keys()
    return {name: Fraction(witness[name]) for name in names}


def any_statement(kind: str, seed: int, index: int) -> RandomStatement | TextStatement:
    """Return the statement of a kind of `SEARCH_KINDS`."""
    return statement(seed, index) if kind == "real" else text_statement(kind, seed, index)


def judged(kind: str, seed: int, index: int, limit: float = LIMIT) -> Judgement:
    """Return the judgement of that statement, labelled with its full kind."""
    given = any_statement(kind, seed, index)
    if isinstance(given, TextStatement):
        return judge_text(given, limit)
    return replace(judge(given, limit), kind=full_kind(kind, given))


def full_kind(kind: str, given: RandomStatement | TextStatement) -> str:
    """Return the kind of `SEARCH_KINDS` with the statement's own kind behind it."""
    return given.kind if isinstance(given, TextStatement) else f"{kind}: {given.kind}"


def kind_of(judgement: Judgement) -> str:
    """Return the kind of `SEARCH_KINDS` of a judged statement."""
    return judgement.kind.partition(":")[0]


def digest(found: Iterable[Judgement]) -> str:
    """Return a digest of the judgements, the same in any order."""
    lines = sorted(f"{j.kind} {j.seed} {j.index} {j.truth} {j.mark}" for j in found)
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]

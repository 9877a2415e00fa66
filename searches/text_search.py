"""The search for wrong verdicts on text: systems, complex fields, compositions, shifts.

The prover gets the texts alone, as a person would type them; what it answers is compared with what
the statement is by construction, and a witness with the residual that the judge finds there.
"""

from __future__ import annotations

import enum
import hashlib
import random
import statistics
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from longwave.derive.algebra.formula_text import FormulaError
from longwave.support.processes import OutOfTime, time_limit
from longwave.verify.proof.text_prover import prove
from longwave.verify.verdict import Outcome, ProofVerdict
from searches.statements.library import statement
from searches.texts.ball_judge import CannotJudge, Judge
from searches.texts.text_library import TEXT_KINDS, text_statement
from searches.texts.text_statement import TextStatement, Truth

SEARCH_KINDS = ("real", *TEXT_KINDS)
"""``real``: one real unknown, equations and formulas as SymPy prints them."""

LIMIT = 10.0
"""Seconds of processor time that a verdict may take."""


class Mark(enum.StrEnum):
    """Judgement of one answer.  UNJUDGED: refuted where the judge cannot say."""

    RIGHT = "right"
    WRONG = "wrong"
    UNDECIDED = "undecided"
    ERROR = "error"
    SLOW = "slow"
    UNJUDGED = "unjudged"


@dataclass(frozen=True)
class Judgement:
    """The answer to one statement.

    ``words``: the verdict's reason, the fault of a wrong one, or the error.  ``seconds`` of
    processor time.
    """

    kind: str
    truth: Truth
    seed: int
    index: int
    mark: Mark
    words: str
    seconds: float


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
    return Judgement(given.kind, given.truth, given.seed, given.index, mark, words, seconds)


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


def marked_answer(
    asked: Callable[[], ProofVerdict],
    marked: Callable[[ProofVerdict], tuple[Mark, str]],
    refused: Callable[[Exception], tuple[Mark, str] | None],
    limit: float,
) -> tuple[Mark, str, float]:
    """The mark of an answer, its words and seconds; ``refused`` marks errors that are answers."""
    start = time.process_time()
    try:
        with time_limit(limit):
            verdict = asked()
        mark, words = marked(verdict)
    except OutOfTime:
        mark, words = Mark.SLOW, f"no verdict in {limit:g} s"
    except Exception as error:  # a crash of the prover is a finding, not the end of the search
        mark, words = refused(error) or (Mark.ERROR, error_words(error))
    return mark, words, time.process_time() - start


def error_words(error: Exception) -> str:
    """The kind of an error and what it says."""
    return f"{type(error).__name__}: {error}"


def any_statement(kind: str, seed: int, index: int) -> TextStatement:
    """Return the statement of a kind of `SEARCH_KINDS`, which stands before its own kind."""
    if kind != "real":
        return text_statement(kind, seed, index)
    found = statement(seed, index)
    return replace(found, kind=f"{kind}: {found.kind}")


def judged(kind: str, seed: int, index: int, limit: float = LIMIT) -> Judgement:
    """The judgement of that statement, its kind first and what there is within it behind."""
    return judge_text(any_statement(kind, seed, index), limit)


def kind_of(judgement: Judgement) -> str:
    """Return the kind of `SEARCH_KINDS` of a judged statement."""
    return judgement.kind.partition(":")[0]


def digest(found: Iterable[Judgement]) -> str:
    """Return a digest of the judgements, the same in any order."""
    lines = sorted(f"{j.kind} {j.seed} {j.index} {j.truth} {j.mark}" for j in found)
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Tally:
    """Marks of the statements of one kind; ``seconds`` of each, in the order asked."""

    kind: str
    counts: Mapping[Mark, int]
    seconds: tuple[float, ...]

    @property
    def total(self) -> int:
        """Number of statements."""
        return len(self.seconds)

    def cells(self) -> list[str]:
        """The row of the table that goes with `HEADINGS`."""
        counts = [str(self.counts.get(mark, 0)) for mark in Mark]
        share = 100 * self.counts.get(Mark.UNDECIDED, 0) / max(self.total, 1)
        times = [f"{1000 * f(self.seconds):.0f}" for f in (statistics.median, max)]
        return [self.kind, str(self.total), *counts, f"{share:.1f}", *times]


HEADINGS = (
    "kind",
    "count",
    *(mark.value for mark in Mark),
    "% undecided",
    "median ms",
    "max ms",
)


def tally(kind: str, found: Sequence[Judgement]) -> Tally:
    """The counts of some judgements."""
    return Tally(
        kind,
        Counter(judgement.mark for judgement in found),
        tuple(judgement.seconds for judgement in found),
    )


def _group(judgement: Judgement) -> str:
    return judgement.kind.partition(":")[0]


def tallies(found: Sequence[Judgement], group: Callable[[Judgement], str] = _group) -> list[Tally]:
    """One a kind (branches and complex formulas together, unless told), and one of all."""
    by_kind: dict[str, list[Judgement]] = {}
    for judgement in found:
        kind = group(judgement)
        by_kind.setdefault(kind, []).append(judgement)
    return [*(tally(kind, own) for kind, own in sorted(by_kind.items())), tally("all", found)]

"""The search for wrong verdicts: random statements of known truth, put to the prover.

A verdict is wrong if something false or void is PROVED, something true or void is REFUTED, or the
witness of a refutation lies outside the domain or leaves no residual.
"""

from __future__ import annotations

import enum
import statistics
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from longwave.support.processes import OutOfTime, time_limit
from longwave.verify.proof import prove, prove_equal
from longwave.verify.proof.certificate_writer import CONSTANTS, FUNCTIONS
from longwave.verify.subexpressions import distinct_nodes
from longwave.verify.verdict import Outcome, ProofVerdict
from searches.statements.library import statement
from searches.statements.random_statement import RandomStatement, Truth
from searches.statements.values import ValueMissing, fails_at, label_fault

LIMIT = 10.0
"""Seconds of processor time that a verdict may take."""


class Mark(enum.StrEnum):
    """What became of one statement.  UNJUDGED: refuted where the judge cannot say."""

    RIGHT = "right"
    WRONG = "wrong"
    UNDECIDED = "undecided"
    ERROR = "error"
    SLOW = "slow"
    UNJUDGED = "unjudged"


@dataclass(frozen=True)
class Judgement:
    """The answer to one statement.

    ``supported``: certificates have a node for every function in it, and the equation is made of
    jets.  ``words``: the verdict's reason, the fault of a wrong one, or the error.  ``seconds`` of
    processor time.
    """

    kind: str
    truth: Truth
    seed: int
    index: int
    mark: Mark
    supported: bool
    words: str
    seconds: float


def ask(given: RandomStatement) -> ProofVerdict:
    """The prover's verdict."""
    if given.unknown is None:
        return prove_equal(given.left, given.right, given.variables, domains=given.domains)
    return prove(given.left, given.right, domains=given.domains)


def judge(given: RandomStatement, limit: float = LIMIT) -> Judgement:
    """Ask the prover and compare with the truth; every error is caught and told."""

    def refused(error: Exception) -> tuple[Mark, str] | None:
        expected = given.truth is Truth.VOID and isinstance(error, (ValueError, TypeError))
        plain = "\n" not in str(error)
        return (Mark.RIGHT, error_words(error)) if expected and plain else None

    mark, words, seconds = marked_answer(
        lambda: ask(given), lambda verdict: marked(given, verdict), refused, limit
    )
    return Judgement(
        given.kind, given.truth, given.seed, given.index, mark, is_supported(given), words, seconds
    )


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


def marked(given: RandomStatement, verdict: ProofVerdict) -> tuple[Mark, str]:
    """Whether a verdict is right, and why not."""
    outcome = verdict.outcome
    if outcome is Outcome.UNDECIDED:
        right = given.truth is Truth.VOID
        return (Mark.RIGHT if right else Mark.UNDECIDED), verdict.detail
    if outcome is Outcome.PROVED:
        right = given.truth is Truth.TRUE
        return (Mark.RIGHT, "") if right else (Mark.WRONG, _contradiction(given, "PROVED"))
    if given.truth is not Truth.FALSE:
        return Mark.WRONG, _contradiction(given, f"REFUTED at {verdict.witness}")
    fault = witness_fault(given, verdict.witness or {})
    return (Mark.RIGHT, "") if fault is None else (Mark.WRONG, fault)


def witness_fault(given: RandomStatement, witness: Mapping[str, str]) -> str | None:
    """What is wrong with a witness against a false statement; None if nothing is."""
    point = {}
    for made in given.ranges:
        text = witness.get(str(made.symbol))
        if text is not None:
            value = point[made.symbol] = sp.Rational(text)
            if not made.holds(value):
                return f"witness {made.symbol} = {value} is not in its range"
    try:
        shown = fails_at(given, point)
    except (ValueMissing, KeyError) as error:
        return f"witness {dict(witness)} has no residual: {error!r}"
    return None if shown else f"witness {dict(witness)} leaves no residual"


def is_supported(given: RandomStatement) -> bool:
    """Whether certificates have a node for every function, and the equation is made of jets."""
    nodes = (node for side in (given.left, given.right) for node in distinct_nodes(side))
    return all(_is_known(node, given.unknown) for node in nodes)


def _is_known(node: sp.Basic, unknown: sp.Expr | None) -> bool:
    if node.is_Add or node.is_Mul or node.is_Symbol or node.is_Rational or node == unknown:
        return True
    if node in CONSTANTS or isinstance(node, sp.Tuple):
        return True
    if isinstance(node, sp.Derivative):
        return bool(node.expr == unknown)
    if node.is_Pow:
        whole = node.exp.is_Integer and node.exp > 0
        return bool(node.exp.is_Rational and (whole or unknown is None or not node.has(unknown)))
    of_unknown = unknown is not None and node.has(unknown)
    return not of_unknown and node.func.__name__ in FUNCTIONS


def _contradiction(given: RandomStatement, words: str) -> str:
    """``words``, and what speaks for the verdict and against the statement's label."""
    fault = label_fault(given)
    return words if fault is None else f"{words}; against the label: {fault}"


def judgements(seed: int, indices: range, limit: float = LIMIT) -> Iterator[Judgement]:
    """The judgements of the statements with these numbers, one after the other."""
    for index in indices:
        yield judge(statement(seed, index), limit)


@dataclass(frozen=True)
class Tally:
    """What became of the statements of one kind; ``seconds`` of each, in the order asked."""

    kind: str
    counts: Mapping[Mark, int]
    supported: int
    undecided_supported: int
    seconds: tuple[float, ...]

    @property
    def total(self) -> int:
        """How many statements there were."""
        return len(self.seconds)

    def cells(self) -> list[str]:
        """The row of the table that goes with `HEADINGS`."""
        counts = [str(self.counts.get(mark, 0)) for mark in Mark]
        share = 100 * self.undecided_supported / self.supported if self.supported else 0.0
        times = [f"{1000 * f(self.seconds):.0f}" for f in (statistics.median, max)]
        return [self.kind, str(self.total), *counts, f"{share:.1f}", *times]


HEADINGS = (
    "kind",
    "count",
    *(mark.value for mark in Mark),
    "% undecided of supported",
    "median ms",
    "max ms",
)


def tally(kind: str, found: Sequence[Judgement]) -> Tally:
    """The counts of some judgements."""
    supported = [judgement for judgement in found if judgement.supported]
    return Tally(
        kind,
        Counter(judgement.mark for judgement in found),
        len(supported),
        sum(judgement.mark is Mark.UNDECIDED for judgement in supported),
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

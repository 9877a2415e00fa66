"""The library of published solutions, decided: verdicts and seconds."""

from __future__ import annotations

from dataclasses import dataclass

from longwave.support.processes import Job, Key, OutOfTime, time_limit
from longwave.verify.problem_file import ProblemText
from longwave.verify.proof.statement_verdict import decide_statement
from longwave.verify.published import chosen, published
from longwave.verify.verdict import Outcome

LIMIT = 60.0
"""Seconds of the processor for a statement."""

STATEMENT_WEIGHT = 0.1
"""Seconds for a statement on average: 343 took 37 s with eight processes on two cores."""


@dataclass(frozen=True)
class PublishedVerdict:
    """A statement of the library and what came of it."""

    text: ProblemText
    outcome: Outcome
    seconds: float

    @property
    def expected(self) -> bool:
        """Whether the verdict is the one that the library expects."""
        return self.outcome == self.text.expect


def published_verdicts(equation_name: str) -> list[PublishedVerdict]:
    """Decide the library's statements on one equation; raises ValueError as `chosen`.

    >>> found = published_verdicts("thin film")
    >>> [(verdict.text.name, verdict.expected) for verdict in found]
    [('thin_film_source', True), ('thin_film_source_factor', True)]
    """
    return [_decided(text) for text in chosen([equation_name])]


def _decided(text: ProblemText) -> PublishedVerdict:
    statement = text.problem().statement
    try:
        with time_limit(LIMIT):
            verdict = decide_statement(statement)
    except OutOfTime:
        return PublishedVerdict(text, Outcome.UNDECIDED, LIMIT)
    return PublishedVerdict(text, verdict.outcome, verdict.seconds)


def library_jobs() -> dict[Key, Job]:
    """The library, a job for each equation."""
    names = [text.equation_name for text in published()]
    return {
        ("library", name): Job(published_verdicts, (name,), STATEMENT_WEIGHT * names.count(name))
        for name in dict.fromkeys(names)
    }

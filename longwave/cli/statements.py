"""Deciding statements given as text, by ``longwave prove`` and ``longwave library``.

Each statement is decided in a separate process with limits of time and memory.
"""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple

from longwave.cli.certificates import ProofFile
from longwave.cli.verdict_lines import VerdictLines
from longwave.cli.verdicts import STYLES, summary
from longwave.derive.algebra.formula_text import FormulaError
from longwave.support import processes
from longwave.support.command_line import fail
from longwave.support.compiled.source_digest import source_digest
from longwave.support.console import finished, print_lines, print_results, table_console, tracked
from longwave.support.dask_cluster import DaskWorkers
from longwave.support.request_limits import current_limits, duration
from longwave.support.slow_work import announce, give_notice
from longwave.verify.problem_file import (
    ProblemText,
    StatedProblem,
    UnreadableProblem,
    problem_texts,
)
from longwave.verify.proof.conditions import ConditionalVerdict, conditional_sentence
from longwave.verify.proof.near_misses import with_hint
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import StatementVerdict, undecided, verified_sentence
from longwave.verify.proof.text_prover import answer
from longwave.verify.proof.typed_statement import Statement
from longwave.verify.published import chosen
from longwave.verify.verdict import Outcome

if TYPE_CHECKING:
    from distributed import Client

DEFAULT_LIMIT = 60.0
"""Default time limit for deciding one statement, in seconds."""

MIN_LIMIT, MAX_LIMIT = 0.01, 1e6
"""Smallest and largest accepted time limit for one statement, in seconds."""

HINT_SECONDS = 5.0
"""Time limit of the search for a true statement close to a refuted one, in seconds."""

SECONDS_BEFORE_NOTICE = 3.0
"""Seconds after which the remaining time is announced; it cannot be estimated in advance."""

READING_SECONDS = 0.012
"""Seconds to read one statement, measured on the 750 of the library."""

GRACE_SECONDS = 1.0
"""Seconds after the limit in which a process may still report its last stage."""

MOST_MEMORY = 2_000_000_000
"""Limit on the memory for deciding one statement: bytes that a worker may add to its idle size."""

MAX_SHOWN = 20
"""Largest number of unreadable statements that are printed."""

FIRST_STAGE = "start"
"""Name of a statement's stage before the prover has reported any."""

STAGES = {
    "find_witness": "looking for a counterexample",
    "make_certificate": "writing the proof",
    "check_certificate": "checking the proof",
    "singularities": "looking for poles and branch points",
}
"""Descriptions of the prover's steps, by the functions that perform them."""


def prove_and_print(
    program: str,
    files: Sequence[str],
    equations: Sequence[str],
    solutions: Sequence[str],
    *,
    parameters: str | None,
    domain: str | None,
    variables: str | None,
    solve: str | None,
    weak: bool,
    **options: Any,
) -> int:
    """Decide a statement given by its formulas, or those in ``files``; see `decide_and_print`."""

    def read() -> Sequence[ProblemOrError]:
        if files:
            return read_problems([text for path in files for text in problem_texts(Path(path))])
        texts = parameters or "", domain or ""
        names = {"solve": solve or "", "variables": variables or ""}
        return [StatedProblem(read_statement(equations, solutions, *texts, weak=weak, **names))]

    return decide_and_print(read, program, files=files, **options)


def decide_library_and_print(program: str, names: Sequence[str], **options: Any) -> int:
    """Decide the named published solutions, or all of them; see `decide_and_print`.

    Without names there are no hints, which take longer than the verdicts.
    """
    hinting = HINT_SECONDS if names else 0.0
    return decide_and_print(
        lambda: read_problems(chosen(names)), program, hinting=hinting, **options
    )


def decide_and_print(
    read: Callable[[], Sequence[ProblemOrError]],
    program: str,
    *,
    files: Sequence[str] = (),
    hinting: float = HINT_SECONDS,
    limit: float | None = None,
    scheduler: str | None = None,
    output: str | None = None,
    system: str | None = None,
    force: bool = False,
    latex: bool = False,
    json_wanted: bool = False,
    keep_going: bool = False,
    lines: str | None = None,
) -> int:
    """Decide the statements that ``read`` returns and print the verdicts; return the exit status.

    The status is 0 if all are proved or as expected, 1 if not, 2 for formulas that cannot be read,
    130 after Ctrl-C. Unreadable formulas are printed and nothing is decided, unless ``keep_going``
    is set. Verdicts are appended to the file ``lines`` as they are reached; statements with a
    verdict there are not decided again. Proofs are written as by `ProofFile`, which never
    overwrites ``files``. Raises ValueError and OSError for other input or output that cannot be
    read or written.
    """
    proofs = ProofFile(output, system, force)
    proofs.check(files)
    seconds = _checked_limit(limit)
    stored = VerdictLines(lines, seconds, proof_digest)
    try:
        problems = read()
    except FormulaError as error:
        return _print_unreadable([error])
    unreadable = [problem.error for problem in problems if isinstance(problem, UnreadableProblem)]
    if unreadable and not keep_going:
        return _print_unreadable(unreadable, len(problems))
    options: dict[str, Any] = {"limit": seconds, "hinting": hinting, "scheduler": scheduler}
    verdicts = _decide_all(problems, stored, partial(_decide_here_or_on_cluster, **options))
    results, complete = finished(tracked(verdicts, len(problems), "deciding"))
    results.sort(key=lambda pair: pair[0])
    proofs.write([certificate for _, verdict in results for certificate in verdict.certificates])
    decisions = [Decision(problems[index], verdict) for index, verdict in results]
    show, requested = partial(_print_decisions, latex=latex), f"{len(problems)} statements"
    status = print_results(decisions, complete, show, json_wanted, program, requested)
    return status or int(not all(decision.is_met for decision in decisions))


def _print_unreadable(errors: Sequence[FormulaError], total: int = 1) -> int:
    """Print statements that cannot be read, with each error's position; return the exit status."""
    status = 0
    for error in errors[:MAX_SHOWN]:
        status = fail(error)
        print(error.picture, file=sys.stderr)
    if total > 1:
        summary_text = f"{len(errors)} of {total} statements cannot be read"
        print(f"{summary_text} (fix them; --keep-going decides the others)", file=sys.stderr)
    return status


class Decision(NamedTuple):
    """A problem and the verdict on it."""

    problem: ProblemOrError
    verdict: StatementVerdict

    @property
    def is_met(self) -> bool:
        """Whether the verdict is the one the problem expects; by default that is a proof."""
        return self.verdict.outcome == (self.problem.expect or Outcome.PROVED)

    def json(self) -> dict[str, Any]:
        """Return the verdict as plain data, with the source and expected verdict of the problem."""
        labels = {"source": self.problem.source, "expect": self.problem.expect}
        return self.verdict.json() | {key: label for key, label in labels.items() if label}


ProblemOrError = StatedProblem | UnreadableProblem


def read_problems(texts: Sequence[ProblemText]) -> list[ProblemOrError]:
    """Read the statements in the texts; if there are many, announce how long reading takes."""
    announce(f"{len(texts)} statements to be read", READING_SECONDS * len(texts))
    return [text.problem_or_error() for text in tracked(texts, len(texts), "reading")]


def _decide_all(
    problems: Sequence[ProblemOrError],
    stored: VerdictLines,
    decide: Callable[[Sequence[StatedProblem]], Iterator[tuple[int, StatementVerdict]]],
) -> Iterator[tuple[int, StatementVerdict]]:
    """Yield index and verdict of each problem: unreadable and stored ones, then the others.

    ``decide`` yields the position and verdict of each of the others.
    """
    remaining: list[tuple[int, StatedProblem]] = []
    for index, problem in enumerate(problems):
        if isinstance(problem, UnreadableProblem):
            fields = problem.name, "", "reading", Outcome.UNREADABLE, str(problem.error)
            yield index, StatementVerdict(*fields)
        elif (verdict := stored.find(problem.statement)) is not None:
            yield index, verdict
        else:
            remaining.append((index, problem))
    for number, verdict in decide([problem for _, problem in remaining]):
        index, problem = remaining[number]
        stored.add(problem.statement, verdict)
        yield index, verdict


def _decide_here_or_on_cluster(
    problems: Sequence[StatedProblem], limit: float, hinting: float, scheduler: str | None
) -> Iterator[tuple[int, StatementVerdict]]:
    """Yield index and verdict of each problem, decided on this machine or on a cluster."""
    if scheduler is None:
        return decide_statements(problems, limit, hinting=hinting, late=_announce_rest)
    workers = DaskWorkers(scheduler, f"{__name__}:{proof_digest.__name__}", check_cluster)
    return decide_statements(problems, limit, hinting=hinting, workers=workers)


def _checked_limit(requested: float | None) -> float:
    limit = DEFAULT_LIMIT if requested is None else requested
    if not MIN_LIMIT <= limit <= MAX_LIMIT:
        raise ValueError(f"--limit must be {MIN_LIMIT} to {MAX_LIMIT:g} seconds, got {limit:g}")
    return limit


def _announce_rest(count: int, takes: str) -> None:
    give_notice(f"{count} statement{'' if count == 1 else 's'} to be decided", takes)


def decide_statements(
    problems: Sequence[StatedProblem],
    limit: float = DEFAULT_LIMIT,
    hinting: float = HINT_SECONDS,
    late: Callable[[int, str], None] = lambda count, takes: None,
    workers: processes.Workers | None = None,
) -> Iterator[tuple[int, StatementVerdict]]:
    """Yield index and verdict of each problem as they are reached.

    After ``limit`` seconds a statement is undecided, and the reason names the last stage. At most
    ``hinting`` seconds are spent on a true statement close to a refuted one. After
    `SECONDS_BEFORE_NOTICE` seconds, ``late`` is called with the number of remaining statements and
    their expected time: the average so far, or the limit if none is decided. ``workers`` may be
    those of a cluster.
    """
    workers = workers or processes.LocalWorkers(os.cpu_count() or 1, isolated=True)
    remaining, start, is_announced = len(problems), time.monotonic(), False

    def announce_late(_: object) -> None:
        nonlocal is_announced
        seconds, done = time.monotonic() - start, len(problems) - remaining
        if is_announced or seconds < SECONDS_BEFORE_NOTICE:
            return
        is_announced = True
        most = math.ceil(remaining / workers.count) * limit
        about = f"about {duration(seconds * remaining / done)}" if done else ""
        late(remaining, f"{about or f'at most {duration(most)}'} more")

    jobs = (
        processes.Job(
            _decide_in_worker,
            (problem.statement, limit, hinting),
            tells=True,
            seconds=limit + GRACE_SECONDS,
            memory=MOST_MEMORY,
        )
        for problem in problems
    )
    for index, call in processes.as_ended(enumerate(jobs), workers, announce_late):
        remaining -= 1
        yield index, _verdict_of(problems[index].statement, call, limit)


def _verdict_of(statement: Statement, call: processes.Call, limit: float) -> StatementVerdict:
    for message in (call.value, call.message):
        if isinstance(message, StatementVerdict):
            return message
    timed_out = isinstance(call.error, processes.OutOfTime)
    reason = f"no verdict within {limit:g} s" if timed_out else str(call.error)
    if not isinstance(call.error, processes.OutOfTime | processes.LostProcess):
        reason = f"the workers ended before it was decided ({type(call.error).__name__})"
    stage = call.message or FIRST_STAGE
    return undecided(statement, f"{reason} (last stage: {stage})", limit if timed_out else 0.0)


def proof_digest() -> str:
    """Return the hexadecimal digest of the sources and versions that affect a verdict."""
    return source_digest(__name__)


def check_cluster(client: Client) -> None:
    """Raise ValueError if a worker runs other code than this process."""
    for worker, digest in client.run(proof_digest).items():
        if digest != proof_digest():
            raise ValueError(
                "--scheduler must have workers with the sources and packages of this machine, "
                f"got other ones on {worker} (install the same there, or start again if sources "
                "changed)"
            )


def _decide_in_worker(
    statement: Statement, limit: float, hinting: float, send: Callable[[object], None]
) -> StatementVerdict:
    """Decide a statement in a worker process and return the verdict; ``send`` gets each stage.

    A refutation is also sent, before a hint to it is searched for at most ``hinting`` seconds.
    """
    start = time.monotonic()
    stage = [FIRST_STAGE]

    def tell(message: str) -> None:
        stage[0] = message
        send(message)

    try:
        with processes.time_limit(limit, passing=True):
            verdict = answer(statement, tell)
    except processes.OutOfTime as error:
        message = f"no verdict within {limit:g} s (last stage: {stage[0]}"
        verdict = undecided(statement, f"{message}{_current_step(error.__traceback__)})", limit)
    except MemoryError:
        allowed = min(MOST_MEMORY, current_limits().memory_bytes)
        verdict = undecided(statement, f"no verdict within {allowed / 1e6:.0f} MB of memory")
    except Exception as error:  # a crash of the prover is neither a verdict nor a user's mistake
        message = f"{type(error).__name__}: {' '.join(str(error).split())}"
        verdict = undecided(statement, f"the prover failed ({message[:200]})")
    seconds_left = min(limit - (time.monotonic() - start), hinting)
    if verdict.outcome is not Outcome.REFUTED or seconds_left <= 0 or statement.weak:
        return verdict
    send(verdict)
    limited = processes.time_limit(seconds_left, passing=True)
    with suppress(processes.OutOfTime, Exception), limited:  # the verdict stays
        return with_hint(statement, verdict)
    return verdict


def _current_step(trace: TracebackType | None) -> str:
    """Return the prover's step when an exception was raised, as ", STEP"; empty if unknown."""
    step = ""
    while trace is not None:
        step = STAGES.get(trace.tb_frame.f_code.co_name, step)
        trace = trace.tb_next
    return f", {step}" if step else ""


def _print_decisions(decisions: Sequence[Decision], latex: bool) -> None:
    if latex:
        sentences = (
            conditional_sentence(verdict)
            if isinstance(verdict, ConditionalVerdict)
            else verified_sentence(problem.statement, verdict)
            if isinstance(problem, StatedProblem)
            else f"% {verdict.name}: {verdict.outcome}: {verdict.detail}"
            for problem, verdict in decisions
        )
        print("\n\n".join(sentences))
        return
    console = table_console()
    for decision in decisions:
        outcome = decision.verdict.outcome
        console.print(f"[{STYLES[outcome]}]{outcome.value}[/] ", end="", highlight=False)
        print_lines(console, _decision_lines(decision))
    if len(decisions) != 1:
        print_lines(console, [summary([verdict for _, verdict in decisions], "statement")])


def _decision_lines(decision: Decision) -> list[str]:
    """Return the lines that explain a verdict: where the statement holds or fails, and remarks."""
    problem, verdict = decision
    first, *further = [verdict.detail]
    if isinstance(verdict, ConditionalVerdict):
        first, *further = verdict.lines()
    elif verdict.outcome is Outcome.PROVED:
        first = verdict.assumptions[0]
    expected = "" if decision.is_met else problem.expect
    prefix = f"{verdict.restriction}: " if verdict.restriction else ""
    lines = [f"{prefix}{verdict.name}: {first}", *further]
    if verdict.witness:
        lines.append(f"at {verdict.point}")
    lines += verdict.nonsmooth_lines
    lines += [verdict.hint] if verdict.hint else []
    lines += [f"expected was {expected}"] if expected else []
    return [lines[0], *(f"    {line}" for line in lines[1:])]

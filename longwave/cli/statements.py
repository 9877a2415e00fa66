"""Statements in text, decided: a user's own by ``longwave prove``, published ones by ``library``.

Each statement is decided in a process of its own, which ends at a limit of time and of memory;
where processes cannot be forked, it is decided here without limits.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import TracebackType
from typing import Any

from longwave.cli.exporting import ProofFile
from longwave.cli.verdicts import STYLES, summary
from longwave.derive.algebra.formula_text import FormulaError
from longwave.support.command_line import duration, fail, interrupted
from longwave.support.console import finished, print_lines, table_console, tracked
from longwave.support.processes import OutOfTime, ignore_interrupt, limit_memory, time_limit
from longwave.support.slow_work import give_notice
from longwave.verify.problem_file import ProblemText, StatedProblem, problem_texts
from longwave.verify.proof.conditions import ConditionalVerdict, conditional_sentence
from longwave.verify.proof.near_misses import SECONDS as HINT_SECONDS
from longwave.verify.proof.near_misses import with_hint
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import (
    StatementVerdict,
    undecided,
    verified_sentence,
)
from longwave.verify.proof.text_prover import answer
from longwave.verify.proof.typed_statement import Statement
from longwave.verify.published import chosen
from longwave.verify.verdict import Outcome

LIMIT = 60.0
"""Seconds for a statement unless told."""

LEAST, LONGEST = 0.01, 1e6

QUIET = 3.0
"""Seconds after which what is left is announced: how long a proof takes nobody knows before."""

MANY = 100
"""Statements that are announced before they are read: the 737 of the library take 5 s for it."""

GRACE = 1.0
"""Seconds after the limit in which a process may say how far it came."""

MEMORY = 2_000_000_000
"""Bytes for a statement, beyond what the process has."""

STAGES = {
    "find_witness": "looking for a counterexample",
    "make_certificate": "writing the proof",
    "check_certificate": "checking the proof",
    "singularities": "looking for poles and branch points",
}
"""What the prover is doing, by the functions that do it."""


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
    **options: Any,
) -> int:
    """Decide a statement in texts, or those of problem files; as `decide_and_print`."""

    def read() -> list[StatedProblem]:
        if files:
            return stated([text for path in files for text in problem_texts(Path(path))])
        texts = parameters or "", domain or ""
        names = {"solve": solve or "", "variables": variables or ""}
        return [StatedProblem(read_statement(equations, solutions, *texts, **names))]

    return decide_and_print(read, program, files=files, **options)


def decide_library_and_print(program: str, names: Sequence[str], **options: Any) -> int:
    """Decide published solutions, without names all; as `decide_and_print`.

    Of all of them without hints at what would hold, which take longer than the verdicts.
    """
    hinting = HINT_SECONDS if names else 0.0
    return decide_and_print(lambda: stated(chosen(names)), program, hinting=hinting, **options)


def decide_and_print(
    read: Callable[[], list[StatedProblem]],
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
) -> int:
    """Decide the statements that are ``read``, of ``files`` if of any, and print the verdicts.

    Returns 0 if all are proved or as expected, 1 if not, 2 for a wrong formula, which is shown, 130
    after Ctrl-C, which ``program`` tells. Proofs are written as `ProofFile` does. Raises ValueError
    and OSError for what else cannot be read or written.
    """
    try:
        proofs = ProofFile(output, system, force)
        proofs.check(files)
        seconds = _limit(limit)
        problems = read()
        verdicts = _decided(problems, seconds, hinting, scheduler)
        found, complete = finished(tracked(verdicts, len(problems), "deciding"))
        found.sort(key=lambda pair: pair[0])
        proofs.write([c for _, verdict in found for c in verdict.certificates])
    except FormulaError as error:
        status = fail(error)
        print(error.picture, file=sys.stderr)
        return status
    decisions = [(problems[place], verdict) for place, verdict in found]
    _print(decisions, json_wanted, latex)
    if not complete:
        return interrupted(program, f"after {len(found)} of {len(problems)} statements")
    return 0 if all(_is_met(problem, verdict) for problem, verdict in decisions) else 1


def stated(texts: Sequence[ProblemText]) -> list[StatedProblem]:
    """The statements in the texts, which take a while where they are many."""
    if len(texts) > MANY:
        give_notice(f"{len(texts)} statements to be read and decided")
    return [text.problem() for text in tracked(texts, len(texts), "reading")]


def _decided(
    problems: Sequence[StatedProblem], limit: float, hinting: float, scheduler: str | None
) -> Iterator[tuple[int, StatementVerdict]]:
    """The verdicts by processes of this machine, or of a cluster."""
    if scheduler is None:
        return decided(problems, limit, hinting=hinting, late=_announce_rest)
    from longwave.cli.cluster_verdicts import decided_on_cluster

    return decided_on_cluster(problems, limit, hinting, scheduler)


def _is_met(problem: StatedProblem, verdict: StatementVerdict) -> bool:
    return verdict.outcome == (problem.expect or Outcome.PROVED)


def _limit(given: float | None) -> float:
    limit = LIMIT if given is None else given
    if not LEAST <= limit <= LONGEST:
        raise ValueError(f"--limit must be {LEAST} to {LONGEST:g} seconds, got {limit:g}")
    return limit


def _announce_rest(count: int, seconds: float) -> None:
    work = f"{count} statement{'' if count == 1 else 's'} to be decided"
    give_notice(work, f"at most {duration(seconds)} more")


# processes


@dataclass
class _Running:
    """A statement that is being decided: its process, when it must end, and what it said last."""

    place: int
    process: Any
    end: float
    stage: str = "the beginning"
    verdict: StatementVerdict | None = None


def decided(
    problems: Sequence[StatedProblem],
    limit: float = LIMIT,
    processes: int | None = None,
    hinting: float = HINT_SECONDS,
    late: Callable[[int, float], None] = lambda count, seconds: None,
) -> Iterator[tuple[int, StatementVerdict]]:
    """The verdicts with the places of their problems, as they are reached.

    Past ``limit`` seconds a statement is undecided, and the reason says how far it came.
    ``hinting`` seconds at most are spent on what would hold in the place of a refuted one. After
    `QUIET` seconds ``late`` is told how many statements are left, and their seconds at most.
    """
    if not hasattr(os, "fork"):
        for place, problem in enumerate(problems):
            verdict = answer(problem.statement)
            yield place, with_hint(problem.statement, verdict, hinting) if hinting else verdict
        return
    waiting = iter(enumerate(problems))
    running: dict[Connection, _Running] = {}
    count = processes or os.cpu_count() or 1
    left, patience = len(problems), time.monotonic() + QUIET
    try:
        while True:
            for place, problem in islice(waiting, count - len(running)):
                connection, started = _start(place, problem.statement, limit, hinting)
                running[connection] = started
            if not running:
                return
            told = _told(running, patience)
            if time.monotonic() > patience:
                patience = math.inf
                late(left, math.ceil(left / count) * limit)
            for connection in told:
                left -= 1
                job = running.pop(connection)
                connection.close()
                job.process.join()
                yield job.place, _last_word(problems[job.place].statement, job, limit)
    finally:
        for connection, job in running.items():
            job.process.kill()
            job.process.join()
            connection.close()


def _start(
    place: int, statement: Statement, limit: float, hinting: float
) -> tuple[Connection, _Running]:
    reading, writing = get_context("fork").Pipe(duplex=False)
    process = get_context("fork").Process(target=_decide, args=(statement, limit, hinting, writing))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # threads elsewhere; the child has one
        process.start()
    writing.close()
    return reading, _Running(place, process, time.monotonic() + limit + GRACE)


def _told(running: dict[Connection, _Running], patience: float) -> list[Connection]:
    """Read what comes next; the connections of processes that are at their end, or put to it.

    None if nothing comes until the time ``patience``.
    """
    nearest = min(patience, *(job.end for job in running.values()))
    over = []
    for ready in wait(list(running), max(0.0, nearest - time.monotonic())):
        assert isinstance(ready, Connection)
        try:
            said = ready.recv()
        except (EOFError, OSError):
            over.append(ready)
            continue
        if isinstance(said, str):
            running[ready].stage = said
        else:
            running[ready].verdict = said
    for connection, job in running.items():
        if time.monotonic() > job.end and connection not in over:
            job.process.kill()
            over.append(connection)
    return over


def _last_word(statement: Statement, job: _Running, limit: float) -> StatementVerdict:
    if job.verdict is not None:
        return job.verdict
    late = time.monotonic() > job.end
    why = f"no verdict within {limit:g} s" if late else "the process broke off"
    return undecided(statement, f"{why} (it had come to {job.stage})", limit if late else 0.0)


def _decide(statement: Statement, limit: float, hinting: float, writing: Connection) -> None:
    """In the child: send stages and the verdict, then the one with a hint."""
    ignore_interrupt()
    limit_memory(MEMORY)
    begun = time.monotonic()
    stage = ["the beginning"]

    def tell(words: str) -> None:
        stage[0] = words
        writing.send(words)

    try:
        with time_limit(limit, passing=True):
            verdict = answer(statement, tell)
    except OutOfTime as error:
        words = f"no verdict within {limit:g} s (it had come to {stage[0]}"
        verdict = undecided(statement, f"{words}{_doing(error.__traceback__)})", limit)
    except MemoryError:
        verdict = undecided(statement, f"no verdict within {MEMORY // 10**6} MB of memory")
    except Exception as error:  # a crash of the prover is no verdict, and not the user's mistake
        words = f"{type(error).__name__}: {' '.join(str(error).split())}"
        verdict = undecided(statement, f"the prover failed ({words[:200]})")
    writing.send(verdict)
    left = min(limit - (time.monotonic() - begun), hinting)
    if verdict.outcome is Outcome.REFUTED and left > 0:
        writing.send(_hinted(statement, verdict, left))
    writing.close()


def _hinted(statement: Statement, verdict: StatementVerdict, seconds: float) -> StatementVerdict:
    """The verdict with a hint if one is found; whatever fails in the search, the verdict stays."""
    try:
        with time_limit(seconds, passing=True):
            return with_hint(statement, verdict, seconds)
    except (OutOfTime, Exception):
        return verdict


def _doing(trace: TracebackType | None) -> str:
    """What the prover was at, from the functions that it was in."""
    found = ""
    while trace is not None:
        found = STAGES.get(trace.tb_frame.f_code.co_name, found)
        trace = trace.tb_next
    return f", {found}" if found else ""


# what is printed


def _print(
    found: Sequence[tuple[StatedProblem, StatementVerdict]], json_wanted: bool, latex: bool
) -> None:
    if json_wanted:
        records = [_record(problem, verdict) for problem, verdict in found]
        print(json.dumps(records, indent=2))
        return
    if latex:
        print("\n\n".join(_sentence(problem.statement, verdict) for problem, verdict in found))
        return
    console = table_console()
    for problem, verdict in found:
        style = STYLES[verdict.outcome]
        console.print(f"[{style}]{verdict.outcome.value}[/] ", end="", highlight=False)
        print_lines(console, _lines(problem, verdict))
    if len(found) != 1:
        print_lines(console, [summary([verdict for _, verdict in found], "statement")])


def _sentence(statement: Statement, verdict: StatementVerdict) -> str:
    if isinstance(verdict, ConditionalVerdict):
        return conditional_sentence(verdict)
    return verified_sentence(statement, verdict)


def _record(problem: StatedProblem, verdict: StatementVerdict) -> dict[str, Any]:
    record = verdict.json()
    if problem.source:
        record["source"] = problem.source
    if problem.expect:
        record["expect"] = problem.expect
    return record


def _lines(problem: StatedProblem, verdict: StatementVerdict) -> list[str]:
    """The verdict in words: where it holds or fails, and what else there is to say."""
    first, *more = [verdict.detail]
    if isinstance(verdict, ConditionalVerdict):
        first, *more = verdict.lines()
    elif verdict.outcome is Outcome.PROVED:
        first = verdict.assumptions[0]
    expected = "" if _is_met(problem, verdict) or not problem.expect else problem.expect
    lines = [f"{verdict.name}: {first}", *more]
    if verdict.witness:
        lines.append(f"at {', '.join(f'{name} = {v}' for name, v in verdict.witness.items())}")
    lines += [f"possibly not smooth: {line}" for line in verdict.singularities]
    lines += [verdict.hint] if verdict.hint else []
    lines += [f"expected was {expected}"] if expected else []
    return [lines[0], *(f"    {line}" for line in lines[1:])]

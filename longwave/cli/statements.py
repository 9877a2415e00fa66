"""Statements in text, decided: a user's own by ``longwave prove``, published ones by ``library``.

Each statement is decided in a process of its own, which ends at a limit of time and of memory.
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
from longwave.support.command_line import fail
from longwave.support.compiled.source_digest import source_digest
from longwave.support.console import finished, print_lines, print_results, table_console, tracked
from longwave.support.dask_cluster import DaskWorkers
from longwave.support.processes import (
    Call,
    Job,
    LocalWorkers,
    LostProcess,
    OutOfTime,
    Workers,
    as_ended,
    time_limit,
)
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
from longwave.verify.proof.statement_verdict import (
    StatementVerdict,
    undecided,
    verified_sentence,
)
from longwave.verify.proof.text_prover import answer
from longwave.verify.proof.typed_statement import Statement
from longwave.verify.published import chosen
from longwave.verify.verdict import Outcome

if TYPE_CHECKING:
    from distributed import Client

LIMIT = 60.0
"""Seconds for a statement unless told."""

LEAST, LONGEST = 0.01, 1e6

HINT_SECONDS = 5.0
"""Longest search for what would hold in the place of a refuted statement."""

QUIET = 3.0
"""Seconds after which what is left is announced: how long a proof takes nobody knows before."""

READING_SECONDS = 0.012
"""To read a statement of the library, which has 750 of them."""

GRACE = 1.0
"""Seconds after the limit in which a process may say how far it came."""

MEMORY = 2_000_000_000
"""Bytes for a statement, beyond what the process has."""

MOST_SHOWN = 20
"""Statements that cannot be read and are shown."""

THE_BEGINNING = "the beginning"

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
    weak: bool,
    **options: Any,
) -> int:
    """Decide a statement in texts, or those of problem files; as `decide_and_print`."""

    def read() -> Sequence[Reading]:
        if files:
            return read_problems([text for path in files for text in problem_texts(Path(path))])
        texts = parameters or "", domain or ""
        names = {"solve": solve or "", "variables": variables or ""}
        return [StatedProblem(read_statement(equations, solutions, *texts, weak=weak, **names))]

    return decide_and_print(read, program, files=files, **options)


def decide_library_and_print(program: str, names: Sequence[str], **options: Any) -> int:
    """Decide published solutions, without names all; as `decide_and_print`.

    Of all of them without hints at what would hold, which take longer than the verdicts.
    """
    hinting = HINT_SECONDS if names else 0.0
    return decide_and_print(
        lambda: read_problems(chosen(names)), program, hinting=hinting, **options
    )


def decide_and_print(
    read: Callable[[], Sequence[Reading]],
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
    """Decide the statements that are ``read``, of ``files`` if of any, and print the verdicts.

    Returns 0 if all are proved or as expected, 1 if not, 2 for wrong formulas, which are shown
    unless ``keep_going`` has the others decided, 130 after Ctrl-C, which ``program`` tells.
    Verdicts are appended to the file of ``lines`` as they are reached, and those that it has are
    not decided again. Proofs are written as `ProofFile` does. Raises ValueError and OSError for
    what else cannot be read or written.
    """
    proofs = ProofFile(output, system, force)
    proofs.check(files)
    seconds = _limit(limit)
    kept = VerdictLines(lines, seconds, proof_digest)
    try:
        problems = read()
    except FormulaError as error:
        return _show_unreadable([error])
    unreadable = [problem.error for problem in problems if isinstance(problem, UnreadableProblem)]
    if unreadable and not keep_going:
        return _show_unreadable(unreadable, len(problems))
    verdicts = _all_decided(
        problems, kept, partial(_decided, limit=seconds, hinting=hinting, scheduler=scheduler)
    )
    found, complete = finished(tracked(verdicts, len(problems), "deciding"))
    found.sort(key=lambda pair: pair[0])
    proofs.write([c for _, verdict in found for c in verdict.certificates])
    decisions = [Decision(problems[place], verdict) for place, verdict in found]
    show, asked = partial(_print, latex=latex), f"{len(problems)} statements"
    status = print_results(decisions, complete, show, json_wanted, program, asked)
    return status or int(not all(decision.is_met for decision in decisions))


def _show_unreadable(errors: Sequence[FormulaError], of: int = 1) -> int:
    """Show what cannot be read, each with its place, and what may be done; the exit status."""
    status = 0
    for error in errors[:MOST_SHOWN]:
        status = fail(error)
        print(error.picture, file=sys.stderr)
    if of > 1:
        words = f"{len(errors)} of {of} statements cannot be read"
        print(f"{words} (mend them; --keep-going decides the others)", file=sys.stderr)
    return status


class Decision(NamedTuple):
    """A problem with the verdict on it."""

    problem: Reading
    verdict: StatementVerdict

    @property
    def is_met(self) -> bool:
        """Whether the verdict is the expected one, or a proof where none is."""
        return self.verdict.outcome == (self.problem.expect or Outcome.PROVED)

    def json(self) -> dict[str, Any]:
        """The verdict as plain data, with what its file says."""
        told = {"source": self.problem.source, "expect": self.problem.expect}
        return self.verdict.json() | {name: text for name, text in told.items() if text}


Reading = StatedProblem | UnreadableProblem


def read_problems(texts: Sequence[ProblemText]) -> list[Reading]:
    """The statements in the texts, which take a while where they are many."""
    announce(f"{len(texts)} statements to be read", READING_SECONDS * len(texts))
    return [text.problem_or_error() for text in tracked(texts, len(texts), "reading")]


def _all_decided(
    problems: Sequence[Reading],
    kept: VerdictLines,
    decide: Callable[[Sequence[StatedProblem]], Iterator[tuple[int, StatementVerdict]]],
) -> Iterator[tuple[int, StatementVerdict]]:
    """The verdicts on all problems: on what cannot be read, those that are kept, and the others."""
    left: list[tuple[int, StatedProblem]] = []
    for place, problem in enumerate(problems):
        if isinstance(problem, UnreadableProblem):
            told = problem.name, "", "reading", Outcome.UNREADABLE, str(problem.error)
            yield place, StatementVerdict(*told)
        elif (verdict := kept.taken(problem.statement)) is not None:
            yield place, verdict
        else:
            left.append((place, problem))
    for number, verdict in decide([problem for _, problem in left]):
        place, problem = left[number]
        kept.add(problem.statement, verdict)
        yield place, verdict


def _decided(
    problems: Sequence[StatedProblem], limit: float, hinting: float, scheduler: str | None
) -> Iterator[tuple[int, StatementVerdict]]:
    """The verdicts by processes of this machine, or of a cluster."""
    if scheduler is None:
        return decided(problems, limit, hinting=hinting, late=_announce_rest)
    workers = DaskWorkers(scheduler, f"{__name__}:{proof_digest.__name__}", check_cluster)
    return decided(problems, limit, hinting=hinting, workers=workers)


def _limit(given: float | None) -> float:
    limit = LIMIT if given is None else given
    if not LEAST <= limit <= LONGEST:
        raise ValueError(f"--limit must be {LEAST} to {LONGEST:g} seconds, got {limit:g}")
    return limit


def _announce_rest(count: int, takes: str) -> None:
    give_notice(f"{count} statement{'' if count == 1 else 's'} to be decided", takes)


# processes


def decided(
    problems: Sequence[StatedProblem],
    limit: float = LIMIT,
    hinting: float = HINT_SECONDS,
    late: Callable[[int, str], None] = lambda count, takes: None,
    workers: Workers | None = None,
) -> Iterator[tuple[int, StatementVerdict]]:
    """The verdicts with the places of their problems, as they are reached.

    Past ``limit`` seconds a statement is undecided, and the reason says how far it came.
    ``hinting`` seconds at most are spent on what would hold in the place of a refuted one. After
    `QUIET` seconds ``late`` is told how many statements are left, and what they take: as long as
    those before them on average, or at most the limit if none is decided.
    ``workers`` may be those of a cluster.
    """
    workers = workers or LocalWorkers(os.cpu_count() or 1, isolated=True)
    left, begun, is_told = len(problems), time.monotonic(), False

    def look(_: object) -> None:
        nonlocal is_told
        seconds, done = time.monotonic() - begun, len(problems) - left
        if is_told or seconds < QUIET:
            return
        is_told = True
        if done:
            late(left, f"about {duration(seconds * left / done)} more")
        else:
            late(left, f"at most {duration(math.ceil(left / workers.count) * limit)} more")

    jobs = (
        Job(
            _decide,
            (problem.statement, limit, hinting),
            tells=True,
            seconds=limit + GRACE,
            memory=MEMORY,
        )
        for problem in problems
    )
    for place, call in as_ended(enumerate(jobs), workers, look):
        left -= 1
        yield place, _last_word(problems[place].statement, call, limit)


def _last_word(statement: Statement, call: Call, limit: float) -> StatementVerdict:
    for found in (call.value, call.message):
        if isinstance(found, StatementVerdict):
            return found
    late = isinstance(call.error, OutOfTime)
    why = f"no verdict within {limit:g} s" if late else str(call.error)
    if not isinstance(call.error, OutOfTime | LostProcess):
        why = f"the workers ended before it was decided ({type(call.error).__name__})"
    stage = call.message or THE_BEGINNING
    return undecided(statement, f"{why} (it had come to {stage})", limit if late else 0.0)


def proof_digest() -> str:
    """The digest (hexadecimal) of the sources and versions that a verdict follows from."""
    return source_digest(__name__)


def check_cluster(client: Client) -> None:
    """Raise ValueError if a worker would decide by another code than this process."""
    for worker, digest in client.run(proof_digest).items():
        if digest != proof_digest():
            raise ValueError(
                "--scheduler must be of workers that prove by the sources and packages of "
                f"this machine, got other ones on {worker} (install the same there, or start "
                "it again where sources changed)"
            )


def _decide(
    statement: Statement, limit: float, hinting: float, send: Callable[[object], None]
) -> StatementVerdict:
    """In a process of its own: send stages and the verdict; return the one with a hint."""
    begun = time.monotonic()
    stage = [THE_BEGINNING]

    def tell(words: str) -> None:
        stage[0] = words
        send(words)

    try:
        with time_limit(limit, passing=True):
            verdict = answer(statement, tell)
    except OutOfTime as error:
        words = f"no verdict within {limit:g} s (it had come to {stage[0]}"
        verdict = undecided(statement, f"{words}{_doing(error.__traceback__)})", limit)
    except MemoryError:
        allowed = min(MEMORY, current_limits().memory_bytes)
        verdict = undecided(statement, f"no verdict within {allowed / 1e6:.0f} MB of memory")
    except Exception as error:  # a crash of the prover is no verdict, and not the user's mistake
        words = f"{type(error).__name__}: {' '.join(str(error).split())}"
        verdict = undecided(statement, f"the prover failed ({words[:200]})")
    left = min(limit - (time.monotonic() - begun), hinting)
    if verdict.outcome is not Outcome.REFUTED or left <= 0 or statement.weak:
        return verdict
    send(verdict)
    with suppress(OutOfTime, Exception), time_limit(left, passing=True):  # the verdict stays
        return with_hint(statement, verdict)
    return verdict


def _doing(trace: TracebackType | None) -> str:
    """What the prover was at, from the functions that it was in."""
    found = ""
    while trace is not None:
        found = STAGES.get(trace.tb_frame.f_code.co_name, found)
        trace = trace.tb_next
    return f", {found}" if found else ""


# what is printed


def _print(found: Sequence[Decision], latex: bool) -> None:
    if latex:
        sentences = (
            conditional_sentence(verdict)
            if isinstance(verdict, ConditionalVerdict)
            else verified_sentence(problem.statement, verdict)
            if isinstance(problem, StatedProblem)
            else f"% {verdict.name}: {verdict.outcome}: {verdict.detail}"
            for problem, verdict in found
        )
        print("\n\n".join(sentences))
        return
    console = table_console()
    for decision in found:
        outcome = decision.verdict.outcome
        console.print(f"[{STYLES[outcome]}]{outcome.value}[/] ", end="", highlight=False)
        print_lines(console, _lines(decision))
    if len(found) != 1:
        print_lines(console, [summary([verdict for _, verdict in found], "statement")])


def _lines(decision: Decision) -> list[str]:
    """The verdict in words: where it holds or fails, and what else there is to say."""
    problem, verdict = decision
    first, *more = [verdict.detail]
    if isinstance(verdict, ConditionalVerdict):
        first, *more = verdict.lines()
    elif verdict.outcome is Outcome.PROVED:
        first = verdict.assumptions[0]
    expected = "" if decision.is_met else problem.expect
    front = f"{verdict.restriction}: " if verdict.restriction else ""
    lines = [f"{front}{verdict.name}: {first}", *more]
    if verdict.witness:
        lines.append(f"at {verdict.point}")
    lines += verdict.nonsmooth_lines
    lines += [verdict.hint] if verdict.hint else []
    lines += [f"expected was {expected}"] if expected else []
    return [lines[0], *(f"    {line}" for line in lines[1:])]

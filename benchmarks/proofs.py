"""Proofs beside SymPy's ``checkpdesol`` and ``simplify`` on the same formulas.

Each attempt runs in a process of its own, which is stopped after ``--limit`` seconds (60 unless
told).  "wrong" counts answers that contradict the proof; "no answer" counts those that ran out
of time, failed, or left a residual that was not simplified to 0.

    python benchmarks/proofs.py [--only NAME ...] [--limit SECONDS] [--json]
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection

import sympy as sp
from rich.console import Console
from rich.table import Table
from sympy.solvers.pde import checkpdesol

from solutions import CATALOGUE, closed_form
from verify.proof import form_domains, prove
from verify.verdict import Outcome

LIMIT = 60.0
SOLVED, WRONG, NO_ANSWER = "solved", "wrong", "no answer"


@dataclass(frozen=True)
class Attempt:
    """One tool's answer on one formula."""

    tool: str
    name: str
    answer: str
    seconds: float


def by_proof(name: str) -> str:
    """The prover's answer; the formula is a solution."""
    form = closed_form(name)
    outcome = prove(form.equation, form.expression, domains=form_domains(form)).outcome
    return {Outcome.PROVED: SOLVED, Outcome.REFUTED: WRONG}.get(outcome, NO_ANSWER)


def by_checkpdesol(name: str) -> str:
    """SymPy's answer: (True, 0), or (False, residual) whether wrong or only not simplified.

    A False is counted as wrong, since it says that the formula is no solution.
    """
    form = closed_form(name)
    unknown = sp.Function("U")(form.equation.xi, form.equation.tau)
    holds, _ = checkpdesol(form.equation.residual(unknown), sp.Eq(unknown, form.expression))
    return SOLVED if holds else WRONG


def by_simplify(name: str) -> str:
    """Whether ``simplify`` brings the residual to 0; anything else says nothing."""
    form = closed_form(name)
    residual = form.equation.residual(form.expression).doit()
    return SOLVED if sp.simplify(residual) == 0 else NO_ANSWER


TOOLS: dict[str, Callable[[str], str]] = {
    "proof": by_proof,
    "checkpdesol": by_checkpdesol,
    "simplify": by_simplify,
}


def _work(tool: str, name: str, pipe: Connection) -> None:
    start = time.perf_counter()
    try:
        answer = TOOLS[tool](name)
    except Exception:  # any failure of a tool is no answer
        answer = NO_ANSWER
    pipe.send((answer, time.perf_counter() - start))


def attempt(tool: str, name: str, limit: float) -> Attempt:
    """Ask ``tool`` about the form called ``name`` in a new process, for ``limit`` seconds."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(tool, name, theirs), daemon=True)
    process.start()
    theirs.close()
    answer, seconds = NO_ANSWER, limit
    try:
        if ours.poll(limit):
            answer, seconds = ours.recv()
    except EOFError:
        pass
    process.kill()
    process.join()
    return Attempt(tool, name, answer, seconds)


def attempts_table(attempts: list[Attempt], limit: float) -> Table:
    """One row a tool: counts of the answers, and the median time with the limit for no answer."""
    table = Table(title=f"The same formulas, {limit:g} s each")
    table.add_column("tool")
    for heading in (SOLVED, WRONG, NO_ANSWER, "median seconds"):
        table.add_column(heading, justify="right")
    for tool in TOOLS:
        own = [attempt for attempt in attempts if attempt.tool == tool]
        if own:
            counts = [sum(a.answer == kind for a in own) for kind in (SOLVED, WRONG, NO_ANSWER)]
            median = statistics.median(a.seconds for a in own)
            table.add_row(tool, *map(str, counts), f"{median:.2f}")
    return table


def main() -> None:
    """Read the options, ask every tool about every form, print."""
    names = [form.name for form in CATALOGUE]
    parser = argparse.ArgumentParser(description="Proofs beside checkpdesol and simplify.")
    parser.add_argument("--only", action="append", choices=names, metavar="NAME")
    parser.add_argument("--tool", action="append", choices=list(TOOLS))
    parser.add_argument("--limit", type=float, default=LIMIT, metavar="SECONDS")
    parser.add_argument("--json", action="store_true", help="print each attempt as JSON")
    options = parser.parse_args()
    console, made = Console(), []
    for name in options.only or names:
        for tool in options.tool or TOOLS:
            found = attempt(tool, name, options.limit)
            made.append(found)
            if not options.json:
                console.print(f"{name:13} {tool:12} {found.answer:10} {found.seconds:8.2f} s")
    if options.json:
        print(json.dumps([asdict(found) for found in made], indent=2))
    else:
        console.print(attempts_table(made, options.limit))


if __name__ == "__main__":
    main()

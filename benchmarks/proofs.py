"""The library of published solutions put to the prover and to other computer algebra.

The prover gets every statement; SymPy's ``checkpdesol`` (``checkodesol``), ``simplify`` of the
residual, and Maxima's simplifiers of the residual get ``--sample`` of them, evenly spaced.  Each
attempt runs in a process of its own, which is stopped after ``--limit`` seconds of the processor.
An answer is right or wrong against what the library says; no answer: out of time, failed, or a
residual that was not simplified to 0 and so says nothing; not taken: systems, lattices and complex
conjugates, for ``checkpdesol``.  Maxima is left out where there is no ``maxima``.

    python benchmarks/proofs.py [--only NAME ...] [--tool NAME ...] [--sample 48] [--limit 20]
                                [--workers 2] [--json FILE]
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import statistics
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from math import ceil
from pathlib import Path

import sympy as sp
from rich.console import Console
from rich.progress import Progress
from rich.table import Table
from sympy.core.function import AppliedUndef
from sympy.solvers.ode import checkodesol
from sympy.solvers.pde import checkpdesol

from longwave.derive.algebra.formula_printing import formula_as_text
from longwave.support.processes import Job, LocalWorkers, as_ended, limit_processor
from longwave.verify.problem_file import ProblemText
from longwave.verify.proof.statement_problem import residual_of
from longwave.verify.proof.statement_verdict import decide_statement
from longwave.verify.proof.typed_statement import Statement
from longwave.verify.published import published
from longwave.verify.verdict import Outcome

HOLDS, FAILS, SILENT, NOT_TAKEN = "holds", "fails", "no answer", "not taken"
RIGHT, WRONG = "right", "wrong"


PATIENCE = 6.0
"""Times the limit that may pass by the clock, on a busy machine."""


@dataclass(frozen=True)
class Attempt:
    """One tool's answer on one statement."""

    tool: str
    name: str
    answer: str
    seconds: float


def by_proof(statement: Statement) -> str:
    """Return the prover's answer."""
    outcome = decide_statement(statement).outcome
    return {Outcome.PROVED: HOLDS, Outcome.REFUTED: FAILS}.get(outcome, SILENT)


def by_checkpdesol(statement: Statement) -> str:
    """Return SymPy's answer: (True, 0), or (False, residual) for what is no solution."""
    (equation, *others), solutions = statement.equations, statement.solutions
    (unknown, formula), *more = solutions.items()
    sites = any(argument.is_integer for argument in unknown.args)
    if others or more or sites or equation.has(sp.conjugate, sp.Abs, sp.re, sp.im):
        return NOT_TAKEN
    if equation.atoms(AppliedUndef) != {unknown}:
        return NOT_TAKEN
    check = checkpdesol if len(unknown.args) > 1 else checkodesol
    return HOLDS if check(equation, sp.Eq(unknown, formula))[0] else FAILS


def residuals(statement: Statement) -> Iterator[sp.Expr]:
    """Yield the residuals, with the formulas put in and differentiated by SymPy."""
    for equation in statement.equations:
        yield residual_of(statement, equation).doit()


def by_simplify(statement: Statement) -> str:
    """Return whether ``simplify`` brings the residuals to 0; anything else says nothing."""
    zero = all(sp.simplify(residual) == 0 for residual in residuals(statement))
    return HOLDS if zero else SILENT


MAXIMA_NAMES = {
    "I": "%i",
    "pi": "%pi",
    "sign": "signum",
    "re": "realpart",
    "im": "imagpart",
    "elliptic_k": "elliptic_kc",
    "elliptic_e": "elliptic_ec",
}
SIMPLIFIERS = (
    *(
        "ratsimp(r)",
        "radcan(r)",
        "trigsimp(r)",
        "ratsimp(trigsimp(r))",
        "radcan(exponentialize(r))",
    ),
    *("ratsimp(trigsimp(radcan(r)))", "radcan(trigreduce(ratsimp(r)))"),
)
"""What is tried on a residual r, until one gives 0."""


def by_maxima(statement: Statement) -> str:
    """Return whether one of Maxima's simplifiers brings each residual to 0."""
    lines = [f"{known}$" for known in _known(statement)]
    for residual in residuals(statement):
        lines.append(f"r: {in_maxima(residual)}$")
        tries = " or ".join(f"errcatch(is(equal({text}, 0))) = [true]" for text in SIMPLIFIERS)
        lines.append(f"print(if {tries} then ANSWERZERO else ANSWEROTHER)$")
    given = "\n".join(lines)
    done = subprocess.run(
        ["maxima", "--very-quiet"], input=given, capture_output=True, text=True, check=False
    )
    zeros = done.stdout.count("ANSWERZERO")
    return HOLDS if zeros == len(statement.equations) else SILENT


def in_maxima(formula: sp.Expr) -> str:
    """Return a formula in Maxima's words, each symbol with a v before its name.

    >>> x = sp.Symbol("x", real=True)
    >>> in_maxima(sp.sin(x) ** 2 + sp.I)
    'sin(v_x)^2 + %i'
    """

    def word(match: re.Match[str]) -> str:
        name = match[0]
        called = formula_text[match.end() : match.end() + 1] == "("
        return MAXIMA_NAMES.get(name, name if called else f"v_{name}")

    formula_text = formula_as_text(formula)
    return re.sub(r"[A-Za-z]\w*", word, formula_text).replace("**", "^")


def _known(statement: Statement) -> Iterator[str]:
    """Yield the assumptions on variables and parameters."""
    for symbol, domain in statement.domains.items():
        name = in_maxima(symbol)
        if domain.lower != -sp.oo:
            yield f"assume({in_maxima(domain.lower)} < {name})"
        if domain.upper != sp.oo:
            yield f"assume({name} < {in_maxima(domain.upper)})"
        if symbol.is_integer:
            yield f"declare({name}, integer)"


TOOLS: dict[str, Callable[[Statement], str]] = {
    "longwave": by_proof,
    "checkpdesol": by_checkpdesol,
    "simplify": by_simplify,
    "maxima": by_maxima,
}


# processes


def _work(tool: str, text: ProblemText, limit: float) -> tuple[str, float]:
    """Return a tool's answer, and the processor seconds of the tool and its children."""
    os.setpgrp()
    limit_processor(ceil(limit))
    start = time.process_time()
    try:
        answer = TOOLS[tool](text.problem().statement)
    except Exception:  # any failure of a tool is no answer
        answer = SILENT
    inner = resource.getrusage(resource.RUSAGE_CHILDREN)
    return answer, time.process_time() - start + inner.ru_utime + inner.ru_stime


def attempts(
    statements: Sequence[tuple[str, ProblemText]], limit: float, workers: int, report: Progress
) -> Iterator[Attempt]:
    """Ask each tool about each statement, ``workers`` at a time, as they come to an end."""
    task = report.add_task("attempts", total=len(statements))
    jobs = [Job(_work, (tool, text, limit), seconds=PATIENCE * limit) for tool, text in statements]
    for place, call in as_ended(enumerate(jobs), LocalWorkers(workers, isolated=True)):
        answer, seconds = (SILENT, limit) if call.error else call.value
        tool, text = statements[place]
        report.advance(task)
        yield Attempt(tool, text.name, _judged(answer, text.expect), seconds)


def _judged(answer: str, expected: str) -> str:
    if answer in (SILENT, NOT_TAKEN):
        return answer
    return RIGHT if (answer == HOLDS) == (expected == Outcome.PROVED) else WRONG


# what is printed


HEADINGS = ("tool", "of", "statements", RIGHT, WRONG, SILENT, NOT_TAKEN, "median s", "most s")


def attempts_table(found: list[Attempt], texts: Sequence[ProblemText], limit: float) -> Table:
    """Return a table with two rows a tool: the statements that hold, and the wrong variants."""
    table = Table(title=f"The library's statements, {limit:g} s of the processor each")
    for place, heading in enumerate(HEADINGS):
        table.add_column(heading, justify="right" if place > 1 else "left")
    holding = {text.name for text in texts if text.expect == Outcome.PROVED}
    for tool in TOOLS:
        for kind, is_solution in (("solutions", True), ("wrong variants", False)):
            own = [a for a in found if a.tool == tool and (a.name in holding) == is_solution]
            if own:
                counts = [sum(a.answer == k for a in own) for k in HEADINGS[3:7]]
                times = [f"{f(a.seconds for a in own):.2f}" for f in (statistics.median, max)]
                table.add_row(tool, kind, str(len(own)), *map(str, counts), *times)
    return table


def main() -> None:
    """Read the options, ask every tool, print."""
    parser = argparse.ArgumentParser(description="The library put to the prover and to others.")
    parser.add_argument("--only", action="append", metavar="NAME")
    parser.add_argument("--tool", action="append", choices=list(TOOLS))
    parser.add_argument("--sample", type=int, default=48, help="for the others; 0 for all")
    parser.add_argument("--limit", type=float, default=20.0, metavar="SECONDS")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", metavar="FILE", type=Path, help="write each attempt there")
    options = parser.parse_args()
    console = Console(width=120)
    texts = [text for text in published() if not options.only or text.name in options.only]
    chosen = options.tool or list(TOOLS)
    if "maxima" in chosen and shutil.which("maxima") is None:
        console.print("maxima is not installed and left out")
        chosen = [tool for tool in chosen if tool != "maxima"]
    step = max(1, len(texts) // options.sample) if options.sample else 1
    statements = [
        (tool, text) for tool in chosen for text in (texts if tool == "longwave" else texts[::step])
    ]
    with Progress(console=console) as report:
        found = list(attempts(statements, options.limit, options.workers, report))
    for attempt in found:
        if attempt.answer == WRONG:
            console.print(f"wrong: {attempt.tool} on {attempt.name}", highlight=False)
    console.print(attempts_table(found, texts, options.limit))
    if options.json:
        records = [asdict(attempt) for attempt in found]
        options.json.write_text(json.dumps(records, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

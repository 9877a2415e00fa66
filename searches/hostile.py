"""Hostile texts through every door: one line each, within seconds and little memory.

Each text goes through a door in a process of its own: as options of the command, beside
``--solve``, in a problem file, to `longwave.prove` in Python, and, where it is a whole file, as
one.  Prints a table with a row a door, and every text that costs more than it may, says more than
one line or has something evaluated; the exit status is 1 if there is one.

    python -m searches.hostile [--door NAME] [--random 300] [--limit 2]
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import track
from rich.table import Table

import longwave
from longwave.__main__ import main as command
from longwave.support.processes import Job, OutOfTime, run_apart, time_limit
from searches.peak_memory import peak_bytes
from tests.verify.proof.hostile_texts import FILES, Texts, generated, written

SECONDS, MEGABYTES = 5.0, 500.0
PATIENCE = 30.0
"""Seconds after which a process that says nothing is stopped."""

EVALUATION = ("os.system", "subprocess.Popen", "os.exec", "os.posix_spawn", "socket.connect")
PARTS = ("equation", "solution", "parameters", "domain")
USUAL = ("", "u_t + u_x", "u = x - t")
"""What is beside the hostile part of a statement."""


@dataclass(frozen=True)
class Cost:
    """Cost of a text at a door; ``status`` as of the command, -1 if there was no end."""

    status: int
    lines: tuple[str, ...]
    seconds: float
    megabytes: float
    evaluated: tuple[str, ...] = ()

    @property
    def faults(self) -> list[str]:
        """Return the limit that is exceeded, in words; "" for none."""
        found = [f"evaluated {event}" for event in self.evaluated]
        if self.status not in (0, 1, 2):
            found.append("no end" if self.status < 0 else f"status {self.status}")
        if len(self.lines) != 1 or not all(line.isprintable() for line in self.lines):
            found.append(f"{len(self.lines)} lines")
        if self.seconds > SECONDS:
            found.append(f"{self.seconds:.1f} s")
        if self.megabytes > MEGABYTES:
            found.append(f"{self.megabytes:.0f} MB")
        return found


def by_options(texts: Texts, limit: float) -> tuple[int, list[str]]:
    """Run ``longwave prove --equation ... --solution ...``."""
    words = [word for part, text in zip(PARTS, texts, strict=True) for word in (f"--{part}", text)]
    return _commanded([*words, "--limit", str(limit), "--json"])


def by_solving(texts: Texts, limit: float) -> tuple[int, list[str]]:
    """Run the same with ``--solve``: for k, or for the hostile part where it is short."""
    words = [word for part, text in zip(PARTS, texts, strict=True) for word in (f"--{part}", text)]
    sought = next((text for text in texts if text not in USUAL), "k")
    solve = sought if 0 < len(sought) < 20 else "k"
    return _commanded([*words, "--solve", solve, "--limit", str(limit), "--json"])


def by_file(texts: Texts, limit: float) -> tuple[int, list[str]]:
    """Run ``longwave prove FILE.toml`` with the texts in a table."""
    lines = [f"{part} = {_quoted(text)}" for part, text in zip(PARTS, texts, strict=True)]
    return by_content("\n".join(["[[problem]]", *lines]), limit)


def by_content(content: str, limit: float) -> tuple[int, list[str]]:
    """Run ``longwave prove FILE.toml`` with this in the file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hostile.toml"
        path.write_bytes(content.encode("utf-8", "surrogatepass"))
        return _commanded([str(path), "--limit", str(limit), "--json"])


def by_python(texts: Texts, limit: float) -> tuple[int, list[str]]:
    """Run `longwave.prove`, which has no limit of its own; stop it after ``limit`` seconds."""
    equation, solution, parameters, domain = texts
    try:
        with time_limit(limit, passing=True):
            verdict = longwave.prove(equation, solution, parameters=parameters, domain=domain)
    except OutOfTime:
        return 1, [f"stopped after {limit:g} s"]
    except ValueError as error:
        return 2, str(error).split("\n")
    return 0, [verdict.outcome.value]


def _quoted(text: str) -> str:
    """Return the text as TOML's basic string; what TOML cannot hold is left as it is."""
    return json.dumps(text, ensure_ascii=True).replace("\\/", "/")


def _commanded(words: list[str]) -> tuple[int, list[str]]:
    """Run the command; return its status, and the lines of its messages or verdicts."""
    output, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors):
        try:
            status = command(["prove", *words])
        except SystemExit as end:
            status = int(end.code or 0)
    if status == 2:
        return status, [line for line in errors.getvalue().splitlines() if line[:4] != " " * 4]
    return status, [str(record["verdict"]) for record in json.loads(output.getvalue())[:1]]


DOORS: dict[str, Callable[[Any, float], tuple[int, list[str]]]] = {
    "options": by_options,
    "solve": by_solving,
    "file": by_file,
    "python": by_python,
    "whole file": by_content,
}


def _pass(door: str, given: Any, limit: float) -> Cost:
    """Measure the cost of the text, in the child process."""
    evaluated: list[str] = []

    def watch(event: str, arguments: tuple[Any, ...]) -> None:
        named = event == "compile" and arguments[1] in ("<string>", "<stdin>")
        if named or event in EVALUATION:
            evaluated.append(event)

    sys.addaudithook(watch)
    start = time.perf_counter()
    try:
        status, lines = DOORS[door](given, limit)
    except BaseException as error:  # whatever escapes is a finding
        status, lines = 3, [f"{type(error).__name__}: {error}"]
    seconds = time.perf_counter() - start
    inner = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    peak = max(peak_bytes(), inner * 1024) / 1e6
    return Cost(status, tuple(lines), seconds, peak, tuple(evaluated))


def cost(door: str, given: Any, limit: float) -> Cost:
    """Measure the cost of a text at a door, in a process of its own."""
    call = run_apart(Job(_pass, (door, given, limit), seconds=PATIENCE))
    lost = Cost(-1, (), PATIENCE if isinstance(call.error, OutOfTime) else 0.0, 0.0)
    found: Cost = lost if call.error else call.value
    return found


def texts_of(door: str, count: int) -> Iterator[Any]:
    """Yield the texts for a door."""
    yield from FILES if door == "whole file" else (*written(), *generated(count))


def row(door: str, found: list[Cost]) -> list[str]:
    """Return the cells of a door."""
    return [
        door,
        str(len(found)),
        str(sum(one.status == 2 for one in found)),
        str(sum(one.status in (0, 1) for one in found)),
        str(sum(bool(one.faults) for one in found)),
        f"{max(one.seconds for one in found):.1f}",
        f"{max(one.megabytes for one in found):.0f}",
    ]


def main() -> int:
    """Put every text through every door, print; 1 if one of them costs too much."""
    parser = argparse.ArgumentParser(description="Hostile texts through every door.")
    parser.add_argument("--door", action="append", choices=list(DOORS))
    parser.add_argument("--random", type=int, default=300, help="random texts beside those written")
    parser.add_argument("--limit", type=float, default=2.0, help="seconds for a verdict")
    options = parser.parse_args()
    console = Console(width=120)
    table = Table(title=f"Hostile texts: one line, {SECONDS:g} s and {MEGABYTES:g} MB each")
    for heading in ("door", "texts", "refused", "verdicts", "faults", "most s", "most MB"):
        table.add_column(heading, justify="left" if heading == "door" else "right")
    faults = 0
    by_options(("u_x - u", "u = exp(x)", "k: k>0", ""), options.limit)  # imports come first
    longwave.prove("u_x - u", "u = exp(x)")
    for door in options.door or DOORS:
        found = []
        given = list(texts_of(door, options.random))
        for text in track(given, door, console=console):
            found.append(cost(door, text, options.limit))
            if found[-1].faults:
                faults += 1
                words = f"{door}: {', '.join(found[-1].faults)}: {ascii(text)[:300]}"
                console.print(words, *found[-1].lines[:3], markup=False, highlight=False)
        table.add_row(*row(door, found))
    console.print(table)
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())

"""Fuzzing: hostile files and command lines, each in a process of its own, within limits.

An input may take 5 s of the processor unless it says before how long it takes (then it is stopped
by Ctrl-C and must end within 2 s), 1 GB of memory beyond the start, write nothing but what it was
told to, and end with status 0, 1, 2 or 130, an error in one line.  Faults are kept as files, with
what was printed; the inputs of a range do not depend on others, so ranges can run anywhere.

    python -m searches.fuzzing [--kind scene] [--count 1000] [--start 0] [--seed 1] [--keep DIR]
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import shlex
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from searches.fuzz_inputs import KINDS, FuzzCase, case_of
from searches.fuzz_series import endings
from searches.fuzz_server import Ending, FuzzServer, warm_up

SAID = 60.0
"""Seconds between two lines of progress."""

SHARES = {
    "scene": 20,
    "lattice scene": 8,
    "lattice": 32,
    "force law": 4,
    "problem": 12,
    "certificate": 20,
    "sweep": 1,
    "run file": 3,
    "command line": 4,
}
"""Inputs of a round: more of what takes less."""

ROUNDS = 10
"""Rounds that are run kind after kind."""

TRIES = 60
"""Shorter inputs that are tried for a fault."""


@dataclass
class Tally:
    """Counts of a kind, and what its inputs took at most."""

    inputs: int = 0
    statuses: Counter[int | None] = field(default_factory=Counter)
    announced: int = 0
    faults: int = 0
    slowest: float = 0.0
    seconds: float = 0.0
    megabytes: float = 0.0

    def add(self, ending: Ending) -> None:
        """Count an input."""
        self.inputs += 1
        self.statuses[ending.status] += 1
        self.announced += ending.announced
        self.faults += bool(ending.faults)
        self.seconds += ending.seconds
        self.megabytes = max(self.megabytes, ending.megabytes)
        if not ending.announced:
            self.slowest = max(self.slowest, ending.seconds)

    def cells(self) -> list[str]:
        """Return a row of the table."""
        ended = self.statuses
        return [
            *(f"{self.inputs}", f"{ended[0]}", f"{ended[1]}", f"{ended[2]}", f"{self.announced}"),
            *(f"{self.faults}", f"{self.slowest:.1f}", f"{self.megabytes:.0f}"),
            f"{self.seconds / max(self.inputs, 1):.3f}",
        ]


def minimised(server: FuzzServer, case: FuzzCase, ending: Ending) -> FuzzCase:
    """Return a case with fewer lines and words that has the same kind of fault; quick ones only."""
    if ending.seconds > 1.0 or ending.status is None:
        return case
    for _, shorter in zip(range(TRIES), _shorter(case), strict=False):
        if server.ending(shorter).kinds >= ending.kinds:
            return minimised(server, shorter, ending)
    return case


def _shorter(case: FuzzCase) -> Iterator[FuzzCase]:
    """Yield the case without one of its words, or without a stretch of a file's lines."""
    for i in range(len(case.words) - 1, 1, -1):
        yield replace(case, words=case.words[:i] + case.words[i + 1 :])
    for name, content in case.files.items():
        lines = content.split(b"\n")
        size = len(lines)
        while size > 1:
            size //= 2
            for i in range(0, len(lines), size):
                shorter = b"\n".join(lines[:i] + lines[i + size :])
                yield replace(case, files={**case.files, name: shorter})


def keep(folder: Path, name: str, case: FuzzCase, ending: Ending) -> None:
    """Write a fault: its input's files, the words, and what was seen."""
    place = folder / re.sub(r"\W+", "-", name)
    place.mkdir(parents=True, exist_ok=True)
    for file, content in case.files.items():
        (place / file).write_bytes(content)
    known = {
        "words": case.words,
        "faults": ending.faults,
        "status": ending.status,
        "seconds": round(ending.seconds, 2),
        "megabytes": round(ending.megabytes),
        "errors": ending.errors[-3000:],
        "out": ending.out[-500:],
    }
    text = json.dumps(known, indent=1)
    (place / "seen.json").write_text(text, encoding="utf-8")


def fuzz(kinds: Sequence[str], seed: int, rounds: range, folder: Path) -> dict[str, Tally]:
    """Run the inputs of these rounds, a tally a kind; faults are printed and kept.

    Ctrl-C or SIGTERM ends it with the tallies until then.
    """
    tallies = {kind: Tally() for kind in kinds}
    last_report = time.monotonic()
    with contextlib.suppress(KeyboardInterrupt), FuzzServer() as server:
        for kind, numbers in _portions(kinds, rounds):
            cases = [case_of(kind, seed, number) for number in numbers]
            for number, case, ending in zip(numbers, cases, endings(server, cases), strict=True):
                tallies[kind].add(ending)
                if ending.faults:
                    name = f"{kind} {seed} {number}"
                    words = shlex.join(word[:60] for word in case.words)
                    print(ascii(f"{name}: {'; '.join(ending.faults)[:300]}: {words}"), flush=True)
                    keep(folder, name, minimised(server, case, ending), ending)
            if time.monotonic() - last_report > SAID:
                last_report = time.monotonic()
                inputs, faults = (
                    sum(getattr(tally, what) for tally in tallies.values())
                    for what in ("inputs", "faults")
                )
                print(f"{inputs} inputs, {faults} faults", flush=True)
    return tallies


def _portions(kinds: Sequence[str], rounds: range) -> Iterator[tuple[str, range]]:
    """Yield each kind in turn, with the numbers of its inputs in some rounds."""
    for first in range(rounds.start, rounds.stop, ROUNDS):
        last = min(first + ROUNDS, rounds.stop)
        for kind in kinds:
            yield kind, range(first * SHARES[kind], last * SHARES[kind])


def main() -> int:
    """Fuzz and print a table; return 1 if there was a fault."""
    parser = argparse.ArgumentParser(description="Hostile files and command lines.")
    parser.add_argument("--kind", action="append", choices=list(KINDS))
    parser.add_argument("--count", type=int, default=1000, help="inputs of all kinds together")
    parser.add_argument("--start", type=int, default=0, help="the first round")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-faults"), help="folder of faults")
    options = parser.parse_args()
    kinds = options.kind or list(KINDS)
    warm_up()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    count = -(-options.count // sum(SHARES[kind] for kind in kinds))
    rounds = range(options.start, options.start + count)
    tallies = fuzz(kinds, options.seed, rounds, options.keep)
    table = Table(title=f"Fuzzing, seed {options.seed}, rounds {rounds.start} to {rounds.stop - 1}")
    for heading in (
        "kind",
        "inputs",
        "0",
        "1",
        "2",
        "announced",
        "faults",
        "most s",
        "MB",
        "mean s",
    ):
        table.add_column(heading, justify="left" if heading == "kind" else "right")
    for kind, tally in tallies.items():
        table.add_row(kind, *tally.cells())
    Console(width=120).print(table)
    return int(any(tally.faults for tally in tallies.values()))


if __name__ == "__main__":
    sys.exit(main())

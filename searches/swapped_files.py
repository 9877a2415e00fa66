"""Files that are swapped while they are read: no foreign byte, and no mixture of two files.

Every reader of files (`searches.swap_readers`) is called many times while another process puts one
thing after the other at its path, of one size and one time: two contents that it takes, and what it
refuses when it meets it alone. A call may find one of the two contents, or end with an error in one
line. Before that each thing is read alone. Prints a row a reader and every fault; the exit status
is 1 if there is one.

    python -m searches.swapped_files [--reader NAME] [--calls 1000] [--seconds 60] [--seed 0]
"""

from __future__ import annotations

import argparse
import logging
import math
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from rich.console import Console
from rich.table import Table

from longwave.support.processes import Job, LocalWorkers, OutOfTime, time_limit
from longwave.support.sealed_file import LOG
from searches.swap_readers import FIRST, FOREIGN, READERS, SECOND, Case, Folder, State

PAUSE = 0.0005
"""Seconds between two swaps, on average."""

RESTING, REST = 0.1, 3.0
"""How often what is taken stays for long, and how long at most, in times of reading it."""

PATIENCE = 20.0
"""Seconds after which a reader is taken to wait for something."""

MOST_SHOWN = 5
"""Faults of a reader that are printed."""

ERROR, NOTHING = "error", "nothing"


class Swaps:
    """States of a case's path, one at a time."""

    def __init__(self, path: Path) -> None:
        self._path, self._draft = path, path.with_name(f".swap-{path.name}")
        self._away: Path | None = None
        self._home: Path | None = None

    def put(self, state: State) -> None:
        """Put a state there, a file or a link in the place of another in one step."""
        if self._home is not None:  # a folder, which nothing replaces in one step
            self._path.rename(self._home)
            self._home = None
        with suppress(FileNotFoundError):
            self._draft.unlink()
        if state.file.is_dir() and not state.is_link:
            self._path.unlink(missing_ok=True)
            state.file.rename(self._path)
            self._home = state.file
            return
        if state.is_link:
            self._draft.symlink_to(state.file)
        else:
            os.link(state.file, self._draft)
        self._draft.replace(self._path)

    def clear(self) -> None:
        """Leave nothing there."""
        if self._home is not None:
            self._path.rename(self._home)
            self._home = None
        self._path.unlink(missing_ok=True)


def swap(path: Path, states: Sequence[State], rest: float, seed: int, end: Path) -> int:
    """Put states at the path at random until there is the file ``end``; return how many.

    One that is taken stays for ``rest`` seconds now and then: a slow reader comes to its end.
    """
    random, swaps, count = Random(seed), Swaps(path), 0
    taken = [state for state in states if state.value is not None]
    others = [state for state in states if state.value is None]
    while not (count % 50 == 0 and end.exists()):
        is_taken = not others or random.random() < 0.5
        swaps.put(random.choice(taken if is_taken else others))
        count += 1
        rests = is_taken and random.random() < RESTING
        time.sleep(random.uniform(0, rest if rests else 2 * PAUSE))
    swaps.clear()
    return count


@contextmanager
def swapped(case: Case, rest: float, seed: int, folder: Path) -> Iterator[Callable[[], int]]:
    """Swap the case's path in another process; yield a function that stops and counts."""
    end = folder / "end"
    workers = LocalWorkers(1, isolated=True)
    call = workers.submit(Job(swap, (case.path, case.states, rest, seed, end)))

    def ended() -> int:
        end.touch()
        while not workers.ended(1.0):
            pass
        return int(call.result())

    try:
        while not os.path.lexists(case.path) and call.error is None:
            workers.ended(0.001)
        yield ended
    finally:
        workers.stop()


@dataclass
class Found:
    """Endings of a reader's calls, and the faults."""

    swaps: int = 0
    calls: Counter[object] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    slowest: float = 0.0

    def add(self, outcome: object, fault: str) -> None:
        """Count a call."""
        self.calls[outcome] += 1
        if fault:
            self.faults.append(fault)


def judged(case: Case) -> tuple[object, str]:
    """Read once: the value that was found or that there was none, and what is wrong with it."""
    try:
        with time_limit(PATIENCE, passing=True):
            values = {float(value) for value in case.read()}
    except OutOfTime:
        return ERROR, f"it waits for more than {PATIENCE:g} s"
    except (ValueError, OSError, MemoryError) as error:
        return ERROR, f"an error of several lines: {error!r}" if "\n" in str(error) else ""
    except Exception as error:
        return ERROR, f"{type(error).__name__}: {error}"
    if FOREIGN in values:
        return FOREIGN, f"foreign bytes: {sorted(values)}"
    if len(values) > 1 or not values <= {FIRST, SECOND}:
        return NOTHING, f"no content that was there: {sorted(values)}"
    return next(iter(values), NOTHING), ""


def alone(case: Case) -> list[str]:
    """Return faults of a reader that meets each state alone."""
    faults, swaps = [], Swaps(case.path)
    for state in case.states:
        swaps.put(state)
        outcome, fault = judged(case)
        if outcome == ERROR and not fault:  # a store that was wrong of a pack looks again
            outcome, fault = judged(case)
        refused = outcome in (ERROR, NOTHING)
        if fault or (outcome != state.value if state.value is not None else not refused):
            faults.append(f"{state.name} alone: {fault or outcome}, expected {state.value}")
    swaps.clear()
    return faults


def search(
    reader: str, calls: int, seconds: float = math.inf, seed: int = 0, stop: bool = False
) -> Found:
    """Call a reader so often, or so long, while its file is swapped; ``stop`` at a fault."""
    found = Found()
    with tempfile.TemporaryDirectory() as name:
        case = READERS[reader](Folder(Path(name) / "case"))
        begun = time.monotonic()
        found.faults += alone(case)
        rest = REST * (time.monotonic() - begun) / len(case.states)
        with swapped(case, rest, seed, Path(name)) as ended:
            last = time.monotonic() + seconds
            while sum(found.calls.values()) < calls and time.monotonic() < last:
                begun = time.monotonic()
                found.add(*judged(case))
                found.slowest = max(found.slowest, time.monotonic() - begun)
                if stop and found.faults:
                    break
            found.swaps = ended()
    return found


def row(reader: str, found: Found) -> list[str]:
    """Return the cells of a reader."""
    counts = [found.calls[outcome] for outcome in (FIRST, SECOND, ERROR, NOTHING, FOREIGN)]
    numbers = [sum(counts), found.swaps, *counts, len(found.faults)]
    return [reader, *map(str, numbers), f"{found.slowest:.2f}"]


def main() -> int:
    """Swap the files of every reader, print; 1 if one of them has a fault."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--reader", action="append", choices=list(READERS))
    parser.add_argument("--calls", type=int, default=1000)
    parser.add_argument("--seconds", type=float, default=math.inf, help="the most for a reader")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    LOG.setLevel(logging.CRITICAL)
    console, table = Console(width=120), Table(title="Files that are swapped while they are read")
    for heading in (
        *("reader", "calls", "swaps", "first", "second", "error", "nothing", "foreign", "faults"),
        "most s",
    ):
        table.add_column(heading, justify="left" if heading == "reader" else "right")
    faults = 0
    for reader in options.reader or READERS:
        found = search(reader, options.calls, options.seconds, options.seed)
        faults += len(found.faults)
        for fault in found.faults[:MOST_SHOWN]:
            console.print(f"{reader}: {fault}", markup=False, highlight=False)
        table.add_row(*row(reader, found))
    console.print(table)
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())

"""A command in a process: its output, its seconds, and the memory of all its processes."""

import os
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from longwave.support.supervision import processes_of
from tests.conftest import PATIENCE

HOUSE = Path(__file__).parents[3]
HOSTILE = Path(__file__).parent / "hostile_start"

LOOK, ENDING = 0.05, 20.0
"""Seconds between two looks at the memory, and for what was killed to be gone."""


@dataclass(frozen=True)
class Ended:
    """Result of a command: exit status, output, wall-clock seconds, and the peak resident memory of
    all its processes in bytes; ``left`` lists processes that are still running."""

    status: int
    out: str
    errors: str
    seconds: float
    memory: int
    left: tuple[int, ...]


def watched(words: list[str], folder: Path, hostile: str = "") -> Ended:
    """Run ``longwave words`` in a folder, with a function replaced as ``hostile`` says."""
    path = os.pathsep.join(map(str, [HOSTILE, HOUSE] if hostile else [HOUSE]))
    settings = {"PYTHONPATH": path, "LONGWAVE_NO_APT": "1"} | (
        {"HOSTILE": hostile} if hostile else {}
    )
    begun = time.monotonic()
    with (folder / "out").open("w+") as out, (folder / "errors").open("w+") as errors:
        running = subprocess.Popen(
            [sys.executable, "-P", "-m", "longwave", *words],
            stdin=subprocess.DEVNULL, stdout=out, stderr=errors, cwd=folder,
            env={**os.environ, **settings}, start_new_session=True,
        )  # fmt: skip
        memory, seen = 0, set[int]()
        try:
            while running.poll() is None and time.monotonic() < begun + PATIENCE:
                processes = processes_of(running.pid)
                seen.update(processes)
                memory = max(memory, sum(map(_resident, processes)))
                time.sleep(LOOK)
            seconds = time.monotonic() - begun
            left = _left(seen)
        finally:
            with suppress(ProcessLookupError):
                os.killpg(running.pid, 9)
            running.wait()
        outputs = [(stream.seek(0), stream.read())[1] for stream in (out, errors)]
    return Ended(running.returncode, *outputs, seconds, memory, left)


def _left(processes: Iterable[int]) -> tuple[int, ...]:
    """Return the processes that do not end within `ENDING` seconds."""
    end = time.monotonic() + ENDING
    while (left := tuple(filter(_resident, processes))) and time.monotonic() < end:
        time.sleep(LOOK)
    return left


def _resident(process: int) -> int:
    """Return the resident bytes of a process, with shared memory divided among its users."""
    with suppress(OSError):
        text = Path(f"/proc/{process}/smaps_rollup").read_text(encoding="ascii")
        return sum(1024 * int(line.split()[1]) for line in text.splitlines() if line[:4] == "Pss:")
    return 0

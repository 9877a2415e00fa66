"""The systems that certificates are written for: how a script is made and run, what it answers."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from .coq import coq_script
from .scripts import MAXIMA, PARI, script
from .terms import WrittenProof

ACCEPTED, REJECTED, NO_ANSWER = "accepted", "rejected", "no answer"

MEMORY = "2000M"
"""For PARI, which takes 8 MB unless told."""

SHORTAGES = ("stack overflow", "out of memory", "heap exhausted", "cannot allocate")
"""What a system says that has not the means to answer, in small letters."""


@dataclass(frozen=True)
class AlgebraSystem:
    """A system: its program, Debian package and file ending, the writer and the command line."""

    title: str
    program: str
    package: str
    ending: str
    write: Callable[[WrittenProof], str]
    command: Callable[[str], list[str]]

    @property
    def is_there(self) -> bool:
        """Whether its program is on the path."""
        return shutil.which(self.program) is not None


SYSTEMS: Mapping[str, AlgebraSystem] = {
    "pari": AlgebraSystem(
        "PARI/GP",
        "gp",
        "pari-gp",
        ".gp",
        lambda proof: script(proof, PARI),
        lambda file: ["gp", "--quiet", "--fast", "--default", f"parisizemax={MEMORY}", file],
    ),
    "maxima": AlgebraSystem(
        "Maxima",
        "maxima",
        "maxima",
        ".mac",
        lambda proof: script(proof, MAXIMA),
        lambda file: ["maxima", "--very-quiet", f'--batch-string=batchload("{file}")$'],
    ),
    "coq": AlgebraSystem("Coq", "coqc", "coq", ".v", coq_script, lambda file: ["coqc", "-q", file]),
}


_running: set[subprocess.Popen[bytes]] = set()


def stop_answers() -> None:
    """End the systems that are at work, in whatever thread they are waited for: no answer."""
    for process in tuple(_running):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)


def answer(text: str, system: str, seconds: float) -> tuple[str, float]:
    """What a system says of a script within a limit, and the seconds that it took.

    It is "accepted" only if the system ends well and says so in its last line.
    """
    found = SYSTEMS[system]
    with tempfile.TemporaryDirectory() as folder:
        file = f"proof{found.ending}"
        (Path(folder) / file).write_text(text, encoding="ascii")
        begun = time.monotonic()
        with subprocess.Popen(
            found.command(file),
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        ) as process:
            _running.add(process)
            try:
                output, _ = process.communicate(timeout=seconds)
            except subprocess.TimeoutExpired:
                return NO_ANSWER, seconds
            finally:
                _running.discard(process)
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGKILL)
        taken = time.monotonic() - begun
    return _understood(output.decode(errors="replace"), process.returncode), taken


def _understood(output: str, status: int) -> str:
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    last = lines[-1] if lines else ""
    short = any(word in output.lower() for word in SHORTAGES)
    if last == ACCEPTED and status == 0 and REJECTED not in lines and not short:
        return ACCEPTED
    failed = last == REJECTED or REJECTED in lines or "Error:" in output
    return REJECTED if failed and not short and status >= 0 else NO_ANSWER

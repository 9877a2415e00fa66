"""External systems for exported certificates: writing a script, running it, reading its answer."""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from longwave.support.processes import LostProcess, OutOfTime, run_program

from .coq import coq_script
from .scripts import MAXIMA, PARI, script
from .terms import WrittenProof

ACCEPTED, REJECTED, NO_ANSWER = "accepted", "rejected", "no answer"

PARI_MEMORY = "2000M"
"""Memory limit of PARI, whose default is 8 MB."""

SHORTAGES = ("stack overflow", "out of memory", "heap exhausted", "cannot allocate")
"""Lower-case messages of a system that ran out of memory."""


@dataclass(frozen=True)
class AlgebraSystem:
    """A system: program, Debian package, file ending, script writer and command line."""

    title: str
    program: str
    package: str
    ending: str
    write: Callable[[WrittenProof], str]
    command: Callable[[str], list[str]]

    @property
    def is_there(self) -> bool:
        """Whether the program is on the path."""
        return shutil.which(self.program) is not None


SYSTEMS: Mapping[str, AlgebraSystem] = {
    "pari": AlgebraSystem(
        *("PARI/GP", "gp", "pari-gp", ".gp"),
        lambda proof: script(proof, PARI),
        lambda file: ["gp", "--quiet", "--fast", "--default", f"parisizemax={PARI_MEMORY}", file],
    ),
    "maxima": AlgebraSystem(
        *("Maxima", "maxima", "maxima", ".mac"),
        lambda proof: script(proof, MAXIMA),
        lambda file: ["maxima", "--very-quiet", f'--batch-string=batchload("{file}")$'],
    ),
    "coq": AlgebraSystem("Coq", "coqc", "coq", ".v", coq_script, lambda file: ["coqc", "-q", file]),
}


def answer(text: str, system: str, seconds: float) -> tuple[str, float]:
    """Run a script; return "accepted" or another answer, and the seconds it took."""
    own = SYSTEMS[system]
    with tempfile.TemporaryDirectory() as name:
        folder, file = Path(name), f"proof{own.ending}"
        (folder / file).write_text(text, encoding="ascii")
        begun = time.monotonic()
        try:
            status, output = run_program(own.command(file), folder, seconds)
        except (OutOfTime, LostProcess):
            return NO_ANSWER, seconds
        return _understood(output, status), time.monotonic() - begun


def _understood(output: str, status: int) -> str:
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    last = lines[-1] if lines else ""
    short = any(word in output.lower() for word in SHORTAGES)
    if last == ACCEPTED and status == 0 and REJECTED not in lines and not short:
        return ACCEPTED
    failed = last == REJECTED or REJECTED in lines or "Error:" in output
    return REJECTED if failed and not short and status >= 0 else NO_ANSWER

"""``longwave verify recheck``: other systems repeat the proofs of catalogue and library."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from rich.markup import escape
from rich.table import Table

from longwave.cli.statements import decided
from longwave.support.command_line import check_and_announce
from longwave.support.console import finished, print_lines, print_results, table_console, tracked
from longwave.support.processes import Job, LocalWorkers, in_order
from longwave.verify.proof import CertificateError
from longwave.verify.proof.catalogue_proofs import NAMES, prove_named
from longwave.verify.proof.export.derivation import written_out
from longwave.verify.proof.export.systems import (
    ACCEPTED,
    NO_ANSWER,
    REJECTED,
    SYSTEMS,
    answer,
)
from longwave.verify.proof.export.terms import WrittenProof, premises_in_short
from longwave.verify.published import chosen
from longwave.verify.verdict import Outcome

LIMIT = 120.0
"""Seconds for a system and a proof unless told. Most proofs take Coq 2 s of processor time, most of
them for the part that all scripts have in common; PARI and Maxima take less than 1 s."""

PROVING, REPEATING = 0.5, 3.5
"""About the seconds that a proof takes, and its repetition by all three systems."""

NO_APT = "LONGWAVE_NO_APT"
MISSING, NO_SCRIPT = "not installed", "no script"


@dataclass(frozen=True)
class Rechecked:
    """What each system said of a statement, if what holds, and the seconds of all."""

    name: str
    answers: Mapping[str, str]
    premises: Sequence[str]
    seconds: float

    def json(self) -> dict[str, Any]:
        """The answers as plain data."""
        return asdict(self)


def print_rechecks(
    names: Sequence[str], limit: float | None, json_wanted: bool, program: str
) -> int:
    """Have all proofs repeated and print the table; the exit status.

    0 if every system that is there accepts every statement, or has no answer; 1 if one rejects;
    130 after Ctrl-C. Raises ValueError for a name that is none.
    """
    seconds = LIMIT if limit is None else limit
    if not 0 < seconds < 1e6:
        raise ValueError(f"--limit must be more than 0 and less than 1e6, got {seconds:g}")
    count = len(names) or len(NAMES) + len(chosen([]))
    each = PROVING + min(REPEATING, len(SYSTEMS) * seconds) / (os.cpu_count() or 1)
    work = f"the proofs of {count} statements, repeated"
    check_and_announce(work, count * each, cheaper="name fewer with --only")
    proofs = proofs_of(names)
    install_systems()
    found, complete = finished(tracked(rechecks(proofs, seconds), len(proofs), "rechecking"))
    asked = f"{len(proofs)} statements"
    status = print_results(found, complete, _print, json_wanted, program, asked)
    return status or int(any(REJECTED in entry.answers.values() for entry in found))


def install_systems() -> None:
    """Install the systems that are missing with apt-get, where root may and nothing forbids it.

    What is missing then is said in one line, and marked in the table.
    """
    packages = [system.package for system in SYSTEMS.values() if not system.is_there]
    if not packages:
        return
    if not os.environ.get(NO_APT) and shutil.which("apt-get") and os.geteuid() == 0:
        said = f"installing {' '.join(packages)} with apt-get ({NO_APT}=1 forbids)"
        print(said, file=sys.stderr)
        settings = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        for words in ("update", f"install -y --no-install-recommends {' '.join(packages)}"):
            subprocess.run(["apt-get", "-qq", *words.split()], env=settings, check=False)
    missing = [system.package for system in SYSTEMS.values() if not system.is_there]
    if missing:
        print(f"not installed: {', '.join(missing)} (install these packages)", file=sys.stderr)


Proofs = list[tuple[str, Sequence[Mapping[str, Any]]]]
"""Names of statements, and the certificates of each."""


def proofs_of(names: Sequence[str] = ()) -> Proofs:
    """The proofs of these forms and statements of the library; without names all.

    Raises ValueError for a name that is of neither.
    """
    verdicts = [prove_named(name) for name in NAMES if not names or name in names]
    found: Proofs = [(v.name, [v.certificate]) for v in verdicts if v.certificate is not None]
    rest = [name for name in names if name not in NAMES]
    if rest or not names:
        problems = [text.problem() for text in chosen(rest, NAMES)]
        stated = [p for p in problems if p.expect in ("", Outcome.PROVED)]
        for place, verdict in sorted(decided(stated), key=lambda pair: pair[0]):
            if verdict.outcome is Outcome.PROVED:
                found.append((stated[place].statement.name, verdict.certificates))
    return found


def rechecks(proofs: Proofs, limit: float) -> Iterator[Rechecked]:
    """What each system says of each statement, on all cores, in the order of the proofs."""
    jobs = (Job(_recheck, (name, parts, limit)) for name, parts in proofs)
    return in_order(jobs, LocalWorkers(os.cpu_count() or 1, isolated=True))


def _recheck(name: str, certificates: Sequence[Mapping[str, Any]], limit: float) -> Rechecked:
    try:
        proofs = [written_out(certificate) for certificate in certificates]
    except CertificateError:
        return Rechecked(name, dict.fromkeys(SYSTEMS, NO_SCRIPT), [], 0.0)
    found = {system: _answers(proofs, system, limit) for system in SYSTEMS}
    worst = {system: worst_of([word for word, _ in said]) for system, said in found.items()}
    premises = list(dict.fromkeys(words for proof in proofs for words in proof.conditions))
    seconds = sum(taken for said in found.values() for _, taken in said)
    return Rechecked(name, worst, premises, seconds)


def _answers(proofs: Sequence[WrittenProof], system: str, limit: float) -> list[tuple[str, float]]:
    if not SYSTEMS[system].is_there:
        return [(MISSING, 0.0)]
    return [answer(SYSTEMS[system].write(proof), system, limit) for proof in proofs]


def worst_of(words: Sequence[str]) -> str:
    """One word for all parts of a statement: accepted only if each of them is."""
    if REJECTED in words:
        return REJECTED
    others = [word for word in words if word != ACCEPTED]
    return [*others, ACCEPTED][0] if words else NO_ANSWER


def _print(found: Sequence[Rechecked]) -> None:
    """One row a statement: its name, each system's word, if what holds, seconds."""
    table = Table(title="The proofs, repeated by other systems")
    table.add_column("statement", no_wrap=True)
    for system in SYSTEMS.values():
        table.add_column(system.title, no_wrap=True)
    table.add_column("if")
    table.add_column("seconds", justify="right")
    for entry in found:
        premises = escape(premises_in_short(entry.premises))
        table.add_row(entry.name, *entry.answers.values(), premises, f"{entry.seconds:.1f}")
    console = table_console()
    console.print(table)
    print_lines(console, [_summary(found)])


def _summary(found: Sequence[Rechecked]) -> str:
    parts = []
    for name, system in SYSTEMS.items():
        counts = Counter(entry.answers[name] for entry in found)
        words = ", ".join(f"{count} {word}" for word, count in counts.items())
        parts.append(f"{system.title}: {words}")
    if any(ACCEPTED in entry.answers.values() for entry in found):
        parts.append("accepted means proved if the premises hold (--json has all of them)")
    return f"{len(found)} statements; {'; '.join(parts)}"

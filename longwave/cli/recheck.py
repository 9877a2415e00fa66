"""``longwave verify recheck``: other systems repeat the proofs of the catalogue and the library."""

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

from longwave.cli.statements import decide_statements
from longwave.support.command_line import check_and_announce
from longwave.support.console import finished, print_lines, print_results, table_console, tracked
from longwave.support.processes import Job, LocalWorkers, in_order
from longwave.verify.proof import CertificateError
from longwave.verify.proof.catalogue_proofs import NAMES, prove_named
from longwave.verify.proof.export import systems
from longwave.verify.proof.export.derivation import written_out
from longwave.verify.proof.export.terms import WrittenProof, premises_in_short
from longwave.verify.published import chosen
from longwave.verify.verdict import Outcome

DEFAULT_LIMIT = 120.0
"""Default time limit in seconds for each system and proof. Most proofs take Coq 2 s of processor
time, mainly for the part that all scripts share; PARI and Maxima take less than 1 s."""

PROOF_SECONDS, REPETITION_SECONDS = 0.5, 3.5
"""Approximate seconds for a proof, and for its repetition by all three systems."""

NO_APT = "LONGWAVE_NO_APT"
"""Environment variable that forbids installing PARI/GP, Maxima and Coq with apt-get."""

MISSING, NO_SCRIPT = "not installed", "no script"
"""Table entries for a system that is not installed, and for a proof without a script."""


@dataclass(frozen=True)
class Recheck:
    """Answer of each system to one statement, the premises of its proof, and the total seconds."""

    name: str
    answers: Mapping[str, str]
    premises: Sequence[str]
    seconds: float

    def json(self) -> dict[str, Any]:
        """Return the answers as plain data."""
        return asdict(self)


def print_rechecks(
    names: Sequence[str], limit: float | None, json_wanted: bool, program: str
) -> int:
    """Repeat the proofs with other systems and print the table; return the exit status.

    The status is 0 if no system rejects a statement, 1 if one does, 130 after Ctrl-C. Raises
    ValueError for an unknown name.
    """
    seconds = DEFAULT_LIMIT if limit is None else limit
    if not 0 < seconds < 1e6:
        raise ValueError(f"--limit must be more than 0 and less than 1e6, got {seconds:g}")
    count = len(names) or len(NAMES) + len(chosen([]))
    repetition = min(REPETITION_SECONDS, len(systems.SYSTEMS) * seconds)
    seconds_each = PROOF_SECONDS + repetition / (os.cpu_count() or 1)
    work = f"the proofs of {count} statements, repeated"
    check_and_announce(work, count * seconds_each, cheaper="name fewer with --only")
    proofs = proofs_of(names)
    install_systems()
    results, complete = finished(tracked(rechecks(proofs, seconds), len(proofs), "rechecking"))
    requested = f"{len(proofs)} statements"
    status = print_results(results, complete, _print_table, json_wanted, program, requested)
    return status or int(any(systems.REJECTED in entry.answers.values() for entry in results))


def install_systems() -> None:
    """Install missing systems with apt-get, if the user is root and `NO_APT` is not set.

    Systems that are still missing are named in one line on stderr, and marked in the table.
    """
    packages = [system.package for system in systems.SYSTEMS.values() if not system.is_there]
    if not packages:
        return
    if not os.environ.get(NO_APT) and shutil.which("apt-get") and os.geteuid() == 0:
        notice = f"installing {' '.join(packages)} with apt-get ({NO_APT}=1 forbids)"
        print(notice, file=sys.stderr)
        settings = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        for arguments in ("update", f"install -y --no-install-recommends {' '.join(packages)}"):
            subprocess.run(["apt-get", "-qq", *arguments.split()], env=settings, check=False)
    missing = [system.package for system in systems.SYSTEMS.values() if not system.is_there]
    if missing:
        print(f"not installed: {', '.join(missing)} (install these packages)", file=sys.stderr)


Proofs = list[tuple[str, Sequence[Mapping[str, Any]]]]
"""Names of statements, each with its certificates."""


def proofs_of(names: Sequence[str] = ()) -> Proofs:
    """Return the proofs of the named forms and statements (default: all); ValueError if unknown."""
    verdicts = [prove_named(name) for name in NAMES if not names or name in names]
    proofs: Proofs = [(v.name, [v.certificate]) for v in verdicts if v.certificate is not None]
    other_names = [name for name in names if name not in NAMES]
    if other_names or not names:
        problems = [text.problem() for text in chosen(other_names, NAMES)]
        expected = [problem for problem in problems if problem.expect in ("", Outcome.PROVED)]
        for index, verdict in sorted(decide_statements(expected), key=lambda pair: pair[0]):
            if verdict.outcome is Outcome.PROVED:
                proofs.append((expected[index].statement.name, verdict.certificates))
    return proofs


def rechecks(proofs: Proofs, limit: float) -> Iterator[Recheck]:
    """Yield the answers of all systems to each statement, in order, using all cores."""
    jobs = (Job(_recheck, (name, parts, limit)) for name, parts in proofs)
    return in_order(jobs, LocalWorkers(os.cpu_count() or 1, isolated=True))


def _recheck(name: str, certificates: Sequence[Mapping[str, Any]], limit: float) -> Recheck:
    try:
        proofs = [written_out(certificate) for certificate in certificates]
    except CertificateError:
        return Recheck(name, dict.fromkeys(systems.SYSTEMS, NO_SCRIPT), [], 0.0)
    answers = {system: _answers(proofs, system, limit) for system in systems.SYSTEMS}
    worst = {system: worst_of([outcome for outcome, _ in a]) for system, a in answers.items()}
    premises = list(dict.fromkeys(words for proof in proofs for words in proof.conditions))
    seconds = sum(taken for pairs in answers.values() for _, taken in pairs)
    return Recheck(name, worst, premises, seconds)


def _answers(proofs: Sequence[WrittenProof], system: str, limit: float) -> list[tuple[str, float]]:
    if not systems.SYSTEMS[system].is_there:
        return [(MISSING, 0.0)]
    return [systems.answer(systems.SYSTEMS[system].write(proof), system, limit) for proof in proofs]


def worst_of(outcomes: Sequence[str]) -> str:
    """Return the outcome of a statement from the outcomes of its parts.

    It is "rejected" if any part is rejected, "accepted" if all parts are, else that of the first
    part that is not accepted.
    """
    if systems.REJECTED in outcomes:
        return systems.REJECTED
    others = [outcome for outcome in outcomes if outcome != systems.ACCEPTED]
    return [*others, systems.ACCEPTED][0] if outcomes else systems.NO_ANSWER


def _print_table(results: Sequence[Recheck]) -> None:
    """Print one row for each statement: name, answers, premises, seconds."""
    table = Table(title="The proofs, repeated by other systems")
    table.add_column("statement", no_wrap=True)
    for system in systems.SYSTEMS.values():
        table.add_column(system.title, no_wrap=True)
    table.add_column("if")
    table.add_column("seconds", justify="right")
    for entry in results:
        premises = escape(premises_in_short(entry.premises))
        table.add_row(entry.name, *entry.answers.values(), premises, f"{entry.seconds:.1f}")
    console = table_console()
    console.print(table)
    print_lines(console, [_summary(results)])


def _summary(results: Sequence[Recheck]) -> str:
    parts = []
    for name, system in systems.SYSTEMS.items():
        counts = Counter(entry.answers[name] for entry in results)
        counts_text = ", ".join(f"{count} {word}" for word, count in counts.items())
        parts.append(f"{system.title}: {counts_text}")
    if any(systems.ACCEPTED in entry.answers.values() for entry in results):
        parts.append("accepted means proved if the premises hold (--json has all of them)")
    return f"{len(results)} statements; {'; '.join(parts)}"

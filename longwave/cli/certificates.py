"""Files of proofs, which are written here; ``longwave check FILE`` repeats those in one.

The checker counts before it works (`verify.kernel.limits`).  What would slip through ends
at a limit of time and memory, in a process of its own: the last line of defence against hostile
input.
"""

from __future__ import annotations

import glob
import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from longwave.support.atomic_file import write_atomically
from longwave.support.command_line import fail, one_line
from longwave.support.console import check_output, print_json
from longwave.support.processes import Job, limit_processor, run_apart
from longwave.support.user_files import QUOTED, read_text, shown_path
from longwave.verify.kernel.limits import FILE_BYTES
from longwave.verify.proof import CertificateError, check_certificate
from longwave.verify.proof.export.derivation import written_out
from longwave.verify.proof.export.systems import SYSTEMS
from longwave.verify.proof.export.terms import premises_in_short

T = TypeVar("T")

CERTIFICATES = 100
"""Most certificates in a file."""


@dataclass(frozen=True)
class ProofFile:
    """The file ``output`` of proofs: their certificates or, for a ``system``, a script of each.

    Several scripts get a number each. Without ``output`` nothing is written.
    """

    output: str | None
    system: str | None = None
    force: bool = False

    def check(self, read: Sequence[str | Path] = ()) -> None:
        """Raise ValueError, before the work, if it cannot or may not be written.

        What is ``read`` is never overwritten.
        """
        if self.output is None:
            if self.system is not None:
                raise ValueError("--export must be given with --output FILE, got no file")
            return
        example = "c.json" if self.system is None else "proof.v"
        check_output(self.output, example, force=self.force, read=read)
        path = Path(self.output)
        others = sorted(path.parent.glob(f"{glob.escape(path.stem)}_[0-9]*{path.suffix}"))
        if self.system is not None and others and not self.force:
            raise ValueError(
                f"--output must name new files, got {self.output} beside {others[0].name}, "
                "which is there (--force overwrites it)"
            )

    def write(self, certificates: Sequence[Mapping[str, Any]]) -> None:
        """Write what is proved; of scripts, tell the premises on the standard error.

        Raises CertificateError for a proof that has no script, ValueError for scripts of none,
        OSError as writing does.
        """
        if self.output is None:
            return
        path = Path(self.output)
        if self.system is None:
            texts = [json.dumps(certificate) for certificate in certificates]
            self._write(path, "[" + ",\n".join(texts) + "]\n")
            return
        if not certificates:
            raise ValueError(
                "--export must be given with what is proved, got no proof (see verdict)"
            )
        proofs = [written_out(certificate) for certificate in certificates]
        texts = [SYSTEMS[self.system].write(proof) for proof in proofs]
        for number, (text, proof) in enumerate(zip(texts, proofs, strict=True), 1):
            file = path if len(texts) == 1 else path.with_stem(f"{path.stem}_{number}")
            self._write(file, text)
            if proof.premises:
                conditions = premises_in_short(proof.conditions)
                print(f"{file}: accepted will mean proved if {conditions}", file=sys.stderr)

    def _write(self, path: Path, text: str) -> None:
        write_atomically(path, lambda draft: draft.write_text(text, encoding="utf-8"), self.force)


def print_certificates(
    path: Path,
    json_wanted: bool = False,
    output: str | None = None,
    system: str | None = None,
    force: bool = False,
) -> int:
    """Check every certificate of a file: what it states and "accepted", 1 at the first failure.

    As JSON a list of the accepted, name and statement. 2 if the file cannot be read at all.
    Scripts for a ``system`` are written to ``output`` if all are accepted.
    """
    accepted: list[dict[str, str]] = []
    status, scripts = 0, ProofFile(output, system, force)
    try:
        scripts.check([path])
        if output is not None and system is None:
            raise ValueError("--output must be given with --export, got it alone (leave it)")
    except ValueError as error:
        return fail(error)
    try:
        certificates = read_certificates(path)
        for certificate in certificates:
            record = limited(checked, certificate)
            accepted.append(record)
            if not json_wanted:
                lines = (f"    {line}" for line in record["statement"].splitlines())
                print(f"{record['name']}:", *lines, f"{record['name']}: accepted", sep="\n")
        scripts.write(certificates)
    except BrokenPipeError:
        raise
    except OSError as error:
        if output is not None and error.filename == output:
            return fail(error)
        return fail(
            f"FILE must be readable, got {shown_path(path)}: {error.strerror} "
            "(one that --output wrote)"
        )
    except CertificateError as error:
        print(f"{shown_path(path)}: rejected: {error}", file=sys.stderr)
        status = 1
    if json_wanted:
        print_json(accepted)
    return status


def read_certificates(path: Path) -> list[Any]:
    """The certificates in a file: one, or a list of them.

    Raises CertificateError if the file is too long, its text no JSON or without a certificate,
    OSError as opening does.
    """
    try:
        text = read_text(path, "the file", FILE_BYTES)
    except ValueError as error:
        raise CertificateError(str(error)) from None
    try:
        data = json.loads(text, parse_constant=_refused, object_pairs_hook=_distinct)
    except (ValueError, RecursionError) as error:
        why = one_line(error)[:QUOTED]
        raise CertificateError(f"the file is no JSON text ({why})") from error
    certificates = data if isinstance(data, list) else [data]
    if not 0 < len(certificates) <= CERTIFICATES:
        held = "no certificate" if not certificates else f"more than {CERTIFICATES} certificates"
        raise CertificateError(f"the file holds {held}")
    return certificates


def checked(certificate: Any) -> dict[str, str]:
    """Name and statement of an accepted certificate; raises CertificateError if it is not."""
    if not isinstance(certificate, Mapping):
        got = type(certificate).__name__
        raise CertificateError(f"certificate must be an object, got {got} (prove writes one)")
    name = ascii(certificate.get("name"))[:60].strip("'")
    try:
        statement = check_certificate(certificate)
    except CertificateError as error:
        raise CertificateError(f"{name}: {error}") from error
    return {"name": name, "statement": statement}


def _refused(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number of JSON")


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("an object has a key twice")
    return found


SECONDS, BYTES = 5, 500_000_000


def limited(work: Callable[..., T], *arguments: object) -> T:
    """What ``work`` returns; its CertificateError, or one that says that it took too much."""
    call = run_apart(Job(_limited, (work, arguments), memory=BYTES))
    if isinstance(call.error, CertificateError):
        raise call.error
    if call.error is not None:
        raise CertificateError(f"it took more than {SECONDS} s or {BYTES // 10**6} MB")
    found: T = call.value
    return found


def _limited(work: Callable[..., T], arguments: tuple[object, ...]) -> T:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # where FLINT says that memory is short
    limit_processor(SECONDS)
    return work(*arguments)

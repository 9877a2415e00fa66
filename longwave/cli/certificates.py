"""Files of certificates: written by the proving commands, checked by ``longwave check FILE``.

The checker counts the work before it starts (`verify.kernel.limits`). As a last line of defence
against hostile input, each check also runs in a separate process with limits of time and memory.
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
from longwave.waves.kernel import check as wave_check
from longwave.waves.kernel.limits import CertificateError as WaveCertificateError

T = TypeVar("T")

MAX_CERTIFICATES = 100
"""Largest number of certificates in a file."""


@dataclass(frozen=True)
class ProofFile:
    """Output file for proofs: certificates, or one script each for the proof assistant ``system``.

    Several scripts get numbered names. Without ``output`` nothing is written.
    """

    output: str | None
    system: str | None = None
    force: bool = False

    def check(self, read: Sequence[str | Path] = ()) -> None:
        """Raise ValueError, before any work, if the file cannot or may not be written.

        Input files, listed in ``read``, are never overwritten.
        """
        if self.output is None and self.system is not None:
            raise ValueError("--export must be given with --output FILE, got no file")
        if self.output is None:
            return
        example = "c.json" if self.system is None else "proof.v"
        check_output(self.output, example, force=self.force, read=read)
        path = Path(self.output)
        others = sorted(path.parent.glob(f"{glob.escape(path.stem)}_[0-9]*{path.suffix}"))
        if self.system is not None and others and not self.force:
            raise ValueError(
                f"--output must name new files, got {self.output} next to the existing file "
                f"{others[0].name} (--force overwrites it)"
            )

    def write(self, certificates: Sequence[Mapping[str, Any]]) -> None:
        """Write the certificates, or their scripts; print the premises of scripts on stderr.

        Raises CertificateError for a proof that cannot be written as a script, ValueError if
        scripts are requested for no certificates, and OSError if writing fails.
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
                "--export must be given with something proved, got no proof (see the verdict)"
            )
        proofs = [written_out(certificate) for certificate in certificates]
        texts = [SYSTEMS[self.system].write(proof) for proof in proofs]
        for number, (text, proof) in enumerate(zip(texts, proofs, strict=True), 1):
            file = path if len(texts) == 1 else path.with_stem(f"{path.stem}_{number}")
            self._write(file, text)
            if proof.premises:
                conditions = premises_in_short(proof.conditions)
                print(f"{file}: if accepted, proved provided that {conditions}", file=sys.stderr)

    def _write(self, path: Path, text: str) -> None:
        write_atomically(path, lambda draft: draft.write_text(text, encoding="utf-8"), self.force)


def print_certificates(
    path: Path,
    json_wanted: bool = False,
    output: str | None = None,
    system: str | None = None,
    force: bool = False,
) -> int:
    """Check every certificate of a file and print its statement and "accepted"; return the status.

    The status is 0 if all are accepted, 1 if one is rejected (checking stops there), 2 if the file
    cannot be read. As JSON, the output is a list of the accepted certificates with name and
    statement. If all are accepted, scripts for a ``system`` are written to ``output``.
    """
    accepted: list[dict[str, str]] = []
    status, scripts = 0, ProofFile(output, system, force)
    try:
        scripts.check([path])
        if output is not None and system is None:
            raise ValueError("--output must be given with --export, got it alone (leave it out)")
    except ValueError as error:
        return fail(error)
    try:
        certificates = read_certificates(path)
        for certificate in certificates:
            record = run_limited(check_one, certificate)
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
            "(name a file that --output wrote)"
        )
    except CertificateError as error:
        print(f"{shown_path(path)}: rejected: {error}", file=sys.stderr)
        status = 1
    if json_wanted:
        print_json(accepted)
    return status


def read_certificates(path: Path) -> list[Any]:
    """Return the certificates in a file, which has one or a list of them.

    Raises CertificateError if the file is too long, is not JSON or has no certificate, and OSError
    if it cannot be opened.
    """
    try:
        text = read_text(path, "the file", FILE_BYTES)
    except ValueError as error:
        raise CertificateError(str(error)) from None
    try:
        data = json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_distinct_keys)
    except (ValueError, RecursionError) as error:
        reason = one_line(error)[:QUOTED]
        raise CertificateError(f"the file is not JSON ({reason})") from error
    certificates = data if isinstance(data, list) else [data]
    if not 0 < len(certificates) <= MAX_CERTIFICATES:
        content = f"more than {MAX_CERTIFICATES} certificates" if certificates else "no certificate"
        raise CertificateError(f"the file holds {content}")
    return certificates


def check_one(certificate: Any) -> dict[str, str]:
    """Return name and statement of a certificate; raise CertificateError if it is not accepted."""
    if not isinstance(certificate, Mapping):
        got = type(certificate).__name__
        raise CertificateError(f"certificate must be an object, got {got} (prove writes one)")
    if isinstance(certificate.get("kind"), str):
        name, check = certificate["kind"][:60], wave_check.check_certificate
    else:
        name, check = ascii(certificate.get("name"))[:60].strip("'"), check_certificate
    try:
        statement = check(certificate)
    except (CertificateError, WaveCertificateError) as error:
        raise CertificateError(f"{name}: {error}") from error
    return {"name": name, "statement": statement}


def _refuse_constant(text: str) -> NoReturn:
    raise ValueError(f"{text} is not a JSON number")


def _distinct_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    entries = dict(pairs)
    if len(entries) != len(pairs):
        raise ValueError("an object must have distinct keys, got one twice (write the file anew)")
    return entries


MOST_SECONDS, MOST_MEMORY = 5, 500_000_000
"""Limits for checking one certificate: seconds of processor time, and bytes of memory."""


def run_limited(work: Callable[..., T], *arguments: object) -> T:
    """Return the result of ``work``; CertificateError if it exceeds time or memory limits."""
    call = run_apart(Job(_run_with_cpu_limit, (work, arguments), memory=MOST_MEMORY))
    if isinstance(call.error, CertificateError):
        raise call.error
    if call.error is not None:
        limits = f"{MOST_SECONDS} s or {MOST_MEMORY // 10**6} MB"
        raise CertificateError(f"the check took more than {limits}")
    result: T = call.value
    return result


def _run_with_cpu_limit(work: Callable[..., T], arguments: tuple[object, ...]) -> T:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # hides FLINT's message about low memory
    limit_processor(MOST_SECONDS)
    return work(*arguments)

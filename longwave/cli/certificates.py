"""``longwave check FILE``: repeat the proofs in a file, without the prover.

The checker counts before it works (`verify.kernel.limits`).  What would slip through ends
at a limit of time and memory, in a process of its own: the last line of defence against hostile
input.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn, TypeVar

from longwave.cli.exporting import ProofFile
from longwave.support.command_line import fail, one_line
from longwave.support.processes import Job, limit_processor, run_apart
from longwave.support.user_files import QUOTED, read_text, shown_path
from longwave.verify.kernel.limits import FILE_BYTES
from longwave.verify.proof import CertificateError, check_certificate

T = TypeVar("T")

CERTIFICATES = 100
"""Most certificates in a file."""


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
                print(lines_of(record))
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
        print(json.dumps(accepted, indent=2))
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


def lines_of(accepted: Mapping[str, str]) -> str:
    """An accepted certificate in words: what it states, and that it is accepted."""
    lines = "\n".join(f"    {line}" for line in accepted["statement"].splitlines())
    return f"{accepted['name']}:\n{lines}\n{accepted['name']}: accepted"


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

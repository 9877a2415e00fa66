"""``python -m verify check-certificate FILE``: repeat the proofs in a file, without the prover."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from verify.cli.parser import OneLineParser, fail
from verify.proof.checker import check_certificate
from verify.proof.meanings import CertificateError


def certificate_command(argv: list[str]) -> int:
    """Check every certificate of a file: one line each, 1 at the first that fails.

    2 if the file cannot be read at all.
    """
    parser = OneLineParser(
        prog="python -m verify check-certificate",
        description="Repeat the proofs of a file written by --certificate, with other arithmetic.",
    )
    parser.add_argument("file", type=Path, metavar="FILE")
    path = parser.parse_args(argv).file
    try:
        for certificate in read_certificates(path):
            print(check_line(certificate))
    except OSError as error:
        return fail(
            f"FILE must be readable, got {path}: {error.strerror} (one that --certificate wrote)"
        )
    except CertificateError as error:
        print(f"{path}: rejected: {error}", file=sys.stderr)
        return 1
    return 0


def read_certificates(path: Path) -> list[Any]:
    """The certificates in a file: one, or a list of them.

    Raises CertificateError if the text is no JSON or holds none, OSError as opening does.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise CertificateError(f"the file is no JSON text ({error})") from error
    certificates = data if isinstance(data, list) else [data]
    if not certificates:
        raise CertificateError("the file holds no certificate")
    return certificates


def check_line(certificate: Any) -> str:
    """One line on an accepted certificate; raises CertificateError if it is not."""
    if not isinstance(certificate, Mapping):
        raise CertificateError(f"a certificate is an object, got {type(certificate).__name__}")
    name = certificate.get("name")
    try:
        check_certificate(certificate)
    except CertificateError as error:
        raise CertificateError(f"{name}: {error}") from error
    return f"{name}: accepted, {len(certificate['generators'])} generators, numerator 0"

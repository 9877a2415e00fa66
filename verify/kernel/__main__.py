"""``python -m longwave.verify.kernel FILE``: repeat the proofs in a file, by this folder alone."""

from __future__ import annotations

import json
import sys
from typing import Any

from .check import check_certificate
from .limits import FILE_BYTES, CertificateError


def main(arguments: list[str]) -> int:
    """Print each certificate's statement; return 0 if all are accepted, 1 at the first failure."""
    if len(arguments) != 1:
        print("usage: python -m longwave.verify.kernel FILE", file=sys.stderr)
        return 2
    try:
        for certificate in certificates(arguments[0]):
            print(check_certificate(certificate), "accepted", sep="\n")
    except OSError as error:
        print(f"FILE must be readable: {error.strerror}", file=sys.stderr)
        return 2
    except CertificateError as error:
        print(f"rejected: {error}", file=sys.stderr)
        return 1
    return 0


def certificates(path: str) -> list[Any]:
    """Read a JSON file with one certificate or a list of them; return them as a list."""
    with open(path, "rb") as file:
        text = file.read(FILE_BYTES + 1)
    if len(text) > FILE_BYTES:
        raise CertificateError(f"the file must have at most {FILE_BYTES} bytes")
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise CertificateError("the file is no JSON text") from error
    return data if isinstance(data, list) and data else [data]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""``python -m longwave.waves.kernel FILE``: repeat the proofs in a file, by this folder alone."""

from __future__ import annotations

import json
import sys

from .check import check_certificate
from .limits import FILE_BYTES, CertificateError
from .reading import without_doubles


def main(arguments: list[str]) -> int:
    """Print what each certificate of a file proves, up to the first that fails.

    Returns the exit status: 0 if all are accepted, 1 if one fails, 2 for a wrong call or an
    unreadable file.
    """
    if len(arguments) != 1:
        print("usage: python -m longwave.waves.kernel FILE", file=sys.stderr)
        return 2
    try:
        with open(arguments[0], "rb") as file:
            text = file.read(FILE_BYTES + 1)
        if len(text) > FILE_BYTES:
            raise CertificateError(f"the file must have at most {FILE_BYTES} bytes")
        data = json.loads(text, object_pairs_hook=without_doubles)
        for certificate in data if isinstance(data, list) else [data]:
            print(check_certificate(certificate), "accepted", sep="\n")
    except OSError as error:
        print(f"FILE must be readable: {error.strerror}", file=sys.stderr)
        return 2
    except (ValueError, RecursionError) as error:
        print(f"rejected: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

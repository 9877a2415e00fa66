"""``longwave prove ... --export SYSTEM``: certificates as scripts of other systems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from verify.proof.export.systems import exported


def write_scripts(path: Path, certificates: Sequence[Mapping[str, Any]], system: str) -> list[Path]:
    """Write a script for each certificate: one into ``path``, several with a number in the name.

    Raises CertificateError for a certificate that has no script, ValueError where there is none,
    OSError as writing does.
    """
    if not certificates:
        raise ValueError("--export must be given with what is proved, got no proof (see verdict)")
    texts = [exported(certificate, system) for certificate in certificates]
    paths = [path]
    if len(texts) > 1:
        paths = [path.with_stem(f"{path.stem}_{number}") for number in range(1, len(texts) + 1)]
    for file, text in zip(paths, texts, strict=True):
        file.write_text(text, encoding="ascii")
    return paths

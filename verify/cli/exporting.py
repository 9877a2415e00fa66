"""``longwave prove ... --export SYSTEM``: certificates as scripts of other systems."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from derive.user_files import shown_path
from verify.proof.export.systems import exported


def check_written(text: str | Path | None, read: Sequence[str | Path] = ()) -> None:
    """Raise ValueError if what is to be written was read, or is of a kind that is only read.

    >>> check_written("waves.toml")
    Traceback (most recent call last):
    ...
    ValueError: output must be a file of its own, got waves.toml (such as proof.json)
    """
    if text is None:
        return
    inputs = {os.path.realpath(name) for name in read}
    if os.path.realpath(text) in inputs or Path(text).suffix.lower() in INPUTS:
        raise ValueError(
            f"output must be a file of its own, got {shown_path(text)} (such as proof.json)"
        )


INPUTS = (".toml", ".nc")
"""Endings of scenes, lattices, problems and runs."""


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

"""What made a run: the versions of packages, the machine, and the code.

Two runs of a scene whose provenance is the same have the same bits; where they differ it says what
was different.
"""

from __future__ import annotations

import hashlib
import platform
from functools import lru_cache
from pathlib import Path

from longwave.support.compiled.native_code import processor
from longwave.support.compiled.source_digest import HOUSE, compiler_settings, installed_version

PACKAGES = (
    *("longwave", "numpy", "scipy", "numba", "llvmlite", "ducc0", "sympy", "mpmath"),
    *("python-flint", "xarray", "h5netcdf"),
)

CODE = ("support", "derive", "solutions", "lattice", "scenes")
"""Folders, with those in them, that hold all that a run is computed by: formulas are imported by
name, so following imports would not do."""

PROVENANCE = ("versions", "platform", "code")
"""The attributes of a run that `provenance` gives."""


@lru_cache
def provenance() -> dict[str, str]:
    """Attributes of a run: ``versions``, ``platform`` and ``code``, digests of its folders.

    >>> sorted(provenance())
    ['code', 'platform', 'versions']
    """
    versions = [f"{package} {installed_version(package) or 'missing'}" for package in PACKAGES]
    name, _, features = processor().partition(" ")
    machine = [
        *(platform.platform(), f"{name} {_digest(features.encode())}"),
        *compiler_settings(),
    ]
    return {
        "versions": ", ".join([*versions, f"Python {platform.python_version()}"]),
        "platform": ", ".join(machine),
        "code": ", ".join(f"{folder} {digest}" for folder, digest in code_digests().items()),
    }


def changed_parts(name: str, before: str, now: str) -> list[str]:
    """Lines that say in what an attribute of `provenance` differs from another.

    >>> changed_parts("code", "derive 12, lattice 34", "derive 12, lattice 56")
    ['code: lattice 56, was lattice 34']
    """
    parts = before.split(", "), now.split(", ")
    gone, come = (
        [part for part in one if part not in other] for one, other in (parts, parts[::-1])
    )
    if not gone and not come:
        return []
    return [f"{name}: {', '.join(come) or 'nothing'}, was {', '.join(gone) or 'nothing'}"]


def code_digests() -> dict[str, str]:
    """The digest (hexadecimal) of the Python files of each folder that a run is computed by.

    >>> "solutions/forms" in code_digests()
    True
    """
    found: dict[str, list[Path]] = {}
    for file, path in code_files().items():
        found.setdefault(file.parent.as_posix(), []).append(path)
    return {folder: _digest(*map(_content, paths)) for folder, paths in sorted(found.items())}


def code_files() -> dict[Path, Path]:
    """The Python files that a run is computed by, under their names in the house."""
    paths = (path for room in CODE for path in sorted((HOUSE / room).rglob("*.py")))
    return {path.relative_to(HOUSE): path for path in paths}


def _content(path: Path) -> bytes:
    return path.name.encode() + b"\n" + path.read_bytes()


def _digest(*contents: bytes) -> str:
    parts = b"".join(hashlib.sha256(content).digest() for content in contents)
    return hashlib.sha256(parts).hexdigest()[:12]

"""Provenance of a run: versions of packages, machine, and code.

Two runs of a scene with the same provenance have the same bits; otherwise it shows the differences.
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
"""Folders with all code that computes runs; some modules are imported by name only."""

PROVENANCE = ("versions", "platform", "code")
"""Names of the attributes that `provenance` returns."""


@lru_cache
def provenance() -> dict[str, str]:
    """Return attributes of a run: ``versions``, ``platform``, and digests of the ``code`` folders.

    >>> sorted(provenance())
    ['code', 'platform', 'versions']
    """
    versions = [f"{package} {installed_version(package) or 'missing'}" for package in PACKAGES]
    name, _, features = processor().partition(" ")
    machine = [*(platform.platform(), f"{name} {_digest(features.encode())}"), *compiler_settings()]
    return {
        "versions": ", ".join([*versions, f"Python {platform.python_version()}"]),
        "platform": ", ".join(machine),
        "code": ", ".join(f"{folder} {digest}" for folder, digest in code_digests().items()),
    }


def changed_parts(name: str, before: str, now: str) -> list[str]:
    """Return lines that say how the attribute ``name`` of `provenance` differs from an earlier one.

    >>> changed_parts("code", "derive 12, lattice 34", "derive 12, lattice 56")
    ['code: lattice 56, was lattice 34']
    """
    parts = before.split(", "), now.split(", ")
    removed, added = ([p for p in one if p not in other] for one, other in (parts, parts[::-1]))
    if not removed and not added:
        return []
    return [f"{name}: {', '.join(added) or 'nothing'}, was {', '.join(removed) or 'nothing'}"]


def code_digests() -> dict[str, str]:
    """Return the digest (hexadecimal) of the Python files in each folder of `CODE`.

    >>> "solutions/forms" in code_digests()
    True
    """
    contents: dict[str, list[bytes]] = {}
    for file, path in code_files().items():
        content = path.name.encode() + b"\n" + path.read_bytes()
        contents.setdefault(file.parent.as_posix(), []).append(content)
    return {folder: _digest(*files) for folder, files in sorted(contents.items())}


def code_files() -> dict[Path, Path]:
    """Return the Python files in `CODE` by their path in the repository."""
    paths = (path for room in CODE for path in sorted((HOUSE / room).rglob("*.py")))
    return {path.relative_to(HOUSE): path for path in paths}


def _digest(*contents: bytes) -> str:
    parts = b"".join(hashlib.sha256(content).digest() for content in contents)
    return hashlib.sha256(parts).hexdigest()[:12]

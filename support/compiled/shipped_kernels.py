"""Kernels that come with the package as text in LLVM's language: a first run need not write them.

Numba takes seconds to write the text of a kernel, LLVM a tenth of that to make machine code of it.
So `support.compiled.kernel_writer` writes the text when the package is built, for the
``examples`` of every kernel, and `shipped_text` finds it again where the sources, the kinds of
arguments, the versions and settings of the compilers, and the computer are those it was written
for. Anywhere else, and in a checkout, numba writes it as before.

Numba lays out loops for the vectors of the processor that it runs on. That changes the speed and no
bit of a kernel whose operations are all rounded one by one: its text serves every processor of the
architecture. Where products and sums may be contracted it serves the processor it was written for.
"""

from __future__ import annotations

import hashlib
import zlib
from pathlib import Path

from longwave.support.compiled.kernel_folder import numba_settings
from longwave.support.compiled.source_digest import Files, all_sources, are_older, kernel_digest
from longwave.support.sealed_file import read_sealed

FOLDER = Path(__file__).with_name("kernel_texts")
"""Folder of the texts, which a checkout does not have."""


def shipped_text(module: str, key: str) -> str | None:
    """Return the text of a kernel that came with the package; None if there is none for it here."""
    if not FOLDER.is_dir():
        return None
    sources = all_sources((module,))
    if not are_older(sources):
        return None
    for computer in computers():
        packed = read_sealed(FOLDER / file_name(sources, key, computer))
        if packed is not None:
            return zlib.decompress(packed).decode()
    return None


def computers() -> tuple[str, str]:
    """Return what texts may be for: this processor, and all of its architecture and system."""
    from llvmlite import binding  # type: ignore[import-untyped]

    from longwave.support.compiled.native_code import processor

    anywhere = f"{binding.get_process_triple()} {object.__basicsize__}"
    return f"{anywhere} {processor()}", anywhere


def file_name(sources: Files, key: str, computer: str) -> str:
    """Return the name of the file of a kernel."""
    parts = [kernel_digest(sources), key, computer, *numba_settings()]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:40] + ".ll.z"

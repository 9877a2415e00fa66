"""Kernels shipped as LLVM text with the package, so that a first run need not generate them.

Numba takes seconds to generate the text of a kernel, LLVM a tenth of that to compile it.
`support.compiled.kernel_writer` generates the text for the ``examples`` of every kernel when the
package is built. `shipped_text` finds it if the sources, the types of arguments, the versions and
settings of the compilers, and the computer are the same. Otherwise, and in a checkout, numba
generates it.

Numba vectorises loops for the processor that it runs on. That changes the speed but no bit of a
kernel whose operations are all rounded separately: its text serves every processor of the
architecture. If products and sums may be contracted, it serves only the processor it was generated
for.
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
    """Return the shipped text of a kernel, or None if there is none for this kind of computer."""
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
    """Return identifiers of this processor, and of its architecture and system."""
    from llvmlite import binding  # type: ignore[import-untyped]

    from longwave.support.compiled.native_code import processor

    anywhere = f"{binding.get_process_triple()} {object.__basicsize__}"
    return f"{anywhere} {processor()}", anywhere


def file_name(sources: Files, key: str, computer: str) -> str:
    """Return the file name of a kernel's text."""
    parts = [kernel_digest(sources), key, computer, *numba_settings()]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:40] + ".ll.z"

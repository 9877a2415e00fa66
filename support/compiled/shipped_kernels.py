"""Kernels that come with the package as text in LLVM's language: a first run need not write them.

Numba takes seconds to write the text of a kernel, LLVM a tenth of that to make machine code of it.
So `write_kernels` writes the text when the package is built (`tools/build_kernels.py`), for the
``examples`` of every kernel, and `shipped_text` finds it again where the sources, the kinds of
arguments, the versions and settings of the compilers, and the computer are those it was written
for. Anywhere else, and in a checkout, numba writes it as before.

Numba lays out loops for the vectors of the processor that it runs on. That changes the speed and no
bit of a kernel whose operations are all rounded one by one: its text serves every processor of the
architecture. Where products and sums may be contracted it serves the processor it was written for.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import zlib
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from longwave.support.compiled.kernel_folder import numba_settings
from longwave.support.compiled.source_digest import (
    PACKAGE,
    ROOT,
    Files,
    all_sources,
    are_older,
    kernel_digest,
)
from longwave.support.sealed_file import read_sealed, write_sealed

FOLDER = Path(__file__).with_name("kernel_texts")
"""Folder of the texts, which a checkout does not have."""

DECLARED = "examples="
"""Text that a module with kernels to be shipped contains."""

FOR_ONE_PROCESSOR = re.compile(r"\b(contract|reassoc|fast|afn|arcp)\b|\bllvm\.x86\.(avx|fma)")
"""Flags by which results depend on the processor, and operations that not all processors have."""

Task = tuple[str, str, int]
"""Module and name of a kernel, and the number of one of its examples."""


def shipped_text(module: str, key: str) -> str | None:
    """Return the text of a kernel that came with the package; None if there is none for it here."""
    if not FOLDER.is_dir():
        return None
    sources = all_sources((module,))
    if not are_older(sources):
        return None
    for computer in _computers():
        packed = read_sealed(FOLDER / _file_name(sources, key, computer))
        if packed is not None:
            return zlib.decompress(packed).decode()
    return None


def write_kernels(folder: Path = FOLDER) -> int:
    """Write the texts of all kernels of the package that have examples; return their number.

    Each is written by a process of its own, as the first one of a run is: some functions of numba
    take their flags from the first kernel that needs them. Nothing is written if one cannot be.
    What an earlier build left in the folder is removed.
    """
    import multiprocessing

    from longwave.support.compiled.jit import compile_complex_product

    shutil.rmtree(folder, ignore_errors=True)
    tasks = [*_tasks()]
    compile_complex_product()  # which brings numba into all of the processes
    with multiprocessing.get_context("fork").Pool(maxtasksperchild=1) as pool:
        files = pool.map(_packed, tasks, chunksize=1)
    folder.mkdir()
    for name, packed in files:
        write_sealed(folder / name, packed, durable=False)
    return len(files)


def _tasks() -> Iterator[Task]:
    from longwave.support.compiled.jit import Kernel

    for module in modules_with_kernels():
        for name, value in vars(import_module(module)).items():
            if isinstance(value, Kernel) and value.__module__ == module:
                yield from ((module, name, number) for number in range(len(value.examples)))


def modules_with_kernels() -> list[str]:
    """Return the modules of the package that declare examples of kernels."""
    found = []
    for folder, _, names in os.walk(ROOT / PACKAGE, followlinks=True):
        for path in (Path(folder, name) for name in names if name.endswith(".py")):
            if path.name != Path(__file__).name and DECLARED in path.read_text(encoding="utf-8"):
                found.append(".".join(path.relative_to(ROOT).with_suffix("").parts))
    return sorted(found)


def _packed(task: Task) -> tuple[str, bytes]:
    """Return the name and the content of a kernel's file."""
    module, name, number = task
    kernel: Any = getattr(import_module(module), name)
    text: str = kernel.text(kernel.examples[number])
    here, anywhere = _computers()
    computer = here if FOR_ONE_PROCESSOR.search(text) else anywhere
    key = kernel.key(kernel.examples[number])
    return _file_name(all_sources((module,)), key, computer), zlib.compress(text.encode(), 9)


def _computers() -> tuple[str, str]:
    """Return what texts may be for: this processor, and all of its architecture and system."""
    from llvmlite import binding  # type: ignore[import-untyped]

    from longwave.support.compiled.native_code import processor

    anywhere = f"{binding.get_process_triple()} {object.__basicsize__}"
    return f"{anywhere} {processor()}", anywhere


def _file_name(sources: Files, key: str, computer: str) -> str:
    parts = [kernel_digest(sources), key, computer, *numba_settings()]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:40] + ".ll.z"

"""Generation of the shipped kernels' texts when the package is built (`tools/build_kernels.py`)."""

from __future__ import annotations

import multiprocessing
import os
import re
import shutil
import zlib
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from longwave.support.compiled.jit import Kernel, compile_complex_product
from longwave.support.compiled.shipped_kernels import FOLDER, computers, file_name
from longwave.support.compiled.source_digest import PACKAGE, ROOT, all_sources
from longwave.support.sealed_file import write_sealed

DECLARED = "examples="
"""Text that occurs in every module with kernels to be shipped."""

FOR_ONE_PROCESSOR = re.compile(r"\b(contract|reassoc|fast|afn|arcp)\b|\bllvm\.x86\.(avx|fma)")
"""Pattern of LLVM flags and instructions whose results, or presence, depend on the processor."""

Task = tuple[str, str, int]
"""Module and name of a kernel, and the index of one of its examples."""


def write_kernels(folder: Path = FOLDER) -> int:
    """Write the texts of all kernels of the package that have examples; return their number.

    Each text is generated in its own process, as in the first run that needs it: some functions of
    numba take their flags from the first kernel that calls them. Nothing is written if one text
    cannot be generated. The folder's earlier content is removed.
    """
    shutil.rmtree(folder, ignore_errors=True)
    tasks = [*_tasks()]
    compile_complex_product()  # imports numba before the processes are forked
    with multiprocessing.get_context("fork").Pool(maxtasksperchild=1) as pool:
        files = pool.map(_packed, tasks, chunksize=1)
    folder.mkdir()
    for name, packed in files:
        write_sealed(folder / name, packed, durable=False)
    return len(files)


def _tasks() -> Iterator[Task]:
    """Yield a task for each example of each kernel."""
    for module in modules_with_kernels():
        for name, value in vars(import_module(module)).items():
            if isinstance(value, Kernel) and value.__module__ == module:
                yield from ((module, name, number) for number in range(len(value.examples)))


def modules_with_kernels() -> list[str]:
    """Return the names of the package's modules that declare examples of kernels."""
    modules = []
    for folder, _, names in os.walk(ROOT / PACKAGE, followlinks=True):
        for path in (Path(folder, name) for name in names if name.endswith(".py")):
            if path.name != Path(__file__).name and DECLARED in path.read_text(encoding="utf-8"):
                modules.append(".".join(path.relative_to(ROOT).with_suffix("").parts))
    return sorted(modules)


def _packed(task: Task) -> tuple[str, bytes]:
    """Return the name and the compressed content of the file with a kernel's text."""
    module, name, number = task
    kernel: Any = getattr(import_module(module), name)
    text: str = kernel.text(kernel.examples[number])
    here, anywhere = computers()
    computer = here if FOR_ONE_PROCESSOR.search(text) else anywhere
    key = kernel.key(kernel.examples[number])
    return file_name(all_sources((module,)), key, computer), zlib.compress(text.encode(), 9)

"""LLVM modules made into functions of this process, and kept on disk."""

from __future__ import annotations

import ctypes
import hashlib
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]
from numpy.typing import NDArray

from longwave.support.compiled.entry_point import processor
from longwave.support.compiled.kernel_folder import cache_folder, read_whole, write_whole
from longwave.support.compiled.source_digest import source_digest

__all__ = ["aligned", "native_functions"]

ALIGNMENT = 8
"""Doubles in a line of the cache."""

_lock = threading.Lock()
_engines: list[Any] = []
"""What holds the machine code: as long as the process lives."""


@lru_cache(maxsize=1)
def _machine() -> Any:
    """The processor at hand, with all that it can."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    target = binding.Target.from_triple(binding.get_process_triple())
    features = binding.get_host_cpu_features().flatten()
    return target.create_target_machine(
        cpu=binding.get_host_cpu_name(), features=features, opt=3, jit=True
    )


def native_functions(
    module: str, key: str, written: Callable[[], str], functions: Mapping[str, Sequence[Any]]
) -> list[Callable[..., None]]:
    """The ``functions``, each of which takes its arguments (ctypes) and gives none.

    They are in the LLVM module that ``written`` gives as text. That is asked for once only: the
    machine code is kept under the ``key`` and the sources of the project's ``module``. Other
    threads may run while a function does.
    """
    with _lock:
        code = _object_code(module, key, written)
        triple = binding.get_process_triple()
        engine = binding.create_mcjit_compiler(
            binding.parse_assembly(f'target triple = "{triple}"'), _machine()
        )
        engine.add_object_file(binding.ObjectFileRef.from_data(code))
        engine.finalize_object()
        _engines.append(engine)
        return [
            ctypes.CFUNCTYPE(None, *arguments)(engine.get_function_address(name))
            for name, arguments in functions.items()
        ]


def _object_code(module: str, key: str, written: Callable[[], str]) -> bytes:
    """The machine code, as it was kept or compiled now."""
    folder = cache_folder(module, source_digest(module))
    digest = hashlib.sha256(f"{processor()}\n{key}".encode()).hexdigest()[:24]
    path = None if folder is None else folder / f"{digest}.object"
    kept = None if path is None else read_whole(path)
    if kept is not None:
        return kept
    parsed = binding.parse_assembly(written())
    parsed.triple, parsed.data_layout = _machine().triple, str(_machine().target_data)
    parsed.verify()
    options = binding.create_pipeline_tuning_options(speed_level=3)
    builder = binding.create_pass_builder(_machine(), options)
    builder.getModulePassManager().run(parsed, builder)
    code: bytes = _machine().emit_object(parsed)
    if path is not None:
        write_whole(path, code)
    return code


def aligned(*shape: int) -> NDArray[np.float64]:
    """Zeros that begin at a line of the cache."""
    size = math.prod(shape)
    raw = np.zeros(size + ALIGNMENT)
    offset = (-(raw.ctypes.data // 8)) % ALIGNMENT
    return raw[offset : offset + size].reshape(shape)

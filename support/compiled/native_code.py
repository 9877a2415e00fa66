"""LLVM's language made into functions of this process; their machine code is kept on disk."""

from __future__ import annotations

import hashlib
import math
import threading
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from llvmlite import binding  # type: ignore[import-untyped]

from longwave.support.compiled.kernel_folder import cache_folder

SUFFIX = ".object"
"""Of the files of machine code."""

_lock = threading.Lock()
_engines: list[Any] = []
"""What holds the machine code: as long as the process lives."""


@lru_cache
def processor() -> str:
    """The processor that machine code is for."""
    return f"{binding.get_host_cpu_name()} {binding.get_host_cpu_features().flatten()}"


@lru_cache
def multiplies_and_adds_at_once() -> bool:
    """Whether the processor has a product and sum that are rounded once."""
    architecture = binding.get_process_triple().partition("-")[0]
    fused = bool(binding.get_host_cpu_features().get("fma"))
    return fused or architecture in ("aarch64", "arm64")


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
    module: str, key: str, written: Callable[[], str], functions: Mapping[str, Any]
) -> list[Callable[..., Any]]:
    """The ``functions``, given by name with their prototypes (of ctypes).

    They are in the LLVM module that ``written`` gives as text. That is asked for once only: the
    machine code is kept under the ``key`` and the sources of the project's ``module``. Other
    threads may run while a function does.
    """
    digest = hashlib.sha256(f"{processor()}\n{key}".encode()).hexdigest()[:24]
    with _lock:
        code = cache_folder(module).kept(f"{digest}{SUFFIX}", lambda: _compiled(written()))
        triple = binding.get_process_triple()
        engine = binding.create_mcjit_compiler(
            binding.parse_assembly(f'target triple = "{triple}"'), _machine()
        )
        engine.add_object_file(binding.ObjectFileRef.from_data(code))
        engine.finalize_object()
        _engines.append(engine)
        return [
            prototype(engine.get_function_address(name)) for name, prototype in functions.items()
        ]


def _compiled(text: str) -> bytes:
    """The machine code; of what it lacked LLVM would end the process that loads it.

    By the passes over single functions: what is written is laid out for vectors already, and those
    over the whole module take 0.21 s for it in the place of 0.08, with the same speed and bits.
    """
    parsed = binding.parse_assembly(text)
    parsed.triple, parsed.data_layout = _machine().triple, str(_machine().target_data)
    parsed.verify()
    options = binding.create_pipeline_tuning_options(speed_level=1)
    builder = binding.create_pass_builder(_machine(), options)
    passes = builder.getFunctionPassManager()
    for function in parsed.functions:
        if not function.is_declaration:
            passes.run(function, builder)
    for value in (*parsed.functions, *parsed.global_variables):
        name = value.name
        if value.is_declaration and not (name.startswith("llvm.") or hasattr(math, name)):
            raise TypeError(
                "machine code must call nothing but itself and C's mathematical functions, got "
                f"{name} (NRT_ stands for arrays that are made: give it its space)"
            )
    code: bytes = _machine().emit_object(parsed)
    return code

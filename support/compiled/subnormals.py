"""Machine code that flushes subnormal numbers, below 2.3e-308, to 0.

The tails of a wave on zero become subnormal, and on Intel processors an operation with a subnormal
number takes 100 cycles and more. Machine code that advances a lattice sets the processor's mode on
entry and restores it on exit: FTZ and DAZ of MXCSR on x86-64, FZ of FPCR on aarch64. The mode
belongs to a thread, so every thread that calls the code sets its own. On other processors nothing
is done.

Double-double arithmetic does not use it, because its error bounds need gradual underflow.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import binding, ir  # type: ignore[import-untyped]

X86_FLUSH = 1 << 15 | 1 << 6
"""Bits FTZ and DAZ of MXCSR (Intel 64 and IA-32 Architectures manual, volume 1, 10.2.3)."""

ARM_FLUSH = 1 << 24
"""Bit FZ of FPCR (Arm Architecture Reference Manual for A-profile, C5.2.8)."""

_WORD, _LONG = ir.IntType(32), ir.IntType(64)


@contextmanager
def flushed_subnormals(module: Any, builder: Any, triple: str | None = None) -> Iterator[None]:
    """Generate code that sets the flushing mode before the block's code and restores it after.

    The block must reach its end: a return or a branch out of it would leave the mode set.
    ``triple`` names the processor, by default this one.
    """
    architecture = (triple or binding.get_process_triple()).partition("-")[0]
    if architecture in ("x86_64", "amd64"):
        slot = builder.alloca(_WORD)
        there = builder.bitcast(slot, ir.IntType(8).as_pointer())
        read, write = (
            _intrinsic(module, f"llvm.x86.sse.{name}", ir.VoidType(), there.type)
            for name in ("stmxcsr", "ldmxcsr")
        )
        builder.call(read, [there])
        before = builder.load(slot)
        builder.store(builder.or_(before, _WORD(X86_FLUSH)), slot)
        builder.call(write, [there])
        yield
        builder.store(before, slot)
        builder.call(write, [there])
    elif architecture in ("aarch64", "arm64"):
        read = _intrinsic(module, "llvm.aarch64.get.fpcr", _LONG)
        write = _intrinsic(module, "llvm.aarch64.set.fpcr", ir.VoidType(), _LONG)
        before = builder.call(read, [])
        builder.call(write, [builder.or_(before, _LONG(ARM_FLUSH))])
        yield
        builder.call(write, [before])
    else:
        yield


def _intrinsic(module: Any, name: str, result: Any, *kinds: Any) -> Any:
    """Return LLVM's intrinsic of that name, declared in the module."""
    if name not in module.globals:
        return ir.Function(module, ir.FunctionType(result, kinds), name)
    return module.globals[name]

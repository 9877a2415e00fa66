"""Measured multiply-add rate of one core, with independent accumulators kept in registers."""

import time
from collections.abc import Callable
from functools import cache
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from longwave.support.compiled.jit import njit

WIDTHS = (4, 8)
"""Vector widths in doubles that are tried: 4 fit a register of AVX2, 8 one of AVX-512."""

ACCUMULATORS = 12
"""Number of independent accumulators: two units of latency 4 need 8, and 16 registers fit 12."""

ROUNDS = 3_000_000


@cache
def _loop(width: int) -> Callable[[int], float]:
    """Compile a kernel that runs a number of rounds on vectors of ``width`` doubles."""

    @intrinsic
    def multiply_add(_context: Any, rounds: Any) -> Any:
        """Apply x -> x / 2 + 1/2 to each accumulator ``rounds`` times; return a sum over all."""

        def codegen(_target: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            kind = ir.VectorType(ir.DoubleType(), width)
            half = ir.Constant(kind, [0.5] * width)
            starts = [ir.Constant(kind, [1.0 + i] * width) for i in range(ACCUMULATORS)]
            slots = [cgutils.alloca_once_value(builder, start) for start in starts]
            with cgutils.for_range(builder, arguments[0]):
                for slot in slots:
                    product = builder.fmul(builder.load(slot), half, flags=("contract",))
                    builder.store(builder.fadd(product, half, flags=("contract",)), slot)
            total = builder.load(slots[0])
            for slot in slots[1:]:
                total = builder.fadd(total, builder.load(slot))
            return builder.extract_element(total, ir.Constant(ir.IntType(32), 0))

        return types.float64(types.intp), codegen

    @njit(nogil=True)
    def run(rounds: int) -> float:
        return multiply_add(rounds)  # type: ignore[call-arg]

    run(1)
    return run


def multiply_add_rate() -> float:
    """Measure multiply-adds per second (each counted once) on this core, at the faster width."""
    rates = []
    for width in WIDTHS:
        run = _loop(width)
        begin = time.thread_time()
        run(ROUNDS)
        rates.append(ROUNDS * ACCUMULATORS * width / (time.thread_time() - begin))
    return max(rates)

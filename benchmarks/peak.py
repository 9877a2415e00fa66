"""The core's multiply-add rate, measured: independent accumulators that stay in registers."""

import time
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from verify.lattice.vector import LANES

ACCUMULATORS = 12
"""Independent chains: two units of latency 4 need 8; 16 registers hold them and a constant."""

ROUNDS = 3_000_000


@intrinsic
def _multiply_add(_context: Any, rounds: Any) -> Any:
    """``rounds`` times x <- x / 2 + 1/2 on every accumulator; their sum, so that all are needed."""

    def codegen(_target: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        kind = ir.VectorType(ir.DoubleType(), LANES)
        half = ir.Constant(kind, [0.5] * LANES)
        starts = [ir.Constant(kind, [1.0 + i] * LANES) for i in range(ACCUMULATORS)]
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
def _run(rounds: int) -> float:
    return _multiply_add(rounds)  # type: ignore[call-arg]


def multiply_add_rate() -> float:
    """Multiply-adds a second (each counted once) of this thread's core."""
    _run(1)
    begin = time.thread_time()
    _run(ROUNDS)
    return ROUNDS * ACCUMULATORS * LANES / (time.thread_time() - begin)

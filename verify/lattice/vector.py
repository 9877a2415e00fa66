"""The fused stage of a splitting scheme as vector code, for kernels of numba.

A stage is one drift and one kick,

    y += a s,    s += b D V'(y),

on rows of ``LANES`` sites. Neighbouring sites stand in neighbouring rows, so D needs no shuffles
and every load is aligned. The loop goes up the rows once: the forces of the last two rows and the
velocity of the last one stay in registers, so that a row costs two loads, two stores and the
arithmetic. LLVM's own vectoriser does not find this form; it takes three passes over memory.

The code says vectors of eight doubles and multiply-adds that may be contracted; LLVM lowers both to
what the processor has: one without AVX-512 runs the same code in halves, without AVX2 in quarters.
"""

from collections.abc import Callable
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 8
"""Sites per row: one 512-bit vector of doubles, which is also a line of the cache."""

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_INDEX = ir.IntType(64)

OPERATIONS = {(False, False): 5, (True, False): 6, (False, True): 7, (True, True): 7}
"""Arithmetic instructions per site and stage, by the presence of (K3, K4).

A fused multiply-add counts once: the drift 1, the force 1, 2, 3 or 3, the kick 3.
"""


def _splat(builder: Any, value: Any) -> Any:
    seed = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, _INDEX(0))
    mask = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    return builder.shuffle_vector(seed, ir.Constant(_VECTOR, ir.Undefined), mask)


def _fma(builder: Any, factor: Any, other: Any, term: Any) -> Any:
    """factor * other + term, rounded once where the processor can."""
    product = builder.fmul(factor, other, flags=("contract",))
    return builder.fadd(product, term, flags=("contract",))


class _Rows:
    """Rows of an array of doubles, loaded and stored as vectors."""

    def __init__(self, context: Any, builder: Any, kind: Any, value: Any) -> None:
        self._builder = builder
        data = context.make_array(kind)(context, builder, value).data
        self._data = builder.bitcast(data, _VECTOR.as_pointer())

    def load(self, row: Any) -> Any:
        return self._builder.load(self._builder.gep(self._data, [row]), align=8)

    def store(self, row: Any, value: Any) -> None:
        self._builder.store(value, self._builder.gep(self._data, [row]), align=8)


def _force(builder: Any, y: Any, K2: Any, K3: Any, K4: Any) -> Any:
    """V'(y) in Horner form; a constant that is ``None`` costs nothing."""
    if K4 is None and K3 is None:
        return builder.fmul(K2, y)
    if K4 is None:
        return builder.fmul(y, _fma(builder, K3, y, K2))
    if K3 is None:
        return builder.fmul(y, _fma(builder, K4, builder.fmul(y, y), K2))
    return builder.fmul(y, _fma(builder, y, _fma(builder, K4, y, K3), K2))


def _generate(present: tuple[bool, bool]) -> Callable[..., Any]:
    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        y, s, forces = (
            _Rows(context, builder, kind, value)
            for kind, value in zip(signature.args[:3], arguments[:3], strict=True)
        )
        level, first, past = arguments[3:6]
        a, b, K2 = (_splat(builder, value) for value in arguments[6:9])
        K3, K4 = (
            _splat(builder, value) if there else None
            for there, value in zip(present, arguments[9:], strict=True)
        )
        minus_two = _splat(builder, ir.Constant(ir.DoubleType(), -2.0))
        places = [builder.add(builder.mul(level, _INDEX(2)), _INDEX(i)) for i in range(2)]
        begin = [*map(forces.load, places), s.load(builder.sub(first, _INDEX(1)))]
        carried = [cgutils.alloca_once_value(builder, value) for value in begin]
        with cgutils.for_range_slice(builder, first, past, _INDEX(1)) as (row, _):
            left, middle, before = (builder.load(slot) for slot in carried)
            velocity = s.load(row)
            strain = _fma(builder, a, velocity, y.load(row))
            y.store(row, strain)
            right = _force(builder, strain, K2, K3, K4)
            bend = _fma(builder, minus_two, middle, builder.fadd(left, right))
            s.store(builder.sub(row, _INDEX(1)), _fma(builder, b, bend, before))
            for slot, value in zip(carried, (middle, right, velocity), strict=True):
                builder.store(value, slot)
        for place, slot in zip(places, carried, strict=False):
            forces.store(place, builder.load(slot))
        return context.get_dummy_value()

    return codegen


@intrinsic
def stage(
    _context: Any,
    y: Any,
    s: Any,
    forces: Any,
    level: Any,
    first: Any,
    past: Any,
    a: Any,
    b: Any,
    K2: Any,
    K3: Any,
    K4: Any,
) -> Any:
    """Drift the rows ``first`` .. ``past - 1`` of (y, s), kick those one row lower.

    ``y``, ``s`` and ``forces`` are contiguous arrays of doubles. Rows 2 level and 2 level + 1 of
    ``forces`` hold V' at the rows first - 2 and first - 1, and at the end that at past - 2 and
    past - 1, so that the next call goes on where this one stopped. 1 <= first <= past; K3 or K4
    is ``None`` when absent.
    """
    present = (K3 is not types.none, K4 is not types.none)
    signature = types.void(y, s, forces, *(types.intp,) * 3, *(types.float64,) * 3, K3, K4)
    return signature, _generate(present)

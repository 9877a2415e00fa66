"""The fused stages of a splitting scheme on rows of sites, as vector code and as plain loops.

A stage is one drift and one kick,

    y += a s,    s += b D V'(y),

on rows of ``LANES`` sites. Neighbouring sites stand in neighbouring rows, so D needs no shuffles
and every load is aligned. The loop goes up the rows once: the last row's force and how much it rose
there are carried along. The force is taken in units of its highest constant, with which the kick is
multiplied instead, and D as a difference of differences: y^3 + (K2/K4) y and D take one
multiply-add, one product and two subtractions. `plain_stage` says all of that in loops.

Two stages go together, the second one row behind the first: a row then costs two loads and two
stores for both, and what is carried stays in registers. LLVM's own vectoriser does not find this
form; it takes three passes over memory. So it is written in LLVM's language here; the plain loops
take three times as long (`benchmarks/same_lattice.py`, with and without ``LONGWAVE_PLAIN_KERNELS``;
it also tells the share of the processor's multiply-adds). The code says vectors of eight doubles
and multiply-adds that may be contracted; LLVM lowers both to what the processor has: one without
AVX-512 runs the same code in halves, without AVX2 in quarters.

The plain loops are taken, and give the same numbers to the bit, where ``LONGWAVE_PLAIN_KERNELS`` is
set to anything but 0, where numba's compiler is switched off, and where this numba or llvmlite
lacks what the vector code needs; ``WHY_PLAIN`` says why, and is empty for the vector code.
"""

import os
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numba.core import config
from numpy.typing import NDArray

from solutions.run.jit import njit

Array = NDArray[np.float64]

LANES = 8
"""Sites per row: one 512-bit vector of doubles, which is also a line of the cache."""

OPERATIONS = {(False, False): 4, (True, False): 6, (False, True): 6, (True, True): 7}
"""Arithmetic instructions per site and stage, by the presence of (K3, K4).

A fused multiply-add counts once: the drift 1, the force 0, 2, 2 or 3, the kick 3.
"""


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _multiply_add(factor: float, other: float, term: float) -> float:
    """factor * other + term, rounded once where the processor can."""
    return factor * other + term


@njit(cache=True, error_model="numpy")
def _scaled_force(
    y: float, lower: float, middle: float, K3: float | None, K4: float | None
) -> float:
    """V'(y) in units of its highest constant: y, y (y + lower) or y (y (y + middle) + lower)."""
    if K4 is None:
        return y if K3 is None else y * (y + lower)
    if K3 is None:
        return y * _multiply_add(y, y, lower)
    return y * _multiply_add(y, y + middle, lower)


@njit(cache=True, error_model="numpy")
def plain_stage(
    y: Array,
    s: Array,
    forces: Array,
    drifts: Array,
    kicks: Array,
    level: int,
    first: int,
    past: int,
    K2: float,
    K3: float | None,
    K4: float | None,
) -> None:
    """Drift the rows ``first`` .. ``past - 1`` of (y, s), kick those one row lower.

    All arrays are contiguous, of doubles; the stage is number ``level`` of ``drifts`` and
    ``kicks``. Rows 2 level and 2 level + 1 of ``forces`` hold the force at the row first - 1 less
    that at the row below it, and the former, in the force's units, and at the end those for
    past - 1, so that the next call goes on where this one stopped. 1 <= first <= past; K3 or K4 is
    ``None`` when absent.
    """
    lower, middle, unit = 0.0, 0.0, K2
    if K4 is not None:
        lower, unit = K2 / K4, K4
        if K3 is not None:
            middle = K3 / K4
    elif K3 is not None:
        lower, unit = K2 / K3, K3
    a, b = drifts[level], kicks[level] * unit
    carried = forces[2 * level * LANES : 2 * (level + 1) * LANES]
    size = (past - first) * LANES
    force, rise = np.empty(LANES + size), np.empty(LANES + size)
    rise[:LANES], force[:LANES] = carried[:LANES], carried[LANES:]
    row_y, row_s = y[first * LANES :], s[first * LANES :]
    for i in range(size):
        row_y[i] = _multiply_add(a, row_s[i], row_y[i])
        force[LANES + i] = _scaled_force(row_y[i], lower, middle, K3, K4)
    below = s[(first - 1) * LANES :]
    for i in range(size):
        rise[LANES + i] = force[LANES + i] - force[i]
    for i in range(size):
        below[i] = _multiply_add(b, rise[LANES + i] - rise[i], below[i])
    carried[:LANES], carried[LANES:] = rise[size:], force[size:]


@njit(cache=True, error_model="numpy")
def plain_pair(
    y: Array,
    s: Array,
    forces: Array,
    drifts: Array,
    kicks: Array,
    level: int,
    first: int,
    past: int,
    *constants: float | None,
) -> None:
    """`plain_stage` for ``level``, and for level + 1 one row lower. 2 <= first."""
    plain_stage(y, s, forces, drifts, kicks, level, first, past, *constants)
    plain_stage(y, s, forces, drifts, kicks, level + 1, first - 1, past - 1, *constants)


def _why_plain() -> str:
    if os.environ.get("LONGWAVE_PLAIN_KERNELS", "0") not in ("", "0"):
        return "LONGWAVE_PLAIN_KERNELS is set"
    return "numba's compiler is switched off" if getattr(config, "DISABLE_JIT", 0) else ""


WHY_PLAIN = _why_plain()
"""Why the plain loops are taken, empty if the vector code is."""

try:
    from llvmlite import ir  # type: ignore[import-untyped]
    from numba.core import cgutils
    from numba.extending import intrinsic

    _VECTOR = ir.VectorType(ir.DoubleType(), LANES)
    _INDEX = ir.IntType(64)
except (ImportError, AttributeError) as missing:
    WHY_PLAIN = WHY_PLAIN or f"this numba or llvmlite lacks what the vector code needs: {missing}"


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

    def number(self, place: Any) -> Any:
        """One of the array's doubles."""
        data = self._builder.bitcast(self._data, ir.DoubleType().as_pointer())
        return self._builder.load(self._builder.gep(data, [place]))

    def load(self, row: Any) -> Any:
        return self._builder.load(self._builder.gep(self._data, [row]), align=8)

    def store(self, row: Any, value: Any) -> None:
        self._builder.store(value, self._builder.gep(self._data, [row]), align=8)


def _force(builder: Any, y: Any, factors: list[Any]) -> Any:
    """V'(y) in units of its highest constant: y, y (y + q) or y (y (y + p) + q).

    ``factors`` are the lower constants in that unit, the highest of them first; None for p = 0.
    """
    found = y
    for place, factor in enumerate(factors):
        if place == 0:
            found = y if factor is None else builder.fadd(y, factor)
        else:
            found = _fma(builder, y, found, factor)
    return builder.fmul(y, found) if factors else y


def _factors(builder: Any, present: tuple[bool, bool], constants: Any) -> tuple[list[Any], Any]:
    """The force's lower constants in units of the highest one, and that."""
    K2, K3, K4 = (
        _splat(builder, value) if there else None
        for there, value in zip((True, *present), constants, strict=True)
    )
    if K4 is not None:
        return [None if K3 is None else builder.fdiv(K3, K4), builder.fdiv(K2, K4)], K4
    if K3 is not None:
        return [builder.fdiv(K2, K3)], K3
    return [], K2


class _Stage:
    """The weights of one of the stages that go together, and what it carries up the rows.

    The last row's rise of the force, its force and its velocity before the kick; behind the first
    stage also the strain that the stage before has left in the next row.
    """

    def __init__(
        self, builder: Any, arrays: list[_Rows], level: Any, behind: int, unit: Any
    ) -> None:
        self._builder, self.behind = builder, behind
        self._y, self._s, self._forces, drifts, kicks = arrays
        place = builder.add(level, _INDEX(behind))
        self.a = _splat(builder, drifts.number(place))
        self.b = builder.fmul(_splat(builder, kicks.number(place)), unit)
        self._rise = builder.mul(place, _INDEX(2))
        self._force = builder.add(self._rise, _INDEX(1))

    def begin(self, first: Any) -> None:
        """Take what stands in memory below ``first``."""
        below = self._builder.sub(first, _INDEX(self.behind))
        values = [self._forces.load(self._rise), self._forces.load(self._force)]
        values.append(self._s.load(self._builder.sub(below, _INDEX(1))))
        if self.behind:
            values.append(self._y.load(below))
        self.slots = [cgutils.alloca_once_value(self._builder, value) for value in values]

    def row(self, y: Any, s: Any, factors: list[Any]) -> tuple[Any, Any]:
        """Drift a row and kick the one below it; give the strain and the kicked velocity."""
        builder = self._builder
        rise, middle, before, *waiting = (builder.load(slot) for slot in self.slots)
        if waiting:
            builder.store(y, self.slots[3])
            y = waiting[0]
        y = _fma(builder, self.a, s, y)
        force = _force(builder, y, factors)
        next_rise = builder.fsub(force, middle)
        kicked = _fma(builder, self.b, builder.fsub(next_rise, rise), before)
        for slot, value in zip(self.slots, (next_rise, force, s), strict=False):
            builder.store(value, slot)
        return y, kicked

    def end(self, past: Any) -> None:
        """Leave in memory what the next call takes from there."""
        rise, force, before, *waiting = (self._builder.load(slot) for slot in self.slots)
        self._forces.store(self._rise, rise)
        self._forces.store(self._force, force)
        if waiting:
            below = self._builder.sub(past, _INDEX(self.behind))
            self._s.store(self._builder.sub(below, _INDEX(1)), before)
            self._y.store(below, waiting[0])


def _generate(together: int, present: tuple[bool, bool]) -> Callable[..., Any]:
    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        arrays = [
            _Rows(context, builder, kind, value)
            for kind, value in zip(signature.args[:5], arguments[:5], strict=True)
        ]
        level, first, past = arguments[5:8]
        factors, unit = _factors(builder, present, arguments[8:])
        stages = [_Stage(builder, arrays, level, behind, unit) for behind in range(together)]
        for one in stages:
            one.begin(first)
        rows_y, rows_s = arrays[:2]
        with cgutils.for_range_slice(builder, first, past, _INDEX(1)) as (row, _):
            y, s = rows_y.load(row), rows_s.load(row)
            for one in stages:
                y, s = one.row(y, s, factors)
            rows_y.store(builder.sub(row, _INDEX(together - 1)), y)
            rows_s.store(builder.sub(row, _INDEX(together)), s)
        for one in stages:
            one.end(past)
        return context.get_dummy_value()

    return codegen


def _vector_stages(together: int) -> Any:
    """`plain_stage` or, for 2 stages together, `plain_pair` as vector code."""

    @intrinsic
    def stages(
        _context: Any,
        y: Any,
        s: Any,
        forces: Any,
        drifts: Any,
        kicks: Any,
        level: Any,
        first: Any,
        past: Any,
        K2: Any,
        K3: Any,
        K4: Any,
    ) -> tuple[Any, Callable[..., Any]]:
        present = (K3 is not types.none, K4 is not types.none)
        rows = (types.intp,) * 3
        signature = types.void(y, s, forces, drifts, kicks, *rows, types.float64, K3, K4)
        return signature, _generate(together, present)

    return stages


stage, pair = plain_stage, plain_pair
if not WHY_PLAIN:
    stage, pair = _vector_stages(1), _vector_stages(2)

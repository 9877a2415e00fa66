"""The vector code of a splitting scheme's stages, in LLVM's language: what numba is told of it.

`lattice.kernels.blocked` says what a stage is; this is read where one is compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils

__all__ = ["stages"]

LANES = 8
"""Sites per row, as in `lattice.kernels.blocked`."""

_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_INDEX = ir.IntType(64)


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


def stages(together: int, kinds: tuple[Any, ...]) -> tuple[Any, Callable[..., Any]]:
    """The signature and the code of ``together`` stages for arguments of these types."""
    present = (kinds[-2] is not types.none, kinds[-1] is not types.none)
    rows = (types.intp,) * 3
    signature = types.void(*kinds[:5], *rows, types.float64, *kinds[-2:])
    return signature, _generate(together, present)

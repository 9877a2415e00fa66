"""Code generator for vectors of doubles in LLVM's intermediate representation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]

from longwave.support.compiled.native_code import multiplies_and_adds_at_once

DOUBLE, INDEX = ir.DoubleType(), ir.IntType(64)


class LaneCode:
    """LLVM builder for vectors of ``lanes`` doubles; ``fused`` if the CPU has multiply-adds."""

    def __init__(self, module: Any, builder: Any, lanes: int, fused: bool | None = None) -> None:
        self.module, self.builder, self.lanes = module, builder, lanes
        self.fused = multiplies_and_adds_at_once() if fused is None else fused
        self.kind = DOUBLE if lanes == 1 else ir.VectorType(DOUBLE, lanes)

    def constant(self, value: float) -> Any:
        """Return a constant with the same number in all lanes."""
        return ir.Constant(self.kind, value if self.lanes == 1 else [value] * self.lanes)

    def splat(self, value: Any) -> Any:
        """Return a vector with a scalar of the program in all lanes."""
        if self.lanes == 1:
            return value
        undefined = ir.Constant(self.kind, ir.Undefined)
        seed = self.builder.insert_element(undefined, value, INDEX(0))
        return self.picked(seed, undefined, [0] * self.lanes)

    def number(self, data: Any, index: Any) -> Any:
        """Load one double from memory into all lanes."""
        index = INDEX(index) if isinstance(index, int) else index
        return self.splat(self.builder.load(self.builder.gep(data, [index])))

    def address(self, data: Any, row: Any) -> Any:
        """Return the address of the vector with index ``row`` in the array ``data``."""
        index = self.builder.mul(row, INDEX(self.lanes))
        return self.builder.bitcast(self.builder.gep(data, [index]), self.kind.as_pointer())

    def load(self, data: Any, row: Any) -> Any:
        """Load a vector from memory."""
        return self.builder.load(self.address(data, row), align=8)

    def store(self, data: Any, row: Any, value: Any) -> None:
        """Store a vector in memory."""
        self.builder.store(value, self.address(data, row), align=8)

    def picked(self, first: Any, second: Any, lanes: Sequence[int]) -> Any:
        """Return a shuffle of two vectors; ``lanes`` are indices into both, joined end to end."""
        mask = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), list(lanes))
        return self.builder.shuffle_vector(first, second, mask)

    def fma(self, factor: Any, second: Any, term: Any) -> Any:
        """Return factor * second + term, rounded once if the processor can."""
        return self._vector_function("fmuladd", factor, second, term)

    def fused_multiply_add(self, factor: Any, second: Any, term: Any) -> Any:
        """Return factor * second + term, rounded once; slow if the processor is not ``fused``."""
        return self._vector_function("fma", factor, second, term)

    def weighted_sum(self, terms: Iterable[tuple[Any, float, Any]]) -> Any:
        """Return the sum of factor times value; a factor of None stands for the given sign."""
        total = None
        for factor, sign, value in terms:
            if factor is not None:
                if total is None:
                    total = self.builder.fmul(factor, value)
                else:
                    total = self.fma(factor, value, total)
            elif total is None:
                total = value if sign > 0 else self.builder.fneg(value)
            else:
                add = self.builder.fadd if sign > 0 else self.builder.fsub
                total = add(total, value)
        return total

    def function(self, name: str, *values: Any) -> Any:
        """Call the C library's function of that name, lane by lane."""
        declared = self.module.globals
        if name not in declared:
            kind = ir.FunctionType(DOUBLE, [DOUBLE] * len(values))
            ir.Function(self.module, kind, name)
        if self.lanes == 1:
            return self.builder.call(declared[name], values)
        result = ir.Constant(self.kind, ir.Undefined)
        for lane in map(INDEX, range(self.lanes)):
            parts = [self.builder.extract_element(value, lane) for value in values]
            lane_result = self.builder.call(declared[name], parts)
            result = self.builder.insert_element(result, lane_result, lane)
        return result

    def root(self, value: Any) -> Any:
        """Return the square root."""
        return self._vector_function("sqrt", value)

    def positive_part(self, value: Any) -> Any:
        """Return the value where it is positive, else 0."""
        none = self.constant(0.0)
        return self.builder.select(self.builder.fcmp_ordered(">", value, none), value, none)

    def where_not(self, tested: Any, cut: float, value: Any) -> Any:
        """Return ``value`` (even NaN), or 0 in lanes where ``tested`` equals ``cut``."""
        is_there = self.builder.fcmp_unordered("!=", tested, self.constant(cut))
        return self.builder.select(is_there, value, self.constant(0.0))

    def _vector_function(self, word: str, *values: Any) -> Any:
        """Call the LLVM intrinsic named ``word`` on all lanes."""
        suffix = "f64" if self.lanes == 1 else f"v{self.lanes}f64"
        name, known = f"llvm.{word}.{suffix}", self.module.globals
        if name not in known:
            kind = ir.FunctionType(self.kind, [self.kind] * len(values))
            ir.Function(self.module, kind, name)
        return self.builder.call(known[name], values)

    @contextmanager
    def loop(self, start: Any, stop: Any, step: int = 1) -> Iterator[Any]:
        """Generate a loop; the body's code sees an index from ``start`` to below ``stop``."""
        builder = self.builder
        before = builder.block
        head, body, after = (builder.append_basic_block() for _ in range(3))
        builder.branch(head)
        builder.position_at_end(head)
        index = builder.phi(INDEX)
        index.add_incoming(start, before)
        builder.cbranch(builder.icmp_signed("<", index, stop), body, after)
        builder.position_at_end(body)
        yield index
        index.add_incoming(builder.add(index, INDEX(step)), builder.block)
        builder.branch(head)
        builder.position_at_end(after)

    def least(self, first: Any, second: Any) -> Any:
        """Return the smaller of two integers."""
        return self.builder.select(self.builder.icmp_signed("<", first, second), first, second)

    def most(self, first: Any, second: Any) -> Any:
        """Return the larger of two integers."""
        return self.builder.select(self.builder.icmp_signed(">", first, second), first, second)

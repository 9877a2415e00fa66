"""A builder of vectors of doubles in LLVM's language."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]

from longwave.support.compiled.native_code import multiplies_and_adds_at_once

DOUBLE, INDEX = ir.DoubleType(), ir.IntType(64)


class LaneCode:
    """A builder of vectors of doubles: what every part of the code is written with."""

    def __init__(self, module: Any, builder: Any, lanes: int, fused: bool | None = None) -> None:
        self.module, self.builder, self.lanes = module, builder, lanes
        self.fused = multiplies_and_adds_at_once() if fused is None else fused
        self.kind = DOUBLE if lanes == 1 else ir.VectorType(DOUBLE, lanes)

    def constant(self, value: float) -> Any:
        """A number in all lanes."""
        return ir.Constant(self.kind, value if self.lanes == 1 else [value] * self.lanes)

    def splat(self, value: Any) -> Any:
        """A value of the program in all lanes."""
        if self.lanes == 1:
            return value
        undefined = ir.Constant(self.kind, ir.Undefined)
        seed = self.builder.insert_element(undefined, value, INDEX(0))
        return self.picked(seed, undefined, [0] * self.lanes)

    def number(self, data: Any, place: Any) -> Any:
        """One double of memory in all lanes."""
        place = INDEX(place) if isinstance(place, int) else place
        return self.splat(self.builder.load(self.builder.gep(data, [place])))

    def address(self, data: Any, row: Any) -> Any:
        """Where a vector stands, counted in vectors."""
        place = self.builder.mul(row, INDEX(self.lanes))
        return self.builder.bitcast(self.builder.gep(data, [place]), self.kind.as_pointer())

    def load(self, data: Any, row: Any) -> Any:
        """A vector of memory."""
        return self.builder.load(self.address(data, row), align=8)

    def store(self, data: Any, row: Any, value: Any) -> None:
        """Put a vector into memory."""
        self.builder.store(value, self.address(data, row), align=8)

    def picked(self, one: Any, other: Any, lanes: Sequence[int]) -> Any:
        """The lanes so numbered, the other's being counted after those of the one."""
        mask = ir.Constant(ir.VectorType(ir.IntType(32), self.lanes), list(lanes))
        return self.builder.shuffle_vector(one, other, mask)

    def fma(self, factor: Any, other: Any, term: Any) -> Any:
        """factor * other + term, rounded once where the processor can."""
        return self._vector_function("fmuladd", factor, other, term)

    def fused_multiply_add(self, factor: Any, other: Any, term: Any) -> Any:
        """factor * other + term, rounded once: slow where the processor is not ``fused``."""
        return self._vector_function("fma", factor, other, term)

    def weighted_sum(self, terms: Iterable[tuple[Any, float, Any]]) -> Any:
        """The sum of (factor, sign, value): factor times value, or with that sign if it is None.

        None without terms.
        """
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
        """The C library's function of that name, lane by lane."""
        known = self.module.globals
        if name not in known:
            kind = ir.FunctionType(DOUBLE, [DOUBLE] * len(values))
            ir.Function(self.module, kind, name)
        if self.lanes == 1:
            return self.builder.call(known[name], values)
        found = ir.Constant(self.kind, ir.Undefined)
        for lane in map(INDEX, range(self.lanes)):
            parts = [self.builder.extract_element(value, lane) for value in values]
            one = self.builder.call(known[name], parts)
            found = self.builder.insert_element(found, one, lane)
        return found

    def root(self, value: Any) -> Any:
        """The square root."""
        return self._vector_function("sqrt", value)

    def positive_part(self, value: Any) -> Any:
        """The value where it is positive, else 0."""
        none = self.constant(0.0)
        return self.builder.select(self.builder.fcmp_ordered(">", value, none), value, none)

    def where_not(self, share: Any, cut: float, value: Any) -> Any:
        """The value, whatever it is, but 0 where the share of it is ``cut``."""
        is_there = self.builder.fcmp_unordered("!=", share, self.constant(cut))
        return self.builder.select(is_there, value, self.constant(0.0))

    def _vector_function(self, word: str, *values: Any) -> Any:
        """A function that LLVM knows, of all lanes."""
        suffix = "f64" if self.lanes == 1 else f"v{self.lanes}f64"
        name, known = f"llvm.{word}.{suffix}", self.module.globals
        if name not in known:
            kind = ir.FunctionType(self.kind, [self.kind] * len(values))
            ir.Function(self.module, kind, name)
        return self.builder.call(known[name], values)

    @contextmanager
    def loop(self, start: Any, stop: Any, step: int = 1) -> Iterator[Any]:
        """A loop over an index from ``start`` below ``stop``."""
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

    def least(self, one: Any, other: Any) -> Any:
        """The smaller of two integers."""
        return self.builder.select(self.builder.icmp_signed("<", one, other), one, other)

    def most(self, one: Any, other: Any) -> Any:
        """The larger of two integers."""
        return self.builder.select(self.builder.icmp_signed(">", one, other), one, other)

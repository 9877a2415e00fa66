"""The machine code of a stage in two dimensions, in LLVM's language: written from its `PlaneFlow`.

A row of cells is contiguous in memory and taken in vectors of ``lanes``. Before it is drifted, the
columns beside it are made to repeat it; they are drifted and bear forces with it, so that no load
needs to know where the ring closes. A row is taken a chunk at a time: what is drifted is still in
the first cache when it stretches bonds, and so are the forces when they kick.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]

from longwave.lattice.kernels.plane_flow import Part, PlaneFlow
from longwave.lattice.kernels.row_code import LaneCode, lane_force

__all__ = ["margins", "sweep_text"]

_DOUBLES, _INDEX = ir.DoubleType().as_pointer(), ir.IntType(64)

CHUNK = 32
"""Vectors of a chunk."""

SPARE = 4096
"""Times its depth, what keeps the number of a kept row from being negative."""


class _Row:
    """Writes the function that takes one stage to its next row.

    Its arguments: positions and velocities at the first cell, kept forces at theirs, the two
    weights, the numbers, and the doubles from field to field and from row to row, the columns, and
    the row at the front.
    """

    def __init__(self, module: Any, flow: PlaneFlow, lanes: int, count: int) -> None:
        kinds = [*[_DOUBLES] * 6, *[_INDEX] * 4]
        self.function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), "row")
        self.function.linkage = "internal"
        for argument in self.function.args[:3]:
            argument.add_attribute("noalias")
        self._builder = ir.IRBuilder(self.function.append_basic_block())
        self._code = LaneCode(module, self._builder, lanes)
        self._flow, self._lanes = flow, lanes
        f, v, forces, drift, kick, numbers, plane, pitch, columns, front = self.function.args
        self._f, self._v, self._forces = f, v, forces
        self._plane, self._pitch, self._columns, self._front = plane, pitch, columns, front
        self._numbers = [self._code.number(numbers, place) for place in range(count)]
        self._drift, self._kick = (self._code.number(data, 0) for data in (drift, kick))
        more = self._builder.add(columns, _INDEX(lanes - 1))
        self._vectors = self._builder.sdiv(more, _INDEX(lanes))

    def write(self) -> None:
        flow, code, builder = self._flow, self._code, self._builder
        for field in range(flow.fields):
            for data in (self._f, self._v):
                self._repeat(self._cells(data, field, self._front))
        acted, ahead = margins(flow, self._lanes)
        forced, kicked = (
            builder.sub(self._front, _INDEX(behind)) for behind in (flow.high, flow.rise)
        )
        with code.loop(_INDEX(0), self._vectors, CHUNK) as chunk:
            begun = builder.icmp_signed(">", chunk, _INDEX(0))
            past = code.least(builder.add(chunk, _INDEX(CHUNK)), self._vectors)

            def part(more: int) -> tuple[Any, Any]:
                """The chunk's vectors, ``more`` ahead; the first chunk has those before the row."""
                first = builder.add(chunk, _INDEX(more))
                first = builder.select(begun, first, _INDEX(-more))
                return first, builder.add(past, _INDEX(more))

            for field in range(flow.fields):
                self._drifted(field, *part(acted + ahead))
            for row, more, do in ((forced, acted, self._forced), (kicked, 0, self._kicked)):
                with builder.if_then(builder.icmp_signed(">=", row, _INDEX(0))):
                    do(row, *part(more))
        builder.ret_void()

    def _cells(self, data: Any, field: int, row: Any, column: int = 0) -> Any:
        """Where a field's row begins, or its cell of that column."""
        builder = self._builder
        place = builder.add(builder.mul(self._plane, _INDEX(field)), builder.mul(self._pitch, row))
        return builder.gep(data, [builder.add(place, _INDEX(column))])

    def _kept(self, bond: int, row: Any, column: int = 0) -> Any:
        """Where a bond's forces of that row are kept."""
        builder, depth = self._builder, self._flow.bonds[bond].depth
        above = sum(other.depth for other in self._flow.bonds[:bond])
        turn = builder.urem(builder.add(row, _INDEX(SPARE * depth)), _INDEX(depth))
        place = builder.mul(self._pitch, builder.add(turn, _INDEX(above)))
        return builder.gep(self._forces, [builder.add(place, _INDEX(column))])

    def _repeat(self, data: Any) -> None:
        """Make the columns beside a row repeat it."""
        builder, flow = self._builder, self._flow
        reach = flow.stretched + flow.acted
        if not reach:
            return
        with self._code.loop(_INDEX(0), _INDEX(reach)) as place:
            last = builder.sub(builder.sub(self._columns, _INDEX(1)), place)
            before = builder.sub(_INDEX(-1), place)
            after = builder.add(self._columns, place)
            for to, at in ((before, last), (after, place)):
                builder.store(builder.load(builder.gep(data, [at])), builder.gep(data, [to]))

    def _drifted(self, field: int, first: Any, past: Any) -> None:
        f, v = (self._cells(data, field, self._front) for data in (self._f, self._v))
        code = self._code
        with code.loop(first, past) as place:
            code.store(f, place, code.fma(self._drift, code.load(v, place), code.load(f, place)))

    def _sum(self, parts: Sequence[Part], rows: Sequence[Any], place: Any) -> Any:
        """The parts' sum, whose rows begin there."""
        return self._code.weighted_sum(
            (
                None if part.number is None else self._numbers[part.number],
                part.sign,
                self._code.load(row, place),
            )
            for part, row in zip(parts, rows, strict=True)
        )

    def _forced(self, row: Any, first: Any, past: Any) -> None:
        """The forces of all bonds of that row."""
        code, bonds = self._code, self._flow.bonds
        rows = [
            [
                self._cells(
                    self._f, part.source, code.builder.add(row, _INDEX(part.row)), part.column
                )
                for part in bond.stretch
            ]
            for bond in bonds
        ]
        kept = [self._kept(place, row) for place in range(len(bonds))]
        with code.loop(first, past) as vector:
            for bond, from_rows, to in zip(bonds, rows, kept, strict=True):
                x = self._sum(bond.stretch, from_rows, vector)
                if bond.offset is not None:
                    x = code.builder.fadd(x, self._numbers[bond.offset])
                code.store(to, vector, lane_force(code, x, bond.law, self._numbers))

    def _kicked(self, row: Any, first: Any, past: Any) -> None:
        """The velocities of that row."""
        code = self._code
        for field in range(self._flow.fields):
            pushes = [push for push in self._flow.pushes if push.field == field]
            if not pushes:
                continue
            speeds = self._cells(self._v, field, row)
            weights = [code.builder.fmul(self._kick, self._numbers[p.factor]) for p in pushes]
            rows = [
                [
                    self._kept(part.source, code.builder.add(row, _INDEX(part.row)), part.column)
                    for part in push.forces
                ]
                for push in pushes
            ]
            with code.loop(first, past) as place:
                speed = code.load(speeds, place)
                for push, weight, from_rows in zip(pushes, weights, rows, strict=True):
                    speed = code.fma(weight, self._sum(push.forces, from_rows, place), speed)
                code.store(speeds, place, speed)


def margins(flow: PlaneFlow, lanes: int) -> tuple[int, int]:
    """The vectors beside a row on which there are forces, and the further ones that drift."""
    return -(-flow.acted // lanes), -(-flow.stretched // lanes)


def sweep_text(flow: PlaneFlow, lanes: int, count: int) -> str:
    """The module of that lattice's ``sweep``, which takes ``count`` numbers, as text.

    All stages go over the rows once, each ``flow.skew`` rows behind the one before. Arguments:
    positions, velocities and kept forces at their first cells, drifts, kicks, numbers; the doubles
    from field to field, from row to row, and from stage to stage of what is kept; the columns, the
    rows, and the stages.
    """
    module = ir.Module("plane")
    row = _Row(module, flow, lanes, count)
    row.write()
    kinds = [*[_DOUBLES] * 6, *[_INDEX] * 6]
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), kinds), "sweep")
    f, v, forces, drifts, kicks, numbers, plane, pitch, kept, columns, rows, stages = function.args
    builder = ir.IRBuilder(function.append_basic_block())
    code = LaneCode(module, builder, lanes)
    skew = _INDEX(flow.skew)
    behind = builder.mul(builder.sub(stages, _INDEX(1)), skew)
    with code.loop(_INDEX(0), builder.add(rows, behind)) as front:
        passed = builder.sub(builder.add(front, skew), rows)
        first = code.most(builder.sdiv(passed, skew), _INDEX(0))
        last = code.least(builder.add(builder.sdiv(front, skew), _INDEX(1)), stages)
        with code.loop(first, last) as stage:
            weights = [builder.gep(data, [stage]) for data in (drifts, kicks)]
            own = builder.gep(forces, [builder.mul(kept, stage)])
            place = builder.sub(front, builder.mul(stage, skew))
            builder.call(row.function, [f, v, own, *weights, numbers, plane, pitch, columns, place])
    builder.ret_void()
    return str(module)

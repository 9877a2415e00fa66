"""Generator of the stages' machine code, as LLVM text, from the streams of a stage.

Cells of a chain are laid out in rows of ``lanes``, each a vector; neighbouring cells are in
neighbouring rows (`lattice.kernels.ring_kernel`). Several stages go up the rows together, each
`StagePlan.skew` rows behind the one before. Values that a stream carries from row to row stay in
registers as far as there are any.

Each row of a plane is laid out as such a chain, and a stage goes along it. Values carried from
column to column stay in registers, those carried from row to row in memory.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]

from longwave.lattice.kernels import streams, vector_functions
from longwave.lattice.kernels.lane_code import DOUBLE, INDEX, LaneCode
from longwave.support.compiled.subnormals import flushed_subnormals

MAX_PRODUCT_EXPONENT = 64
"""Largest whole exponent for which a power is computed by products."""

ZERO_AT = {"kept": -1.0, "felt": 0.0}
"""Value of a cell's share at which a stream is 0 whatever its force; keyed by the stream's kind."""

COPY_BLOCK = 256
"""Number of vectors in a block when cells are copied."""

_DOUBLES, _INDICES = DOUBLE.as_pointer(), INDEX.as_pointer()

_STAGES = (*[_DOUBLES] * 6, *[INDEX] * 6)
"""Argument types of a stage function: positions, velocities, carried values, drifts, kicks,
numbers; doubles from field to field and from row to row, vectors of a row; first stage, and the
first and last row of its front."""


def _whole_power(code: LaneCode, value: Any, exponent: int) -> Any:
    """Generate code for ``value`` to the power ``exponent`` > 0 by repeated squaring."""
    result = None
    square, left = value, exponent
    while left:
        if left % 2:
            result = square if result is None else code.builder.fmul(result, square)
        left //= 2
        square = code.builder.fmul(square, square) if left else square
    return result


def _power(code: LaneCode, value: Any, exponent: float) -> Any:
    """Return a power, by products and a square root if the exponent is a multiple of 1/2."""
    size = abs(exponent)
    if exponent == 0.0 or not size <= vector_functions.LARGEST_EXPONENT:
        return code.function("pow", value, code.constant(exponent))
    if 2.0 * size != round(2.0 * size) or size > MAX_PRODUCT_EXPONENT:
        return vector_functions.power(vector_functions.Lanes(code, value), exponent).value
    whole = int(size)
    result = _whole_power(code, value, whole) if whole else None
    if size != whole:
        root = code.root(value)
        result = root if result is None else code.builder.fmul(result, root)
    return result if exponent > 0.0 else code.builder.fdiv(code.constant(1.0), result)


def lane_force(code: LaneCode, x: Any, law: streams.ForceFormula, numbers: Sequence[Any]) -> Any:
    """Generate code for the force at the stretch ``x``; return its value."""
    if law.program:
        return _run_program(code, x, law.program, numbers)
    builder = code.builder
    result = None if law.leading is None else numbers[law.leading]
    for index in law.factors:
        factor = None if index is None else numbers[index]
        if result is None:
            result = x if factor is None else builder.fadd(x, factor)
        elif factor is None:
            result = builder.fmul(x, result)
        else:
            result = code.fma(x, result, factor)
    return x if result is None else builder.fmul(x, result)


def _run_program(
    code: LaneCode, x: Any, program: Sequence[tuple[str, float]], numbers: Sequence[Any]
) -> Any:
    """Generate code for a force's program at the stretch ``x``; return its value."""
    stack: list[Any] = []
    for word, value in program:
        if word == "x":
            stack.append(x)
        elif word == "number":
            stack.append(numbers[int(value)])
        elif word in ("add", "multiply"):
            combine = code.builder.fadd if word == "add" else code.builder.fmul
            stack.append(combine(stack.pop(), stack.pop()))
        elif word == "power":
            stack.append(_power(code, stack.pop(), value))
        elif word == "contact":
            stack.append(code.positive_part(stack.pop()))
        elif word in vector_functions.FUNCTIONS_OF_LANES:
            stack.append(
                vector_functions.FUNCTIONS_OF_LANES[word](
                    vector_functions.Lanes(code, stack.pop())
                ).value
            )
        else:
            stack.append(code.function(word, stack.pop()))
    return stack.pop()


CarriedValue = Callable[[int, int, int], Any]
"""Function (stream, rows, columns) that loads the value a stream had so many rows and columns
ago."""


class _Stage:
    """One of several fused stages: its weights, and slots of earlier values, the latest first."""

    def __init__(
        self,
        code: LaneCode,
        flow: streams.StagePlan,
        numbers: Sequence[Any],
        drift: Any,
        weights: Sequence[Any],
        depths: Sequence[int],
    ) -> None:
        self._code, self._flow, self._numbers = code, flow, numbers
        kick, *further = weights
        self._drifts = [drift] * flow.fields
        self._shrunk = further[flow.damped : 2 * flow.damped]
        self._drifts[: flow.damped] = further[: flow.damped]
        self._series = further[2 * flow.damped : 2 * flow.damped + flow.series]
        self._pulses = further[2 * flow.damped + flow.series :]
        self._kicks = {
            stream.field: code.builder.fmul(kick, numbers[stream.number])
            for stream in flow.streams
            if stream.kind == "kicked" and stream.number is not None
        }
        self.slots = [[code.builder.alloca(code.kind) for _ in range(depth)] for depth in depths]
        self.latest: list[Any] = []
        """Latest value of each stream."""
        self._carried: CarriedValue | None = None

    def value(self, tap: streams.StreamRead, lag: int) -> Any:
        """Return the value that a stream with the given ``lag`` reads through its ``tap``."""
        rows, age = streams.rows_and_columns(lag - tap.shift - self._flow.streams[tap.stream].lag)
        if rows:
            assert self._carried is not None
            return self._carried(tap.stream, rows, age)
        if age == 0:
            return self.latest[tap.stream]
        return self._code.builder.load(self.slots[tap.stream][age - 1])

    def row(
        self,
        positions: Sequence[Any],
        velocities: Sequence[Any],
        carried: CarriedValue | None = None,
    ) -> None:
        """Generate code for a row of a chain or a column; ``carried`` loads a plane's earlier rows.

        ``carried`` loads values of earlier rows of the plane.
        """
        code, flow, self._carried = self._code, self._flow, carried
        drifting = 0 if flow.spread else flow.moving
        self.latest = [
            code.fma(drift, v, f)
            for drift, f, v in zip(self._drifts[:drifting], positions, velocities, strict=False)
        ]
        self.latest += positions[drifting:]
        self.latest += [
            code.builder.fmul(factor, v)
            for factor, v in zip(self._shrunk, velocities, strict=False)
        ]
        self.latest += velocities[flow.damped :]
        for stream in flow.streams[2 * flow.fields :]:
            values = [self.value(tap, stream.lag) for tap in stream.taps]
            if stream.kind == "force":
                value = lane_force(code, values[0], stream.law, self._numbers)
            elif stream.kind in ("varied", *ZERO_AT):
                value = code.fma(values[1], values[2], values[0])
                if stream.kind in ZERO_AT:
                    value = code.where_not(values[1], ZERO_AT[stream.kind], value)
            elif stream.kind == "kicked":
                value = code.fma(self._kicks[stream.field], values[1], values[0])
            elif stream.kind in ("spread", "pulsed"):
                assert stream.number is not None
                weights = self._series if stream.kind == "spread" else self._pulses
                value = code.fma(weights[stream.number], values[1], values[0])
            else:
                value = self._sum(stream.taps, values)
                if stream.number is not None:
                    value = code.builder.fadd(value, self._numbers[stream.number])
            self.latest.append(value)

    def _sum(self, taps: Sequence[streams.StreamRead], values: Sequence[Any]) -> Any:
        """Return the sum of the values, each times the weight or factor of its tap."""
        pairs = zip(taps, values, strict=True)
        total = self._code.weighted_sum((self._factor(tap), tap.weight, v) for tap, v in pairs)
        return self._code.constant(0.0) if total is None else total

    def _factor(self, tap: streams.StreamRead) -> Any:
        """Return the factor of a tap's value; None if it is 1 or -1."""
        if tap.number is not None:
            return self._numbers[tap.number]
        return None if abs(tap.weight) == 1.0 else self._code.constant(tap.weight)

    def outcome(self, lag: int) -> tuple[list[Any], list[Any]]:
        """Return positions and new velocities of the row ``lag`` behind the front."""
        flow = self._flow
        positions = [self.value(streams.StreamRead(stream), lag) for stream in flow.drifted]
        return positions, [self.value(streams.StreamRead(stream), lag) for stream in flow.kicked]

    def keep(self) -> None:
        """Shift the slots: the latest values become those of the previous row."""
        builder = self._code.builder
        for slots, latest in zip(self.slots, self.latest, strict=True):
            values = [latest, *(builder.load(slot) for slot in slots)]
            for slot, value in zip(slots, values, strict=False):
                builder.store(value, slot)


class _Writer:
    """Generates all functions of a lattice's LLVM module."""

    def __init__(
        self, flow: streams.StagePlan, lanes: int, together: int, block: int, count: int
    ) -> None:
        self._flow, self._lanes, self._together, self._count = flow, lanes, together, count
        self._block, self._skew, self._below, self._copied = block, flow.skew, flow.below, 1
        self._module = ir.Module("lattice")

    def chain(self) -> str:
        """Return the module's text for a chain."""
        groups = {size: self._group(size) for size in sorted({1, self._together})}
        return self._text(groups, {size: self._flow.carried_values(size) for size in groups})

    def plane(self, columns: int) -> str:
        """Return the module's text for a plane; ``columns`` matters only modulo ``lanes``."""
        rows = streams.rows_of(self._flow)
        self._flow, self._skew, self._below = rows.flow, rows.skew, rows.below
        self._copied = self._lanes
        return self._text({1: self._along(rows, columns)}, {1: sum(rows.depths)})

    def _text(self, groups: dict[int, Any], carried: dict[int, int]) -> str:
        """Return the module's text with its functions for stages, copies and scripts."""
        moves = {name: self._move(name) for name in ("to_rows", "from_rows")}
        self._script({"passages": self._passages(groups, carried), **moves, "drift": self._drift()})
        return str(self._module)

    def _function(self, name: str, kinds: Sequence[Any], internal: bool = True) -> Any:
        """Return a new function with argument types ``kinds``, and a builder of its body."""
        function = ir.Function(self._module, ir.FunctionType(ir.VoidType(), kinds), name)
        if internal:
            function.linkage = "internal"
        for argument in function.args:
            if argument.type == _DOUBLES:
                argument.add_attribute("noalias")
        builder = ir.IRBuilder(function.append_basic_block())
        return function, LaneCode(self._module, builder, self._lanes)

    def _group(self, together: int) -> Any:
        """Return the function that does ``together`` fused stages on rows of a chain."""
        function, code = self._function(f"stages_{together}", _STAGES)
        f, v, carried, drifts, kicks, data, plane, _, _, level, first, past = function.args
        flow, builder = self._flow, code.builder
        numbers = [code.number(data, index) for index in range(self._count)]
        stages = []
        for position in range(together):
            depths = flow.depths(followed=position < together - 1)
            index = builder.add(level, INDEX(position))
            drift, weights = code.number(drifts, index), self._weights(code, kicks, index)
            stages.append(_Stage(code, flow, numbers, drift, weights, depths))
        slots = [slot for stage in stages for stream_slots in stage.slots for slot in stream_slots]
        for row, slot in enumerate(slots):
            builder.store(code.load(carried, INDEX(row)), slot)
        planes = [builder.mul(plane, INDEX(index)) for index in range(flow.fields)]
        fields, speeds = ([builder.gep(data, [p]) for p in planes] for data in (f, v))
        with code.loop(first, past) as row:
            positions = [code.load(data, row) for data in fields]
            velocities = [code.load(data, row) for data in speeds[: flow.moving]]
            velocities += [code.constant(0.0)] * flow.resting
            for position, stage in enumerate(stages):
                stage.row(positions, velocities)
                if position < together - 1:
                    positions, velocities = stage.outcome(flow.skew)
            for stage in stages:
                stage.keep() if stage is not stages[-1] else None
            last = builder.sub(row, INDEX((together - 1) * flow.skew))
            outputs = zip(fields[: flow.moving], flow.drifted, strict=False)
            for data, index in (*outputs, *zip(speeds[: flow.moving], flow.kicked, strict=False)):
                target_row = builder.sub(last, INDEX(flow.streams[index].lag))
                code.store(data, target_row, stages[-1].latest[index])
            stages[-1].keep()
        for row, slot in enumerate(slots):
            code.store(carried, INDEX(row), builder.load(slot))
        builder.ret_void()
        return function

    def _weights(self, code: LaneCode, kicks: Any, level: Any) -> list[Any]:
        """Load the weights of a stage other than its drift."""
        count = self._flow.weights
        first = code.builder.mul(level, INDEX(count)) if count > 1 else level
        indices = [code.builder.add(first, INDEX(more)) for more in range(count)]
        return [code.number(kicks, index) for index in indices]

    def _along(self, rows: streams.Rows, columns: int) -> Any:
        """Return the function that does one stage along the rows of a plane."""
        function, code = self._function("stages_1", _STAGES)
        f, v, carried, drifts, kicks, data, plane, pitch, width, level, first, past = function.args
        flow, builder = self._flow, code.builder
        numbers = [code.number(data, stream) for stream in range(self._count)]
        drift, weights = code.number(drifts, level), self._weights(code, kicks, level)
        stage = _Stage(code, flow, numbers, drift, weights, flow.depths(followed=False))

        def begin(stream: int, row: Any, age: int) -> Any:
            """Return the address of the row that a stream had ``age`` rows ago."""
            row, depth = builder.sub(row, INDEX(age)), rows.depths[stream]
            if stream < 2 * flow.fields:
                data = f if stream < flow.fields else v
                above = builder.mul(plane, INDEX(stream % flow.fields))
            else:
                row = builder.urem(builder.add(row, INDEX(depth * age)), INDEX(depth))
                data, above = carried, builder.mul(pitch, INDEX(sum(rows.depths[:stream])))
            return builder.gep(data, [builder.add(above, builder.mul(pitch, row))])

        def cell(row: Any, column: Any, is_written: bool) -> None:
            """Generate one column; only for real columns, ``is_written``, are results stored."""

            def earlier(stream: int, age: int, columns: int) -> Any:
                there = builder.sub(column, INDEX(columns))
                return code.load(begin(stream, row, age), there)

            fronts = [earlier(stream, 0, 0) for stream in range(2 * flow.fields)]
            stage.row(fronts[: flow.fields], fronts[flow.fields :], earlier)
            for stream, depth in enumerate(rows.depths):
                if depth:
                    code.store(begin(stream, row, 0), column, stage.latest[stream])
            for stream in range(flow.moving) if is_written else ():
                code.store(begin(stream, row, 0), column, stage.latest[stream])
            for stream, kicked in enumerate(flow.kicked, flow.fields) if is_written else ():
                if kicked >= 2 * flow.fields:
                    code.store(begin(stream, row, rows.rise), column, stage.latest[kicked])
            stage.keep()

        with code.loop(first, past) as row:
            for column in range(-rows.before, 0):
                cell(row, INDEX(column), is_written=False)
            with code.loop(INDEX(0), width) as column:
                cell(row, column, is_written=True)
            for more in range(rows.after):
                cell(row, builder.add(width, INDEX(more)), is_written=False)
            for stream in range(flow.fields):
                self._close(code, begin(stream, row, 0), width, columns, rows)
        builder.ret_void()
        return function

    def _close(
        self, code: LaneCode, data: Any, width: Any, columns: int, rows: streams.Rows
    ) -> None:
        """Generate code that fills the ghost columns from the row's ends, shifted by one lane."""
        builder, lanes = code.builder, self._lanes
        last = builder.sub(width, INDEX(1))
        starts = [lane * columns // lanes for lane in range(lanes + 1)]
        short = [after - before < -(-columns // lanes) for before, after in pairwise(starts)]

        def repeat(to: Any, at: Any, step: int, moved: Sequence[int]) -> None:
            """Copy lanes ``moved`` of the vectors ``at`` and ``at + step`` to the vector ``to``."""
            one, other = (code.load(data, builder.add(at, INDEX(more))) for more in (0, step))
            code.store(data, to, one if lanes == 1 else code.picked(one, other, moved))

        up = [(lane + 1) % lanes + lanes * short[lane] for lane in range(lanes)]
        down = [(lane - 1) % lanes + lanes * short[lane - 1] for lane in range(lanes)]
        for more in range(rows.right):
            repeat(builder.add(width, INDEX(more)), INDEX(more), 1, up)
        for more in range(rows.left):
            repeat(INDEX(-1 - more), builder.sub(last, INDEX(more)), -1, down)

    def _move(self, name: str) -> Any:
        """Return the function named "to_rows" or "from_rows", which copies cells from or to rings.

        Vector r holds in lane l the cell ``starts[l] + r`` modulo ``size``; it is copied where
        ``firsts[l] <= r < pasts[l]``. Vectors are copied in blocks, so that each cache line is
        loaded once; within a block, square groups of vectors are transposed where all lanes have
        them. There are ``rings`` rings, ``ring_pitch`` doubles apart.
        """
        kinds = [*[_DOUBLES] * 2, *[_INDICES] * 3, *[INDEX] * 5]
        function, code = self._function(name, kinds)
        begin, to, starts, firsts, pasts, size, height, rings, ring_pitch, row_pitch = function.args
        builder = code.builder
        ends = [
            [builder.load(builder.gep(data, [INDEX(lane)])) for data in (starts, firsts, pasts)]
            for lane in range(self._lanes)
        ]
        with code.loop(INDEX(0), rings) as one, code.loop(INDEX(0), height, COPY_BLOCK) as low:
            ring, rows = (
                builder.gep(data, [builder.mul(one, pitch)])
                for data, pitch in ((begin, ring_pitch), (to, row_pitch))
            )
            high = code.least(builder.add(low, INDEX(COPY_BLOCK)), height)
            shared, unshared = low, high
            for start, first, past in ends:
                shared = code.most(shared, first)
                unshared = code.least(unshared, code.least(past, builder.sub(size, start)))
            together = builder.sdiv(builder.sub(unshared, shared), INDEX(self._lanes))
            together = builder.mul(code.most(together, INDEX(0)), INDEX(self._lanes))
            done = builder.add(shared, together)
            with code.loop(shared, done, self._lanes) as row:
                cells = [builder.gep(ring, [builder.add(start, row)]) for start, _, _ in ends]
                self._transpose(code, cells, rows, row, name == "to_rows")
            with code.loop(INDEX(0), INDEX(self._lanes)) as lane:
                start, first, past = (
                    builder.load(builder.gep(data, [lane])) for data in (starts, firsts, pasts)
                )
                past = code.least(high, past)
                ranges = (code.most(low, first), code.least(shared, past)), (done, past)
                for some in ranges:
                    with code.loop(*some) as row:
                        cell = builder.add(start, row)
                        beyond = builder.icmp_signed(">=", cell, size)
                        cell = builder.select(beyond, builder.sub(cell, size), cell)
                        index = builder.add(builder.mul(row, INDEX(self._lanes)), lane)
                        ends_at = builder.gep(ring, [cell]), builder.gep(rows, [index])
                        there, at = reversed(ends_at) if name == "to_rows" else ends_at
                        builder.store(builder.load(at), there)
        builder.ret_void()
        return function

    def _transpose(
        self, code: LaneCode, cells: Sequence[Any], rows: Any, row: Any, to_rows: bool
    ) -> None:
        """Generate code that copies ``lanes`` vectors from ``row`` on, transposing in registers."""
        builder, size = code.builder, range(self._lanes)
        vectors = [builder.add(row, INDEX(more)) for more in size]
        along = [builder.bitcast(cell, code.kind.as_pointer()) for cell in cells]
        if to_rows:
            block = [builder.load(at, align=8) for at in along]
        else:
            block = [code.load(rows, vector) for vector in vectors]
        step = 1
        while step < self._lanes:
            low = [lane - step + self._lanes if lane & step else lane for lane in size]
            high = [lane + self._lanes if lane & step else lane + step for lane in size]
            for one in (lane for lane in size if not lane & step):
                pair = block[one], block[one + step]
                block[one], block[one + step] = (code.picked(*pair, of) for of in (low, high))
            step *= 2
        for at, vector, value in zip(along, vectors, block, strict=True):
            if to_rows:
                code.store(rows, vector, value)
            else:
                builder.store(value, at, align=8)

    def _drift(self) -> Any:
        """Return the function of ``f += length v`` for ``count`` doubles, rounding the product."""
        function, code = self._function("drift", [*[_DOUBLES] * 3, INDEX])
        f, v, length, count = function.args
        builder = code.builder
        by = builder.load(length)
        with code.loop(INDEX(0), count) as index:
            at, speed = (builder.gep(data, [index]) for data in (f, v))
            moved = builder.fmul(by, builder.load(speed))
            builder.store(builder.fadd(builder.load(at), moved), at)
        builder.ret_void()
        return function

    def _script(self, functions: dict[str, Any]) -> None:
        """Generate the exported function, which makes ``count`` calls, each given as words."""
        function, code = self._function("script", [_INDICES, INDEX], internal=False)
        words, count = function.args
        builder, size = code.builder, 1 + max(streams.FUNCTIONS.values())
        with flushed_subnormals(self._module, builder), code.loop(INDEX(0), count) as row:
            at = builder.gep(words, [builder.mul(row, INDEX(size))])
            requested = builder.load(at)
            for index, name in enumerate(streams.FUNCTIONS):
                called = functions[name]
                with builder.if_then(builder.icmp_signed("==", requested, INDEX(index))):
                    arguments = []
                    for number, argument in enumerate(called.args, 1):
                        word = builder.load(builder.gep(at, [INDEX(number)]))
                        pointer = argument.type != INDEX
                        arguments.append(builder.inttoptr(word, argument.type) if pointer else word)
                    builder.call(called, arguments)
        builder.ret_void()

    def _passages(self, groups: dict[int, Any], depths: dict[int, int]) -> Any:
        """Return the function of ``passages`` passes of ``stages`` stages over all rows."""
        kinds = [*[_DOUBLES] * 6, *[_INDICES] * 2, *[INDEX] * 8]
        function, code = self._function("passages", kinds)
        f, v, carried, drifts, kicks, numbers, target, source, *counts = function.args
        copies, plane, pitch, width, rows, stages, passages, period = counts
        builder = code.builder
        copied = LaneCode(self._module, builder, self._copied)
        with code.loop(INDEX(0), passages) as passage:
            with code.loop(INDEX(0), copies) as copy:
                to, at = (builder.load(builder.gep(data, [copy])) for data in (target, source))
                for data in (f, v):
                    for field in range(self._flow.fields):
                        begin = builder.gep(data, [builder.mul(plane, INDEX(field))])
                        copied.store(begin, to, copied.load(begin, at))
            started = builder.srem(builder.mul(passage, stages), period)
            at_kicks = builder.mul(started, INDEX(self._flow.weights))
            weights = [builder.gep(drifts, [started]), builder.gep(kicks, [at_kicks])]
            data = f, v, carried, *weights, numbers, plane, pitch, width
            sizes = {size: builder.mul(pitch, INDEX(number)) for size, number in depths.items()}
            self._passage(code, groups, data, sizes, rows, stages)
        builder.ret_void()
        return function

    def _passage(
        self,
        code: LaneCode,
        groups: dict[int, Any],
        data: tuple[Any, ...],
        sizes: dict[int, Any],
        rows: Any,
        stages: Any,
    ) -> None:
        """Generate one pass of all stages over the rows, block by block."""
        builder, skew = code.builder, INDEX(self._skew)
        together = self._together
        paired = builder.mul(builder.sdiv(stages, INDEX(together)), INDEX(together))
        carried = data[2]
        most = builder.mul(builder.sdiv(stages, INDEX(together)), sizes[together])

        def advance(size: int, level: Any, low: Any, index: Any) -> None:
            offset = builder.mul(level, skew)
            high = code.least(builder.add(low, INDEX(self._block)), rows)
            lowest_valid = builder.mul(level, INDEX(self._below))
            first = code.most(builder.sub(low, offset), lowest_valid)
            carried_part = builder.gep(carried, [index])
            past = builder.sub(high, offset)
            builder.call(groups[size], [*data[:2], carried_part, *data[3:], level, first, past])

        with code.loop(INDEX(0), rows, self._block) as low:
            with code.loop(INDEX(0), paired, together) as level:
                number = builder.sdiv(level, INDEX(together))
                advance(together, level, low, builder.mul(number, sizes[together]))
            if together > 1:
                with code.loop(paired, stages) as level:
                    number = builder.sub(level, paired)
                    index = builder.add(most, builder.mul(number, sizes[1]))
                    advance(1, level, low, index)


def passage_text(
    flow: streams.StagePlan, lanes: int, together: int, block: int, count: int, columns: int = 0
) -> str:
    """Return the LLVM text of the stages of a lattice, which take ``count`` numbers.

    ``count`` is the number of constants. A row of a chain has ``lanes`` cells; ``together`` stages
    are fused, in blocks of ``block`` rows. A plane's stages are not fused; its number of columns is
    ``columns`` modulo ``lanes``.
    """
    writer = _Writer(flow, lanes, together, block, count)
    return writer.plane(columns) if columns else writer.chain()

"""Stages of a chain or plane as streams of values, derived from the lattice's data alone.

A stage drifts every field and kicks every velocity, in one sweep up the cells. At the front all
fields are drifted. A stretch is computed as soon as its furthest field has drifted, with it the
force, and a sum of forces as soon as its last force is known. Each of these is a *stream* with one
value for each cell; its *lag* is the number of cells by which it stays behind the front. A stream's
values are carried along as long as a stream further behind needs them.

In a plane the front goes along one row after the other; a shift is the number of rows times
`ROW_SHIFT` plus the number of columns. There each stream stays behind as far as it can (`rows_of`),
because a value computed in the row in which it is needed is not carried from row to row.

All dependence on the lattice's constants is in ``numbers``, an argument of the machine code, so
that lattices with different constants share the code. Terms that are absent, factors of 1 and
offsets of 0 are left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, NamedTuple

if TYPE_CHECKING:
    from longwave.lattice.force_program import ForceProgram
    from longwave.lattice.numeric_lattice import Entry, NumericLattice
    from longwave.lattice.variation import MassKind, Variation

Kind = Literal[
    "position", "velocity", "sum", "force", "varied", "kept", "felt", "kicked", "pulsed", "spread"
]
Polynomial = Mapping[int, float]
"""Stencil as a polynomial: maps each flat shift to its weight."""

MAX_CONSTANT_RATIO = 1e100
"""Largest ratio of a polynomial's lower coefficients to its highest at which a force is divided by
the highest: quotients then do not overflow for any stretch that occurs."""

BEYOND_SHIFTS = 10**15
"""Number larger than any shift."""

ROW_SHIFT = 2**24
"""Flat shift that stands for one row of a plane."""

DASHPOT_TERMS = 8
"""Number of terms of the exponential series of dashpots in a drift. The remainder is below rounding
if a drift changes velocities by at most 0.1, which `lattice.integration` ensures."""

FUNCTIONS = {"passages": 16, "to_rows": 10, "from_rows": 10, "drift": 4}
"""Functions in a lattice's machine code, with the number of arguments of each."""


def flat_shift(shift: Sequence[int]) -> int:
    """Encode a shift along all axes as one integer; these integers are in the order of a sweep.

    >>> rows_and_columns(flat_shift((2, -3)))
    (2, -3)
    """
    *rows, column = shift
    return sum(rows) * ROW_SHIFT + column


def rows_and_columns(shift: int) -> tuple[int, int]:
    """Return the numbers of rows and columns that a flat shift stands for."""
    rows = (shift + ROW_SHIFT // 2) // ROW_SHIFT
    return rows, shift - rows * ROW_SHIFT


class ForceFormula(NamedTuple):
    """How to compute a force. Integers are indices into the stage's numbers.

    ``factors`` are a polynomial's coefficients below the highest power, in descending order, None
    where absent; ``leading`` is the highest coefficient, None if the force is divided by it. A
    ``program`` has stack instructions, with an index for "number" and the exponent for "power".
    """

    factors: tuple[int | None, ...] = ()
    leading: int | None = None
    program: tuple[tuple[str, float], ...] = ()


class StreamRead(NamedTuple):
    """``weight``, or the stage's ``number``, times a stream's value in the cell at ``shift``."""

    stream: int
    shift: int = 0
    weight: float = 1.0
    number: int | None = None


class Stream(NamedTuple):
    """A stream: one value per cell, its inputs (``taps``) and its lag behind the front.

    Kind "kept" is a varied force that is 0 where its share is -1: the bond is cut. Kind "felt" is
    an external force that is 0 where its share is 0, whatever its law gives there. ``number`` is
    the index of a sum's offset, of the factor with which a sum kicks ``field``, of an external
    pulse, or of the weight of a series' term. ``lowest`` is the offset of the lowest cell whose
    position the stream depends on.
    """

    kind: Kind
    taps: tuple[StreamRead, ...]
    lag: int
    lowest: int
    field: int = 0
    number: int | None = None
    law: ForceFormula = ForceFormula()


class StagePlan(NamedTuple):
    """Streams of a stage in order of computation; hashable.

    Positions come first, then velocities; ``kicked`` are the streams of the new velocities. With
    ``damped`` fields, a drift takes a weight and a velocity factor for each damped field. With
    dashpots, a drift takes a ``series`` of weights, and ``spread`` are the streams of the new
    positions. There are ``pulses`` external pulses. The last ``resting`` fields hold the deviations
    of cells.
    """

    fields: int
    streams: tuple[Stream, ...]
    kicked: tuple[int, ...]
    damped: int = 0
    series: int = 0
    pulses: int = 0
    spread: tuple[int, ...] = ()
    resting: int = 0

    @property
    def moving(self) -> int:
        """Number of fields that move."""
        return self.fields - self.resting

    @property
    def weights(self) -> int:
        """Number of a stage's weights other than its drift: kick, damped drifts, series, pulses."""
        return 1 + 2 * self.damped + self.series + self.pulses

    @property
    def drifted(self) -> tuple[int, ...]:
        """Indices of the streams of the new positions."""
        return (*self.spread, *range(len(self.spread), self.fields))

    @property
    def skew(self) -> int:
        """Number of cells by which a stage follows the previous one, for its inputs to exist."""
        return max(self.streams[index].lag for index in (*self.kicked, *self.spread))

    @property
    def below(self) -> int:
        """Number of cells at the lower end that a stage leaves invalid."""
        return max(0, *(-self.streams[index].lowest for index in (*self.kicked, *self.spread)))

    def delay(self, stream: Stream, tap: StreamRead) -> int:
        """Return the number of cells ago at which the value read by ``tap`` was computed."""
        return stream.lag - tap.shift - self.streams[tap.stream].lag

    def depths(self, followed: bool) -> list[int]:
        """Return how many earlier values of each stream must be stored.

        If ``followed``, they include those that the next fused stage reads.
        """
        depths = [0] * len(self.streams)
        for stream in self.streams:
            for tap in stream.taps:
                rows, cells = rows_and_columns(self.delay(stream, tap))
                depths[tap.stream] = max(depths[tap.stream], 0 if rows else cells)
        for index in (*self.drifted, *self.kicked) if followed else ():
            depths[index] = max(depths[index], self.skew - self.streams[index].lag)
        return depths

    def carried_values(self, together: int) -> int:
        """Return how many values ``together`` fused stages carry from row to row."""
        return sum(sum(self.depths(position < together - 1)) for position in range(together))

    @property
    def operations(self) -> int:
        """Instructions per cell and stage; each fused multiply-add or function counts once."""
        total = self.fields + self.damped
        for stream in self.streams:
            if stream.kind == "sum":
                scaled = any(tap.weight != 1.0 or tap.number is not None for tap in stream.taps[:1])
                total += max(len(stream.taps) - 1, 0) + scaled + (stream.number is not None)
            elif stream.kind == "force":
                total += _operations(stream.law)
            elif stream.kind in ("varied", "kept", "felt", "kicked", "pulsed", "spread"):
                total += 1
        return total


def _operations(law: ForceFormula) -> int:
    """Return the number of arithmetic instructions of a force."""
    if law.program:
        return sum(word not in ("x", "number") for word, _ in law.program)
    if not law.factors:
        return int(law.leading is not None)
    first = law.factors[0] is not None or law.leading is not None
    return first + len(law.factors)


class Rows(NamedTuple):
    """Plan of a stage that goes along the rows of a plane; hashable.

    The kick is ``rise`` rows behind the front and depends on that many rows above its own and
    ``below`` rows under it; a stage stays ``skew`` rows behind the previous stage. In each row
    streams are also computed on ``before`` and ``after`` ghost columns at its ends. Positions on
    ``left`` and ``right`` ghost columns repeat those at the other end; ``margin`` columns are read.
    ``depths`` are the numbers of rows stored of each stream.
    """

    flow: StagePlan
    rise: int
    below: int
    skew: int
    before: int
    after: int
    left: int
    right: int
    margin: int
    depths: tuple[int, ...]


@lru_cache(maxsize=256)
def rows_of(flow: StagePlan) -> Rows:
    """Return the plan of a stage on a plane's rows, with each stream computed as late as possible.

    A row's ghost columns exist only after all of it has drifted; until then a stream may read its
    own column only.
    """
    rise = rows_and_columns(flow.skew)[0]
    columns = _columns(flow)
    late = _late(flow, rise)
    if any(
        late.delay(stream, tap) < ROW_SHIFT // 2 and (tap.shift != stream.lag or any(felt))
        for stream, felt in zip(late.streams, columns, strict=True)
        for tap in stream.taps
        if late.streams[tap.stream].kind == "position"
    ):
        rise += 1
        late = _late(flow, rise)
    reads = [(t.stream, *rows_and_columns(late.delay(s, t))) for s in late.streams for t in s.taps]
    formed = [
        (low + rows_and_columns(stream.lag)[1], high + rows_and_columns(stream.lag)[1])
        for stream, (low, high) in zip(
            late.streams[2 * late.fields :], columns[2 * late.fields :], strict=True
        )
    ]
    before = max(0, *(-low for low, _ in formed)) if formed else 0
    after = max(0, *(high for _, high in formed)) if formed else 0
    depths = [0] * len(late.streams)
    for index, rows, column in reads:
        if index >= 2 * flow.fields and rows:
            depths[index] = max(depths[index], rows + (column > 0))
    ends = columns[: flow.fields]
    return Rows(
        late,
        rise,
        -min(0, *(rows_and_columns(late.streams[index].lowest)[0] for index in late.kicked)),
        max(1, rise, *(rows for index, rows, _ in reads if index < flow.fields)),
        before,
        after,
        -min(low for low, _ in ends),
        max(high for _, high in ends),
        max(before, after) + max(0, *(abs(column) for _, _, column in reads)),
        tuple(depths),
    )


def _late(flow: StagePlan, rise: int) -> StagePlan:
    """Return the plan with late streams; the kick is ``rise`` rows behind the front."""
    lags: dict[int, int] = {}
    streams = list(flow.streams)
    for index in range(len(streams) - 1, 2 * flow.fields - 1, -1):
        stream = streams[index]
        lag = rise * ROW_SHIFT if stream.kind == "kicked" else lags.get(index, stream.lag)
        streams[index] = stream._replace(lag=lag)
        for tap in stream.taps:
            lags[tap.stream] = min(lag - tap.shift, lags.get(tap.stream, BEYOND_SHIFTS))
    return flow._replace(streams=tuple(streams))


def _columns(flow: StagePlan) -> list[tuple[int, int]]:
    """Return the ghost columns (left <= 0, right >= 0) on which each stream is needed."""
    columns = [(0, 0)] * len(flow.streams)
    for index in range(len(flow.streams) - 1, -1, -1):
        for tap in flow.streams[index].taps:
            step, (low, high) = rows_and_columns(tap.shift)[1], columns[tap.stream]
            here = columns[index]
            columns[tap.stream] = min(low, here[0] + step), max(high, here[1] + step)
    return columns


@lru_cache(maxsize=256)
def stage_plan(lattice: NumericLattice) -> tuple[StagePlan, tuple[float, ...]]:
    """Return the streams of a stage of the lattice, and the constants to which they refer by index.

    Raises ValueError for a lattice of more than two dimensions.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> lattice = numeric_lattice(LATTICES["beta_fput"], {"K2": 4, "K4": 1})
    >>> flow, numbers = stage_plan(lattice)
    >>> flow.operations, flow.skew, numbers
    (6, 1, (4.0, 1.0))
    """
    flow, numbers, _ = varied_stage_plan(lattice, None)
    return flow, numbers


class VariedStagePlan(NamedTuple):
    """Stage of a lattice whose masses or springs differ from cell to cell.

    The deviations are additional fields, after the lattice's, that do not move. Each holds a row of
    the chain's `shares` times its entry of ``units``.
    """

    flow: StagePlan
    numbers: tuple[float, ...]
    units: tuple[float, ...]


@lru_cache(maxsize=256)
def varied_stage_plan(lattice: NumericLattice, variation: Variation | None) -> VariedStagePlan:
    """Return the `stage_plan` of a lattice with a variation from cell to cell, if any."""
    if lattice.dimension > 2:
        raise ValueError(
            f"lattice must be a chain or a plane, got {lattice.name} in {lattice.dimension} "
            "dimensions (rows of cells go up one axis)"
        )
    fields = len(lattice.fields)
    added = 0 if variation is None else variation.rows(fields) + len(variation.pulsed)
    builder = _Builder(fields + added)
    acting: list[list[_Part]] = [[] for _ in lattice.fields]
    units = [] if variation is None else [1.0] * variation.mass_rows(fields)
    spread: tuple[int, ...] = ()
    if variation is not None and variation.dashpots:
        spread = builder.spread(lattice, variation)
    for index, bond in enumerate(lattice.bonds):
        law, unit = force_formula(bond.force, builder.number)
        if law is None:
            continue
        stretch = builder.stretch(bond.stretch, bond.offset)
        force = builder.add("force", [stretch], law=law)
        part = None if variation is None or not variation.forces else variation.forces[index]
        if part is not None:
            share, own = force_formula(part, builder.number)
            assert share is not None
            weight, units = StreamRead(fields + len(units)), [*units, own / unit]
            varied = builder.add("force", [stretch], law=share)
            taps = [StreamRead(force), weight, StreamRead(varied)]
            force = builder.add("kept" if part == bond.force else "varied", taps)
        for of, parts in enumerate(acting):
            stencil = merged_weights(entry for entry in bond.action if entry.field == of)
            if stencil:
                parts.append(_part(unit, force, stencil))
    units += [1.0] if variation is not None and variation.walled else []
    masses = variation.masses if variation is not None else None
    kicked = [
        builder.kicked(index, parts, mass, None if masses is None else fields + index, masses)
        for index, (parts, mass) in enumerate(zip(acting, lattice.masses, strict=True))
    ]
    pulsed = variation.pulsed if variation is not None else ()
    for pulse, (index, factor) in enumerate(pulsed):
        felt, unit = builder.felt(StreamRead(fields + len(units)), index, factor)
        taps = [StreamRead(kicked[index]), felt]
        kicked[index] = builder.add("pulsed", taps, 0, field=index, number=pulse)
        units.append(unit)
    kicked += range(builder.fields + fields, 2 * builder.fields)
    damped = fields if variation is not None and variation.damped and not spread else 0
    flow = StagePlan(
        builder.fields,
        tuple(builder.streams),
        tuple(kicked),
        damped,
        2 * DASHPOT_TERMS + 1 if spread else 0,
        len(pulsed),
        spread,
        builder.fields - fields,
    )
    return VariedStagePlan(flow, tuple(builder.numbers), tuple(units))


class _Part(NamedTuple):
    """Summand of an acceleration: ``factor`` times the sum of a stream's values in a stencil."""

    factor: float
    stream: int
    stencil: Polynomial


def merged_weights(entries: Iterable[Entry]) -> dict[int, float]:
    """Return the total weight at each shift; zero weights are left out."""
    weights: dict[int, float] = {}
    for entry in entries:
        shift_number = flat_shift(entry.shift)
        weights[shift_number] = weights.get(shift_number, 0.0) + entry.weight
    return {n: weights[n] for n in sorted(weights, reverse=True) if weights[n] != 0.0}


def _part(unit: float, stream: int, stencil: dict[int, float]) -> _Part:
    """Return ``unit * stencil`` as a part, normalised: first weight positive, integers coprime."""
    first = next(iter(stencil.values()))
    common = abs(first)
    if all(weight == round(weight) for weight in stencil.values()):
        common = float(math.gcd(*(round(weight) for weight in stencil.values())))
    common = math.copysign(common, first)
    return _Part(unit * common, stream, {shift: w / common for shift, w in stencil.items()})


def _quotient(stencil: Polynomial, step: int, sign: int, most: int) -> dict[int, float] | None:
    """Return the stencil divided by the stencil ``value[n + step] + sign value[n]``.

    None if there is a remainder, or if the quotient has more than ``most`` terms.
    """
    dividend = dict(stencil)
    quotient: dict[int, float] = {}
    lowest = min(stencil)
    while dividend:
        top = max(dividend)
        if top - step < lowest or len(quotient) == most:
            return None
        weight = quotient[top - step] = dividend.pop(top)
        rest = dividend.pop(top - step, 0.0) - sign * weight
        if rest != 0.0:
            dividend[top - step] = rest
    return quotient


def _work(parts: Sequence[_Part]) -> int:
    """Return the number of additions that the sum of the parts takes."""
    return sum(len(part.stencil) for part in parts) - 1


def force_formula(
    force: ForceProgram, number: Callable[[float], int]
) -> tuple[ForceFormula | None, float]:
    """Return a formula (None for a force of 0) and a unit; their product is the force.

    ``number`` is called with a constant and returns its index.
    """
    if force.instructions:
        program = tuple(
            (word, float(number(value)) if word == "number" else value)
            for word, value in force.instructions
        )
        return ForceFormula(program=program), 1.0
    highest = max((i for i, value in enumerate(force.coefficients) if value), default=None)
    if highest is None:
        return None, 1.0
    unit = force.coefficients[highest]
    lower = force.coefficients[:highest][::-1]
    monic = max(map(abs, lower), default=0.0) <= MAX_CONSTANT_RATIO * abs(unit)
    leading, unit = (None, unit) if monic else (number(unit), 1.0)
    factors = tuple(number(value / unit) if value else None for value in lower)
    return ForceFormula(factors, leading), unit


@dataclass
class _Builder:
    """Collects the streams and numbers of a stage."""

    fields: int
    streams: list[Stream] = field(default_factory=list)
    numbers: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        for kind in ("position", "velocity"):
            for index in range(self.fields):
                self.streams.append(Stream(kind, (), 0, 0, index))
        self.positions = [StreamRead(index) for index in range(self.fields)]
        self.velocities = [StreamRead(self.fields + index) for index in range(self.fields)]

    def number(self, value: float) -> int:
        """Return the index of a number of the stage; a new number is added."""
        if value not in self.numbers:
            self.numbers.append(value)
        return self.numbers.index(value)

    def add(
        self, kind: Kind, taps: Sequence[StreamRead], low: int = -BEYOND_SHIFTS, **more: object
    ) -> int:
        """Return the index of a stream with these taps; a new stream is added."""
        lags = [tap.shift + self.streams[tap.stream].lag for tap in taps]
        lag = max(max(lags, default=0), low)
        lowest = min((tap.shift + self.streams[tap.stream].lowest for tap in taps), default=0)
        stream = Stream(kind, tuple(taps), lag, lowest, **more)  # type: ignore[arg-type]
        if stream not in self.streams:
            self.streams.append(stream)
        return self.streams.index(stream)

    def stretch(
        self, entries: Sequence[Entry], offset: float, values: Sequence[StreamRead] = ()
    ) -> StreamRead:
        """Return a bond's stretch by the streams ``values``, by default the positions."""
        taps = []
        for index, read in enumerate(values or self.positions):
            stencil = merged_weights(entry for entry in entries if entry.field == index)
            taps += [read._replace(shift=shift, weight=weight) for shift, weight in stencil.items()]
        taps.sort(key=lambda tap: tap.weight != 1.0)
        if len(taps) == 1 and taps[0].weight == 1.0 and offset == 0.0:
            return taps[0]
        number = self.number(offset) if offset else None
        return StreamRead(self.add("sum", taps, number=number))

    def varied(self, base: StreamRead, factor: StreamRead, change: StreamRead) -> int:
        """Add the stream ``base + factor * change``, cell by cell, and return its index."""
        return self.add("varied", [base, factor, change])

    def felt(
        self, weight: StreamRead, index: int, factor: ForceProgram | None
    ) -> tuple[StreamRead, float]:
        """Return the read of ``weight``, times the field's law ``factor`` if any; and a unit."""
        if factor is None:
            return weight, 1.0
        law, unit = force_formula(factor, self.number)
        assert law is not None
        own, none = self.add("force", [self.positions[index]], law=law), self.add("sum", [])
        return StreamRead(self.add("felt", [StreamRead(none), weight, StreamRead(own)])), unit

    def kicked(
        self,
        index: int,
        parts: Sequence[_Part],
        mass: float,
        deviation: int | None = None,
        masses: MassKind | None = None,
    ) -> int:
        """Return the index of the stream of a field's velocities after the kick by ``parts``.

        ``deviation`` is the field with the relative deviations of inverse masses, if they vary.
        """
        if not parts:
            return self.velocities[index].stream
        unit = parts[0].factor
        scaled = [part._replace(factor=part.factor / unit) for part in parts]
        if deviation is None:
            total = self.total(scaled)
        elif masses == "strains":
            pulls = self._divided(scaled, 1, -1, BEYOND_SHIFTS)
            assert pulls is not None
            pull = self.total(pulls)
            moved = self.varied(pull, StreamRead(deviation), pull)
            total = StreamRead(self.add("sum", [StreamRead(moved, 1), StreamRead(moved, 0, -1.0)]))
        else:
            pull = self.total(scaled)
            total = StreamRead(self.varied(pull, StreamRead(deviation), pull))
        number = self.number(unit / mass)
        taps = [self.velocities[index], total]
        return self.add("kicked", taps, 0, field=index, number=number)

    def spread(self, lattice: NumericLattice, variation: Variation) -> tuple[int, ...]:
        """Add the streams of a drift with dashpots; return the streams of the new positions."""
        fields, rates = len(lattice.fields), variation.damped
        shares = [StreamRead(fields + index) for index in range(variation.mass_rows(fields))]
        cut = iter(range(fields + len(shares), self.fields))
        cuts = [
            StreamRead(next(cut)) if part is not None else None
            for part in variation.forces or (None,) * len(lattice.bonds)
        ]
        rows = fields + variation.rows(fields)
        walls = [StreamRead(rows - 1)] * fields if variation.walled else shares
        terms = [self.velocities[:fields]]
        for _ in range(DASHPOT_TERMS):
            before = terms[-1] if len(terms) > 1 else self._cells(terms[0], walls)
            parts: list[list[_Part]] = [
                [_Part(-rate, read.stream, {0: 1.0})] if rate else []
                for rate, read in zip(rates, before, strict=True)
            ]
            for bond, dashpot, cut_row in zip(lattice.bonds, variation.dashpots, cuts, strict=True):
                if not dashpot:
                    continue
                pull = self.stretch(bond.stretch, 0.0, before)
                if cut_row is not None or pull.shift or pull.weight != 1.0:
                    pull = StreamRead(self.add("sum", [pull]))
                if cut_row is not None:
                    pull = StreamRead(self.varied(pull, cut_row, pull))
                for of, mass in enumerate(lattice.masses):
                    stencil = merged_weights(entry for entry in bond.action if entry.field == of)
                    if stencil:
                        parts[of].append(_Part(dashpot / mass, pull.stream, stencil))
            sums = [StreamRead(self.add("sum", [self.total(part)])) for part in parts]
            terms.append(self._cells(sums, shares))
        for index in range(fields):
            position, velocity = self.positions[index], self.velocities[index]
            for power, term in enumerate(terms):
                position = self._spread(position, term[index], power)
                if power:
                    velocity = self._spread(velocity, term[index], DASHPOT_TERMS + power)
            self.positions[index], self.velocities[index] = position, velocity
        return tuple(read.stream for read in self.positions[:fields])

    def _spread(self, total: StreamRead, term: StreamRead, weight: int) -> StreamRead:
        """Return ``total`` plus ``term`` times the series weight with index ``weight``."""
        return StreamRead(self.add("spread", [total, term], 0, number=weight))

    def _cells(self, reads: Sequence[StreamRead], shares: Sequence[StreamRead]) -> list[StreamRead]:
        """Return the values times ``1 + share``, cell by cell; that factor is 0 in walls."""
        if not shares:
            return list(reads)
        pairs = zip(reads, shares, strict=True)
        return [StreamRead(self.varied(read, share, read)) for read, share in pairs]

    def total(self, parts: Sequence[_Part]) -> StreamRead:
        """Return the sum of the parts, factored by common divisors to save instructions."""
        if len(parts) == 1 and len(parts[0].stencil) == 1 and parts[0].factor == 1.0:
            [(shift, weight)] = parts[0].stencil.items()
            if weight == 1.0:
                return StreamRead(parts[0].stream, shift)
        steps = {a - b for part in parts for a in part.stencil for b in part.stencil if a > b}
        for step in sorted(steps):
            for sign in (-1, 1):
                divided = self._divided(parts, step, sign, _work(parts))
                if divided is not None and _work(divided) < _work(parts):
                    inner = self.total(divided)
                    upper = inner._replace(shift=inner.shift + step)
                    lower = inner._replace(weight=sign * inner.weight)
                    return StreamRead(self.add("sum", [upper, lower]))
        taps = [tap for part in parts for tap in self._terms(part, alone=len(parts) == 1)]
        return StreamRead(self.add("sum", taps))

    def _divided(
        self, parts: Sequence[_Part], step: int, sign: int, most: int
    ) -> list[_Part] | None:
        """Return the parts with divided stencils (`_quotient`); None if one is not divisible."""
        result = []
        for part in parts:
            quotient = _quotient(part.stencil, step, sign, most)
            if quotient is None:
                return None
            result.append(part._replace(stencil=quotient))
        return result

    def _terms(self, part: _Part, alone: bool) -> list[StreamRead]:
        """Return stream reads whose sum is the part; ``alone`` if no other part is summed."""
        factor, stream, stencil = part
        if abs(factor) == 1.0 and alone:
            return [StreamRead(stream, shift, factor * weight) for shift, weight in stencil.items()]
        if len(stencil) == 1:
            [(shift, weight)] = stencil.items()
            inner = StreamRead(stream, shift, weight)
        else:
            inner = self.total([part._replace(factor=1.0)])
        factor *= inner.weight
        if abs(factor) == 1.0:
            return [inner._replace(weight=factor)]
        return [inner._replace(weight=1.0, number=self.number(factor))]

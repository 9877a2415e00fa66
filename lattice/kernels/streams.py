"""What one stage computes for a chain or plane, as streams: written from the lattice's data alone.

A stage drifts every field and kicks every velocity. It goes up the cells once. At the front all
fields are drifted; a stretch is formed as soon as its furthest field has drifted, a force with it,
a sum of forces as soon as its last force is there. Each of these is a *stream*, one value a cell,
and its *lag* is the number of cells by which it stays behind the front. What has to be carried
follows: a stream is kept as long as one that is further behind needs it.

In a plane the front goes along one row after the other: a shift is so many rows times `SPAN`, and
so many columns. There each stream stays behind as far as it can (`rows_of`): what is formed in the
row in which it is needed is not kept for rows.

What depends on the lattice's constants alone goes into ``numbers``, which the machine code takes as
an argument: lattices that differ in constants share it. Terms that are absent, factors that are 1
and offsets that are 0 have no place in it.
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
"""A stencil: weights by shift."""

MONIC = 1e100
"""A force is taken in units of its highest constant where the others are at most so many times as
large: the quotients then overflow for no stretch that a run may meet."""

MOST = 10**15
"""Beyond all shifts."""

SPAN = 2**24
"""What stands for one row in a shift."""

TERMS = 8
"""Of the series by which velocities spread through dashpots in a drift: what is left out is less
than rounding where a drift turns them by 0.1, as `lattice.integration` sees to."""

FUNCTIONS = {"passages": 16, "to_rows": 10, "from_rows": 10, "drift": 4}
"""What the machine code of a lattice has, and how many arguments each function takes."""


def joined(shift: Sequence[int]) -> int:
    """A shift along each axis as one number; they are ordered as cells are met.

    >>> apart(joined((2, -3)))
    (2, -3)
    """
    *rows, column = shift
    return sum(rows) * SPAN + column


def apart(shift: int) -> tuple[int, int]:
    """The rows and columns of a shift."""
    rows = (shift + SPAN // 2) // SPAN
    return rows, shift - rows * SPAN


class ForceFormula(NamedTuple):
    """A force's arithmetic. Integers are places in the numbers.

    A polynomial's ``factors`` are those of the powers below the highest, from above, None where one
    is absent; ``leading`` is that of the highest power, None where the force is taken in its unit.
    A ``program`` has words for a stack, with a place for "number" and the exponent for "power".
    """

    factors: tuple[int | None, ...] = ()
    leading: int | None = None
    program: tuple[tuple[str, float], ...] = ()


class StreamRead(NamedTuple):
    """``weight`` times a stream's value at the cell at offset ``shift``.

    If ``number`` is given, the factor is the one that stands there.
    """

    stream: int
    shift: int = 0
    weight: float = 1.0
    number: int | None = None


class Stream(NamedTuple):
    """One value a cell: what it is made of, and how far it stays behind the front.

    What is ``kept`` is a varied force, and nothing where its share is -1: the bond is cut. What is
    ``felt`` from outside is nothing where its share is 0, whatever its law is there.
    ``number`` is the place of a sum's offset, of the factor with which a sum kicks ``field``, of
    the pulse that does so from outside, or of the weight with which a series takes a term.
    ``lowest`` is the furthest cell below its own of which it feels a position.
    """

    kind: Kind
    taps: tuple[StreamRead, ...]
    lag: int
    lowest: int
    field: int = 0
    number: int | None = None
    law: ForceFormula = ForceFormula()


class StagePlan(NamedTuple):
    """The streams of a stage in the order in which they are formed; hashable.

    The positions come first, then the velocities; ``kicked`` are the streams of the new velocities.
    If it is ``damped``, a drift takes a weight and a factor of the velocity for each of so many
    fields. Where velocities spread, a drift takes a series of so many weights, and the streams of
    the new positions are those ``spread``. There are so many ``pulses``. The last fields, so many,
    are ``resting``: they hold what differs from cell to cell.
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
        """The fields that are not resting."""
        return self.fields - self.resting

    @property
    def weights(self) -> int:
        """Numbers of a stage beside its drift: kick, those of damped drifts, series, pulses."""
        return 1 + 2 * self.damped + self.series + self.pulses

    @property
    def drifted(self) -> tuple[int, ...]:
        """The streams of the new positions."""
        return (*self.spread, *range(len(self.spread), self.fields))

    @property
    def skew(self) -> int:
        """Cells by which one stage stays behind the stage before: it needs all its values."""
        return max(self.streams[place].lag for place in (*self.kicked, *self.spread))

    @property
    def below(self) -> int:
        """Cells at the lower end that a stage leaves untrue."""
        return max(0, *(-self.streams[place].lowest for place in (*self.kicked, *self.spread)))

    def behind(self, stream: Stream, tap: StreamRead) -> int:
        """How long ago the value was formed that a stream takes there."""
        return stream.lag - tap.shift - self.streams[tap.stream].lag

    def depths(self, followed: bool) -> list[int]:
        """How many earlier values of each stream are kept; ``followed`` if a stage goes behind."""
        kept = [0] * len(self.streams)
        for stream in self.streams:
            for tap in stream.taps:
                rows, cells = apart(self.behind(stream, tap))
                kept[tap.stream] = max(kept[tap.stream], 0 if rows else cells)
        for place in (*self.drifted, *self.kicked) if followed else ():
            kept[place] = max(kept[place], self.skew - self.streams[place].lag)
        return kept

    def kept(self, together: int) -> int:
        """How many values that many stages keep between two rows."""
        return sum(sum(self.depths(behind < together - 1)) for behind in range(together))

    @property
    def operations(self) -> int:
        """Arithmetic instructions a cell and stage; a fused multiply-add counts once.

        A function of a force counts once, too.
        """
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
    if law.program:
        return sum(word not in ("x", "number") for word, _ in law.program)
    if not law.factors:
        return int(law.leading is not None)
    first = law.factors[0] is not None or law.leading is not None
    return first + len(law.factors)


class Rows(NamedTuple):
    """A stage that goes along the rows of a plane; hashable.

    The kick is ``rise`` whole rows behind the front and feels so many above its own, ``below`` of
    them below it; a stage stays ``skew`` rows behind the one before. For a row streams are formed
    on ``before`` and ``after`` more columns beside it, where positions repeat those at its other
    end, ``left`` and ``right`` of them; ``margin`` columns are read. ``depths``: the rows that are
    kept of each stream.
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
    """The stage with streams that are as late as they can be.

    A row has no ends before all of it is drifted: until then only its own column is taken.
    """
    rise = apart(flow.skew)[0]
    columns = _columns(flow)
    late = _late(flow, rise)
    if any(
        late.behind(stream, tap) < SPAN // 2 and (tap.shift != stream.lag or any(felt))
        for stream, felt in zip(late.streams, columns, strict=True)
        for tap in stream.taps
        if late.streams[tap.stream].kind == "position"
    ):
        rise += 1
        late = _late(flow, rise)
    reads = [(tap.stream, *apart(late.behind(s, tap))) for s in late.streams for tap in s.taps]
    formed = [
        (low + apart(stream.lag)[1], high + apart(stream.lag)[1])
        for stream, (low, high) in zip(
            late.streams[2 * late.fields :], columns[2 * late.fields :], strict=True
        )
    ]
    before = max(0, *(-low for low, _ in formed)) if formed else 0
    after = max(0, *(high for _, high in formed)) if formed else 0
    depths = [0] * len(late.streams)
    for place, rows, column in reads:
        if place >= 2 * flow.fields and rows:
            depths[place] = max(depths[place], rows + (column > 0))
    ends = columns[: flow.fields]
    return Rows(
        late,
        rise,
        -min(0, *(apart(late.streams[place].lowest)[0] for place in late.kicked)),
        max(1, rise, *(rows for place, rows, _ in reads if place < flow.fields)),
        before,
        after,
        -min(low for low, _ in ends),
        max(high for _, high in ends),
        max(before, after) + max(0, *(abs(column) for _, _, column in reads)),
        tuple(depths),
    )


def _late(flow: StagePlan, rise: int) -> StagePlan:
    """The streams with a kick so many rows behind the front, as late as what needs them allows."""
    lags: dict[int, int] = {}
    streams = list(flow.streams)
    for place in range(len(streams) - 1, 2 * flow.fields - 1, -1):
        stream = streams[place]
        lag = rise * SPAN if stream.kind == "kicked" else lags.get(place, stream.lag)
        streams[place] = stream._replace(lag=lag)
        for tap in stream.taps:
            lags[tap.stream] = min(lag - tap.shift, lags.get(tap.stream, MOST))
    return flow._replace(streams=tuple(streams))


def _columns(flow: StagePlan) -> list[tuple[int, int]]:
    """The columns beside a row's own, at either end, on which each stream is needed."""
    found = [(0, 0)] * len(flow.streams)
    for place in range(len(flow.streams) - 1, -1, -1):
        for tap in flow.streams[place].taps:
            step, (low, high) = apart(tap.shift)[1], found[tap.stream]
            here = found[place]
            found[tap.stream] = min(low, here[0] + step), max(high, here[1] + step)
    return found


@lru_cache(maxsize=256)
def stage_plan(lattice: NumericLattice) -> tuple[StagePlan, tuple[float, ...]]:
    """The streams of a stage of that lattice, and the numbers that they take.

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
    """A stage of a lattice whose masses or springs differ from cell to cell.

    What differs stands in fields of its own behind the lattice's, which rest; each holds shares
    times its unit.
    """

    flow: StagePlan
    numbers: tuple[float, ...]
    units: tuple[float, ...]


@lru_cache(maxsize=256)
def varied_stage_plan(lattice: NumericLattice, variation: Variation | None) -> VariedStagePlan:
    """`stage_plan` with what differs from cell to cell, if anything does."""
    if lattice.dimension > 2:
        raise ValueError(
            f"lattice must be a chain or a plane, got {lattice.name} in {lattice.dimension} "
            "dimensions (rows of cells go up one axis)"
        )
    fields = len(lattice.fields)
    builder = _Builder(fields + (0 if variation is None else variation.added_fields(fields)))
    acting: list[list[_Part]] = [[] for _ in lattice.fields]
    units = [] if variation is None else [1.0] * variation.mass_rows(fields)
    spread: tuple[int, ...] = ()
    if variation is not None and variation.dashpots:
        spread = builder.spread(lattice, variation)
    for place, bond in enumerate(lattice.bonds):
        law, unit = force_formula(bond.force, builder.number)
        if law is None:
            continue
        stretch = builder.stretch(bond.stretch, bond.offset)
        force = builder.force(stretch, law)
        part = None if variation is None or not variation.forces else variation.forces[place]
        if part is not None:
            share, own = force_formula(part, builder.number)
            assert share is not None
            weight, units = StreamRead(fields + len(units)), [*units, own / unit]
            taps = [StreamRead(force), weight, StreamRead(builder.force(stretch, share))]
            force = builder.add("kept" if part == bond.force else "varied", taps)
        for of, parts in enumerate(acting):
            stencil = _merged(entry for entry in bond.action if entry.field == of)
            if stencil:
                parts.append(_part(unit, force, stencil))
    units += [1.0] if variation is not None and variation.walled else []
    masses = variation.masses if variation is not None else None
    kicked = [
        builder.kicked(place, parts, mass, None if masses is None else fields + place, masses)
        for place, (parts, mass) in enumerate(zip(acting, lattice.masses, strict=True))
    ]
    pulsed = variation.pulsed if variation is not None else ()
    for pulse, (place, factor) in enumerate(pulsed):
        felt, unit = builder.felt(StreamRead(fields + len(units)), place, factor)
        taps = [StreamRead(kicked[place]), felt]
        kicked[place] = builder.add("pulsed", taps, 0, field=place, number=pulse)
        units.append(unit)
    kicked += range(builder.fields + fields, 2 * builder.fields)
    damped = fields if variation is not None and variation.damped and not spread else 0
    flow = StagePlan(
        builder.fields,
        tuple(builder.streams),
        tuple(kicked),
        damped,
        2 * TERMS + 1 if spread else 0,
        len(pulsed),
        spread,
        builder.fields - fields,
    )
    return VariedStagePlan(flow, tuple(builder.numbers), tuple(units))


class _Part(NamedTuple):
    """``factor`` times the stencil's sum over a stream."""

    factor: float
    stream: int
    stencil: Polynomial


def _merged(entries: Iterable[Entry]) -> dict[int, float]:
    """The weights by shift, those that cancel left out."""
    found: dict[int, float] = {}
    for entry in entries:
        place = joined(entry.shift)
        found[place] = found.get(place, 0.0) + entry.weight
    return {shift: found[shift] for shift in sorted(found, reverse=True) if found[shift] != 0.0}


def _part(unit: float, stream: int, stencil: dict[int, float]) -> _Part:
    """The part with whole weights without a common divisor, the uppermost positive, if it can."""
    first = next(iter(stencil.values()))
    common = abs(first)
    if all(weight == round(weight) for weight in stencil.values()):
        common = float(math.gcd(*(round(weight) for weight in stencil.values())))
    common = math.copysign(common, first)
    return _Part(unit * common, stream, {shift: w / common for shift, w in stencil.items()})


def _quotient(stencil: Polynomial, step: int, sign: int, most: int) -> dict[int, float] | None:
    """The stencil divided by ``value[n + step] + sign value[n]``.

    None if that leaves a rest or has more than so many terms.
    """
    left = dict(stencil)
    found: dict[int, float] = {}
    lowest = min(stencil)
    while left:
        top = max(left)
        if top - step < lowest or len(found) == most:
            return None
        weight = found[top - step] = left.pop(top)
        rest = left.pop(top - step, 0.0) - sign * weight
        if rest != 0.0:
            left[top - step] = rest
    return found


def _work(parts: Sequence[_Part]) -> int:
    return sum(len(part.stencil) for part in parts) - 1


def force_formula(
    force: ForceProgram, number: Callable[[float], int]
) -> tuple[ForceFormula | None, float]:
    """A force's arithmetic and its unit, ``number`` giving places; None if there is no force."""
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
    monic = max(map(abs, lower), default=0.0) <= MONIC * abs(unit)
    leading, unit = (None, unit) if monic else (number(unit), 1.0)
    factors = tuple(number(value / unit) if value else None for value in lower)
    return ForceFormula(factors, leading), unit


@dataclass
class _Builder:
    """The streams and numbers so far."""

    fields: int
    streams: list[Stream] = field(default_factory=list)
    numbers: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        for kind in ("position", "velocity"):
            for place in range(self.fields):
                self.streams.append(Stream(kind, (), 0, 0, place))
        self.positions = [StreamRead(place) for place in range(self.fields)]
        self.velocities = [StreamRead(self.fields + place) for place in range(self.fields)]

    def number(self, value: float) -> int:
        """The place of that number."""
        if value not in self.numbers:
            self.numbers.append(value)
        return self.numbers.index(value)

    def add(
        self, kind: Kind, taps: Sequence[StreamRead], least: int = -MOST, **more: object
    ) -> int:
        """The place of a stream of these taps; one that is there already is not formed twice."""
        lags = [tap.shift + self.streams[tap.stream].lag for tap in taps]
        lag = max(max(lags, default=0), least)
        lowest = min((tap.shift + self.streams[tap.stream].lowest for tap in taps), default=0)
        made = Stream(kind, tuple(taps), lag, lowest, **more)  # type: ignore[arg-type]
        if made not in self.streams:
            self.streams.append(made)
        return self.streams.index(made)

    def stretch(
        self, entries: Sequence[Entry], offset: float, of: Sequence[StreamRead] = ()
    ) -> StreamRead:
        """What a bond of a cell is stretched by: the same ``of`` other values than positions."""
        taps = []
        for place, read in enumerate(of or self.positions):
            stencil = _merged(entry for entry in entries if entry.field == place)
            taps += [read._replace(shift=shift, weight=weight) for shift, weight in stencil.items()]
        taps.sort(key=lambda tap: tap.weight != 1.0)
        if len(taps) == 1 and taps[0].weight == 1.0 and offset == 0.0:
            return taps[0]
        number = self.number(offset) if offset else None
        return StreamRead(self.add("sum", taps, number=number))

    def force(self, stretch: StreamRead, law: ForceFormula) -> int:
        """The force of such a bond."""
        return self.add("force", [stretch], law=law)

    def varied(self, whole: StreamRead, share: StreamRead, part: StreamRead) -> int:
        """``whole + share part``, cell by cell."""
        return self.add("varied", [whole, share, part])

    def felt(
        self, share: StreamRead, place: int, factor: ForceProgram | None
    ) -> tuple[StreamRead, float]:
        """The share times the factor at a field's position, if any, and the share's unit."""
        if factor is None:
            return share, 1.0
        law, unit = force_formula(factor, self.number)
        assert law is not None
        own, none = self.force(self.positions[place], law), self.add("sum", [])
        return StreamRead(self.add("felt", [StreamRead(none), share, StreamRead(own)])), unit

    def kicked(
        self,
        place: int,
        parts: Sequence[_Part],
        mass: float,
        share: int | None = None,
        masses: MassKind | None = None,
    ) -> int:
        """The velocity of a field after the kick.

        ``share``: the field by which a cell's inverse mass is larger, of what ``masses`` says.
        """
        if not parts:
            return self.velocities[place].stream
        unit = parts[0].factor
        scaled = [part._replace(factor=part.factor / unit) for part in parts]
        if share is None:
            total = self.total(scaled)
        elif masses == "strains":
            pulls = self._divided(scaled, 1, -1, MOST)
            assert pulls is not None
            pull = self.total(pulls)
            moved = self.varied(pull, StreamRead(share), pull)
            total = StreamRead(self.add("sum", [StreamRead(moved, 1), StreamRead(moved, 0, -1.0)]))
        else:
            pull = self.total(scaled)
            total = StreamRead(self.varied(pull, StreamRead(share), pull))
        number = self.number(unit / mass)
        taps = [self.velocities[place], total]
        return self.add("kicked", taps, 0, field=place, number=number)

    def spread(self, lattice: NumericLattice, variation: Variation) -> tuple[int, ...]:
        """Let velocities spread through dashpots in a drift, by the series of an exponential.

        The streams of the new positions.
        """
        fields, rates = len(lattice.fields), variation.damped
        shares = [StreamRead(fields + place) for place in range(variation.mass_rows(fields))]
        cut = iter(range(fields + len(shares), self.fields))
        cuts = [
            StreamRead(next(cut)) if part is not None else None
            for part in variation.forces or (None,) * len(lattice.bonds)
        ]
        rows = fields + variation.rows(fields)
        walls = [StreamRead(rows - 1)] * fields if variation.walled else shares
        terms = [self.velocities[:fields]]
        for _ in range(TERMS):
            before = terms[-1] if len(terms) > 1 else self._of_cells(terms[0], walls)
            parts: list[list[_Part]] = [
                [_Part(-rate, read.stream, {0: 1.0})] if rate else []
                for rate, read in zip(rates, before, strict=True)
            ]
            for bond, dashpot, gone in zip(lattice.bonds, variation.dashpots, cuts, strict=True):
                if not dashpot:
                    continue
                pull = self.stretch(bond.stretch, 0.0, before)
                if gone is not None or pull.shift or pull.weight != 1.0:
                    pull = StreamRead(self.add("sum", [pull]))
                if gone is not None:
                    pull = StreamRead(self.varied(pull, gone, pull))
                for of, mass in enumerate(lattice.masses):
                    stencil = _merged(entry for entry in bond.action if entry.field == of)
                    if stencil:
                        parts[of].append(_Part(dashpot / mass, pull.stream, stencil))
            sums = [StreamRead(self.add("sum", [self.total(part)])) for part in parts]
            terms.append(self._of_cells(sums, shares))
        for place in range(fields):
            moved, turned = self.positions[place], self.velocities[place]
            for power, term in enumerate(terms):
                moved = self._spread(moved, term[place], power)
                turned = self._spread(turned, term[place], TERMS + power) if power else turned
            self.positions[place], self.velocities[place] = moved, turned
        return tuple(read.stream for read in self.positions[:fields])

    def _spread(self, total: StreamRead, term: StreamRead, weight: int) -> StreamRead:
        """The sum with another term of a series."""
        return StreamRead(self.add("spread", [total, term], 0, number=weight))

    def _of_cells(
        self, reads: Sequence[StreamRead], shares: Sequence[StreamRead]
    ) -> list[StreamRead]:
        """The values where there is a mass; 0 in walls."""
        if not shares:
            return list(reads)
        pairs = zip(reads, shares, strict=True)
        return [StreamRead(self.varied(read, share, read)) for read, share in pairs]

    def total(self, parts: Sequence[_Part]) -> StreamRead:
        """The sum of the parts, with as few instructions as common divisors of stencils give."""
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
        found = []
        for part in parts:
            quotient = _quotient(part.stencil, step, sign, most)
            if quotient is None:
                return None
            found.append(part._replace(stencil=quotient))
        return found

    def _terms(self, part: _Part, alone: bool) -> list[StreamRead]:
        """The part's taps; a factor that is not 1 is applied to their sum."""
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

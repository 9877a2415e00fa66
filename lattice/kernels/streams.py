"""What one stage computes for a chain of cells, as streams: written from the lattice's data alone.

A stage drifts every field and kicks every velocity. It goes up the cells once. At the front all
fields are drifted; a stretch is formed as soon as its furthest field has drifted, a force with it,
a sum of forces as soon as its last force is there. Each of these is a *stream*, one value a cell,
and its *lag* is the number of cells by which it stays behind the front. What has to be carried
follows: a stream is kept as long as one that is further behind needs it.

What depends on the lattice's constants alone goes into ``numbers``, which the machine code takes as
an argument: lattices that differ in constants share it. Terms that are absent, factors that are 1
and offsets that are 0 have no place in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, NamedTuple

if TYPE_CHECKING:
    from longwave.lattice.disordered_lattice import MassKind, Variation
    from longwave.lattice.force_program import ForceProgram
    from longwave.lattice.numeric_lattice import Entry, NumericLattice

Kind = Literal["position", "velocity", "sum", "force", "varied", "kicked"]
Polynomial = Mapping[int, float]
"""A stencil: weights by shift."""

MONIC = 1e100
"""A force is taken in units of its highest constant where the others are at most so many times as
large: the quotients then overflow for no stretch that a run may meet."""

MOST = 10**9
"""Beyond all shifts."""


class Law(NamedTuple):
    """A force's arithmetic. Integers are places in the numbers.

    A polynomial's ``factors`` are those of the powers below the highest, from above, None where one
    is absent; ``leading`` is that of the highest power, None where the force is taken in its unit.
    A ``program`` has words for a stack, with a place for "number" and the exponent for "power".
    """

    factors: tuple[int | None, ...] = ()
    leading: int | None = None
    program: tuple[tuple[str, float], ...] = ()


class Tap(NamedTuple):
    """``weight`` times a stream's value at the cell at offset ``shift``.

    If ``number`` is given, the factor is the one that stands there.
    """

    stream: int
    shift: int = 0
    weight: float = 1.0
    number: int | None = None


class Stream(NamedTuple):
    """One value a cell: what it is made of, and how far it stays behind the front.

    ``number`` is the place of a sum's offset, or of the factor with which a sum kicks ``field``.
    ``lowest`` is the furthest cell below its own of which it feels a position.
    """

    kind: Kind
    taps: tuple[Tap, ...]
    lag: int
    lowest: int
    field: int = 0
    number: int | None = None
    law: Law = Law()


class Flow(NamedTuple):
    """The streams of a stage in the order in which they are formed; hashable.

    The positions come first, then the velocities; ``kicked`` are the streams of the new velocities.
    """

    fields: int
    streams: tuple[Stream, ...]
    kicked: tuple[int, ...]

    @property
    def skew(self) -> int:
        """Cells by which one stage stays behind the stage before: it needs all its values."""
        return max(self.streams[place].lag for place in self.kicked)

    @property
    def below(self) -> int:
        """Cells at the lower end that a stage leaves untrue."""
        return max(0, *(-self.streams[place].lowest for place in self.kicked))

    def depths(self, followed: bool) -> list[int]:
        """How many earlier values of each stream are kept; ``followed`` if a stage goes behind."""
        kept = [0] * len(self.streams)
        for stream in self.streams:
            for tap in stream.taps:
                other = self.streams[tap.stream].lag
                kept[tap.stream] = max(kept[tap.stream], stream.lag - tap.shift - other)
        for place in (*range(self.fields), *self.kicked) if followed else ():
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
        total = self.fields
        for stream in self.streams:
            if stream.kind == "sum":
                scaled = any(tap.weight != 1.0 or tap.number is not None for tap in stream.taps[:1])
                total += max(len(stream.taps) - 1, 0) + scaled + (stream.number is not None)
            elif stream.kind == "force":
                total += _operations(stream.law)
            elif stream.kind in ("varied", "kicked"):
                total += 1
        return total


def _operations(law: Law) -> int:
    if law.program:
        return sum(word not in ("x", "number") for word, _ in law.program)
    if not law.factors:
        return int(law.leading is not None)
    first = law.factors[0] is not None or law.leading is not None
    return first + len(law.factors)


@lru_cache(maxsize=256)
def flow_of(lattice: NumericLattice) -> tuple[Flow, tuple[float, ...]]:
    """The streams of a stage of that chain, and the numbers that they take.

    Raises ValueError for a lattice of more than one dimension.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> flow, numbers = flow_of(numeric_lattice(LATTICES["beta_fput"], {"K2": 4, "K4": 1}))
    >>> flow.operations, flow.skew, numbers
    (6, 1, (4.0, 1.0))
    """
    flow, numbers, _ = varied_flow(lattice, None)
    return flow, numbers


class VariedFlow(NamedTuple):
    """A stage of a chain whose masses or springs differ from cell to cell.

    What differs stands in fields of its own behind the lattice's, which rest; each holds shares
    times its unit.
    """

    flow: Flow
    numbers: tuple[float, ...]
    units: tuple[float, ...]


@lru_cache(maxsize=256)
def varied_flow(lattice: NumericLattice, variation: Variation | None) -> VariedFlow:
    """`flow_of` with what differs from cell to cell, if anything does."""
    if lattice.dimension != 1:
        raise ValueError(
            f"lattice must be a chain, got {lattice.name} in {lattice.dimension} dimensions "
            "(rows of cells go up one axis)"
        )
    fields = len(lattice.fields)
    builder = _Builder(fields + (0 if variation is None else variation.rows(fields)))
    acting: list[list[_Part]] = [[] for _ in lattice.fields]
    units: list[float] = []
    for place, bond in enumerate(lattice.bonds):
        law, unit = law_of(bond.force, builder.number)
        if law is None:
            continue
        stretch = builder.stretch(bond.stretch, bond.offset)
        force = builder.force(stretch, law)
        part = None if variation is None or not variation.forces else variation.forces[place]
        if part is not None:
            share, own = law_of(part, builder.number)
            assert share is not None
            weight, units = Tap(fields + len(units)), [*units, own / unit]
            force = builder.varied(Tap(force), weight, Tap(builder.force(stretch, share)))
        for of, parts in enumerate(acting):
            stencil = _merged(entry for entry in bond.action if entry.field == of)
            if stencil:
                parts.append(_part(unit, force, stencil))
    masses = variation.masses if variation is not None else None
    kicked = [
        builder.kicked(place, parts, mass, None if masses is None else fields + place, masses)
        for place, (parts, mass) in enumerate(zip(acting, lattice.masses, strict=True))
    ]
    kicked += range(builder.fields + fields, 2 * builder.fields)
    flow = Flow(builder.fields, tuple(builder.streams), tuple(kicked))
    units += [1.0] * (builder.fields - fields - len(units))
    return VariedFlow(flow, tuple(builder.numbers), tuple(units))


class _Part(NamedTuple):
    """``factor`` times the stencil's sum over a stream."""

    factor: float
    stream: int
    stencil: Polynomial


def _merged(entries: object) -> dict[int, float]:
    """The weights by shift, those that cancel left out."""
    found: dict[int, float] = {}
    for entry in entries:  # type: ignore[attr-defined]
        found[entry.shift[0]] = found.get(entry.shift[0], 0.0) + entry.weight
    return {shift: found[shift] for shift in sorted(found, reverse=True) if found[shift] != 0.0}


def _part(unit: float, stream: int, stencil: dict[int, float]) -> _Part:
    """The part with whole weights without a common divisor, the uppermost positive, if it can."""
    first = next(iter(stencil.values()))
    common = abs(first)
    if all(weight == round(weight) for weight in stencil.values()):
        common = float(math.gcd(*(round(weight) for weight in stencil.values())))
    common = math.copysign(common, first)
    return _Part(unit * common, stream, {shift: w / common for shift, w in stencil.items()})


def _quotient(stencil: Polynomial, step: int, sign: int) -> dict[int, float] | None:
    """The stencil divided by ``value[n + step] + sign value[n]``; None if that leaves a rest."""
    left = dict(stencil)
    found: dict[int, float] = {}
    lowest = min(stencil)
    while left:
        top = max(left)
        if top - step < lowest:
            return None
        weight = found[top - step] = left.pop(top)
        rest = left.pop(top - step, 0.0) - sign * weight
        if rest != 0.0:
            left[top - step] = rest
    return found


def _work(parts: Sequence[_Part]) -> int:
    return sum(len(part.stencil) for part in parts) - 1


def law_of(force: ForceProgram, number: Callable[[float], int]) -> tuple[Law | None, float]:
    """A force's arithmetic and its unit, ``number`` giving places; None if there is no force."""
    if force.instructions:
        program = tuple(
            (word, float(number(value)) if word == "number" else value)
            for word, value in force.instructions
        )
        return Law(program=program), 1.0
    highest = max((i for i, value in enumerate(force.coefficients) if value), default=None)
    if highest is None:
        return None, 1.0
    unit = force.coefficients[highest]
    lower = force.coefficients[:highest][::-1]
    monic = max(map(abs, lower), default=0.0) <= MONIC * abs(unit)
    leading, unit = (None, unit) if monic else (number(unit), 1.0)
    factors = tuple(number(value / unit) if value else None for value in lower)
    return Law(factors, leading), unit


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

    def number(self, value: float) -> int:
        """The place of that number."""
        if value not in self.numbers:
            self.numbers.append(value)
        return self.numbers.index(value)

    def add(self, kind: Kind, taps: Sequence[Tap], least: int = -MOST, **more: object) -> int:
        """The place of a stream of these taps; one that is there already is not formed twice."""
        lags = [tap.shift + self.streams[tap.stream].lag for tap in taps]
        lag = max(max(lags, default=0), least)
        lowest = min((tap.shift + self.streams[tap.stream].lowest for tap in taps), default=0)
        made = Stream(kind, tuple(taps), lag, lowest, **more)  # type: ignore[arg-type]
        if made not in self.streams:
            self.streams.append(made)
        return self.streams.index(made)

    def stretch(self, entries: Sequence[Entry], offset: float) -> Tap:
        """What a bond of a cell is stretched by."""
        taps = []
        for place in range(self.fields):
            stencil = _merged(entry for entry in entries if entry.field == place)
            taps += [Tap(place, shift, weight) for shift, weight in stencil.items()]
        taps.sort(key=lambda tap: tap.weight != 1.0)
        if len(taps) == 1 and taps[0].weight == 1.0 and offset == 0.0:
            return taps[0]
        number = self.number(offset) if offset else None
        return Tap(self.add("sum", taps, number=number))

    def force(self, stretch: Tap, law: Law) -> int:
        """The force of such a bond."""
        return self.add("force", [stretch], law=law)

    def varied(self, whole: Tap, share: Tap, part: Tap) -> int:
        """``whole + share part``, cell by cell."""
        return self.add("varied", [whole, share, part])

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
            return self.fields + place
        unit = parts[0].factor
        scaled = [part._replace(factor=part.factor / unit) for part in parts]
        if share is None:
            total = self.total(scaled)
        elif masses == "strains":
            pulls = self._divided(scaled, 1, -1)
            assert pulls is not None
            pull = self.total(pulls)
            moved = self.varied(pull, Tap(share), pull)
            total = Tap(self.add("sum", [Tap(moved, 1), Tap(moved, 0, -1.0)]))
        else:
            pull = self.total(scaled)
            total = Tap(self.varied(pull, Tap(share), pull))
        velocity = Tap(self.fields + place)
        number = self.number(unit / mass)
        return self.add("kicked", [velocity, total], 0, field=place, number=number)

    def total(self, parts: Sequence[_Part]) -> Tap:
        """The sum of the parts, with as few instructions as common divisors of stencils give."""
        if len(parts) == 1 and len(parts[0].stencil) == 1 and parts[0].factor == 1.0:
            [(shift, weight)] = parts[0].stencil.items()
            if weight == 1.0:
                return Tap(parts[0].stream, shift)
        widest = max(max(part.stencil) - min(part.stencil) for part in parts)
        for step in range(1, widest + 1):
            for sign in (-1, 1):
                divided = self._divided(parts, step, sign)
                if divided is not None and _work(divided) < _work(parts):
                    inner = self.total(divided)
                    upper = inner._replace(shift=inner.shift + step)
                    lower = inner._replace(weight=sign * inner.weight)
                    return Tap(self.add("sum", [upper, lower]))
        taps = [tap for part in parts for tap in self._terms(part, alone=len(parts) == 1)]
        return Tap(self.add("sum", taps))

    def _divided(self, parts: Sequence[_Part], step: int, sign: int) -> list[_Part] | None:
        found = []
        for part in parts:
            quotient = _quotient(part.stencil, step, sign)
            if quotient is None:
                return None
            found.append(part._replace(stencil=quotient))
        return found

    def _terms(self, part: _Part, alone: bool) -> list[Tap]:
        """The part's taps; a factor that is not 1 is applied to their sum."""
        factor, stream, stencil = part
        if abs(factor) == 1.0 and alone:
            return [Tap(stream, shift, factor * weight) for shift, weight in stencil.items()]
        if len(stencil) == 1:
            [(shift, weight)] = stencil.items()
            inner = Tap(stream, shift, weight)
        else:
            inner = self.total([part._replace(factor=1.0)])
        factor *= inner.weight
        if abs(factor) == 1.0:
            return [inner._replace(weight=factor)]
        return [inner._replace(weight=1.0, number=self.number(factor))]

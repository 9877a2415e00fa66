"""A chain on a bench, as described by a scene's tables: ends, start, forces and observables.

`KEYS` lists the keys of each table. [start] may instead have the column ``site`` and columns of
fields and velocities, such as ``u`` and ``du``. In any table ``file = "drive.csv"`` stands for the
columns of that file; the scene stores the numbers. Losses are those of any scene (`losses.py`). If
a chain is driven or damped, its energy is recorded with the work and the heat since the start.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from longwave.lattice.outer_forces import SiteForce
from longwave.scenes.description import scene_checks as check
from longwave.scenes.description.csv_table import number_list, with_columns
from longwave.scenes.description.scene_checks import TableKey, read_table, table
from longwave.scenes.description.stated_tables import StatedTables
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.scenes.description.losses import Losses

FORCE_TABLES = {"force": SiteForce}
"""Class of the force for each table of forces on single cells."""

BENCH_TABLES = ("chain", "start", *FORCE_TABLES, "noise", "defects", "observables")

MOST_READINGS = 10**6
"""Maximum number of times at which sensors are read."""

SENSOR_QUANTITIES = ("displacement", "velocity", "strain", "force")
"""Quantities that sensors read, of a cell or of the bond from it to the next cell."""

MEAN_SUFFIXES = ("_error", "_spread")
"""Suffixes of two variables for each mean: half its confidence interval, and the spread of runs."""

END_DRIVES = ("displacement", "velocity", "force")
"""Quantities that may drive an end, as functions of time."""

Drive: TypeAlias = "str | Mapping[str, Any]"
"""Formula in t, or table of times and values."""

FACTOR_EXAMPLE = "{ 12 = 3 }"
FROM_0 = partial(check.whole, least=0)


def _drive(label: str, given: Drive) -> Drive:
    """Return ``given``; ValueError, which names ``label``, unless it is a function of time."""
    from longwave.scenes.description.time_functions import time_function

    time_function(label, given)
    return given


def _truth(name: str, given: object) -> bool:
    if not isinstance(given, bool):
        raise ValueError(
            f"{name} must be true or false, got {shown(given)} (such as {name.split()[0]} = true)"
        )
    return given


def _numbers(name: str, given: object, of: str, least: int = 0, few: int = 0) -> tuple[int, ...]:
    """Check and return at least ``few`` whole numbers >= ``least``; messages call them ``of``."""
    if not isinstance(given, list | tuple) or len(given) < few:
        raise ValueError(f"{name} must be a list of {of}, got {shown(given)} (such as [1, 2])")
    return tuple(check.whole(name, number, least) for number in given)


def _end(name: str, given: object) -> str | Mapping[str, Drive]:
    """Return the condition at an end: "fixed", "free" or a drive {quantity: function of time}."""
    if isinstance(given, Mapping) and len(given) == 1 and set(given) <= set(END_DRIVES):
        return {kind: _drive(f"{kind} of {name.split()[0]}", given[kind]) for kind in given}
    if isinstance(given, str) and given in ("fixed", "free"):
        return given
    raise ValueError(
        f'{name} must be "fixed", "free" or one of {", ".join(END_DRIVES)} in time, got '
        f'{shown(given)} (such as {{ displacement = "0.1*sin(t)" }})'
    )


def _factors(name: str, given: object) -> dict[int, Any]:
    """Return factors of masses or springs, by the number of the cell or bond.

    A factor is a number; for masses also a table by field, for springs also a list by bond.
    """
    if not isinstance(given, Mapping):
        raise ValueError(
            f"{name} must be a table by cells, got {shown(given)} (such as {FACTOR_EXAMPLE})"
        )
    kind = name.split()[0]
    factors: dict[int, Any] = {}
    for cell, value in given.items():
        if not re.fullmatch(r"-?\d{1,9}", str(cell)):
            raise ValueError(
                f"{name} must have cell numbers as keys, got {check.plain(cell)} (such as "
                f"{FACTOR_EXAMPLE})"
            )
        label = f"{kind} of {cell} in [defects]"
        if isinstance(value, Mapping) and kind == "mass":
            factors[int(cell)] = {str(name): check.finite(label, value[name]) for name in value}
        elif isinstance(value, list | tuple) and kind == "spring":
            factors[int(cell)] = tuple(check.finite(label, factor) for factor in value)
        else:
            factors[int(cell)] = check.finite(label, value)
    return factors


@dataclass(frozen=True)
class Impact:
    """Velocity added to one cell at the start."""

    site: int
    velocity: float
    field: str = ""


@dataclass(frozen=True)
class Mode:
    """Mode of a chain at the start: ``u_n = amplitude sin(pi number (n + 1) / (sites + 1))``."""

    number: int
    amplitude: float


@dataclass(frozen=True)
class Cells:
    """Initial ``values`` of single cells, by field ("u") or velocity of a field ("du")."""

    sites: tuple[int, ...]
    values: Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class Push:
    """Force on one cell over time; ``kind``, a key of `FORCE_TABLES`, names its table."""

    site: int
    value: Drive
    field: str = ""
    kind: str = "force"


@dataclass(frozen=True)
class Noise:
    """Heat bath on cells with losses: temperature (an energy) and the seed of its noise."""

    temperature: float
    seed: int = 0


def _read(name: str, given: object, where: str = "") -> dict[str, Any]:
    return read_table(name, KEYS[name], given, where)


def _rest(name: str, given: object) -> tuple[()]:
    if given is not True:
        raise ValueError(
            f"{name} must be true, got {shown(given)} (or state mode or impact instead)"
        )
    return ()


def _parts(label: str, given: object, record: type) -> list[Any]:
    """Return a list of records, read from one table or from a list of tables."""
    name = label.split()[0]
    return [record(**_read(name, part, f" of {name}")) for part in _as_list(given)]


def _as_list(given: object) -> Sequence[Any]:
    return given if isinstance(given, list | tuple) else [given]


def _start(given: object) -> Iterator[Impact | Mode | Cells]:
    """Yield the parts of the table [start], whose sum is the initial state."""
    for entry in _as_list(given) or [None]:
        if not entry and not isinstance(entry, str):
            raise ValueError(
                "start must be stated, got nothing (such as rest = true below a line [start])"
            )
        if isinstance(entry, Mapping) and "site" in entry:
            yield _cells(entry)
        else:
            for parts in _read("start", entry).values():
                yield from parts


def _cells(given: Mapping[str, Any]) -> Cells:
    """Return the initial values of single cells from columns, one of which is ``site``."""
    columns = {str(name): number_list(f"{name} in [start]", given[name]) for name in given}
    numbers = columns.pop("site")
    sites = tuple(
        check.whole("site in [start]", int(n) if n.is_integer() else n, 0) for n in numbers.tolist()
    )
    if len({*sites}) < len(sites) or any(len(column) != len(sites) for column in columns.values()):
        raise ValueError(
            f"columns in [start] must be equally long and have each cell once, got {len(sites)} "
            f"rows with {len({*sites})} cells (leave one of two equal cells out)"
        )
    return Cells(sites, {name: tuple(column.tolist()) for name, column in columns.items()})


def _pushes(kind: str, given: object) -> Iterator[Push]:
    if not isinstance(given, list | tuple):
        raise ValueError(f"{kind} must be [[{kind}]] tables, got {shown(given)} (write [[{kind}]])")
    for entry in given:
        fields = _read(kind, entry, f" in [[{kind}]]")
        times, value = fields.pop("t"), fields.pop("value")
        drive = value if times is None else {"t": times, "value": value}
        yield Push(value=_drive(f"value in [[{kind}]]", drive), kind=kind, **fields)


FROM_2 = partial(check.whole, least=2, most=1e7)
MODES = partial(_numbers, of="numbers of modes", least=1)
CELLS = partial(_numbers, of="numbers of cells")
SENSOR_CELLS = partial(_numbers, of="cells", few=1)
QUANTITIES = partial(check.names, known=SENSOR_QUANTITIES)
AT_END = '`"fixed"`, `"free"`, or one of `displacement`, `velocity`, `force` as a formula in t'
FIELD = TableKey(lambda _, given: str(given), "field of the cell, the first unless stated", "")
EVERY = TableKey(check.positive, "time units between readings", math.inf, "every")
ON_CELLS = {
    "site": TableKey(FROM_0, "the cell"),
    "value": TableKey(lambda _, given: given, "a formula in t, or a list at the times `t`"),
    "field": FIELD,
    "t": TableKey(lambda _, given: given, "times of the values in a list", None),
}

KEYS: dict[str, Mapping[str, TableKey]] = {
    "chain": {
        "sites": TableKey(FROM_2, "number of cells", remedy="such as sites = 24"),
        "left": TableKey(_end, AT_END, "fixed"),
        "right": TableKey(_end, AT_END, "fixed"),
    },
    "start": {
        "rest": TableKey(_rest, "`true`", ()),
        "mode": TableKey(
            partial(_parts, record=Mode), "a mode of a chain between fixed walls, or a list", ()
        ),
        "impact": TableKey(partial(_parts, record=Impact), "a velocity of a cell, or a list", ()),
    },
    "mode": {
        "number": TableKey(check.whole, "number of the mode, from 1", 1),
        "amplitude": TableKey(check.finite, "factor of its sine", None, "amplitude"),
    },
    "impact": {
        "site": TableKey(FROM_0, "the cell", 0),
        "velocity": TableKey(check.finite, "velocity of this cell", None),
        "field": FIELD,
    },
    **dict.fromkeys(FORCE_TABLES, ON_CELLS),
    "defects": {
        "mass": TableKey(_factors, "factors of masses, or tables by field", {}, field="masses"),
        "spring": TableKey(_factors, "factors of bonds' forces, or lists", {}, field="springs"),
    },
    "noise": {
        "temperature": TableKey(
            check.positive, "temperature of the bath, in units of energy", None
        ),
        "seed": TableKey(FROM_0, "seed of its noise", 0),
    },
    "observables": {
        "sensors": TableKey(lambda _, given: given, "a table of cells and quantities", {}),
        "energy": TableKey(_truth, "`true`: the energy, work and heat", False),
        "mode_energies": TableKey(MODES, "numbers of modes", (), "mode_energies", "modes"),
        "flux": TableKey(
            CELLS, "the power through the bonds from these cells to the next", (), "flux"
        ),
        "state": TableKey(
            _truth, "`true`: all cells; the default if nothing else is observed", False
        ),
        "every": EVERY,
    },
    "sensors": {
        "sites": TableKey(SENSOR_CELLS, "the cells", None, field="sensors"),
        "of": TableKey(
            QUANTITIES, "quantities read there", SENSOR_QUANTITIES[:1], "of in sensors", "sensed"
        ),
        "every": EVERY,
    },
}
"""Allowed keys of each table of a bench, by the table's name."""


@dataclass(frozen=True)
class Bench:
    """Contents of a bench's tables, checked as far as possible without the lattice.

    >>> bench = Bench.of_tables({"chain": {"sites": 8}, "start": {"rest": True}})
    >>> bench.sites, bench.ends
    (8, ('fixed', 'fixed'))
    >>> Bench.of_tables({"chain": {"sites": 8, "ends": "free"}})
    Traceback (most recent call last):
    ...
    ValueError: keys in [chain] must be known ones, got ends (one of sites, left, right)
    """

    sites: int
    ends: tuple[str | Mapping[str, Drive], ...]
    start: tuple[Impact | Mode | Cells, ...] = ()
    forces: tuple[Push, ...] = ()
    masses: Mapping[int, float | Mapping[str, float]] = field(default_factory=dict)
    springs: Mapping[int, float | tuple[float, ...]] = field(default_factory=dict)
    sensors: tuple[int, ...] = ()
    sensed: tuple[str, ...] = ()
    energy: bool = False
    modes: tuple[int, ...] = ()
    flux: tuple[int, ...] = ()
    state: bool = False
    every: float = math.inf
    noise: Noise | None = None
    stated: StatedTables = field(default=StatedTables({}), repr=False)

    def __hash__(self) -> int:
        return hash(self.stated)

    def __post_init__(self) -> None:
        if not (
            (self.sensors and self.sensed) or self.energy or self.modes or self.flux or self.state
        ):
            raise ValueError(
                "observables must name at least one quantity, got nothing (state = true)"
            )
        mentioned = [(f"of [[{push.kind}]]", [push.site]) for push in self.forces]
        for part in self.start:
            mentioned += [("of impact", [part.site])] if isinstance(part, Impact) else []
            mentioned += [("in [start]", [*part.sites])] if isinstance(part, Cells) else []
        mentioned += [("of sensors", [*self.sensors]), ("of flux", [*self.flux])]
        for where, sites in mentioned:
            if max(sites, default=0) >= self.sites:
                raise ValueError(
                    f"site {where} must be 0 to {self.sites - 1}, got {max(sites)} (there are "
                    f"{self.sites} cells)"
                )
        if self.flux and self.noise is not None:
            raise ValueError(
                f"flux must be left out with [noise], got {list(self.flux)} (a bath acts "
                "on all cells)"
            )

    @classmethod
    def of_tables(cls, tables: Mapping[str, Any]) -> Bench:
        """Return the bench that a scene's tables describe; ValueError for invalid tables."""
        stated = StatedTables(tables, "tables of a bench")
        given = stated.tables  # as lists, without NumPy arrays
        chain = _read("chain", given.get("chain", {}))
        requested = table(given, "observables")
        sensor_table = table(requested, "sensors")
        if "every" in requested and "every" in sensor_table:
            raise ValueError("every must be in [observables] or in sensors, got both (leave one)")
        if not requested.keys() - {"every"}:
            requested = {"state": True, **requested}
        observables = _read("observables", requested)
        has_sensors = bool(observables.pop("sensors"))
        sensors = _read("sensors", sensor_table, " of sensors") if has_sensors else {}
        every = min(observables.pop("every"), sensors.pop("every", math.inf))
        ends = {0: chain["left"], chain["sites"] - 1: chain["right"]}
        pushes = [push for kind in FORCE_TABLES for push in _pushes(kind, given.get(kind, []))]
        for site, end in ends.items():
            if isinstance(end, Mapping) and "force" in end:
                ends[site] = "free"
                pushes.append(Push(site, end["force"]))
        return cls(
            chain["sites"],
            tuple(ends.values()),
            tuple(_start(given.get("start"))),
            tuple(pushes),
            every=every,
            noise=Noise(**_read("noise", given["noise"])) if "noise" in given else None,
            stated=stated,
            **_read("defects", given.get("defects", {})),
            **observables,
            **sensors,
        )


def check_bath(bench: Bench, losses: Losses | None) -> None:
    """Raise ValueError for a bath without losses of cells, or with losses of bonds."""
    stated = losses.table if losses else {}
    for kind, is_needed in (("site", True), ("bond", False)) if bench.noise else ():
        rates = stated.get(kind)
        if bool(any(rates.values()) if isinstance(rates, Mapping) else rates) is not is_needed:
            raise ValueError(
                f"{kind} in [losses] must be {'given' if is_needed else 'left out'} with [noise], "
                f"got {shown(rates)} (the bath is at the cells that lose energy to it)"
            )


def bench_of(given: Mapping[str, Any]) -> Bench | None:
    """Return the bench among a scene's keywords, or None; ValueError for an invalid one.

    The keyword ``bench`` is a `Bench` or the JSON of its tables. A keyword with the name of a
    table, such as ``chain``, replaces that table of the bench.
    """
    bench = given.get("bench")
    stated = dict(bench.stated.tables if isinstance(bench, Bench) else json.loads(bench or "{}"))
    own = {key: given[key] for key in BENCH_TABLES if given.get(key) is not None}
    if not isinstance(own.get("observables", {}), Mapping):
        own.pop("observables")
    stated |= own
    if not stated:
        return None
    if isinstance(bench, Bench) and not own:
        return bench
    if not {"chain", "start"} & stated.keys():
        [first] = list(stated)[:1]
        raise ValueError(
            f"{first} must be with a chain on a bench, got no [chain] (state its sites, its ends "
            "and how it starts)"
        )
    return Bench.of_tables(with_columns(stated, Path()))

"""A chain on a bench, as a scene's tables say it: ends, a start, forces, what is watched.

Its tables::

    [chain]        sites, left, right: "fixed" (which they are unless said), "free", a wall that
                   moves, { displacement = "0.05*sin(1.3*t)" } or { velocity = ... } (from 0 at the
                   start), or a free end whose cell is pushed to the right, { force = ... }
    [start]        rest = true, mode = { number, amplitude } or impact = { site, velocity }, or a
                   list of these; or lists, site and those of fields and their velocities, u, du
    [[force]]      site, value (a formula in t, or a list at the times t), field (the first unless
                   said)
    [defects]      mass = { 12 = 3 }: factors of single cells' masses, or tables of such by field;
                   spring = { 20 = 2 }: those of single bonds' forces, dashpots included, from a
                   cell to the next (-1: from the left wall), or of several bonds lists
    [noise]        temperature, seed (0 unless said): a bath beside the losses of cells
    [observables]  sensors = { sites, of }, energy = true, mode_energies = [1, 2], flux = [5, 15],
                   state = true, every

A wall's formula in t may be a table of measured values, ``{ t = [...], value = [...] }``, too. In
any table ``file = "drive.csv"`` stands for the columns of that file, by their names: a scene holds
the numbers.

Losses are those of any scene (`losses.py`). Cells and sensors count from 0, modes from 1. ``of``
are some of `SENSED`. With the energy of a chain that is driven or damped come work and heat since
the start; ``flux`` is the power through the bonds from each of these cells to the next. All that is
observed is read at the scene's times and, if that is given, after ``every`` so many time units.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from longwave.lattice.outer_forces import SiteForce
from longwave.scenes.description import scene_checks as check
from longwave.scenes.description.csv_table import number_list, with_columns
from longwave.scenes.description.stated_tables import StatedTables
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

if TYPE_CHECKING:
    from longwave.scenes.description.losses import Losses

ACTING = {"force": SiteForce}
"""Tables of what acts on single cells, and of what kind it is; each has a site, a value and a
field."""

BENCH_TABLES = ("chain", "start", *ACTING, "noise", "defects", "observables")

MOST_READINGS = 10**6
"""Times at which sensors are read."""

KEYS = {
    "chain": ("sites", "left", "right"),
    "start": ("rest", "mode", "impact"),
    "mode": ("number", "amplitude"),
    "impact": ("site", "velocity", "field"),
    **dict.fromkeys(ACTING, ("site", "value", "field", "t")),
    "defects": ("mass", "spring"),
    "noise": ("temperature", "seed"),
    "observables": ("sensors", "energy", "mode_energies", "flux", "state", "every"),
    "sensors": ("sites", "of", "every"),
}
"""What may stand in each table."""


SENSED = ("displacement", "velocity", "strain", "force")
"""What sensors read: of the cell, and of the bond from it to the next."""


OF_MEANS = ("_error", "_spread")
"""Endings of what belongs to a mean over runs: half its interval, the standard deviation."""

MOVES = ("displacement", "velocity", "force")
"""What may be given of an end that does not rest, in time."""

Drive: TypeAlias = "str | Mapping[str, Any]"
"""A formula in t, or a table of times and values."""


@dataclass(frozen=True)
class Impact:
    """Velocities of single cells at the start."""

    site: int
    velocity: float
    field: str = ""


@dataclass(frozen=True)
class Mode:
    """``u_n = amplitude sin(pi number (n + 1) / (sites + 1))``."""

    number: int
    amplitude: float


@dataclass(frozen=True)
class Cells:
    """What single cells do at the start: ``values`` by fields' names, of velocities as ``du``."""

    sites: tuple[int, ...]
    values: Mapping[str, tuple[float, ...]]


@dataclass(frozen=True)
class Push:
    """A force on a cell, of a kind in `ACTING`."""

    site: int
    value: Drive
    field: str = ""
    kind: str = "force"


@dataclass(frozen=True)
class Noise:
    """A bath of that temperature, in units of energy, with noise drawn from a seed."""

    temperature: float
    seed: int = 0


@dataclass(frozen=True)
class Bench:
    """What the tables say, checked as far as it can be without the lattice.

    >>> made = Bench.of_tables({"chain": {"sites": 8}, "start": {"rest": True}})
    >>> made.sites, made.ends
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
    sensed: tuple[str, ...] = ("displacement",)
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
            raise ValueError("observables must name what is watched, got nothing (state = true)")
        named = [(f"of [[{push.kind}]]", push.site) for push in self.forces]
        named += [("of impact", part.site) for part in self.start if isinstance(part, Impact)]
        cells = [part for part in self.start if isinstance(part, Cells)]
        named += [("in [start]", site) for part in cells for site in part.sites]
        named += [("of sensors", site) for site in self.sensors]
        for where, site in [*named, *(("of flux", site) for site in self.flux)]:
            if site >= self.sites:
                raise ValueError(
                    f"site {where} must be 0 to {self.sites - 1}, got {site} (there are "
                    f"{self.sites} cells)"
                )
        if self.flux and self.noise is not None:
            raise ValueError(
                f"flux must be left out with [noise], got {list(self.flux)} (a bath acts "
                "on all cells)"
            )

    @classmethod
    def of_tables(cls, tables: Mapping[str, Any]) -> Bench:
        """The bench that a scene's tables describe; ValueError in one line."""
        stated = StatedTables(tables, "tables of a bench")
        tables = stated.tables  # without arrays
        chain = _table(tables.get("chain", {}), "chain")
        if "sites" not in chain:
            raise ValueError("sites in [chain] must be stated, got nothing (such as sites = 24)")
        watched = _table(tables.get("observables", {}), "observables")
        sensors = _table(watched.get("sensors", {}), "sensors")
        sites = check.whole("sites in [chain]", chain["sites"], 2, 1e7)
        ends, pushes = _ends(chain, sites)
        defects = _table(tables.get("defects", {}), "defects")
        if "every" in watched and "every" in sensors:
            raise ValueError("every must be in [observables] or in sensors, got both (leave one)")
        return cls(
            sites,
            ends,
            tuple(_start(tables.get("start"))),
            (*(push for kind in ACTING for push in _pushes(kind, tables)), *pushes),
            _factors("mass", defects),
            _factors("spring", defects),
            *_sensors(sensors),
            _truth("energy", watched.get("energy", False)),
            _numbers("mode_energies", watched, "modes", 1),
            _numbers("flux", watched, "cells", 0),
            _truth("state", watched.get("state", not set(watched) - {"every"})),
            _every(watched.get("every", sensors.get("every"))),
            _noise(tables["noise"]) if "noise" in tables else None,
            stated,
        )


def check_bath(bench: Bench, losses: Losses | None) -> None:
    """Raise ValueError for a bath without losses of cells, or with losses of bonds."""
    table = losses.table if losses else {}
    for key, wanted in (("site", True), ("bond", False)) if bench.noise else ():
        rates = table.get(key)
        if bool(any(rates.values()) if isinstance(rates, Mapping) else rates) is not wanted:
            raise ValueError(
                f"{key} in [losses] must be {'given' if wanted else 'left out'} with [noise], got "
                f"{shown(rates)} (the bath is at the cells that lose energy to it)"
            )


def _table(given: object, name: str) -> Mapping[str, Any]:
    """A table with known keys."""
    if not isinstance(given, Mapping):
        raise ValueError(f"{name} must be a table, got {shown(given)} (write [{name}])")
    for key in given:
        if key not in KEYS[name]:
            raise ValueError(
                f"keys in [{name}] must be known ones, got {check.plain(key)} "
                f"({one_of(key, KEYS[name])})"
            )
    return given


def _truth(name: str, given: object) -> bool:
    if not isinstance(given, bool):
        raise ValueError(f"{name} in [observables] must be true or false, got {shown(given)}")
    return given


def _numbers(name: str, watched: Mapping[str, Any], of: str, least: int) -> tuple[int, ...]:
    """A list of whole numbers, empty if it is not given."""
    given = watched.get(name, [])
    if not isinstance(given, list | tuple):
        raise ValueError(
            f"{name} must be a list of numbers of {of}, got {shown(given)} (such as [1, 2])"
        )
    return tuple(check.whole(name, number, least) for number in given)


def _ends(
    chain: Mapping[str, Any], sites: int
) -> tuple[tuple[str | Mapping[str, Drive], ...], list[Push]]:
    """What is at the ends, one that is pushed being free, and the forces there."""
    ends, pushes = [], []
    for side, site in (("left", 0), ("right", sites - 1)):
        given = chain.get(side, "fixed")
        if isinstance(given, Mapping) and len(given) == 1 and set(given) <= set(MOVES):
            [(kind, value)] = given.items()
            _check_drive(f"{kind} of {side}", value)
            pushes += [Push(site, value)] if kind == "force" else []
            ends.append("free" if kind == "force" else given)
        elif isinstance(given, str) and given in ("fixed", "free"):
            ends.append(given)
        else:
            raise ValueError(
                f'{side} in [chain] must be "fixed", "free" or one of {", ".join(MOVES)} in time, '
                f'got {shown(given)} (such as {{ displacement = "0.1*sin(t)" }})'
            )
    return tuple(ends), pushes


def _check_drive(label: str, given: object) -> None:
    """Refuse what is no function of time."""
    from longwave.scenes.description.time_functions import time_function

    time_function(label, given)


def _start(given: object) -> list[Impact | Mode | Cells]:
    """What the cells do at the start."""
    entries = given if isinstance(given, list | tuple) else [given]
    found: list[Impact | Mode | Cells] = []
    for entry in entries or [None]:
        if not entry and not isinstance(entry, str):
            raise ValueError(
                "start must be stated, got nothing (such as rest = true below a line [start])"
            )
        if isinstance(entry, Mapping) and "site" in entry:
            found.append(_cells(entry))
            continue
        for key, value in _table(entry, "start").items():
            if key == "rest":
                if value is not True:
                    raise ValueError(f"rest in [start] must be true, got {shown(value)}")
                continue
            for part in value if isinstance(value, list | tuple) else [value]:
                table = _table(part, key)
                if key == "mode":
                    number = check.whole("number of mode", table.get("number", 1))
                    found.append(Mode(number, check.finite("amplitude", table.get("amplitude"))))
                else:
                    site = check.whole("site of impact", table.get("site", 0), 0)
                    speed = check.finite("velocity of impact", table.get("velocity"))
                    found.append(Impact(site, speed, str(table.get("field", ""))))
    return found


def _cells(given: Mapping[str, Any]) -> Cells:
    """What lists by cell say."""
    columns = {str(name): number_list(f"{name} in [start]", given[name]) for name in given}
    numbers = columns.pop("site")
    sites = tuple(
        check.whole("site in [start]", int(n) if n.is_integer() else n, 0) for n in numbers.tolist()
    )
    if len({*sites}) < len(sites) or any(len(column) != len(sites) for column in columns.values()):
        raise ValueError(
            f"lists in [start] must have each cell once and a number of each, got {len(sites)} "
            f"rows with {len({*sites})} cells (leave out what is there twice)"
        )
    return Cells(sites, {name: tuple(column.tolist()) for name, column in columns.items()})


def _factors(name: str, defects: Mapping[str, Any]) -> dict[int, Any]:
    """Factors by the numbers of cells or bonds: numbers, by field of masses, in a list of bonds."""
    given = defects.get(name, {})
    found: dict[int, Any] = {}
    if not isinstance(given, Mapping):
        raise ValueError(
            f"{name} in [defects] must be a table by cells, got {shown(given)} (such as "
            "{ 12 = 3 })"
        )
    for key, value in given.items():
        if not re.fullmatch(r"-?\d{1,9}", str(key)):
            raise ValueError(
                f"{name} in [defects] must be by the numbers of cells, got {check.plain(key)} "
                "(such as { 12 = 3 })"
            )
        label = f"{name} of {key} in [defects]"
        if isinstance(value, Mapping) and name == "mass":
            found[int(key)] = {str(one): check.finite(label, value[one]) for one in value}
        elif isinstance(value, list | tuple) and name == "spring":
            found[int(key)] = tuple(check.finite(label, one) for one in value)
        else:
            found[int(key)] = check.finite(label, value)
    return found


def _pushes(kind: str, tables: Mapping[str, Any]) -> Iterator[Push]:
    given = tables.get(kind, [])
    if not isinstance(given, list | tuple):
        raise ValueError(f"{kind} must be [[{kind}]] tables, got {shown(given)} (write [[{kind}]])")
    for entry in given:
        table = _table(entry, kind)
        for key in ("site", "value"):
            if key not in table:
                raise ValueError(f"{key} in [[{kind}]] must be stated, got nothing")
        value = table["value"]
        if "t" in table:
            value = {"t": table["t"], "value": value}
        _check_drive(f"value in [[{kind}]]", value)
        site = check.whole(f"site in [[{kind}]]", table["site"], 0)
        yield Push(site, value, str(table.get("field", "")), kind)


def _noise(given: object) -> Noise:
    table = _table(given, "noise")
    temperature = check.finite("temperature in [noise]", table.get("temperature"))
    check.positive("temperature in [noise]", temperature)
    return Noise(temperature, check.whole("seed in [noise]", table.get("seed", 0), 0))


def _sensors(given: Mapping[str, Any]) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Where and what is read."""
    if not given:
        return (), ()
    sites, of = given.get("sites"), given.get("of", ["displacement"])
    if not isinstance(sites, list | tuple) or not sites:
        raise ValueError(
            f"sites of sensors must be a list of cells, got {shown(sites)} (such as [0, 7])"
        )
    found = tuple(check.whole("sites of sensors", site, 0) for site in sites)
    return found, check.names("of in sensors", of, SENSED)


def _every(given: object) -> float:
    """The time between readings, infinite if they are not asked for."""
    if given is None:
        return math.inf
    every = check.finite("every", given)
    check.positive("every", every)
    return every


def bench_of(given: Mapping[str, Any]) -> Bench | None:
    """Return the bench among a scene's keywords, None if there is none; ValueError in one line.

    ``bench`` is a record or the JSON of its tables; tables given beside it take their places.
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

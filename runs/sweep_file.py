"""Sweeps: one scene, and what varies of it; the files that say so.

    title = "error of the sech soliton over eps and its height"
    scene = "soliton_sech.toml"     # a shipped scene, a file beside this one, or a table [scene]

    [set]                           # fields that are the same in all cells
    tolerance = 1e-4

    [grid]                          # every value with every other: a dimension each
    eps = [0.05, 0.1]
    parameters.A = { from = 0.5, to = 2, count = 7 }

    [list]                          # columns of one length, which go together: the dimension `case`
    wave = ["rogue_cn", "rogue_dn"]
    lattice.K4 = [1, -1]            # or whole tables: constants = [{ K2 = 1 }, { K2 = 2 }]

    [random]                        # samples: the dimension `sample`
    count = 100
    seed = 1
    lattice.K3 = { from = -0.5, to = 0.5 }
    parameters.A = { choose = [0.5, 1, 2] }

A field has the name that it has in the scene's file, with its table. A range has ends, both taken,
and ``log = true`` spaces it evenly in the logarithm; between whole numbers, ``whole = true`` draws
whole ones. There may be a grid, a list and a random sample at once: each of one with each of the
others.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.resources import as_file, files
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from longwave.runs.run_pack import NUMBERS, TEXTS
from longwave.runs.sweep_scene import (
    base_document,
    changed_document,
    check_field,
    field_in_one_spelling,
    make_scene,
)
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import finite, refuse_unknown, table, text, whole
from longwave.scenes.description.scene_file import read_document
from longwave.support.html_tables import html_table
from longwave.support.known_names import one_of
from longwave.support.user_files import cut, shown

MOST_CELLS = 1_000_000

TOP = ("title", "scene", "set", "grid", "list", "random")
RANGE = ("from", "to", "count", "log")
DRAWN = ("from", "to", "log", "whole", "choose")

SHOWN = 120
"""Characters that a notebook shows of a dimension's values."""

CASE, SAMPLE = "case", "sample"
"""The dimensions of a list and of a random sample."""

TAKEN = (CASE, SAMPLE, "time", "site", "row", "quantity", "background", *TEXTS, *NUMBERS)
"""Names that runs, or cells, have for something else."""

FOLDER = files("longwave.runs.sweeps")

Values = tuple[Any, ...]


@dataclass(frozen=True)
class SweptDimension:
    """A dimension: its name, the fields that vary along it, and their values at each step."""

    name: str
    fields: tuple[str, ...]
    rows: tuple[Values, ...]

    @property
    def size(self) -> int:
        """The number of steps."""
        return len(self.rows)


@dataclass(frozen=True)
class Sweep:
    """A base scene, as the tables of its file, and the dimensions in which cells differ from it.

    Cells are counted with the last dimension running fastest; `scene` makes each when it is needed.
    ``folder`` is where files that the scene names are looked for.

    >>> varied = {"eps": [0.1, 0.2], "order": ["leading"]}
    >>> sweep = sweep_of({"scene": "toda_soliton", "grid": varied})
    >>> sweep
    <Sweep of toda_soliton: 2 eps x 1 order = 2 cells>
    >>> sweep.scene(1)
    <Scene toda_soliton: kdv_soliton with kappa = 1 on toda, eps = 0.2, ...>
    """

    name: str
    base: str
    document: Mapping[str, Any]
    dimensions: tuple[SweptDimension, ...]
    folder: Path = Path()
    title: str = ""

    @property
    def shape(self) -> tuple[int, ...]:
        """The sizes of the dimensions."""
        return tuple(dimension.size for dimension in self.dimensions)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def __repr__(self) -> str:
        sizes = " x ".join(f"{d.size} {d.name}" for d in self.dimensions)
        return f"<Sweep of {self.base}: {sizes} = {len(self)} cells>"

    def _repr_html_(self) -> str:
        rows = [
            (d.name, str(d.size), cut(", ".join(" ".join(map(str, row)) for row in d.rows), SHOWN))
            for d in self.dimensions
        ]
        return html_table(repr(self).strip("<>"), rows, ("dimension", "size", "values"))

    def json(self) -> str:
        """The tables of the base scene, and what varies, as JSON."""
        varied = [asdict(dimension) for dimension in self.dimensions]
        return json.dumps({"scene": self.document, "dimensions": varied}, sort_keys=True)

    def values(self, cell: int) -> dict[str, Any]:
        """The swept fields of a cell."""
        found: dict[str, Any] = {}
        places = np.unravel_index(cell, self.shape)
        for dimension, place in zip(self.dimensions, places, strict=True):
            found |= zip(dimension.fields, dimension.rows[place], strict=True)
        return found

    def scene(self, cell: int) -> Scene:
        """The cell's scene; ValueError in one line for what no scene may be."""
        document = changed_document(self.document, self.values(cell))
        return make_scene(document, self.base, self.folder)


def load_sweep(source: str | Path, changes: Mapping[str, Any] | None = None) -> Sweep:
    """The sweep in a TOML file, or the shipped one of that name.

    ``changes`` are values for fields that it does not vary, in the place of those in its [set].

    Raises ValueError, with the file's name, for what is no sweep. Whether each cell's scene is
    admissible is not looked at: a cell that is not fails by itself.
    """
    path = Path(source)
    if path.suffix == ".toml" or path.is_file():
        return _read(path, changes or {})
    if str(source) in shipped_sweeps():
        with as_file(FOLDER / f"{source}.toml") as found:
            return _read(found, changes or {})
    raise ValueError(
        f"sweep must be a TOML file or a shipped sweep, got {shown(str(source))} "
        f"({one_of(source, shipped_sweeps())})"
    )


def _read(path: Path, changes: Mapping[str, Any]) -> Sweep:
    document = read_document(path, "sweep")
    try:
        return sweep_of(document, path.stem, path.parent, changes)
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from None


def shipped_sweeps() -> tuple[str, ...]:
    """Names of the sweeps that come with the package, sorted."""
    found = (entry.name for entry in FOLDER.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in found if name.endswith(".toml")))


def sweep_of(
    document: Mapping[str, Any],
    name: str = "sweep",
    folder: Path = Path(),
    changes: Mapping[str, Any] | None = None,
) -> Sweep:
    """The sweep that the tables of a file say, with ``changes`` to its [set]; ValueError in one
    line for what is none."""
    refuse_unknown(document, TOP, "")
    title = document.get("title", "")
    text("title", title)
    if "scene" not in document:
        raise ValueError("scene must be stated, got nothing (a shipped scene, a file or a table)")
    base, base_tables = base_document(document["scene"], folder)
    fixed = dict(_flat(table(document, "set"), "set"))
    fixed |= {field_in_one_spelling(field): value for field, value in (changes or {}).items()}
    dimensions = tuple(_dimensions(document))
    if not dimensions:
        raise ValueError("[grid], [list] or [random] must be stated, got none (such as [grid])")
    swept = [field for dimension in dimensions for field in dimension.fields]
    for field in (*fixed, *swept):
        check_field(field, base_tables)
        if field in swept and field in (changes or {}):
            raise ValueError(
                f"--set must name what the sweep does not vary, got {field} (leave it)"
            )
    for place, field in enumerate(swept):
        others = {*swept[:place], *fixed}
        if field in others or any(
            _within(*pair) for o in others for pair in [(o, field), (field, o)]
        ):
            raise ValueError(f"{field} must vary in one place, got two (leave one out)")
    cells = math.prod(dimension.size for dimension in dimensions)
    if cells > MOST_CELLS:
        raise ValueError(f"cells must be at most {MOST_CELLS}, got {cells} (take fewer values)")
    constant = changed_document(base_tables, fixed)
    return Sweep(name, base, constant, _named(dimensions), folder, title)


def _within(table: str, field: str) -> bool:
    return field.startswith(f"{table}.")


def _named(dimensions: Sequence[SweptDimension]) -> tuple[SweptDimension, ...]:
    """The dimensions under the last part of their fields' names, where that is theirs alone."""
    short = [dimension.name.rpartition(".")[2] for dimension in dimensions]
    return tuple(
        replace(d, name=name if _is_free(name, short) else d.name.replace(".", "_"))
        for d, name in zip(dimensions, short, strict=True)
    )


def _is_free(name: str, others: Sequence[str]) -> bool:
    return others.count(name) == 1 and name not in TAKEN


def _flat(entries: Mapping[str, Any], where: str, inner: str = "") -> Iterator[tuple[str, Any]]:
    """Fields by dotted names; a table with a range's keys, or one in [set], is a value's own."""
    for key, value in entries.items():
        name = f"{inner}{key}"
        if isinstance(value, Mapping) and not set(value) & {*RANGE, *DRAWN}:
            if name.count(".") > 1:
                raise ValueError(
                    f"fields in [{where}] must have at most one dot, got {shown(name)}"
                )
            yield from _flat(value, where, f"{name}.")
        else:
            yield field_in_one_spelling(name), value


def _dimensions(document: Mapping[str, Any]) -> Iterator[SweptDimension]:
    for field, given in _flat(table(document, "grid"), "grid"):
        values = _range(field, given) if isinstance(given, Mapping) else _listed(field, given)
        _check_different(field, values)
        yield SweptDimension(field, (field,), tuple((value,) for value in values))
    columns = {
        field: _range(field, given) if isinstance(given, Mapping) else _listed(field, given)
        for field, given in _flat(table(document, "list"), "list")
    }
    if columns:
        first, *others = columns
        for field in others:
            if len(columns[field]) != len(columns[first]):
                raise ValueError(
                    f"columns in [list] must have one length, got {len(columns[first])} of {first} "
                    f"and {len(columns[field])} of {field} (they go together; or use [grid])"
                )
        yield SweptDimension(CASE, tuple(columns), tuple(zip(*columns.values(), strict=True)))
    if "random" in document:
        yield _sampled(dict(table(document, "random")))


def _check_different(field: str, values: Sequence[Any]) -> None:
    """Refuse a value that stands twice on an axis: of its cells one could not be asked for."""
    found: set[str | float] = set()
    for value in values:
        told = json.dumps(value, sort_keys=True) if isinstance(value, list | dict) else value
        if told in found:
            raise ValueError(
                f"{field} in [grid] must have different values, got {shown(value)} twice (leave "
                "one out)"
            )
        found.add(told)


def _sampled(given: dict[str, Any]) -> SweptDimension:
    """Samples, each field drawn from a stream of its own: a further field changes no other."""
    for key in ("count", "seed"):
        if key not in given:
            raise ValueError(f"{key} in [random] must be stated, got nothing (such as {key} = 100)")
    count, seed = _count(given.pop("count")), given.pop("seed")
    if isinstance(seed, bool) or not isinstance(seed, int):
        raise ValueError(f"seed in [random] must be a whole number, got {shown(seed)} (such as 1)")
    columns = {}
    for field, drawn in _flat(given, "random"):
        stream = Random(f"{seed} {field}")
        columns[field] = [_drawn(field, drawn, stream) for _ in range(count)]
    if not columns:
        raise ValueError(
            "[random] must name a field, got none (such as eps = {from = 0.05, to = 0.1})"
        )
    return SweptDimension(SAMPLE, tuple(columns), tuple(zip(*columns.values(), strict=True)))


def _count(value: object) -> int:
    number = whole("count", value)
    if number > MOST_CELLS:
        raise ValueError(f"count must be at most {MOST_CELLS}, got {number} (take fewer)")
    return number


def _listed(field: str, given: object) -> Sequence[Any]:
    if not isinstance(given, list) or not given:
        raise ValueError(
            f"{field} must be a list of values or a range, got {shown(given)} (such as [1, 2] or "
            "{from = 0, to = 1, count = 5})"
        )
    return [_value(field, value) for value in given]


def _value(field: str, value: object) -> Any:
    """A number, a text, or a list or table of them; the scene says what else it must be."""
    if isinstance(value, list):
        return [_value(field, part) for part in value]
    if isinstance(value, Mapping):
        return {key: _value(f"{field}.{key}", part) for key, part in value.items()}
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{field} must be finite numbers or texts, got {value} (such as 0.5)")
    if isinstance(value, str) and "\0" in value:
        raise ValueError(f"{field} must be a text without NUL, got {shown(value)} (leave it out)")
    if isinstance(value, str | bool | int | float):
        return value
    raise ValueError(f"{field} must be numbers or texts, got {shown(value)} (such as 0.5)")


def _ends(field: str, given: Mapping[str, Any]) -> tuple[float, float, bool]:
    for key in ("from", "to"):
        if key not in given:
            raise ValueError(f"{field} must have its ends, got no {key} (state it)")
    low, high = (finite(f"{key} of {field}", given[key]) for key in ("from", "to"))
    if low >= high:
        raise ValueError(f"{field} must have from < to, got {low:g} and {high:g} (swap them)")
    log = _flag(field, given, "log")
    if log and low <= 0:
        raise ValueError(f"{field} must have from > 0 with log, got {low:g} (leave log out)")
    return low, high, log


def _flag(field: str, given: Mapping[str, Any], key: str) -> bool:
    flag = given.get(key, False)
    if not isinstance(flag, bool):
        raise ValueError(
            f"{key} of {field} must be true or false, got {shown(flag)} (without quotes)"
        )
    return flag


def _range(field: str, given: Mapping[str, Any]) -> Sequence[float]:
    """Values from end to end, to 15 digits: 0.3 is not 0.30000000000000004."""
    refuse_unknown(given, RANGE, f" of {field}")
    low, high, log = _ends(field, given)
    if "count" not in given:
        raise ValueError(f"{field} must have a count, got none (such as count = 5)")
    count = _count(given["count"])
    if count < 2:
        raise ValueError(f"count of {field} must be at least 2, got {count} (or list the value)")
    shares = (i / (count - 1) for i in range(count))
    if log:
        points = [low * (high / low) ** share for share in shares]
    else:
        points = [low * (1 - share) + high * share for share in shares]
    points = [low, *(float(f"{point:.15g}") for point in points[1:-1]), high]
    between_whole = all(isinstance(given[key], int) for key in ("from", "to"))
    if between_whole and all(point == int(point) for point in points):
        return [int(point) for point in points]
    return points


def _drawn(field: str, given: object, stream: Random) -> Any:
    if not isinstance(given, Mapping):
        raise ValueError(
            f"{field} in [random] must be a range or a choice, got {shown(given)} (such as "
            "{from = 0, to = 1} or {choose = [1, 2]})"
        )
    refuse_unknown(given, DRAWN, f" of {field}")
    if "choose" in given:
        if len(given) > 1:
            raise ValueError(f"{field} must have choose alone, got other keys too (leave them out)")
        choices = _listed(field, given["choose"])
        return choices[int(stream.random() * len(choices))]
    low, high, log = _ends(field, given)
    share = stream.random()
    is_whole = _flag(field, given, "whole")
    if is_whole and not (low.is_integer() and high.is_integer()):
        raise ValueError(
            f"{field} must have whole ends where it is whole, got {low:g} and {high:g} (such as "
            "{from = 1, to = 100, whole = true})"
        )
    beyond = high + is_whole
    drawn = low * (beyond / low) ** share if log else low + (beyond - low) * share
    return min(math.floor(drawn), int(high)) if is_whole else drawn

"""Sweeps: a scene, the fields that vary, and the TOML files that describe both.

    title = "error of the sech soliton over eps and its height"
    scene = "soliton_sech.toml"     # a shipped scene, a file beside this one, or a table [scene]

    [set]                           # fields with one value in all cells
    tolerance = 1e-4

    [grid]                          # one dimension for each field: every value with every other
    eps = [0.05, 0.1]
    parameters.A = { from = 0.5, to = 2, count = 7 }

    [list]                          # columns of equal length, varied together: dimension `case`
    wave = ["rogue_cn", "rogue_dn"]
    lattice.K4 = [1, -1]            # or whole tables: constants = [{ K2 = 1 }, { K2 = 2 }]

    [random]                        # random samples: dimension `sample`
    count = 100
    seed = 1
    lattice.K3 = { from = -0.5, to = 0.5 }
    parameters.A = { choose = [0.5, 1, 2] }

A field has the same dotted name as in the scene's file. A range includes both ends; ``log = true``
spaces it evenly in the logarithm. In [random], ``whole = true`` draws integers. A file may have a
grid, a list and a random sample at once, which are combined as a product.
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

from longwave.runs import sweep_scene
from longwave.runs.run_pack import NUMBERS, TEXTS
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import finite, refuse_unknown, table, text, whole
from longwave.scenes.description.scene_file import read_document
from longwave.support.html_tables import html_table
from longwave.support.known_names import one_of
from longwave.support.user_files import cut, shown

MAX_CELLS = 1_000_000
"""Largest number of cells of a sweep."""

TOP_KEYS = ("title", "scene", "set", "grid", "list", "random")
RANGE_KEYS = ("from", "to", "count", "log")
RANDOM_KEYS = ("from", "to", "log", "whole", "choose")
"""Keys at the top of a sweep's file, of a range, and of a field in [random]."""

MAX_SHOWN = 120
"""Largest number of characters of a dimension's values that a notebook shows."""

CASE, SAMPLE = "case", "sample"
"""Names of the dimensions of a list and of a random sample."""

RESERVED_NAMES = (CASE, SAMPLE, "time", "site", "row", "quantity", "background", *TEXTS, *NUMBERS)
"""Names that no swept dimension may have, as they mean something else in a data set."""

SHIPPED_FOLDER = files("longwave.runs.sweeps")
"""Folder of the shipped sweeps."""

Values = tuple[Any, ...]


@dataclass(frozen=True)
class SweptDimension:
    """A dimension of a sweep: name, fields that vary along it, and their values at each index."""

    name: str
    fields: tuple[str, ...]
    rows: tuple[Values, ...]

    @property
    def size(self) -> int:
        """Number of values along the dimension."""
        return len(self.rows)


@dataclass(frozen=True)
class Sweep:
    """A base scene, as the tables of its file, and the dimensions along which its fields vary.

    Cells are numbered with the last dimension varying fastest; `scene` builds the scene of a cell
    on demand. ``folder`` is the folder of the files that the scene names.

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
        """Sizes of the dimensions."""
        return tuple(dimension.size for dimension in self.dimensions)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def __repr__(self) -> str:
        sizes = " x ".join(f"{d.size} {d.name}" for d in self.dimensions)
        return f"<Sweep of {self.base}: {sizes} = {len(self)} cells>"

    def _repr_html_(self) -> str:
        texts = (", ".join(" ".join(map(str, row)) for row in d.rows) for d in self.dimensions)
        rows = [
            (d.name, str(d.size), cut(text, MAX_SHOWN))
            for d, text in zip(self.dimensions, texts, strict=True)
        ]
        return html_table(repr(self).strip("<>"), rows, ("dimension", "size", "values"))

    def json(self) -> str:
        """Return the tables of the base scene and the dimensions as JSON."""
        varied = [asdict(dimension) for dimension in self.dimensions]
        return json.dumps({"scene": self.document, "dimensions": varied}, sort_keys=True)

    def values(self, cell: int) -> dict[str, Any]:
        """Return the values of the swept fields in a cell."""
        values: dict[str, Any] = {}
        indices = np.unravel_index(cell, self.shape)
        for dimension, index in zip(self.dimensions, indices, strict=True):
            values |= zip(dimension.fields, dimension.rows[index], strict=True)
        return values

    def scene(self, cell: int) -> Scene:
        """Build the scene of a cell; raise ValueError in one line if it is not admissible."""
        document = sweep_scene.changed_document(self.document, self.values(cell))
        return sweep_scene.make_scene(document, self.base, self.folder)


def load_sweep(source: str | Path, changes: Mapping[str, Any] | None = None) -> Sweep:
    """Load a sweep from a TOML file, or a shipped sweep by name.

    ``changes`` are values for fields that the sweep does not vary; they replace those in [set].
    Raises ValueError, with the file's name, if the file is no sweep. The scenes of the cells are
    not checked: an inadmissible one only fails in its cell.
    """
    path = Path(source)
    if path.suffix == ".toml" or path.is_file():
        return _read_sweep(path, changes or {})
    if str(source) in shipped_sweeps():
        with as_file(SHIPPED_FOLDER / f"{source}.toml") as path:
            return _read_sweep(path, changes or {})
    got = f"{shown(str(source))} ({one_of(source, shipped_sweeps())})"
    raise ValueError(f"sweep must be a TOML file or a shipped sweep, got {got}")


def _read_sweep(path: Path, changes: Mapping[str, Any]) -> Sweep:
    document = read_document(path, "sweep")
    try:
        return sweep_of(document, path.stem, path.parent, changes)
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from None


def shipped_sweeps() -> tuple[str, ...]:
    """Return the names of the shipped sweeps, sorted."""
    names = (entry.name for entry in SHIPPED_FOLDER.iterdir())
    return tuple(sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml")))


def sweep_of(
    document: Mapping[str, Any],
    name: str = "sweep",
    folder: Path = Path(),
    changes: Mapping[str, Any] | None = None,
) -> Sweep:
    """Build a sweep from a file's tables with ``changes`` to its [set]; ValueError if invalid."""
    refuse_unknown(document, TOP_KEYS, "")
    title = document.get("title", "")
    text("title", title)
    if "scene" not in document:
        raise ValueError("scene must be stated, got nothing (a shipped scene, a file or a table)")
    base, base_tables = sweep_scene.base_document(document["scene"], folder)
    fixed = dict(_flatten_tables(table(document, "set"), "set"))
    fixed |= {sweep_scene.canonical_field(field): value for field, value in (changes or {}).items()}
    dimensions = tuple(_dimensions(document))
    if not dimensions:
        raise ValueError("[grid], [list] or [random] must be stated, got none (such as [grid])")
    swept = [field for dimension in dimensions for field in dimension.fields]
    for field in (*fixed, *swept):
        sweep_scene.check_field(field, base_tables)
        if field in swept and field in (changes or {}):
            raise ValueError(f"--set must not name a swept field, got {field} (leave it out)")
    for index, field in enumerate(swept):
        others = {*swept[:index], *fixed}
        if any(f"{o}.".startswith(f"{field}.") or field.startswith(f"{o}.") for o in others):
            raise ValueError(f"{field} must be given in one table, got it in two (leave one out)")
    cells = math.prod(dimension.size for dimension in dimensions)
    if cells > MAX_CELLS:
        raise ValueError(f"cells must be at most {MAX_CELLS}, got {cells} (take fewer values)")
    constant = sweep_scene.changed_document(base_tables, fixed)
    return Sweep(name, base, constant, _name_dimensions(dimensions), folder, title)


def _name_dimensions(dimensions: Sequence[SweptDimension]) -> tuple[SweptDimension, ...]:
    """Shorten each dimension's dotted name to its last part, if that is unique and not reserved."""
    short = [d.name.rpartition(".")[2] for d in dimensions]
    free = {name for name in short if short.count(name) == 1} - {*RESERVED_NAMES}
    return tuple(
        replace(d, name=name if name in free else d.name.replace(".", "_"))
        for d, name in zip(dimensions, short, strict=True)
    )


def _flatten_tables(
    entries: Mapping[str, Any], where: str, prefix: str = ""
) -> Iterator[tuple[str, Any]]:
    """Yield dotted names of fields and their values; a table that describes a range is a value."""
    for key, value in entries.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping) and not set(value) & {*RANGE_KEYS, *RANDOM_KEYS}:
            if name.count(".") > 1:
                got = shown(name)
                raise ValueError(f"fields in [{where}] must have at most one dot, got {got}")
            yield from _flatten_tables(value, where, f"{name}.")
        else:
            yield sweep_scene.canonical_field(name), value


def _dimensions(document: Mapping[str, Any]) -> Iterator[SweptDimension]:
    for field, given in _flatten_tables(table(document, "grid"), "grid"):
        values = _axis_values(field, given)
        _check_distinct(field, values)
        yield SweptDimension(field, (field,), tuple((value,) for value in values))
    listed = _flatten_tables(table(document, "list"), "list")
    columns = {field: _axis_values(field, given) for field, given in listed}
    if columns:
        first, *others = columns
        for field in others:
            if len(columns[field]) != len(columns[first]):
                raise ValueError(
                    f"columns in [list] must have one length, got {len(columns[first])} of {first} "
                    f"and {len(columns[field])} of {field} (they vary together; or use [grid])"
                )
        yield SweptDimension(CASE, tuple(columns), tuple(zip(*columns.values(), strict=True)))
    if "random" in document:
        yield _sample_dimension(dict(table(document, "random")))


def _check_distinct(field: str, values: Sequence[Any]) -> None:
    """Raise ValueError if a value occurs twice on an axis, where its index would be ambiguous."""
    distinct: set[str | float] = set()
    for value in values:
        comparable = json.dumps(value, sort_keys=True) if isinstance(value, list | dict) else value
        if comparable in distinct:
            got = f"{shown(value)} twice (leave one out)"
            raise ValueError(f"{field} in [grid] must have different values, got {got}")
        distinct.add(comparable)


def _sample_dimension(given: dict[str, Any]) -> SweptDimension:
    """Draw the random samples of [random].

    Each field has its own random stream, so a new field leaves the samples of others unchanged.
    """
    for key in ("count", "seed"):
        if key not in given:
            raise ValueError(f"{key} in [random] must be stated, got nothing (such as {key} = 100)")
    count, seed = _checked_count(given.pop("count")), given.pop("seed")
    if isinstance(seed, bool) or not isinstance(seed, int):
        raise ValueError(f"seed in [random] must be a whole number, got {shown(seed)} (such as 1)")
    columns = {}
    for field, law in _flatten_tables(given, "random"):
        stream = Random(f"{seed} {field}")
        columns[field] = [_draw(field, law, stream) for _ in range(count)]
    if not columns:
        raise ValueError(
            "[random] must name a field, got none (such as eps = {from = 0.05, to = 0.1})"
        )
    return SweptDimension(SAMPLE, tuple(columns), tuple(zip(*columns.values(), strict=True)))


def _checked_count(value: object) -> int:
    number = whole("count", value)
    if number > MAX_CELLS:
        raise ValueError(f"count must be at most {MAX_CELLS}, got {number} (take fewer)")
    return number


def _axis_values(field: str, given: object) -> Sequence[Any]:
    """Return the values of a field along its dimension, from a range or a list."""
    if isinstance(given, Mapping):
        return _range_values(field, given)
    return _listed_values(field, given)


def _listed_values(field: str, given: object) -> Sequence[Any]:
    if not isinstance(given, list) or not given:
        raise ValueError(
            f"{field} must be a list of values or a range, got {shown(given)} (such as [1, 2] or "
            "{from = 0, to = 1, count = 5})"
        )
    return [_checked_value(field, value) for value in given]


def _checked_value(field: str, value: object) -> Any:
    """Return the value if it is a number, text, or list or table of them; else raise ValueError."""
    if isinstance(value, list):
        return [_checked_value(field, part) for part in value]
    if isinstance(value, Mapping):
        return {key: _checked_value(f"{field}.{key}", part) for key, part in value.items()}
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{field} must be finite numbers or texts, got {value} (such as 0.5)")
    if isinstance(value, str) and "\0" in value:
        raise ValueError(f"{field} must be a text without NUL, got {shown(value)} (leave it out)")
    if isinstance(value, str | bool | int | float):
        return value
    raise ValueError(f"{field} must be numbers or texts, got {shown(value)} (such as 0.5)")


def _range_ends(field: str, given: Mapping[str, Any]) -> tuple[float, float, bool]:
    for key in ("from", "to"):
        if key not in given:
            raise ValueError(f"{field} must have its ends, got no {key} (state it)")
    low, high = (finite(f"{key} of {field}", given[key]) for key in ("from", "to"))
    if low >= high:
        raise ValueError(f"{field} must have from < to, got {low:g} and {high:g} (swap them)")
    log = _boolean(field, given, "log")
    if log and low <= 0:
        raise ValueError(f"{field} must have from > 0 with log, got {low:g} (leave log out)")
    return low, high, log


def _boolean(field: str, given: Mapping[str, Any], key: str) -> bool:
    flag = given.get(key, False)
    if not isinstance(flag, bool):
        got = f"{shown(flag)} (without quotes)"
        raise ValueError(f"{key} of {field} must be true or false, got {got}")
    return flag


def _range_values(field: str, given: Mapping[str, Any]) -> Sequence[float]:
    """Return the values of a range, rounded to 15 digits: 0.3, not 0.30000000000000004."""
    refuse_unknown(given, RANGE_KEYS, f" of {field}")
    low, high, log = _range_ends(field, given)
    if "count" not in given:
        raise ValueError(f"{field} must have a count, got none (such as count = 5)")
    count = _checked_count(given["count"])
    if count < 2:
        raise ValueError(f"count of {field} must be at least 2, got {count} (or list the value)")
    fractions = [i / (count - 1) for i in range(1, count - 1)]
    inner = (low * (high / low) ** s if log else low * (1 - s) + high * s for s in fractions)
    points = [low, *(float(f"{point:.15g}") for point in inner), high]
    between_whole = all(isinstance(given[key], int) for key in ("from", "to"))
    if between_whole and all(point == int(point) for point in points):
        return [int(point) for point in points]
    return points


def _draw(field: str, given: object, stream: Random) -> Any:
    if not isinstance(given, Mapping):
        raise ValueError(
            f"{field} in [random] must be a range or a choice, got {shown(given)} (such as "
            "{from = 0, to = 1} or {choose = [1, 2]})"
        )
    refuse_unknown(given, RANDOM_KEYS, f" of {field}")
    if "choose" in given:
        if len(given) > 1:
            got = f"{shown(given)} (leave them out)"
            raise ValueError(f"{field} with choose must have no other key, got {got}")
        choices = _listed_values(field, given["choose"])
        return choices[int(stream.random() * len(choices))]
    low, high, log = _range_ends(field, given)
    fraction = stream.random()
    is_whole = _boolean(field, given, "whole")
    if is_whole and not (low.is_integer() and high.is_integer()):
        raise ValueError(
            f"{field} must have whole ends where it is whole, got {low:g} and {high:g} (such as "
            "{from = 1, to = 100, whole = true})"
        )
    beyond = high + is_whole
    value = low * (beyond / low) ** fraction if log else low + (beyond - low) * fraction
    return min(math.floor(value), int(high)) if is_whole else value

"""Tables of numbers: as lists, or as text of which line 1 names the columns.

Commas, semicolons or tabs part them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.support.real_arrays import real_array
from longwave.support.user_files import read_text, shown, shown_path

Numbers = NDArray[np.float64]

LARGEST = 1e50
"""Of numbers: larger ones would leave the range of doubles on the way."""

LARGEST_FILE = 1_000_000
"""Bytes of a table that a scene holds."""


def with_columns(given: Any, folder: Path) -> Any:
    """Tables in which ``file = "drive.csv"``, looked for in ``folder``, stands for its columns.

    Raises ValueError in one line for what is no such file.
    """
    if isinstance(given, list | tuple):
        return [with_columns(entry, folder) for entry in given]
    if not isinstance(given, Mapping):
        return given
    found = {key: with_columns(value, folder) for key, value in given.items() if key != "file"}
    if "file" not in given:
        return found
    file = given["file"]
    if not isinstance(file, str):
        raise ValueError(f"file must be a name, got {shown(file)} (such as 'drive.csv')")
    try:
        return found | table_columns(read_text(folder / file, "file", LARGEST_FILE))
    except (OSError, ValueError) as error:
        raise ValueError(f"{shown_path(file)}: {getattr(error, 'strerror', error)}") from None


def _mark(header: str) -> str:
    """Return what parts the columns of a table with this first line."""
    return next((sign for sign in ";\t" if sign in header), ",")


def column_names(header: str) -> list[str]:
    """Return the names of columns in the first line of a table."""
    return [part.strip().strip('"') for part in header.split(_mark(header))]


def table_columns(text: str) -> dict[str, list[float]]:
    r"""The columns by name; ValueError, with the line, for what is no such table.

    >>> table_columns("t;value\n0;1\n1;3")
    {'t': [0.0, 1.0], 'value': [1.0, 3.0]}
    """
    lines = text.rstrip().splitlines()
    header = lines[0] if lines else ""
    mark, names = _mark(header), column_names(header)
    if len({*names}) < len(names):
        raise ValueError(f"line 1 must name each column once, got {shown(header)} (name it anew)")
    rows = [_numbers(line, mark, names, place) for place, line in enumerate(lines[1:], 2)]
    return {name: [row[place] for row in rows] for place, name in enumerate(names)}


def _numbers(line: str, mark: str, names: Sequence[str], place: int) -> list[float]:
    parts = [part.strip() for part in line.split(mark)]
    if len(parts) != len(names):
        raise ValueError(
            f"line {place} must hold {len(names)} numbers, {' '.join(names)}, got {shown(line)} "
            "(mend the line or leave it out)"
        )
    try:
        found = [float(part) for part in parts]
    except ValueError:
        found = [math.nan]
    if not all(abs(number) <= LARGEST for number in found):
        raise ValueError(
            f"line {place} must hold finite numbers, got {shown(line)} (with a point, as 0.5; mend "
            "the line or leave it out)"
        )
    return found


def number_list(label: str, given: ArrayLike) -> Numbers:
    """A list of finite numbers; ValueError in one line for what is none."""
    found = real_array(f"every {label}", given, allows_nan=True)
    if found.ndim != 1:
        raise ValueError(
            f"{label} must be a list of numbers, got {shown(given)} (such as [0, 0.1])"
        )
    for row in np.flatnonzero(~(abs(found) <= LARGEST)):
        raise ValueError(
            f"{label} must be finite, got {found[row]:g} in row {row + 1} (leave the row out)"
        )
    return found

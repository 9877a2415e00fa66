"""Tables of numbers: as lists, or as CSV text whose first line names the columns.

Columns are separated by commas, semicolons or tabs.
"""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.support.real_arrays import real_array
from longwave.support.user_files import read_text, shown, shown_path

Numbers = NDArray[np.float64]

LARGEST_NUMBER = 1e50
"""Largest number accepted; computations with larger ones may overflow."""

MAX_TABLE_BYTES = 1_000_000
"""Maximum size in bytes of a table that a scene stores."""


def with_columns(given: Any, folder: Path) -> Any:
    """Return tables in which ``file = "drive.csv"`` is replaced by the columns of that file.

    The file is looked up in ``folder``. Raises ValueError if it cannot be read.
    """
    if isinstance(given, list | tuple):
        return [with_columns(entry, folder) for entry in given]
    if not isinstance(given, Mapping):
        return given
    columns = {key: with_columns(value, folder) for key, value in given.items() if key != "file"}
    if "file" not in given:
        return columns
    file = given["file"]
    if not isinstance(file, str):
        raise ValueError(f"file must be a name, got {shown(file)} (such as 'drive.csv')")
    try:
        return columns | table_columns(read_text(folder / file, "file", MAX_TABLE_BYTES))
    except (OSError, ValueError) as error:
        raise ValueError(f"{shown_path(file)}: {getattr(error, 'strerror', error)}") from None


def _separator(header: str) -> str:
    """Return the separator of columns in a table with this first line."""
    return next((character for character in ";\t" if character in header), ",")


def column_names(header: str) -> list[str]:
    """Return the names of columns in the first line of a table."""
    return [part.strip().strip('"') for part in header.split(_separator(header))]


def table_columns(text: str) -> dict[str, list[float]]:
    r"""Return the columns of a CSV text by name; ValueError, with the line, for an invalid text.

    >>> table_columns("t;value\n0;1\n1;3")
    {'t': [0.0, 1.0], 'value': [1.0, 3.0]}
    """
    lines = text.rstrip().splitlines()
    header = lines[0] if lines else ""
    separator, names = _separator(header), column_names(header)
    if len({*names}) < len(names):
        raise ValueError(f"line 1 must name each column once, got {shown(header)} (rename one)")
    rows = [_numbers(line, separator, names, i) for i, line in enumerate(lines[1:], 2)]
    return {name: [row[i] for row in rows] for i, name in enumerate(names)}


def _numbers(line: str, separator: str, names: Sequence[str], row: int) -> list[float]:
    parts = [part.strip() for part in line.split(separator)]
    if len(parts) != len(names):
        raise ValueError(
            f"line {row} must hold {len(names)} numbers, {' '.join(names)}, got "
            f"{shown(line)} (correct the line or leave it out)"
        )
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        numbers = [math.nan]
    if not all(abs(number) <= LARGEST_NUMBER for number in numbers):
        raise ValueError(
            f"line {row} must hold finite numbers, got {shown(line)} (with a point, as 0.5; "
            "correct the line or leave it out)"
        )
    return numbers


def number_list(label: str, given: ArrayLike) -> Numbers:
    """Return a list of finite numbers as an array; ValueError, naming ``label``, for others."""
    numbers = real_array(f"every {label}", given, allows_nan=True)
    if numbers.ndim != 1:
        raise ValueError(
            f"{label} must be a list of numbers, got {shown(given)} (such as [0, 0.1])"
        )
    for row in np.flatnonzero(~(abs(numbers) <= LARGEST_NUMBER)):
        raise ValueError(
            f"{label} must be finite, got {numbers[row]:g} in row {row + 1} (leave the row out)"
        )
    return numbers

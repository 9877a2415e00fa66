"""Measured points of a force law: stretch, force, and the standard deviation of the force.

    stretch,force,deviation
    -0.10,-0.0952,0.002
    -0.05,-0.0488,0.002

Columns are separated by commas, semicolons or tabs, in the order of the header; the deviation is
optional.  A spring under tension has a positive stretch and a positive force.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.scenes.description.csv_table import column_names, number_list, table_columns
from longwave.support.user_files import read_text, shown, shown_path

Points = NDArray[np.float64]

COLUMNS = ("stretch", "force", "deviation")

COMMENT, LENGTHS = "#", ("m", "in", "inch")
"""Prefix of comment lines; suffixes of unit names by which units of length are recognised."""

MAX_FILE_BYTES = 10_000_000
"""Maximum size of a file, in bytes."""

MIN_POINTS = 4
"""Minimum number of points, so that a fit leaves degrees of freedom to test the law."""

MAX_POINTS = 100_000
"""Maximum number of measured points."""

SMALLEST_SIZE = 1e-20
"""Least magnitude of the largest stretch, of the largest force and of each deviation; the greatest
magnitude accepted is its inverse. The squares of their sixth powers are then within the range of
doubles."""

TURN_FRACTION = 0.1
"""Smallest reversal of the stretch counted as a turn, as a fraction of the range of stretches."""

MIN_BRANCH_POINTS = 4
"""Minimum mean number of points between two turns; with fewer, points are unordered."""

LOOP_FRACTION, LOOP_DEVIATIONS = 0.005, 4.0
"""Mean width above which loading and unloading form a loop, as a fraction of the range of forces
(which allows for interpolation between points) and in standard deviations of the mean width. A loop
must be wider than both and than the noise of a point."""


@dataclass(frozen=True)
class ForceData:
    """Measured points of a force law, sorted by stretch; ``deviation`` is None if unknown.

    ``rows`` are the row numbers of the points in the order of measurement, from 0.
    """

    stretch: Points
    force: Points
    deviation: Points | None
    rows: NDArray[np.intp]

    @classmethod
    def of(
        cls, stretch: ArrayLike, force: ArrayLike, deviation: ArrayLike | None = None
    ) -> ForceData:
        """Build the data from columns in the order of measurement.

        Raises ValueError for columns that are not lists of finite numbers, too few points, a
        repeated point, values near the ends of the range of doubles, unordered points, and loading
        and unloading branches that differ (hysteresis).
        """
        given = (stretch, force) if deviation is None else (stretch, force, deviation)
        columns = [number_list(*entry) for entry in zip(COLUMNS, given, strict=False)]
        for name, column in zip(COLUMNS[1:], columns[1:], strict=False):
            if column.size != columns[0].size:
                raise ValueError(
                    f"{name} must have a number for each stretch, {columns[0].size}, got "
                    f"{column.size} (give as many)"
                )
        rows = np.column_stack(columns)
        _check_points(rows)
        _check_order(rows)
        order = np.argsort(rows[:, 0], kind="stable")
        sorted_stretch, sorted_force, *others = rows[order].T
        return cls(sorted_stretch, sorted_force, others[0] if others else None, order)


def _check_sizes(name: str, column: Points) -> None:
    """Raise ValueError for a column whose powers and squares would leave the range of doubles."""
    sizes = np.abs(column)
    largest, least = float(np.max(sizes)), float(np.min(sizes) if name == COLUMNS[2] else 1.0)
    if not (SMALLEST_SIZE <= largest <= 1 / SMALLEST_SIZE and least >= SMALLEST_SIZE):
        got = largest if least >= SMALLEST_SIZE else least
        raise ValueError(
            f"{name} must be of a size from {SMALLEST_SIZE:g} to {1 / SMALLEST_SIZE:g}, got "
            f"{got:g} (take other units)"
        )


def _check_points(rows: Points) -> None:
    if not MIN_POINTS <= len(rows) <= MAX_POINTS:
        raise ValueError(
            f"points must be {MIN_POINTS} to {MAX_POINTS}, got {len(rows)} (measure more, or take "
            "means)"
        )
    if rows.shape[1] > 2:
        for row in np.flatnonzero(rows[:, 2] <= 0):
            raise ValueError(
                f"deviation must satisfy deviation > 0, got {rows[row, 2]:g} in row {row + 1} "
                "(leave the column out if it is not known)"
            )
    first_rows: dict[tuple[float, ...], int] = {}
    for number, point in enumerate(map(tuple, rows.tolist()), 1):
        if point in first_rows:
            raise ValueError(
                f"rows must be different, got row {number} the same as row {first_rows[point]} "
                "(leave one out; combine equal readings into one row with the deviation of their "
                "mean)"
            )
        first_rows[point] = number
    for name, column in zip(COLUMNS[:2], rows.T, strict=False):
        if not np.ptp(column):
            raise ValueError(
                f"{name} must vary, got {column[0]:g} in all rows (measure at several stretches)"
            )
    for name, column in zip(COLUMNS, rows.T, strict=False):
        _check_sizes(name, column)


def _check_order(rows: Points) -> None:
    """Raise ValueError for points in random order and for a hysteresis loop."""
    turns = _turns(rows[:, 0])
    ends = [0, *turns, len(rows) - 1]
    if turns and len(rows) < MIN_BRANCH_POINTS * (len(turns) + 1):
        raise ValueError(
            f"stretch must rise or fall from row to row, got {len(turns)} turns in {len(rows)} "
            "rows (sort them by stretch, if their order has no meaning)"
        )
    branches: dict[bool, list[Points]] = {True: [], False: []}
    for index, (start, end) in enumerate(pairwise(ends)):
        # a turning point belongs to the branch that ends there
        piece = rows[start + (index > 0) : end + 1]
        branches[bool(rows[end, 0] > rows[start, 0])].append(piece)
    if all(branches.values()):
        _check_loop(np.concatenate(branches[True]), np.concatenate(branches[False]), ends[1])


def _turns(stretch: Points) -> list[int]:
    """Return the rows where the stretch turns back by more than `TURN_FRACTION` of its range."""
    least = TURN_FRACTION * float(np.ptp(stretch))
    turns: list[int] = []
    lowest = highest = 0
    rising: bool | None = None
    for row, value in enumerate(stretch):
        lowest = row if value < stretch[lowest] else lowest
        highest = row if value > stretch[highest] else highest
        if rising is not True and value > stretch[lowest] + least:
            turns += [] if rising is None else [lowest]
            rising, highest = True, row
        elif rising is not False and value < stretch[highest] - least:
            turns += [] if rising is None else [highest]
            rising, lowest = False, row
    return turns


def _check_loop(rising: Points, falling: Points, turn: int) -> None:
    """Raise ValueError if loading and unloading branches differ by more than noise."""
    rising, falling = (b[np.argsort(b[:, 0], kind="stable")] for b in (rising, falling))
    common = falling[(falling[:, 0] >= rising[0, 0]) & (falling[:, 0] <= rising[-1, 0])]
    if len(common) < MIN_POINTS:
        return
    gap = np.interp(common[:, 0], rising[:, 0], rising[:, 1]) - common[:, 1]
    if rising.shape[1] > 2:
        others = np.interp(common[:, 0], rising[:, 0], rising[:, 2])
        noise = float(np.sqrt(np.mean(common[:, 2] ** 2 + others**2)))
    else:
        noise = float(np.std(np.diff(gap)) / np.sqrt(2))
    force = np.concatenate([rising[:, 1], falling[:, 1]])
    width = float(abs(np.mean(gap)))
    allowed = noise * max(1.0, LOOP_DEVIATIONS / np.sqrt(len(common)))
    if width > max(allowed, LOOP_FRACTION * float(np.ptp(force))):
        raise ValueError(
            f"loading and unloading must agree within the noise, {noise:.2g}, got a difference of "
            f"{width:.2g} (hysteresis: fit one branch alone, such as rows 1 to {turn + 1})"
        )


def read_force(path: str | Path, units: str | None = None) -> ForceData:
    """Read the points of a CSV file, or of the standard input for ``-``.

    ``units`` of stretch and force, such as ``"mm,N"``, are converted to metres and newtons. Raises
    ValueError, with file and line, for an invalid table, and OSError for an unreadable file.
    """
    length, force = (1.0, 1.0) if units is None else _factors(units)
    text = read_text(path, "force law", MAX_FILE_BYTES)
    try:
        _check_header(text)
        columns = {name.lower(): column for name, column in table_columns(text).items()}
        arrays = (np.array(columns[name]) for name in COLUMNS if name in columns)
        return ForceData.of(*(c * f for c, f in zip(arrays, (length, force, force), strict=False)))
    except ValueError as error:
        raise ValueError(f"{shown_path(path)}: {error}") from None


def _check_header(text: str) -> None:
    """Raise ValueError unless the first line names the columns; the message lists all remedies."""
    lines = text.rstrip().splitlines() or [""]
    number = next((n for n, line in enumerate(lines) if not line.startswith(COMMENT)), 0)
    names = column_names(lines[number])
    if number == 0 and {*COLUMNS[:2]} <= {name.lower() for name in names} <= {*COLUMNS}:
        return
    got = shown(",".join(names)) + (f" in line {number + 1}, below a comment" if number else "")
    remedies = ["leave out the lines above"] if number else []
    remedies.append("write stretch,force,deviation")
    if len(units := re.findall(rf"\(({_UNIT.pattern})\)", lines[number])) > 1:
        length, force = units[:2] if units[0].endswith(LENGTHS) else units[1::-1]
        remedies.append(f"state --units {length},{force}")
    raise ValueError(
        "line 1 must name the columns stretch, force and, if it is known, deviation, got "
        f"{got} ({', and '.join(remedies)})"
    )


_UNIT = re.compile(r"[A-Za-z\u00b5\u03bc]{1,30}")


def _factors(units: str) -> tuple[float, float]:
    """Return the factors that convert units such as "mm,N" to m and N; ValueError for others."""
    parts = [part.strip() for part in units.split(",")]
    if len(parts) != 2 or not all(map(_UNIT.fullmatch, parts)):
        raise ValueError(f"--units must be a length and a force, got {shown(units)} (such as mm,N)")
    try:
        import pint
    except ImportError:
        raise ValueError(
            f"--units must be left out without the package pint, got {units} (pip install "
            "'longwave[units]')"
        ) from None
    registry: Any = pint.UnitRegistry()
    return _factor(registry, parts[0], "m"), _factor(registry, parts[1], "N")


def _factor(registry: Any, unit: str, target: str) -> float:
    import pint

    try:
        return float(registry.Quantity(1.0, unit).to(target).magnitude)
    except pint.UndefinedUnitError:
        got = f"{unit}, which is not a known unit"
    except pint.DimensionalityError:
        got = f"{unit}, which cannot be converted to {target}"
    raise ValueError(f"--units must be a length and a force, got {got} (such as mm,N)")

"""Measured points of a force law: stretch, force, and the standard deviation of the force.

    stretch,force,deviation
    -0.10,-0.0952,0.002
    -0.05,-0.0488,0.002

Commas, semicolons or tabs part the columns, whose order is that of the header; the deviation may
be left out.  A spring that is pulled has a positive stretch and a positive force.
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
"""Start of a comment above a table; ends of the names of units of length."""

LARGEST = 10_000_000
"""Bytes of a file."""

FEWEST = 4
"""Points; a law has fewer constants, and something must be left to judge it by."""

MOST = 100_000

SMALLEST = 1e-20
"""Size of the largest stretch and force at the least, and of each deviation: their powers to the
sixth, and the squares of those, are then doubles."""

TURN = 0.1
"""Share of the range of stretch by which it must go back to have turned: less is noise of it."""

FEWEST_OF_BRANCH = 4
"""Points between two turns on the average, below which the points are in no order."""

LOOP_SHARE, LOOP_DEVIATIONS = 0.005, 4.0
"""A loop is wider than the noise of a point, than its mean width is uncertain by so many standard
deviations, and than this share of the range of forces, which the chords between points may miss."""


@dataclass(frozen=True)
class ForceData:
    """Points of a force law, by rising stretch; ``deviation`` is None where it is not known.

    ``rows`` are their places in the order of measurement.
    """

    stretch: Points
    force: Points
    deviation: Points | None
    rows: NDArray[np.intp]

    @classmethod
    def of(
        cls, stretch: ArrayLike, force: ArrayLike, deviation: ArrayLike | None = None
    ) -> ForceData:
        """Points in the order in which they were measured.

        Raises ValueError for what is no list of finite numbers, too few points, a point that is
        there twice, sizes near the ends of the range of doubles, no order, and branches of loading
        and unloading that lie apart.
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
        rows = rows[order]
        return cls(rows[:, 0], rows[:, 1], rows[:, 2] if deviation is not None else None, order)


def _check_sizes(name: str, column: Points) -> None:
    """Refuse columns, and deviations, whose powers and squares leave the range of doubles."""
    sizes = np.abs(column)
    largest, least = float(np.max(sizes)), float(np.min(sizes) if name == COLUMNS[2] else 1.0)
    if not (SMALLEST <= largest <= 1 / SMALLEST and least >= SMALLEST):
        got = largest if least >= SMALLEST else least
        raise ValueError(
            f"{name} must be of a size from {SMALLEST:g} to {1 / SMALLEST:g}, got {got:g} (take "
            "other units)"
        )


def _check_points(rows: Points) -> None:
    if not FEWEST <= len(rows) <= MOST:
        raise ValueError(
            f"points must be {FEWEST} to {MOST}, got {len(rows)} (measure more, or take means)"
        )
    if rows.shape[1] > 2:
        for row in np.flatnonzero(rows[:, 2] <= 0):
            raise ValueError(
                f"deviation must satisfy deviation > 0, got {rows[row, 2]:g} in row {row + 1} "
                "(leave the column out if it is not known)"
            )
    seen: dict[tuple[float, ...], int] = {}
    for number, point in enumerate(map(tuple, rows.tolist()), 1):
        if point in seen:
            raise ValueError(
                f"rows must be different, got row {number} the same as row {seen[point]} (leave "
                "one out; equal readings are one row with the deviation of their mean)"
            )
        seen[point] = number
    for name, column in zip(COLUMNS[:2], rows.T, strict=False):
        if not np.ptp(column):
            raise ValueError(
                f"{name} must vary, got {column[0]:g} in all rows (measure at several stretches)"
            )
    for name, column in zip(COLUMNS, rows.T, strict=False):
        _check_sizes(name, column)


def _check_order(rows: Points) -> None:
    """Refuse points in no order, and a loop."""
    turns = _turns(rows[:, 0])
    ends = [0, *turns, len(rows) - 1]
    if turns and len(rows) < FEWEST_OF_BRANCH * (len(turns) + 1):
        raise ValueError(
            f"stretch must rise or fall from row to row, got {len(turns)} turns in {len(rows)} "
            "rows (sort them by stretch, if the order says nothing)"
        )
    # a point at which it turns is the end of the branch before it
    pieces = [
        rows[start + (index > 0) : end + 1] for index, (start, end) in enumerate(pairwise(ends))
    ]
    branches: dict[bool, list[Points]] = {True: [], False: []}
    for piece, (start, end) in zip(pieces, pairwise(ends), strict=True):
        branches[bool(rows[end, 0] > rows[start, 0])].append(piece)
    if all(branches.values()):
        _check_loop(np.concatenate(branches[True]), np.concatenate(branches[False]), ends[1])


def _turns(stretch: Points) -> list[int]:
    """The rows at which the stretch turns back by more than noise."""
    least = TURN * float(np.ptp(stretch))
    found: list[int] = []
    lowest = highest = 0
    rising: bool | None = None
    for row, value in enumerate(stretch):
        lowest = row if value < stretch[lowest] else lowest
        highest = row if value > stretch[highest] else highest
        if rising is not True and value > stretch[lowest] + least:
            found += [] if rising is None else [lowest]
            rising, highest = True, row
        elif rising is not False and value < stretch[highest] - least:
            found += [] if rising is None else [highest]
            rising, lowest = False, row
    return found


def _check_loop(rising: Points, falling: Points, turn: int) -> None:
    """Refuse branches that are apart, where they are, by more than the noise."""
    rising = rising[np.argsort(rising[:, 0], kind="stable")]
    falling = falling[np.argsort(falling[:, 0], kind="stable")]
    common = falling[(falling[:, 0] >= rising[0, 0]) & (falling[:, 0] <= rising[-1, 0])]
    if len(common) < FEWEST:
        return
    apart = np.interp(common[:, 0], rising[:, 0], rising[:, 1]) - common[:, 1]
    if rising.shape[1] > 2:
        others = np.interp(common[:, 0], rising[:, 0], rising[:, 2])
        noise = float(np.sqrt(np.mean(common[:, 2] ** 2 + others**2)))
    else:
        noise = float(np.std(np.diff(apart)) / np.sqrt(2))
    force = np.concatenate([rising[:, 1], falling[:, 1]])
    width = float(abs(np.mean(apart)))
    allowed = noise * max(1.0, LOOP_DEVIATIONS / np.sqrt(len(common)))
    if width > max(allowed, LOOP_SHARE * float(np.ptp(force))):
        raise ValueError(
            f"loading and unloading must agree within the noise, {noise:.2g}, got them {width:.2g} "
            f"apart (a loop: fit one branch alone, such as rows 1 to {turn + 1})"
        )


def read_force(path: str | Path, units: str | None = None) -> ForceData:
    """The points of a file, or of the standard input for ``-``.

    With ``units`` of stretch and force, such as ``"mm,N"``, they are brought to metres and newtons.
    Raises ValueError, with the file and the line, for what is no such table; OSError where the
    file cannot be read.
    """
    length, force = (1.0, 1.0) if units is None else _factors(units)
    text = read_text(path, "force law", LARGEST)
    try:
        _check_header(text)
        columns = {name.lower(): column for name, column in table_columns(text).items()}
        given = (np.array(columns[name]) for name in COLUMNS if name in columns)
        return ForceData.of(*(c * f for c, f in zip(given, (length, force, force), strict=False)))
    except ValueError as error:
        raise ValueError(f"{shown_path(path)}: {error}") from None


def _check_header(text: str) -> None:
    """Refuse other lines in the place of the names of the columns, and say all that must change."""
    lines = text.rstrip().splitlines() or [""]
    place = next((p for p, line in enumerate(lines) if not line.startswith(COMMENT)), 0)
    names = column_names(lines[place])
    if place == 0 and {*COLUMNS[:2]} <= {name.lower() for name in names} <= {*COLUMNS}:
        return
    got = shown(",".join(names)) + (f" in line {place + 1}, below a comment" if place else "")
    remedies = ["leave out what stands above"] if place else []
    remedies.append("write stretch,force,deviation")
    if len(units := re.findall(rf"\(({_UNIT.pattern})\)", lines[place])) > 1:
        length, force = units[:2] if units[0].endswith(LENGTHS) else units[1::-1]
        remedies.append(f"state --units {length},{force}")
    raise ValueError(
        "line 1 must name the columns stretch, force and, if it is known, deviation, got "
        f"{got} ({', and '.join(remedies)})"
    )


_UNIT = re.compile(r"[A-Za-z\u00b5\u03bc]{1,30}")


def _factors(units: str) -> tuple[float, float]:
    """What a length and a force in these units are in metres and newtons."""
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


def _factor(registry: Any, unit: str, base: str) -> float:
    import pint

    try:
        return float(registry.Quantity(1.0, unit).to(base).magnitude)
    except pint.UndefinedUnitError:
        got = f"{unit}, which is no unit"
    except pint.DimensionalityError:
        got = f"{unit}, which cannot be brought to {base}"
    raise ValueError(f"--units must be a length and a force, got {got} (such as mm,N)")

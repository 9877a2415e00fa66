"""Sensor records of a chain: a CSV table of times, with a column for each sensor and quantity.

    time,displacement_0,velocity_7,displacement_0_deviation,velocity_7_deviation
    0.5,0.0312,-0.0021,0.001,0.002
    1.0,0.0588,0.0013,0.001,0.002

The name of a column is a quantity (displacement, velocity, strain, force) and a cell.  For several
fields or bonds the field's name or the bond's number, from 1, follows: ``velocity_7_v``,
``strain_7_2``.  Standard deviations are given for all columns or for none.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.sensitivities import Sensor
from longwave.scenes.description.bench import SENSOR_QUANTITIES
from longwave.scenes.description.csv_table import table_columns
from longwave.scenes.fits.force_data import MAX_FILE_BYTES
from longwave.scenes.starts.bench_chain import READINGS
from longwave.support.known_names import one_of
from longwave.support.real_arrays import Array, real_array
from longwave.support.user_files import read_text, shown, shown_path

DEVIATION_SUFFIX = "_deviation"

COLUMN_PATTERN = re.compile(
    rf"({'|'.join(SENSOR_QUANTITIES)})_(\d{{1,7}})(?:_([A-Za-z]+|\d{{1,3}}))?", re.ASCII
)


@dataclass(frozen=True)
class SensorRecord:
    """Readings (times, sensors) of one run; ``deviations`` is None if they are unknown.

    Raises ValueError for values that are not real numbers, and for wrong shapes.
    """

    times: Array
    sensors: tuple[Sensor, ...]
    values: Array
    deviations: Array | None

    def __post_init__(self) -> None:
        for name in ("times", "values", "deviations"):
            if (argument := getattr(self, name)) is None:
                continue
            array = real_array(f"every one of {name}", argument)
            shape = (np.size(self.times), len(self.sensors))[: 1 if name == "times" else 2]
            if array.shape != shape:
                raise ValueError(
                    f"{name} must have the shape {shape}, got {array.shape} (rows are times, "
                    "columns are sensors)"
                )
            object.__setattr__(self, name, array)


def read_record(
    path: str | Path, lattice: NumericLattice, cells: int, span: tuple[float, float]
) -> SensorRecord:
    """Read a sensor record from a CSV file, for a chain of ``cells`` cells.

    All times must lie within ``span``. Raises ValueError, with file and line, for
    an invalid table, and OSError if the file cannot be read.
    """
    text = read_text(path, "record of sensors", MAX_FILE_BYTES)
    try:
        columns = {name: np.array(column) for name, column in table_columns(text).items()}
        return _record(columns, lattice, cells, span)
    except ValueError as error:
        raise ValueError(f"{shown_path(path)}: {error}") from None


def _record(
    columns: Mapping[str, Array], lattice: NumericLattice, cells: int, span: tuple[float, float]
) -> SensorRecord:
    given = [name for name in columns if name.endswith(DEVIATION_SUFFIX)]
    names = [name for name in columns if name != "time" and name not in given]
    if "time" not in columns or not names:
        raise ValueError(
            "line 1 must name the column time and one for each sensor, got "
            f"{shown(','.join(columns))} (such as time,displacement_0,velocity_7)"
        )
    sensors = tuple(_sensor(name, lattice, cells) for name in names)
    if given and {*given} != {name + DEVIATION_SUFFIX for name in names}:
        raise ValueError(
            f"deviations must be given for all sensors or for none, got {', '.join(given)} for "
            f"{', '.join(names)} (the deviations of a column NAME are in NAME{DEVIATION_SUFFIX})"
        )
    _check_times(columns["time"], span)
    deviations = None
    if given:
        deviations = np.stack([columns[name + DEVIATION_SUFFIX] for name in names], axis=1)
        for row in np.flatnonzero((deviations <= 0.0).any(axis=1)):
            raise ValueError(
                f"deviations must be above 0, got {deviations[row].min():g} in line {row + 2} "
                "(leave the columns out if they are not known)"
            )
    values = np.stack([columns[name] for name in names], axis=1)
    return SensorRecord(columns["time"], sensors, values, deviations)


def _sensor(name: str, lattice: NumericLattice, cells: int) -> Sensor:
    match = COLUMN_PATTERN.fullmatch(name)
    if match is None:
        raise ValueError(
            f"columns must be time, or {', '.join(SENSOR_QUANTITIES)} with a cell, got "
            f"{shown(name)} (such as displacement_0)"
        )
    quantity, cell, inner = match[1], int(match[2]), match[3]
    if cell >= cells:
        raise ValueError(
            f"cell of {name} must be 0 to {cells - 1}, got {cell} (the chain has {cells} cells)"
        )
    known = lattice.fields
    if READINGS[quantity].dimensions == ("bond",):
        known = tuple(str(number) for number in range(1, len(lattice.bonds) + 1))
    if inner is not None and inner not in known:
        raise ValueError(
            f"sensor {name} must be on a field or bond of {lattice.name}, got {shown(inner)} "
            f"({one_of(inner, known)})"
        )
    return Sensor(quantity, known.index(inner) if inner else 0, cell)


def _check_times(times: Array, span: tuple[float, float]) -> None:
    for row in np.flatnonzero((times < span[0]) | (times > span[1])):
        raise ValueError(
            f"time must lie in the scene, {span[0]:g} to {span[1]:g}, got {times[row]:g} in line "
            f"{row + 2} (leave the line out, or let the scene end later)"
        )
    for row in np.flatnonzero(np.diff(times) <= 0.0):
        raise ValueError(
            f"time must rise from line to line, got {times[row + 1]:g} in line {row + 3} "
            "(sort them; put each run into its own file)"
        )

"""Coordinates of the dimensions that observables add, for a given half-width of compared sites."""

import math

import numpy as np
from numpy.typing import NDArray

MAP_CELLS = 256
"""Most cells of a space-time map."""


def cell_width(compared: int) -> int:
    """Sites in one cell of a space-time map.

    >>> cell_width(1500), cell_width(50)
    (12, 1)
    """
    return math.ceil((2 * compared + 1) / MAP_CELLS)


def axis_values(dimension: str, compared: int) -> tuple[NDArray[np.generic], dict[str, str]] | None:
    """Values and attributes of a dimension, None for one that is only counted."""
    count = 2 * compared + 1
    if dimension == "site":
        offsets = np.arange(-compared, compared + 1)
        return offsets, {"long_name": "offset from the site nearest c t"}
    if dimension == "wavenumber":
        values = 2.0 * np.pi * np.fft.rfftfreq(count)
        return values, {"units": "1/site"}
    if dimension == "map_site":
        starts = np.arange(-compared, compared + 1, cell_width(compared))
        return starts, {"long_name": "first site of the cell, from the site nearest c t"}
    return None

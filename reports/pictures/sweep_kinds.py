"""Names of the kinds of sweep pictures, and a test whether a data set is a sweep."""

from __future__ import annotations

from collections.abc import Mapping

from longwave.support.labelled_arrays import Labelled

VALUES, WORK_PRECISION, GROWTH_MAP = "values", "work_precision", "growth_map"
SWEEP_PICTURES = (VALUES, WORK_PRECISION, GROWTH_MAP)
"""Kinds of pictures of a sweep."""

Choice = Mapping[str, str | float]
"""Swept field -> the value that a cell must have to be drawn."""


def is_sweep(data: Labelled) -> bool:
    """Return whether a data set is the result of a sweep."""
    return "sweep" in data.attrs and "status" in data.variables

"""Names of the pictures of a sweep, and which data set is one: known before a sweep is drawn."""

from __future__ import annotations

from collections.abc import Mapping

from longwave.support.labelled_arrays import Labelled

VALUES, WORK_PRECISION, GROWTH_MAP = "values", "work_precision", "growth_map"
SWEEP_PICTURES = (VALUES, WORK_PRECISION, GROWTH_MAP)
"""The kinds of pictures of a sweep."""

Choice = Mapping[str, str | float]
"""Values of swept fields at which a sweep is drawn."""


def is_sweep(data: Labelled) -> bool:
    """Return whether a data set is the result of a sweep."""
    return "sweep" in data.attrs and "status" in data.variables

"""The error of a run over time, as pictures draw it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from longwave.support.labelled_arrays import Labelled

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ErrorCurve:
    """Relative sup errors at some times, and the run's ``own`` errors in the same units.

    ``own`` is NaN where it was not measured, and None where it is not drawn.
    """

    times: Array
    errors: Array
    own: Array | None = None

    @classmethod
    def of(cls, run: Labelled, name: str, own: Array | None = None) -> ErrorCurve:
        """Return the curve of the run's variable ``name`` over its dimension, which is a time."""
        variable = run.variables[name]
        (along,) = variable.dims
        return cls(run.variables[along].values, variable.values, own)

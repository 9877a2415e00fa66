"""Comparison of a run with its repetition from the same file, bit by bit.

Nothing that a run chooses depends on the speed of the machine: the search for step and domain uses
errors and counted work, and estimated seconds use constants. So the same code, packages and
processor give the same bits; `provenance` shows where these differ.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from longwave.support.provenance import PROVENANCE, changed_parts

if TYPE_CHECKING:
    import xarray as xr

TIMED = ("seconds", "planning_seconds")
"""Attributes with measured times, in which any two runs differ; they are not compared."""


@dataclass(frozen=True)
class RunComparison:
    """Differences between two runs of one scene, one line each; empty if they have the same bits.

    ``origins`` lists the differences of their code, packages and machines, ``values`` counts the
    compared numbers.
    """

    differences: tuple[str, ...]
    origins: tuple[str, ...]
    values: int

    @property
    def is_same(self) -> bool:
        """Whether all values and attributes are the same, bit by bit."""
        return not self.differences

    def lines(self) -> Iterator[str]:
        """Yield the result of the comparison as lines of text."""
        if self.is_same:
            yield f"same bits: all {self.values} values, and what was chosen and estimated"
        else:
            yield "other bits:"
            yield from (f"  {line}" for line in self.differences)
        yield from self.origins or ["code, packages and machine are the same"]


def compare_runs(stored: xr.Dataset, repeated: xr.Dataset) -> RunComparison:
    """Compare two runs of one scene, except for the time that they took."""
    names = [str(name) for name in dict.fromkeys((*stored.variables, *repeated.variables))]
    differences = [line for name in names if (line := _variable_line(name, stored, repeated))]
    attributes = dict.fromkeys((*stored.attrs, *repeated.attrs))
    for name in (name for name in attributes if name not in (*TIMED, *PROVENANCE)):
        old, new = (run.attrs.get(name, "nothing") for run in (stored, repeated))
        if repr(old) != repr(new):
            differences.append(f"{name}: {new}, was {old}")
    origins: list[str] = []
    for name in PROVENANCE:
        texts = (str(run.attrs.get(name, "")) for run in (stored, repeated))
        origins += changed_parts(name, *texts)
    count = sum(variable.size for variable in repeated.variables.values())
    return RunComparison(tuple(differences), tuple(origins), count)


def _variable_line(name: str, stored: xr.Dataset, repeated: xr.Dataset) -> str:
    """Return one line on how a variable differs between two runs; empty if it does not."""
    for run, word in ((stored, "is new"), (repeated, "is missing")):
        if name not in run.variables:
            return f"{name} {word}"
    old, new = (run.variables[name].values for run in (stored, repeated))
    if old.shape != new.shape or old.dtype != new.dtype:
        return f"{name}: {new.dtype} {new.shape}, was {old.dtype} {old.shape}"
    if old.tobytes() == new.tobytes():
        return ""
    return f"{name}: {_distance(old, new)}"


def _distance(old: NDArray[np.generic], new: NDArray[np.generic]) -> str:
    """Return a text on how many values of two arrays differ, and by how much at most."""
    size = old.dtype.itemsize
    bits = [np.ascontiguousarray(values).view(f"V{size}").ravel() for values in (old, new)]
    count = int(np.count_nonzero(bits[0] != bits[1]))
    line = f"{count} of {old.size} values differ"
    if old.dtype.kind not in "fc":
        return line
    with np.errstate(all="ignore"):
        distance = np.nanmax(np.abs(np.subtract(new, old)), initial=0.0)
        largest = np.nanmax(np.abs(old), initial=0.0)
    return f"{line}, by at most {distance:.2g} where they reach {largest:.2g}"

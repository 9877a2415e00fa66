"""A run made again from its own file, and whether it has the same bits.

Nothing that a run chooses depends on how fast the machine is: the search for its step and domain
goes by errors and counted work, and estimated seconds are of constants. So the same code, packages
and processor give the same bits; `provenance` says where those differ.
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
"""Attributes that no two runs share."""


@dataclass(frozen=True)
class Repetition:
    """What is not the same in two runs of a scene, one line each: nothing if they have the same
    bits. ``origins`` says what of their code, packages and machines differs."""

    differences: tuple[str, ...]
    origins: tuple[str, ...]
    values: int

    @property
    def is_same(self) -> bool:
        """Whether all values and all that was told of them are the same, bit by bit."""
        return not self.differences

    def lines(self) -> Iterator[str]:
        """What is to be told."""
        if self.is_same:
            yield f"same bits: all {self.values} values, and what was chosen and estimated"
        else:
            yield "other bits:"
            yield from (f"  {line}" for line in self.differences)
        yield from self.origins
        if not self.origins:
            yield "code, packages and machine are the same"


def compare_runs(kept: xr.Dataset, made: xr.Dataset) -> Repetition:
    """What differs in two runs of one scene, but for the time that they took."""
    names = [str(name) for name in dict.fromkeys((*kept.variables, *made.variables))]
    found = [line for name in names if (line := _variable_line(name, kept, made))]
    told = dict.fromkeys((*kept.attrs, *made.attrs))
    for name in (name for name in told if name not in (*TIMED, *PROVENANCE)):
        one, other = (run.attrs.get(name, "nothing") for run in (kept, made))
        if repr(one) != repr(other):
            found.append(f"{name}: {other}, was {one}")
    origins = tuple(
        line
        for name in PROVENANCE
        for line in changed_parts(name, *(str(run.attrs.get(name, "")) for run in (kept, made)))
    )
    return Repetition(tuple(found), origins, sum(v.size for v in made.variables.values()))


def _variable_line(name: str, kept: xr.Dataset, made: xr.Dataset) -> str:
    """How far a variable is from what it was; nothing if it is not."""
    for run, word in ((kept, "is new"), (made, "is missing")):
        if name not in run.variables:
            return f"{name} {word}"
    one, other = (run.variables[name].values for run in (kept, made))
    if one.shape != other.shape or one.dtype != other.dtype:
        return f"{name}: {other.dtype} {other.shape}, was {one.dtype} {one.shape}"
    if one.tobytes() == other.tobytes():
        return ""
    return f"{name}: {_distance(one, other)}"


def _distance(one: NDArray[np.generic], other: NDArray[np.generic]) -> str:
    """How many values differ, and by how much at most."""
    size = one.dtype.itemsize
    bits = [np.ascontiguousarray(values).view(f"V{size}").ravel() for values in (one, other)]
    count = int(np.count_nonzero(bits[0] != bits[1]))
    line = f"{count} of {one.size} values differ"
    if one.dtype.kind not in "fc":
        return line
    with np.errstate(all="ignore"):
        apart = np.nanmax(np.abs(np.subtract(other, one)), initial=0.0)
        largest = np.nanmax(np.abs(one), initial=0.0)
    return f"{line}, by at most {apart:.2g} where they reach {largest:.2g}"

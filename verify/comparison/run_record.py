"""What is recorded of a run, and what Ctrl-C leaves: arrays, until a data set is asked for."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from verify.comparison.observables import axis_values
from verify.comparison.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

Variables = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]
"""Name -> (dimensions, values, attributes)."""


PACKAGES = ("longwave", "numpy", "numba", "sympy", "xarray")


@dataclass
class RunRecord:
    """A run of ``scene`` as it was recorded: a `Dataset` before anyone needs one.

    ``reached`` are the snapshots that were got to; ``attrs`` is what was told of the run, its cost
    first, and may be added to until the data set is made.
    """

    scene: Scene
    reached: Sequence[float]
    variables: Variables
    attrs: dict[str, Any]

    def values(self, name: str) -> NDArray[Any]:
        """The values of a variable, in the order of its times."""
        return np.asarray(self.variables[name][1])

    @cached_property
    def dataset(self) -> "xr.Dataset":
        """The run with its coordinates, the scene and the versions."""
        from importlib.metadata import version

        import xarray as xr  # 0.4 s, for those who want a data set

        used = {name for dimensions, _, _ in self.variables.values() for name in dimensions}
        axes = {name: axis_values(name, self.scene.compared) for name in used}
        coordinates: dict[str, object] = {
            "time": ("time", list(self.reached), {"units": "lattice time"})
        }
        coordinates |= {name: (name, *axis) for name, axis in axes.items() if axis is not None}
        names = {name for name, (found, _, _) in self.variables.items() if found == (name,)}
        coordinates |= {name: self.variables[name] for name in names}
        data = {name: value for name, value in self.variables.items() if name not in names}
        attributes = {
            "scene": self.scene.json(),
            "title": self.scene.title or self.scene.name,
            **self.attrs,
            "versions": ", ".join(f"{package} {version(package)}" for package in PACKAGES),
        }
        return xr.Dataset(data, coordinates, attributes)


class UnfinishedRun(KeyboardInterrupt):
    """Ctrl-C during a run, which had recorded something: ``run``, and ``record`` before it.

    The run's attribute ``unfinished`` says why it is not what the scene asks for.
    """

    def __init__(self, record: RunRecord) -> None:
        super().__init__("interrupted")
        self.record = record

    @property
    def run(self) -> "xr.Dataset":
        """What was recorded."""
        return self.record.dataset


def unfinished(
    run: RunRecord | None, error: float | None, planning_seconds: float
) -> KeyboardInterrupt:
    """The best run of a search that Ctrl-C ended; ``error`` is its estimated one, if measured."""
    if run is None:
        return KeyboardInterrupt("before anything was recorded")
    run.attrs["planning_seconds"] = planning_seconds
    why = run.attrs.get("unfinished", "Ctrl-C before the tolerance was met")
    if error is None:
        run.attrs["unfinished"] = f"{why}, its error not estimated"
    else:
        run.attrs |= {"unfinished": why, "error_estimate": error}
    return UnfinishedRun(run)

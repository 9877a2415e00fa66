"""What a run returns: what was recorded, with the scene, the versions and the cost."""

from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version

import xarray as xr

from verify.lattice.observables import axis_values
from verify.lattice.recorder import Variables
from verify.lattice.scene import Scene

PACKAGES = ("longwave", "numpy", "numba", "sympy", "xarray")


def build_dataset(
    scene: Scene, reached: Sequence[float], variables: Variables, cost: Mapping[str, object]
) -> xr.Dataset:
    """The run of ``scene``; ``reached`` are the snapshots that were got to."""
    coordinates: dict[str, object] = {"time": ("time", list(reached), {"units": "lattice time"})}
    for dimension in {name for dimensions, _, _ in variables.values() for name in dimensions}:
        axis = axis_values(dimension, scene.compared)
        if axis is not None:
            coordinates[dimension] = (dimension, *axis)
    names = {name for name, (dimensions, _, _) in variables.items() if dimensions == (name,)}
    coordinates |= {name: variables[name] for name in names}
    data = {name: value for name, value in variables.items() if name not in names}
    attributes = {
        "scene": scene.json(),
        "title": scene.title or scene.name,
        **cost,
        "versions": _versions(),
    }
    return xr.Dataset(data, coordinates, attributes)


@cache
def _versions() -> str:
    """Those of the packages that a run's numbers depend on; each takes a file to be found."""
    return ", ".join(f"{package} {version(package)}" for package in PACKAGES)

"""What a run records. Each observable names its times and sees the state there, and only there."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from verify.lattice.comparison import Comparison
from verify.lattice.energy import ring_energy
from verify.lattice.scene import Scene

Variables = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]

STRAIN_UNIT = {"units": "strain (lattice units)"}
RELATIVE = {"units": "1", "long_name": "relative sup error against the bare background"}
RELATIVE_FAR = {"units": "1", "long_name": "relative sup error against the true far field"}


class Observable(Protocol):
    """Sees the comparison at its times; gives its variables at the end."""

    @property
    def times(self) -> Sequence[float]:
        """The increasing times at which it wants to see the state."""

    def see(self, comparison: Comparison) -> None:
        """Record the state at one of the times."""

    def variables(self) -> Variables:
        """Name -> (dimensions, values, attributes)."""


def curve_times(scene: Scene) -> tuple[float, ...]:
    """The error curve's times: equidistant ones and the snapshots."""
    equidistant = np.linspace(scene.t0, scene.end, scene.curve_points)
    return tuple(sorted({float(t) for t in equidistant} | set(scene.snapshots)))


class Errors:
    """The relative sup error at a list of times, with both denominators where they differ."""

    def __init__(self, times: Sequence[float], dimension: str, prefix: str) -> None:
        self.times = times
        self.dimension = dimension
        self.prefix = prefix
        self._seen: list[float] = []
        self._bare: list[float] = []
        self._far: list[float] = []

    def see(self, comparison: Comparison) -> None:
        """Record the errors at one time."""
        self._seen.append(comparison.state.t)
        self._bare.append(comparison.error)
        if comparison.has_far_field:
            self._far.append(comparison.error_far_field)

    def variables(self) -> Variables:
        """The errors, and their times unless they are the snapshots'."""
        result: Variables = {self.prefix: ((self.dimension,), self._bare, RELATIVE)}
        if self._far:
            result[f"{self.prefix}_far_field"] = ((self.dimension,), self._far, RELATIVE_FAR)
        if self.dimension != "time":
            result[self.dimension] = ((self.dimension,), self._seen, {"units": "lattice time"})
        return result


class StrainSnapshots:
    """Strains of run, wave and bare background at the snapshots, and the error there."""

    def __init__(self, scene: Scene) -> None:
        self.times = scene.snapshots
        self._errors = Errors(self.times, "time", "error")
        self._rows: dict[str, list[Any]] = {"strain": [], "analytic": [], "background": []}
        self._sites: list[Any] = []

    def see(self, comparison: Comparison) -> None:
        """Store the compared sites at one snapshot."""
        self._errors.see(comparison)
        self._sites.append(comparison.sites)
        self._rows["strain"].append(comparison.numeric)
        self._rows["analytic"].append(comparison.analytic)
        self._rows["background"].append(comparison.background)

    def variables(self) -> Variables:
        """Arrays of shape (time, site), and n, the site's number on the lattice."""
        if not self._sites:
            return {}
        rows: Variables = {
            name: (("time", "site"), np.array(values), STRAIN_UNIT)
            for name, values in self._rows.items()
        }
        rows["n"] = (("time", "site"), np.array(self._sites), {"long_name": "site on the lattice"})
        return rows | self._errors.variables()


class Energy:
    """The energy of the ring at the times of the error curve."""

    def __init__(self, scene: Scene) -> None:
        self.times = curve_times(scene)
        self._values: list[float] = []

    def see(self, comparison: Comparison) -> None:
        """Sum the energy at one time."""
        self._values.append(ring_energy(comparison.state, comparison.scene.constants))

    def variables(self) -> Variables:
        """The energies and their times."""
        return {
            "energy": (("energy_time",), self._values, {"units": "lattice energy"}),
            "energy_time": (("energy_time",), list(self.times[: len(self._values)]), {}),
        }


def build_observables(scene: Scene) -> list[Observable]:
    """The observables that the scene asks for, those that re-run it apart."""
    found: list[Observable] = []
    if "strain" in scene.observables:
        found.append(StrainSnapshots(scene))
    if "error_curve" in scene.observables:
        found.append(Errors(curve_times(scene), "curve_time", "error_curve"))
    if "energy" in scene.observables:
        found.append(Energy(scene))
    return found

"""The observables that a scene may ask for, as a table; each is computed only if it is asked for.

Adding one is one function in `measures.py` and one entry here: what it computes, when it looks,
what it adds and what it needs.

>>> from verify.comparison.observables import observable_named
>>> [variable.name for variable in observable_named("momentum").variables]
['mean_strain', 'mean_velocity']
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from verify.comparison.measures import (
    background_difference,
    cell_width,
    crest_track,
    energy,
    error_curve,
    error_split,
    momentum,
    space_time,
    spectrum,
    strain,
    whole_state,
)
from verify.comparison.view import View

Moment = Literal["snapshots", "curve", "looks", "refinement"]

TIME_DIMENSION: Mapping[Moment, str] = {
    "snapshots": "time",
    "curve": "curve_time",
    "looks": "look_time",
    "refinement": "time",
}
"""The time dimension of what is seen at each kind of moment.

``snapshots`` and ``curve`` times are hit exactly, and the steps are fitted to them. ``looks`` are
taken where the run stops anyway, so they change no step. A ``refinement`` runs the scene again.
"""

Measure = Callable[[View], Mapping[str, Any]]


@dataclass(frozen=True)
class Variable:
    """One array that an observable adds; ``dimensions`` are those after the time."""

    name: str
    dimensions: tuple[str, ...] = ()
    units: str = "1"
    long_name: str = ""
    optional: bool = False

    @property
    def attributes(self) -> dict[str, str]:
        """Attributes of the array in the run."""
        return {"units": self.units} | ({"long_name": self.long_name} if self.long_name else {})


@dataclass(frozen=True)
class Observable:
    """One observable.

    ``measure`` maps a view to the values of ``variables`` at one moment; optional variables may be
    missing from all moments of a run. ``uses_wave`` says that the closed form is evaluated,
    ``needs_ring`` that the sites must form a ring, ``all_sites`` that others than the compared ones
    are looked at.
    """

    name: str
    what: str
    seen: Moment
    variables: tuple[Variable, ...]
    measure: Measure
    uses_wave: bool = False
    needs_ring: bool = False
    all_sites: bool = False


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


STRAIN, PER_TIME, SITES = "strain (lattice units)", "strain per lattice time", "sites"
RELATIVE = "relative sup error against the bare background"
RELATIVE_FAR = "relative sup error against the true far field"
REFINED = "sup difference to the refined run"


def _nothing(_: View) -> Mapping[str, Any]:
    """A refinement is measured by a second run, not by looking at the first."""
    return {}


OBSERVABLES = (
    Observable(
        name="strain",
        what="strains of run, wave and background at the snapshots, and the error there",
        seen="snapshots",
        variables=(
            Variable("strain", ("site",), STRAIN),
            Variable("analytic", ("site",), STRAIN),
            Variable("background", ("site",), STRAIN),
            Variable("n", ("site",), long_name="site on the lattice"),
            Variable("error", long_name=RELATIVE),
            Variable("error_far_field", long_name=RELATIVE_FAR, optional=True),
        ),
        measure=strain,
        uses_wave=True,
    ),
    Observable(
        name="error_curve",
        what="the relative sup error against time",
        seen="curve",
        variables=(
            Variable("error_curve", long_name=RELATIVE),
            Variable("error_curve_far_field", long_name=RELATIVE_FAR, optional=True),
        ),
        measure=error_curve,
        uses_wave=True,
    ),
    Observable(
        name="energy",
        what="kinetic and potential energy of the ring against time",
        seen="looks",
        variables=(Variable("energy", units="lattice energy"),),
        measure=energy,
        needs_ring=True,
        all_sites=True,
    ),
    Observable(
        name="momentum",
        what="mean strain and mean velocity of the ring against time",
        seen="looks",
        variables=(
            Variable("mean_strain", units=STRAIN),
            Variable("mean_velocity", units=PER_TIME, long_name="conserved by the exact flow"),
        ),
        measure=momentum,
        needs_ring=True,
        all_sites=True,
    ),
    Observable(
        name="spectrum",
        what="Fourier amplitudes of the compared strains at the snapshots",
        seen="snapshots",
        variables=(Variable("spectrum", ("wavenumber",), STRAIN),),
        measure=spectrum,
    ),
    Observable(
        name="crest_track",
        what="position and strain of the crest against time",
        seen="looks",
        variables=(
            Variable("crest_position", units=SITES, long_name="position of the crest less c t"),
            Variable("crest_strain", units=STRAIN),
        ),
        measure=crest_track,
    ),
    Observable(
        name="space_time",
        what="a map of the strain over time and cells of sites",
        seen="looks",
        variables=(Variable("space_time", ("map_site",), STRAIN),),
        measure=space_time,
    ),
    Observable(
        name="background_difference",
        what="strain of the run less the bare background at the snapshots",
        seen="snapshots",
        variables=(Variable("background_difference", ("site",), STRAIN),),
        measure=background_difference,
        uses_wave=True,
    ),
    Observable(
        name="error_split",
        what="the error at the snapshots as shift in position, amplitude and shape",
        seen="snapshots",
        variables=(
            Variable("shift", units=SITES, long_name="fitted shift of the run"),
            Variable("scale", long_name="fitted amplitude over the wave's"),
            Variable("error_position", long_name="relative sup of the shift's part"),
            Variable("error_amplitude", long_name="relative sup of the amplitude's part"),
            Variable("error_shape", long_name="relative sup of what is left"),
        ),
        measure=error_split,
        uses_wave=True,
    ),
    Observable(
        name="state",
        what="strains and velocities of all computed sites at the snapshots, for a restart",
        seen="snapshots",
        variables=(
            Variable("state_y", ("cell",), STRAIN),
            Variable("state_s", ("cell",), PER_TIME),
            Variable("state_left", long_name="leftmost site held"),
        ),
        measure=whole_state,
        all_sites=True,
    ),
    Observable(
        name="time_step_error",
        what="largest difference of y/eps to the run with half the step",
        seen="refinement",
        variables=(Variable("time_step_error", units="strain / eps", long_name=REFINED),),
        measure=_nothing,
    ),
    Observable(
        name="domain_error",
        what="largest difference of y/eps to the run with twice the sites",
        seen="refinement",
        variables=(Variable("domain_error", units="strain / eps", long_name=REFINED),),
        measure=_nothing,
    ),
)

NAMES = tuple(entry.name for entry in OBSERVABLES)


def observable_named(name: str) -> Observable:
    """The entry of that name; ValueError lists the known ones.

    >>> observable_named("colour")
    Traceback (most recent call last):
    ...
    ValueError: observables must be known ones, got 'colour' (one of strain, ..., domain_error)
    """
    for entry in OBSERVABLES:
        if entry.name == name:
            return entry
    raise ValueError(f"observables must be known ones, got {name!r} (one of {', '.join(NAMES)})")

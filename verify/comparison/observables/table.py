"""The observables that a scene may ask for. Adding one is one function and one entry here."""

from collections.abc import Mapping
from typing import Any

from verify.comparison.observables.entry import Entry, Variable, View
from verify.comparison.observables.measures import (
    background_difference,
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

STRAIN, PER_TIME, SITES = "strain (lattice units)", "strain per lattice time", "sites"
RELATIVE = "relative sup error against the bare background"
RELATIVE_FAR = "relative sup error against the true far field"
REFINED = "sup difference to the refined run"


def _nothing(_: View) -> Mapping[str, Any]:
    """A refinement is measured by a second run, not by looking at the first."""
    return {}


ENTRIES = (
    Entry(
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
    Entry(
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
    Entry(
        name="energy",
        what="kinetic and potential energy of the ring against time",
        seen="looks",
        variables=(Variable("energy", units="lattice energy"),),
        measure=energy,
        needs_ring=True,
        all_sites=True,
    ),
    Entry(
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
    Entry(
        name="spectrum",
        what="Fourier amplitudes of the compared strains at the snapshots",
        seen="snapshots",
        variables=(Variable("spectrum", ("wavenumber",), STRAIN),),
        measure=spectrum,
    ),
    Entry(
        name="crest_track",
        what="position and strain of the crest against time",
        seen="looks",
        variables=(
            Variable("crest_position", units=SITES, long_name="position of the crest less c t"),
            Variable("crest_strain", units=STRAIN),
        ),
        measure=crest_track,
    ),
    Entry(
        name="space_time",
        what="a map of the strain over time and cells of sites",
        seen="looks",
        variables=(Variable("space_time", ("map_site",), STRAIN),),
        measure=space_time,
    ),
    Entry(
        name="background_difference",
        what="strain of the run less the bare background at the snapshots",
        seen="snapshots",
        variables=(Variable("background_difference", ("site",), STRAIN),),
        measure=background_difference,
        uses_wave=True,
    ),
    Entry(
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
    Entry(
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
    Entry(
        name="time_step_error",
        what="largest difference of y/eps to the run with half the step",
        seen="refinement",
        variables=(Variable("time_step_error", units="strain / eps", long_name=REFINED),),
        measure=_nothing,
    ),
    Entry(
        name="domain_error",
        what="largest difference of y/eps to the run with twice the sites",
        seen="refinement",
        variables=(Variable("domain_error", units="strain / eps", long_name=REFINED),),
        measure=_nothing,
    ),
)

NAMES = tuple(entry.name for entry in ENTRIES)


def entry_named(name: str) -> Entry:
    """The entry of that name; ValueError lists the known ones.

    >>> entry_named("colour")
    Traceback (most recent call last):
    ...
    ValueError: observables must be known ones, got 'colour' (one of strain, ..., domain_error)
    """
    for entry in ENTRIES:
        if entry.name == name:
            return entry
    raise ValueError(f"observables must be known ones, got {name!r} (one of {', '.join(NAMES)})")

"""An observable as data: what it computes, when it looks, what it adds and what it needs.

Coordinates of the dimensions that observables add, for a given half-width of compared sites.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from lattice.model import Model
from lattice.state import Sites, State

Array = NDArray[np.float64]
Moment = Literal["snapshots", "curve", "looks", "refinement"]

TIME_DIMENSION: Mapping[Moment, str] = {
    "snapshots": "time",
    "curve": "curve_time",
    "looks": "look_time",
    "refinement": "time",
}
"""The time dimension of what is seen at each kind of moment.

``snapshots`` and ``curve`` times are hit exactly, and the steps are fitted to them. ``looks`` are
taken where the march stops anyway, so they change no step. A ``refinement`` runs the scene again.
"""


class View(Protocol):
    """What an observable may look at; each part is made when it is first used."""

    @property
    def state(self) -> State:
        """All sites that are computed."""

    @property
    def constants(self) -> Model:
        """The lattice constants."""

    @property
    def level(self) -> float:
        """Strain of the constant background, 0 on a periodic one."""

    @property
    def sites(self) -> Sites:
        """The compared sites."""

    @property
    def numeric(self) -> Array:
        """Strains of the run on the compared sites."""

    @property
    def analytic(self) -> Array:
        """Strains of the wave there."""

    @property
    def background(self) -> Array:
        """Strains of the bare wave of the same phase there."""

    @property
    def has_far_field(self) -> bool:
        """Whether the true far field gives a second denominator."""

    @property
    def error(self) -> float:
        """Relative sup error against the bare background."""

    @property
    def error_far_field(self) -> float:
        """Relative sup error against the true far field."""

    def displaced(self, shift: float) -> tuple[Array, Array, Array, Array]:
        """Wave, background and their slopes at n - ``shift``, n the compared sites (strains)."""


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
class Entry:
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


MAP_CELLS = 256
"""Most cells of a space-time map."""


def cell_width(compared: int) -> int:
    """Sites in one cell of a space-time map.

    >>> cell_width(1500), cell_width(50)
    (12, 1)
    """
    return math.ceil((2 * compared + 1) / MAP_CELLS)


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

"""A run that a search has done: what was chosen about it, and what it gave."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NUDGE = 2.0**-51
"""Relative change of the data's last digits."""


@dataclass(frozen=True)
class Choices:
    """All numerical choices of a run.

    ``step`` in time; ``size`` of the domain in sites; ``causal`` if no signal from its ends reaches
    a compared site in time; ``density`` in points per site, or more if the spectrum calls for more,
    and of either ``finer`` times as many; ``shift`` of the domain's middle, in its sizes;
    ``absorber`` is the strength of one at the seam, 0 if there is none; ``start`` the
    step at first, until what the data send to the left has left the wave, 0 if there is none.
    ``nudged`` if the last digits of the data are changed, by ``NUDGE``.
    """

    step: float
    size: float
    causal: bool = False
    density: float = 1.0
    finer: float = 1.0
    shift: float = 0.0
    absorber: float = 0.0
    start: float = 0.0
    nudged: bool = False


@dataclass(frozen=True)
class Trial:
    """A finished run: ``values`` of y/eps on the compared sites at all times that are looked at.

    They are None after a blow-up. ``rounding`` estimates what rounding has done to them, ``alike``
    bounds what a run with a shorter step would not show, for it does the same. ``payload`` is the
    engine's own. ``shown`` if the observables can be asked for. An unfinished run holds the times
    before it was stopped.
    """

    choices: Choices
    values: Array | None
    work: float
    seconds: float
    rounding: float
    payload: Any
    shown: bool = True
    alike: float = 0.0


class StoppedTrial(KeyboardInterrupt):
    """Ctrl-C during a run: what there is of it."""

    def __init__(self, trial: Trial) -> None:
        super().__init__("interrupted")
        self.trial = trial


def difference(one: Trial, other: Trial) -> float:
    """Largest difference of y/eps between two runs; infinite if either blew up."""
    if one.values is None or other.values is None:
        return math.inf
    with np.errstate(invalid="ignore", over="ignore"):
        found = float(np.max(np.abs(one.values - other.values)))
    return found if math.isfinite(found) else math.inf

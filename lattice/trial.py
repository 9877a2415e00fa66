"""A run whose error is to be judged: what was chosen about it, what it gave, what rounding did.

Values and errors are of y in the unit of the tolerance, sup over the compared sites.
"""

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


ROUNDING = 4.0 * 2.0**-53
"""What one evaluation adds to a unit strain: a few roundings, of signs that vary."""

STEADY = 2.0**-53
"""The part whose sign does not vary (measured: 0.4 of it, on a kink's far field at t = 2e8)."""


@dataclass(frozen=True)
class Estimate:
    """By how much y/eps is estimated to miss the infinite lattice's, at most.

    ``total`` stands for everything that was chosen, and for rounding, whose part is ``rounding``.
    ``next_decade`` is the factor by which ten times more accuracy costs more.
    """

    total: float
    rounding: float
    next_decade: float


def rounding_error(largest: float, evaluations: int) -> float:
    """What rounding is taken to do to strains of that size in so many force evaluations a site.

    Where nothing moves, it is the same every time and adds up.

    >>> rounding_error(5.0, 10_000) < 1e-11
    True
    """
    return largest * (ROUNDING * math.sqrt(1.0 + evaluations) + STEADY * evaluations)


def clock_error(values: NDArray[np.float64], c: float, times: tuple[float, float]) -> float:
    """What two roundings of the time do to ``values``, of neighbouring sites, which move at c.

    Far from t = 0 a time stands for its unit in the last place, in which the wave goes on.

    >>> f"{clock_error(np.array([[0.0, 1.0]]), 1.0, (2.0**28, 2.0**28 + 1)):.2g}"
    '1.2e-07'
    """
    slope = float(np.max(np.abs(np.diff(values, axis=-1)), initial=0.0))
    return 2.0 * float(np.spacing(max(map(abs, times)))) * c * slope

"""The error of the reduction itself: Y_j at its peak against eps, from one slow time on."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from verify.comparison import Scene, rational_family_scenes, run
from verify.studies.cost_scaling import PowerLaw, ScalingPoint, fit_law

HALF_WIDTH = 25.0
"""Half-width compared, in X: all extrema of Y_2 .. Y_5 from the family's first slow time on."""

PEAK_TOLERANCES = {2: 1e-4, 3: 2e-4, 4: 1e-3, 5: 2e-3}
"""Sup error of y/eps allowed, by order: the higher the order, the larger the error to be shown."""

RESOLVED = 0.1
"""Most of a value that its discretisation error may be."""

FITTED_PEAKS = 3
"""Points at the small-eps end through which the law is fitted."""


@dataclass(frozen=True)
class PeakError:
    """The relative sup error of one member of the family at T = 0.

    ``own`` is the estimated discretisation error over the same denominator, ``seconds`` the run
    with its planning. ``fault`` tells why there is no value, if there is none.
    """

    order: int
    eps: float
    value: float = math.nan
    own: float = math.nan
    seconds: float = math.nan
    engine: str = ""
    fault: str = ""

    @property
    def resolved(self) -> bool:
        """Whether the value is the reduction's and not the discretisation's.

        >>> PeakError(2, 0.1, 0.35, 1e-4).resolved, PeakError(2, 0.1, fault="blow-up").resolved
        (True, False)
        """
        return self.own <= RESOLVED * self.value


def peak_scene(order: int, eps: float) -> Scene:
    """The member of the family up to its peak, by whichever engine is cheaper."""
    (scene,) = rational_family_scenes((order,), (eps,), PEAK_TOLERANCES[order]).values()
    return replace(scene, snapshots=(0.0,), compared=round(HALF_WIDTH / eps))


def peak_error(order: int, eps: float) -> PeakError:
    """Run one member; a run that does not come to its end is a record, too."""
    scene = peak_scene(order, eps)
    try:
        found = run(scene)
    except ValueError as error:
        return PeakError(order, eps, fault=str(error))
    seconds = float(found.attrs["seconds"] + found.attrs["planning_seconds"])
    engine, fault = str(found.attrs["engine"]), str(found.attrs["blow_up"])
    if fault:
        return PeakError(order, eps, seconds=seconds, engine=engine, fault=fault)
    height = float(np.max(np.abs(found["analytic"] - found["background"]))) / eps
    own = float(found.attrs["error_estimate"]) / height
    return PeakError(order, eps, float(found["error"][-1]), own, seconds, engine)


def peak_laws(points: Iterable[PeakError]) -> dict[int, PowerLaw | None]:
    """For each order the power of eps through its smallest resolved eps; None below two points."""
    orders: dict[int, list[PeakError]] = {}
    for point in points:
        orders.setdefault(point.order, []).append(point)
    return {order: _law(found) for order, found in sorted(orders.items())}


def _law(points: Sequence[PeakError]) -> PowerLaw | None:
    sound = sorted((point for point in points if point.resolved), key=lambda point: point.eps)
    if len(sound) < 2:
        return None
    return fit_law([ScalingPoint(f"Y_{p.order}", p.eps, p.value) for p in sound[:FITTED_PEAKS]])

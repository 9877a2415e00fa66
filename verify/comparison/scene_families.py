"""Families of scenes: the rational solutions over one slow-time range, for many eps."""

from collections.abc import Sequence

from verify.comparison.scene import Scene

ORDERS = (2, 3, 4, 5)
EPS = (0.1, 0.05, 0.025, 0.0125, 0.00625)

SLOW_START = -1.25
"""T = eps^3 t at the beginning: t = -10000 at eps = 0.05, as in the paper's scene."""

SLOW_SNAPSHOTS = (-0.625, 0.0, 0.625)
"""Slow times of the snapshots: those of the paper's scene."""

HALF_WIDTH = 75.0
"""Half-width of the compared region in X, 1500 sites at eps = 0.05."""


def rational_family_scenes(
    orders: Sequence[int] = ORDERS, eps: Sequence[float] = EPS, tolerance: float = 1e-4
) -> dict[str, Scene]:
    """The scenes Y_j at each eps by name, same slow times and same range of X.

    >>> scene = rational_family_scenes()["Y5_eps_0.025"]
    >>> scene.wave, scene.t0, scene.compared
    ('rational_5', -80000.0, 3000)
    """
    scenes = [_member(order, value, tolerance) for order in orders for value in eps]
    return {scene.name: scene for scene in scenes}


def _member(order: int, eps: float, tolerance: float) -> Scene:
    return Scene(
        name=f"Y{order}_eps_{eps:g}",
        title=f"Rational solution of order {order}, eps = {eps:g}",
        wave=f"rational_{order}",
        eps=eps,
        t0=_time(SLOW_START, eps),
        snapshots=tuple(_time(T, eps) for T in SLOW_SNAPSHOTS),
        K2=4.0,
        K4=1.0,
        compared=round(HALF_WIDTH / eps),
        tolerance=tolerance,
        observables=("strain",),
    )


def _time(T: float, eps: float) -> float:
    """The lattice time of a slow time, rounded to whole units."""
    return float(round(T / eps**3))

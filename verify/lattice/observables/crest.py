"""The crest: where the strain is farthest from its background."""

from collections.abc import Mapping

import numpy as np

from verify.lattice.observables.axes import cell_width
from verify.lattice.observables.entry import Array, View

NEWTON_STEPS = 4


def crest_track(view: View) -> Mapping[str, float]:
    """Position of the crest relative to c t, and its strain, interpolated between the sites."""
    deviation = view.numeric - view.level
    top = int(np.argmax(np.abs(deviation)))
    offset, height = 0.0, float(deviation[top])
    if 2 <= top < deviation.size - 2:
        offset, height = extremum(deviation[top - 2 : top + 3])
    travelled = view.constants.sound_speed() * view.state.t
    return {
        "crest_position": float(view.sites[top]) + offset - travelled,
        "crest_strain": height + view.level,
    }


def extremum(f: Array) -> tuple[float, float]:
    """Place and value of the extremum of the quartic through five values at -2 .. 2.

    The middle one is the largest in modulus; Newton starts from the parabola through the three
    innermost.

    >>> x = np.arange(-2.0, 3.0) - 0.3
    >>> place, value = extremum(5.0 - x**2 + 0.01 * x**4)
    >>> round(place, 12), round(value, 12)
    (0.3, 5.0)
    """
    c1 = (f[0] - 8.0 * f[1] + 8.0 * f[3] - f[4]) / 12.0
    c2 = (-f[0] + 16.0 * f[1] - 30.0 * f[2] + 16.0 * f[3] - f[4]) / 24.0
    c3 = (-f[0] + 2.0 * f[1] - 2.0 * f[3] + f[4]) / 12.0
    c4 = (f[0] - 4.0 * f[1] + 6.0 * f[2] - 4.0 * f[3] + f[4]) / 24.0
    bend = f[1] - 2.0 * f[2] + f[3]
    x = 0.5 * (f[1] - f[3]) / bend if bend != 0.0 else 0.0
    for _ in range(NEWTON_STEPS):
        curvature = 2.0 * c2 + x * (6.0 * c3 + 12.0 * c4 * x)
        if curvature == 0.0:
            break
        x -= (c1 + x * (2.0 * c2 + x * (3.0 * c3 + 4.0 * c4 * x))) / curvature
    if not abs(x) <= 1.0:
        return 0.0, float(f[2])
    return float(x), float(f[2] + x * (c1 + x * (c2 + x * (c3 + c4 * x))))


def space_time(view: View) -> Mapping[str, Array]:
    """The strain farthest from the background in each cell of sites: no crest is lost."""
    starts = np.arange(0, view.numeric.size, cell_width((view.numeric.size - 1) // 2))
    high = np.maximum.reduceat(view.numeric, starts)
    low = np.minimum.reduceat(view.numeric, starts)
    return {"space_time": np.where(high + low >= 2.0 * view.level, high, low)}

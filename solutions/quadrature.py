"""The integral of a function between many points, by Gauss-Legendre rules in panels."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NODES = 16
PRECISE = 1e-13
"""Largest error of a panel, in units of the integral of the absolute value over all panels."""

HALVINGS = 12
MOST_PANELS = 2_000_000


def integral_from_zero(function: Callable[[Array], Array], points: Array, width: float) -> Array:
    """The integrals of ``function`` from 0 to each of ``points``, real or complex.

    No panel is wider than ``width``, over which the function must not hide anything; a panel that
    its two halves do not confirm is halved. Raises ValueError for points that are too far apart
    for that, and where halving does not end.

    >>> integral_from_zero(np.cos, np.array([0.5, -1.0]), 1.0) - np.sin([0.5, -1.0])
    array([..., ...])
    """
    places, back = np.unique(np.append(0.0, points.ravel()), return_inverse=True)
    gaps = np.diff(places)
    needed = np.maximum(np.ceil(gaps / width), 1.0)
    if not needed.sum() <= MOST_PANELS:
        raise ValueError(
            f"points must span at most {MOST_PANELS * width:g}, got {places[-1] - places[0]:g} "
            "(integrate between nearer ones)"
        )
    counts = needed.astype(np.int64)
    first = np.repeat(np.cumsum(counts) - counts, counts)
    step = np.repeat(gaps / counts, counts)
    left = np.repeat(places[:-1], counts) + (np.arange(counts.sum()) - first) * step
    panels = _panel_integrals(function, left, step)
    ends = np.concatenate([[0.0], np.cumsum(panels)])[np.append(0, np.cumsum(counts))]
    origin = int(np.searchsorted(places, 0.0))
    return (ends - ends[origin])[back[1:]].reshape(points.shape)


def _panel_integrals(function: Callable[[Array], Array], left: Array, step: Array) -> Array:
    """The integral over each panel, halved until both halves give the same."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)

    def over(start: Array, width: Array) -> tuple[Array, float]:
        at = start[:, None] + width[:, None] * (0.5 + 0.5 * nodes)
        values = function(at.ravel()).reshape(at.shape)
        size = float(np.sum(np.abs(values) @ weights * width) / 2)
        return values @ weights * width / 2, size

    found, size = over(left, step)
    owner = np.arange(left.size)
    total = np.zeros_like(found)
    for _ in range(HALVINGS):
        halves = np.concatenate([left, left + step / 2]), np.concatenate([step, step]) / 2
        parts, _ = over(*halves)
        both = parts[: left.size] + parts[left.size :]
        right = np.abs(both - found) <= PRECISE * size
        np.add.at(total, owner[right], both[right])
        if right.all():
            return total
        wrong = np.tile(~right, 2)
        left, step, found = halves[0][wrong], halves[1][wrong], parts[wrong]
        owner = np.tile(owner, 2)[wrong]
    raise ValueError(
        f"panels must be confirmed after {HALVINGS} halvings, got {left.size} that are not, the "
        f"first at {left[0]:g} (the function is not smooth there)"
    )

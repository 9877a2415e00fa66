"""What the lattice site by site can be given: scheme, steps, windows and rings."""

import math
from collections.abc import Sequence

import numpy as np

from solutions import Wave
from verify.lattice.domain import (
    Array,
    creeping,
    least_ring,
    least_window,
    seam_room,
    window_moves,
)
from verify.lattice.extent import Extent, find_extent
from verify.lattice.moments import moments_of
from verify.lattice.observables import entry_named
from verify.lattice.scene import Scene
from verify.lattice.scheme import Scheme
from verify.lattice.stability import stability_limit
from verify.lattice.trust import TOLERANCE

PREFERRED = "reduced_phase_6"
"""Fewest force evaluations for sup errors from 1e-2 to 1e-9 of those in the table."""

LIMIT_SHARE = 0.9
"""Longest step tried, in units of the stability limit at the largest strain of the wave."""

LANES = 64
"""Sizes are multiples of this, which suits the kernels."""

SEEN = 16
"""Moves of a window at which runs are compared, beside the times that are asked for."""


def extent_of(scene: Scene, wave: Wave) -> Extent:
    """The sites that hold the scene's wave and its compared sites at all times."""
    times = (scene.t0, *scene.snapshots)
    tolerance = scene.tolerance or TOLERANCE
    return find_extent(scene.constants, wave, scene.eps, times, scene.compared, tolerance)


def domain_kind(scene: Scene, wave: Wave) -> str:
    """A window on a constant background, unless something asked for needs a ring."""
    needs_ring = any(entry_named(name).needs_ring for name in scene.observables)
    return "ring" if needs_ring or wave.constant_background is None else "window"


def longest_step(scene: Scene, scheme: Scheme, extent: Extent) -> float:
    """A step that is stable about the wave's largest strain."""
    limit = stability_limit(scheme) / scene.constants.highest_frequency(extent.strain)
    return LIMIT_SHARE * limit


def least_sites(scene: Scene, wave: Wave, domain: str, extent: Extent) -> int:
    """Fewest sites that hold the wave and the compared sites, in a multiple that suits kernels.

    A window's also keep off the rear's signals, which are faster than it on some backgrounds.
    """
    if domain == "ring":
        return round_up(least_ring(scene, extent.strain) + seam_room(wave, scene.eps))
    return round_up(least_window(extent.reach + creeping(scene, wave)))


def round_up(sites: float) -> int:
    """The next multiple of ``LANES``."""
    return LANES * math.ceil(sites / LANES)


def exact_times(scene: Scene) -> tuple[float, ...]:
    """The times that the scene's observables want exactly."""
    entries = map(entry_named, scene.observables)
    times = {t for entry in entries for t in moments_of(scene, entry.seen).times}
    return tuple(sorted(times.union(scene.snapshots)))


def judged_times(scene: Scene, exact: Sequence[float], domain: str) -> tuple[float, ...]:
    """The exact times and, in a window, some of the stops that its moves make anyway."""
    if domain == "ring":
        return tuple(exact)
    moves = [t for t in window_moves(scene) if t < scene.end]
    return tuple(sorted({*moves[:: max(1, len(moves) // SEEN)], *exact}))


def mean_step(stops: Array, step: float, order: int) -> float:
    """The step that would make the same error if the stops did not shorten it.

    Between two stops the steps are equal and at most ``step``.

    >>> mean_step(np.array([0.0, 1.0, 2.0]), 0.9, 6)
    0.5
    """
    gaps = np.diff(stops)
    gaps = gaps[gaps > 0]
    if gaps.size == 0:
        return step
    taken = gaps / np.ceil(gaps / step * (1.0 - 1e-12))
    return float(np.average((taken / step) ** order, weights=gaps) ** (1.0 / order) * step)


def shorter_step(stops: Array, step: float, order: int, ratio: float) -> float:
    """A step whose error falls as that of ``ratio`` times the step, whatever the stops."""
    wanted = ratio * mean_step(stops, step, order)
    found = ratio * step
    while mean_step(stops, found, order) > wanted:
        found *= 0.97
    return found

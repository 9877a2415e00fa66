"""Scheme, step and domain for a tolerance, chosen by pilot runs on the crest.

Time step: the errors of a scheme of order p at two steps differ by the factor ratio^p, so the
difference of two pilots tells both. Domain: the part of a window's error that comes from its finite
size falls at least like N^-5 on a constant background, so the run itself, being wider than its
pilots, tells by its difference from them; it is repeated in a wider window if that is too much. A
ring is wide enough that its seam is not felt. A window moves at times that do not depend on the
step, so its error cancels where steps are compared, and pilots may run in the smallest one. Each
estimate carries the factor ``SAFETY``.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.lattice.cost import CostModel
from verify.lattice.domain import MARGIN, least_ring, least_window
from verify.lattice.estimate import fitted_cost, richardson
from verify.lattice.extent import Extent, extent_of
from verify.lattice.observables import entry_named
from verify.lattice.pilot import Pilots
from verify.lattice.recording import Progress
from verify.lattice.scene import Scene
from verify.lattice.scheme import Scheme
from verify.lattice.schemes import scheme_named
from verify.lattice.stability import stability_limit

Array = NDArray[np.float64]

PREFERRED = "reduced_phase_6"
"""Fewest force evaluations for sup errors from 1e-2 to 1e-9 of those in the table."""

LIMIT_SHARE = 0.9
"""Longest step tried, in units of the stability limit at the largest strain of the wave."""

RATIO = 0.75
"""Step of the second pilot, in units of the first one's."""

SAFETY = 2.0
"""Factor on each estimate."""

TIME_SHARE = 0.7
"""Share of the tolerance that the time step may use."""

DECAY = 5
"""A window's error falls at least like N^-DECAY (measured: between 5.8 and 7.4)."""

GROWTH = 1.5
"""Size of a window, in units of one before it, at least."""

FASTEST_GROWTH = 8.0
"""The same, at most."""

LANES = 64
"""Sizes are multiples of this, which suits the kernels."""

ATTEMPTS = 6
"""Most refinements of the step, and most sizes tried."""


@dataclass(frozen=True)
class StencilPlan:
    """The scene with scheme, step and domain filled in, and what the pilots say about it.

    ``pilot`` is the (step, sites) of the pilot that has the scene's step; ``time`` the error of
    that step, ``allowed`` the error that the domain may have, ``next_decade`` as in `Estimate`.
    """

    scene: Scene
    pilots: Pilots
    pilot: tuple[float, int]
    time: float
    allowed: float
    next_decade: float

    def space(self, strains: Sequence[Array]) -> float:
        """The domain's error of a finished run with these strains at the pilots' times.

        That of a ring is what a wider one changes; its run may have other steps than its pilots.
        """
        step, sites = self.pilot
        if self.scene.domain == "ring":
            return SAFETY * self.pilots.difference(self.pilot, (step, sites + 4 * MARGIN))
        change = SAFETY * self.pilots.distance(strains, self.pilot)
        ratio = sites / self.scene.sites
        return richardson(change, ratio, DECAY) * ratio**DECAY

    def settled(self, space: float) -> bool:
        """Whether a wider domain is not called for, or would not help."""
        return space <= self.allowed or math.isinf(space) or self.scene.domain == "ring"

    def wider(self, space: float) -> "StencilPlan":
        """The plan in a window in which that error would be allowed."""
        factor = max(GROWTH, (space / self.allowed) ** (1.0 / DECAY))
        sites = round_up(min(factor, FASTEST_GROWTH) * self.scene.sites)
        return replace(self, scene=replace(self.scene, sites=sites))


def plan_stencil(scene: Scene, wave: Wave, progress: Progress) -> StencilPlan:
    """Choose scheme, step and domain for the scene's tolerance.

    If pilots keep blowing up, the plan is the last one tried and its error is infinite: the run
    itself then tells what happens. Raises ValueError for what wave or lattice do not admit.
    """
    assert scene.tolerance is not None
    extent = extent_of(scene, wave)
    scheme = scheme_named(scene.scheme or PREFERRED)
    domain = domain_kind(scene, wave)
    pilots = Pilots(scene, wave, scheme.name, domain, extent.crest, progress)
    longest = longest_step(scene, scheme, extent)
    least = least_sites(replace(scene, compared=pilots.compared), domain, extent)
    begin = smallest_domain(pilots, longest, least)
    step, time, cost = plan_step(pilots, longest, begin, scheme.order, TIME_SHARE * scene.tolerance)
    stated = replace(
        scene,
        tolerance=None,
        engine="stencil",
        scheme=scheme.name,
        step=step,
        domain=domain,
        sites=first_sites(begin, least_sites(scene, domain, extent), domain),
    )
    allowed = (1.0 - TIME_SHARE) * scene.tolerance
    return StencilPlan(stated, pilots, (step, begin), time, allowed, cost.next_decade)


def domain_kind(scene: Scene, wave: Wave) -> str:
    """A window on a constant background, unless something asked for needs a ring."""
    needs_ring = any(entry_named(name).needs_ring for name in scene.observables)
    return "ring" if needs_ring or wave.constant_background is None else "window"


def longest_step(scene: Scene, scheme: Scheme, extent: Extent) -> float:
    """A step that is stable about the wave's largest strain."""
    limit = stability_limit(scheme) / scene.constants.highest_frequency(extent.strain)
    return LIMIT_SHARE * limit


def least_sites(scene: Scene, domain: str, extent: Extent) -> int:
    """Fewest sites that the scene admits, rounded up to what suits the kernels."""
    if domain == "window":
        return round_up(least_window(scene.compared))
    return round_up(least_ring(scene, extent.strain))


def round_up(sites: float) -> int:
    """The next multiple of ``LANES``."""
    return LANES * math.ceil(sites / LANES)


def smallest_domain(pilots: Pilots, step: float, least: int) -> int:
    """The fewest sites tried, ``least`` or more, with which pilots come to their end.

    Where the feed of a window begins too near the crest they do not. ``least`` if none does.
    """
    sites = least
    for _ in range(ATTEMPTS):
        if math.isfinite(pilots.difference((step, sites), (RATIO * step, sites))):
            return sites
        sites = round_up(GROWTH * sites)
    return least


def first_sites(begin: int, least: int, domain: str) -> int:
    """Sites of the run's first domain: ``least``, but more than the pilots' in a window."""
    return least if domain == "ring" else max(least, round_up(GROWTH * begin))


def plan_step(
    pilots: Pilots, longest: float, sites: int, order: int, allowed: float
) -> tuple[float, float, CostModel]:
    """The longest step whose estimated error is allowed, that error, and the cost of less.

    The step is shortened by the law of the scheme's order until the difference to the run before
    says that it is short enough.
    """
    coarse, step = longest, RATIO * longest
    for _ in range(ATTEMPTS):
        change = pilots.difference((coarse, sites), (step, sites))
        error = SAFETY * richardson(change, step / coarse, order)
        finer = error * (step / coarse) ** order
        if error <= allowed:
            return coarse, error, fitted_cost(*pilots.errors(sites), order)
        if finer <= allowed:
            return step, finer, fitted_cost(*pilots.errors(sites), order)
        shorter = 0.95 * (allowed / finer) ** (1.0 / order) if math.isfinite(finer) else RATIO
        coarse, step = step, step * min(RATIO, shorter)
    return step, math.inf, fitted_cost([], [], order)

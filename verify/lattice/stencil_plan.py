"""Scheme, step and domain for a tolerance, chosen by pilot runs on the crest.

Time step: the errors of a scheme of order p at two steps differ by the factor ratio^p, so the
difference of two pilots tells both. Domain: the part of a window's error that comes from its finite
size falls at least like N^-5 on a constant background, and a ring is wide enough that its seam is
not felt; two sizes are compared. A window moves at times that do not depend on the step, so its
error cancels where steps are compared, and those pilots may run in the smallest one. Each estimate
carries the factor ``SAFETY``.
"""

import math
from dataclasses import dataclass, replace

from solutions import Wave
from verify.lattice.cost import CostModel
from verify.lattice.domain import MARGIN, least_ring, least_window
from verify.lattice.estimate import Estimate, fitted_cost, richardson
from verify.lattice.extent import Extent, extent_of
from verify.lattice.observables import entry_named
from verify.lattice.pilot import Pilots
from verify.lattice.recording import Progress
from verify.lattice.scene import Scene
from verify.lattice.scheme import Scheme
from verify.lattice.schemes import scheme_named
from verify.lattice.stability import stability_limit

PREFERRED = "blanes_moan_6"
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
"""Size of the second window, in units of the first one's."""

LANES = 64
"""Sizes are multiples of this, which suits the kernels."""

ATTEMPTS = 6
"""Most refinements of step or domain."""


@dataclass(frozen=True)
class StencilPlan:
    """The scene with scheme, step and domain filled in, and the error to be expected."""

    scene: Scene
    estimate: Estimate


def plan_stencil(scene: Scene, wave: Wave, progress: Progress) -> StencilPlan:
    """Choose scheme, step and domain for the scene's tolerance.

    If pilots keep blowing up, the plan is the last one tried and its estimate is infinite: the run
    itself then tells what happens. Raises ValueError for what wave or lattice do not admit.
    """
    assert scene.tolerance is not None
    extent = extent_of(scene, wave)
    scheme = scheme_named(scene.scheme or PREFERRED)
    domain = domain_kind(scene, wave)
    pilots = Pilots(scene, wave, scheme.name, domain, extent.crest, progress)
    longest = longest_step(scene, scheme, extent)
    begin = least_sites(replace(scene, compared=pilots.compared), domain, extent)
    least = least_sites(scene, domain, extent)
    allowed = (1.0 - TIME_SHARE) * scene.tolerance
    sites, space = plan_domain(pilots, longest, begin, least, domain, allowed)
    step, time, cost = plan_step(pilots, longest, begin, scheme.order, TIME_SHARE * scene.tolerance)
    stated = replace(
        scene,
        tolerance=None,
        engine="stencil",
        scheme=scheme.name,
        step=step,
        domain=domain,
        sites=sites,
    )
    return StencilPlan(stated, Estimate(time, space, cost.next_decade))


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


def plan_domain(
    pilots: Pilots, step: float, begin: int, least: int, domain: str, allowed: float
) -> tuple[int, float]:
    """Sites for the run, at least ``least``, and its error; the pilots have ``begin`` and more."""
    if domain == "ring":
        wider = least + round_up(4 * MARGIN)
        return least, SAFETY * pilots.difference((step, least), (step, wider))
    small = begin
    for _ in range(ATTEMPTS):
        large = round_up(GROWTH * small)
        change = pilots.difference((step, small), (step, large))
        error = SAFETY * richardson(change, small / large, DECAY)
        for sites in (max(least, small), max(least, large)):
            expected = error * (small / sites) ** DECAY
            if expected <= allowed:
                return sites, expected
        small = large
    return max(least, small), math.inf


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

"""One march through a scene, seen by a list of observables."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from solutions import Wave
from verify.lattice.comparison import Comparison
from verify.lattice.domain import build_domain
from verify.lattice.march import March
from verify.lattice.observables import Observable
from verify.lattice.scene import Scene
from verify.lattice.stability import check_step

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 .. 1."""


@dataclass(frozen=True)
class Recording:
    """A finished march: where it got to, and what it cost (seconds without compilation)."""

    march: March
    step_limit: float
    seconds: float


def prepare(scene: Scene, wave: Wave) -> tuple[March, float]:
    """The march of a scene at its initial time, kernels compiled, and the largest stable step.

    Raises ValueError for a step past the stability limit and for a domain that is too small.
    """
    domain, scheme = build_domain(scene, wave), scene.scheme_table
    state = domain.start()
    limit = check_step(scene.step, scheme, scene.constants, state.y)
    scheme.advance(state.y, state.s, scene.step, 0, scene.constants)
    return March(state, scheme, scene.constants, domain, scene.step), limit


def record(
    scene: Scene, wave: Wave, observables: Sequence[Observable], progress: Progress
) -> Recording:
    """Run the scene to its end or to a blow-up, showing each observable its times."""
    march, step_limit = prepare(scene, wave)
    times = sorted({t for observable in observables for t in observable.times} | {scene.end})
    begun = time.perf_counter()
    for state in march.through(times, lambda t: progress(_share(scene, t))):
        comparison = Comparison(scene, wave, state)
        for observable in observables:
            if state.t in observable.times:
                observable.see(comparison)
    return Recording(march, step_limit, time.perf_counter() - begun)


def _share(scene: Scene, t: float) -> float:
    return (t - scene.t0) / (scene.end - scene.t0) if scene.end > scene.t0 else 1.0

"""One march through a scene, seen by a list of observables."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from solutions import Wave
from verify.lattice.comparison import Comparison
from verify.lattice.domain import build_domain
from verify.lattice.march import March
from verify.lattice.recorder import Observable
from verify.lattice.scene import Scene
from verify.lattice.stability import check_step
from verify.lattice.state import State

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 .. 1."""


@dataclass(frozen=True)
class Recording:
    """A march: where it got to, and what it cost (seconds without compilation).

    ``stopped`` if Ctrl-C ended it.
    """

    march: March
    step_limit: float
    seconds: float
    stopped: bool = False


def prepare(scene: Scene, wave: Wave, restart: State | None = None) -> tuple[March, float]:
    """The march of a scene, kernels compiled, and the largest stable step.

    It begins with the scene's initial data, or with the state ``restart`` of an earlier run of the
    same scene. Raises ValueError for a step past the stability limit and for a domain that is too
    small.
    """
    domain, scheme = build_domain(scene, wave), scene.scheme_table
    initial = domain.start()
    limit = check_step(scene.step, scheme, scene.constants, initial.y)
    scheme.advance(initial.y, initial.s, scene.step, 0, scene.constants)
    state = initial if restart is None else restart
    amplitude = float(np.max(np.abs(initial.y)))
    return March(state, scheme, scene.constants, domain, scene.step, amplitude), limit


def record(
    scene: Scene,
    wave: Wave,
    observables: Sequence[Observable],
    progress: Progress,
    restart: State | None = None,
) -> Recording:
    """Run the scene to its end, a blow-up or Ctrl-C, showing it to each observable at its moments.

    A run from ``restart`` shows nothing before or at the time of that state.
    """
    march, step_limit = prepare(scene, wave, restart)
    begin = march.state.t
    exact = {t for observable in observables for t in observable.moments.times}
    first = {begin} if restart is None else set()
    times = sorted({t for t in exact if t > begin} | first | {scene.end})
    begun, stopped = time.perf_counter(), False
    try:
        for state in march.through(times):
            view = Comparison(scene, wave, state)
            for observable in observables:
                if observable.moments.due(state.t):
                    observable.see(view)
            progress(_share(begin, scene.end, state.t))
    except KeyboardInterrupt:
        stopped = True
    return Recording(march, step_limit, time.perf_counter() - begun, stopped)


def _share(begin: float, end: float, t: float) -> float:
    return (t - begin) / (end - begin) if end > begin else 1.0

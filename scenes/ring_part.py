"""The step of a run on a large ring, found and judged on a part of its cells.

A search takes four or five runs, all but one of them to see what a shorter step changes. Where some
of the cells show all that the wave does (`ring_runs.part_of`) these runs are of them alone, and one
is of all: with the step of the last of them, whose error is known. It must give what that gave, and
its data must be no larger, nor steeper, anywhere than on the part.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from longwave.lattice.refine import Announce, Refined, StoppedSearch, refine
from longwave.lattice.trial import Progress, StoppedTrial, difference
from longwave.scenes.ring_cost import USUAL_RUNS
from longwave.scenes.ring_runs import SiteRingEngine, WaveRings, part_of
from longwave.scenes.run_record import unfinished
from longwave.scenes.scene import Scene

ALIKE = 1e-3
"""By what share the largest value, or step from cell to cell, may be larger than on the part."""


def found_on_part(
    scene: Scene, engine: SiteRingEngine, progress: Progress, announce: Announce
) -> Refined | None:
    """The run of a large ring to the scene's tolerance; None where no part stands for all of it.

    Raises as `run_record.searched` does.
    """
    rings, tolerance = engine.rings, scene.target.tolerance
    part = part_of(rings.wave, rings.compared, rings.times, rings.signals)
    if part is None:
        return None
    inner = WaveRings(rings.wave, part, rings.times)
    within = SiteRingEngine(replace(engine.scene, observables=()), inner)
    if not np.all(rings.sizes <= (1.0 + ALIKE) * inner.sizes):
        return None
    sizes = within.first().size * USUAL_RUNS, engine.first().size
    share = sizes[0] / sum(sizes)
    try:
        found = refine(within, tolerance, lambda done: progress(share * done), announce)
    except StoppedSearch:
        raise unfinished(None, scene, None, 0.0) from None
    choices = replace(engine.first(), step=found.trial.choices.step)
    whole = SiteRingEngine(engine.scene, rings, part)
    announce(found.trial.seconds * sizes[1] / within.first().size)
    try:
        trial = whole.run(choices, True, lambda done: progress(share + (1.0 - share) * done))
    except StoppedTrial as stop:
        raise unfinished(stop.trial.payload, scene, found.error, 0.0) from None
    error = found.error + difference(trial, found.trial)
    return replace(found, trial=trial, error=error) if error <= tolerance else None

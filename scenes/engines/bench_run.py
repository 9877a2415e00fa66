"""Runs of a chain on a bench, to a tolerance on its readings, and their expected cost."""

from time import perf_counter

import numpy as np

from longwave.lattice.dynamics import Dynamics
from longwave.lattice.refine import Announce
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.lattice.state import State
from longwave.lattice.trial import DRIVEN_SHARE, Progress
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import MOST_STEPS
from longwave.scenes.engines.bench_readings import BenchReadings, bench_and_chain, reading_times
from longwave.scenes.engines.ring_cost import USUAL_RUNS, enlarged, search_cost
from longwave.scenes.engines.run_record import RunRecord, add_error_estimate, refine_scene
from longwave.scenes.starts.bench_chain import energy_cuts
from longwave.support.request_limits import ExpectedCost, OverBudgetError, check_request

BALANCE_SECONDS = 4e-4
"""Seconds to stop at a step and update the energy balance; measured on 24 cells."""

READING_SECONDS = 3e-4
"""Seconds to stop at a time and take all readings; measured: 3e-4 to 4.6e-4 (31, 60 cells)."""

FIRST_STEP = 4.0
"""First step tried, in units of the inverse highest frequency at rest."""


def scene_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of a bench scene; ValueError beyond `MOST_STEPS` steps."""
    bench, chain = bench_and_chain(scene)
    times = reading_times(scene, bench)
    highest = Dynamics(chain).highest_frequency(np.zeros((len(chain.bonds) + len(chain.fields), 2)))
    duration = float(times[-1] - scene.t0)
    longest = FIRST_STEP / highest if highest > 0.0 else duration
    tolerance = scene.target.tolerance
    driven = chain.drive_steps(scene.t0, scene.end, longest, REDUCED_PHASE_6, tolerance)
    steps = max(duration / driven.step, float(times.size)) + driven.stops.size
    if steps > MOST_STEPS and driven.step >= longest:
        raise ValueError(
            f"times must end within at most {MOST_STEPS:g} steps, got {scene.end:g} (about "
            f"{steps:.2g} steps: the highest frequency is {highest:.2g}; end earlier)"
        )
    if steps > MOST_STEPS:
        raise ValueError(
            f"losses and drivers must need at most {MOST_STEPS:g} steps, got about {steps:.2g} "
            f"(their time scale is {driven.step / DRIVEN_SHARE:.2g}; slow them down or end earlier)"
        )
    readings = times.size * max(1, len(bench.sensed)) * max(1, len(bench.sensors))
    cost = search_cost(chain, bench.sites, steps, REDUCED_PHASE_6.stages, float(readings))
    balance = steps * BALANCE_SECONDS if energy_cuts(bench, chain) is not None else 0.0
    reading = times.size * READING_SECONDS
    return enlarged(cost, USUAL_RUNS * (reading + balance))


def record_scene(
    scene: Scene, progress: Progress | None, announce: Announce | None, restart: State | None
) -> RunRecord:
    """Run the chain so that the error of each reading is within the tolerance.

    Raises ValueError for an inadmissible request, one that takes too long, and a diverging chain.
    """
    begun = perf_counter()
    if restart is not None:
        raise ValueError(
            f"a chain on a bench must be run from its start, got a state of {scene.name} (run it)"
        )
    cost = scene_cost(scene)
    check_request(scene.name, cost, "watch it less often, end earlier or take fewer sites")
    announce, progress = announce or (lambda _: None), progress or (lambda _: None)
    bench, chain = bench_and_chain(scene)
    if bench.noise is not None:
        from longwave.scenes.engines.bench_bath import record_means

        return record_means(scene, bench, chain, progress, announce)
    announce(cost.seconds)
    readings = BenchReadings(scene, bench, chain)
    try:
        result = refine_scene(readings.engine, scene, progress, announce, readings.record_of)
    except OverBudgetError as error:
        raise ValueError(readings.engine.budget_message(error.work, scene.tolerance)) from None
    record = readings.record_of(result.trial)
    if result.trial.values is None:
        readings.engine.check_followed(result.trial)
        raise ValueError(
            f"times must end before {scene.lattice} flies apart, got {scene.end:g} "
            f"({record.attrs['blow_up'] or 'no run reaches the end'}, with steps down to "
            f"{result.trial.choices.step:.2g}; end earlier)"
        )
    return add_error_estimate(record, result, scene, begun)

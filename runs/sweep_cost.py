"""Expected cost of the cells that a sweep's store does not have, estimated from all or a sample."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, replace
from random import Random
from time import process_time
from typing import TYPE_CHECKING

from longwave.scenes.engines.methods import expected_cost
from longwave.support.request_limits import ExpectedCost

if TYPE_CHECKING:
    from longwave.runs.run_store import RunStore
    from longwave.runs.sweep_file import Sweep
    from longwave.scenes.description.scene import Scene

MAX_SAMPLED, MIN_SAMPLED = 200, 5
"""Largest and least number of cells whose cost is estimated. With 200, costs that differ by a
factor of 100 are estimated to about 20 %."""

FREE_SAMPLING_SECONDS, SAMPLING_FRACTION, MAX_SAMPLING_SECONDS = 0.2, 0.01, 3.0
"""Limits on the processor time for estimating costs of cells (the first cell is not counted):
seconds that are always allowed, fraction of the sweep's expected time, and the most seconds. An
estimate takes 30 ms if an equation must be derived."""


@dataclass(frozen=True)
class SweepCost:
    """Expected cost of a sweep: cells in all, cells missing in the store, sampled costs, memory.

    ``missing`` is extrapolated from the sample. ``seconds_by_cell`` has the seconds of the sampled
    cells by number, 0 for a cell that need not be run.
    """

    cells: int
    missing: int
    seconds_by_cell: Mapping[int, float]
    memory_bytes: float

    @property
    def sampled(self) -> int:
        """Number of sampled cells."""
        return len(self.seconds_by_cell)

    @property
    def seconds(self) -> float:
        """Expected seconds of all missing cells on one worker."""
        return sum(self.seconds_by_cell.values()) * self.cells / len(self.seconds_by_cell)

    @property
    def description(self) -> str:
        """Number of cells, and the size of the sample if not all were estimated."""
        suffix = "" if self.sampled == self.cells else f", estimated from {self.sampled} of them"
        return f"{self.cells} cells{suffix}"

    def on_workers(self, workers: int, share_memory: bool) -> ExpectedCost:
        """Return the cost on several workers; with ``share_memory`` their memory is added up."""
        concurrent = min(workers, self.missing) if share_memory else 1
        startup = WORKER_SECONDS if self.missing else 0.0
        return ExpectedCost(startup + self.seconds / workers, self.memory_bytes * concurrent)


CELL_SECONDS = 0.05
"""Overhead of a sweep cell in seconds: derivation, plan, data set, writing to a pack."""

WORKER_SECONDS = 1.5
"""Seconds that a worker needs before its first cell."""


def expected_cell_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of a cell in a process that runs many, without one-time costs."""
    cost = expected_cost(scene)
    return replace(cost, seconds=CELL_SECONDS + max(0.0, cost.seconds - cost.once))


def expected_sweep_cost(sweep: Sweep, store: RunStore, stored_keys: Container[str]) -> SweepCost:
    """Estimate the cost of the cells whose keys are not in ``stored_keys``.

    Cells are sampled in a random order that is always the same. A cell with an inadmissible scene
    costs nothing.
    """
    order = Random(0).sample(range(len(sweep)), min(MAX_SAMPLED, len(sweep)))
    start = process_time()
    memory, missing = 0.0, 0
    seconds: dict[int, float] = {}
    requested: set[str] = set()
    for number in order:
        expected = sum(seconds.values()) * len(sweep) / max(1, len(seconds))
        allowed = max(FREE_SAMPLING_SECONDS, SAMPLING_FRACTION * expected)
        has_enough = len(seconds) >= MIN_SAMPLED
        if has_enough and process_time() - start > min(allowed, MAX_SAMPLING_SECONDS):
            break
        seconds[number] = 0.0
        start = process_time() if len(seconds) == 2 else start
        try:
            scene = sweep.scene(number)
            key = store.key(scene)
            if key in requested or key in stored_keys:
                continue
            requested.add(key)
            cost = expected_cell_cost(scene)
        except ValueError:
            continue
        missing += 1
        seconds[number] = cost.seconds
        memory = max(memory, cost.memory_bytes)
    return SweepCost(len(sweep), round(len(sweep) / len(seconds) * missing), seconds, memory)

"""What a sweep is expected to cost: what its store does not hold of it, by all cells or by some."""

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

MOST_LOOKED_AT, FEWEST = 200, 5
"""Cells that are looked at, of sweeps with more. Costs that differ by a factor of 100 are met to
about 20 % then."""

LOOKING_SECONDS, LOOKING_SHARE, MOST_LOOKING_SECONDS = 0.2, 0.01, 3.0
"""Seconds of the processor that looking at cells may always take after the first, as a share of the
sweep, and at most. A cell takes 30 ms where an equation is derived anew."""


@dataclass(frozen=True)
class SweepCost:
    """The cells looked at, the missing ones among them, and the cost of all that are missing.

    ``seconds`` are those of one worker, ``each`` those of the cells looked at by their numbers, 0
    where nothing is to be run.
    """

    cells: int
    missing: int
    each: Mapping[int, float]
    memory_bytes: float

    @property
    def looked_at(self) -> int:
        """Cells."""
        return len(self.each)

    @property
    def seconds(self) -> float:
        """Of all that are missing."""
        return sum(self.each.values()) * self.cells / len(self.each)

    @property
    def words(self) -> str:
        """How many cells there are, and by how many of them all are judged."""
        by = "" if self.looked_at == self.cells else f", judged by {self.looked_at} of them"
        return f"{self.cells} cells{by}"

    def by(self, workers: int, together: bool) -> ExpectedCost:
        """The cost with so many workers; of memory that of all ``together`` on this machine."""
        held = min(workers, self.missing) if together else 1
        begun = WORKER_SECONDS if self.missing else 0.0
        return ExpectedCost(begun + self.seconds / workers, self.memory_bytes * held)


CELL_SECONDS = 0.05
"""Of a cell of a sweep, whatever it holds: its derivation, plan, data set, its place in a pack."""

WORKER_SECONDS = 1.5
"""Of a worker, before its first cell."""


def expected_cell_cost(scene: Scene) -> ExpectedCost:
    """The cost of a run as one of many in a process: what that does once is left out."""
    found = expected_cost(scene)
    return replace(found, seconds=CELL_SECONDS + max(0.0, found.seconds - found.once))


def expected_sweep_cost(sweep: Sweep, store: RunStore, held: Container[str]) -> SweepCost:
    """What the sweep is expected to cost beside the keys that are ``held`` by the store.

    Cells are taken in a random order, always the same. One that is inadmissible costs nothing.
    """
    order = Random(0).sample(range(len(sweep)), min(MOST_LOOKED_AT, len(sweep)))
    begun = process_time()
    memory, missing = 0.0, 0
    each: dict[int, float] = {}
    given: set[str] = set()
    for number in order:
        share = LOOKING_SHARE * sum(each.values()) * len(sweep) / max(1, len(each))
        allowed = min(max(LOOKING_SECONDS, share), MOST_LOOKING_SECONDS)
        if len(each) >= FEWEST and process_time() - begun > allowed:
            break
        each[number] = 0.0
        begun = process_time() if len(each) == 2 else begun
        try:
            scene = sweep.scene(number)
            key = store.key(scene)
            if key in given or key in held:
                continue
            given.add(key)
            cost = expected_cell_cost(scene)
        except ValueError:
            continue
        missing += 1
        each[number] = cost.seconds
        memory = max(memory, cost.memory_bytes)
    return SweepCost(len(sweep), round(len(sweep) / len(each) * missing), each, memory)

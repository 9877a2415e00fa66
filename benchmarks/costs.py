"""Estimated and true cost of random scenes, each in a process of its own.

Prints estimated over true processor seconds and bytes for every scene, then least, median and
largest of both.

    python -m benchmarks.costs [--scenes 20] [--seed 7] [--budget 60]
"""

from __future__ import annotations

import argparse
import resource
import statistics
import time

from longwave.scenes import run
from longwave.scenes.engines.methods import expected_cost
from longwave.support.processes import Job, LocalWorkers, in_order
from searches.estimate_scenes import random_scene


def ratios(seed: int, index: int, budget: float) -> tuple[str, float, float] | None:
    """Return the scene, and estimated over true seconds and bytes; None if it is refused."""
    scene = random_scene(seed, index, budget).scene
    try:
        expected = expected_cost(scene)
        begun = time.process_time()
        run(scene)
    except ValueError:
        return None
    seconds = time.process_time() - begun
    peak_memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return repr(scene), expected.seconds / seconds, expected.memory_bytes / peak_memory


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description="Estimated and true costs of random scenes.")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--budget", type=float, default=60.0, help="seconds of the longest")
    options = parser.parse_args()
    found = []
    for index in range(options.scenes):
        job = Job(ratios, (options.seed, index, options.budget))
        (one,) = in_order([job], LocalWorkers(1))
        if one is not None:
            found.append(one[1:])
            print(f"seconds {one[1]:5.2f}  bytes {one[2]:5.2f}  {one[0]}", flush=True)
    for name, values in zip(("seconds", "bytes"), zip(*found, strict=True), strict=True):
        middle = statistics.median(values)
        print(f"{name}: {min(values):.2f} to {max(values):.2f}, median {middle:.2f}")


if __name__ == "__main__":
    main()

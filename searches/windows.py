"""The search for windows that err: random long waves in windows, each against a causal ring.

Long waves are drawn on the lattices of the catalogue but the paper's, with times long enough for a
window to need fewer cells than a ring. The true error is the difference to a third of the step on a
ring that is wide enough for signals of one and a half times the speed (`opponent.of_lattice`).

    python -m searches.windows [--count 300] [--seed 0] [--workers 2] [--seconds 60]

Prints each scene's ratio of true error to estimate and its cells in the window and on the ring, and
at the end the largest ratio. The exit status is 1 if one is above 1.
"""

from __future__ import annotations

import argparse
import random
import sys
from collections.abc import Iterator

from longwave.derive import LATTICES
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import CHAIN
from longwave.scenes.engines.domain_plan import DomainPlan, count_cells
from longwave.scenes.engines.lattice_run import domain_plan
from longwave.support.processes import Job, LocalWorkers, OutOfTime, as_ended, time_limit
from searches.estimate_judge import warm_up
from searches.opponent import NeutralError, of_lattice
from searches.soak_scenes import soak_scene

REDRAWN = 60
"""Scenes that are drawn before an index is given up."""


def window_scene(seed: int, index: int) -> tuple[Scene, DomainPlan] | None:
    """Return the first drawn scene of that index that runs in a window, with its rings."""
    draw = random.Random(f"windows {seed}:{index}")
    names = sorted(name for name in LATTICES if name != CHAIN)
    for redrawn in range(REDRAWN):
        span = round(draw.uniform(100.0, 1000.0), 1)
        changes = {
            "eps": round(draw.uniform(0.05, 0.3), 3),
            "times": [0.0, round(draw.uniform(0.3, 0.9) * span, 1), span],
            "compared": draw.randint(1, 120),
            "tolerance": float(f"{10.0 ** draw.uniform(-8.0, -2.0):.3g}"),
        }
        try:
            drawn = soak_scene(seed, index, redrawn, draw.choice(names), False)
            scene = drawn.changed(**changes, observables=("strain",), disorder=None)
            if scene.tolerance is None or scene.target.engine or scene.has_moving_wave:
                continue
            domains = domain_plan(scene)[1]
        except ValueError:
            continue
        if domains.window is not None:
            return scene, domains
    return None


def judge(seed: int, index: int, seconds: float) -> tuple[str, float | None]:
    """Return the result of an index in words, and its ratio, if there is one."""
    found = window_scene(seed, index)
    if found is None:
        return "no window drawn", None
    scene, domains = found
    text = (
        f"{scene.lattice}/{scene.wave_name} {domains.window} of {count_cells(domains.ends())} cells"
    )
    try:
        with time_limit(seconds):
            estimate, true = of_lattice(scene)
    except (NeutralError, ValueError, OutOfTime) as error:
        return f"{text}: {type(error).__name__} {str(error)[:80]}", None
    ratio = true / estimate
    return f"{text}: {ratio:.3g}{f' {scene.json()}' if ratio > 1.0 else ''}", ratio


def main() -> int:
    """Judge the scenes; 1 if an error exceeds its estimate."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--count", type=int, default=300, help="indices that are tried")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=60.0, help="of a run and its reference")
    given = parser.parse_args()
    ratios: list[float] = []

    def todo() -> Iterator[tuple[int, Job]]:
        for index in range(given.count):
            yield index, Job(judge, (given.seed, index, given.seconds))

    for index, call in as_ended(todo(), LocalWorkers(given.workers, warm_up)):
        text, ratio = call.result()
        print(f"{index} {text}", flush=True)
        ratios += [] if ratio is None else [ratio]
    largest = max(ratios, default=0.0)
    print(f"{len(ratios)} of {given.count} judged, largest ratio {largest:.3g}")
    return int(largest > 1.0)


if __name__ == "__main__":
    sys.exit(main())

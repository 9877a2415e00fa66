"""The time that a run or a sweep is told to take, beside the time that it takes.

Each scene is run in a process of its own on one core, and each sweep by one worker. Times are
seconds of the processor, which other programs on the machine hardly change; a scene's are those of
the whole process, imports included. Printed are told, taken and told / taken; and the same of what
was left when more was told on the way, of which the worst ratio is shown. Of a sweep that is the
time left as told from its second batch on, in seconds of the clock, until a tenth of it is left.

    python -m benchmarks.time_told [--scenes NAME ...] [--sweeps NAME ...] [--json]
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

SCENES = (
    *("fput_1955", "struck_grains", "soliton_dn_k_0.7", "alpha_fput_soliton", "kawahara_soliton"),
    *("kdv_burgers_shock", "fput_peregrine", "granular_peregrine", "damped_mkdv_soliton"),
    *("toda_soliton", "gardner_soliton", "rogue_cn_k_0.5_long", "Y3_eps_0.05", "square_lump"),
    *("alpha_beta_rogue", "rational_2_eps_0.075", "granular_dark", "dimer_rogue"),
    *("rational_2_eps_0.05", "Y2_eps_0.025", "soliton_dn_k_0.7_long", "Y3_eps_0.0125"),
)
SWEEPS = (
    *("error_over_k_cnoidal", "error_over_k_envelopes", "disorder_masses"),
    *("growth_over_k", "error_over_k"),
)

FIRST_LEFT = 0.1
"""Share of a sweep below which the time left is not looked at any more."""

Told = tuple[float, float]
"""When, and how many seconds more."""


def scene_told(name: str) -> dict[str, object]:
    """Run a scene here; what was told of it when, and what it took.

    The clock of its engines is made that of the processor: others on the machine do not slow it.
    """
    time.perf_counter = time.process_time
    from longwave.scenes.description.named_scenes import load_scene
    from longwave.scenes.engines.methods import expected_cost

    scene = load_scene(name)
    first = expected_cost(scene).seconds
    announced: list[Told] = []
    scene.run(announce=lambda seconds: announced.append((time.process_time(), seconds)))
    return {"told": first, "left": announced, "taken": time.process_time()}


def sweep_told(name: str) -> dict[str, object]:
    """Run a sweep by one worker; the same of it."""
    from longwave.runs.run_store import RunStore
    from longwave.runs.sweep import SweepState, run_sweep
    from longwave.runs.sweep_cost import expected_sweep_cost
    from longwave.runs.sweep_file import load_sweep
    from longwave.support.processes import LocalWorkers

    sweep, announced = load_sweep(name), []
    workers = LocalWorkers(1)
    with tempfile.TemporaryDirectory() as folder:
        store = RunStore(Path(folder))
        expected = expected_sweep_cost(sweep, store, ())
        first = expected.on_workers(1, share_memory=True).seconds
        begun = time.perf_counter()

        def tell(state: SweepState) -> None:
            announced.append((time.perf_counter() - begun, state.seconds_left))

        state = SweepState(len(sweep), expected=expected.seconds_by_cell)
        run_sweep(sweep, store, workers, tell, state)
        workers.stop()
        whole = time.perf_counter() - begun
    later = [entry for entry in announced[1:] if whole - entry[0] > FIRST_LEFT * whole]
    return {"told": first, "left": later, "taken": state.worker_seconds, "end": whole}


def measured(kind: str, names: Sequence[str]) -> Iterator[dict[str, object]]:
    """Yield the announced and the true time of each, in a process of its own on one core."""
    core = {min(os.sched_getaffinity(0))}
    for name in names:
        command = [sys.executable, "-P", "-m", "benchmarks.time_told", f"--one-{kind}", name]
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=True,
            preexec_fn=lambda: os.sched_setaffinity(0, core),
        )
        found = json.loads(done.stdout)
        end = found.pop("end", found["taken"])
        ratios = [seconds / (end - then) for then, seconds in found["left"] if end > then]
        worst = max(ratios, key=lambda ratio: max(ratio, 1 / max(ratio, 1e-9)), default=None)
        ratio = found["told"] / found["taken"]
        yield {"name": name, **found, "ratio": ratio, "worst": worst}


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description="Time told and time taken.")
    parser.add_argument("--scenes", nargs="*", default=SCENES)
    parser.add_argument("--sweeps", nargs="*", default=SWEEPS)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--one-scene", help=argparse.SUPPRESS)
    parser.add_argument("--one-sweep", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one_scene:
        print(json.dumps(scene_told(options.one_scene)))
        return
    if options.one_sweep:
        print(json.dumps(sweep_told(options.one_sweep)))
        return
    if not options.json:
        print(f"{'':24} {'told':>8} {'taken':>8} {'ratio':>6} {'on the way':>10}")
    for kind, names in (("scene", options.scenes), ("sweep", options.sweeps)):
        for found in measured(kind, names):
            if options.json:
                print(json.dumps(found), flush=True)
                continue
            worst = "" if found["worst"] is None else f"{found['worst']:.2f}"
            numbers = f"{found['told']:8.2f} {found['taken']:8.2f} {found['ratio']:6.2f}"
            print(f"{found['name']:24} {numbers} {worst:>10}", flush=True)


if __name__ == "__main__":
    main()

"""Cost of scenes of millions of cells: to plan, for their data, to integrate; and bytes a site.

A soliton on a dimer, the Peregrine wave on one, and a soliton on the dn wave of the paper's chain,
which has no end: compared in all but few cells at the end. The steps are those of the scene; it is
set against `integrate` with the same lattice, data, scheme and steps, and nothing but that. With
``--tolerance`` the step is found, and the last column is the share of the run that planning took.
Each in a process of its own.

    python benchmarks/large_scenes.py [--sites 1000000 10000000] [--steps 1000] [--tolerance 1e-4]
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import time
from typing import Any

import numpy as np

from longwave.lattice import integrate
from longwave.lattice.schemes import scheme_named
from longwave.lattice.state import State
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.lattice_run import domain_plan
from longwave.scenes.engines.stepped_cells import SteppedCells

STEP, SCHEME = 0.25, "reduced_phase_6"
BESIDE = 1000
"""Cells at each end of a ring that are not compared, beside those that signals go in the time."""

WAVES: dict[str, dict[str, Any]] = {
    "soliton on a dimer": {
        "lattice": "dimer",
        "wave": "kdv_soliton",
        "eps": 0.1,
        "order": "slaved",
        "constants": {"m1": 1, "m2": 2, "K2": 1, "K3": "1/2", "K4": 0, "H2": 2, "H3": 1, "H4": 0},
        "parameters": {"kappa": 1},
    },
    "Peregrine on a dimer": {
        "lattice": "mass_dimer",
        "wave": "nls_peregrine",
        "eps": 0.04,
        "order": "slaved",
        "carrier": "pi/2",
        "branch": "optical",
        "constants": {"m1": 1, "m2": 3, "K2": 1, "K3": 0, "K4": 1},
        "parameters": {"A": 1},
    },
    "paper's chain": {
        "wave": "soliton_dn",
        "eps": 0.05,
        "K2": 1,
        "K4": 1,
        "parameters": {"k": 0.7},
    },
}


def scene_of(wave: str, sites: int, steps: int, tolerance: float | None) -> Scene:
    """Return the scene on a ring of so many cells; a tolerance implies the engine site by site."""
    end = steps * STEP
    compared = sites // 2 - BESIDE - int(2.5 * end)
    numerics: dict[str, Any] = {"step": STEP, "domain": "ring", "sites": sites, "scheme": SCHEME}
    if tolerance is not None:
        numerics = {"tolerance": tolerance, "engine": "stencil"}
    return Scene.of(
        name=wave,
        t0=0,
        snapshots=[end],
        compared=compared,
        observables=("strain",),
        **WAVES[wave],
        **numerics,
    )


def data_of(scene: Scene) -> tuple[Any, State]:
    """Return the lattice and the data of a stated scene."""
    ring = SteppedCells(*domain_plan(scene)).ring
    return ring.lattice, State(ring.t, ring.f, ring.v)


def whole(scene: Scene) -> list[float]:
    """Return seconds, processor seconds, bytes, and seconds of planning and of the last run."""
    few = scene_of(scene.name, 20_000, 20, scene.tolerance)
    few.run()
    begun, worked, memory = time.perf_counter(), time.process_time(), _held()
    run = scene.run()
    seconds, work = time.perf_counter() - begun, time.process_time() - worked
    attributes = run.attrs
    return [
        seconds,
        work,
        _held() - memory,
        attributes.get("planning_seconds", 0.0),
        attributes["seconds"],
    ]


def alone(scene: Scene) -> list[float]:
    """Return seconds of the data, then seconds and processor seconds of `integrate` alone."""
    begun = time.perf_counter()
    lattice, state = data_of(scene)
    data_seconds = time.perf_counter() - begun
    stated = scene.discretisation
    table = scheme_named(stated.scheme)
    integrate(lattice, _few(state), [STEP], scheme=table, step=STEP, measure_error=False)
    begun, worked = time.perf_counter(), time.process_time()
    integrate(lattice, state, [scene.end], scheme=table, step=stated.step, measure_error=False)
    return [data_seconds, time.perf_counter() - begun, time.process_time() - worked]


def _few(state: State) -> State:
    return State(state.t, np.zeros_like(state.f[:, :64]), np.zeros_like(state.v[:, :64]))


def _held() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def in_process(part: str, wave: str, sites: int, options: argparse.Namespace) -> list[float]:
    """Return the numbers that a process of its own measures."""
    words = [sys.executable, "-P", __file__, "--part", part, "--wave", wave, "--sites", str(sites)]
    words += ["--steps", str(options.steps)]
    if options.tolerance is not None and part == "whole":
        words += ["--tolerance", str(options.tolerance)]
    found = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    return [float(word) for word in found.split()]


def main() -> int:
    """Print a row per wave and number of cells."""
    parser = argparse.ArgumentParser(description="What scenes of millions of cells take.")
    parser.add_argument("--sites", type=int, nargs="+", default=[10**6, 10**7])
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--tolerance", type=float)
    parser.add_argument("--wave", choices=WAVES)
    parser.add_argument("--part", choices=["whole", "alone"])
    options = parser.parse_args()
    if options.part:
        tolerance = options.tolerance if options.part == "whole" else None
        scene = scene_of(options.wave, options.sites[0], options.steps, tolerance)
        print(*{"whole": whole, "alone": alone}[options.part](scene))
        return 0
    print(f"{len(os.sched_getaffinity(0))} cores, {options.steps} steps of {STEP}, {SCHEME}")
    for wave in [options.wave] if options.wave else WAVES:
        for sites in options.sites:
            seconds, work, memory, planned, last = in_process("whole", wave, sites, options)
            row = f"{wave}, {sites:9d} sites, stencil: {seconds:6.1f} s in all"
            if options.tolerance is not None:
                row += f", planned {planned:.1f} ({planned / seconds:.0%}), last run {last:.1f}"
            else:
                data, integrated, worked = in_process("alone", wave, sites, options)
                row += f", data {data:.1f}, integrate alone {integrated:.1f}; "
                row += f"{seconds / integrated:.2f} times that ({work / worked:.2f} in processor s)"
            print(
                f"{row}; {memory / sites:.0f} bytes a site, {work / seconds:.1f} cores", flush=True
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Small scenes of every engine, their comparable bits, and a checkpoint folder that kills."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.support.checkpoint import CheckpointFolder

ALL_LOOKS = ("strain", "error_curve", "crest_track", "space_time")


def chain(name: str, **given: Any) -> Scene:
    wave = {"wave": "soliton_sech", "parameters": {"A": 1}, "eps": 0.1}
    usual = {"t0": 0, "snapshots": [0, 150, 300], "compared": 60, "K2": 1, "K4": 1}
    return Scene.of(name=name, **(wave | usual | given))


ROGUE = {"wave": "rogue_cn", "parameters": {"k": 0.5}, "snapshots": [0, 150], "tolerance": 1e-4}

SCENES: dict[str, Scene] = {
    "stated window, refined": chain(
        "window", domain="window", observables=[*ALL_LOOKS, "time_step_error"], step=0.2, sites=1024
    ),
    "stated ring": chain(
        "ring", domain="ring", observables=[*ALL_LOOKS, "energy", "state"], step=0.2, sites=1280
    ),
    "stencil, window": chain("window_to", tolerance=1e-6, engine="stencil"),
    "stencil, ring": chain("ring_to", engine="stencil", observables=ALL_LOOKS, **ROGUE),
    "spectral": chain("spectral", tolerance=1e-4, engine="spectral", observables=ALL_LOOKS),
    "spectral, periodic": chain("spectral_periodic", engine="spectral", **ROGUE),
    "chain": load_scene("toda_soliton").changed(
        name="chain", slow_times=[0, 0.5, 1], tolerance=1e-3
    ),
    "disorder": load_scene("toda_soliton").changed(
        name="disorder",
        slow_times=[0, 0.1, 0.3],
        tolerance=1e-4,
        disorder={"of": "a", "spread": 0.2, "seed": 3},
    ),
    "dimer": load_scene("dimer_peregrine"),
    "growth": Scene.of(
        name="growth",
        lattice="fput",
        wave="perturbed_plane",
        eps=0.1,
        tolerance=1e-3,
        constants={"K2": 1, "K3": 0, "K4": 1},
        parameters={"amplitude": 0.3},
        carrier="pi/2",
    ),
    "bench": load_scene("driven_chain").changed(name="bench", tolerance=1e-8),
    "bath": load_scene("chain_in_a_bath").changed(name="bath", tolerance=2e-3),
    "plane": load_scene("square_lump").changed(
        name="plane", slow_times=[0, 0.02, 0.04], half_width=3, tolerance=1e-2
    ),
}

CLOCKS = ("seconds", "planning_seconds")
"""What two runs of a scene may differ in."""


def bits(run: xr.Dataset) -> dict[str, object]:
    """Return the contents of a run, each array as type and bytes, without the measured seconds."""
    stored: dict[str, object] = {
        name: (variable.dims, variable.dtype.str, np.ascontiguousarray(variable.values).tobytes())
        for name, variable in run.variables.items()
    }
    return stored | {
        f"@{name}": repr(message) for name, message in run.attrs.items() if name not in CLOCKS
    }


class Killed(BaseException):
    """Simulated end of the process, which no code of the run can handle."""


class KillingFolder(CheckpointFolder):
    """Checkpoint folder that ends the run after it has saved a given number of checkpoints."""

    def __init__(self, folder: Any, writes: int) -> None:
        super().__init__(folder, "stamp", least=0.0, share=1e9)
        self.left = writes
        self.names: list[str] = []

    def write(self, name: str, task: str, memory: dict[str, Any]) -> None:
        if self.left <= 0:
            raise Killed
        self.left -= 1
        self.names.append(name)
        super().write(name, task, memory)

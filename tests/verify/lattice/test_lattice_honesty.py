"""Catches: an estimate below the true error, on scenes where one was found.

The kink's absorber, the wave that was never on the ring, the strains that outran a causal ring, and
steps that averaged away what the data send to the left.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from verify.lattice import Scene, run
from verify.lattice.engine import choose_engine
from verify.lattice.initial import build_wave


def _scene(name: str, eps: float, **fields: Any) -> Scene:
    base = {"K2": 1.0, "K4": 1.0, "observables": ("strain",), "wave": name}
    return Scene(name=name, eps=eps, **(base | fields))


KINK = _scene(
    "kink",
    0.05,
    K4=-1.0,
    t0=-5000.0,
    snapshots=(0.0, 5000.0),
    compared=60,
    tolerance=1e-3,
    parameters=(("A", 1),),
)
WAVE_CN = _scene(
    "wave_cn",
    0.03,
    t0=-3000.0,
    snapshots=(0.0, 3000.0),
    compared=60,
    tolerance=1e-4,
    parameters=(("k", 0.5),),
)
STEEP = _scene(
    "rational_2", 0.1, K2=4.0, t0=-800.0, snapshots=(0.0, 400.0), compared=100, tolerance=1e-3
)
FAST = _scene(
    "soliton_sech",
    0.05,
    K2=4.0,
    t0=-1e5,
    snapshots=(0.0,),
    compared=50,
    tolerance=1e-3,
    parameters=(("A", 2),),
)
FASTER = _scene(
    "soliton_sech",
    0.05,
    K2=4.0,
    t0=-1e5,
    snapshots=(0.0,),
    compared=100,
    tolerance=1e-3,
    parameters=(("A", 3),),
)
LONG = _scene(
    "soliton_dn",
    0.05,
    t0=-4000.0,
    snapshots=(0.0, 4000.0),
    compared=200,
    tolerance=1e-4,
    parameters=(("k", 0.7),),
)
LEFT_GOING = _scene(
    "soliton_sech",
    0.1963,
    K2=0.2276,
    K4=0.002014,
    t0=50213.92812289078,
    snapshots=(57008.328660265805,),
    compared=126,
    tolerance=8.568e-08,
    parameters=(("A", 2.485),),
)


@pytest.mark.parametrize(
    "scene",
    [
        KINK,
        WAVE_CN,
        STEEP,
        LONG,
        pytest.param(FAST, marks=pytest.mark.slow),
        pytest.param(FASTER, marks=pytest.mark.slow),
        pytest.param(LEFT_GOING, marks=pytest.mark.slow),
    ],
)
def test_both_engines_are_within_their_estimates_of_each_other(scene: Scene) -> None:
    """Their errors have nothing in common; one of them is the program's own choice."""
    runs = {engine: run(replace(scene, engine=engine)) for engine in ("stencil", "spectral")}
    strains = [found["strain"].values for found in runs.values()]
    estimates = [float(found.attrs["error_estimate"]) for found in runs.values()]
    assert float(np.max(np.abs(strains[0] - strains[1]))) / scene.eps <= sum(estimates)
    assert scene.tolerance is not None
    assert max(estimates) <= scene.tolerance
    assert choose_engine(scene, build_wave(scene)) in runs

"""Catches: bits that depend on threads or on earlier compilation, a scene misread from its text."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from longwave.scenes.description.named_scenes import (
    load_scene,
    rational_family_scenes,
    scene_of_toml,
    shipped_scenes,
)
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import CHAIN, CHAIN_CONSTANTS
from longwave.scenes.observed.observables import OBSERVABLES

HOUSE = Path(__file__).parents[2]


def python(*words: str, **settings: str) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(HOUSE)} | settings
    return subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, env=environment, check=False
    )


RATE = """
import numpy as np
from longwave.scenes.starts.background_growth import fastest_rate
from longwave.scenes.starts.fourier_interval import FourierInterval
x = np.linspace(0, 1, 512, endpoint=False)
print(fastest_rate(10 * np.exp(60 * (np.cos(2 * np.pi * x) - 1)), 10.0, 1.0, 1).hex())
random = np.random.default_rng(0)
interval = FourierInterval((0.0, 1.0), 3000)
modes = interval.modes(random.standard_normal(3000))
print(interval.jets(modes, random.random(2048), 7)[:, ::97].tolist())
"""


@pytest.mark.slow
def test_bits_do_not_depend_on_the_number_of_threads() -> None:
    found = [python("-c", RATE, OPENBLAS_NUM_THREADS=str(count)) for count in (1, 2)]
    assert found[0].stdout == found[1].stdout
    assert found[0].stdout.count("\n") == 2, found[0].stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", ["soliton_dn_k_0.7", "dimer_peregrine"])
def test_an_empty_kernel_cache_gives_the_same_bits(name: str, tmp_path: Path) -> None:
    """No kernel is compiled yet, another one is compiled first, and only one thread is used."""
    scene, output = load_scene(name), str(tmp_path / "run.nc")
    if scene.has_moving_wave:
        scene = scene.with_tolerance(1e-4).changed(engine="spectral", snapshots=[-100, -50])
    else:
        scene = scene.changed(eps=0.1, half_width=3.0, slow_times=[-0.3, 0])
    (tmp_path / "scene.toml").write_text(scene.toml(), "utf-8")
    result = python("-m", "longwave", "run", str(tmp_path / "scene.toml"), "--output", output)
    assert result.returncode == 0, result.stderr
    first = (
        "import sys; from longwave.__main__ import main; "
        "main(['run', 'soliton_dn_k_0.7']); sys.exit(main(['run', sys.argv[1]]))"
    )
    fresh = {"NUMBA_CACHE_DIR": str(tmp_path / "fresh"), "OPENBLAS_NUM_THREADS": "1"}
    again = python("-c", first, output, **fresh)
    assert f"{output}: same bits: all " in again.stdout, again.stdout + again.stderr
    assert again.returncode == 0


TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
NUMBERS = st.floats(1e-40, 1e40) | st.integers(1, 10**40)
TIMES = st.floats(-1e9, 1e9).filter(lambda t: t == 0.0 or abs(t) > 1e-40)
ORDERED = st.lists(TIMES, min_size=2, max_size=4, unique=True).map(sorted)


@st.composite
def chain_scenes(draw: st.DrawFn) -> Scene:
    """Strategy for scenes of the paper's chain with any admissible fields."""
    times = draw(ORDERED)
    given: dict[str, Any] = {
        "name": draw(TEXTS),
        "title": draw(TEXTS),
        "wave": draw(TEXTS.filter(bool)),
        "parameters": draw(st.dictionaries(TEXTS, NUMBERS | TEXTS, max_size=3)),
        "eps": draw(st.floats(1e-9, 1.0)),
        "t0": times[0],
        "snapshots": times[1:],
        "K2": draw(st.floats(0.01, 100.0) | st.integers(1, 99)),
        "K3": 0,
        "K4": draw(NUMBERS),
        "compared": draw(st.integers(1, 10**9)),
        "curve_points": draw(st.integers(1, 10**9)),
        "look_points": draw(st.none() | st.integers(1, 10**9)),
        "tolerance": draw(st.floats(1e-10, 1.0)),
        "engine": draw(st.sampled_from(["", "stencil", "spectral"])),
    }
    saved = [name for name, entry in OBSERVABLES.items() if entry.measured_at != "refinement"]
    given["observables"] = draw(st.lists(st.sampled_from(saved), unique=True))
    return Scene.of(**given)


VALUES = st.recursive(
    TEXTS | st.integers() | st.floats(allow_nan=False) | st.booleans(),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(TEXTS, inner, max_size=2),
    max_leaves=5,
)


DISORDERS = st.fixed_dictionaries(
    {
        "of": TEXTS,
        "spread": st.just(0.0) | st.floats(1e-40, 1, exclude_max=True),
        "seed": st.integers(0, 2**63 - 1),
    },
    optional={
        "distribution": st.sampled_from(["uniform", "binary"]),
        "sites": st.tuples(st.integers(-(2**53), 0), st.integers(0, 2**53)),
    },
)


@st.composite
def ring_scenes(draw: st.DrawFn) -> Scene:
    """Strategy for scenes on any lattice, shipped or declared, with any admissible fields."""
    scene = draw(st.sampled_from(shipped_scenes("lattices")).map(load_scene))
    pairs = st.dictionaries(TEXTS, NUMBERS | TEXTS, max_size=3)
    changes: dict[str, Any] = {key: draw(TEXTS) for key in ("name", "title")}
    changes |= {key: draw(pairs) for key in ("constants", "parameters")}
    changes |= {"slow_times": [], "times": []} | {
        draw(st.sampled_from(["slow_times", "times"])): draw(ORDERED)
    }
    if not scene.is_envelope:
        changes["amplitude"] = draw(st.none() | st.integers(0, 8))
        changes["background"] = draw(NUMBERS | TEXTS.filter(bool) | st.just(0))
    if not (scene.is_growth or scene.losses) and draw(st.booleans()):
        changes["disorder"] = draw(DISORDERS)
    if draw(st.booleans()):
        declared = {"fields": ["u"]} | draw(st.dictionaries(TEXTS, VALUES, max_size=3))
        changes |= {"lattice": draw(TEXTS), "declared": json.dumps(declared)}
    elif scene.lattice == CHAIN:
        changes["constants"] = {name: draw(NUMBERS | TEXTS) for name in CHAIN_CONSTANTS}
    return scene.changed(**changes)


@settings(max_examples=50, deadline=None)
@given(chain_scenes() | ring_scenes())
def test_any_scene_is_read_back_from_its_text(scene: Scene) -> None:
    found = scene_of_toml(scene.toml())
    assert found == scene
    assert repr(found) == repr(scene)
    assert found.toml() == scene.toml()


@pytest.mark.parametrize(
    "scene", [*rational_family_scenes().values(), *map(load_scene, shipped_scenes("lattices"))]
)
def test_every_shipped_scene_is_read_back(scene: Scene, tmp_path: Path) -> None:
    path = tmp_path / "other.toml"
    path.write_text(scene.toml(), "utf-8")
    assert load_scene(str(path)) == scene

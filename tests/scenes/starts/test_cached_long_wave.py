"""Waves on lattices from the cached results of their derivation."""

from dataclasses import astuple
from typing import Any

import numpy as np
import pytest

from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.rate_cases import rate_cases
from longwave.scenes.starts import cached_long_wave
from longwave.scenes.starts.cached_long_wave import _key, equation_of, scene_lattice_wave
from longwave.scenes.starts.lattice_derivation import derivation, lattice_wave
from longwave.scenes.starts.long_wave_data import LongWaveData
from longwave.solutions import Wave
from longwave.support.plain_data import plain_bytes, plain_value


def corrected() -> Scene:
    return rate_cases()["2"].scene.changed(eps=0.1, order="corrected")


SCENES = {
    "toda_soliton": lambda: load_scene("toda_soliton"),
    "gardner_soliton": lambda: load_scene("gardner_soliton"),
    "square_lump": lambda: load_scene("square_lump"),
    "corrected": corrected,
}


@pytest.mark.parametrize("name", SCENES)
def test_a_cached_wave_equals_the_derived_one(name: str) -> None:
    """Catches: a field that is not cached, or not restored."""
    scene = SCENES[name]()
    derived = lattice_wave(scene)
    assert isinstance(derived, LongWaveData)
    for _ in range(2):  # derived, then from the cache
        cached = scene_lattice_wave(scene)
        assert isinstance(cached, LongWaveData)
        assert cached.numbers == derived.numbers
        assert not isinstance(cached.wave, Wave)
        found = derivation(scene)
        assert equation_of(scene) == (found.text(), found.lattice.has_displacements)
    parts = astuple(derived.numbers)
    assert plain_value(plain_bytes(parts)) == parts
    if name == "toda_soliton":
        cells = np.arange(-20.0, 20.0)
        assert np.array_equal(cached.state(cells, 3.0), derived.state(cells, 3.0))


@pytest.mark.parametrize(
    "change",
    [
        {"eps": 0.2},
        {"order": "leading"},
        {"constants": {"a": 1, "b": 2}},
        {"parameters": {"kappa": 2}},
        {"background": 0.1},
        {"time": 5},
    ],
)
def test_what_a_wave_depends_on_is_in_its_key(change: dict[str, Any]) -> None:
    scene = load_scene("toda_soliton")
    assert _key(scene.changed(**change)) != _key(scene)
    other = scene.changed(name="other", title="", slow_times=(0, 3)).with_tolerance(1e-6)
    assert _key(other) == _key(scene)


def test_other_waves_are_derived(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: losses, disorder or an envelope that a cached wave ignores."""
    monkeypatch.setattr(cached_long_wave, "kept_wave", None)
    toda = load_scene("toda_soliton")
    computed = toda.changed(wave="computed_soliton", parameters={"speed": 1})
    for scene in (load_scene("damped_kdv_soliton"), load_scene("fput_peregrine"), computed):
        assert type(scene_lattice_wave(scene)) is type(lattice_wave(scene))

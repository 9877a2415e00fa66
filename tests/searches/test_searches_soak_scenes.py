"""Random scenes of other lattices: every kind of run is among them, and each can be written."""

import pytest

from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.methods import expected_cost
from searches.soak_scenes import soak_scene


@pytest.mark.parametrize(("index", "disordered", "growing"), [(12, True, False), (6, False, True)])
def test_scenes_of_each_kind_are_drawn(index: int, disordered: bool, growing: bool) -> None:
    scene = soak_scene(7, index)
    assert (bool(scene.disorder), scene.is_growth) == (disordered, growing)
    assert Scene.from_json(scene.json()) == scene
    assert 0.0 < expected_cost(scene).seconds < 60.0

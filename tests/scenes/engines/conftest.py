"""Scenes for the tests of the lattice, short enough to run in a fraction of a second."""

from collections.abc import Callable
from typing import Any

import pytest

from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.lattice_run import domain_plan
from longwave.scenes.engines.window import FedWave

RING = Scene.of(
    name="short",
    wave="rogue_cn",
    parameters=(("k", 0.5),),
    eps=0.1,
    t0=-20.0,
    snapshots=(-20.0, 0.0, 20.0),
    K2=1.0,
    K4=1.0,
    step=0.5,
    domain="ring",
    sites=400,
    compared=50,
    curve_points=5,
)
WINDOW = RING.changed(
    wave="rational_2",
    parameters=(),
    K2=4.0,
    t0=-200.0,
    snapshots=(-100.0, 0.0),
    domain="window",
    sites=1024,
    compared=200,
)


@pytest.fixture
def ring_scene() -> Callable[..., Scene]:
    """A cn rogue wave on a ring; keyword arguments replace fields."""

    def make(**changes: Any) -> Scene:
        return RING.changed(**changes)

    return make


@pytest.fixture
def window_scene() -> Callable[..., Scene]:
    """Y2 in a window; keyword arguments replace fields."""

    def make(**changes: Any) -> Scene:
        return WINDOW.changed(**changes)

    return make


@pytest.fixture
def fed_wave() -> Callable[[Scene], FedWave]:
    """The wave of a stated scene as its window is fed with it."""

    def make(scene: Scene) -> FedWave:
        return FedWave(domain_plan(scene)[1], scene.discretisation.sites)

    return make

"""Catches: a seam that softens on its own and ends a sound run; fading that reaches the sites."""

from dataclasses import replace

import numpy as np
import pytest

from longwave.lattice.seam import Fading
from longwave.lattice.state import State
from longwave.scenes import run
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.stepped_cells import RingDomain

SOUND = Scene.of(
    name="sn",
    wave="wave_sn",
    eps=0.06386,
    t0=-1853.0720329884607,
    snapshots=(408.206703149222,),
    K2=1.0,
    K4=-39.63,
    compared=611,
    parameters=(("k", 0.5077),),
    observables=("strain",),
    tolerance=4.455e-5,
    engine="stencil",
)


def test_a_seam_that_softens_ends_no_sound_run() -> None:
    found = run(SOUND)
    assert found.attrs["blow_up"] == ""
    assert found.attrs["error_estimate"] <= 4.455e-5


def test_a_lattice_that_softens_within_reach_is_told() -> None:
    found = run(replace(SOUND, eps=0.2, snapshots=(-1700.0,), compared=60))
    assert "a bond is stretched to where waves grow" in found.attrs["blow_up"]


def test_fading_cannot_be_felt(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = SOUND.changed(K4=-1.0, t0=-300.0, snapshots=(-100.0, 100.0), compared=60)
    scene = scene.changed(tolerance=1e-8)
    faded = run(scene).strain.values
    monkeypatch.setattr(RingDomain, "fade", lambda *_: None)
    assert np.abs(faded - run(scene).strain.values).max() < 1e-12 * scene.eps


def test_only_what_the_seam_has_reached_fades() -> None:
    state = State(30.0, np.ones((1, 400)), np.ones((1, 400)), left=-200)
    Fading(0.0, 2.0, 0.5, 20.0).at(state)
    inside = np.arange(-140, 140)
    assert (np.array(state.at(inside)) == 1.0).all()
    y, s = state.at(np.array([-200, 199]))
    assert y == pytest.approx(0.5)
    assert s == pytest.approx(0.0)

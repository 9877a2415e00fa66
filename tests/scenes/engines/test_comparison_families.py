"""Catches: members that differ in slow time or in width, waves that cannot be made from a name."""

import numpy as np
import pytest

from longwave.scenes.description.named_scenes import (
    load_scene,
    rational_family_scenes,
    shipped_scenes,
)
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.solutions import closed_form


def test_members_share_slow_times_and_width() -> None:
    scenes = rational_family_scenes()
    assert len(scenes) == 20
    for scene in scenes.values():
        assert scene.eps**3 * scene.t0 == pytest.approx(-1.25, rel=1e-3)
        assert scene.eps**3 * scene.end == pytest.approx(0.625, rel=1e-3)
        assert scene.eps * scene.compared == pytest.approx(75.0)


@pytest.mark.parametrize("order", [2, 3, 4, 5])
def test_the_peak_is_twice_the_order_and_one(order: int) -> None:
    wave = moving_wave(rational_family_scenes()[f"Y{order}_eps_0.05"]).wave
    assert abs(float(wave(0.0, 0.0).Y)) == pytest.approx(2 * order + 1)


def test_a_shift_in_the_parameters_splits_the_wave() -> None:
    scene = load_scene("split_rational_3")
    X = np.linspace(-10.0, 10.0, 2001)
    wave = moving_wave(scene).wave
    assert float(np.max(wave(X, np.zeros_like(X)).Y)) < 3.5
    assert [parameter.name for parameter in wave.form.parameters] == ["tau_5"]


def test_the_split_waves_snapshots_are_its_trough_and_its_crest() -> None:
    """Catches snapshots, or a beginning, that miss what the scene is there to show."""
    scene = load_scene("split_rational_3")
    wave, X = moving_wave(scene).wave, np.linspace(-10.0, 10.0, 4001)

    def ends(t: float) -> tuple[float, float]:
        Y = wave(X, np.full_like(X, scene.eps**3 * t)).Y
        return float(Y.min()), float(Y.max())

    trough, crest = -11200.0, 9200.0
    assert {trough, crest} < set(scene.snapshots)
    assert ends(trough)[0] == pytest.approx(-4.52, abs=0.01)
    assert ends(crest)[1] == pytest.approx(4.35, abs=0.01)
    for offset in (-800.0, 800.0):
        assert ends(trough + offset)[0] > ends(trough)[0]
        assert ends(crest + offset)[1] < ends(crest)[1]


def test_a_catalogued_form_is_not_replaced() -> None:
    assert closed_form("rational_3", ["k"]).reference.label == "third-order soln of mKdV"


@pytest.mark.parametrize("name", ["rational_0", "rational_13", "rational_1.5", "rational_x"])
def test_orders_that_there_are_not(name: str) -> None:
    with pytest.raises(ValueError, match=r"name must be a closed form of the catalogue"):
        closed_form(name)


def test_further_scenes_load_and_leave_their_discretisation_open() -> None:
    for name in shipped_scenes("further"):
        assert load_scene(name).tolerance == 1e-4

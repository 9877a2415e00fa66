"""Catches: an unstable background that nobody is told of, a tolerance kept beyond the horizon."""

import math
from dataclasses import replace

import numpy as np
import pytest

from longwave.cli.scene_command import summary_lines
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.starts import background_growth as trust_module
from longwave.scenes.starts.background_growth import (
    USUAL_TOLERANCE,
    fastest_rate,
    predictability_time,
    trust_attributes,
    trust_in,
)


def test_a_scenes_horizon() -> None:
    """Only the cn background is unstable; at four times the eps the horizon is 64 times shorter."""
    scene = load_scene("rogue_cn_k_0.5")
    trust = trust_in(scene, 1e-4)
    assert trust.rate == pytest.approx(2.49e-5, rel=0.01)
    assert trust.predictability_time > 1e6
    closer = trust_in(replace(scene, eps=0.2), 1e-4)
    assert trust.rate / closer.rate == pytest.approx(0.25**3, rel=1e-6)
    for name in ("soliton_dn_k_0.7", "breather_sn_k_0.5", "rational_2_eps_0.05"):
        assert trust_in(load_scene(name), 1e-4).predictability_time == float("inf")


def test_a_constant_background_has_nothing_to_report() -> None:
    assert trust_attributes(load_scene("rational_2_eps_0.05")) == {}


def test_a_tolerance_of_the_scene_sets_the_horizon() -> None:
    scene = load_scene("rogue_cn_k_0.5")
    found = trust_attributes(scene)
    assert found["trust_horizon"] == trust_in(scene, USUAL_TOLERANCE).predictability_time
    closer = trust_attributes(scene.with_tolerance(1e-8))
    ratio = found["trust_horizon"] - closer["trust_horizon"]
    assert ratio * found["trust_rate"] == pytest.approx(math.log(1e4))


def test_a_tolerance_below_rounding_is_lost_at_once() -> None:
    assert predictability_time(0.1, 1e-20, 1e-16) == 0.0


def _line(background: dict[str, float], **changes: float) -> str:
    scene = load_scene("rogue_cn_k_0.5").changed(**changes)
    attributes = {"engine": "e", "scheme": "s", "steps": 1, "sites": 2, "force_evaluations": 3}
    attributes |= {"seconds": 0.1, "blow_up": ""} | background
    return list(summary_lines(RunRecord(scene, (9,), (), {}, attributes), scene))[-1]


def test_the_summary_says_whether_the_scene_ends_before() -> None:
    unstable = {"trust_rate": 0.01, "trust_horizon": 500.0}
    early = _line(unstable)
    assert "exp(0.01 t)" in early
    assert "reaches 0.0001 eps 500 after t0, at t = 400; the scene ends before" in early
    assert early.endswith("before")
    assert "after that, where it is not reliable" in _line(unstable, snapshots=(1000.0,))
    assert _line({"trust_rate": 0.0, "trust_horizon": np.inf}) == "background: periodic and stable"


def test_a_tolerance_beyond_the_horizon_is_refused_before_anything_is_run() -> None:
    scene = replace(load_scene("rogue_cn_k_0.5"), snapshots=(2e6,))
    with pytest.raises(ValueError, match=r"snapshots must satisfy t <= 1.106e\+06 with tolerance"):
        run(scene.with_tolerance(1e-4))


def test_a_bare_wave_is_its_own_background() -> None:
    """Its record's background is zero, which has no wavelength."""
    scene = load_scene("rogue_cn_k_0.5")
    bare = trust_in(replace(scene, wave="wave_cn"), USUAL_TOLERANCE)
    assert bare.rate == pytest.approx(trust_in(scene, USUAL_TOLERANCE).rate, rel=1e-5)


def test_a_background_too_sharp_is_said_to_be() -> None:
    scene = replace(load_scene("rogue_cn_k_0.5"), parameters=(("k", 1.0 - 1e-15),))
    found = trust_attributes(scene)
    assert np.isnan(found["trust_rate"])
    assert np.isnan(found["trust_horizon"])
    assert "too far apart" in _line(found)


@pytest.mark.parametrize("fastest", [0.013, 0.4, 1.0])
def test_the_fastest_perturbation_is_found_wherever_in_the_zone_it_is(
    fastest: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        trust_module, "mkdv_rate", lambda *given: 1.0 - abs(given[4] / np.pi - fastest)
    )
    found = fastest_rate(np.cos(np.arange(64) * np.pi / 32), 1.0, 1.0, 1)
    assert found == pytest.approx(1.0, abs=1e-3)

"""Long waves in moving windows, on any chain: as on rings, and told where they cannot be fed."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from longwave.derive import LATTICES
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.scenes import load_scene, resume, run
from longwave.scenes.description.named_scenes import scene_of
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import site_engine
from longwave.scenes.engines.lattice_run import domain_plan
from longwave.scenes.engines.site_engine import SiteEngine
from longwave.scenes.engines.window import FedWave, Window
from longwave.scenes.starts.lattice_wave import sound_speed
from longwave.scenes.starts.long_wave_data import LongWaveData
from longwave.support.request_limits import request_limits

SHORT: dict[str, Any] = {"slow_times": (-0.1, 0, 0.1), "half_width": 6}
SCENES = {
    "strains about a background": load_scene("alpha_beta_rogue").changed(**SHORT, tolerance=1e-5),
    "displacements": load_scene("gardner_soliton").changed(slow_times=(0, 0.5, 1.5)),
    "two masses on a background": load_scene("dimer_rogue").changed(slow_times=(-0.2, 0, 0.2)),
    "radiation of the fifth order": load_scene("kawahara_soliton").changed(slow_times=(0, 1, 2)),
}


@pytest.fixture(scope="module", params=SCENES.values(), ids=[*SCENES])
def scene(request: pytest.FixtureRequest) -> Scene:
    found: Scene = request.param
    return found


def on_a_ring(scene: Scene) -> xr.Dataset:
    """The scene with an observable that asks for a ring."""
    return run(scene.changed(observables=(*scene.observables, "momentum")))


@pytest.mark.slow
def test_a_window_shows_what_a_ring_does(scene: Scene) -> None:
    moved, whole = run(scene), on_a_ring(scene)
    assert 'kind = "window"' in moved.plan
    assert moved.sites < whole.sites
    difference = np.abs(moved["strain"] - whole["strain"]).max() / scene.eps**moved.power
    assert difference <= moved.error_estimate + whole.error_estimate
    assert moved.error_estimate >= 2.0 * moved.feed_mismatch


def test_a_plan_in_a_window_has_the_bits_of_its_search(scene: Scene) -> None:
    found = run(scene.changed(observables=("strain", "state")))
    again = run(scene_of(found))
    for name in ("strain", "state_y", "state_s", "state_left"):
        np.testing.assert_array_equal(found[name], again[name])
    rest = resume(again, at=float(again["time"][1]))
    for name in ("strain", "state_y", "state_s"):
        np.testing.assert_array_equal(rest[name], again[name][2:])


@pytest.mark.slow
def test_what_is_fed_wrongly_is_run_on_a_ring(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a far field at a wrong speed, which the lattice does not follow."""
    scene = SCENES["two masses on a background"]
    rightly = run(scene)
    monkeypatch.setattr(LongWaveData, "far_speed", property(lambda _: 1.7))
    wrongly = run(scene)
    assert "window" in rightly.plan
    assert "window" not in wrongly.plan
    difference = np.abs(rightly["strain"] - wrongly["strain"]).max() / scene.eps
    assert difference <= rightly.error_estimate + wrongly.error_estimate


def test_what_a_feed_misses_is_part_of_the_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    timed, domains = domain_plan(SCENES["two masses on a background"])
    monkeypatch.setattr(site_engine, "LARGEST_MISFIT", 1.0)
    monkeypatch.setattr("longwave.scenes.engines.window.LARGEST_MISFIT", 1.0)
    monkeypatch.setattr(LongWaveData, "far_speed", property(lambda _: 1.45))
    engine = SiteEngine(timed, domains)
    trial = engine.run(engine.first(), shown=False)
    mismatch = trial.payload.attrs["feed_mismatch"]
    assert trial.common_error == 2.0 * mismatch > 1e-4


@pytest.mark.parametrize(
    ("lattice", "constants"),
    [
        ("fput", {"K2": 4, "K3": 0, "K4": 1}),
        ("mass_dimer", {"m1": 1, "m2": 3, "K2": 16, "K3": 0, "K4": 4}),
        ("next_nearest", {"K2": 1, "K3": 0, "K4": 0, "L2": 0.3, "L3": 0, "L4": 0}),
    ],
)
def test_the_speed_of_sound_is_that_of_the_reduction(
    lattice: str, constants: dict[str, float]
) -> None:
    numeric = numeric_lattice(LATTICES[lattice], constants)
    exact = {"fput": 2.0, "mass_dimer": np.sqrt(2.0), "next_nearest": np.sqrt(2.2)}[lattice]
    found = sound_speed(numeric, numeric.rest_slopes(), 1.1 * exact)
    assert found == pytest.approx(exact, rel=1e-10)


def test_a_far_field_in_strains_and_displacements_is_at_rest_or_moves_as_a_whole() -> None:
    _, domains = domain_plan(SCENES["two masses on a background"])
    growth, velocity = domains.wave.far_rates
    assert growth == pytest.approx([0.05, 0.05], rel=1e-12)
    assert velocity == pytest.approx(-domains.wave.speed * growth, rel=1e-2)
    _, domains = domain_plan(SCENES["strains about a background"])
    growth, velocity = domains.wave.far_rates
    assert not growth.any()
    assert not velocity.any()


@pytest.mark.parametrize("name", [*SCENES])
def test_the_feed_is_the_wave_itself_at_first(name: str) -> None:
    _, domains = domain_plan(SCENES[name])
    assert domains.window is not None
    fed = FedWave(domains, domains.window)
    state = Window(fed).start()
    sites = state.sites[-100:]
    speed = fed.background_speed
    assert speed is not None
    f, v = fed.rigid_data(speed, fed.rigid_offsets(speed, sites, fed.t0))
    at = state.at(sites)
    assert np.abs(f + fed.uniform(sites, fed.t0) - at[0]).max() < 1e-10
    assert np.abs(v - at[1]).max() < 1e-3 * fed.scale  # the wave's own rate in T is left out


def test_a_soliton_that_overtakes_all_signals_among_the_compared_cells_arrives() -> None:
    """It begins far from them: a ring that left it out had no wave, and an error of 1e-8."""
    fast: dict[str, Any] = {"order": "slaved", "parameters": {"kappa": 4}, "tolerance": 1e-3}
    fast |= {"eps": 0.08, "slow_times": (-2, 0), "half_width": 3}
    scene = load_scene("alpha_fput_soliton").changed(**fast)
    whole = on_a_ring(scene)
    assert np.abs(whole["strain"][-1]).max() > 0.9 * np.abs(whole["analytic"][-1]).max()
    moved = run(scene)
    difference = np.abs(moved["strain"] - whole["strain"]).max() / scene.eps**2
    assert difference <= moved.error_estimate + whole.error_estimate


@pytest.mark.slow
def test_a_window_that_misses_the_lattice_is_widened_first() -> None:
    scene = SCENES["two masses on a background"]
    usual, fine = run(scene), run(scene.changed(tolerance=1e-6))
    assert 'kind = "window"' in fine.plan
    assert fine.sites > usual.sites
    assert 2.0 * fine.feed_mismatch < 0.3e-6 < 2.0 * usual.feed_mismatch
    difference = np.abs(usual["strain"] - fine["strain"]).max() / scene.eps
    assert difference <= usual.error_estimate + fine.error_estimate


@pytest.mark.slow
def test_a_ring_in_the_place_of_a_window_may_be_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(site_engine, "LARGEST_MISFIT", -1.0)
    scene = load_scene("dimer_rogue")
    with (
        request_limits(seconds=5.0),
        pytest.raises(
            ValueError, match="since no smaller window can be fed with its wave, must take"
        ),
    ):
        run(scene)


def test_a_background_beyond_the_force_is_refused_in_a_line(tmp_path: Path) -> None:
    (tmp_path / "root.toml").write_text(
        'fields = ["u"]\nmasses = [1]\n[[spring]]\nbetween = ["u[n]", "u[n+1]"]\n'
        'force = "x/sqrt(1-x**2)"\n'
    )
    (tmp_path / "scene.toml").write_text(
        'lattice = "root.toml"\nwave = "soliton_background"\neps = 0.5\nslow_times = [0, 0.5]\n'
        "half_width = 3\ntolerance = 1e-3\n[parameters]\nU_0 = 10\nkappa = 1\n"
    )
    with pytest.raises(ValueError, match="where its force is defined"):
        run(tmp_path / "scene.toml")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"name": "dimer_peregrine"}, r"domain must be 'ring' for .* on mass_dimer"),
        ({"name": "alpha_fput_soliton"}, r"domain must be 'ring' for this wave on alpha_fput"),
        ({"name": "square_lump"}, r"tolerance must be given on square"),
        ({"name": "gardner_soliton", "sites": 128}, r"sites must satisfy sites >= 752 in this"),
    ],
)
def test_a_window_where_there_is_none_is_refused(changes: dict[str, Any], message: str) -> None:
    scene = load_scene(changes["name"])
    stated = {"step": 0.1, "domain": "window", "sites": changes.get("sites", 4096)}
    with pytest.raises(ValueError, match=message):
        run(scene.changed(tolerance=None, **stated))

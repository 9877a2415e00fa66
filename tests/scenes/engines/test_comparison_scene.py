"""Catches: bad input accepted, refused without a reason, or told in more than one line."""

import json
import math
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene, shipped_scenes
from longwave.scenes.description.scene import Scene

TEXT = """
wave = "breather_sn"
eps = 0.05
t0 = -100
snapshots = [0]
[lattice]
K2 = 1
K4 = -1
[parameters]
k = 0.7
alpha = "K/2"
[scheme]
step = 0.5
[domain]
kind = "ring"
sites = 2048
compared = 400
"""

BAD_NUMBERS: list[tuple[dict[str, Any], str]] = [
    ({"eps": 0.0}, r"eps must satisfy eps > 0, got 0"),
    ({"eps": math.nan}, r"eps must be finite, got nan"),
    ({"eps": "small"}, r"eps must be a number, got 'small'"),
    ({"step": -0.5}, r"step must satisfy step > 0, got -0.5"),
    ({"K2": 0}, r"K2 must satisfy K2 > 0, got 0 \(sound travels"),
    ({"K4": math.inf}, r"K4 must be finite, got inf"),
    ({"t0": True}, r"t0 must be a number, got True"),
    ({"snapshots": (-20.0, -30.0)}, r"snapshots must satisfy t >= t0 = -20, got -30 \(start earl"),
    ({"snapshots": (0.0, -10.0)}, r"snapshots must increase, got \[0.0, -10.0\]"),
    ({"snapshots": ()}, r"snapshots must be a list of at least one time"),
    (
        {"observables": ("colour",)},
        r"must be a known one, got 'colour' \(one of strain, ",
    ),
    ({"observables": "strain"}, r"observables must be a list of names, got 'strain'"),
    ({"scheme": "euler"}, r"scheme must be a known one, got 'euler' \(one of rk4, "),
    (
        {"domain": "torus"},
        r"domain must be a known one, got 'torus' \(one of window, ring, clo",
    ),
    ({"sites": 12.5}, r"sites must be a whole number, 1 <= sites <= 1e.09, got 12.5"),
    ({"compared": 0}, r"compared must be a whole number, 1 <= compared <= 1e.09, got 0"),
    ({"eps": "0.1"}, r"eps must be a number, got '0.1' \(such as 0.05\)"),
    ({"snapshots": 5}, r"snapshots must be a list of at least one time, got 5 \(such as \["),
    ({"observables": (3,)}, r"observables must be a known one, got 3"),
    ({"parameters": 5}, r'parameters must be pairs of names and values, got 5 \(such as {"k": 0.5'),
    ({"parameters": ("k",)}, r"parameters must be pairs of names and values, got \('k',\)"),
    ({"parameters": {"k": [1]}}, r"k must be a number, got \[1\]"),
    ({"wave": 3}, r"wave must be a text or a ClosedForm, got 3"),
    ({"name": None}, r"name must be a text, got None"),
    ({"scheme": 8}, r"scheme must be a text, got 8"),
    ({"engine": 8}, r"engine must be a known one, got 8"),
    ({"engine": "spectral"}, r"tolerance must be given for engine 'spectral', got none"),
    ({"tolerance": 1e-4}, r"step must not be given with a tolerance, got 0.5"),
    ({"numerics": 1}, r"keywords must be known ones, got numerics \(one of name, wave, "),
    ({"colour": 1}, r"keywords must be known ones, got colour"),
    ({"look_points": 0}, r"look_points must be a whole number, 1 <= look_points <= 1e.09, got 0"),
]

BAD_WAVES: list[tuple[dict[str, Any], str]] = [
    ({"wave": "tsunami"}, r"tsunami.*rational_2|rational_2.*tsunami"),
    ({"parameters": (("k", 1.2),)}, r"k must satisfy 0 < k < 1, got 1.2 \(k = 1 is "),
    ({"parameters": (("k", 0),)}, r"k must satisfy 0 < k < 1, got 0"),
    ({"parameters": ()}, r"k must satisfy 0 < k < 1, got nothing"),
    ({"parameters": (("k", 0.5), ("q", 1.0))}, r"parameters must be those of rogue_cn, got q"),
    ({"K3": 0.1}, r"wave must solve the KdV equation, which is derived from fput_strain here"),
    ({"K4": -1.0}, r"K4 must satisfy K4 > 0 for rogue_cn, got -1"),
    ({"K4": 0.0}, r"K4 must satisfy K4 > 0 for rogue_cn, got 0"),
    (
        {"wave": "breather_sn", "parameters": (("k", 0.5), ("alpha", "K/2"))},
        r"K4 must satisfy K4 < 0 for breather_sn, got 1",
    ),
    (
        {"wave": "breather_sn", "K4": -1.0, "parameters": (("k", 1.5), ("alpha", "K/2"))},
        r"k must satisfy 0 < k < 1, got 1.5",
    ),
    ({"step": 1.7}, r"step must satisfy step <= 1\.\d+, got 1.7 \(linear stability limit of kahan"),
    ({"sites": 150}, r"sites must satisfy sites >= \d+ on this ring, got 150 .*widen"),
    ({"domain": "window"}, r"domain must be 'ring' for rogue_cn, got 'window'"),
]


def one_line(error: ValueError) -> str:
    text = str(error)
    assert "\n" not in text
    return text


@pytest.mark.parametrize(("changes", "message"), BAD_NUMBERS)
def test_bad_numbers_are_refused_when_the_scene_is_made(
    ring_scene: Callable[..., Scene], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        ring_scene(**changes)
    one_line(caught.value)


@pytest.mark.parametrize(("changes", "message"), BAD_WAVES)
def test_what_wave_and_lattice_do_not_admit_is_refused_before_the_run(
    ring_scene: Callable[..., Scene], changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        run(ring_scene(**changes))
    one_line(caught.value)


def test_a_window_must_clear_the_compared_sites(window_scene: Callable[..., Scene]) -> None:
    with pytest.raises(ValueError, match=r"sites must satisfy sites >= 916 in this window"):
        run(window_scene(sites=900))


@pytest.mark.parametrize("name", ["energy", "momentum"])
def test_what_needs_a_ring_is_refused_in_a_window(
    window_scene: Callable[..., Scene], name: str
) -> None:
    with pytest.raises(ValueError, match=f"domain must be 'ring' for {name}"):
        window_scene(observables=(name,))


@pytest.mark.parametrize("numerics", [1e-4, None, "ring"])
def test_numerics_are_one_of_two_records(ring_scene: Callable[..., Scene], numerics: Any) -> None:
    with pytest.raises(ValueError, match=r"numerics must be a Discretisation or a Tolerance, got"):
        replace(ring_scene(), numerics=numerics)


def test_what_is_not_stated_is_not_asked_for(ring_scene: Callable[..., Scene]) -> None:
    stated = ring_scene()
    chosen = stated.with_tolerance(1e-3)
    with pytest.raises(ValueError, match=r"step, domain and sites must be stated for this"):
        _ = chosen.discretisation
    with pytest.raises(ValueError, match=r"tolerance must be given for this"):
        _ = stated.target


@pytest.mark.parametrize("wrong", [3, None, ["rogue_cn_k_0.5"]])
def test_only_a_scene_is_run(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"scene must be a scene, its name or its file, got"):
        run(wrong)


def test_numbers_of_any_kind_become_floats_and_ints(ring_scene: Callable[..., Scene]) -> None:
    scene = ring_scene(eps=Fraction(1, 10), compared=np.int64(50), t0=np.float32(-20))
    assert scene == ring_scene()
    assert json.loads(scene.json())["compared"] == 50


def test_a_scene_shows_itself_in_one_line(ring_scene: Callable[..., Scene]) -> None:
    assert repr(ring_scene()) == (
        "<Scene short: rogue_cn with k = 0.5 on fput_strain, eps = 0.1, t = -20 .. 20, "
        "101 sites compared, kahan_li_8, step 0.5, ring of 400 sites>"
    )
    by_ring = ring_scene().with_tolerance(1e-3).changed(engine="spectral")
    assert repr(by_ring).endswith("101 sites compared, to 0.001 by spectral>")


OLD = (
    '{"K2": 1.0, "K3": 0.0, "K4": 1.0, "compared": 50, "curve_points": 5, "domain": %s, '
    '"engine": "%s", "eps": 0.1, "look_points": null, "name": "short", "observables": ["strain", '
    '"error_curve"], "parameters": [["k", 0.5]], "scheme": "%s", "sites": %d, "snapshots": '
    '[-20.0, 0.0, 20.0], "step": %g, "t0": -20.0, "title": "", "tolerance": %s, "wave": "rogue_cn"}'
)


def test_scenes_of_older_runs_are_read(ring_scene: Callable[..., Scene]) -> None:
    """Older scenes had all keys; those that did not apply were empty."""
    stated = OLD % ('"ring"', "", "kahan_li_8", 400, 0.5, "null")
    assert Scene.from_json(stated) == ring_scene()
    by_program = OLD % ('"ring"', "stencil", "kahan_li_8", 400, 0.5, "null")
    assert Scene.from_json(by_program) == ring_scene()
    chosen = OLD % ('""', "spectral", "", 0, 0.0, "0.001")
    assert Scene.from_json(chosen) == ring_scene().with_tolerance(1e-3).changed(engine="spectral")


@pytest.mark.parametrize("engine", ["", "stencil", "spectral"])
def test_a_scene_comes_back_from_its_json(ring_scene: Callable[..., Scene], engine: str) -> None:
    chosen = ring_scene().with_tolerance(1e-3).changed(engine=engine)
    for scene in (ring_scene(), chosen):
        assert Scene.from_json(scene.json()) == scene


def test_a_file_becomes_the_record(tmp_path: Path) -> None:
    path = tmp_path / "mine_0.7.toml"
    path.write_text(TEXT)
    scene = Scene.from_toml(path)
    assert scene.name == "mine_0.7"
    assert (scene.model.K2, scene.model.K3, scene.model.K4, scene.discretisation.scheme) == (
        1.0,
        0.0,
        -1.0,
        "kahan_li_8",
    )
    assert dict(scene.parameters) == {"k": 0.7, "alpha": "K/2"}
    assert json.loads(scene.json())["snapshots"] == [0.0]
    assert hash(scene) == hash(Scene.from_toml(path))
    with pytest.raises(FrozenInstanceError):
        scene.eps = 1.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "eps =",
            "epsilon =",
            r"keys must be known ones, got epsilon \(did you mean eps\? one of [0-9]+ names\)",
        ),
        ("K4 =", "K5 =", r"keys in \[lattice\] must be known ones, got K5 \(one of K2, K3, K4\)"),
        ("step =", "dt =", r"keys in \[scheme\] must be known ones, got dt \(one of name, step\)"),
        ("K2 = 1\n", "", r"K2 in \[constants\] must be stated"),
        ('kind = "ring"\n', "", r"kind in \[domain\] must be stated"),
        ("eps = 0.05", "eps = 0.05 0.06", r"must be a TOML file, got .*bad.toml"),
        ("eps = 0.05", "eps = nan", r"eps must be finite, got nan"),
        ("[scheme]\nstep = 0.5", "", r"step in \[scheme\] must be stated"),
        ("[0]", "[-101]", r"snapshots must satisfy t >= t0 = -100, got -101"),
    ],
)
def test_bad_files_are_told_with_their_name(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    assert old in TEXT
    path = tmp_path / "bad.toml"
    path.write_text(TEXT.replace(old, new))
    with pytest.raises(ValueError, match=message) as caught:
        Scene.from_toml(path)
    assert "bad.toml" in one_line(caught.value)


def test_a_missing_file_and_an_unknown_scene_are_told(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"none\.toml: No such file"):
        Scene.from_toml(tmp_path / "none.toml")
    with pytest.raises(ValueError, match=r"got 'none' .*rational_2_eps_0\.05"):
        load_scene("none")


@pytest.mark.parametrize("name", shipped_scenes())
def test_shipped_scenes_are_the_papers(name: str) -> None:
    scene = load_scene(name)
    rational = scene.wave_name.startswith("rational")
    assert (scene.model.K2, abs(scene.model.K4)) == ((4.0, 1.0) if rational else (1.0, 1.0))
    assert (-1.0 if scene.wave == "breather_sn" else 1.0) == scene.model.K4
    times = {0.05: (-10000.0, -5000.0, 0.0, 5000.0), 0.075: (-5000.0, -1000.0, 0.0, 1000.0)}
    expected = times[scene.eps] if rational else (-100.0, -100.0, 0.0, 100.0)
    assert (scene.t0, *scene.snapshots) == expected
    assert scene.discretisation.domain == ("window" if rational else "ring")


def test_all_of_the_papers_scenes_are_shipped() -> None:
    assert len(shipped_scenes()) == 9

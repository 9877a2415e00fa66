"""Scenes that name a lattice: their files, refused values, and reading them back."""

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from longwave.scenes.convergence import at_eps
from longwave.scenes.description.named_scenes import load_scene, scene_of_toml, shipped_scenes
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.domain_plan import ComparedCells
from longwave.scenes.engines.methods import expected_cost
from longwave.scenes.engines.scene_run import run
from longwave.scenes.starts.moving_wave import moving_wave

GIVEN: dict[str, Any] = {
    "name": "short",
    "lattice": "toda",
    "wave": "kdv_soliton",
    "eps": 0.2,
    "tolerance": 1e-3,
    "constants": {"a": 1, "b": "1/2"},
    "parameters": {"kappa": 1},
    "slow_times": [0, 0.1],
    "half_width": 4,
}
FILE = """
title = "short"
lattice = "cell.toml"
wave = "kdv_soliton"
eps = 0.2
times = [0, 10]
compared = 30
tolerance = 1e-3
order = "slaved"
[constants]
m = 3
[parameters]
kappa = 1
[long_wave]
amplitude = 1
"""
CELL = """
fields = ["u", "v"]
masses = [1, "m"]
[[spring]]
between = ["u[n]", "v[n]"]
force = "x + x**2"
[[spring]]
between = ["v[n]", "u[n+1]"]
force = "x + x**2"
"""


@pytest.mark.parametrize("name", shipped_scenes("lattices"))
def test_a_scene_is_what_its_json_says(name: str) -> None:
    scene = load_scene(name)
    assert Scene.from_json(scene.json()) == scene
    assert "eps" not in scene.title
    assert scene.tolerance <= 1e-3


def test_a_file_names_the_file_of_a_lattice_beside_it(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(CELL, "utf-8")
    (tmp_path / "short.toml").write_text(FILE, "utf-8")
    scene = Scene.from_toml(tmp_path / "short.toml")
    assert (scene.name, scene.lattice, scene.order) == ("short", "cell", "slaved")
    assert scene.declared is not None
    assert '"between": ["v[n]", "u[n+1]"]' in scene.declared.json
    assert (scene.snapshots, scene.compared, scene.amplitude) == ((0.0, 10.0), 30, 1)
    inline = (
        FILE.replace('lattice = "cell.toml"\n', "")
        + "[lattice]\n"
        + CELL.replace("[[spring", "[[lattice.spring")
    )
    (tmp_path / "other.toml").write_text(inline, "utf-8")
    other = Scene.from_toml(tmp_path / "other.toml")
    assert other.declared == scene.declared


@pytest.mark.parametrize(("stated", "m"), [("[constants]\nm = 3\n", 3), ("", 2.5)])
def test_a_scene_has_the_constants_that_its_lattice_was_measured_to_have(
    stated: str, m: float, tmp_path: Path
) -> None:
    cell = CELL.replace('"x + x**2"', '"K*x + x**2"')
    cell += "[constants]\nK = 1.25\nm = 2.5\n[covariance]\nK = {K = 0.01}\n"
    (tmp_path / "cell.toml").write_text(cell, "utf-8")
    (tmp_path / "short.toml").write_text(FILE.replace("[constants]\nm = 3\n", stated), "utf-8")
    scene = Scene.from_toml(tmp_path / "short.toml")
    assert dict(scene.constants) == {"K": 1.25, "m": m}
    (tmp_path / "again.toml").write_text(scene.toml(), "utf-8")
    assert Scene.from_toml(tmp_path / "again.toml").constants == scene.constants


def test_a_scene_is_run_as_its_lattice_and_wave_need(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(CELL, "utf-8")
    (tmp_path / "short.toml").write_text(FILE, "utf-8")
    assert load_scene(str(tmp_path / "short.toml")).start.method == "ring"
    assert load_scene("toda_soliton").start.method == "ring"
    assert load_scene("Y2_eps_0.05").start.method == "moving_wave"
    assert load_scene("Y2_eps_0.05").changed(order="corrected").start.method == "ring"
    with pytest.raises(ValueError, match=r"one of breather_sn_k_0\.5, .*, toda_soliton"):
        load_scene("nowhere")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"eps": "small"}, "eps must be a number, got 'small'"),
        ({"eps": 0}, "eps must satisfy eps > 0, got 0"),
        ({"eps": 3}, "eps must satisfy eps <= 1, got 3"),
        ({"eps": float("nan")}, "eps must be finite"),
        ({"tolerance": 0}, "tolerance must satisfy tolerance > 0"),
        ({"tolerance": 1e-14}, "tolerance must satisfy tolerance >= 1e-11"),
        ({"order": "third"}, "order must be a known one, got 'third'"),
        ({"wave": 3}, "wave must be a text or a ClosedForm, got 3"),
        ({"slow_times": [1]}, "slow_times must be a list of at least two times"),
        ({"slow_times": [1, 0]}, "slow_times must increase"),
        ({"slow_times": [0, "b"]}, "slow_times must be a number, got 'b'"),
        ({"slow_times": []}, "either slow_times or times must be given, got neither"),
        ({"times": [0, 1]}, "either slow_times or times must be given, got both"),
        ({"half_width": None}, "either half_width or compared must be given, got neither"),
        ({"compared": 3}, "either half_width or compared must be given, got both"),
        ({"half_width": -1}, "half_width must satisfy half_width > 0"),
        ({"half_width": None, "compared": 0}, "compared must be a whole number"),
        ({"constants": [1]}, "constants must be pairs of names and values"),
        ({"constants": {"a": True}}, "a must be a number, got True"),
        ({"constants": {"a": 10**400}}, "a must be 0 or satisfy 1e-50"),
        ({"constants": {"a": "1" * 1000}}, "a must be a short formula, got 1000 characters"),
        ({"amplitude": 1.5}, "amplitude must be a whole number"),
        ({"carrier": [1]}, "k must be a number"),
        ({"carrier": 1, "time": 3}, "time must not be given with an envelope, got 3"),
        ({"branch": 1.5}, "branch must be acoustic, optical or a number, got 1.5"),
        ({"colour": 3}, "keywords must be known ones, got colour"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match="must") as raised:
        Scene.of(**(GIVEN | changes))
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


CHAIN: dict[str, Any] = {
    "name": "chain",
    "wave": "soliton_sech",
    "parameters": {"A": 1},
    "eps": 0.1,
    "K2": 1,
    "K4": 1,
    "tolerance": 1e-3,
}
TIMED = {"t0": 0, "snapshots": [0, 50], "compared": 60}


def same(scene: Scene, other: Scene) -> bool:
    return scene == other and scene.json() == other.json()


def test_alternative_keywords_give_equal_scenes() -> None:
    expected = Scene.of(**CHAIN | TIMED)
    bare = {key: value for key, value in (CHAIN | TIMED).items() if key not in ("K2", "K4")}
    constants = {"K4": 1, "K2": 1.0, "K3": 0}
    assert same(Scene.of(**bare, constants=constants), expected)
    moments = {key: value for key, value in (CHAIN | TIMED).items() if key not in TIMED}
    assert same(Scene.of(**moments, times=[0, 50], compared=60), expected)
    slow = Scene.of(**moments, slow_times=[0, 0.05], half_width=6)
    assert (slow.t0, slow.snapshots, slow.compared) == (0.0, (0.0, 0.05 / 0.1**3), 60)


@pytest.mark.parametrize("given", [TIMED, {"slow_times": [0, 0.1], "half_width": 5.5}])
@pytest.mark.parametrize("changes", [{}, {"K3": 1}, {"order": "slaved"}, {"wave": "kink"}])
def test_a_scene_comes_back_as_it_was(given: dict[str, Any], changes: dict[str, Any]) -> None:
    scene = Scene.of(**CHAIN | given).changed(**changes)
    for again in (
        Scene.from_json(scene.json()),
        scene_of_toml(scene.toml()),
        scene.changed(),
        pickle.loads(pickle.dumps(scene)),
        copy.deepcopy(scene),
    ):
        assert same(again, scene)
    assert hash(scene) == hash(scene.changed())


def test_slow_times_and_half_width_stay_where_others_change() -> None:
    """Catches: lattice times and cells that are not recomputed when eps changes."""
    given = CHAIN | {"slow_times": [0, 0.1], "half_width": 6}
    scene = Scene.of(**given)
    assert same(scene.changed(eps=0.05), Scene.of(**given | {"eps": 0.05}))
    assert same(scene.changed(order="slaved"), Scene.of(**given | {"order": "slaved"}))
    assert scene.changed(slow_times=[0, 0.2]).end == pytest.approx(200.0)
    assert scene.changed(times=[0, 30]).slow_times == ()
    assert scene.changed(compared=7).half_width is None
    assert scene.changed(half_width=8).compared == 80


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (TIMED | {"times": [5, 9]}, "t0 must not be given with times, got both"),
        (TIMED | {"constants": {"K2": 9}}, "constants must not be given with K2, K4, got both"),
        (TIMED | {"times": 0}, "t0 must not be given with times"),
        (
            TIMED | {"slow_times": np.array([0.0, 1.0])},
            "either slow_times or times must be given, got both",
        ),
        (TIMED | {"order": "slaved", "observables": ["energ"]}, "observables must be a known one"),
        (
            {"t0": 0, "snapshots": [0], "compared": 9, "K3": 1},
            "times must hold one after the start, got 0",
        ),
        ({"slow_times": [0, 1e-80], "compared": 9}, "slow_times must be 0 or satisfy"),
    ],
)
def test_what_is_said_twice_or_cannot_be_is_one_line(given: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=rf"^{told}[^\n]*$"):
        Scene.of(**CHAIN | given)


FILE_OF_CHAIN = """
wave = "soliton_sech"
eps = 0.1
times = [0, 50]
tolerance = 1e-3
compared = 9
lattice = {K2 = 1, K4 = 1}
"""


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[constants]\nK2 = 7", "K2, K3 and K4 must be"),
        (
            "[domain]\ncompared = 7",
            "compared must be given",
        ),
        (
            "[envelope]\nk = ''",
            r"k in \[envelope\] must be",
        ),
    ],
)
def test_a_file_that_says_a_thing_twice_is_refused(text: str, told: str) -> None:
    with pytest.raises(ValueError, match=told) as caught:
        scene_of_toml(FILE_OF_CHAIN + text)
    assert "\n" not in str(caught.value)


def test_parameters_are_formulas_or_multiples_of_K_at_every_order() -> None:
    half = Scene.of(**CHAIN | TIMED | {"parameters": {"A": "1/2"}})
    assert moving_wave(half).wave.numbers.a == pytest.approx(
        moving_wave(Scene.of(**CHAIN | TIMED | {"parameters": {"A": 0.5}})).wave.numbers.a
    )
    snoidal = {"wave": "breather_sn", "parameters": {"k": 0.7, "alpha": "K/2"}, "K4": -1}
    for order in ("leading", "slaved"):
        scene = Scene.of(**CHAIN | TIMED | snoidal | {"order": order})
        assert expected_cost(scene).seconds > 0.0


def test_a_scene_runs_itself() -> None:
    """`longwave.scenes` gives descriptions the function that runs scenes."""
    scene = Scene.of(**GIVEN)
    assert scene.run().strain.identical(run(scene).strain)


def test_cells_of_a_half_width_are_whole_at_any_eps() -> None:
    for compared in range(1, 400):
        scene = Scene.of(**CHAIN | TIMED | {"compared": compared})
        assert at_eps(scene, scene.eps).compared == compared


def test_a_ring_contains_the_compared_cells_and_all_that_can_affect_them() -> None:
    compared = ComparedCells(0.5, (10,))
    times = (0.0, 100.0)
    [(low, high)] = compared.ring(times, [2.0], 0)
    assert low <= 50 - 10 - 200
    assert high >= 50 + 10 + 200
    [(low_wider, high_wider)] = compared.ring(times, [2.0], 64)
    assert (high_wider - low_wider) - (high - low) == 64
    [part] = compared.slices([(low, high)], 100.0)
    assert (part.start + low, part.stop - 1 + low) == (40, 60)

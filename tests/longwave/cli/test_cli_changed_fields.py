"""`--set` and `--json` of scenes and sweeps: the same values reach every command and are checked.

Catches: a set field that does not reach the run, a wrong one that is reported after seconds of
work, two values of which one is dropped, JSON that no other program can read.
"""

import json
from pathlib import Path
from typing import Any

import pytest

import longwave.cli.sweep_command
from longwave.__main__ import main
from longwave.reports.pictures import animation, plotting
from longwave.runs.run_file import load_run, save_run, scene_of_run
from longwave.runs.sweep_file import load_sweep
from longwave.runs.sweep_scene import changed_scene
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from tests.longwave.cli.short_chain import CHAIN

Output = pytest.CaptureFixture[str]

SWEEP = 'scene = "chain.toml"\n[grid]\neps = [0.2, 0.25]\n'


def strict(text: str) -> Any:
    """Parse JSON; reject NaN and Infinity, which only Python's parser accepts."""

    def refused(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refused)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("chain.toml").write_text(CHAIN, encoding="utf-8")
    Path("sweep.toml").write_text(SWEEP, encoding="utf-8")
    return tmp_path


@pytest.mark.usefixtures("folder")
def test_set_values_are_run_and_printed_as_json(capsys: Output) -> None:
    words = ["run", "chain.toml", "--set", "eps=0.25,parameters.A=1.5", "--set", "times=[0, 5]"]
    assert main([*words, "--json", "--output", "run.nc"]) == 0
    report = strict(capsys.readouterr().out)
    assert (report["scene"]["eps"], report["scene"]["parameters"]) == (0.25, {"A": 1.5})
    assert report["times"] == [0.0, 5.0]
    assert len(report["variables"]["error"]["values"]) == 2
    assert report["attributes"]["error_estimate"] <= 1e-3
    saved = scene_of_run(load_run("run.nc"))
    assert saved.changed(name="chain") == changed_scene(
        "chain.toml", {"eps": 0.25, "parameters.A": 1.5, "times": [0, 5]}
    ).changed(name="chain")


@pytest.mark.usefixtures("folder")
def test_a_repeated_run_is_compared_as_json(capsys: Output) -> None:
    save_run(load_scene("chain.toml").run(), "run.nc")
    assert main(["run", "run.nc", "--json"]) == 0
    report = strict(capsys.readouterr().out)
    assert (report["run"], report["same_bits"]) == ("run.nc", True)


@pytest.mark.usefixtures("folder")
def test_a_sweep_takes_set_values_and_prints_its_cells_as_json(
    capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = load_sweep("sweep.toml", {"lattice.K4": 2, "parameters.A": 0.5})
    assert [dict(sweep.scene(cell).constants)["K4"] for cell in (0, 1)] == [2, 2]
    monkeypatch.setattr(longwave.cli.sweep_command, "run_with_progress", lambda *_: None)
    words = ["sweep", "sweep.toml", "--set", "parameters.A=0.5", "--processes", "1", "--json"]
    assert main(words) == 1
    report = strict(capsys.readouterr().out)
    assert [cell["set"] for cell in report["cells"]] == [{"eps": 0.2}, {"eps": 0.25}]
    assert {cell["status"] for cell in report["cells"]} == {"missing"}
    assert report["cells"][0]["error"] is None


@pytest.mark.usefixtures("folder")
def test_pictures_films_and_rates_take_set_values(monkeypatch: pytest.MonkeyPatch) -> None:
    met: list[Scene] = []

    def seen(scene: Scene, *_: object, **__: object) -> int:
        met.append(scene)
        raise ValueError("seen")

    monkeypatch.setattr(plotting, "plot", seen)
    monkeypatch.setattr(animation, "animate", seen)
    monkeypatch.setattr("longwave.scenes.convergence.scene_convergence", seen)
    for command in ("plot", "animate", "converge"):
        assert main([command, "chain.toml", "--set", "lattice.K4=3"]) == 2
    assert [dict(scene.constants)["K4"] for scene in met] == [3, 3, 3]


def test_a_scene_on_standard_input_and_one_repaired_by_set(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    Path("wrong.toml").write_text(CHAIN.replace("eps = 0.2", "eps = 7"), encoding="utf-8")
    scene = changed_scene("wrong.toml", {"eps": 0.2})
    assert scene.changed(name="chain") == load_scene("chain.toml")
    assert changed_scene(str(folder / "wrong.toml"), {"eps": 0.2}) == scene


WRONG = [
    (["run", "S", "--set", "eps"], "--set must be NAME=VALUE, got 'eps' (such as eps=0.05"),
    (["run", "S", "--set", "eps="], "--set must be NAME=VALUE, got 'eps='"),
    (["run", "S", "--set", "eps=1,eps=2"], "--set must give eps one value, got 1 and 2"),
    (["run", "S", "--set", "eps=1", "--set", "eps=2"], "--set must give eps one value"),
    (["run", "S", "--set", "eps=five"], "eps must be a number, got 'five'"),
    (["run", "S", "--set", "eps=inf"], "eps must be finite, got inf"),
    (["run", "S", "--set", "colour=3"], "fields must be known ones, got 'colour' (one of"),
    (["run", "S", "--set", "K4=2"], "with their table, got K4 (write constants.K4)"),
    (["run", "S", "--set", "A=2"], "got A (write parameters.A)"),
    (["run", "S", "--set", "title=x"], "fields must be known ones, got 'title'"),
    (["run", "S", "--set", "tolerance=1", "--tolerance", "1"], "tolerance must be given once"),
    (["run", "S", "--set", "engine=x", "--engine", "x"], "engine must be given once"),
    (["run", "S", "--set", "scheme.step=1"], "step must not be given with a tolerance"),
    (["run", "R", "--set", "eps=0.1"], "--set must not be given with a run, got eps=0.1"),
    (["plot", "R", "--set", "eps=0.1"], "--set must not be given with the file of a run"),
    (["animate", "R", "--set", "eps=0.1"], "--set must not be given with the file of a run"),
    (["converge", "S", "--set", "eps=1", "--eps", "1,2,3"], "eps must be given once"),
    (["sweep", "W", "--set", "eps=0.1"], "--set must not name a swept field, got eps"),
    (["derive", "--set", "K2=1,K2=2"], "--set must give K2 one value, got 1 and 2 (leave one"),
    (["derive", "--k2", "1", "--set", "K2=2"], "got --k2 1 and --set K2=2 (leave one out)"),
    (["derive", "--losses", "site=1,site=2"], "--losses must give site one value"),
    (["fit", "f.csv", "--fix", "K2=1,K2=2"], "--fix must give K2 one value"),
    (["plot", "W.nc", "--at", "eps=1,eps=2"], "--at must give eps one value"),
]


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("words", "message"), WRONG)
def test_a_wrong_set_value_is_a_one_line_error(
    words: list[str], message: str, capsys: Output
) -> None:
    files = {"S": "chain.toml", "W": "sweep.toml", "R": "run.nc"}
    Path("run.nc").write_bytes(b"\x89HDF\r\n\x1a\n")
    assert main([files.get(word, word) for word in words]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.count("\n") == 1
    assert message in output.err

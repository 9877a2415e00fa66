"""Catches: a kill that costs more than the last seconds of a run, or foreign checkpoints used."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from longwave.cli.scene_command import run_and_print
from longwave.runs import run_output
from longwave.runs.run_file import load_run
from longwave.scenes.engines import scene_run
from longwave.support.checkpoint import CheckpointFolder
from tests.runs.unfinished_scenes import SCENES, Killed, bits

NAME = "stated window, refined"


@pytest.fixture
def saved(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Save every checkpoint, until the write with a given number raises an error."""
    report: dict[str, Any] = {"writes": 0, "at": 10**9, "raised": Killed}
    write = CheckpointFolder.write

    def counted(folder: CheckpointFolder, *memory: Any) -> None:
        if report["writes"] == report["at"]:
            raise report["raised"]
        report["writes"] += 1
        write(folder, *memory)

    monkeypatch.setattr(CheckpointFolder, "write", counted)
    monkeypatch.setattr(run_output, "CHECKPOINT_PACE", (0.0, 1e9))
    monkeypatch.setattr("os.fsync", lambda _: None)
    return report


def run(folder: Path, output: str = "run.nc", **changes: Any) -> int:
    scene = folder / "scene.toml"
    scene.write_text(SCENES[NAME].changed(**changes).toml(), encoding="utf-8")
    return run_and_print(str(scene), "longwave run", output=str(folder / output))


@pytest.mark.slow
def test_a_run_is_resumed_next_to_its_output(
    tmp_path: Path, saved: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(tmp_path, "whole.nc") == 0
    whole, saved["writes"], saved["at"] = saved["writes"], 0, 5
    with pytest.raises(Killed):
        run(tmp_path)
    assert (tmp_path / "run.nc.checkpoint").is_dir()
    capsys.readouterr()
    saved["writes"], saved["at"] = 0, 10**9
    assert run(tmp_path) == 0
    assert capsys.readouterr().err == "window: goes on where it was broken off\n"
    assert saved["writes"] < whole
    assert bits(load_run(tmp_path / "run.nc")) == bits(scene_run.run(SCENES[NAME]))
    assert {path.name for path in tmp_path.iterdir()} == {"scene.toml", "run.nc", "whole.nc"}


def test_checkpoints_of_another_scene_are_not_used_and_other_files_stay(
    tmp_path: Path, saved: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    saved["at"] = 5
    with pytest.raises(Killed):
        run(tmp_path, eps=0.11)
    mine = tmp_path / "run.nc.checkpoint" / "mine.txt"
    mine.write_text("mine", encoding="utf-8")
    saved["at"] = 10**9
    capsys.readouterr()
    assert run(tmp_path) == 0
    said = f"window: begins anew: {mine.parent} has no checkpoint of this scene, code and machine\n"
    assert capsys.readouterr().err == said
    assert bits(load_run(tmp_path / "run.nc")) == bits(scene_run.run(SCENES[NAME]))
    assert list(mine.parent.iterdir()) == [mine]


def test_ctrl_c_says_how_to_resume(
    tmp_path: Path, saved: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    saved.update(at=5, raised=KeyboardInterrupt)
    assert run(tmp_path) == 130
    assert "run.nc; repeat the command with --force to resume" in capsys.readouterr().err
    assert "Ctrl-C" in load_run(tmp_path / "run.nc").attrs["unfinished"]
    assert (tmp_path / "run.nc.checkpoint").is_dir()


@pytest.mark.parametrize("taken", [True, False])
def test_a_run_continues_without_a_checkpoint_folder(
    taken: bool, tmp_path: Path, saved: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    """A file has the folder's name, or the name is too long."""
    name = "run.nc" if taken else "a" * 250 + ".nc"
    if taken:
        (tmp_path / "run.nc.checkpoint").write_text("mine", encoding="utf-8")
    assert run(tmp_path, name) == 0
    assert "the run goes on without a checkpoint" in capsys.readouterr().err
    assert load_run(tmp_path / name).attrs["title"]
    assert not taken or (tmp_path / "run.nc.checkpoint").read_text(encoding="utf-8") == "mine"

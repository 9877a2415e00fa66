"""`longwave plot`: the output file, wrong input, and the picture after Ctrl-C."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from house import HOUSE
from longwave.__main__ import main
from longwave.cli.command_tree import RUN_PICTURES
from longwave.reports.pictures import plotting as drawing
from longwave.reports.pictures.plotting import ALL
from longwave.reports.pictures.plotting import PICTURES as KINDS
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.run_record import RunRecord, UnfinishedRun

Output = pytest.CaptureFixture[str]

NOTHING = RunRecord(load_scene("rogue_cn_k_0.5"), (9,), (), {}, {})


def test_the_kinds_are_those_that_are_drawn() -> None:
    assert (ALL, *KINDS) == RUN_PICTURES


def test_a_shipped_scene_is_drawn_into_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Output
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["plot", "rogue_cn_k_0.5", "--kind", "snapshots"]) == 0
    assert capsys.readouterr().out == "rogue_cn_k_0.5.png\n"
    assert Path("rogue_cn_k_0.5.png").read_bytes().startswith(b"\x89PNG")


def test_a_picture_that_is_there_is_refused_before_anything_is_imported(tmp_path: Path) -> None:
    picture = tmp_path / "toda.png"
    picture.touch()
    line = ["plot", "toda_soliton", "--output", str(picture)]
    script = (
        "import sys; from longwave.__main__ import main; status = main(sys.argv[1:]);"
        "heavy = {'matplotlib', 'xarray', 'numpy'} & set(sys.modules);"
        "sys.exit(', '.join(heavy) or status)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *line],
        capture_output=True,
        text=True,
        cwd=HOUSE,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert "which exists (--force overwrites it)" in done.stderr


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (["nowhere"], "scene must be a TOML file or a shipped scene, got 'nowhere'"),
        (["nowhere.nc"], "got nowhere.nc"),
        (["rogue_cn_k_0.5", "--output", "x.gif"], ".svg"),
        (["rogue_cn_k_0.5", "--output", "/nowhere/x.png"], "must lie in an existing folder"),
        (["rogue_cn_k_0.5", "--output", "/tmp/"], "must name a file, got the folder /tmp/"),
        (["rogue_cn_k_0.5", "--kind", "movie"], "'movie' is not one of 'all', 'snapshots'"),
    ],
)
def test_wrong_input_is_one_line_and_status_2(
    argv: list[str], message: str, capsys: Output
) -> None:
    assert main(["plot", *argv]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("error: ")
    assert output.err.count("\n") == 1
    assert message in output.err


@pytest.mark.parametrize(
    ("stop", "drawable", "printed_text"),
    [
        (UnfinishedRun(NOTHING), True, "what was run until then is in x.png"),
        (UnfinishedRun(NOTHING), False, "too little was run to be drawn"),
        (KeyboardInterrupt(), True, "nothing was drawn yet"),
    ],
)
def test_ctrl_c_draws_what_was_run(
    stop: BaseException,
    drawable: bool,
    printed_text: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Output,
) -> None:
    def plot(source: Any, *_: object, **__: object) -> None:
        if isinstance(source, Scene):
            raise stop
        if not drawable:
            raise ValueError("source must hold what is drawn")

    monkeypatch.setattr(drawing, "plot", plot)
    assert main(["plot", "rogue_cn_k_0.5", "--output", "x.png"]) == 130
    assert capsys.readouterr().err == f"longwave plot: interrupted ({printed_text})\n"

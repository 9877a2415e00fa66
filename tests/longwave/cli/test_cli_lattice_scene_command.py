"""`longwave run`, `plot` and `converge` of scenes on any lattice."""

import json
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from longwave.__main__ import main
from longwave.runs import load_run

Output = pytest.CaptureFixture[str]

SCENE = """
title = "[red]soliton"
lattice = "toda"
wave = "kdv_soliton"
eps = 0.4
slow_times = [0, 0.5]
half_width = 6
tolerance = 1e-3
[constants]
a = 1
b = 1
[parameters]
kappa = 1
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "soliton.toml"
    path.write_text(SCENE, "utf-8")
    return path


@pytest.mark.slow
def test_a_run_is_printed_written_and_drawn(scene: Path, capsys: Output) -> None:
    run, picture = scene.with_suffix(".nc"), scene.with_suffix(".png")
    assert main(["run", str(scene), "--output", str(run)]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("[red]soliton\n")
    assert "toda, eps = 0.4, leading order; KdV: Y_T + (1/(2 c)) Y Y_X" in printed
    assert "of 0.001 allowed" in printed
    assert "energy kept to" in printed
    assert load_run(run)["strain"].dims == ("time", "site")
    assert main(["plot", str(run), "--output", str(picture)]) == 0
    assert matplotlib.image.imread(picture).shape[1] == 1400
    assert main(["plot", str(run), "--kind", "crest", "--output", str(picture), "--force"]) == 0


@pytest.mark.parametrize("stated", ["tolerance = 1e-3\n", ""])
def test_a_tolerance_of_the_command_line_is_kept(stated: str, scene: Path, capsys: Output) -> None:
    scene.write_text(SCENE.replace("tolerance = 1e-3\n", stated), "utf-8")
    assert main(["run", str(scene), "--tolerance", "1e-7"]) == 0
    assert "of 1e-07 allowed" in capsys.readouterr().out


def test_the_rate_is_printed_as_a_table_and_as_json_and_drawn(scene: Path, capsys: Output) -> None:
    picture = scene.with_suffix(".png")
    words = ["converge", str(scene), "--eps", "0.4,0.3,0.2"]
    assert main([*words, "--output", str(picture)]) == 0
    printed = capsys.readouterr().out
    assert "toda, KdV, leading order: the sup error falls as eps^rate" in printed
    assert "rate 3.8 (3.8 .. 5.1), theory 4\n" in printed
    assert np.ptp(matplotlib.image.imread(picture)[..., :3]) > 0.5
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["equation"], found["power"]) == ("KdV", 2)
    assert [point["eps"] for point in found["points"]] == [0.4, 0.3, 0.2]
    assert found["rate"] == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("half_width", "halfwidth", "keys must be known ones, got halfwidth"),
        ('"toda"', "3", "lattice must be a name, a file or a table, got 3"),
        ('"toda"', '"nowhere.toml"', "lattice must be a file beside the scene"),
        ('wave = "kdv_soliton"\n', "", "wave must be stated, got nothing"),
        ("[constants]", "[envelope]\n[constants]", "k in [envelope] must be stated, got nothing"),
        ("[constants]", "[long_wave]\nspeed = 1\n[constants]", "keys in [long_wave] must be known"),
        ("kappa = 1", "kappa = 1\n[long_wave]\n[envelope]\nk = 1", "got both (leave one)"),
        ("a = 1", "a = 1979-05-27", "a must be a number, got datetime.date(1979, 5, 27)"),
        ("a = 1", "a = ", "scene must be a TOML file, got"),
        ("a = 1", "a = '\\\\x1b[31m'", "a: expected"),
    ],
)
def test_a_wrong_file_is_one_line_and_status_2(
    scene: Path, old: str, new: str, message: str, capsys: Output
) -> None:
    scene.write_text(SCENE.replace(old, new), "utf-8")
    assert main(["run", str(scene)]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("error: ")
    assert output.err.count("\n") == 1
    assert message in output.err


def test_ctrl_c_is_one_line_and_status_130(
    scene: Path, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("longwave.lattice.dynamics.Dynamics.advance", stop)
    saved_item = {"run": "1 snapshots are kept", "converge": "nothing was saved"}
    for word, report in saved_item.items():
        assert main([word, str(scene)]) == 130
        assert capsys.readouterr().err == f"longwave {word}: interrupted ({report})\n"

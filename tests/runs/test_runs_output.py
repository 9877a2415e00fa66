"""Catches: a run lost at its end, a file overwritten without --force, different bits unnoticed."""

import errno
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from longwave.__main__ import main
from longwave.runs import load_run, run_output, save_run
from longwave.runs.repeated_run import compare_runs

SCENE = """
wave = "soliton_sech"
eps = 0.2
t0 = 0
snapshots = [0, 5]
curve_points = 2
[lattice]
K2 = 1
K4 = 1
[parameters]
A = 1
[scheme]
step = 0.5
[domain]
kind = "ring"
sites = 256
compared = 50
"""

Output = pytest.CaptureFixture[str]


@pytest.fixture
def scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def run_file(scene: Path, capsys: Output) -> Path:
    path = scene.with_name("run.nc")
    assert main(["run", str(scene), "--output", str(path)]) == 0
    capsys.readouterr()
    return path


@pytest.mark.parametrize(
    ("output", "words", "message"),
    [
        ("scene.toml", [], "--output must end in .nc, got 'scene.toml' (such as run.nc)"),
        ("scene.toml", ["--force"], "--output must end in .nc"),
        ("nowhere/run.nc", [], "--output must lie in an existing folder, got nowhere/run.nc"),
        ("folder.nc", [], "--output must name a file, got the folder folder.nc"),
        ("pipe.nc", ["--force"], "--output must name a file, got pipe.nc, which is not a file"),
        ("run.nc", [], "must name a new file, got run.nc, which exists (--force overwrites it)"),
        ("text.nc", ["--force"], "must name a new file or a run, got text.nc, another file"),
        ("/proc/run.nc", [], "must lie in a writable folder, got /proc: "),
    ],
)
def test_an_unwritable_output_is_refused_before_the_run(
    run_file: Path, output: str, words: list[str], message: str, capsys: Output
) -> None:
    folder = run_file.parent
    (folder / "folder.nc").mkdir()
    os.mkfifo(folder / "pipe.nc")
    (folder / "text.nc").write_text("precious")
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    assert main(["run", "scene.toml", "--output", output, *words]) == 2
    found = capsys.readouterr()
    assert found.out == ""
    assert found.err.count("\n") == 1
    assert message in found.err
    assert {path: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


def test_force_overwrites_a_run(run_file: Path) -> None:
    before = run_file.stat().st_ino
    assert main(["run", "scene.toml", "--output", "run.nc", "--force"]) == 0
    assert run_file.stat().st_ino != before
    assert load_run(run_file).attrs["steps"] == 10


@pytest.mark.parametrize("source", ["scene.toml", "run.nc"])
def test_a_disk_that_is_full_at_the_end_loses_nothing(
    run_file: Path, source: str, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    older = run_file.read_bytes()

    def full(run: Any, path: str | Path, force: bool = True) -> None:
        if Path(path).parent == Path():
            raise OSError(errno.ENOSPC, "No space left on device", str(path))
        save_run(run, path, force)

    monkeypatch.setattr(run_output, "save_run", full)
    assert main(["run", source, "--output", "run.nc", "--force"]) == 1
    found = capsys.readouterr()
    assert found.out
    message, _, saved_item = found.err.strip().removesuffix(")").partition(" (the run is saved in ")
    assert message == "error: run.nc: No space left on device"
    assert run_file.read_bytes() == older
    assert compare_runs(load_run(run_file), load_run(saved_item)).is_same
    Path(saved_item).unlink()
    Path(saved_item).parent.rmdir()


def test_a_store_that_is_full_at_the_end_loses_nothing(
    scene: Path, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "store/x.nc")

    monkeypatch.setattr("longwave.support.sealed_file.write_atomically", full)
    assert main(["run", str(scene), "--store", "store"]) == 1
    message = capsys.readouterr().err
    assert "x.nc: No space left on device (the run is saved in " in message
    saved_item = Path(message.strip().removesuffix(")").rpartition(" ")[2])
    assert load_run(saved_item).attrs["steps"] == 10
    saved_item.unlink()
    saved_item.parent.rmdir()


def test_a_stored_run_is_printed_the_same_and_not_run_again(
    scene: Path, capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    printed, report = [], ""
    for _ in range(2):
        assert main(["run", str(scene), "--store", "store", "--output", "copy.nc", "--force"]) == 0
        out, report = capsys.readouterr()
        printed.append(out)
        monkeypatch.setattr("longwave.scenes.engines.lattice_run.record_scene", None)
    assert printed[0] == printed[1]
    assert "10 steps, 256 sites" in printed[0]
    (saved_item,) = Path("store").rglob("*.nc")
    assert report == f"scene: found in {saved_item}, not run again\n"
    assert compare_runs(load_run(saved_item), load_run("copy.nc")).is_same


def test_a_run_repeated_from_its_file_has_the_same_bits(run_file: Path, capsys: Output) -> None:
    assert main(["run", "run.nc"]) == 0
    assert capsys.readouterr().out == (
        "run.nc: same bits: all 917 values, and what was chosen and estimated\n"
        "code, packages and machine are the same\n"
    )


def test_differences_of_a_repeated_run_are_printed(run_file: Path, capsys: Output) -> None:
    other = load_run(run_file)
    other["strain"][1, 7] += 2.0**-60
    other["error"][0] = -0.0
    other.attrs |= {"steps": 2**40, "least_strain": float("nan")}
    other.attrs["code"] = other.attrs["code"].replace("derive/models ", "derive/models 00")
    other.attrs["versions"] = "longwave 0.0.1"
    save_run(other.drop_vars("analytic"), run_file)
    assert main(["run", "run.nc"]) == 1
    first, *lines = capsys.readouterr().out.splitlines()
    assert first == "run.nc: other bits:"
    report = "\n".join(lines)
    assert "  analytic is new" in report
    assert "  strain: 1 of 202 values differ, by at most 8.7e-19 where they reach 0.2" in report
    assert "  error: 1 of 2 values differ, by at most " in report
    assert "  steps: 10, was 1099511627776" in report
    assert "  least_strain: " in report
    assert "code: derive/models " in report
    assert "versions: " in report
    assert "was longwave 0.0.1" in report
    assert "platform" not in report


def test_bits_are_compared_and_not_values(run_file: Path) -> None:
    one, other = load_run(run_file), load_run(run_file)
    for run, sign in ((one, 1.0), (other, -1.0)):
        run["strain"][0, 0] = np.copysign(np.nan, sign)
    assert not compare_runs(one, other).is_same
    assert compare_runs(one, one).is_same


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--tolerance", "1e-3"], "--tolerance must not be given with a run, got 0.001"),
        (["--store", "s"], "--store must not be given with a run, got s"),
        (["--engine", "stencil"], "--engine must not be given with a run"),
    ],
)
def test_a_repetition_takes_no_other_options(
    run_file: Path, words: list[str], message: str, capsys: Output
) -> None:
    assert main(["run", "run.nc", *words]) == 2
    assert message in capsys.readouterr().err


def test_an_unfinished_run_is_not_repeated(run_file: Path, capsys: Output) -> None:
    other = load_run(run_file)
    other.attrs["unfinished"] = "Ctrl-C after t = 3 of 5"
    save_run(other, run_file)
    assert main(["run", "run.nc"]) == 2
    assert "got run.nc, unfinished: Ctrl-C after t = 3 of 5" in capsys.readouterr().err

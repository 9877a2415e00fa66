"""`longwave sweep`: which files it overwrites, and its messages during the run."""

import errno
import re
import time
from pathlib import Path

import pytest

from longwave.__main__ import main
from longwave.cli import sweep_command
from longwave.cli.sweep_command import sweep_and_print
from longwave.runs import sweep_dataset
from longwave.runs.run_store import RunStore
from longwave.runs.sweep_file import load_sweep
from longwave.support import slow_work

TEXT = 'scene = "toda_soliton"\n[grid]\neps = [0.1, 0.2]\n'


@pytest.mark.parametrize(("name", "report"), [("sw.toml", "end in .nc"), ("sw.nc", "another file")])
def test_force_overwrites_nothing_but_results(
    name: str, report: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "sw.toml"
    for file in (path, tmp_path / name):
        file.write_text(TEXT, encoding="utf-8")
    written = str(tmp_path / name)
    assert sweep_and_print(str(path), "sweep", processes=1, output=written, force=True) == 2
    assert report in capsys.readouterr().err
    assert (tmp_path / name).read_text(encoding="utf-8") == TEXT


def test_a_store_is_not_the_file_of_its_sweep(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Otherwise the error would come after all cells were run."""
    path, both = tmp_path / "sw.toml", str(tmp_path / "both.nc")
    path.write_text(TEXT, encoding="utf-8")
    assert sweep_and_print(str(path), "sweep", output=both, store=both) == 2
    assert "--output must differ from the folder --store, got" in capsys.readouterr().err
    assert not Path(both).exists()


@pytest.mark.slow
def test_a_full_disk_at_the_end_names_the_saved_cells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "sw.nc")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sweep_dataset, "write_sweep", full)
    Path("sw.toml").write_text(TEXT, encoding="utf-8")
    for _ in ("run", "found again"):
        assert sweep_and_print("sw.toml", "longwave sweep", processes=1) == 1
        *_, report = capsys.readouterr().err.splitlines()
        saved_item = "2 of 2 cells are saved; repeat the command for the rest"
        assert report == f"error: sw.nc: No space left on device ({saved_item})"


@pytest.mark.slow
def test_a_damaged_pack_is_reported_once_and_one_cell_in_the_singular(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("sw.toml").write_text(TEXT.replace("0.1, 0.2", "0.2"), encoding="utf-8")
    for damaged in (0, 1):
        assert sweep_and_print("sw.toml", "longwave sweep", processes=1) == 0
        report = capsys.readouterr()
        assert "1 was run now by 1 worker, " in report.out
        (error,) = (line for line in report.out.splitlines() if line.startswith("relative error"))
        assert " to " not in error
        assert report.err.count("is damaged") == damaged
        for pack in Path("sw.store", "packs").rglob("*.h5"):
            pack.write_bytes(pack.read_bytes()[:-100])


def test_a_sweep_is_no_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "sw.toml"
    path.write_text(TEXT, encoding="utf-8")
    assert main(["run", str(path)]) == 2
    report = "a scene must be one, got a sweep, which has [grid] (run it with `longwave sweep`)"
    assert capsys.readouterr().err == f"error: {path}: {report}\n"


def test_a_slow_sweep_shows_its_progress(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Progress is shown before the first cell is done, because a worker takes seconds to start."""
    message = ""

    def nothing_yet(*_: object) -> None:
        nonlocal message
        end = time.monotonic() + 600.0
        while "2 cells" not in message and time.monotonic() < end:
            time.sleep(0.01)
            message += capsys.readouterr().err

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(slow_work, "EVERY", 0.0)
    monkeypatch.setattr(sweep_command, "run_with_progress", nothing_yet)
    path = tmp_path / "sw.toml"
    path.write_text(TEXT, encoding="utf-8")
    store = str(tmp_path / "store")
    assert sweep_and_print(str(path), "longwave sweep", processes=1, store=store) == 1
    assert re.search(r"sw, 2 cells: .*(left|so far) \(Ctrl-C stops it\)", message)


def test_messages_of_the_store_are_printed_as_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The sweep also finds a damaged run in a file of its own."""
    (tmp_path / "sw.toml").write_text(TEXT, encoding="utf-8")
    store = RunStore(tmp_path / "store")
    path = store.path(load_sweep(str(tmp_path / "sw.toml")).scene(0))
    path.parent.mkdir(parents=True)
    path.write_bytes(b"damaged")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sweep_command, "run_with_progress", lambda *_: None)
    saved_item = str(store.folder)
    assert sweep_and_print("sw.toml", "longwave sweep", processes=1, store=saved_item) == 1
    report = f"{path} is damaged: it counts as missing, and is made anew"
    assert report in capsys.readouterr().err.splitlines()

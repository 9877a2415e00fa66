"""Catches: a run or pack that a network file system loses, truncates or has computed too often."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from longwave.runs import store_packs
from longwave.runs import sweep as sweep_module
from longwave.runs.run_file import load_run
from longwave.runs.run_store import RunStore
from longwave.runs.sweep import run_sweep
from longwave.runs.sweep_dataset import sweep_dataset
from longwave.scenes.engines import scene_run
from longwave.support.compiled import cores
from longwave.support.sealed_file import read_sealed
from tests.runs.shared_store import Report, SharedStore, scenes
from tests.runs.test_runs_sweep import HereWorkers, small_sweep
from tests.runs.unfinished_scenes import bits
from tests.support.failing_folder import BLIND, REFUSED, WORK, FailingFolder

Ask = Callable[[SharedStore], list[Report]]


@pytest.fixture(scope="module")
def ask() -> Iterator[Ask]:
    """Return a function that lets processes share a store and returns their reports."""
    command = [sys.executable, "-m", "tests.runs.shared_store"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=Path(__file__).parents[2], **pipes) as process:

        def reports(shared: SharedStore) -> list[Report]:
            assert process.stdin is not None
            assert process.stdout is not None
            print(json.dumps(vars(shared)), file=process.stdin, flush=True)
            return [Report(**report) for report in json.loads(process.stdout.readline())]

        try:
            yield reports
        finally:
            process.kill()


def check_shared(ask: Ask, folder: Path, runs: int, locks: tuple[str, ...], **options: Any) -> None:
    """Check that nothing is lost, truncated, left behind, or computed more often than reported."""
    reports = ask(SharedStore(str(folder), runs, list(locks), **options))
    counts = Counter(number for report in reports for number in report.computed)
    assert counts.keys() == {*range(runs)}
    assert max(counts.values()) <= (1 if {*locks} == {WORK} else len(locks))
    for report, kind in zip(reports, locks, strict=True):
        assert len(report.messages) <= (kind != WORK), report.messages
        assert all("files cannot be locked there" in message for message in report.messages)
    assert any(report.messages for report in reports) == ({*locks} != {WORK})
    store = RunStore(folder)
    paths = {scene: store.path(scene) for scene in scenes(runs)}
    assert {scene: store.find(scene) for scene in paths} == paths
    for path in {path.read_bytes(): path for path in paths.values()}.values():
        assert load_run(path).sizes["time"] == 2
    new = {folder / f"{of}-{count}.new": count for of in range(len(locks)) for count in range(runs)}
    assert {path: int(read_sealed(path) or b"-1") for path in new} == new
    assert {path for path in folder.rglob("*") if path.is_file()} == {*paths.values(), *new}


@pytest.mark.parametrize(
    ("locks", "links"),
    [
        pytest.param((WORK, WORK, WORK), True, marks=pytest.mark.slow),
        pytest.param((REFUSED, REFUSED, REFUSED), False, marks=pytest.mark.slow),
        ((BLIND, BLIND, BLIND), True),
        ((WORK, REFUSED, BLIND), False),
    ],
)
def test_three_processes_share_a_store(
    locks: tuple[str, ...], links: bool, ask: Ask, tmp_path: Path
) -> None:
    check_shared(ask, tmp_path, 20, locks, links=links)


@pytest.mark.slow
@pytest.mark.parametrize("links", [True, False])
@pytest.mark.parametrize("locks", [WORK, REFUSED, BLIND])
def test_three_processes_share_a_store_of_a_thousand_runs(
    locks: str, links: bool, ask: Ask, tmp_path: Path
) -> None:
    check_shared(ask, tmp_path, 1000, (locks,) * 3, links=links)


@pytest.mark.slow
def test_three_processes_share_a_store_of_many_real_runs(ask: Ask, tmp_path: Path) -> None:
    check_shared(ask, tmp_path, 40, (WORK,) * 3, real=True)
    check_shared(ask, tmp_path / "other", 40, (BLIND,) * 3, real=True)


def test_two_writers_without_locks_delete_nothing_of_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second one starts and saves the run just before the first one renames its draft."""
    store, (scene,) = RunStore(tmp_path), scenes(1)
    run, replace = scene_run.run(scene), os.replace
    monkeypatch.setattr(fcntl, "flock", lambda *_: None)

    def late(*given: Any) -> None:
        monkeypatch.setattr(os, "replace", replace)
        store.keep(scene, run)
        replace(*given)

    monkeypatch.setattr(os, "replace", late)
    path = store.keep(scene, run)
    assert bits(load_run(path)) == bits(run)
    assert [file for file in tmp_path.rglob("*") if file.is_file()] == [path]


def test_a_second_writer_of_a_run_keeps_the_first_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other processes may be reading the first file."""
    store, (scene,) = RunStore(tmp_path), scenes(1)
    run, files = scene_run.run, []
    monkeypatch.setattr(fcntl, "flock", lambda *_: None)

    def late(*given: Any) -> Any:
        monkeypatch.setattr(scene_run, "run", run)
        files.append(store.fetch(scene).stat().st_ino)
        return run(*given)

    monkeypatch.setattr(scene_run, "run", late)
    assert [store.fetch(scene).stat().st_ino] == files


def test_a_lock_file_deleted_on_another_host_is_opened_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The open file then fails with ESTALE."""
    store, (scene,), left = RunStore(tmp_path), scenes(1), [errno.ESTALE, errno.ESTALE]
    flock = fcntl.flock

    def removed(*given: Any) -> None:
        if left:
            raise OSError(left.pop(), "Stale file handle")
        flock(*given)

    monkeypatch.setattr(fcntl, "flock", removed)
    assert store.fetch(scene) == store.find(scene)


@pytest.mark.parametrize("links", [True, False])
def test_no_cell_of_a_sweep_is_lost(
    links: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cores, "_alone", False)  # a cell keeps its process to one core
    sweep, store = small_sweep(eps=[0.1 + 0.01 * cell for cell in range(6)]), RunStore(tmp_path)
    for module in (store_packs, sweep_module):
        monkeypatch.setattr(module, "MERGED_COUNT", 2)
    monkeypatch.setattr(sweep_module._Dispatch, "_size", lambda _: 1)
    view = FailingFolder(str(tmp_path), seed=5, repeated=0.3, stale=0.2, links=links)
    with view.seen():
        for workers in (HereWorkers(), HereWorkers()):
            state = run_sweep(sweep, store, workers)
    assert state.stored == 6
    assert set(sweep_dataset(sweep, store)["status"].values) == {"done"}
    assert not list(tmp_path.rglob("*.draft*"))
    assert len(list(tmp_path.rglob("*.h5"))) < 6

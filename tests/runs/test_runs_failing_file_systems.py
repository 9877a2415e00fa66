"""Catches: a run or a pack that a network file system loses, has made too often or leaves half."""

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
from tests.runs.shared_store import Said, SharedStore, scenes
from tests.runs.test_runs_sweep import HereWorkers, small_sweep
from tests.runs.unfinished_scenes import bits
from tests.support.failing_folder import BLIND, REFUSED, WORK, FailingFolder

Ask = Callable[[SharedStore], list[Said]]


@pytest.fixture(scope="module")
def ask() -> Iterator[Ask]:
    """Has processes share a store, and gives what they said."""
    command = [sys.executable, "-m", "tests.runs.shared_store"]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=Path(__file__).parents[2], **pipes) as process:

        def answered(shared: SharedStore) -> list[Said]:
            assert process.stdin is not None
            assert process.stdout is not None
            print(json.dumps(vars(shared)), file=process.stdin, flush=True)
            return [Said(**said) for said in json.loads(process.stdout.readline())]

        try:
            yield answered
        finally:
            process.kill()


def check_shared(ask: Ask, folder: Path, runs: int, locks: tuple[str, ...], **how: Any) -> None:
    """Nothing is lost, half, left behind, or made more often than was told."""
    said = ask(SharedStore(str(folder), runs, list(locks), **how))
    made = Counter(number for one in said for number in one.made)
    assert made.keys() == {*range(runs)}
    assert max(made.values()) <= (1 if {*locks} == {WORK} else len(locks))
    for one, kind in zip(said, locks, strict=True):
        assert len(one.told) <= (kind != WORK), one.told
        assert all("files cannot be locked there" in told for told in one.told)
    assert any(one.told for one in said) == ({*locks} != {WORK})
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
def test_three_processes_share_a_store_of_many_runs_that_are_made(ask: Ask, tmp_path: Path) -> None:
    check_shared(ask, tmp_path, 40, (WORK,) * 3, real=True)
    check_shared(ask, tmp_path / "other", 40, (BLIND,) * 3, real=True)


def test_two_that_are_let_in_remove_nothing_of_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second comes, and keeps the run, when the first is about to name its file."""
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


def test_of_two_that_make_a_run_the_first_ones_file_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Others may be reading it."""
    store, (scene,) = RunStore(tmp_path), scenes(1)
    run, files = scene_run.run, []
    monkeypatch.setattr(fcntl, "flock", lambda *_: None)

    def late(*given: Any) -> Any:
        monkeypatch.setattr(scene_run, "run", run)
        files.append(store.fetch(scene).stat().st_ino)
        return run(*given)

    monkeypatch.setattr(scene_run, "run", late)
    assert [store.fetch(scene).stat().st_ino] == files


def test_a_lock_that_its_holder_removes_elsewhere_is_taken_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its number leads nowhere then: ESTALE."""
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

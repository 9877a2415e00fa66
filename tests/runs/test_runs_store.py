"""Catches: a scene run twice, or not run again when needed; damaged runs that are read."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import longwave.runs.run_store
from longwave.runs.run_file import load_run
from longwave.runs.run_store import RunStore, UnsavedRunError, code_digest
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.engines import scene_run
from longwave.support.compiled.source_digest import Files
from longwave.support.provenance import provenance
from tests.runs.unfinished_scenes import bits, chain

SMALL = chain("small", snapshots=[0, 20], domain="window", step=0.5, sites=640)


RUN = scene_run.run


@pytest.fixture
def store(tmp_path: Path) -> RunStore:
    return RunStore(tmp_path / "store")


@pytest.fixture
def runs_made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the list to which the names of scenes are appended when they are run."""
    result: list[str] = []

    def run(scene: Any, *rest: Any) -> xr.Dataset:
        result.append(scene.name)
        return RUN(scene, *rest)

    monkeypatch.setattr(scene_run, "run", run)
    return result


def test_a_scene_is_run_once(store: RunStore, runs_made: list[str]) -> None:
    assert store.find(SMALL) is None
    path = store.fetch(SMALL)
    assert bits(load_run(path)) == bits(RUN(SMALL))
    assert store.fetch(SMALL) == store.find(SMALL) == path == store.path(SMALL)
    assert RunStore(store.folder).fetch(SMALL.changed(K2=1.0)) == path
    assert runs_made == ["small"]
    assert [file for file in store.folder.rglob("*") if file.is_file()] == [path]
    with xr.open_dataset(path) as run:
        assert run.sizes["site"] == 121


def test_another_request_has_another_key(store: RunStore) -> None:
    toda = load_scene("toda_soliton")
    others = [
        *(
            SMALL.changed(**one)
            for one in ({"eps": 0.2}, {"sites": 704}, {"observables": ["strain"]})
        ),
        SMALL.changed(parameters={"A": 2}),
        *(toda, toda.changed(order="leading"), toda.changed(constants={"a": 1, "b": "1/2"})),
    ]
    keys = {store.key(scene) for scene in (SMALL, *others)}
    assert len(keys) == 1 + len(others)


def test_equal_scenes_have_equal_keys(store: RunStore) -> None:
    pairs = [
        (SMALL, SMALL.changed(K3=-0.0)),
        (
            load_scene("toda_soliton"),
            load_scene("toda_soliton").changed(constants=(("a", 1.0), ("b", 1))),
        ),
    ]
    for one, other in pairs:
        assert one == other
        assert store.key(one) == store.key(other)


def test_a_user_defined_wave_has_no_key(store: RunStore) -> None:
    scene = replace(SMALL, wave=SMALL.form)
    with pytest.raises(ValueError, match="wave must be a shipped one"):
        store.key(scene)


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("code", "solutions/forms ", "solutions/forms 0"),
        ("code", "lattice/kernels ", "lattice/kernels 0"),
        ("code", "scenes/engines ", "scenes/engines 0"),
        ("versions", "numpy ", "numpy 0"),
    ],
)
def test_a_changed_formula_kernel_engine_or_package_makes_another_key(
    name: str, before: str, after: str, store: RunStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    key, result = store.key(SMALL), dict(provenance())
    assert before in result[name]
    result[name] = result[name].replace(before, after)
    with monkeypatch.context() as changed:
        changed.setattr("longwave.support.provenance.provenance", lambda: result)
        code_digest.cache_clear()
        assert store.key(SMALL) != key
    code_digest.cache_clear()
    assert store.key(SMALL) == key


def test_code_that_draws_or_prints_does_not_change_the_key() -> None:
    output = {part.split()[0] for part in provenance()["code"].split(", ")}
    assert {"solutions/forms", "lattice/kernels", "lattice/spectral", "scenes"} <= output
    assert not [
        name for name in output if name.startswith(("reports", "docs", "longwave/cli", "runs"))
    ]


def test_a_damaged_file_is_computed_again_with_a_warning(
    store: RunStore, runs_made: list[str], caplog: pytest.LogCaptureFixture
) -> None:
    path = store.fetch(SMALL)
    stored = path.read_bytes()
    flipped = bytearray(stored)
    flipped[len(stored) // 2] ^= 1
    for broken in (b"", stored[: len(stored) // 2], stored[:-1], stored + b"\n", flipped):
        path.write_bytes(broken)
        caplog.clear()
        assert store.find(SMALL) is None
        assert f"{path} is damaged" in caplog.text
    assert bits(load_run(store.fetch(SMALL))) == bits(RUN(SMALL))
    assert runs_made == ["small", "small"]


def test_a_planted_link_overwrites_no_file(
    store: RunStore, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Anyone who may write into a shared store can put links there to files of others."""
    letter = tmp_path / "letter"
    letter.write_text("mine")
    path = store.path(SMALL)
    path.parent.mkdir(parents=True)
    path.symlink_to(letter)
    store.fetch(SMALL)
    assert letter.read_text() == "mine"
    assert f"{path} is a link, or no file: it counts as missing" in caplog.text
    assert not path.is_symlink()
    assert store.find(SMALL) == path


def test_a_link_to_a_run_is_not_followed(store: RunStore, tmp_path: Path) -> None:
    path = store.fetch(SMALL)
    path.rename(tmp_path / "run.nc")
    path.symlink_to(tmp_path / "run.nc")
    assert store.find(SMALL) is None


def test_no_folder_is_made_through_a_link(store: RunStore, tmp_path: Path) -> None:
    planted = store.path(SMALL).parent
    planted.parent.mkdir(parents=True)
    (tmp_path / "elsewhere").mkdir()
    planted.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OSError, match="must not be a link") as raised:
        store.fetch(SMALL)
    assert raised.value.filename == str(planted)
    assert not list((tmp_path / "elsewhere").iterdir())


def test_a_link_in_the_place_of_a_lock_is_replaced(store: RunStore, tmp_path: Path) -> None:
    path = store.path(SMALL)
    path.parent.mkdir(parents=True)
    path.with_suffix(".lock").symlink_to(tmp_path / "elsewhere")
    assert store.fetch(SMALL) == path
    assert not (tmp_path / "elsewhere").exists()
    assert not path.with_suffix(".lock").is_symlink()


def test_a_pipe_in_the_place_of_a_run_is_not_waited_for(store: RunStore) -> None:
    path = store.path(SMALL)
    path.parent.mkdir(parents=True)
    os.mkfifo(path)
    assert store.find(SMALL) is None


def test_an_unfinished_run_is_not_saved(store: RunStore) -> None:
    run = scene_run.run(SMALL).assign_attrs(unfinished="Ctrl-C after t = 3")
    with pytest.raises(ValueError, match="run must be finished"):
        store.keep(SMALL, run)
    assert store.find(SMALL) is None


def test_a_finished_run_is_not_lost_if_it_cannot_be_written(
    store: RunStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "there.nc")

    with monkeypatch.context() as broken:
        broken.setattr(longwave.runs.run_store, "write_sealed", full)
        with pytest.raises(UnsavedRunError, match="No space left") as caught:
            store.fetch(SMALL)
    assert bits(caught.value.run) == bits(scene_run.run(SMALL))
    assert store.find(SMALL) is None
    assert store.find(SMALL) is None
    assert store.keep(SMALL, caught.value.run) == store.find(SMALL)


def test_an_unwritable_folder_is_reported_before_the_run(runs_made: list[str]) -> None:
    with pytest.raises(OSError, match="/proc/self"):
        RunStore("/proc/self/store").fetch(SMALL)
    assert runs_made == []


def test_no_run_is_saved_after_sources_changed(
    store: RunStore, runs_made: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("longwave.support.compiled.source_digest.runs_as_written", lambda _: False)
    longwave.runs.run_store.runs_its_sources.cache_clear()
    with pytest.raises(ValueError, match="start it again"):
        store.fetch(SMALL)
    longwave.runs.run_store.runs_its_sources.cache_clear()
    assert runs_made == []


def test_the_sources_of_all_rooms_are_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: wrong module names, for which nothing is compared and all seems unchanged."""
    seen: list[str] = []

    def noted(sources: Files) -> bool:
        seen.extend(name for name, _ in sources)
        return True

    monkeypatch.setattr("longwave.support.compiled.source_digest.runs_as_written", noted)
    longwave.runs.run_store.runs_its_sources.cache_clear()
    assert longwave.runs.run_store.runs_its_sources()
    longwave.runs.run_store.runs_its_sources.cache_clear()
    imported = {name for name in sys.modules if name.startswith("longwave.scenes.")}
    assert imported
    assert imported <= {*seen}


FETCH = """
import sys
from longwave.scenes.engines import scene_run
from longwave.runs.run_store import RunStore
from tests.runs.test_runs_store import SMALL

made = scene_run.run

def run(*given):
    print("made", flush=True)
    return made(*given)

scene_run.run = run
RunStore(sys.argv[1]).fetch(SMALL)
"""


@pytest.mark.slow
def test_processes_on_one_store_run_a_scene_once(store: RunStore) -> None:
    command = [sys.executable, "-c", FETCH, str(store.folder)]
    started = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(3)]
    message = [process.communicate(timeout=600)[0] for process in started]
    assert [process.returncode for process in started] == [0, 0, 0]
    assert sorted(message) == ["", "", "made\n"]
    assert store.find(SMALL) is not None
    assert not list(store.folder.rglob("*.lock"))


def test_a_run_is_found_without_listing_folders(
    store: RunStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = store.fetch(SMALL)

    def listed(*_: object) -> None:
        raise AssertionError("a folder was listed")

    for name in ("scandir", "listdir"):
        monkeypatch.setattr(os, name, listed)
    assert store.find(SMALL) == path
    assert store.find(SMALL.changed(eps=0.2)) is None

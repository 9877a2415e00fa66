"""Catches: a run that a kill, a full disk or a second process loses, or leaves half written."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from longwave.runs.run_file import load_run
from longwave.runs.run_store import RunStore, UnsavedRunError
from longwave.scenes.engines import scene_run
from tests.runs.unfinished_scenes import SCENES, bits, chain

KILLS = 12
"""Of each scene: 108 of all nine."""


@dataclass
class Server:
    """`fetch_server` of some scenes, and the seconds that each of them takes in it."""

    process: subprocess.Popen[str]
    seconds: dict[str, float]

    def ask(self, *words: object) -> int:
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(*words, sep="\t", file=self.process.stdin, flush=True)
        return int(self.process.stdout.readline())

    def start(self, name: str, folder: Path, least: float) -> int:
        return self.ask("fetch", name, folder, least)

    def wait(self, number: int) -> int:
        return self.ask("wait", number)

    def killed(self, number: int, delay: float) -> bool:
        """Whether the fork was still at work after so many seconds, when it was killed."""
        time.sleep(delay)
        os.kill(number, signal.SIGKILL)
        status = self.wait(number)
        assert status in (0, -signal.SIGKILL)
        return status != 0


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    command = [sys.executable, "-m", "tests.runs.fetch_server", *SCENES]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=Path(__file__).parents[2], **pipes) as process:
        try:
            assert process.stdout is not None
            yield Server(process, {name: float(process.stdout.readline()) for name in SCENES})
        finally:
            process.kill()


def check_kept(store: RunStore, name: str, whole: dict[str, object]) -> bool:
    """Whether the store has the run; nothing else goes by its name."""
    path = store.path(SCENES[name])
    found = store.find(SCENES[name])
    assert found == (path if path.exists() else None)
    if found is not None:
        assert bits(load_run(found)) == whole
        found.unlink()
    return found is not None


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_a_run_killed_at_any_moments_is_finished_with_the_same_bits(
    name: str, server: Server, tmp_path: Path, rng: np.random.Generator
) -> None:
    store, whole = RunStore(tmp_path), bits(scene_run.run(SCENES[name]))
    kills = 0
    while kills < KILLS:
        least = float(rng.choice([0.0, 0.02]))
        number = server.start(name, tmp_path, least)
        kills += server.killed(number, rng.uniform(0.0, server.seconds[name]))
        check_kept(store, name, whole)
    assert server.wait(server.start(name, tmp_path, 0.02)) == 0
    assert check_kept(store, name, whole)
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stated window, refined", "stencil, ring", "spectral", "dimer"])
def test_a_killed_run_without_a_store_is_resumed_next_to_its_output(
    name: str, server: Server, tmp_path: Path, rng: np.random.Generator
) -> None:
    output, whole = tmp_path / "out.nc", bits(scene_run.run(SCENES[name]))
    kills = 0
    while kills < KILLS:
        number = server.ask("write", name, tmp_path, float(rng.choice([0.0, 0.02])))
        kills += server.killed(number, rng.uniform(0.0, server.seconds[name]))
        if output.exists():
            assert bits(load_run(output)) == whole
            output.unlink()
    assert server.wait(server.ask("write", name, tmp_path, 0.02)) == 0
    assert bits(load_run(output)) == whole
    left = {path.name for path in tmp_path.iterdir() if ".draft" not in path.suffixes}
    assert left == {"out.nc", "scene.toml"}


@pytest.mark.slow
def test_a_waiting_process_finishes_the_run_of_a_killed_one(
    server: Server, tmp_path: Path, rng: np.random.Generator
) -> None:
    name = "stencil, window"
    store, whole = RunStore(tmp_path), bits(scene_run.run(SCENES[name]))
    for _ in range(4):
        one, other = (server.start(name, tmp_path, 0.0) for _ in range(2))
        server.killed(one, rng.uniform(0.0, server.seconds[name]))
        assert server.wait(other) == 0
        assert check_kept(store, name, whole)


@pytest.mark.slow
def test_a_file_of_a_killed_writer_is_complete_or_absent(
    server: Server, tmp_path: Path, rng: np.random.Generator
) -> None:
    store, name = RunStore(tmp_path), "stated ring"
    path = store.path(SCENES[name])
    seen = []
    for _ in range(15):
        soon = 0.2 * rng.uniform() ** 4  # most of them while it is written
        assert server.killed(server.ask("keep", name, tmp_path), soon)
        seen.append(store.find(SCENES[name]))
        assert seen[-1] == (path if path.exists() else None)
        path.unlink(missing_ok=True)
    assert {None, path} == set(seen)


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 64 kB, where root may mount one."""
    mount = ["mount", "-t", "tmpfs", "-o", "size=64k", "none", str(tmp_path)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True).returncode != 0:
        pytest.skip("only root mounts a disk, and not everywhere")
    try:
        yield tmp_path
    finally:
        subprocess.run(["umount", str(tmp_path)], check=True)


LARGE = chain(
    "large",
    snapshots=[*range(0, 40, 2)],
    domain="ring",
    step=0.5,
    sites=2048,
    observables=["strain", "state"],
)


def test_a_full_disk_loses_no_finished_run_and_harms_no_other(
    small_disk: Path, caplog: pytest.LogCaptureFixture
) -> None:
    store, small = RunStore(small_disk, least=0.0, share=1e9), SCENES["stated window, refined"]
    whole = bits(scene_run.run(LARGE))
    with pytest.raises(UnsavedRunError, match="No space left") as caught:
        store.fetch(LARGE)
    assert bits(caught.value.run) == whole
    assert "goes on without a checkpoint" in caplog.text
    assert store.find(LARGE) is None
    remount = ["mount", "-o", "remount,size=20m", str(small_disk)]
    subprocess.run(remount, check=True)
    assert bits(load_run(store.fetch(LARGE))) == whole
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    assert bits(load_run(store.fetch(LARGE))) == whole
    with pytest.raises(OSError, match="Read-only file system"):
        store.fetch(small)

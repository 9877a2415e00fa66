"""Catches: a checkpoint that is read although it is damaged, or of another run or task."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from longwave.support.atomic_file import draft_path
from longwave.support.checkpoint import (
    CheckpointFolder,
    Memory,
    begin_loop,
    branches,
    checkpoints_in,
    fitting,
)
from longwave.support.request_limits import request_limits
from longwave.support.sealed_file import write_sealed

MEMORY: Memory = {"seconds": 1.5, "f": np.arange(3.0), "rows": [np.float64(2.0), (1, None, "a")]}


def test_a_checkpoint_is_read_only_for_the_same_run_and_task(tmp_path: Path) -> None:
    CheckpointFolder(tmp_path, "this run").write("1", "this task", MEMORY)
    found = CheckpointFolder(tmp_path, "this run").read("1", "this task")
    assert found is not None
    assert found["f"].tolist() == [0.0, 1.0, 2.0]
    found["f"][0] = 5.0  # a run changes it in place
    assert found["rows"] == MEMORY["rows"]
    assert CheckpointFolder(tmp_path, "this run").read("1", "another task") is None
    assert CheckpointFolder(tmp_path, "this run").read("2", "this task") is None
    assert CheckpointFolder(tmp_path, "another run").read("1", "this task") is None


def test_a_damaged_checkpoint_is_reported_and_not_read(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    keeper = CheckpointFolder(tmp_path, "this run")
    keeper.write("1", "this task", MEMORY)
    (path,) = tmp_path.iterdir()
    held = path.read_bytes()
    for broken in (b"", held[:40], held[:-1], held[:50] + bytes([held[50] ^ 1]) + held[51:]):
        path.write_bytes(broken)
        caplog.clear()
        assert keeper.read("1", "this task") is None
        assert f"{path} is damaged" in caplog.text


def pickled(what: object) -> bytes:
    return pickle.dumps(("this run", "this task", what), protocol=5)


CRAFTED = """
import sys
from pathlib import Path
from longwave.support.checkpoint import CheckpointFolder
memory = CheckpointFolder(Path(sys.argv[1]), "this run").read("1", "this task")
print(memory)
"""


class HiddenObjects:
    """Array type that contains an object but denies it."""

    def __reduce__(self) -> tuple[Any, ...]:
        fields = {"a": (np.dtype("O"), 0)}
        return np.dtype, ("V8", False, True), (3, "|", None, ("a",), fields, 8, 1, 0)


class Pointers:
    """Array of objects at chosen addresses."""

    def __reduce__(self) -> tuple[Any, ...]:
        return np._core.numeric._frombuffer, (24 * b"A", HiddenObjects(), (3,), "C")  # type: ignore


@pytest.mark.parametrize("what", [os.getcwd, {"seconds": 1.0, "f": Pointers()}])
def test_a_checkpoint_calls_nothing_and_has_no_addresses(what: object, tmp_path: Path) -> None:
    """Whoever may write into the folder must not be able to run code or crash this process."""
    write_sealed(tmp_path / "1.loop", pickled(what))
    words = [sys.executable, "-c", CRAFTED, str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "None\n", "")


@pytest.mark.parametrize("memory", [{}, {"seconds": "1"}, {"seconds": None}])
def test_a_state_without_its_seconds_is_not_read(memory: Memory, tmp_path: Path) -> None:
    keeper = CheckpointFolder(tmp_path, "this run")
    keeper.write("1", "this task", memory)
    assert keeper.read("1", "this task") is None


def test_links_are_not_followed(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """No user typed the names, which could lead into the folders of whoever resumes the run."""
    folder, theirs = tmp_path / "run.unfinished", tmp_path / "theirs"
    CheckpointFolder(theirs, "this run").write("1", "this task", MEMORY)
    folder.symlink_to(theirs)
    keeper = CheckpointFolder(folder, "this run")
    assert keeper.read("1", "this task") is None
    keeper.write("2", "this task", MEMORY)
    assert "is a link (remove it)" in caplog.text
    keeper.clear()
    assert [path.name for path in theirs.iterdir()] == ["1.loop"]
    folder.unlink()
    folder.mkdir()
    (folder / "1.loop").symlink_to(theirs / "1.loop")
    assert keeper.read("1", "this task") is None
    keeper.write("1", "this task", MEMORY | {"seconds": 2.0})
    assert keeper.read("1", "this task") is not None
    kept = CheckpointFolder(theirs, "this run").read("1", "this task")
    assert kept is not None
    assert kept["seconds"] == 1.5


@pytest.mark.parametrize(
    "value", [np.zeros(2), np.zeros((3, 2)).T, np.zeros((2, 3), "f4"), np.zeros((2, 4)), 1.0, None]
)
def test_restored_arrays_must_fit_the_machine_code(value: object) -> None:
    """Machine code does not check the sizes of restored arrays."""
    like = np.zeros((2, 3))
    assert fitting(like, like) is like
    with pytest.raises(ValueError, match=r"^a checkpoint must have the state of its run, got "):
        fitting(value, like)


def test_an_unexpected_state_is_reported_in_one_line(tmp_path: Path) -> None:
    """Whoever knows the stamp of a run can write a file that fits except for its content."""
    CheckpointFolder(tmp_path, "this run").write("1", "this task", {"seconds": 1.0})
    told = rf"^a checkpoint must have [^\n]* got {tmp_path} with KeyError: 'f' \(remove"

    def go_on(run: str) -> None:
        with checkpoints_in(CheckpointFolder(tmp_path, run)):
            (begin_loop("this task").memory or {})["f"]

    with pytest.raises(ValueError, match=told):
        go_on("this run")
    with pytest.raises(KeyError):  # which no checkpoint has brought
        go_on("another run")


def test_a_checkpoint_that_does_not_fit_the_memory_is_not_read(tmp_path: Path) -> None:
    keeper = CheckpointFolder(tmp_path, "this run")
    keeper.write("1", "this task", MEMORY)
    (path,) = tmp_path.iterdir()
    os.truncate(path, 10**9)  # takes nothing of the disk
    with request_limits(memory="1M"):
        assert keeper.read("1", "this task") is None
        assert not keeper.is_begun


def test_drafts_are_not_checkpoints_and_live_ones_stay(tmp_path: Path) -> None:
    """Where locks do nothing, another process may be making the same run."""
    keeper = CheckpointFolder(tmp_path, "this run")
    keeper.write("1", "this task", MEMORY)
    (path,) = tmp_path.iterdir()
    draft = draft_path(path)
    draft.write_bytes(path.read_bytes())
    keeper.tell("this scene")
    assert keeper.stored_seconds == MEMORY["seconds"]
    keeper.clear()
    assert list(tmp_path.iterdir()) == [draft]
    draft.unlink()
    keeper.clear()
    assert not tmp_path.exists()


def test_loops_are_numbered_by_the_order_in_which_they_begin(tmp_path: Path) -> None:
    """Loops of concurrent work are numbered separately, whichever begins first."""
    with checkpoints_in(CheckpointFolder(tmp_path, "this run")):
        first = begin_loop("").name
        one, other = branches(2)
        later = [place.run(lambda: begin_loop("").name) for place in (other, one, one)]
        last = begin_loop("").name
    assert [first, *later, last] == ["1", "3-1", "2-1", "2-2", "4"]
    assert begin_loop("").keeper is None


def test_checkpoints_take_a_small_share_of_the_time(tmp_path: Path) -> None:
    """However long a write takes, it is rare enough; the test sets the clock."""
    keeper = CheckpointFolder(tmp_path, "this run", least=0.0, share=0.01)
    written = []
    with checkpoints_in(keeper), pytest.MonkeyPatch.context() as patched:
        clock = [0.0]
        patched.setattr("longwave.support.checkpoint.perf_counter", lambda: clock[0])

        def write(*_: object) -> None:
            written.append(clock[0])
            clock[0] += 0.2

        patched.setattr(keeper, "write", write)
        loop = begin_loop("")
        for _ in range(100_000):
            clock[0] += 0.01
            loop.offer(dict)
    assert 0.8 * 0.01 <= 0.2 * len(written) / clock[0] <= 0.0101

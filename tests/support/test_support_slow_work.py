"""Reports about long work, before it begins and on its way.

Catches: a time left that is wrong by a factor because of a checkpoint or the first, slow cells, and
too many lines in a cluster's log.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from rich.console import Console

from longwave.support.checkpoint import CheckpointFolder, begin_loop, checkpoints_in, stored_seconds
from longwave.support.console import progress_bar
from longwave.support.slow_work import EVERY, TimeLeft, announce, report_time_left

Output = pytest.CaptureFixture[str]


class ManualClock:
    """A clock that the test sets."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@contextmanager
def looking(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], None]]:
    """Yield a function that lets the watching thread check once."""
    go, looked, ended = threading.Semaphore(0), threading.Semaphore(0), threading.Event()

    class Over:
        """Event that is awaited as often as the test says."""

        begun = False

        def wait(self, _: float) -> bool:
            if self.begun:
                looked.release()
            self.begun = True
            go.acquire()
            return ended.is_set()

        def set(self) -> None:
            ended.set()
            go.release()

    def look() -> None:
        go.release()
        assert looked.acquire(timeout=600.0)

    monkeypatch.setattr("longwave.support.slow_work.Event", Over)
    yield look
    monkeypatch.undo()


def test_lines_are_rare_and_contain_a_number(
    monkeypatch: pytest.MonkeyPatch, capsys: Output
) -> None:
    clock = ManualClock()
    with looking(monkeypatch) as look, report_time_left("longwave derive", clock):
        look()
        clock.now = EVERY - 1.0
        look()
        assert capsys.readouterr().err == ""
        clock.now = EVERY + 1.0
        look()
        assert capsys.readouterr().err == "longwave derive: 31 s so far (Ctrl-C stops it)\n"
        look()
        announce("the run", 20.0)
        clock.now = 2.0 * EVERY
        look()
        clock.now = 2.9 * EVERY
        look()
        assert capsys.readouterr().err == "the run: about 20 s (Ctrl-C stops it)\n"


def test_without_a_terminal_lines_report_the_time_left(
    monkeypatch: pytest.MonkeyPatch, capsys: Output
) -> None:
    clock = ManualClock()
    bar = progress_bar("name", "the run", Console(stderr=True), clock)
    with looking(monkeypatch) as look, bar as (share, tell):
        tell(100.0)
        share(0.0)
        look()
        clock.now = 40.0
        share(0.25)
        look()
    told, line = capsys.readouterr().err.splitlines()
    assert told == "the run: about 100 s (Ctrl-C stops it)"
    assert line == "the run: 25 %, about 71 s left (Ctrl-C stops it)"  # between 60 and 120


def test_earlier_work_does_not_count_for_the_pace() -> None:
    clock = ManualClock()
    left = TimeLeft(clock)
    left.share(0.8)
    clock.now = 10.0
    left.share(0.9)
    assert left.words() == "90 %, about 10 s left"


def test_work_in_a_checkpoint_is_not_announced_again(tmp_path: Path, capsys: Output) -> None:
    before = CheckpointFolder(tmp_path / "kept", "stamp")
    before.write("1", "task", {"seconds": 80.0})
    now = CheckpointFolder(tmp_path / "kept", "stamp")
    now.tell("run")
    with progress_bar("run", "the run", Console(stderr=True)) as (_, tell), checkpoints_in(now):
        assert stored_seconds() == 80.0
        tell(100.0)
        begin_loop("task")
        assert stored_seconds() == 0.0
    assert capsys.readouterr().err == "the run: about 20 s (Ctrl-C stops it)\n"

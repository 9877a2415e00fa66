"""Catches: a lock that admits two holders, and work that stops where locking is impossible."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path
from threading import Event, Thread
from typing import Any

import pytest

from longwave.support import file_lock
from longwave.support.file_lock import locked
from tests.support.failing_folder import FailingFolder

FLOCK, OPEN, FSTAT = fcntl.flock, os.open, os.fstat


@pytest.fixture(autouse=True)
def _reset_warnings() -> Iterator[None]:
    """Reset what was tested and reported for each file system."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(file_lock, "_WARNED", set())
        patch.setattr(file_lock, "_TESTED", set())
        yield


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return tmp_path / "run.lock"


def refused(number: int) -> Any:
    def refuse(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    return refuse


def test_a_lock_has_one_holder_at_a_time(place: Path, caplog: pytest.LogCaptureFixture) -> None:
    waiting, done = Event(), []

    def other() -> None:
        with locked(place, waiting.set):
            done.append("other")

    with locked(place):
        thread = Thread(target=other)
        thread.start()
        assert waiting.wait(600)
        done.append("first")
    thread.join()
    assert done == ["first", "other"]
    assert not place.exists()
    assert not caplog.text


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, 524])
def test_without_locks_work_continues_after_one_warning(
    number: int, place: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Linux returns 524 on some file systems, an error without a name."""
    monkeypatch.setattr(fcntl, "flock", refused(number))
    for _ in range(2):
        with locked(place), locked(place):
            pass
    (told,) = caplog.messages
    assert f"{place.parent}: files cannot be locked there ({os.strerror(number)})" in told
    assert not place.exists()


def test_a_lock_that_excludes_nobody_is_reported(
    place: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(fcntl, "flock", lambda *_: None)
    with locked(place), locked(place):
        assert "a lock there excludes nobody" in caplog.text


def test_a_system_without_locks_continues_with_a_warning(
    place: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(file_lock, "fcntl", None)
    with locked(place):
        assert "files cannot be locked there" in caplog.text


def test_changing_inodes_do_not_block(
    place: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(os.path, "samestat", lambda *_: False)
    with locked(place):
        assert "the inode of a file changes" in caplog.text


def test_a_link_in_the_place_of_a_lock_is_replaced(
    place: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Catches: a run that fails because another user has put a link there."""
    other = place.with_name("other")
    other.write_text("theirs")
    place.symlink_to(other)
    with locked(place):
        assert not place.is_symlink()
    assert other.read_text() == "theirs"
    assert "is a link: it is removed" in caplog.text


def test_the_lock_of_another_is_not_removed(place: Path) -> None:
    with locked(place):
        place.unlink()
        place.touch()
    assert place.exists()


def test_a_lock_removed_from_another_host_is_acquired_again(
    place: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Its holder there removes it while this process waits."""
    opened: list[int] = []

    def open_late(path: Any, *given: Any) -> int:
        opened.append(OPEN(path, *given))
        if len(opened) == 1:
            os.unlink(path)
        return opened[-1]

    monkeypatch.setattr(os, "open", open_late)
    with FailingFolder(str(place.parent), repeated=0.0, stale=0.0).seen(), locked(place):
        assert place.exists()
    assert not place.exists()
    assert not caplog.text


def test_a_lock_removed_during_the_test_is_not_created_again(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a lock file that nobody holds and nobody removes."""
    monkeypatch.setattr(fcntl, "flock", lambda *_: None)
    leads = file_lock.leads_to

    def removed_after(path: Path, file: os.stat_result) -> bool:
        found = leads(path, file)
        path.unlink(missing_ok=True)
        return found

    monkeypatch.setattr(file_lock, "leads_to", removed_after)
    with locked(place):
        assert not place.exists()
    assert not place.exists()


def test_a_lock_that_cannot_be_made_or_closed(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Failing to create it is an error; failing to close it is not, because the work is done."""
    with (
        pytest.raises(FileNotFoundError, match=r"nowhere/run\.lock"),
        locked(place.parent / "nowhere" / "run.lock"),
    ):
        pass
    with monkeypatch.context() as patch, locked(place):
        patch.setattr(os, "close", refused(errno.ENOSPC))

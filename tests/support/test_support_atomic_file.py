"""Catches: a file that is half written, lost or overwritten unasked, and leftover drafts."""

import errno
import os
import resource
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from pathlib import Path

import pytest

from longwave.support.atomic_file import OLD_DRAFT, draft_path, remove_dead_drafts, write_atomically
from tests.support.failing_folder import FailingFolder

OLD, NEW = "the older file", "new " * 1000

KILLED = """
import os, signal, sys
from pathlib import Path
from longwave.support.atomic_file import write_atomically

moment, place = sys.argv[1:]

def die(*_):
    os.kill(os.getpid(), signal.SIGKILL)

def write(draft):
    with draft.open("w") as stream:
        stream.write("new " * 500)
        stream.flush()
        if moment == "writing":
            die()
        stream.write("new " * 500)

if moment == "flushing":
    os.fsync = die
if moment == "naming":
    os.replace = die
if moment == "named":
    put = os.replace
    os.replace = lambda *names: (put(*names), die())
write_atomically(place, write)
"""


@pytest.mark.parametrize("moment", ["writing", "flushing", "naming", "named"])
def test_a_process_killed_at_any_step_leaves_a_whole_file(moment: str, tmp_path: Path) -> None:
    place = tmp_path / "run.nc"
    place.write_text(OLD)
    done = subprocess.run([sys.executable, "-c", KILLED, moment, str(place)], timeout=600)
    assert done.returncode == -signal.SIGKILL
    assert place.read_text() == (NEW if moment == "named" else OLD)


def test_content_is_flushed_before_the_file_is_renamed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []
    place = tmp_path / "run.nc"
    monkeypatch.setattr(
        os, "fsync", lambda number: seen.append((stat.S_ISDIR(os.fstat(number).st_mode), *there()))
    )

    def there() -> list[bool]:
        return [place.exists()]

    write_atomically(place, lambda draft: draft.write_text(NEW))
    assert seen == [(False, False), (True, True)]
    write_atomically(place, lambda draft: draft.write_text(NEW), durable=False)
    assert len(seen) == 2


@contextmanager
def no_file_larger_than(size: int) -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_failed_write_leaves_the_older_file_and_no_draft(tmp_path: Path) -> None:
    place = tmp_path / "run.nc"
    place.write_text(OLD)
    with no_file_larger_than(1000), pytest.raises(OSError, match=r"run\.nc") as caught:
        write_atomically(place, lambda draft: draft.write_text(NEW))
    assert caught.value.errno == errno.EFBIG
    assert caught.value.filename == str(place)
    assert place.read_text() == OLD
    assert list(tmp_path.iterdir()) == [place]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root mounts a disk")
def test_full_and_read_only_disks_are_reported(tmp_path: Path) -> None:
    mount = ["mount", "-t", "tmpfs", "-o", "size=16k", "none", str(tmp_path)]
    if subprocess.run(mount, capture_output=True).returncode != 0:
        pytest.skip("root may not mount here")
    try:
        place = tmp_path / "run.nc"
        place.write_text(OLD)
        with pytest.raises(OSError, match="No space left") as caught:
            write_atomically(place, lambda draft: draft.write_text(10 * NEW))
        assert caught.value.filename == str(place)
        subprocess.run(["mount", "-o", "remount,ro", str(tmp_path)], check=True)
        with pytest.raises(OSError, match="Read-only") as caught:
            write_atomically(place, lambda draft: draft.write_text(NEW))
        assert caught.value.filename == str(place)
        assert place.read_text() == OLD
        assert list(tmp_path.iterdir()) == [place]
    finally:
        subprocess.run(["umount", str(tmp_path)], check=True)


def test_an_unwritable_folder_is_reported() -> None:
    """Not even root can create a file in it."""
    place = Path("/proc/self/run.nc")
    with pytest.raises(OSError, match=r"/proc/self/run\.nc") as caught:
        write_atomically(place, lambda draft: draft.write_text(NEW))
    assert caught.value.filename == str(place)


def test_any_error_of_the_writer_leaves_the_older_file_and_no_draft(tmp_path: Path) -> None:
    place = tmp_path / "run.nc"
    place.write_text(OLD)
    for error in (KeyboardInterrupt(), RuntimeError("damaged"), OSError("no number")):

        def write(draft: Path, error: BaseException = error) -> None:
            draft.write_text(NEW)
            raise error

        with pytest.raises(type(error)):
            write_atomically(place, write)
        assert place.read_text() == OLD
        assert list(tmp_path.iterdir()) == [place]


@pytest.mark.parametrize("links", [True, False])
def test_one_of_several_writers_without_force_wins(
    links: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also on file systems without hard links."""
    place = tmp_path / "run.nc"
    if not links:

        def refuse(*_: object) -> None:
            raise OSError(errno.EPERM, "Operation not permitted")

        monkeypatch.setattr(os, "link", refuse)

    def attempt(number: int) -> int | None:
        try:
            write_atomically(place, lambda draft: draft.write_text(f"{number}"), force=False)
        except FileExistsError as error:
            return None if error.filename == str(place) else -1
        return number

    with ThreadPoolExecutor(8) as pool:
        won = [number for number in pool.map(attempt, range(64)) if number is not None]
    assert [str(number) for number in won] == [place.read_text()]
    assert list(tmp_path.iterdir()) == [place]


def test_readers_never_see_less_than_a_whole_file(tmp_path: Path) -> None:
    place = tmp_path / "run.nc"
    whole = {f"{letter}" * 200_000 for letter in "ab"}
    write_atomically(place, lambda draft: draft.write_text(min(whole)))

    def writer(text: str) -> None:
        for _ in range(20):
            write_atomically(place, lambda draft: draft.write_text(text), durable=False)

    with ThreadPoolExecutor(2) as pool:
        writing = [pool.submit(writer, text) for text in sorted(whole)]
        while not all(future.done() for future in writing):
            assert place.read_text() in whole


def test_only_files_are_replaced(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    for name in ("folder", "pipe"):
        with pytest.raises(FileExistsError, match="is not a file"):
            write_atomically(tmp_path / name, lambda draft: draft.write_text(NEW))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "pipe"]


def test_a_link_and_permissions_stay(tmp_path: Path) -> None:
    place, link = tmp_path / "run.nc", tmp_path / "last.nc"
    place.write_text(OLD)
    place.chmod(0o600)
    link.symlink_to(place)
    write_atomically(link, lambda draft: draft.write_text(NEW))
    assert link.is_symlink()
    assert place.read_text() == NEW
    assert stat.S_IMODE(place.stat().st_mode) == 0o600


def test_the_longest_name_that_a_file_may_have_has_room_for_its_draft(tmp_path: Path) -> None:
    seen = []

    def write(draft: Path) -> None:
        seen.append(draft.suffix)
        draft.write_text(NEW)

    for name in (252 * "r" + ".nc", "r." + 250 * "n", 84 * "波" + ".nc"):
        write_atomically(tmp_path / name, write)
        assert (tmp_path / name).read_text() == NEW
    assert seen == [".nc", ".draft", ".nc"]


@pytest.mark.parametrize("force", [True, False])
def test_a_repeated_request_that_fails_counts_as_done(force: bool, tmp_path: Path) -> None:
    """The client of a network file system repeats requests that got no answer."""
    place = tmp_path / "run.nc"
    view = FailingFolder(str(tmp_path), repeated=1.0, stale=0.0)
    with view.seen():
        write_atomically(place, lambda draft: draft.write_text(NEW), force)
    assert place.read_text() == NEW
    assert list(tmp_path.iterdir()) == [place]


def test_another_file_of_the_name_is_not_mistaken_for_the_draft(tmp_path: Path) -> None:
    place = tmp_path / "run.nc"

    def write(draft: Path) -> None:
        draft.write_text(NEW)
        place.write_text(NEW)

    with pytest.raises(FileExistsError):
        write_atomically(place, write, force=False)
    place.unlink()

    def gone(draft: Path) -> None:
        write(draft)
        draft.unlink()

    with pytest.raises(FileNotFoundError) as caught:
        write_atomically(place, gone, durable=False)
    assert caught.value.filename == str(place)


def test_a_reserved_name_is_released_after_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where there are no links, an empty file reserves the name for a moment."""
    place = tmp_path / "run.nc"

    def fail(*_: object) -> None:
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(os, "replace", fail)
    refused = pytest.raises(OSError, match="Input/output error")
    with FailingFolder(str(tmp_path), links=False).seen(), refused:
        write_atomically(place, lambda draft: draft.write_text(NEW), force=False)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("number", [errno.EINVAL, errno.EOPNOTSUPP, errno.EIO, errno.ENOSPC])
def test_an_unsupported_flush_is_ignored_and_a_full_disk_is_not(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = tmp_path / "run.nc"
    place.write_text(OLD)

    def flush(_: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", flush)
    fits = number in (errno.EINVAL, errno.EOPNOTSUPP)
    with nullcontext() if fits else pytest.raises(OSError, match=os.strerror(number)):
        write_atomically(place, lambda draft: draft.write_text(NEW))
    assert place.read_text() == (NEW if fits else OLD)
    assert list(tmp_path.iterdir()) == [place]


@pytest.fixture
def dead() -> int:
    """Return the number of a process that has ended."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        pass
    return process.pid


@pytest.mark.parametrize("goes", [True, False])
def test_only_drafts_of_ended_processes_are_removed(goes: bool, dead: int, tmp_path: Path) -> None:
    """For another host or an older version, the age decides."""
    here = draft_path(tmp_path / "run.nc").name
    process = dead if goes else os.getpid()
    names = [here.replace(f"-{os.getpid()}-", f"-{process}-")]
    names += [f".run.{8 * '0'}-{os.getpid()}-{16 * 'a'}.draft.nc", f".run.{16 * 'a'}.draft.nc"]
    names += [".run.draft-.draft.nc", ".run.-1-2.draft"]
    for name in names:
        (tmp_path / name).touch()
    for name in names[1:]:
        written = time.time() - (2 if goes else 0.5) * OLD_DRAFT
        os.utime(tmp_path / name, (written, written))
    remove_dead_drafts(tmp_path, "other")
    assert {path.name for path in tmp_path.iterdir()} == {*names}
    remove_dead_drafts(tmp_path, "run")
    assert {path.name for path in tmp_path.iterdir()} == (set() if goes else {*names})


@pytest.mark.parametrize("follow", [False, True])
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="another's file")
def test_permissions_of_another_users_file_are_not_kept(follow: bool, tmp_path: Path) -> None:
    """Catches: a damaged file with mode 0666 in place of a run, replaced by one just as open."""
    place = tmp_path / "key.nc"
    place.write_text("damaged")
    place.chmod(0o666)
    os.chown(place, 12345, 12345)
    write_atomically(place, lambda draft: draft.write_text("new"), follow=follow)
    assert place.read_text() == "new"
    assert place.stat().st_mode & 0o022 == 0


def test_an_own_file_keeps_its_permissions_unless_a_mode_is_given(
    tmp_path: Path,
) -> None:
    place = tmp_path / "file"
    place.write_text("old")
    place.chmod(0o640)
    write_atomically(place, lambda draft: draft.write_text("new"))
    assert place.stat().st_mode & 0o777 == 0o640
    write_atomically(place, lambda draft: draft.write_text("new"), mode=0o600)
    assert place.stat().st_mode & 0o777 == 0o600


def test_a_private_file_is_private_while_it_is_written_anew(tmp_path: Path) -> None:
    """Catches: a draft that everybody may read until it is complete."""
    place, seen = tmp_path / "file", list[int]()
    place.write_text("old")
    place.chmod(0o600)

    def write(draft: Path) -> None:
        draft.write_text("new")
        seen.append(draft.stat().st_mode & 0o077)

    write_atomically(place, write)
    write_atomically(tmp_path / "other", write, mode=0o600)
    assert seen == [0, 0]
    assert place.read_text() == "new"

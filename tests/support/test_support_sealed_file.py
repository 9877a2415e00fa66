"""Catches: a sealed file that is lost, or counted as missing, on a network file system."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from longwave.support import sealed_file
from longwave.support.sealed_file import is_whole, read_sealed, write_sealed
from tests.support.failing_folder import FailingFolder

CONTENT = b"a run" * 1000


@pytest.mark.parametrize("force", [True, False])
def test_a_removed_draft_is_written_again(
    force: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, fsync, left = tmp_path / "run.nc", os.fsync, [1, 2]

    def tidied(number: int) -> None:
        if left:
            left.pop()
            for draft in tmp_path.glob(".*.draft*"):
                draft.unlink()
        fsync(number)

    monkeypatch.setattr(os, "fsync", tidied)
    write_sealed(place, CONTENT, force)
    assert read_sealed(place) == CONTENT
    assert list(tmp_path.iterdir()) == [place]


def test_permissions_of_a_replaced_file_are_not_kept(tmp_path: Path) -> None:
    """Catches: a damaged file of another user, open to all, replaced by one just as open."""
    place = tmp_path / "run.nc"
    place.write_bytes(b"damaged")
    place.chmod(0o666)
    before = os.umask(0o022)
    try:
        write_sealed(place, CONTENT)
    finally:
        os.umask(before)
    assert place.stat().st_mode & 0o777 == 0o644


def test_a_missing_folder_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        write_sealed(tmp_path / "folder" / "run.nc", CONTENT)
    assert caught.value.filename == str(tmp_path / "folder" / "run.nc")


def test_a_file_replaced_during_reading_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    place, opened = tmp_path / "run.nc", sealed_file.open_plain
    write_sealed(place, CONTENT)
    left = [1, 2]

    def replaced(path: Any, *folder: Any, **untyped: int) -> int:
        number = opened(path, *folder, **untyped)
        if left:
            left.pop()
            write_sealed(place, CONTENT)
        return number

    monkeypatch.setattr(sealed_file, "open_plain", replaced)
    with FailingFolder(str(tmp_path), repeated=0.0, stale=0.0).seen():
        assert is_whole(place)
        left.append(1)
        assert read_sealed(place) == CONTENT
    assert not caplog.text


def test_a_file_that_stays_stale_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It must not count as missing, because it would be made again although it may exist."""
    place = tmp_path / "run.nc"
    write_sealed(place, CONTENT)

    def stale(*_: object, **__: object) -> int:
        raise OSError(errno.ESTALE, "Stale file handle", str(place))

    monkeypatch.setattr(os, "open", stale)
    with pytest.raises(OSError, match="Stale file handle"):
        is_whole(place)

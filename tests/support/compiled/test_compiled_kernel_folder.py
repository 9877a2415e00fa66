"""Catches: machine code and data read from a folder into which others may have put them."""

import os
import shutil
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from longwave.support.compiled import kernel_folder
from longwave.support.compiled.kernel_folder import CacheFolder, cache_folder
from tests.support.compiled.cache_places import caches_in, forget

MODULE = kernel_folder.__name__


@pytest.fixture
def bases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Path, Path]]:
    """Return two locations for caches, the first of which is shared."""
    yield from caches_in(tmp_path, monkeypatch)


def opened_to_others(folder: Path, _: Path) -> None:
    folder.chmod(0o777)


def linked(folder: Path, elsewhere: Path) -> None:
    shutil.move(folder, elsewhere)
    folder.symlink_to(elsewhere)


def readable_by_the_group(folder: Path, _: Path) -> None:
    folder.chmod(0o750)


@pytest.mark.parametrize("plant", [opened_to_others, linked, readable_by_the_group])
def test_files_others_may_have_planted_are_reported_and_not_read(
    plant: Callable[[Path, Path], None], bases: tuple[Path, Path], tmp_path: Path
) -> None:
    shared, own = bases
    first = cache_folder(MODULE)
    first.write("code", b"planted")
    assert first.read("code") == b"planted"
    assert first.path is not None
    plant(first.path, tmp_path / "elsewhere")
    assert first.read("code") is None
    forget()
    with pytest.warns(RuntimeWarning, match=f"must be private to the user, got {shared}[^\n]*$"):
        second = cache_folder(MODULE)
    assert second.path is not None
    assert second.path.parent == own
    assert second.path.stat().st_mode & 0o777 == 0o700
    assert second.read("code") is None
    assert len(second.refused) == 1


def test_a_warning_is_one_line(bases: tuple[Path, Path]) -> None:
    first = cache_folder(MODULE)
    assert first.path is not None
    first.path.chmod(0o777)
    forget()
    with pytest.warns(RuntimeWarning) as told:
        cache_folder(MODULE)
    (one,) = told
    shown = warnings.formatwarning(one.message, one.category, one.filename, one.lineno)
    (line,) = shown.splitlines()
    assert line.endswith("with the mode 0777: its files are not used (remove it)")


def test_another_users_folder_is_not_read(
    bases: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    first = cache_folder(MODULE)
    first.write("code", b"planted")
    us = os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: us + 1)
    assert first.read("code") is None


def test_users_of_one_folder_have_separate_caches(
    bases: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise the second user would be warned about the first one's folder."""
    before, us = kernel_folder._digest("sources"), os.geteuid()
    monkeypatch.setattr(os, "geteuid", lambda: us + 1)
    assert kernel_folder._digest("sources") != before


def test_a_file_is_read_by_its_own_name_and_not_through_links(tmp_path: Path) -> None:
    folder = CacheFolder(tmp_path)
    folder.write("code", b"kept")
    os.link(tmp_path / "code", tmp_path / "other")
    (tmp_path / "link").symlink_to(tmp_path / "code")
    os.mkfifo(tmp_path / "pipe")
    assert folder.read("code") == b"kept"
    for name in ("other", "link", "pipe", "missing"):
        assert folder.read(name) is None
    (tmp_path / "code").chmod(0o666)
    assert folder.read("code") is None


def test_a_planted_link_is_replaced_and_its_target_unchanged(tmp_path: Path) -> None:
    (tmp_path / "letter").write_text("mine")
    folder = CacheFolder(tmp_path / "cache")
    (tmp_path / "cache").mkdir(mode=0o700)
    (tmp_path / "cache" / "code").symlink_to(tmp_path / "letter")
    folder.write("code", b"kept")
    assert (tmp_path / "letter").read_text() == "mine"
    assert folder.read("code") == b"kept"


def test_files_are_private_whatever_the_mask(tmp_path: Path) -> None:
    """Catches: with mask 0, files that all may write, which are then written but never read."""
    folder = tmp_path / "folder"
    folder.mkdir(mode=0o700)
    cache = CacheFolder(folder)
    before = os.umask(0)
    try:
        cache.write("name", b"data")
    finally:
        os.umask(before)
    assert (folder / "name").stat().st_mode & 0o777 == 0o600
    assert cache.read("name") == b"data"

"""Two locations for caches, and a process that has not searched for them yet."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from longwave.support.compiled import kernel_folder


def caches_in(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Path, Path]]:
    """Put the caches in a folder, shared with other users or the user's own."""
    found = folder / "shared", folder / "own"
    monkeypatch.setattr(kernel_folder, "_bases", lambda _: iter(found))
    forget()
    yield found
    forget()


def forget() -> None:
    """Forget which locations were found and reported."""
    kernel_folder.cache_folder.cache_clear()
    kernel_folder._warn.cache_clear()

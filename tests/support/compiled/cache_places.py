"""Two places for caches, and a process that has not looked for them yet."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from longwave.support.compiled import kernel_folder


def caches_in(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Path, Path]]:
    """Have caches kept in a folder: in a place that users share, or in one's own."""
    found = folder / "shared", folder / "own"
    monkeypatch.setattr(kernel_folder, "_bases", lambda _: iter(found))
    forget()
    yield found
    forget()


def forget() -> None:
    """Forget which places were found and told of."""
    kernel_folder.cache_folder.cache_clear()
    kernel_folder._warn.cache_clear()

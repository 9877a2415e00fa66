"""Catches: a command run by unpickling a file in the cache."""

import os
import pickle
from pathlib import Path
from typing import Any

from longwave.solutions.data_store import DataStore
from longwave.support.compiled.kernel_folder import CacheFolder


class Planted:
    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Any, ...]:
        return os.mkdir, (str(self.path),)


def test_a_planted_pickle_calls_nothing(tmp_path: Path) -> None:
    folder = CacheFolder(tmp_path)
    store = DataStore(__name__, "key", folder)
    store.write("data", [1.0])
    (path,) = tmp_path.iterdir()
    folder.write(path.name, pickle.dumps(Planted(tmp_path / "made")))
    assert store.read("data") is None
    assert not (tmp_path / "made").exists()

"""Replace a function by a hostile one in every process that is started.

The variable ``HOSTILE`` is ``how module:function``: a call that takes more and more memory, or one
that never ends, in compiled code that holds the GIL.
"""

import ctypes
import importlib.abc
import importlib.machinery
import importlib.util
import os
import sys
import time
from collections.abc import Sequence
from types import ModuleType

CHUNK, PAUSE = 5_000_000, 0.01
"""Bytes that are taken at once, and seconds between: less than 500 MB a second."""


def take_memory(*_: object, **__: object) -> None:
    taken = []
    while True:
        taken.append(bytearray(CHUNK))
        taken[-1][::4096] = b"1" * len(range(0, CHUNK, 4096))
        time.sleep(PAUSE)


def never_end(*_: object, **__: object) -> None:
    mutex, libc = ctypes.create_string_buffer(256), ctypes.PyDLL(None)
    libc.pthread_mutex_lock(mutex)
    libc.pthread_mutex_lock(mutex)


HOW = {"memory": take_memory, "time": never_end}


class Replacing(importlib.abc.MetaPathFinder):
    """Import hook that finds one module and replaces a function in it."""

    def __init__(self, how: str, place: str) -> None:
        self._hostile = HOW[how]
        self._module, _, self._name = place.partition(":")

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname != self._module:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(fullname)
        assert spec is not None
        assert spec.loader is not None
        execute = spec.loader.exec_module

        def exec_module(module: ModuleType) -> None:
            execute(module)
            assert hasattr(module, self._name)
            setattr(module, self._name, self._hostile)

        spec.loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec


if "HOSTILE" in os.environ:
    sys.meta_path.insert(0, Replacing(*os.environ["HOSTILE"].split()))

"""Lazy exports of a room: its public names, each imported on first use.

A command that only shows its help, or a room that needs one record, imports nothing else.
"""

import sys
import time
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

BEGUN = time.time()
"""Time of the first import of a room, in seconds since the epoch: files changed after it may differ
from the running code."""


def lazy_exports(
    room: str, modules: Mapping[str, str]
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return a room's ``__getattr__`` and ``__dir__``.

    ``modules`` maps each module to the names that it provides, separated by spaces.
    """
    module_by_name = {name: module for module, names in modules.items() for name in names.split()}

    def get(name: str) -> object:
        if name not in module_by_name:
            from longwave.support.known_names import one_of

            known = "" if name.startswith("_") else f" ({one_of(name, sorted(module_by_name))})"
            raise AttributeError(f"{room} has no public name {name!r}{known}")
        value = getattr(import_module(module_by_name[name]), name)
        setattr(sys.modules[room], name, value)
        return value

    return get, lambda: sorted({*vars(sys.modules[room]), *sys.modules[room].__all__})


def declared_exports(
    room: str,
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a room from the room's own source.

    The exported names are those that the source imports for type checkers: ``from MODULE import
    NAME as NAME``.
    """
    modules: dict[str, str] = {}
    loader: Any = sys.modules[room].__loader__
    for line in loader.get_source(room).splitlines():
        match line.split():
            case ["from", module, "import", name, "as", _]:
                modules[module] = f"{modules.get(module, '')} {name}"
    return *lazy_exports(room, modules), sorted(" ".join(modules.values()).split())

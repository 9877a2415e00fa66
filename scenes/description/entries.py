"""Entries that a scene may name, and its run: both lie above a description.

`longwave.scenes` sets them when it is imported, before any of its modules. The entries are listed
in `scenes/tables.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import xarray as xr


class Entry:
    """A start, a domain or an engine that a scene may name."""


E = TypeVar("E", bound=Entry)

table: Callable[[type[E]], Mapping[str, E]]
"""Return the entries of one kind by their names."""

run: Callable[..., xr.Dataset]
"""Run a scene; takes it and the callbacks of `Scene.run`."""

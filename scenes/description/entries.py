"""Hooks: functions that look up starts, domains and engines by name, and that run a scene.

Descriptions must not import starts and engines. Therefore `longwave.scenes` sets the hooks when it
is imported, before any of its modules. The entries are listed in `scenes/tables.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import xarray as xr

E = TypeVar("E")

table: Callable[[type[E]], Mapping[str, E]]
"""Function that returns all entries of one record type, such as `StartRules`, by name."""

run: Callable[..., xr.Dataset]
"""Function that runs a scene; it takes the scene and the callbacks of `Scene.run`."""

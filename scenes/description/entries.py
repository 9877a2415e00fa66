"""Hooks for the starts that a scene may name and for the function that runs a scene.

Descriptions must not import starts and engines. Therefore `longwave.scenes` sets the hooks when it
is imported, before any of its modules.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

starts: Callable[[], Mapping[str, Any]]
"""Function that returns `starts.start_entries.STARTS`."""

run: Callable[..., xr.Dataset]
"""Function that runs a scene; it takes the scene and the callbacks of `Scene.run`."""

"""The function that runs a scene; `longwave.scenes` sets it, as a description knows no engine."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

run: Callable[..., xr.Dataset]
"""Takes the scene and the callbacks of `Scene.run`."""

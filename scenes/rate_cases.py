"""Scenes for convergence studies, read from `rates.toml`.

The file states no expected rates: these follow from the expansion (`convergence.scene_rate`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from longwave.scenes.description.scene import Scene
from longwave.support.user_files import parse_toml

if TYPE_CHECKING:
    from longwave.scenes.convergence import SceneConvergence

RATES_FILE = "rates.toml"

LATE_TIMES = 61
"""Number of late times to compare an envelope at; many, as its error beats with the carrier."""


@dataclass(frozen=True)
class RateCase:
    """Scene of a convergence study, with the ``orders`` of its data and the values of ``eps``.

    A case with ``is_long`` takes long and is run for the full report only.
    """

    scene: Scene
    orders: tuple[str, ...]
    eps: tuple[float, ...]
    is_long: bool

    def study(self, order: str) -> SceneConvergence:
        """Run the convergence study with initial data of this order, such as "leading"."""
        from longwave.scenes.convergence import scene_convergence  # loads SymPy

        return scene_convergence(self.scene.changed(order=order), self.eps)


@cache
def rate_cases() -> Mapping[str, RateCase]:
    """Return the cases by name, in the order of `rates.toml`."""
    text = files("longwave.scenes").joinpath(RATES_FILE).read_bytes()
    tables = dict(parse_toml(text, RATES_FILE, "scene"))
    defaults = tables.pop("usual")
    return {name: _case(name, defaults | table) for name, table in tables.items()}


def _case(name: str, table: dict[str, Any]) -> RateCase:
    orders, eps, is_long = table.pop("orders"), table.pop("at"), table.pop("long", False)
    if "late" in table:
        first, last = table.pop("late")
        late = np.linspace(first, last, LATE_TIMES).tolist()
        table["slow_times"] = [*table["slow_times"], *late]
    scene = Scene.of_document(table | {"name": name, "eps": eps[0]}, Path(RATES_FILE))
    return RateCase(scene, tuple(orders), tuple(eps), is_long)

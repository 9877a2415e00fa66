"""Scenes and the rates at which their errors must fall with eps, as data: `rates.toml`.

What they must fall with is in no table: it follows from the expansion (`convergence.scene_rate`).
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

FILE = "rates.toml"

LATE = 61
"""Times at which an envelope is compared, whose errors beat with its carrier."""


@dataclass(frozen=True)
class RateCase:
    """A scene, the ``orders`` of its data and the values of ``eps`` at which its errors are taken.

    ``is_long`` if the full report alone has it.
    """

    scene: Scene
    orders: tuple[str, ...]
    eps: tuple[float, ...]
    is_long: bool

    def study(self, order: str) -> SceneConvergence:
        """The errors with data of that order, and their rate."""
        from longwave.scenes.convergence import scene_convergence  # with SymPy; a list needs none

        return scene_convergence(self.scene.changed(order=order), self.eps)


@cache
def rate_cases() -> Mapping[str, RateCase]:
    """The cases by name: the row of the equation, as in the tests of the reductions."""
    text = files("longwave.scenes").joinpath(FILE).read_bytes()
    tables = dict(parse_toml(text, FILE, "scene"))
    usual = tables.pop("usual")
    return {name: _case(name, usual | found) for name, found in tables.items()}


def _case(name: str, given: dict[str, Any]) -> RateCase:
    orders, eps, is_long = given.pop("orders"), given.pop("at"), given.pop("long", False)
    if "late" in given:
        first, last = given.pop("late")
        late = np.linspace(first, last, LATE).tolist()
        given["slow_times"] = [*given["slow_times"], *late]
    scene = Scene.of_document(given | {"name": name, "eps": eps[0]}, Path(FILE))
    return RateCase(scene, tuple(orders), tuple(eps), is_long)

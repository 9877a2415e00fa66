"""A run's own error: how far it may be from the infinite lattice, in the units of what it measures.

With a tolerance it is the estimate, the same at all times; with a stated step twice what half the
step and twice the sites change, at the snapshots, if the scene asks for that.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from longwave.scenes.engines.methods import wave_size
from longwave.scenes.observed.observables import measured_error

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from longwave.scenes.description.scene import Scene
    from longwave.support.labelled_arrays import Labelled


def scaled_own_error(run: Labelled) -> NDArray[np.float64] | None:
    """The run's own error at each snapshot, in units of eps or of its power that errors are told
    in; None if the run did not measure it."""
    estimate = run.attrs.get("error_estimate")
    if estimate is not None:
        return np.full(run.sizes.get("time", 0), float(estimate))
    return measured_error(run)


def own_error_at(run: Labelled, scene: Scene, name: str, place: int) -> float:
    """The run's own error in units of its variable ``name``, ``error``, ``error_curve`` or
    ``error_curve_far_field``, and at that place of it; NaN where it was not measured."""
    own, held = scaled_own_error(run), run.variables
    if own is None:
        return math.nan
    if name == "error" and "sup_error" in held:
        relative, apart = (float(held[part].values[place]) for part in ("error", "sup_error"))
        return float(own[place]) * relative / apart if apart > 0.0 else math.nan
    unit = scene.eps ** run.attrs.get("power", 1)
    if name == "error":
        wave, background = (held[part].values[place] for part in ("analytic", "background"))
        return float(own[place]) * unit / (float(np.max(np.abs(wave - background))) or math.nan)
    t = float(held["curve_time"].values[place])
    here = own if "error_estimate" in run.attrs else own[held["time"].values == t]
    if not here.size:
        return math.nan
    return float(here[0]) * unit / (wave_size(scene, t, name.endswith("far_field")) or math.nan)

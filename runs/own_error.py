"""A run's own numerical error: how far it may be from the exact motion of the infinite lattice.

With a tolerance this is the run's error estimate, the same at all times. With a stated step it is
twice the change of the solution at half the step and twice the sites, at each snapshot, if the
scene measures that.
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
    """Return the run's own error at each snapshot, shape (time,), or None if it was not measured.

    The unit is eps, or the power of eps in which the run reports its errors.
    """
    estimate = run.attrs.get("error_estimate")
    if estimate is not None:
        return np.full(run.sizes.get("time", 0), float(estimate))
    return measured_error(run)


def own_error_at(run: Labelled, scene: Scene, name: str, index: int) -> float:
    """Return the run's own error at ``index`` of its variable ``name``, in that variable's units.

    ``name`` is ``error``, ``error_curve`` or ``error_curve_far_field``. Returns NaN where the error
    was not measured.
    """
    errors, variables = scaled_own_error(run), run.variables
    if errors is None:
        return math.nan
    if name == "error" and "sup_error" in variables:
        relative, distance = (float(variables[key].values[index]) for key in ("error", "sup_error"))
        return float(errors[index]) * relative / distance if distance > 0.0 else math.nan
    scale = scene.eps ** run.attrs.get("power", 1)
    if name == "error":
        wave, background = (variables[key].values[index] for key in ("analytic", "background"))
        return float(errors[index]) * scale / (float(np.max(np.abs(wave - background))) or math.nan)
    t = float(variables["curve_time"].values[index])
    at_time = errors if "error_estimate" in run.attrs else errors[variables["time"].values == t]
    if not at_time.size:
        return math.nan
    return float(at_time[0]) * scale / (wave_size(scene, t, name.endswith("far_field")) or math.nan)

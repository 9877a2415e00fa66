"""The error split into a shift in position, a change of amplitude and a change of shape.

With y the run's strain, w the wave, b its bare background and n the compared sites, the shift d
(sites) and the scale a minimise

    sum_n ( y_n - [ b(n - d) + a (w - b)(n - d) ] )^2

The error is then, exactly,

    y - w  =  position + amplitude + shape
    position   =  w(n - d) - w(n)
    amplitude  =  (a - 1) (w - b)(n - d)
    shape      =  y_n - b(n - d) - a (w - b)(n - d)

Each is reported as its largest modulus over max_n |w - b|, the denominator of the error figure.
"""

from collections.abc import Mapping

import numpy as np
from scipy.optimize import least_squares

from verify.lattice.observables.entry import Array, View


def error_split(view: View) -> Mapping[str, float]:
    """Shift, scale, and the three parts of the relative error."""
    analytic = view.analytic
    height = float(np.max(np.abs(analytic - view.background)))
    shift, scale = fit(view)
    wave, background, _, _ = view.displaced(shift)
    parts = {
        "error_position": wave - analytic,
        "error_amplitude": (scale - 1.0) * (wave - background),
        "error_shape": view.numeric - background - scale * (wave - background),
    }
    found = {name: float(np.max(np.abs(part))) / height for name, part in parts.items()}
    return {"shift": shift, "scale": scale} | found


def fit(view: View) -> tuple[float, float]:
    """The least-squares shift (sites) and scale, started from no shift and from the crests' one."""
    run, wave = view.numeric - view.background, view.analytic - view.background
    crests = float(np.argmax(np.abs(run)) - np.argmax(np.abs(wave)))
    fits = [
        least_squares(
            lambda unknown: _residual(view, unknown),
            [start, 1.0],
            lambda unknown: _slopes(view, unknown),
            method="lm",
            xtol=1e-12,
        )
        for start in sorted({0.0, crests})
    ]
    best = min(fits, key=lambda found: float(found.cost))
    return float(best.x[0]), float(best.x[1])


def _residual(view: View, unknown: Array) -> Array:
    wave, background, _, _ = view.displaced(float(unknown[0]))
    return view.numeric - background - float(unknown[1]) * (wave - background)


def _slopes(view: View, unknown: Array) -> Array:
    wave, background, wave_slope, background_slope = view.displaced(float(unknown[0]))
    by_shift = background_slope + float(unknown[1]) * (wave_slope - background_slope)
    return np.stack([by_shift, background - wave], axis=1)

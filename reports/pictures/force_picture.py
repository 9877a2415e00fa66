"""A picture of a fitted force law with its data points and residuals."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from longwave.derive.intervals import HALF_WIDTH
from longwave.reports.pictures.drawing import STABLE
from longwave.reports.pictures.style import CURVES, WIDTHS
from longwave.scenes.fits.force_fit import ForceFit
from longwave.support.user_files import cut

CURVE_POINTS, LONGEST_TITLE = 400, 60


def force_figure(fit: ForceFit, label: str) -> Figure:
    """Return a figure of the points with the law, above their residuals in standard deviations."""
    figure = Figure((WIDTHS[1], 3.4), layout="constrained")
    above, below = figure.subplots(2, sharex=True, height_ratios=(2, 1))
    stretch = fit.data.stretch
    style: dict[str, Any] = {**CURVES[0], "linestyle": "", "capsize": 2.0}
    above.errorbar(stretch, fit.data.force, fit.errors, label=label, **style)
    fine = np.linspace(stretch[0], stretch[-1], CURVE_POINTS)
    above.plot(fine, fit.forces(fine), color="black", linewidth=0.8, label="fitted law")
    above.set_ylabel("force")
    above.legend()
    below.axhspan(-HALF_WIDTH, HALF_WIDTH, color=STABLE, lw=0)
    below.axhline(0.0, color="black", linewidth=0.8)
    below.plot(stretch, fit.residuals, **(CURVES[0] | {"linestyle": ""}))
    below.set(xlabel="stretch", ylabel="residual / deviation")
    figure.suptitle(
        cut(f"F(x) = {fit.law.text}", LONGEST_TITLE), parse_math=False, fontsize="medium"
    )
    return figure

"""A fitted force law over its points, and what is left."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from longwave.derive.intervals import WIDE
from longwave.reports.pictures.drawing import STABLE
from longwave.reports.pictures.style import CURVES, WIDTHS
from longwave.scenes.fits.force_fit import ForceFit
from longwave.support.user_files import cut

CURVE_POINTS, LONGEST_TITLE = 400, 60


def force_figure(found: ForceFit, where: str) -> Figure:
    """The points with the law above, their residuals in standard deviations below."""
    figure = Figure((WIDTHS[1], 3.4), layout="constrained")
    above, below = figure.subplots(2, sharex=True, height_ratios=(2, 1))
    stretch = found.data.stretch
    look: dict[str, Any] = {**CURVES[0], "linestyle": "", "capsize": 2.0}
    above.errorbar(stretch, found.data.force, found.errors, label=where, **look)
    fine = np.linspace(stretch[0], stretch[-1], CURVE_POINTS)
    above.plot(fine, found.forces(fine), color="black", linewidth=0.8, label="fitted law")
    above.set_ylabel("force")
    above.legend()
    below.axhspan(-WIDE, WIDE, color=STABLE, lw=0)
    below.axhline(0.0, color="black", linewidth=0.8)
    below.plot(stretch, found.residuals, **(CURVES[0] | {"linestyle": ""}))
    below.set_xlabel("stretch")
    below.set_ylabel("residual / deviation")
    figure.suptitle(
        cut(f"F(x) = {found.law.text}", LONGEST_TITLE), parse_math=False, fontsize="medium"
    )
    return figure

"""Every wave of mKdV.

$U(\\xi, \\tau)$ for $-12 \\le \\xi \\le 12$ (horizontal) and $-2 \\le \\tau \\le 2$ (vertical).
The pictures of rational waves show a smaller range.
"""

import numpy as np
from matplotlib.figure import Figure
from sympy import S

from longwave.derive import NormalForm
from longwave.solutions import CATALOGUE, Wave

VALUES = {"k": 0.8, "alpha": 0.8, "A": 1, "p": 1, "q": 0.7, "A_1": 1.2, "A_2": 0.7}
VALUES |= {"U_0": 0.5, "kappa": 1}


def picture() -> Figure:
    """One panel for each closed form."""
    figure = Figure((6.5, 6.5), layout="constrained")
    for form, ax in zip(CATALOGUE.of("mKdV"), figure.subplots(4, 4).flat, strict=True):
        own = {p.name: VALUES[p.name] for p in form.parameters if p.name in VALUES}
        wave = Wave(form, NormalForm(S.One, S.One, S(form.equation.s), S.One), **own)
        width, height = (3, 0.3) if form.name.startswith("rational") else (12, 2)
        across, upwards = np.linspace(-width, width, 181), np.linspace(-height, height, 121)
        xi, tau = np.meshgrid(across, upwards)
        ax.imshow(wave(xi, tau).Y, origin="lower", aspect="auto", cmap="viridis")
        ax.set_title(form.name, fontsize=8)
        ax.set_axis_off()
    return figure

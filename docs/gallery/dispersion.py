"""Where long waves end.

The dispersion relation of the lattice, and the first two terms of its expansion for long waves,
which are those of the mKdV equation.
"""

import numpy as np
import sympy as sp
from matplotlib.figure import Figure

from longwave.derive import dispersion_relation
from longwave.derive.symbols import K2, k
from longwave.reports.pictures.style import CURVES


def picture() -> Figure:
    """Both relations for K2 = 1, about zero strain."""
    relation = dispersion_relation().at(sp.Integer(0))
    wavenumber = np.linspace(0, np.pi, 200)
    figure = Figure((4.5, 2.6), layout="constrained")
    ax = figure.subplots()
    curves = [("lattice", relation.omega_plus), ("long waves", relation.long_wave())]
    for (label, omega), look in zip(curves, CURVES, strict=False):
        values = sp.lambdify(k, omega.subs(K2, 1), "numpy")(wavenumber)
        ax.plot(wavenumber, values, label=label, **look | {"marker": ""})
    ax.set_xlabel("$k$")
    ax.set_ylabel("$\\omega$")
    ax.legend()
    return figure

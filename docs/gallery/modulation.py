"""Where plane waves are unstable.

Carrier waves of the FPUT lattice with cubic and quartic energies, $K_2 = K_4 = 1$: the growth rate
of the fastest perturbation if the envelope is focusing, grey if it is not. The coefficients are
derived once, as functions of $k$ and $K_3$, and evaluated on the grid.
"""

import numpy as np
from matplotlib.figure import Figure

from longwave import LATTICES
from longwave.reports.pictures.lattice_figures import modulation_figure
from longwave.scenes.modulation import modulation_grid


def picture() -> Figure:
    """Growth rate over wavenumber and K3."""
    k, K3 = np.meshgrid(np.linspace(0.01, np.pi, 200), np.linspace(0, 1.5, 200))
    return modulation_figure(modulation_grid(LATTICES["fput_strain"], k, K2=1, K3=K3, K4=1), K3)

"""Energy and integration schemes.

A sech soliton on a ring, with the same time step for all schemes. RK4 loses energy at every step.
The splittings conserve it up to an error that does not grow.
"""

import numpy as np
from matplotlib.figure import Figure

from longwave import Scene, run
from longwave.reports.pictures.style import CURVES


def scene(scheme: str) -> Scene:
    """The soliton with that scheme."""
    return Scene.of(
        name=scheme,
        wave="soliton_sech",
        parameters=(("A", 1),),
        eps=0.15,
        t0=0,
        snapshots=(2000,),
        K2=1,
        K4=1,
        scheme=scheme,
        step=0.5,
        domain="ring",
        sites=8192,
        compared=100,
        observables=("energy",),
        look_points=201,
    )


def picture() -> Figure:
    """The relative change of the energy, on a logarithmic axis."""
    figure = Figure((6.5, 2.6), layout="constrained")
    ax = figure.subplots()
    for scheme, look in zip(("rk4", "mclachlan_4", "kahan_li_8"), CURVES, strict=False):
        energy = run(scene(scheme))["energy"]
        change = np.abs(energy / energy[0] - 1)[1:]
        ax.semilogy(change[energy.dims[0]], change, label=scheme, **look | {"marker": ""})
    ax.set_xlabel("$t$")
    ax.set_ylabel("$|E/E_0 - 1|$")
    figure.legend(loc="outside right center")
    return figure

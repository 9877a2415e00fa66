"""Two solitons in space and time.

The fast soliton overtakes the slow one. Like solitons of the mKdV equation, both have the same
shape after the encounter, and are only shifted.
"""

from matplotlib.figure import Figure

from longwave import Scene, run
from longwave.reports.pictures.drawing import space_time_map
from longwave.reports.pictures.run_data import placed

SCENE = Scene.of(
    name="two_solitons",
    wave="two_soliton",
    eps=0.2,
    t0=-3000,
    snapshots=(3000,),
    K2=1,
    K4=1,
    parameters=(("A_1", 1.2), ("A_2", 0.7)),
    compared=80,
    tolerance=1e-3,
    observables=("space_time",),
    look_points=241,
)


def picture() -> Figure:
    """The strain over time, in the frame that moves with the sound."""
    return space_time_map(placed(run(SCENE))).figure()

"""A rogue wave on the cnoidal wave.

The lattice started from the closed form at $t = -100$, and the closed form itself. The crest of the
lattice is a little lower than that of the mKdV wave.
"""

from matplotlib.figure import Figure

from longwave import load_scene, run
from longwave.reports.pictures.drawing import snapshot_panels
from longwave.reports.pictures.run_data import snapshots


def picture() -> Figure:
    """The paper's snapshots, 150 sites to either side of the crest."""
    scene = load_scene("rogue_cn_k_0.5")
    return snapshot_panels([snapshots(run(scene), half_width=150)]).figure()

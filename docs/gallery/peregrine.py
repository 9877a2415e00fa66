"""A Peregrine wave on a dimer.

The envelope of a carrier on the optical branch of a chain of light and heavy masses. The lattice
is started long before the crest, and compared with the closed form. On the left is the whole wave,
then its carrier at the crest and at the end.
"""

from matplotlib.figure import Figure

from longwave.reports.pictures.drawing import snapshot_panels
from longwave.reports.pictures.run_data import snapshots
from longwave.scenes import run


def picture() -> Figure:
    """The strain of the cells, 180 and then 16 of them to either side of the crest."""
    found = run("dimer_peregrine")
    wide, near = (snapshots(found, cells, (1, 2)) for cells in (180, 16))
    return snapshot_panels([[wide[0], *near]], "theory").figure()

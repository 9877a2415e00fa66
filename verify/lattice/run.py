"""Running a scene."""

import xarray as xr

from verify.lattice.engine import stated_seconds
from verify.lattice.recording import Progress
from verify.lattice.refine import Announce
from verify.lattice.scene import Scene
from verify.lattice.stencil_run import run_from
from verify.lattice.tolerance import run_to_tolerance
from verify.lattice.trust import check_trust
from verify.lattice.unfinished import Announcer


def run(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> xr.Dataset:
    """Run the scene and return what it asks for.

    Dimensions: ``time`` (the snapshots), ``curve_time``, ``look_time``, ``site`` (offset from the
    site nearest to c t) and what else the observables add. The table of observables
    (`observables/table.py`) says which variables each of them adds; none other is there.

    Attributes: the scene as JSON, versions, cost, and ``blow_up`` (empty if there was none). A run
    that blows up keeps the times before it. With a tolerance also ``error_estimate`` and its parts
    (`tolerance.py`); the scene is then the one with step and domain filled in, if sites were
    computed one by one. ``progress`` is called with the share of the work that is done, 0 .. 1;
    ``announce`` with the seconds that are expected to pass, if they are many.

    Raises ValueError for every input that the scene's wave, lattice or scheme do not admit, and
    UnfinishedRun on Ctrl-C.
    """
    if scene.tolerance is None:
        Announcer(announce or (lambda _: None))(stated_seconds(scene))
        return run_from(scene, None, progress)
    check_trust(scene)
    return run_to_tolerance(scene, progress, announce)

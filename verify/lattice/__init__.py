"""The strain FPUT lattice run from a closed-form wave, and compared with it.

>>> from verify.lattice import load_scene, run
>>> scene = load_scene("breather_sn_k_0.7")
>>> scene.wave, scene.eps, scene.snapshots
('breather_sn', 0.05, (-100.0, 0.0, 100.0))
"""

from verify.lattice.blow_up import BlowUp
from verify.lattice.constants import Constants
from verify.lattice.error import relative_sup_error
from verify.lattice.families import rational_family_scenes
from verify.lattice.restart import load_run, resume, save_run
from verify.lattice.run import run
from verify.lattice.scene import (
    ENGINES,
    OBSERVABLES,
    Scene,
    further_scenes,
    load_scene,
    shipped_scenes,
    with_tolerance,
)
from verify.lattice.scheme import Composition, RungeKutta, Scheme
from verify.lattice.schemes import SCHEMES, scheme_named
from verify.lattice.stability import stability_limit

__all__ = [
    "ENGINES",
    "OBSERVABLES",
    "SCHEMES",
    "BlowUp",
    "Composition",
    "Constants",
    "RungeKutta",
    "Scene",
    "Scheme",
    "further_scenes",
    "load_run",
    "load_scene",
    "rational_family_scenes",
    "relative_sup_error",
    "resume",
    "run",
    "save_run",
    "scheme_named",
    "shipped_scenes",
    "stability_limit",
    "with_tolerance",
]

"""The strain FPUT lattice run from a closed-form wave, and compared with it.

>>> from longwave.scenes.chain import load_scene, run
>>> scene = load_scene("breather_sn_k_0.7")
>>> scene.wave, scene.eps, scene.snapshots
('breather_sn', 0.05, (-100.0, 0.0, 100.0))
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_face import lazy_face

if TYPE_CHECKING:
    from longwave.lattice.model import BlowUp, Model
    from longwave.lattice.schemes import (
        SCHEMES,
        Composition,
        RungeKutta,
        Scheme,
        scheme_named,
        stability_limit,
    )
    from longwave.scenes.chain.observables import OBSERVABLES
    from longwave.scenes.chain.scene import (
        ENGINES,
        Discretisation,
        Scene,
        Tolerance,
        further_scenes,
        load_scene,
        rational_family_scenes,
        shipped_scenes,
        with_tolerance,
    )
    from longwave.scenes.chain.scene_run import resume, run
    from longwave.scenes.chain.view import relative_sup_error

__all__ = [
    "ENGINES",
    "OBSERVABLES",
    "SCHEMES",
    "BlowUp",
    "Composition",
    "Discretisation",
    "Model",
    "RungeKutta",
    "Scene",
    "Scheme",
    "Tolerance",
    "further_scenes",
    "load_scene",
    "rational_family_scenes",
    "relative_sup_error",
    "resume",
    "run",
    "scheme_named",
    "shipped_scenes",
    "stability_limit",
    "with_tolerance",
]

__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "longwave.lattice.model": "BlowUp Model",
        "longwave.lattice.schemes": "SCHEMES Composition RungeKutta Scheme scheme_named "
        "stability_limit",
        "longwave.scenes.chain.observables": "OBSERVABLES",
        "longwave.scenes.chain.scene_run": "resume run",
        "longwave.scenes.chain.scene": "ENGINES Discretisation Scene Tolerance further_scenes "
        "load_scene rational_family_scenes shipped_scenes with_tolerance",
        "longwave.scenes.chain.view": "relative_sup_error",
    },
)

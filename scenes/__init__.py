"""Scenes: waves on lattices, run and compared.

>>> from longwave.scenes import load_scene, run
>>> run(load_scene("breather_sn_k_0.7")).strain.dims
('time', 'site')
"""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from longwave.scenes.description import entries
from longwave.scenes.engines.methods import run_scene
from longwave.support.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from longwave.scenes.description.named_scenes import load_scene
    from longwave.scenes.engines.scene_run import resume, run
    from longwave.scenes.observed.view import relative_sup_error

__all__ = ["load_scene", "relative_sup_error", "resume", "run"]

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "longwave.scenes.description.named_scenes": "load_scene",
        "longwave.scenes.engines.scene_run": "resume run",
        "longwave.scenes.observed.view": "relative_sup_error",
    },
)


def _table(kind: type[entries.E]) -> Mapping[str, entries.E]:
    from longwave.scenes import tables  # imported with the first scene

    return {name: entry for name, entry in vars(tables).items() if isinstance(entry, kind)}


entries.run, entries.table = run_scene, _table  # a scene is described below what runs it

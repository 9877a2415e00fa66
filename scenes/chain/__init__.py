"""mKdV waves on the paper's chain: data, domains, observables, engines, runs.

>>> from longwave.scenes.chain import run
>>> from longwave.scenes.named_scenes import load_scene
>>> run(load_scene("breather_sn_k_0.7")).strain.dims
('time', 'site')
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_face import lazy_face

if TYPE_CHECKING:
    from longwave.scenes.chain.scene_run import resume, run
    from longwave.scenes.chain.view import relative_sup_error

__all__ = ["relative_sup_error", "resume", "run"]

__getattr__, __dir__ = lazy_face(
    __name__,
    {
        "longwave.scenes.chain.scene_run": "resume run",
        "longwave.scenes.chain.view": "relative_sup_error",
    },
)

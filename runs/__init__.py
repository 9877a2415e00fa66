"""Runs saved as NetCDF-4 files, stores of runs, and sweeps.

>>> from longwave.runs import load_run, open_run, save_run
"""

from typing import TYPE_CHECKING

from longwave.support.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from longwave.runs.run_file import load_run, open_run, save_run, scene_of_run

__all__ = ["load_run", "open_run", "save_run", "scene_of_run"]

__getattr__, __dir__ = lazy_exports(
    __name__, {"longwave.runs.run_file": "load_run open_run save_run scene_of_run"}
)

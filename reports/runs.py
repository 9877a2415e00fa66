"""Running scenes in several processes, with their progress reported as one number each."""

import multiprocessing as mp
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_EXCEPTION, Future, ProcessPoolExecutor, wait
from ctypes import c_double
from typing import Any

import xarray as xr

from verify.lattice import Scene, run

POLL = 0.2
"""Seconds between two looks at the progress."""

_shares: Any = None


def run_scenes(
    scenes: Mapping[str, Scene], workers: int, progress: Callable[[float], None]
) -> dict[str, xr.Dataset]:
    """Run all scenes in `workers` processes and return the runs under the scenes' keys.

    `progress` is called from time to time with the share of the work done, 0 .. 1. The first
    failing run's exception is raised here and the runs not yet begun are dropped.

    Raises ValueError unless workers >= 1.
    """
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
    context = mp.get_context("spawn")
    shares: Any = context.Array(c_double, len(scenes), lock=False)
    with ProcessPoolExecutor(workers, context, _share_progress, (shares,)) as pool:
        jobs = {
            name: pool.submit(_run_one, place, scene)
            for place, (name, scene) in enumerate(_longest_first(scenes).items())
        }
        _watch(jobs, lambda: progress(sum(shares) / len(shares)))
    progress(1.0)
    return {name: jobs[name].result() for name in scenes}


def _longest_first(scenes: Mapping[str, Scene]) -> dict[str, Scene]:
    """Order the scenes by force evaluations, so that no long run is left for the end."""

    def work(item: tuple[str, Scene]) -> float:
        scene = item[1]
        steps = (scene.end - scene.t0) / scene.step
        return steps * scene.scheme_table.stages * scene.sites

    return dict(sorted(scenes.items(), key=work, reverse=True))


def _watch(jobs: Mapping[str, Future[xr.Dataset]], report: Callable[[], None]) -> None:
    """Wait for the jobs, reporting meanwhile; cancel the rest and raise when one fails."""
    pending = set(jobs.values())
    while pending:
        done, pending = wait(pending, POLL, FIRST_EXCEPTION)
        report()
        for job in done:
            if job.exception() is not None:
                for other in pending:
                    other.cancel()
                job.result()


def _share_progress(shares: Any) -> None:
    """Keep the array of progress shares in this worker process."""
    global _shares
    _shares = shares


def _run_one(place: int, scene: Scene) -> xr.Dataset:
    """Run one scene in a worker process, writing its progress at its place."""

    def progress(share: float) -> None:
        _shares[place] = share

    return run(scene, progress)

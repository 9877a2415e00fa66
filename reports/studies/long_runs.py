"""Long runs on periodic backgrounds on the spectral ring, compared with the stencil engine.

The stencil runs on a ring of whole sites that does not close. It is so wide that no signal from
its seam reaches a compared site, so its domain causes no error. The error of its step is measured
by a second run with a shorter step.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import xarray as xr

from longwave.lattice.trial import Progress
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene, scene_of
from longwave.scenes.description.numerics import Discretisation
from longwave.scenes.description.scene import Scene
from longwave.support.processes import Job, Key

LONG_SCENES = ("breather_sn_k_0.7_long", "rogue_cn_k_0.5_long", "soliton_dn_k_0.7_long")
SPLIT_SCENE = "split_rational_3"
"""Name of the scene of the third-order rational wave whose shift splits its peak."""

SHARES = (0.6, 0.45)
"""Steps of the coarse and the fine stencil run, as fractions of the longest allowed step."""


@dataclass(frozen=True)
class LongRun:
    """One scene on the spectral ring, and twice on the stencil: ``fine`` has the shorter step."""

    ring: xr.Dataset
    coarse: xr.Dataset
    fine: xr.Dataset

    @property
    def differences(self) -> xr.DataArray:
        """Sup difference of y/eps between the engines on the compared sites, at each snapshot."""
        return self._difference(self.ring)

    @property
    def own(self) -> float:
        """Sup difference of y/eps between the stencil runs, which bounds the finer one's error."""
        return float(self._difference(self.coarse).max(skipna=False))

    @property
    def within_tolerance(self) -> bool:
        """Whether the engines' difference plus `own` is within the tolerance; False for NaN."""
        snapshots, runs = len(scene_of(self.ring).snapshots), (self.ring, self.coarse, self.fine)
        complete = all(run.sizes["time"] == snapshots for run in runs)
        worst = float(self.differences.max(skipna=False)) + self.own
        return complete and worst <= float(self.ring.attrs["tolerance"])

    def _difference(self, other: xr.Dataset) -> xr.DataArray:
        eps = scene_of(self.ring).eps
        difference: xr.DataArray = abs(other["strain"] - self.fine["strain"])
        return difference.max("site", skipna=False) / eps


def by_ring(name: str, progress: Progress | None = None) -> xr.Dataset:
    """Run the scene to its own tolerance on the spectral ring."""
    return run(load_scene(name).changed(engine="spectral"), progress)


def by_sites(name: str, share: float, progress: Progress | None = None) -> xr.Dataset:
    """Run the scene with the stencil engine at ``share`` times the longest allowed step."""
    return run(site_by_site(load_scene(name), share), progress)


def site_by_site(scene: Scene, share: float) -> Scene:
    """Return the scene at ``share`` times the longest step, on a ring whose seam cannot affect
    compared sites."""
    from longwave.scenes.engines.domain_plan import SCHEME, count_cells, longest_step
    from longwave.scenes.engines.lattice_run import domain_plan

    _, domains = domain_plan(scene.changed(engine="stencil"))
    step = share * longest_step(domains.fastest, 0.0)
    sites = count_cells(domains.plain_ends(0))
    return replace(scene, numerics=Discretisation(step, "ring", sites, SCHEME.name))


def long_run_jobs() -> dict[Key, Job]:
    """Return the jobs of the long runs on both engines, and the run of the split wave."""
    jobs: dict[Key, Job] = {}
    jobs["split", SPLIT_SCENE] = Job(run, (load_scene(SPLIT_SCENE),), 4.0, tells=True)
    for name in LONG_SCENES:
        jobs["ring", name] = Job(by_ring, (name,), 5.0, tells=True)
        for share in SHARES:
            jobs["sites", (name, share)] = Job(by_sites, (name, share), 1.5 / share, tells=True)
    return jobs


def long_runs(results: Mapping[Key, Any]) -> dict[str, LongRun]:
    """Collect the long runs from the results of jobs, by scene."""
    return {
        name: LongRun(results["ring", name], *(results["sites", (name, share)] for share in SHARES))
        for name in LONG_SCENES
        if ("ring", name) in results
    }

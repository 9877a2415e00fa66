"""Long runs about periodic backgrounds on the spectral ring, judged by the stencil site by site.

The stencil runs on a ring of whole sites that does not close; it is so wide that no signal from its
seam reaches a compared site. So its domain makes no error, and that of its step is measured by a
second run with a shorter one.
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

SHARES = (0.6, 0.45)
"""Steps of the runs site by site, in units of the longest tried; the second run is the judge."""


@dataclass(frozen=True)
class LongRun:
    """A run to a tolerance, and two of the same scene site by site, the second with less step."""

    ring: xr.Dataset
    coarse: xr.Dataset
    fine: xr.Dataset

    @property
    def differences(self) -> xr.DataArray:
        """Sup of y/eps between the two engines on the compared sites, at each snapshot."""
        return self._apart(self.ring)

    @property
    def own(self) -> float:
        """Sup of y/eps between the two runs site by site: more than the second one's error."""
        return float(self._apart(self.coarse).max(skipna=False))

    @property
    def kept(self) -> bool:
        """Whether the ring keeps its tolerance even if the judge errs against it; no NaN does."""
        wanted = len(scene_of(self.ring).snapshots)
        whole = all(part.sizes["time"] == wanted for part in (self.ring, self.coarse, self.fine))
        worst = float(self.differences.max(skipna=False)) + self.own
        return whole and worst <= float(self.ring.attrs["tolerance"])

    def _apart(self, other: xr.Dataset) -> xr.DataArray:
        eps = scene_of(self.ring).eps
        difference = abs(other["strain"] - self.fine["strain"])
        found: xr.DataArray = difference.max("site", skipna=False) / eps
        return found


def by_ring(name: str, progress: Progress | None = None) -> xr.Dataset:
    """The scene to its own tolerance on the spectral ring."""
    return run(load_scene(name).changed(engine="spectral"), progress)


def by_sites(name: str, share: float, progress: Progress | None = None) -> xr.Dataset:
    """The scene site by site, at a share of the longest step."""
    return run(site_by_site(load_scene(name), share), progress)


def site_by_site(scene: Scene, share: float) -> Scene:
    """The scene on a ring of whole sites whose seam is out of hearing, with its step stated."""
    from longwave.scenes.engines.domain_plan import SCHEME, longest_step, sites_of
    from longwave.scenes.engines.lattice_run import domain_plan

    _, domains = domain_plan(scene.changed(engine="stencil"))
    step = share * longest_step(domains.fastest, 0.0)
    sites = sites_of(domains.plain_ends(0))
    return replace(scene, numerics=Discretisation(step, "ring", sites, SCHEME.name))


def long_run_jobs() -> dict[Key, Job]:
    """The long runs on both engines, and the run of the split wave."""
    jobs: dict[Key, Job] = {}
    jobs["split", SPLIT_SCENE] = Job(run, (load_scene(SPLIT_SCENE),), 4.0, tells=True)
    for name in LONG_SCENES:
        jobs["ring", name] = Job(by_ring, (name,), 5.0, tells=True)
        for share in SHARES:
            jobs["sites", (name, share)] = Job(by_sites, (name, share), 1.5 / share, tells=True)
    return jobs


def long_runs(found: Mapping[Key, Any]) -> dict[str, LongRun]:
    """The long runs among the results of jobs."""
    return {
        name: LongRun(found["ring", name], *(found["sites", (name, share)] for share in SHARES))
        for name in LONG_SCENES
        if ("ring", name) in found
    }

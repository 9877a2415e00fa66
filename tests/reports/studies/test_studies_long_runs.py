"""Long runs judged by the other engine: the verdict follows the numbers, tolerances hold."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from longwave.reports.studies.long_runs import (
    LONG_SCENES,
    SHARES,
    LongRun,
    by_ring,
    by_sites,
    site_by_site,
)
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene

SCENE = load_scene(LONG_SCENES[0])


def fake(scene: Scene, off: float, times: int = 6) -> xr.Dataset:
    """Return a run whose y/eps is wrong by ``off`` at the last time, and exact before."""
    strain = np.zeros((times, 3))
    strain[-1, 1] = off * scene.eps
    data = {"strain": (("time", "site"), strain)}
    attributes = {"scene": scene.toml(), "tolerance": scene.tolerance}
    return xr.Dataset(data, {"time": list(scene.snapshots[:times])}, attributes)


def test_the_difference_is_that_of_y_over_eps_to_the_finer_run() -> None:
    found = LongRun(fake(SCENE, 6e-5), fake(SCENE, 3e-5), fake(SCENE, 2e-5))
    assert float(found.differences.max()) == pytest.approx(4e-5)
    assert found.own == pytest.approx(1e-5)
    assert found.within_tolerance


@pytest.mark.parametrize(
    ("ring", "coarse", "times"),
    [(1.1e-4, 0.0, 6), (9e-5, 2e-5, 6), (0.0, 0.0, 5), (np.nan, 0.0, 6)],
)
def test_a_tolerance_that_is_not_confirmed_is_not_met(
    ring: float, coarse: float, times: int
) -> None:
    """Too far off, a judge too coarse to tell, a run that ended early, and NaN."""
    found = LongRun(fake(SCENE, ring, times), fake(SCENE, coarse), fake(SCENE, 0.0))
    assert not found.within_tolerance


def test_the_reference_ring_is_too_large_for_waves_to_go_around() -> None:
    scene = site_by_site(SCENE, 0.5)
    stated = scene.discretisation
    assert stated.domain == "ring"
    assert stated.sites > 2 * (scene.compared + (scene.end - scene.t0))
    whole = site_by_site(SCENE, 1.0).discretisation
    assert stated.step == pytest.approx(0.5 * whole.step)


def test_engines_agree_on_a_short_piece() -> None:
    """Catches a judge that runs another wave, from another time or in other units."""
    scene = replace(SCENE, snapshots=(-9950.0, -9900.0))
    ring = run(scene.changed(engine="spectral"))
    sites = [run(site_by_site(scene, share)) for share in SHARES]
    assert LongRun(ring, *sites).within_tolerance


@pytest.mark.slow
@pytest.mark.parametrize("name", LONG_SCENES)
def test_long_scenes_keep_their_tolerance(name: str) -> None:
    found = LongRun(by_ring(name), *(by_sites(name, share) for share in SHARES))
    assert found.within_tolerance
    assert found.own < 0.05 * found.ring.attrs["tolerance"]
    assert float(found.differences.max()) <= found.ring.attrs["error_estimate"] + found.own

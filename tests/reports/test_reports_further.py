"""Further tables: laws and faults by eps, the split wave's ends, long runs with a judge's word."""

import numpy as np
import pytest
import xarray as xr

from longwave.reports.sections.runs import (
    SNAPSHOTS_PER_ROW,
    long_table,
    peak_panels,
    peak_table,
    split_rows,
    split_table,
)
from longwave.reports.studies.lattice_cost import PeakError
from longwave.reports.studies.long_runs import LONG_SCENES, LongRun
from longwave.scenes.description.named_scenes import load_scene

SPLIT = "split_rational_3"


def fake(name: str, off: float = 0.0) -> xr.Dataset:
    """Return a scene's run: a wave of height 4 on a background of -1, the lattice ``off`` above."""
    scene = load_scene(name)
    shape = (len(scene.snapshots), 5)
    wave = scene.eps * np.tile([-1.0, -2.0, 3.0, -1.0, -1.0], (shape[0], 1))
    data = {
        "strain": (("time", "site"), wave + scene.eps * off),
        "analytic": (("time", "site"), wave),
        "background": (("time", "site"), np.full(shape, -scene.eps)),
        "n": (("time", "site"), np.tile(np.arange(-2, 3), (shape[0], 1))),
        "error": ("time", np.full(shape[0], abs(off) / 4.0)),
    }
    attributes = {
        "scene": scene.toml(),
        "tolerance": scene.tolerance,
        "error_estimate": 4e-5,
        "seconds": 2.0,
        "planning_seconds": 1.0,
        "frame_speed": scene.model.sound_speed(),
        "power": 1,
    }
    return xr.Dataset(data, {"time": list(scene.snapshots), "site": np.arange(-2, 3)}, attributes)


def test_points_without_a_value_say_why() -> None:
    points = [
        PeakError(2, 0.1, 0.04, 1e-6, 3.0, "stencil"),
        PeakError(2, 0.05, 0.01, 1e-6, 3.0, "spectral"),
        PeakError(3, 0.1, 0.04, 0.03, 3.0, "stencil"),
        PeakError(3, 0.05, fault="tolerance must be 50 % larger"),
    ]
    text = peak_table(points)
    assert r"$Y_2$ & $0.1$ & $0.04000$ & $\le$ $1.0\times 10^{-6}$ & stencil & $3.0$" in text
    assert text.count(r"$\epsilon^{2.00}$") == 1
    assert "(not resolved)" in text
    assert r"did not run: tolerance must be 50 \% larger & -- & -- & --" in text


def test_the_figure_holds_resolved_points_and_a_slope_of_two() -> None:
    points = [PeakError(2, eps, eps, 1e-9) for eps in (0.1, 0.05)] + [PeakError(2, 0.02, 1.0, 1.0)]
    (curves,) = peak_panels(points).values()
    assert curves["$Y_2$"] == [(0.1, 0.1), (0.05, 0.05)]
    (low, first), (high, last) = curves[r"$\propto\epsilon^2$"]
    assert (low, high) == (0.05, 0.1)
    assert last / first == pytest.approx(4.0)


def test_the_split_waves_ends_are_in_units_of_eps() -> None:
    text = split_table({SPLIT: fake(SPLIT, 0.1)})
    ends = r"$-11200$ & $-1.900$ & $-2.000$ & $3.100$ & $3.000$ & $4.0\times 10^{-5}$"
    assert ends + r" & $0.025000$ & $1.0\times 10^{-5}$" in text
    assert split_table({}) == ""


def test_the_split_waves_snapshots_fill_their_rows() -> None:
    rows = split_rows({SPLIT: fake(SPLIT)})
    assert [len(row) for row in rows] == [SNAPSHOTS_PER_ROW, SNAPSHOTS_PER_ROW]
    assert rows[0][2].variables["time"].values == -11200.0


def test_a_long_run_is_one_row_and_a_missed_tolerance_is_reported() -> None:
    good, bad = LONG_SCENES[:2]
    runs = {
        good: LongRun(fake(good, 2e-5), fake(good, 1e-6), fake(good)),
        bad: LongRun(fake(bad, 2e-4), fake(bad), fake(bad)),
    }
    lines = long_table(runs).splitlines()
    first, second = (line for line in lines if line.startswith(("breather", "rogue")))
    assert first.startswith("breather sn & 0.0000 & 0.0000")
    assert r"$2.0\times 10^{-5}$ & $1\times 10^{-6}$ & $3.0$ & $2.0$" in first
    assert "TOO LARGE" not in first
    assert "(TOO LARGE)" in second
    assert long_table({}) == ""

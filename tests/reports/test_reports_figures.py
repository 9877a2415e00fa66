"""Figures: colours, all panels drawn, vector output that is the same each time."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

from longwave.reports.pictures.drawing import error_panels, snapshot_panels
from longwave.reports.pictures.error_curve import ErrorCurve
from longwave.reports.pictures.style import CURVES, LATTICE, WAVE, save, styled

SITES = np.arange(-20.0, 21.0)


def snapshot(time: float, eps: float = 0.05) -> xr.Dataset:
    wave = eps / (1 + SITES**2)
    data = {"strain": ("site", 0.9 * wave), "analytic": ("site", wave)}
    return xr.Dataset(data, {"offset": ("site", SITES), "time": time}, {"eps": eps, "wave": "wave"})


def test_the_wave_is_a_thin_line_on_the_beads_of_the_lattice() -> None:
    figure = snapshot_panels([[snapshot(0.0)]]).figure()
    lattice, wave = figure.axes[0].lines
    assert (lattice.get_color(), lattice.get_linestyle()) == (LATTICE, "None")
    assert (wave.get_color(), wave.get_linestyle()) == (WAVE, "-")
    assert wave.get_linewidth() < 0.5 * lattice.get_markersize()
    assert np.array_equal(lattice.get_ydata(), snapshot(0.0)["strain"])
    assert np.array_equal(wave.get_ydata(), snapshot(0.0)["analytic"])


def test_panels_are_lettered_row_by_row_and_share_the_strain_axis() -> None:
    times = (-1.0, 0.0, 1.0)
    rows = [[snapshot(t, eps) for t in times] for eps in (0.05, 0.075)]
    every = snapshot_panels(rows).figure().axes
    axes = [*every[:3], *every[6:9]]
    assert [ax.get_title(loc="left")[:3] for ax in axes] == [f"({c})" for c in "ABCDEF"]
    assert len({ax.get_ylim() for ax in axes[:3]}) == 1
    assert axes[0].get_ylim() != axes[3].get_ylim()


def test_error_axis_starts_at_zero_and_curves_differ_without_colour() -> None:
    times = np.arange(5.0)
    curves = {str(n): ErrorCurve(times, times + n) for n in range(3)}
    (ax,) = error_panels({"(A)": curves}).figure().axes
    assert ax.get_ylim()[0] == 0
    assert len({(line.get_linestyle(), line.get_marker()) for line in ax.lines}) == 3
    assert len({look["color"] for look in CURVES}) == len(CURVES)


@pytest.mark.parametrize(("suffix", "start"), [("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_a_figure_is_written_reproducibly(tmp_path: Path, suffix: str, start: bytes) -> None:
    with styled():
        parts = [snapshot_panels([[snapshot(0.0)]]) for _ in "ab"]
        paths = [save(p.figure(), tmp_path / f"{i}.{suffix}") for i, p in enumerate(parts)]
    first, second = (path.read_bytes() for path in paths)
    assert first.startswith(start)
    assert first == second


def test_the_users_settings_are_restored() -> None:
    with mpl.rc_context({"font.size": 23.0}):
        with styled():
            assert mpl.rcParams["font.size"] < 12
        assert mpl.rcParams["font.size"] == pytest.approx(23.0)

"""The style of all pictures: differences that can be seen, colours, letters, widths, full grids."""

import re
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import (
    cheapest_indices,
    cost_figure,
    crest_track,
    grid_shape,
    snapshot_panels,
)
from longwave.reports.pictures.plotting import plot, shown_half_width
from longwave.reports.pictures.run_data import (
    envelope,
    placed,
    with_looks,
    with_theory,
    within,
)
from longwave.reports.pictures.style import (
    CURVES,
    LATTICE,
    OWN,
    WAVE,
    WIDTHS,
    page_width,
    save,
    styled,
)
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import scene_run
from longwave.support.labelled_arrays import LabelledArrays

Array = NDArray[np.float64]

SCENE = Scene.of(
    name="soliton",
    title="One soliton, 100 % <_{|}> $x",
    wave="soliton_sech",
    parameters=(("A", 1),),
    eps=0.2,
    t0=0,
    snapshots=(0, 7.3, 20),
    K2=1,
    K4=1,
    step=0.5,
    domain="ring",
    sites=512,
    compared=60,
    look_points=33,
    observables=("strain", "space_time", "crest_track", "time_step_error", "domain_error"),
)


@pytest.fixture(scope="module")
def finished_run() -> xr.Dataset:
    return scene_run.run(SCENE)


def differences(figure: Figure) -> list[Axes]:
    """Return the panels of differences, from the left."""
    axes = figure.get_axes()
    first = next(place for place, ax in enumerate(axes) if ax.get_ylabel() == "difference")
    return axes[first : first + first]


def test_below_each_snapshot_is_lattice_less_wave_on_the_runs_own_error(
    finished_run: xr.Dataset,
) -> None:
    """Catches: wave less lattice, another time's band, half of it or twice."""
    half, run = shown_half_width(finished_run), placed(finished_run)
    own = 0.2 * 2.0 * (finished_run.time_step_error + finished_run.domain_error).values
    parts = [within(run, half).isel(time=place) for place in range(3)]
    panels = differences(plot(finished_run, kind="snapshots"))
    assert len(panels) == 3
    for ax, part, error in zip(panels, parts, own, strict=True):
        expected = part["strain"].values - part["analytic"].values
        assert np.array_equal(ax.lines[0].get_ydata(), expected)
        (band,) = ax.patches
        assert (band.get_y(), band.get_height()) == pytest.approx((-error, 2.0 * error), abs=0.0)  # type: ignore[attr-defined]
        assert band.get_facecolor()[:3] == to_rgb(OWN)
        low, high = ax.get_ylim()
        assert -low == high > max(error, float(abs(expected).max()))


def test_a_run_without_own_error_has_no_band(finished_run: xr.Dataset) -> None:
    bare = finished_run.drop_vars(["time_step_error", "domain_error"])
    assert not any(ax.patches for ax in differences(plot(bare, kind="snapshots")))


def test_the_crest_of_the_wave_stands_beside_the_lattices(finished_run: xr.Dataset) -> None:
    """Catches: the lattice's crest once more, a crest in sites and not in the moving frame."""
    data = with_theory(placed(finished_run))
    at, end = finished_run["analytic"].isel(time=-1), data.isel(look_time=-1)
    assert float(end["look_time"].values) == float(at.time) == 20.0
    top = int(np.argmax(at.values))
    assert abs(end["crest_position_wave"].values - data["offset"].values[-1, top]) < 0.6
    assert 1.0 <= float(end["crest_strain_wave"].values) / float(at.max()) < 1.01
    difference = abs(data["crest_strain"].values - data["crest_strain_wave"].values)
    assert difference[0] < 1e-12
    assert difference[-1] > 1e-6
    position, height = plot(finished_run, kind="crest").get_axes()
    assert np.array_equal(position.lines[1].get_ydata(), data["crest_position_wave"].values)
    assert np.array_equal(height.lines[1].get_ydata(), data["crest_strain_wave"].values)
    data["crest_position_wave"].values[5:] += 20.0
    broken = crest_track(data).figure().get_axes()[1].lines[1].get_ydata()
    assert np.flatnonzero(np.isnan(np.asarray(broken))).tolist() == [5]


def test_the_map_is_sheared_into_the_moving_frame(finished_run: xr.Dataset) -> None:
    """Catches: stairs, where the frame passes the sites one by one."""
    data = with_theory(placed(finished_run))
    assert np.abs(data["shift"].values).max() <= 0.5
    assert np.ptp(data["shift"].values) > 0.5
    image = plot(finished_run, kind="space_time").get_axes()[0].images[0]
    values = np.asarray(image.get_array())
    bottom, top = image.get_extent()[2:]
    place = np.linspace(bottom, top, values.shape[0] + 1)
    middles = (place[1:] + place[:-1]) / 2
    moments = (middles[:, None] * values**2).sum(axis=0) / (values**2).sum(axis=0)
    jumps = np.abs(np.diff(moments - data["crest_position"].values))
    assert jumps.max() < 0.05
    assert np.abs(np.diff(data["shift"].values)).max() > 0.3


def test_envelopes_are_those_of_carriers() -> None:
    n = np.arange(-120.0, 121.0)
    shape = 0.4 + 1.0 / np.cosh(n / 15.0)
    for k in (0.7, 1.5, 2.6):
        found = envelope(shape * np.cos(k * n + 0.4) + 0.01 * shape**2)
        known = np.isfinite(found)
        assert known[20:-20].all()
        assert not known[0]
        assert np.abs(found - shape)[30:-30].max() < 0.02
    in_phase = envelope(0.3 * shape * (-1.0) ** n)
    assert np.abs(in_phase - 0.3 * shape)[30:-30].max() < 0.01
    assert np.isnan(envelope(shape)).all()
    assert np.isnan(envelope(np.full(241, np.nan))).all()


def carried(phase: float) -> xr.Dataset:
    """Return a snapshot of a carrier whose envelope in theory is a tenth larger."""
    n = np.arange(-100.0, 101.0)
    wave = np.cos(1.4 * n + phase) / np.cosh(n / 12.0)
    data = {"strain": ("site", wave), "analytic": ("site", 1.1 * wave)}
    return xr.Dataset(data, {"offset": ("site", n), "time": phase}, {"eps": 0.1, "wave": "wave"})


def test_a_carriers_snapshot_has_both_envelopes_to_either_side() -> None:
    at = carried(0.3)
    found = {f"{name}_envelope": ("site", envelope(at[name].values)) for name in at.data_vars}
    figure = snapshot_panels([[at.assign(found)]]).figure(3.4)
    _, *lines = figure.axes[0].lines
    tops = [float(np.nanmax(np.abs(np.asarray(line.get_ydata())))) for line in lines]
    assert tops == pytest.approx([1.0, 1.0, 1.1, 1.1], rel=0.02)
    signs = [np.sign(np.nansum(np.asarray(line.get_ydata()))) for line in lines]
    assert signs == [1.0, -1.0, 1.0, -1.0]
    assert [line.get_color() for line in lines] == [LATTICE, LATTICE, WAVE, WAVE]


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 7, 10, 11, 12])
@pytest.mark.parametrize("columns", [1, 2])
def test_grids_are_full_or_hold_the_legend(
    finished_run: xr.Dataset, count: int, columns: int
) -> None:
    with styled(WIDTHS[columns]):
        down, across = grid_shape(count)
        assert 0 <= down * across - count <= 1
        assert page_width() / across >= 1.6
    if count in (1, 5):
        many = finished_run.isel(time=[0] * count).assign_coords(time=range(count))
        for kind in ("snapshots", "spectra"):
            figure = plot(many, kind=kind, columns=columns)
            for ax in figure.get_axes():
                assert ax.lines or ax.get_legend() is not None
            with_legend = [ax for ax in figure.get_axes() if ax.get_legend()]
            assert len(with_legend) == (count == 5)


# -- colours ---------------------------------------------------------------------------------------

SIGHT = {
    "full": np.eye(3),
    "protan": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
         [-0.003882, -0.048116, 1.051998]]
    ),
    "deutan": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
         [-0.011820, 0.042940, 0.968881]]
    ),
    "tritan": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
         [0.004733, 0.691367, 0.303900]]
    ),
}  # fmt: skip
"""Matrices of colour vision, linear colours (Machado, Oliveira and Fernandes 2009, severity 1)."""


def appearance(colour: str, sight: Array) -> Array:
    """Return the colour in CIELAB, as it appears with a kind of colour vision."""
    srgb = np.array(to_rgb(colour))
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    xyz = np.array(to_xyz) @ np.clip(sight @ linear, 0.0, 1.0) / [0.9505, 1.0, 1.089]
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16.0 / 116.0)
    return np.array([116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])])


def distance(one: str, other: str, sight: Array) -> float:
    return float(np.linalg.norm(appearance(one, sight) - appearance(other, sight)))


@pytest.mark.parametrize("sight", SIGHT)
def test_colours_are_distinct_for_any_colour_vision(sight: str) -> None:
    """Catches: red and green, which no one with deutan sight tells apart."""
    for one, other in combinations((LATTICE, WAVE, "#000000"), 2):
        assert distance(one, other, SIGHT[sight]) > 35.0
    assert distance(OWN, "#000000", SIGHT[sight]) > 35.0
    for one, other in combinations([look["color"] for look in CURVES[:5]], 2):
        assert distance(one, other, SIGHT[sight]) > 9.0
    assert distance("#00AA00", "#D04000", SIGHT["deutan"]) < 35.0


# -- letters and sizes -----------------------------------------------------------------------------


def texts(svg: str) -> Iterator[str]:
    for found in re.findall(r"<text[^>]*>(.*?)</text>", svg, re.DOTALL):
        yield re.sub(r"<[^>]*>|\n\s*", "", found)


def test_text_is_text_in_svg(finished_run: xr.Dataset, tmp_path: Path) -> None:
    plot(finished_run, tmp_path / "run.svg", kind="snapshots")
    svg = (tmp_path / "run.svg").read_text(encoding="utf-8")
    words = list(texts(svg))
    assert "lattice" in words
    assert any("100 %" in text for text in words)
    assert any("=7.3" in text and "ε" in text for text in words)
    assert "'Times New Roman', Times, serif" in svg
    assert "#STIX" not in svg


@pytest.mark.parametrize("font", ["times", "tex"])
def test_letters_are_type_42_in_pdf(finished_run: xr.Dataset, tmp_path: Path, font: str) -> None:
    import zlib

    with styled(3.4, font):
        figure = snapshot_panels([[at] for at in _snapshots(finished_run)]).figure()
        figure.suptitle(SCENE.title, parse_math=False)
        save(figure, tmp_path / "run.pdf")
    raw = (tmp_path / "run.pdf").read_bytes()
    parts = [raw]
    for found in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", raw, re.DOTALL):
        try:
            parts.append(zlib.decompress(found))
        except zlib.error:
            continue
    pdf = b"".join(parts)
    assert b"/CIDFontType2" in pdf
    assert b"/Type3" not in pdf
    assert (b"Cmr10" in pdf) == (font == "tex")


def _snapshots(run: xr.Dataset) -> list[xr.Dataset]:
    from longwave.reports.pictures.run_data import snapshots

    return snapshots(run, 20, (0, 1))


def test_in_tex_what_has_no_letter_is_mathematics(tmp_path: Path) -> None:
    with styled(3.4, "tex"):
        figure = Figure((3.4, 2.0))
        plain = figure.text(0.1, 0.1, "a_b | 5 $ <", parse_math=False)
        mixed = figure.text(0.1, 0.5, r"x_1 $\alpha_1$ y")
        save(figure, tmp_path / "run.png")
    assert plain.get_text() == r"a$\_$b $|$ 5 \$ $<$"
    assert mixed.get_text() == r"x$\_$1 $\alpha_1$ y"


@pytest.mark.slow
@pytest.mark.parametrize("columns", [1, 2])
def test_a_picture_is_as_wide_as_columns(finished_run: xr.Dataset, columns: int) -> None:
    figure = plot(finished_run, columns=columns)
    assert figure.get_figwidth() == WIDTHS[columns]
    figure.draw_without_rendering()
    for ax in figure.get_axes():
        box = ax.get_tightbbox()
        assert box is not None
        assert box.x0 >= -1.0
        assert box.x1 <= figure.bbox.x1 + 1.0


def test_another_number_of_columns_is_one_line() -> None:
    with pytest.raises(ValueError, match=r"^columns must be 1 or 2, got 3 \(of a journal\)$"):
        plot(SCENE, columns=3)


# -- work and precision ----------------------------------------------------------------------------


def test_lines_of_work_join_the_cheapest_runs_alone() -> None:
    """Catches: a zigzag, where a run took longer than a finer one."""
    points = [(1.0, 1e-1), (3.0, 1e-2), (2.0, 1e-3), (4.0, 1e-4), (5.0, 2e-4)]
    work, errors = np.array(points).T
    figure = cost_figure({"one": {"RK4": points}}, "seconds", "error", cheapest="runs")
    runs, line = figure.axes[0].lines
    assert np.array_equal(runs.get_xydata(), np.array(points))
    assert line.get_xdata().tolist() == [1.0, 2.0, 4.0]
    assert np.all(np.diff(np.asarray(line.get_ydata())) < 0.0)
    title = figure.legends[0].get_title().get_text()
    assert title.startswith("points: runs; ")
    assert "monotone envelope" in title
    random = np.random.default_rng(3).uniform(size=(2, 200))
    chosen = cheapest_indices(*random)
    assert np.all(np.diff(random[0][chosen]) > 0.0)
    assert np.all(np.diff(random[1][chosen]) < 0.0)
    for place in set(range(200)) - set(chosen.tolist()):
        beaten = (random[0][chosen] <= random[0][place]) & (random[1][chosen] <= random[1][place])
        assert beaten.any()
    assert not cheapest_indices(np.array([np.nan]), np.array([1.0])).size
    assert cheapest_indices(work, errors).tolist() == [0, 2, 3]


def test_a_run_with_a_law_has_it_at_the_times_of_its_map() -> None:
    """Catches: looks of two lengths, where a scene asks for the crest and is drawn."""
    times, sites = np.arange(9.0), np.arange(-20, 21)
    n = np.broadcast_to(sites, (9, 41))
    wave = np.exp(-0.1 * times)[:, None] / np.cosh(sites / 4.0)
    over = ("time", "site")
    values = {"strain": wave, "analytic": wave, "background": 0.0 * wave, "n": n}
    data = {name: (over, value) for name, value in values.items()}
    data |= dict.fromkeys(("error", "sup_error"), (("time",), 0.0 * times))
    looks = np.linspace(0.0, 8.0, 81)
    data |= {name: (("look_time",), np.exp(-0.1 * looks)) for name in ("crest_law", "crest_strain")}
    data["offset"] = (over, n)
    attrs = {"speed": 0.0, "carried": 0, "unit": 1.0, "scene": SCENE.toml()}
    run = xr.Dataset(data, {"time": times, "site": sites, "look_time": looks}, attrs)
    looked = with_looks(LabelledArrays.of(run))
    assert looked.sizes["look_time"] == 9
    law, strain, wave = (
        looked[f"crest_{name}"].values for name in ("law", "strain", "strain_wave")
    )
    assert np.allclose(law, strain, rtol=2e-3)
    assert np.allclose(wave, strain)

"""`plot`: pictures of each kind of source, titles as plain text, and one-line errors."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from longwave.reports.pictures.drawing import moving_grid
from longwave.reports.pictures.plotting import MAX_PANELS, PICTURES, plot, shown_half_width
from longwave.reports.pictures.run_data import placed, with_theory
from longwave.runs import save_run
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.methods import record_scene
from longwave.scenes.engines.run_record import RunRecord

SCENE = Scene.of(
    name="soliton",
    title="One soliton",
    wave="soliton_sech",
    parameters=(("A", 1),),
    eps=0.2,
    t0=0,
    snapshots=(0, 20),
    K2=1,
    K4=1,
    step=0.5,
    domain="ring",
    sites=512,
    compared=150,
    observables=("strain", "error_curve", "space_time", "crest_track"),
    curve_points=11,
    look_points=11,
)


@pytest.fixture(scope="module")
def finished_run() -> xr.Dataset:
    return run(SCENE)


def labels(figure: object) -> list[str]:
    return [ax.get_ylabel() for ax in figure.get_axes()]  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("suffix", "start"),
    [(".pdf", b"%PDF"), (".svg", b"<?xml"), (".PNG", b"\x89PNG")],
)
def test_the_suffix_says_the_format(
    finished_run: xr.Dataset, tmp_path: Path, suffix: str, start: bytes
) -> None:
    path = tmp_path / f"run{suffix}"
    plot(finished_run[["error_curve"]], path)
    first = path.read_bytes()
    plot(finished_run[["error_curve"]], str(path))
    assert first.startswith(start)
    assert path.read_bytes() == first


def test_all_kinds_are_drawn_in_order_with_the_runs_own_numbers(finished_run: xr.Dataset) -> None:
    figure = plot(finished_run)
    assert labels(figure) == [
        "$y_n$", "", "difference", "", "$n - c\\,t$  (sites)", "$y_n$", "amplitude of $y$", "",
        r"$L^\infty_\epsilon$",
        "crest at $n - c\\,t$  (sites)", "$y$ at the crest",
    ]  # fmt: skip
    axes = figure.get_axes()
    assert np.array_equal(axes[8].lines[0].get_ydata(), finished_run["error_curve"])
    assert np.array_equal(axes[10].lines[0].get_ydata(), finished_run["crest_strain"])
    drawn = np.asarray(axes[4].images[0].get_array())
    assert np.array_equal(drawn, moving_grid(with_theory(placed(finished_run)))[2].T)


@pytest.mark.parametrize("kind", [kind for kind, one in PICTURES.items() if one.observable])
def test_a_single_kind_is_drawn(finished_run: xr.Dataset, kind: str) -> None:
    variables = set(finished_run.data_vars) & set(PICTURES[kind].variables)
    assert labels(plot(finished_run[[*variables, "n"]], kind=kind)) == labels(
        plot(finished_run, kind=kind)
    )


def test_a_bench_is_drawn_with_its_own_kinds(finished_run: xr.Dataset) -> None:
    chain = {"sites": 8}
    tables: dict[str, Any] = {"chain": chain, "start": {"impact": {"site": 0, "velocity": 0.1}}}
    common: dict[str, Any] = {"lattice": "beta_fput", "constants": {"K2": 1, "K4": 1}}
    common |= {"times": [0, 1, 2], "tolerance": 1e-3} | tables
    sensors = {"sites": [0, 3], "of": ["displacement", "force"]}
    observables = {"sensors": sensors, "mode_energies": [1, 2], "state": True}
    run = Scene.of(name="struck", observables=observables, **common).run()
    named = {"sensors": ["displacement", "force in the bond to the next cell"]}
    named |= {"modes": ["energy of the mode of a linear chain"], "cells": ["displacement"]}
    for kind, ylabels in named.items():
        figure = plot(run, kind=kind)
        assert labels(figure) == ylabels
        with pytest.raises(
            ValueError, match=r"source must hold what is drawn .* \(a chain on a be"
        ):
            plot(finished_run, kind=kind)
    panel = plot(run, kind="sensors").get_axes()[0]
    np.testing.assert_array_equal(panel.lines[1].get_ydata(), run.sensor_displacement[:, 1])
    assert [line.get_label() for line in panel.lines] == ["cell 0", "cell 3"]
    assert labels(plot(run)) == [label for ylabels in named.values() for label in ylabels]


def test_a_driven_bench_is_drawn_with_its_energies_and_spectra() -> None:
    times = np.arange(0.0, 64.0, 0.5)
    wave = np.sin(2.0 * np.pi * times / 8.0)[:, np.newaxis]
    attributes = {"units": "lattice units", "long_name": "something"}
    names = ("sensor_displacement", "energy", "work", "heat", "flux", "transmitted")
    axes = (("time", "sensor", "field"), *[("time",)] * 3, *[("time", "cut")] * 2)
    values = (
        wave[..., np.newaxis] * [[[2.0], [0.5]]],
        *np.array([2.0, 3.0, 1.0])[:, None] * times,
        wave,
        wave,
    )
    data = xr.Dataset(
        {
            name: (dims, part, attributes)
            for name, dims, part in zip(names, axes, values, strict=True)
        },
        {"time": times, "sensor": [3, 7], "cut": [5]},
        {"scene": load_scene("driven_chain").toml()},
    )
    spectrum, ratio = plot(data, kind="transmission").get_axes()
    frequency, amplitude = spectrum.lines[0].get_data()
    peak = int(np.argmax(amplitude))
    assert frequency[peak] == pytest.approx(2.0 * np.pi / 8.0)
    assert amplitude[peak] == pytest.approx(2.0)
    (line,) = ratio.lines
    is_drawn = np.isfinite(np.asarray(line.get_ydata()))
    assert is_drawn.sum() == 3
    np.testing.assert_allclose(np.asarray(line.get_ydata())[is_drawn], 0.25)
    (panel,) = plot(data, kind="balance").get_axes()
    drawn = [np.asarray(line.get_ydata())[-1] / times[-1] for line in panel.lines]
    assert drawn == [2.0, 3.0, 1.0]
    assert labels(plot(data, kind="flux")) == ["something", "something"]
    assert len(plot(0.0 * data.isel(sensor=[0]), kind="transmission").get_axes()) == 1
    with pytest.raises(ValueError, match="source must hold what is drawn"):
        plot(data.isel(time=slice(0, 8)), kind="transmission")


def test_pictures_without_data_are_left_out(finished_run: xr.Dataset) -> None:
    assert labels(plot(finished_run[["error_curve"]])) == [r"$L^\infty_\epsilon$"]


def test_a_saved_run_gives_the_same_picture(finished_run: xr.Dataset, tmp_path: Path) -> None:
    """The file may have any name."""
    save_run(finished_run, tmp_path / "renamed")
    plot(tmp_path / "renamed", tmp_path / "saved.png", kind="snapshots")
    plot(finished_run, tmp_path / "direct.png", kind="snapshots")
    assert (tmp_path / "saved.png").read_bytes() == (tmp_path / "direct.png").read_bytes()


def test_a_scene_is_run_for_what_is_drawn_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    scenes: list[Scene] = []

    def noted(scene: Scene, *_: object) -> RunRecord:
        scenes.append(scene)
        return record_scene(scene)

    monkeypatch.setattr("longwave.reports.pictures.plotting.record_scene", noted)
    refined = replace(SCENE, observables=("strain", "time_step_error", "energy"), look_points=None)
    plot(refined)
    plot(refined, kind="errors")
    assert [scene.observables for scene in scenes] == [
        ("strain", "space_time", "crest_track"),
        ("error_curve", "time_step_error"),
    ]
    assert scenes[0].look_points is not None


def test_a_periodic_wave_is_shown_on_all_compared_sites() -> None:
    bare = replace(SCENE, wave="wave_cn", parameters=(("k", 0.5),), observables=("strain",))
    assert plot(bare, kind="snapshots").get_axes()[0].get_xlim() == (-150, 150)


def test_the_map_shows_the_wave_and_not_all_of_its_background(finished_run: xr.Dataset) -> None:
    assert shown_half_width(finished_run) <= plot(finished_run).get_axes()[4].get_ylim()[1] < 60


def test_snapshots_show_the_wave_and_not_all_of_its_background(finished_run: xr.Dataset) -> None:
    half_width = shown_half_width(finished_run)
    left, right = plot(finished_run, kind="snapshots").get_axes()[0].get_xlim()
    assert half_width < 60
    assert (left, right) == (-half_width, half_width)
    outside = abs(finished_run["site"]) > half_width
    assert (
        np.abs(finished_run["strain"]).where(outside).max()
        < 0.02 * np.abs(finished_run["strain"]).max()
    )


@pytest.mark.parametrize(("count", "panels"), [(1, 1), (4, 4), (40, MAX_PANELS)])
def test_many_snapshots_are_thinned_and_the_last_is_kept(
    finished_run: xr.Dataset, count: int, panels: int
) -> None:
    many = finished_run.isel(time=[0] * count).assign_coords(time=range(count))
    axes = plot(many, kind="snapshots").get_axes()
    titles = [title for ax in axes if (title := ax.get_title(loc="left"))]
    assert len(axes) == 2 * len(titles) == 2 * panels
    assert titles[-1].endswith(f"$t={count - 1}$")


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("title", "drawn", "suffix"),
    [
        *(
            (title, drawn, suffix)
            for title, drawn in (
                (r"[/nope] 50 % of $x_ \frac{ ^ \ ", r"[/nope] 50 % of $x_ \frac{ ^ \ ".strip()),
                ("漢字 \x00\x1b[1m\n\n", r"漢字 \x00\x1b[1m"),
            )
            for suffix in (".pdf", ".svg")
        ),
        ("_a_ & # ~ {}", "_a_ & # ~ {}", ".svg"),
        ("w" * 4000, "...", ".png"),
        ("w " * 60, "w " * 44 + "w\n" + "w " * 14 + "w", ".png"),
    ],
)
def test_a_title_is_drawn_as_text(
    finished_run: xr.Dataset, tmp_path: Path, title: str, drawn: str, suffix: str
) -> None:
    figure = plot(finished_run.assign_attrs(title=title), tmp_path / f"run{suffix}", kind="errors")
    assert figure.get_suptitle() == drawn


def test_the_title_says_how_a_run_ended(finished_run: xr.Dataset) -> None:
    ended = finished_run.assign_attrs(blow_up="blow-up at t = 3, site 5")
    assert plot(ended, kind="errors").get_suptitle() == "One soliton\nblow-up at t = 3, site 5"


@pytest.mark.parametrize("name", ["run.jpg", "run", "run.png.gz", "run.nc"])
def test_another_suffix_is_refused_before_the_run(tmp_path: Path, name: str) -> None:
    with pytest.raises(
        ValueError, match=r"^output must be a path ending in \.png, \.pdf, \.svg, got '.*\)$"
    ):
        plot(SCENE, tmp_path / name)
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "No such file"),
        (b"", ""),
        (b"no netCDF", ""),
        (b"CDF\x01" + b"\xff" * 100, ""),
        (b"\x89HDF\r\n\x1a\n", ""),
    ],
    ids=["missing", "empty", "text", "broken", "netCDF 4"],
)
def test_a_file_that_is_no_run_is_one_line(
    tmp_path: Path, content: bytes | None, said: str
) -> None:
    path = tmp_path / "run.nc"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ValueError, match=rf"^(source|run) must be a [^\n]*{said}[^\n]*\)$"):
        plot(path)


@pytest.mark.parametrize("kept", [0.02, 0.5, 0.99])
def test_a_truncated_run_is_one_line(finished_run: xr.Dataset, tmp_path: Path, kept: float) -> None:
    save_run(finished_run, tmp_path / "whole.nc")
    content = (tmp_path / "whole.nc").read_bytes()
    (tmp_path / "cut.nc").write_bytes(content[: int(kept * len(content))])
    with pytest.raises(ValueError, match=r"^run must be a whole [^\n]*$"):
        plot(tmp_path / "cut.nc")


@pytest.mark.parametrize("source", [3, None, ["run.nc"]])
def test_a_wrong_type_is_one_line(source: object) -> None:
    with pytest.raises(ValueError, match=r"^source must be a run, a scene, or the path"):
        plot(source)  # type: ignore[arg-type]


def test_a_wrong_kind_and_a_run_without_the_variables_are_one_line(
    finished_run: xr.Dataset,
) -> None:
    with pytest.raises(ValueError, match=r"^kind must be a known one, got 'film' \(one of all, sn"):
        plot(finished_run, kind="film")
    with pytest.raises(ValueError, match=r"\(space_time\), got error_curve .* ask for space_time"):
        plot(finished_run[["error_curve"]], kind="space_time")
    with pytest.raises(ValueError, match=r"got nothing \(the scene must ask for strain, space_"):
        plot(finished_run[[]])


@pytest.mark.parametrize("scene", [None, "no JSON", "{}", "[1]", '{"parameters": [], "x": 1}'])
def test_a_run_without_its_scene_is_one_line(finished_run: xr.Dataset, scene: str | None) -> None:
    attributes = {} if scene is None else {"scene": scene}
    foreign = finished_run.copy()
    foreign.attrs = attributes
    with pytest.raises(ValueError, match=r"^source must be a run with the scene [^\n]*$"):
        plot(foreign)


def test_a_time_that_is_too_late_for_any_site_is_one_line(finished_run: xr.Dataset) -> None:
    late = finished_run.assign_coords(curve_time=1e300 * (1.0 + finished_run["curve_time"]))
    late.attrs["error_estimate"] = 1e-3
    with pytest.raises(ValueError, match=r"^t must leave c t within 2\^53 sites, got t = "):
        plot(late, kind="errors")
    bare = late[["error_curve"]].assign_coords(curve_time=finished_run["curve_time"])
    plot(bare, kind="errors")


def test_a_run_that_is_zero_on_one_site_is_drawn(finished_run: xr.Dataset) -> None:
    figure = plot(finished_run[["strain", "analytic", "n"]] * 0.0)
    for ax in figure.get_axes():
        assert np.isfinite([*ax.get_xlim(), *ax.get_ylim()]).all()

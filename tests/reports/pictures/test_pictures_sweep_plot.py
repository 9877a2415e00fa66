"""Pictures of sweeps: the cells' numbers are drawn, and other requests are refused."""

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import LogNorm

from longwave.__main__ import main
from longwave.cli.command_tree import SWEEP_PICTURES as WORDS
from longwave.reports.pictures.plotting import plot
from longwave.reports.pictures.sweep_drawing import SweptAxis, work_precision
from longwave.reports.pictures.sweep_kinds import SWEEP_PICTURES
from longwave.reports.pictures.sweep_plotting import axis_of
from longwave.runs import save_run
from tests.families import family

EPS = [0.2, 0.05, 0.1, 0.4]
K = [0.1, 0.5, 0.9]
WAVES = ["rogue_cn", "wave_dn"]


def swept(shape: dict[str, int], coords: dict[str, Any]) -> xr.Dataset:
    dims, sizes = tuple(shape), tuple(shape.values())
    error = 0.01 * np.arange(1.0, 1.0 + np.prod(sizes)).reshape(sizes)
    numbers = {
        "error": error,
        "own_error": 0.1 * error,
        "error_estimate": 1e-3 * error,
        "seconds": 1.0 / error,
        "force_evaluations": 2.0 / error,
        "sites": np.full(sizes, 100.0),
    }
    data: dict[str, Any] = {name: (dims, values) for name, values in numbers.items()}
    data["status"] = (dims, np.full(sizes, "done", dtype=object))
    return xr.Dataset(data, coords, {"sweep": "{}", "title": "50 % of $x_ [/b] \\frac{"})


def cube() -> xr.Dataset:
    coords = {"eps": EPS, "k": K, "wave": ("case", np.array(WAVES, dtype=object))}
    return swept({"case": 2, "eps": 4, "k": 3}, coords)


def meshes(figure: Any) -> list[Any]:
    return [
        ax.collections[0] for ax in figure.get_axes() if ax.collections and ax.get_title("left")
    ]


def bars(ax: Any) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return the points of an axis with one curve, and the ends of their bars."""
    (container,) = ax.containers
    line, _, (columns,) = container
    return line.get_xydata(), [segment[:, 1] for segment in columns.get_segments()]


def test_the_kinds_are_those_of_the_command_line() -> None:
    assert SWEEP_PICTURES == WORDS


def test_one_dimension_is_a_curve_in_order_with_its_own_errors() -> None:
    ax = plot(cube(), at={"wave": "wave_dn", "k": 0.5}).get_axes()[0]
    points, ends = bars(ax)
    values = cube()["error"].values[1, :, 1][[1, 2, 0, 3]]
    assert np.allclose(points, np.transpose([sorted(EPS), values]))
    assert np.allclose(ends, np.transpose([0.9 * values, 1.1 * values]))
    assert ax.get_xscale() == "log"
    assert ax.get_xlabel() == r"$\epsilon$"
    assert ax.get_title("left") == "bars: own error, at most 10% of the value"
    unsure = cube().assign(own_error=1.44 * cube()["error"])
    ax = plot(unsure, at={"wave": "wave_dn", "k": 0.5}).get_axes()[0]
    assert ax.get_title("left") == "bars: own error, at most 140% of the value"


def test_two_dimensions_are_a_heat_map_in_order() -> None:
    figure = plot(cube(), at={"wave": "rogue_cn"})
    ax = figure.get_axes()[0]
    values = np.asarray(ax.collections[0].get_array())
    assert np.allclose(values, cube()["error"].values[0][[1, 2, 0, 3]].T)
    left, right = ax.get_xlim()
    assert left < min(EPS) < max(EPS) < right
    assert figure.get_suptitle() == "50 % of $x_ [/b] \\frac{\nwave = rogue_cn"


def test_three_dimensions_are_maps_with_the_same_colours() -> None:
    figure = plot(cube())
    drawn = meshes(figure)
    titles = [ax.get_title("left") for ax in figure.get_axes() if ax.get_title("left")]
    assert titles == ["wave = rogue_cn", "wave = wave_dn"]
    assert [mesh.get_clim() for mesh in drawn] == [(0.01, 0.24)] * 2
    assert not isinstance(drawn[0].norm, LogNorm)
    assert isinstance(meshes(plot(cube().assign(error=cube()["error"] ** 3)))[0].norm, LogNorm)


def test_texts_make_a_curve_each() -> None:
    ax = plot(cube(), at={"k": "0.1"}).get_axes()[0]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == WAVES
    heights = [container[0].get_ydata() for container in ax.containers]
    assert np.allclose(heights, cube()["error"].values[:, [1, 2, 0, 3], 0])


def test_long_texts_that_begin_alike_are_distinct_and_leave_room() -> None:
    long = [f"{'a lattice of ' * 40}{end}" for end in ("one mass", "two masses")]
    data = cube().assign_coords(wave=("case", np.array(long, dtype=object)))
    curves = plot(data, at={"k": 0.1})
    for figure in (curves, plot(data), plot(data, at={"eps": 0.1, "k": 0.1})):
        figure.draw_without_rendering()
        assert all(ax.get_position().width > 0.2 for ax in figure.get_axes()[:2])
    (ax,) = curves.get_axes()
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert [text[-4:] for text in labels] == ["mass", "sses"]
    assert all(len(text) <= 24 for text in labels)


def hatched(ax: Any) -> set[tuple[float, float]]:
    """Return the cells that are hatched."""
    paths = [path for part in ax.collections if part.get_hatch() for path in part.get_paths()]
    return {place for place in product(EPS, K) if any(path.contains_point(place) for path in paths)}


def legend(figure: Any) -> list[str]:
    return [text.get_text() for text in figure.subfigs[0].legends[0].get_texts()]


def test_cells_are_hatched_where_their_own_error_is_large() -> None:
    data, words = cube(), {"wave": "rogue_cn"}
    data["own_error"] *= 0.9
    figure = plot(data, at=words)
    assert hatched(figure.get_axes()[0]) == set()
    assert legend(figure) == ["own error nowhere above 10% of the value"]
    data["own_error"].values[0, 1, 2] = 0.11 * data["error"].values[0, 1, 2]
    data["own_error"].values[0, 3, 0] = 5.0
    data["own_error"].values[0, 3, 1] = np.nan
    data["own_error"].values[0, 0, 0], data["status"].values[0, 0, 0] = 5.0, "failed"
    figure = plot(data, at=words)
    assert hatched(figure.get_axes()[0]) == {(EPS[1], K[2]), (EPS[3], K[0])}
    assert legend(figure) == ["own error above 10% of the value"]
    assert not plot(data, at=words, variable="seconds").subfigs[0].legends


def test_cells_without_a_result_have_no_value_and_a_cross() -> None:
    data = cube()
    data["status"].values[0, 0, 0] = "failed"
    data["status"].values[0, 3, 2] = "missing"
    ax = plot(data, at={"wave": "rogue_cn"}).get_axes()[0]
    values = np.ma.asarray(ax.collections[0].get_array())
    assert np.ma.getmaskarray(values).sum() == 2
    assert ax.lines[0].get_xydata().tolist() == [[0.2, 0.1]]


def test_samples_are_drawn_by_median_and_quartiles() -> None:
    data = swept({"eps": 4, "sample": 5}, {"eps": EPS, "K3": ("sample", np.arange(5.0))})
    points, ends = bars(plot(data).get_axes()[0])
    errors = data["error"].values[[1, 2, 0, 3]]
    assert np.allclose(points[:, 1], np.median(errors, axis=1))
    assert np.allclose(ends, np.quantile(errors, (0.25, 0.75), axis=1).T)
    (ax,) = plot(data, at={"eps": 0.05}).get_axes()
    assert ax.containers[0][0].get_linestyle() == "None"
    assert ax.get_xlabel() == "$K3$"


def test_realisations_are_drawn_by_mean_standard_error_and_deviation() -> None:
    seeds = ("seed", np.arange(5), {"field": "disorder.seed"})
    of = np.array(["mass", "K2"], dtype=object)
    coords = {"seed": seeds, "spread": [0.3, 0.1, 0.2], "of": of}
    data = swept({"seed": 5, "of": 2, "spread": 3}, coords)
    values = np.random.default_rng(2).uniform(0.5, 1.0, (5, 2, 3))
    data["error"] = (data.status.dims, values)
    data["status"].values[3, 1, 0] = "failed"
    figure = plot(data)
    (ax,) = figure.get_axes()
    caption = "bars: standard error, band: standard deviation"
    assert ax.get_title("left") == f"mean of 4 to 5, {caption}"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["mass", "K2"]
    for place, (container, band) in enumerate(
        zip(ax.containers, ax.collections[1::2], strict=True)
    ):
        repeats = [values[:, place, column] for column in (1, 2, 0)]
        repeats[2] = np.delete(repeats[2], 3) if place else repeats[2]
        line, _, (columns,) = container
        mean, deviation = (
            np.array([f(one) for one in repeats]) for f in (np.mean, sample_deviation)
        )
        np.testing.assert_allclose(line.get_xydata(), np.transpose([[0.1, 0.2, 0.3], mean]))
        error = deviation / np.sqrt([len(one) for one in repeats])
        ends = [segment[:, 1] for segment in columns.get_segments()]
        np.testing.assert_allclose(ends, np.transpose([mean - error, mean + error]))
        corners = band.get_paths()[0].vertices
        assert corners[:, 1].max() == pytest.approx((mean + deviation).max())
        assert corners[:, 1].min() == pytest.approx((mean - deviation).min())
    one = plot(data, at={"seed": 2, "of": "K2"})
    assert [line.get_ydata()[0] for line in one.get_axes()[0].lines[:1]] == [values[2, 1, 1]]
    data["last_peak"] = (data.status.dims, 2.0 * values)
    peak, error = plot(data).get_axes()
    assert peak.get_ylim()[1] == pytest.approx(2.0 * error.get_ylim()[1])
    assert len(plot(data, variable="last_peak").get_axes()) == 1


def test_repeats_are_counted_where_they_have_a_value() -> None:
    seeds = ("seed", np.arange(5), {"field": "disorder.seed"})
    data = swept({"seed": 5, "spread": 4}, {"seed": seeds, "spread": [0.0, 0.1, 0.2, 0.3]})
    data["status"].values[3:] = "refused"
    data["status"].values[:, 3] = "refused"
    caption = "bars: standard error, band: standard deviation; \xd7: no result"
    assert plot(data).get_axes()[0].get_title("left") == f"mean of 3, {caption}"
    data["status"].values[2, 0] = "failed"
    assert plot(data).get_axes()[0].get_title("left") == f"mean of 2 to 3, {caption}"
    sample = swept({"eps": 4, "sample": 5}, {"eps": EPS, "K3": ("sample", np.arange(5.0))})
    sample["status"].values[:, 0] = sample["status"].values[1] = "missing"
    (ax,) = plot(sample).get_axes()
    assert ax.get_title("left") == "median of 4, bars to the quartiles"
    assert np.isnan(ax.containers[0][0].get_ydata()).tolist() == [True, False, False, False]


def test_repeats_over_texts_are_points_with_bars() -> None:
    seeds = ("seed", np.arange(3), {"field": "disorder.seed"})
    kinds = np.array(["uniform", "binary"], dtype=object)
    data = swept({"seed": 3, "distribution": 2}, {"seed": seeds, "distribution": kinds})
    (ax,) = plot(data).get_axes()
    points, ends = bars(ax)
    assert np.allclose(points, [[0.0, 0.03], [1.0, 0.04]])
    assert np.allclose(ends[0], 0.03 + 0.02 / np.sqrt(3.0) * np.array([-1.0, 1.0]))
    assert ax.containers[0][0].get_linestyle() == "None"
    wide = ax.collections[1].get_segments()
    assert np.allclose([one[:, 1] for one in wide], [[0.01, 0.05], [0.02, 0.06]])
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["uniform", "binary"]
    sample = swept({"order": 2, "sample": 3}, {"order": kinds, "eps": ("sample", EPS[:3])})
    assert np.allclose(bars(plot(sample, kind="values").get_axes()[0])[0][:, 1], [0.02, 0.05])
    both = swept(
        {"seed": 3, "distribution": 2, "of": 2},
        {"seed": seeds, "distribution": kinds, "of": np.array(["mass", "K2"], object)},
    )
    places = [line[0].get_xdata() for line in plot(both).get_axes()[0].containers]
    assert np.allclose(places, [[-0.05, 0.95], [0.05, 1.05]])
    texts = data.assign_coords(seed=("seed", np.array(["1", "9" * 20, "-3"], dtype=object)))
    texts["seed"].attrs["field"] = "disorder.seed"
    assert np.allclose(bars(plot(texts).get_axes()[0])[0], points)


def test_repeats_over_two_dimensions_have_a_curve_for_each_value_of_the_smaller() -> None:
    seeds = ("seed", np.arange(5), {"field": "disorder.seed"})
    data = swept({"seed": 5, "eps": 4, "k": 3}, {"seed": seeds, "eps": EPS, "k": K})
    (ax,) = plot(data).get_axes()
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels == ["k = 0.1", "k = 0.5", "k = 0.9"]
    mean = data["error"].values.mean(axis=0)[[1, 2, 0, 3]]
    assert np.allclose([line[0].get_ydata() for line in ax.containers], mean.T)
    wide = swept({"seed": 2, "a": 9, "b": 9}, {"seed": ("seed", [1, 2], seeds[2])})
    with pytest.raises(ValueError, match=r"^repeats must be over one or two .* got 2 seed, 9 a, 9"):
        plot(wide)


def test_no_bars_stand_where_no_error_is_known() -> None:
    data = cube()
    words = {"wave": "rogue_cn", "k": 0.5}
    (container,) = plot(data, at=words, variable="seconds").get_axes()[0].containers
    assert not container.has_yerr
    assert not container[1]
    data["own_error"].values[0, 1, 1] = np.nan
    (container,) = plot(data, at=words).get_axes()[0].containers
    assert np.isnan(container[1][0].get_ydata()).tolist() == [True, False, False, False]


def test_cells_without_a_result_are_crosses_below_the_curves() -> None:
    data = swept({"case": 4, "eps": 4}, {"eps": EPS, "wave": ("case", np.array([*"abcd"], object))})
    data["status"].values[0, 0] = "refused"
    data["status"].values[1] = "failed"
    data["status"].values[2] = "missing"
    data["status"].values[3, 1], data["error"].values[3, 1] = "blown up", np.nan
    (ax,) = plot(data).get_axes()
    assert ax.get_title("left").endswith("; \xd7: no result")
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["a", "b", "d"]
    crosses = [line for line in ax.lines if line.get_marker() == "x"]
    places = [line.get_xdata().tolist() for line in crosses]
    assert places == [[0.2], sorted(EPS), [0.05]]
    bottom, top = ax.get_ylim()
    highest = bottom + max(line.get_ydata()[0] for line in crosses) * (top - bottom)
    assert highest < 0.9 * np.nanmin([line[0].get_ydata() for line in ax.containers])
    figure = plot(data.assign(error=data["error"] ** 4))
    assert figure.get_axes()[0].get_yscale() == "log"
    assert 0.0 < figure.get_axes()[0].get_ylim()[0] < 0.01**4
    (one,) = plot(data, at={"wave": "d"}).get_axes()
    assert one.get_legend() is None


def test_values_that_hardly_differ_are_printed_in_full() -> None:
    data = swept({"eps": 3}, {"eps": EPS[:3]}).assign(peak=("eps", 1.0 + 1e-5 * np.arange(3)))
    figure = plot(data, variable="peak")
    figure.draw_without_rendering()
    (ax,) = figure.get_axes()
    assert ax.yaxis.get_offset_text().get_text() == ""
    ticks = [float(tick.get_text()) for tick in ax.get_yticklabels()]
    assert min(abs(tick - 1.00001) for tick in ticks) < 1e-9


def test_names_that_are_unclear_alone_are_replaced() -> None:
    names = ("name", np.array(["rk4", "leapfrog"], dtype=object), {"field": "scheme.name"})
    data = swept({"name": 2, "eps": 4, "k": 3}, {"name": names, "eps": EPS, "k": K})
    titles = [ax.get_title("left") for ax in plot(data).get_axes()[:2]]
    assert titles == ["scheme = rk4", "scheme = leapfrog"]
    of = ("case", np.array(["mass", "K2"], dtype=object), {"field": "disorder.of"})
    assert axis_of(swept({"case": 2}, {"of": of}), "case").name == "disorder of"


def test_ticks_of_a_logarithmic_axis_are_plain() -> None:
    for values, texts in (
        ([256.0, 512.0, 1024.0], ["256", "512", "1024"]),
        ([0.05, 1.0, 1048576.0], ["0.05", "1", "1048576"]),
        ([1e-6, 1e-5, 1e-4], ["1e-06", "1e-05", "0.0001"]),
        ([1e8, 1e9, 1.5e10], ["1e+08", "1e+09", "1.5e+10"]),
        ([0.1 * 3**0.5, 0.3, 0.9], ["0.173", "0.3", "0.9"]),
    ):
        (ax,) = plot(swept({"x": 3}, {"x": values})).get_axes()
        assert [tick.get_text() for tick in ax.get_xticklabels()] == texts


def sample_deviation(values: np.ndarray) -> float:
    return float(np.std(values, ddof=1))


def named(ax: Any) -> list[Any]:
    """Return the lines of an axis that have a label in its legend."""
    return [line for line in ax.lines if not line.get_label().startswith("_")]


def test_work_precision_is_drawn_along_the_tolerance() -> None:
    data = swept({"order": 2, "tolerance": 3}, {"order": WAVES, "tolerance": [1e-2, 1e-3, 1e-4]})
    seconds, updates = plot(data, kind="work_precision").get_axes()
    assert [line.get_label() for line in named(seconds)] == [
        "order = rogue_cn: estimated", "order = rogue_cn: relative to the wave",
        "order = wave_dn: estimated", "order = wave_dn: relative to the wave",
    ]  # fmt: skip
    assert np.allclose(named(seconds)[2].get_ydata(), data["error_estimate"].values[1])
    assert np.allclose(named(seconds)[3].get_ydata(), data["error"].values[1])
    assert np.allclose(named(seconds)[2].get_xdata(), data["seconds"].values[1])
    assert np.allclose(named(updates)[2].get_xdata(), 200.0 / data["error"].values[1])
    ends = [segment[:, 1] for segment in updates.collections[1].get_segments()]
    assert np.allclose(ends, np.outer(data["error"].values[1], [0.9, 1.1]))
    assert len(plot(data).get_axes()) == 3


def test_work_precision_of_stated_steps_is_what_was_achieved() -> None:
    step = ("step", [0.1, 0.2, 0.4], {"field": "scheme.step"})
    names = ("name", np.array(["rk4", "leapfrog", "none"], object), {"field": "scheme.name"})
    data = swept({"name": 3, "step": 3}, {"step": step, "name": names})
    data["error_estimate"] = xr.full_like(data["error_estimate"], np.nan)
    data["status"].values[2] = "refused"
    seconds = plot(data, kind="work_precision").get_axes()[0]
    labels = [line.get_label() for line in named(seconds)]
    assert labels == [f"scheme = {name}: relative to the wave" for name in ("rk4", "leapfrog")]
    assert np.allclose(named(seconds)[1].get_ydata(), data["error"].values[1])
    ends = [segment[:, 1] for segment in seconds.collections[1].get_segments()]
    assert np.allclose(ends, np.outer(data["error"].values[1], [0.9, 1.1]))
    alone = plot(data, at={"step": 0.2}, kind="work_precision").get_axes()[0]
    assert [line.get_label() for line in named(alone)] == labels
    assert [line.get_ydata().tolist() for line in named(alone)] == [
        [data["error"].values[place, 1]] for place in (0, 1)
    ]
    with pytest.raises(ValueError, match=r"^error must be a number in some cell"):
        plot(data.assign(error=data["error_estimate"]), kind="work_precision")


def test_long_names_of_work_precision_have_a_column() -> None:
    order = np.array([f"{'a long name of an order' * 3}{end}" for end in "12"], dtype=object)
    data = swept({"order": 2, "tolerance": 3}, {"order": order, "tolerance": [1e-2, 1e-3, 1e-4]})
    figure = plot(data, kind="work_precision")
    figure.draw_without_rendering()
    (legend_above,) = figure.subfigs[0].legends
    assert legend_above.get_window_extent().x0 >= 0.0
    assert legend_above.get_window_extent().x1 <= figure.bbox.x1
    assert all(ax.get_position().height > 0.3 for ax in figure.get_axes())


def test_cells_that_took_the_same_work_stand_in_the_panel() -> None:
    numbers = {"seconds": 2e6, "updates": 2e6, "estimated": 1e-3, "achieved": 1e-3, "own": 1e-3}
    curve = xr.Dataset({name: ("step", np.full(3, value)) for name, value in numbers.items()})
    for ax in work_precision({"": curve}).figure().get_axes():
        low, high = ax.get_xlim()
        assert (low, high) == pytest.approx((1e6, 4e6))
        assert len({label.get_text() for label in ax.get_xticklabels()}) == 2


@pytest.mark.parametrize("suffix", family([".png", ".pdf", ".svg"], quick=(".svg",)))
def test_a_file_of_a_sweep_is_drawn(tmp_path: Path, suffix: str, capsys: Any) -> None:
    save_run(cube(), tmp_path / "sweep.nc")
    path = tmp_path / f"sweep{suffix}"
    words = ["--at", "wave=wave_dn", "--at", "k=0.5", "--variable", "seconds"]
    words += ["--output", str(path)]
    assert main(["plot", str(tmp_path / "sweep.nc"), *words]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    first = path.read_bytes()
    assert b'clip-path="url(#p' not in first
    assert (b'clip-path="url(#clip0)"' in first) == (suffix == ".svg")
    assert main(["plot", str(tmp_path / "sweep.nc"), *words, "--force"]) == 0
    assert path.read_bytes() == first


@pytest.mark.parametrize("value", family([0.0, -3.0, 1e300, 5e-324], quick=("5e-324",)))
def test_equal_values_are_drawn(tmp_path: Path, value: float) -> None:
    data = cube().assign(error=xr.full_like(cube()["error"], value))
    for at in ({}, {"wave": "wave_dn"}, {"wave": "wave_dn", "k": 0.1}):
        figure = plot(data, tmp_path / "x.png", at=at)
        assert (tmp_path / "x.png").stat().st_size > 0
        for axes in figure.axes:
            assert np.isfinite([*axes.get_xlim(), *axes.get_ylim()]).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            {"at": {"colour": 1}},
            r"at must name a swept field, got 'colour' \(one of eps, k, wave\)",
        ),
        ({"at": {"k": 0.3}}, r"k must be one of its values, got 0\.3 \(one of 0\.1, 0\.5, 0\.9\)"),
        ({"variable": "charm"}, r"variable must be a number of each cell, got 'charm' \(one of er"),
        (
            {"kind": "snapshots"},
            "kind must be all, values, work_precision, growth_map for a sweep, got 'snap",
        ),
        ({"kind": "work_precision"}, "work_precision must have a sweep over one of tolerance, or"),
        (
            {"at": {"k": 0.1, "eps": 0.1, "wave": "wave_dn"}},
            r"a picture must be of two cells or more, got one cell \(its error is 0.19; ",
        ),
    ],
)
def test_a_sweep_that_cannot_be_drawn_is_one_line(words: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=rf"^{said}[^\n]*$") as raised:
        plot(cube(), **words)
    assert len(str(raised.value)) < 300


def test_no_numbers_and_too_many_maps_are_one_line() -> None:
    empty = cube().assign(error=xr.full_like(cube()["error"], np.nan))
    with pytest.raises(ValueError, match=r"^error must be a number in some cell, got none in 24"):
        plot(empty)
    wide = swept({"a": 13, "b": 14, "eps": 15}, {})
    with pytest.raises(
        ValueError, match=r"^a must have at most 12 .* \(choose with --at a=VALUE\)"
    ):
        plot(wide)
    four = swept({"a": 2, "b": 2, "d": 2, "eps": 2}, {})
    with pytest.raises(ValueError, match=r"got 2 a, 2 b, 2 d, 2 eps \(choose with --at NAME=VALUE"):
        plot(four)


def test_a_value_may_be_given_as_it_is_printed() -> None:
    eps = [0.1, 0.1 * 3.0**0.5, 0.3]
    data = swept({"eps": 3, "k": 3}, {"eps": eps, "k": K})
    for value in ("0.173205", 0.173205, repr(eps[1])):
        ax = plot(data, at={"eps": value}).get_axes()[0]
        assert np.allclose(ax.containers[0][0].get_ydata(), data["error"].values[1])
    for value in (0.17320512, "0.1732"):
        with pytest.raises(ValueError, match=r"^eps must be one of its values, .* 0\.3\)"):
            plot(data, at={"eps": value})
    near = data.assign_coords(eps=[0.1732051, 0.1732052, 0.3])
    with pytest.raises(ValueError, match=r"^eps must match .* \(one of 0\.1732051, 0\.1732052\)"):
        plot(near, at={"eps": "0.173205"})
    assert plot(near, at={"eps": "0.1732052"}).get_axes()


def test_a_list_of_values_says_that_it_is_cut() -> None:
    for size, end in ((20, "19)"), (21, "19, ...)")):
        data = swept({"k": size}, {"k": np.arange(float(size))})
        with pytest.raises(ValueError, match=r"^k must be one of its values") as raised:
            plot(data, at={"k": -1})
        assert str(raised.value).endswith(end)


def test_words_of_sweeps_are_refused_for_scenes_before_a_run() -> None:
    for words in ({"at": {"k": 1}}, {"variable": "steps"}, {"kind": "values"}):
        with pytest.raises(ValueError, match=r"must not be given for a run or a scene"):
            plot("rogue_cn_k_0.5", **words)  # type: ignore[arg-type]


def test_an_axis_is_logarithmic_where_its_values_are() -> None:
    assert SweptAxis("eps", [0.1, 0.2, 0.4, 0.8]).is_logarithmic
    assert not SweptAxis("k", [0.1, 0.3, 0.5, 0.7, 0.9]).is_logarithmic
    assert not SweptAxis("k", [-1.0, 1.0, 10.0]).is_logarithmic
    assert axis_of(cube(), "case").values == WAVES
    assert axis_of(swept({"case": 2}, {}), "case").values == [0.0, 1.0]

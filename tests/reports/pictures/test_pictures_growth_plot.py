"""Pictures of growth rates: which map belongs to which points, and titles of rows."""

import json
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from longwave.reports.pictures.growth_plotting import growth_panels
from longwave.reports.pictures.plotting import plot
from longwave.runs.sweep_scene import changed_document, make_scene
from longwave.scenes.engines.sideband_growth import growth_plan
from tests.runs.test_runs_sweep_growth import GROWTH

SCENE: dict[str, Any] = GROWTH | {
    "eps": 0.1,
    "constants": {"K2": 1, "K3": 0.6, "K4": 1},
    "envelope": {"k": 2},
}
EXTRA = {"K2": 1, "K3": 0, "K4": 3}

Fields = Mapping[str, Sequence[Any]]


def _swept(grid: Fields, listed: Fields | None = None) -> xr.Dataset:
    """Return a sweep's data set whose cells have rates and wavenumbers of the scene's theory."""
    axes: list[tuple[str, Fields]] = [(n.rpartition(".")[2], {n: v}) for n, v in grid.items()]
    axes += [("case", listed)] if listed else []
    sizes = [len(next(iter(fields.values()))) for _, fields in axes]
    coords: dict[str, Any] = {}
    for dimension, fields in axes:
        for field, values in fields.items():
            texts = [json.dumps(v) if isinstance(v, dict) else v for v in values]
            coords[field.rpartition(".")[2]] = (dimension, texts, {"field": field})
    names = ("carrier_k", "growth_rate", "growth_rate_theory", "perturbation_kappa")
    found = {name: np.full(sizes, np.nan) for name in (*names, "growth_rate_error", "error")}
    for places in product(*map(range, sizes)):
        changes = {
            field: values[place]
            for (_, fields), place in zip(axes, places, strict=True)
            for field, values in fields.items()
        }
        scene = make_scene(changed_document(SCENE, changes), "scene", Path())
        plan = growth_plan(scene)
        numbers = (float(plan.ring.k), plan.wave.growth, plan.wave.growth, plan.wave.kappa)
        for name, value in zip(names, numbers, strict=True):
            found[name][places] = value
        found["growth_rate_error"][places] = found["error"][places] = 1e-3
    dims = [name for name, _ in axes]
    data = {name: (dims, values) for name, values in found.items()}
    data["status"] = (dims, np.full(sizes, "done"))
    return xr.Dataset(data, coords, {"sweep": json.dumps({"scene": SCENE})})


def _check(data: xr.Dataset, titles: Sequence[str], labels: Sequence[str]) -> None:
    """Check that each point is on its line and map, and inside the grey only if it is stable."""
    panels = growth_panels(data, 8)
    assert [panel.title for panel in panels] == titles
    count = 0
    for panel in panels:
        assert [curve.attrs["label"] for curve in panel.curves] == labels
        found = panel.theory
        assert found is not None
        for curve in panel.curves:
            k, kappa, theory = (
                curve[name].values
                for name in ("carrier_k", "perturbation_kappa", "growth_rate_theory")
            )
            count += k.size
            line = np.interp(k, found.k, found.lines.sel(line=curve.attrs["line"]))
            np.testing.assert_allclose(line, theory, rtol=0.05, atol=1e-3)
            places, heights = np.searchsorted(found.k, k), np.searchsorted(found.kappa, kappa)
            inside = heights < found.kappa.size
            on_map = found.rates.values[heights[inside], places[inside]]
            np.testing.assert_allclose(on_map, theory[inside], rtol=0.1, atol=1e-2)
            assert np.array_equal(found["product"].values[places] > 0, theory > 0)
    assert count == data["status"].size


def test_each_set_of_constants_has_its_map() -> None:
    """Not that of K4 = 0.5 behind the points of K4 = 1.5, which grow where the others do not."""
    grid = {"eps": [0.05, 0.1], "constants.K4": [0.5, 1.5], "envelope.k": [1.9, 2.5]}
    _check(_swept(grid), ["K4 = 0.5", "K4 = 1.5"], ["eps = 0.05", "eps = 0.1"])


def test_each_amplitude_has_its_map() -> None:
    grid = {"envelope.k": [1.9, 2.4], "parameters.amplitude": [0.15, 0.3]}
    _check(_swept(grid), ["amplitude = 0.15", "amplitude = 0.3"], [""])


def test_a_list_of_k_and_constants_has_a_map_for_each_constants() -> None:
    listed = {
        "envelope.k": [1.9, 2.2, 2.4],
        "constants": [SCENE["constants"], EXTRA, SCENE["constants"]],
    }
    _check(_swept({}, listed), ["K3 = 0.6, K4 = 1", "K3 = 0, K4 = 3"], [""])


def test_rows_with_the_same_map_have_titles() -> None:
    grid = {"envelope.k": [1.9], "tolerance": [1e-2, 1e-3], "order": ["leading", "slaved"]}
    labels = ["tolerance = 0.01", "tolerance = 0.001"]
    _check(_swept(grid), ["order = leading", "order = slaved"], labels)


def test_lines_of_theory_have_the_colours_of_their_points() -> None:
    data = _swept({"envelope.k": [1.9, 2.4], "parameters.share": [0.5, 1.2]})
    _check(data, [""], ["share = 0.5", "share = 1.2"])
    figure = plot(data, kind="growth_map")
    left = figure.get_axes()[0]
    lines = [line for line in left.lines if len(line.get_xdata()) > 100]
    points = [container[0] for container in left.containers if len(container[0].get_xdata())]
    assert len(lines) == len(points) == 2
    for line, point in zip(lines, points, strict=True):
        assert line.get_color() == point.get_color()
        drawn = np.interp(point.get_xdata(), line.get_xdata(), line.get_ydata())
        np.testing.assert_allclose(drawn, point.get_ydata(), rtol=0.02)
    (legend,) = figure.subfigs[0].legends
    handles = {line.get_label(): line for line in legend.legend_handles}
    styles = [handles[f"share = {share}"].get_linestyle() for share in (0.5, 1.2)]
    assert styles == [line.get_linestyle() for line in lines]
    assert lines[0].get_linestyle() != lines[1].get_linestyle()


def test_more_maps_than_a_picture_holds_are_refused_and_left_to_the_values() -> None:
    data = _swept({"envelope.k": [1.9, 2.4], "constants.K4": [1 + i / 8 for i in range(7)]})
    with pytest.raises(
        ValueError, match=r"K4 must have at most 6 values beside k, got 7 \(choose with --at K4=V"
    ):
        plot(data, kind="growth_map")
    assert len(plot(data).get_axes()) == 2
    assert plot(data, kind="growth_map", at={"K4": 1.5}).get_axes()[1].get_ylabel()


def test_a_list_that_no_choice_makes_smaller_is_left_to_the_values() -> None:
    every = [{"K2": 1, "K3": 0, "K4": 1 + i / 8} for i in range(7)]
    data = _swept({}, {"envelope.k": [1.5 + i / 8 for i in range(7)], "constants": every})
    with pytest.raises(ValueError, match=r"constants must have .* got 7 \(take --kind values\)"):
        growth_panels(data, 8)


def test_constants_that_are_small_with_eps_have_a_map_for_each_eps() -> None:
    listed = {"eps": [0.1, 0.2], "envelope.k": [1.9, 1.9]}
    data = _swept({}, listed)
    assert [panel.title for panel in growth_panels(data, 8)] == [""]
    small = SCENE | {"constants": {"K2": 1, "K3": "6*eps", "K4": 1}}
    data.attrs["sweep"] = json.dumps({"scene": small})
    assert [panel.title for panel in growth_panels(data, 8)] == ["eps = 0.1", "eps = 0.2"]

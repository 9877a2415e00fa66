"""Pictures of scenes on any lattice: snapshots of a run, and the errors of one at several eps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure, FigureBase

from derive.command_line import fail, interrupted
from reports.figures.drawing import (
    ANALYTICAL,
    CURVES,
    NUMERICAL,
    TEXT_WIDTH,
    save,
    snapshot_height,
    styled,
)
from verify.cli.console import check_output, picture_path
from verify.cli.converge import measured_convergence, print_convergence

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from verify.lattices.scene_convergence import SceneConvergence

ACROSS, MOST_PANELS = 3, 9
"""Snapshots side by side, and most of them; of more some are taken, evenly."""

SQUARE = 2.3
"""Height in inches of a row of maps."""


def draw_lattice_run(data: xr.Dataset, title: str) -> Figure:
    """The snapshots of a run: lattice and wave on a chain, the lattice's strain on two axes."""
    count = data.sizes["time"]
    shown = np.unique(np.linspace(0, count - 1, min(count, MOST_PANELS)).round().astype(int))
    rows = -(-len(shown) // ACROSS)
    draw = _draw_map if "row" in data.dims else _draw_chain
    height = SQUARE * rows if "row" in data.dims else snapshot_height(rows)
    figure = Figure((TEXT_WIDTH, height + 0.25), layout="constrained")
    panels = figure.subplots(rows, min(ACROSS, len(shown)), squeeze=False, sharey=True)
    for ax, place in zip(panels.flat, shown, strict=False):
        at = data.isel(time=int(place))
        draw(figure, ax, at)
        ax.set_title(f"$T={float(at['slow_time']):.4g}$", loc="left")
    for ax in panels.flat[len(shown) :]:
        ax.set_visible(False)
    figure.suptitle(title, parse_math=False, fontsize="medium")
    return figure


def _draw_chain(figure: FigureBase, ax: Axes, at: xr.Dataset) -> None:
    ax.plot(at["site"], at["strain"], label="lattice", **NUMERICAL)
    ax.plot(at["site"], at["analytic"], label="wave", **ANALYTICAL)
    ax.set_xlabel("cells from $c\\,t$")
    if not figure.legends:
        figure.legend(*ax.get_legend_handles_labels(), loc="outside upper right", ncols=2)


def _draw_map(figure: FigureBase, ax: Axes, at: xr.Dataset) -> None:
    values = np.asarray(at["strain"])
    largest = float(np.max(np.abs(values))) or 1.0
    mesh = ax.pcolormesh(
        at["site"], at["row"], values.T, cmap="RdBu_r", vmin=-largest, vmax=largest, rasterized=True
    )
    ax.set_xlabel("cells from $c\\,t$")
    figure.colorbar(mesh, ax=ax)


def convergence_figure(study: SceneConvergence) -> Figure:
    """The errors over eps, both in logarithms, with the runs' own errors and the fitted power."""
    eps = np.array([point.eps for point in study.points])
    errors = np.array([point.error for point in study.points])
    own = np.array([point.discretisation for point in study.points])
    figure = Figure((0.7 * TEXT_WIDTH, 3.0), layout="constrained")
    ax = figure.subplots()
    power = np.exp(np.mean(np.log(errors) - study.rate * np.log(eps))) * eps**study.rate
    ax.loglog(eps, errors, label="sup error", **(CURVES[0] | {"linestyle": ""}))
    label = rf"$\epsilon^{{{study.rate:.2f} \pm {study.uncertainty:.2f}}}$"
    ax.loglog(eps, power, color="black", linewidth=0.8, label=label)
    ax.loglog(eps, own, label="discretisation", **(CURVES[1] | {"linestyle": ""}))
    ax.set_xlabel(r"$\epsilon$")
    ax.set_xticks(eps, [f"{value:g}" for value in eps], minor=False)
    ax.set_xticks([], minor=True)
    ax.legend()
    figure.suptitle(study.scene.title or study.scene.name, parse_math=False, fontsize="medium")
    return figure


def converge_and_draw(
    source: str,
    eps: str | None,
    tolerance: float | None,
    output: str | None,
    json_wanted: bool,
    program: str,
) -> int:
    """Run, print, and draw if asked; return the exit status: 0, 2 for wrong input, 130."""
    try:
        check_output(output, "rate.png")
        path = None if output is None else picture_path(output)
        study = measured_convergence(source, eps, tolerance)
        print_convergence(study, json_wanted)
        if path is not None:
            with styled():
                save(convergence_figure(study), path)
    except KeyboardInterrupt:
        return interrupted(program, "nothing was kept")
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail(f"cells must fit the memory, got a scene that does not: {error} (take fewer)")
    return 0

"""``longwave converge SCENE``: errors of a scene at several eps, their rate, and a picture."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import NullFormatter
from rich.table import Table

from longwave.reports.pictures.shown import ShownFigure
from longwave.reports.pictures.style import BEADS, OWN, WAVE, WIDTHS, save, styled
from longwave.runs.sweep_scene import changed_scene
from longwave.scenes.description.scene_checks import finite
from longwave.support import console
from longwave.support.command_line import fail_for_memory, listed
from longwave.support.interruption import interrupted

if TYPE_CHECKING:
    from longwave.scenes.convergence import SceneConvergence


def measured_convergence(
    source: str, eps: str | None, tolerance: float | None, changes: Mapping[str, Any]
) -> SceneConvergence:
    """Run the named scene at several eps and return the convergence study."""
    from longwave.scenes.convergence import scene_convergence

    values: tuple[float, ...] = ()
    if eps is not None:
        example = "such as 0.1,0.07,0.05"
        values = listed("--eps", eps, lambda part: finite("--eps", float(part)), "numbers", example)
        if "eps" in changes:
            got = f"--eps {eps} and --set eps={changes['eps']} (leave one out)"
            raise ValueError(f"eps must be given once, got {got}")
    scene = changed_scene(source, changes, tolerance)
    with console.progress_bar(scene.name, f"{scene.name} at several eps") as bar:
        return scene_convergence(scene, values, *bar)


def print_convergence(study: SceneConvergence, json_wanted: bool) -> None:
    """Print the table of errors and the rate, or one JSON document."""
    if json_wanted:
        console.print_json(study.data())
        return
    table = Table("eps", "sup error", "of the wave's size", "discretisation", "cells")
    for point in study.points:
        errors = f"{point.error:.3g}", f"{point.relative:.3g}", f"{point.discretisation:.1g}"
        table.add_row(f"{point.eps:g}", *errors, str(point.sites))
    scene, output = study.scene, console.plain_console()
    theory = "none known" if study.theory is None else str(study.theory)
    console.print_lines(output, [scene.title or scene.name])
    output.print(table)
    lines = [
        f"{scene.lattice}, {study.equation}, {scene.order} order: the sup error falls as eps^rate, "
        f"the wave's size as eps^{study.power}",
        f"rate {study.rate}, theory {theory}",
    ]
    console.print_lines(output, lines)


def convergence_figure(study: SceneConvergence) -> ShownFigure:
    """Draw errors against eps on logarithmic axes, with the runs' numerical errors and the fit."""
    points = [(point.eps, point.error, point.discretisation) for point in study.points]
    eps, errors, run_errors = np.transpose(points)
    figure = ShownFigure((WIDTHS[1], 2.8), layout="constrained")
    ax = figure.subplots()
    rate = study.rate.value
    power = np.exp(np.mean(np.log(errors) - rate * np.log(eps))) * eps**rate
    theory = "" if study.theory is None else f", theory {study.theory}"
    ax.loglog(eps, power, color=WAVE, linewidth=0.9, label=f"rate {study.rate}{theory}")
    ax.loglog(eps, errors, label="lattice against wave", **BEADS | {"zorder": 3.0})
    ax.loglog(eps, run_errors, label="own error of the runs", color=OWN, marker="s", linestyle="--")
    ax.set(xlabel=r"$\epsilon$", ylabel="sup error")
    ax.set_xticks(eps, [f"{value:g}" for value in eps], minor=False)
    ax.set_xticks([], minor=True)
    ax.yaxis.set_minor_formatter(NullFormatter())
    figure.legend(loc="outside lower center")
    title = textwrap.fill(study.scene.title or study.scene.name, TITLE_WIDTH)
    figure.suptitle(title, parse_math=False, fontsize="medium")
    return figure


TITLE_WIDTH = 44
"""Most characters in one line of the title of the convergence picture."""


def converge_and_draw(
    scene: str,
    program: str,
    *,
    eps: str | None,
    tolerance: float | None,
    changes: Mapping[str, Any],
    output: str | None,
    force: bool,
    json_wanted: bool,
) -> int:
    """Run the study, print it and draw it if asked; return 0, or 130 after Ctrl-C."""
    try:
        console.check_output(output, "rate.png", force=force)
        path = None if output is None else console.picture_path(output)
        study = measured_convergence(scene, eps, tolerance, changes)
        if path is not None:
            with styled():
                save(convergence_figure(study), path)
        print_convergence(study, json_wanted)
    except KeyboardInterrupt:
        return interrupted(program, "nothing was saved")
    except MemoryError as error:
        return fail_for_memory(error, "cells")
    return 0

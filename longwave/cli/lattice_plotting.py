"""The picture of `longwave converge`: the errors of a scene on any lattice at several eps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from longwave.cli.converge import measured_convergence, print_convergence
from longwave.reports.pictures.drawing import (
    CURVES,
    TEXT_WIDTH,
    save,
    styled,
)
from longwave.support.command_line import fail, fail_for_memory, interrupted
from longwave.support.console import check_output, picture_path

if TYPE_CHECKING:
    from longwave.scenes.scene_convergence import SceneConvergence


def convergence_figure(study: SceneConvergence) -> Figure:
    """The errors over eps, both in logarithms, with the runs' own errors and the fitted power."""
    eps = np.array([point.eps for point in study.points])
    errors = np.array([point.error for point in study.points])
    own = np.array([point.discretisation for point in study.points])
    figure = Figure((0.7 * TEXT_WIDTH, 3.0), layout="constrained")
    ax = figure.subplots()
    rate = study.rate.value
    power = np.exp(np.mean(np.log(errors) - rate * np.log(eps))) * eps**rate
    ax.loglog(eps, errors, label="sup error", **(CURVES[0] | {"linestyle": ""}))
    theory = "" if study.theory is None else f", theory {study.theory}"
    ax.loglog(eps, power, color="black", linewidth=0.8, label=f"rate {study.rate}{theory}")
    ax.loglog(eps, own, label="discretisation", **(CURVES[1] | {"linestyle": ""}))
    ax.set_xlabel(r"$\epsilon$")
    ax.set_xticks(eps, [f"{value:g}" for value in eps], minor=False)
    ax.set_xticks([], minor=True)
    ax.legend()
    figure.suptitle(study.scene.title or study.scene.name, parse_math=False, fontsize="medium")
    return figure


def converge_and_draw(
    scene: str,
    program: str,
    *,
    eps: str | None,
    tolerance: float | None,
    output: str | None,
    force: bool,
    json_wanted: bool,
) -> int:
    """Run, print, and draw if asked; return the exit status: 0, 2 for wrong input, 130."""
    try:
        check_output(output, "rate.png", force=force)
        path = None if output is None else picture_path(output)
        study = measured_convergence(scene, eps, tolerance)
        if path is not None:
            with styled():
                save(convergence_figure(study), path)
        print_convergence(study, json_wanted)
    except KeyboardInterrupt:
        return interrupted(program, "nothing was kept")
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail_for_memory(error, "cells")
    return 0

"""What the report shows of runs on other lattices: scenes with their errors, rates over eps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from sympy import Symbol

from longwave.derive.output.notation import latex_of
from longwave.derive.symbols import constant_value, ybar
from longwave.reports.latex import (
    duration,
    escape,
    measured,
    picture_latex,
    table,
    title_latex,
    titled_rows,
)
from longwave.reports.pictures.drawing import snapshot_panels
from longwave.reports.pictures.lattice_figures import even_times, rate_figure, strain_maps
from longwave.reports.pictures.run_data import snapshots
from longwave.reports.studies.lattice_runs import SceneRun
from longwave.scenes.scene import Scene
from longwave.scenes.scene_rules import COMPUTED

if TYPE_CHECKING:
    from longwave.scenes.convergence import ConvergencePoint, SceneConvergence


def scene_table(runs: Mapping[str, SceneRun]) -> str:
    """Each scene: wave and equation, size, the largest error after the start, what it took."""
    lines = [
        line
        for name, found in runs.items()
        for line in titled_rows(
            found.scene.title or name,
            name,
            f"did not run: {found.fault}" if found.run is None else _scene_cells(found, found.run),
        )
    ]
    head = ["equation", r"$\epsilon$", r"error$\,/\,\epsilon^p$", "relative error", "cells", "time"]
    return table("L{36mm}llllr", head, lines)


def _scene_cells(found: SceneRun, run: xr.Dataset) -> list[str]:
    """The cells of a scene that ran; the errors are the largest after the first time."""
    sup, relative = (run[name].values[1:] for name in ("sup_error", "error"))
    own = float(run.attrs["error_estimate"])
    place = int(sup.argmax())
    share = relative[place] / sup[place] if sup[place] else 0.0
    lost = "" if found.kept else " (TOO LARGE)"
    return [
        escape(str(run.attrs["equation"]).partition(":")[0]),
        f"${found.scene.eps:g}$",
        measured(float(sup[place]), own) + lost,
        measured(float(relative[place]), own * float(share)),
        f"${run.attrs['sites']:,}$".replace(",", r"\,"),
        duration(float(run.attrs["seconds"] + run.attrs["planning_seconds"])),
    ]


def is_map(found: SceneRun) -> bool:
    """Whether a scene ran on two axes."""
    return found.run is not None and "row" in found.run.dims


def scene_maps(runs: Mapping[str, SceneRun]) -> str:
    """The figures of the scenes that ran on two axes."""
    what = "strain along $n$, and its distance from theory."
    return "\n".join(
        picture_latex(f"scene_{name}", f"{escape(found.scene.title)}: {what}")
        for name, found in runs.items()
        if is_map(found)
    )


def rate_table(rates: Iterable[SceneConvergence]) -> str:
    """Each lattice with its numbers; below it each rate, and the error at every eps."""
    lines, last = [], ""
    for found in rates:
        words = rate_title(found.scene)
        if words != last:
            lines.append([rf"\multicolumn{{5}}{{L{{160mm}}}}{{\rule{{0pt}}{{3.5ex}}{words}}}"])
            last = words
        rate, scene = str(found.rate).replace("..", "to"), found.scene
        wave = "computed soliton" if scene.wave == COMPUTED else scene.form.title
        errors = ", ".join(
            f"{measured(point.error, point.discretisation)} at ${point.eps:g}$"
            for point in found.points
        )
        lines += [
            [
                rf"\nopagebreak {escape(found.equation)}",
                escape(wave),
                scene.order,
                f"${found.theory}$",
                rate + ("" if found.reached else " (NOT REACHED)"),
            ],
            [rf"\nopagebreak\multicolumn{{5}}{{L{{160mm}}}}{{errors {errors}}}"],
        ]
    head = ["equation", "wave", "data", "expected", "rate"]
    return table("L{36mm}L{44mm}lll", head, lines)


def rate_title(scene: Scene) -> str:
    """Number, lattice and its numbers, in LaTeX."""
    from longwave.scenes.lattice_derivation import declared_lattice

    lattice = declared_lattice(scene)
    numbers = [*scene.constants]
    numbers += [(str(ybar), scene.background)] if scene.background else []
    numbers += [("k", scene.carrier)] if scene.is_envelope else []
    values = ", ".join(
        f"${latex_of(Symbol(name))} = {latex_of(constant_value(name, value))}$"
        for name, value in numbers
    )
    branch = f", {scene.branch} branch" if scene.branch != "acoustic" else ""
    return f"{escape(scene.name)}: {title_latex(lattice.title + branch)}; {values}"


def rate_panels(
    rates: Iterable[SceneConvergence],
) -> dict[float, dict[str, tuple[ConvergencePoint, ...]]]:
    """For each expected rate its curves, by the name of the case in the table."""
    panels: dict[float, dict[str, tuple[ConvergencePoint, ...]]] = {}
    for found in sorted(rates, key=lambda one: one.theory or 0):
        curves = panels.setdefault(found.theory or 0, {})
        curves[found.scene.name] = found.points
    return panels


ROGUES = ("alpha_beta_rogue", "dimer_rogue")
"""The scenes beside the paper's, which is the same wave on its own lattice."""

PEREGRINES = ("fput_peregrine", "dimer_peregrine", "granular_peregrine")

ROGUE_CELLS, PEREGRINE_CELLS, NEAR = 120, 180, 16
"""Cells shown to either side of c t: of rogue waves, of envelopes, and of their carriers."""


def lattice_figures(
    scenes: Mapping[str, SceneRun], papers: xr.Dataset, rates: Iterable[SceneConvergence]
) -> Iterator[tuple[str, Figure]]:
    """Each figure under its name, of scenes that ran, and of the paper's own run of their wave."""
    ran = {name: found.run for name, found in scenes.items() if found.run is not None}
    own = snapshots(papers, ROGUE_CELLS)
    rogues = [snapshots(ran[n], ROGUE_CELLS, even_times(ran[n])) for n in ROGUES if n in ran]
    yield "lattice_rogues", snapshot_panels([own, *rogues], "theory").figure()
    peregrines = [_peregrine_row(ran[name]) for name in PEREGRINES if name in ran]
    yield "lattice_peregrines", snapshot_panels(peregrines, "theory").figure()
    for name, run in ran.items():
        if is_map(scenes[name]):
            yield f"scene_{name}", strain_maps(run).figure()
    yield "lattice_rates", rate_figure(rate_panels(rates))


def _peregrine_row(run: xr.Dataset) -> list[xr.Dataset]:
    """The wave at its crest, and its carrier there and at the end."""
    crest = int(np.argmin(np.abs(run["time"].values)))
    wide = snapshots(run, PEREGRINE_CELLS, (crest,))
    return [*wide, *snapshots(run, NEAR, (crest, -1))]

"""What the report shows of runs on other lattices: scenes with their errors, rates over eps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from math import ceil, floor
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from sympy import Symbol

from longwave.derive.output.notation import latex_of
from longwave.derive.symbols import constant_value, ybar
from longwave.reports.formulas.typed import prose_latex
from longwave.reports.latex import (
    Row,
    escape,
    picture_latex,
    scientific,
    table,
    title_latex,
    titled,
    uncertain,
)
from longwave.reports.pictures.drawing import snapshot_panels
from longwave.reports.pictures.lattice_figures import even_times, rate_figure, strain_maps
from longwave.reports.pictures.run_data import placed, snapshots, with_own
from longwave.reports.studies.lattice_runs import SceneRun
from longwave.scenes.description.scene import Scene
from longwave.support.labelled_arrays import LabelledArrays

if TYPE_CHECKING:
    from longwave.scenes.convergence import ConvergencePoint, FittedRate, SceneConvergence


def scene_table(runs: Mapping[str, SceneRun]) -> str:
    """Each scene: wave and equation, size, the largest error after the start, what it took."""
    lines: list[Row] = []
    for name, found in runs.items():
        lines.append(titled(prose_latex(found.scene.title or name), name, found.fault))
        lines += [] if found.run is None else [_scene_cells(found, found.run)]
    head = [
        *("equation", r"$\epsilon$", r"error$\,/\,\epsilon^p$", "own error"),
        *("relative error", "own error", "cells", "time (s)"),
    ]
    caption = (
        "Lattices run from their waves: the largest error of the strain after the start, in units "
        r"of $\epsilon^p$ and relative to the wave, each with the run's own error."
    )
    return table("scenes", caption, "L{30mm}lllllrr", head, lines)


def _scene_cells(found: SceneRun, run: xr.Dataset) -> list[str]:
    """The cells of a scene that ran; the errors are the largest after the first time."""
    sup, relative = (run[name].values[1:] for name in ("sup_error", "error"))
    own = float(run.attrs["error_estimate"])
    place = int(sup.argmax())
    share = relative[place] / sup[place] if sup[place] else 0.0
    lost = "" if found.kept else " (TOO LARGE)"
    sup_shown, sup_own = uncertain(float(sup[place]), own)
    return [
        escape(str(run.attrs["equation"]).partition(":")[0]),
        f"${found.scene.eps:g}$",
        sup_shown,
        sup_own + lost,
        *uncertain(float(relative[place]), own * float(share)),
        f"${run.attrs['sites']:,}$".replace(",", r"\,"),
        scientific(float(run.attrs["seconds"] + run.attrs["planning_seconds"])),
    ]


def is_map(found: SceneRun) -> bool:
    """Whether a scene ran on two axes."""
    return found.run is not None and "row" in found.run.dims


def scene_maps(runs: Mapping[str, SceneRun]) -> str:
    """The figures of the scenes that ran on two axes."""
    what = "strain along $n$, and its distance from theory."
    return "\n".join(
        picture_latex(f"scene_{name}", f"{prose_latex(found.scene.title)}: {what}")
        for name, found in runs.items()
        if is_map(found)
    )


def rate_table(rates: Iterable[SceneConvergence]) -> str:
    """Each lattice with its numbers; below it each case with its expected and fitted rate."""
    head = ["equation", "wave", "data", "expected", "fitted", "limit (extrapolated)"]
    rows: list[Row] = []
    for title, cases in _by_lattice(rates):
        rows.append(title)
        rows += [
            [
                escape(found.equation),
                _wave(found.scene),
                found.scene.order,
                f"${found.theory}$",
                f"${found.rate.value:.2f}$",
                f"${interval(found.rate)}$" + ("" if found.reached else " (NOT REACHED)"),
            ]
            for found in cases
        ]
    caption = (
        r"Rates of convergence: the power of $\epsilon$ expected and fitted. The last column is "
        r"extrapolated: the interval of the limit at $\epsilon\to0$."
    )
    return table("rates", caption, "L{34mm}L{38mm}llll", head, rows)


def rate_errors(rates: Iterable[SceneConvergence]) -> str:
    """The error at every eps of each case with the run's own error, two of them in a row."""
    rows: list[Row] = []
    for title, cases in _by_lattice(rates):
        for found in cases:
            name = f"{title.partition(':')[0]}: {escape(found.equation)}, {found.scene.order} data"
            rows.append(f"{name}, {_wave(found.scene)}")
            cells = [
                [f"${point.eps:g}$", *uncertain(point.error, point.discretisation)]
                for point in found.points
            ]
            cells += [[""] * 3] * (len(cells) % 2)
            rows += [[*left, *right] for left, right in zip(cells[::2], cells[1::2], strict=True)]
    caption = "Sup errors of the strain at each $\\epsilon$, which the rates are fitted to."
    return table("rate_errors", caption, "llllll", [r"$\epsilon$", "error", "own error"] * 2, rows)


def _by_lattice(
    rates: Iterable[SceneConvergence],
) -> Iterator[tuple[str, list[SceneConvergence]]]:
    for title, cases in groupby(rates, lambda found: rate_title(found.scene)):
        yield title, list(cases)


def _wave(scene: Scene) -> str:
    return scene.wave_name.replace("_", " ") if scene.named_start else escape(scene.form.title)


def interval(rate: FittedRate) -> str:
    """The interval of a rate's limit, its ends rounded outwards."""
    return rf"{floor(10 * rate.low) / 10:.1f}\ldots {ceil(10 * rate.high) / 10:.1f}"


def rate_title(scene: Scene) -> str:
    """Number, lattice and its numbers, in LaTeX."""
    lattice = scene.symbolic_lattice
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
            yield f"scene_{name}", strain_maps(with_own(placed(run))).figure()
    yield "lattice_rates", rate_figure(rate_panels(rates))


def _peregrine_row(run: xr.Dataset) -> list[LabelledArrays]:
    """The wave at its crest, and its carrier there and at the end."""
    crest = int(np.argmin(np.abs(run["time"].values)))
    wide = snapshots(run, PEREGRINE_CELLS, (crest,))
    return [*wide, *snapshots(run, NEAR, (crest, -1))]

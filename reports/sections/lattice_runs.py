"""Tables and figures of runs on other lattices: errors of scenes, and rates over eps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from math import ceil, floor
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from sympy import Symbol

from longwave.derive.algebra.formula_printing import latex_of
from longwave.derive.symbols import constant_value, ybar
from longwave.reports import latex
from longwave.reports.formulas.typed import prose_latex
from longwave.reports.pictures.drawing import snapshot_panels
from longwave.reports.pictures.lattice_figures import even_times, rate_figure, strain_maps
from longwave.reports.pictures.run_data import placed, snapshots, with_own
from longwave.reports.studies.lattice_runs import SceneRun
from longwave.scenes.description.scene import Scene
from longwave.support.labelled_arrays import LabelledArrays

if TYPE_CHECKING:
    from longwave.scenes.convergence import ConvergencePoint, FittedRate, SceneConvergence


def scene_table(runs: Mapping[str, SceneRun]) -> str:
    """Return the table of scenes: equation, eps, largest errors after the start, cells, time."""
    lines: list[latex.Row] = []
    for name, entry in runs.items():
        lines.append(latex.titled(prose_latex(entry.scene.title or name), name, entry.fault))
        lines += [] if entry.run is None else [_scene_cells(entry, entry.run)]
    head = [
        *("equation", r"$\epsilon$", r"error$\,/\,\epsilon^p$", "own error"),
        *("relative error", "own error", "cells", "time (s)"),
    ]
    caption = (
        "Lattices run from their waves: the largest error of the strain after the start, in units "
        r"of $\epsilon^p$ and relative to the wave, each with the run's own error."
    )
    return latex.table("scenes", caption, "L{30mm}lllllrr", head, lines)


def _scene_cells(entry: SceneRun, run: xr.Dataset) -> list[str]:
    """Return the cells of a finished scene; errors are the largest after the first snapshot."""
    sup, relative = (run[name].values[1:] for name in ("sup_error", "error"))
    own = float(run.attrs["error_estimate"])
    worst = int(sup.argmax())
    share = relative[worst] / sup[worst] if sup[worst] else 0.0
    warning = "" if entry.within_tolerance else " (TOO LARGE)"
    sup_shown, sup_own = latex.uncertain(float(sup[worst]), own)
    return [
        latex.escape(str(run.attrs["equation"]).partition(":")[0]),
        f"${entry.scene.eps:g}$",
        sup_shown,
        sup_own + warning,
        *latex.uncertain(float(relative[worst]), own * float(share)),
        f"${run.attrs['sites']:,}$".replace(",", r"\,"),
        latex.scientific(float(run.attrs["seconds"] + run.attrs["planning_seconds"])),
    ]


def is_map(entry: SceneRun) -> bool:
    """Return whether a scene ran on a plane lattice (two axes)."""
    return entry.run is not None and "row" in entry.run.dims


def scene_maps(runs: Mapping[str, SceneRun]) -> str:
    """Return the LaTeX of the figures of scenes on plane lattices."""
    what = "strain along $n$, and its distance from theory."
    return "\n".join(
        latex.picture_latex(f"scene_{name}", f"{prose_latex(entry.scene.title)}: {what}")
        for name, entry in runs.items()
        if is_map(entry)
    )


def rate_table(rates: Iterable[SceneConvergence]) -> str:
    """Return the table of rates: under each lattice its cases with expected and fitted power."""
    head = ["equation", "wave", "data", "expected", "fitted", "limit (extrapolated)"]
    rows: list[latex.Row] = []
    for title, cases in _by_lattice(rates):
        rows.append(title)
        rows += [
            [
                latex.escape(case.equation),
                _wave(case.scene),
                case.scene.order,
                f"${case.theory}$",
                f"${case.rate.value:.2f}$",
                f"${interval(case.rate)}$" + ("" if case.reached else " (NOT REACHED)"),
            ]
            for case in cases
        ]
    caption = (
        r"Rates of convergence: the power of $\epsilon$ expected and fitted. The last column is "
        r"extrapolated: the interval of the limit at $\epsilon\to0$."
    )
    return latex.table("rates", caption, "L{34mm}L{38mm}llll", head, rows)


def rate_errors(rates: Iterable[SceneConvergence]) -> str:
    """Return the table of errors at every eps of each case, two points to a row."""
    rows: list[latex.Row] = []
    for title, cases in _by_lattice(rates):
        for case in cases:
            name = (
                f"{title.partition(':')[0]}: {latex.escape(case.equation)}, {case.scene.order} data"
            )
            rows.append(f"{name}, {_wave(case.scene)}")
            cells = [
                [f"${point.eps:g}$", *latex.uncertain(point.error, point.discretisation)]
                for point in case.points
            ]
            cells += [[""] * 3] * (len(cells) % 2)
            rows += [[*left, *right] for left, right in zip(cells[::2], cells[1::2], strict=True)]
    caption = "Sup errors of the strain at each $\\epsilon$, which the rates are fitted to."
    return latex.table(
        "rate_errors", caption, "llllll", [r"$\epsilon$", "error", "own error"] * 2, rows
    )


def _by_lattice(rates: Iterable[SceneConvergence]) -> Iterator[tuple[str, list[SceneConvergence]]]:
    for title, cases in groupby(rates, lambda case: rate_title(case.scene)):
        yield title, list(cases)


def _wave(scene: Scene) -> str:
    return (
        scene.wave_name.replace("_", " ") if scene.named_start else latex.escape(scene.form.title)
    )


def interval(rate: FittedRate) -> str:
    """Return the interval ``low`` .. ``high`` of a fitted rate as LaTeX, rounded outward to 0.1."""
    return rf"{floor(10 * rate.low) / 10:.1f}\ldots {ceil(10 * rate.high) / 10:.1f}"


def rate_title(scene: Scene) -> str:
    """Return a case's heading in LaTeX: name of its scene, lattice and values of its constants."""
    lattice = scene.symbolic_lattice
    numbers = [*scene.constants]
    numbers += [(str(ybar), scene.background)] if scene.background else []
    numbers += [("k", scene.carrier)] if scene.is_envelope else []
    values = ", ".join(
        f"${latex_of(Symbol(name))} = {latex_of(constant_value(name, value))}$"
        for name, value in numbers
    )
    branch = f", {scene.branch} branch" if scene.branch != "acoustic" else ""
    return f"{latex.escape(scene.name)}: {latex.title_latex(lattice.title + branch)}; {values}"


def rate_panels(
    rates: Iterable[SceneConvergence],
) -> dict[float, dict[str, tuple[ConvergencePoint, ...]]]:
    """Return curves of error against eps in panels by expected rate: {rate: {case: points}}."""
    panels: dict[float, dict[str, tuple[ConvergencePoint, ...]]] = {}
    for case in sorted(rates, key=lambda one: one.theory or 0):
        curves = panels.setdefault(case.theory or 0, {})
        curves[case.scene.name] = case.points
    return panels


ROGUES = ("alpha_beta_rogue", "dimer_rogue")
"""Scenes with the paper's rogue wave on other lattices."""

PEREGRINES = ("fput_peregrine", "dimer_peregrine", "granular_peregrine")
"""Scenes in which the Peregrine breather is the envelope of a carrier wave."""

ROGUE_CELLS, PEREGRINE_CELLS, CARRIER_CELLS = 120, 180, 16
"""Cells on either side of c t in pictures of rogue waves, of Peregrine envelopes, of carriers."""


def lattice_figures(
    scenes: Mapping[str, SceneRun], papers: xr.Dataset, rates: Iterable[SceneConvergence]
) -> Iterator[tuple[str, Figure]]:
    """Yield (name, figure) of runs on other lattices; ``papers`` is the paper's rogue-wave run."""
    ran = {name: found.run for name, found in scenes.items() if found.run is not None}
    rogues = [snapshots(papers, ROGUE_CELLS)]
    for run in (ran[name] for name in ROGUES if name in ran):
        rogues.append(snapshots(run, ROGUE_CELLS, even_times(run)))
    yield "lattice_rogues", snapshot_panels(rogues, "theory").figure()
    peregrines = [_peregrine_row(ran[name]) for name in PEREGRINES if name in ran]
    yield "lattice_peregrines", snapshot_panels(peregrines, "theory").figure()
    for name, run in ran.items():
        if is_map(scenes[name]):
            yield f"scene_{name}", strain_maps(with_own(placed(run))).figure()
    yield "lattice_rates", rate_figure(rate_panels(rates))


def _peregrine_row(run: xr.Dataset) -> list[LabelledArrays]:
    """Return snapshots of the envelope at its crest, and of the carrier then and at the end."""
    crest = int(np.argmin(np.abs(run["time"].values)))
    wide = snapshots(run, PEREGRINE_CELLS, (crest,))
    return [*wide, *snapshots(run, CARRIER_CELLS, (crest, -1))]

"""Tables and figures of chains on a bench: ends, forces, accuracy and cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain

import xarray as xr
from matplotlib.figure import Figure

from longwave.reports import latex
from longwave.reports.formulas.typed import prose_latex
from longwave.reports.pictures.bench_plotting import mode_energies, sensor_readings
from longwave.reports.pictures.drawing import crest_track
from longwave.reports.pictures.plotting import PICTURES
from longwave.reports.pictures.run_data import placed
from longwave.reports.studies.bench_laws import mode_return
from longwave.reports.studies.effects import CELLS, TOLERANCES, EffectCost
from longwave.reports.studies.lattice_runs import SceneRun
from longwave.scenes.description.bench import FORCE_TABLES, Bench
from longwave.scenes.description.losses import Losses
from longwave.support.labelled_arrays import LabelledArrays


def bench_table(runs: Mapping[str, SceneRun]) -> str:
    """Return the table of bench runs: ends, effects, cells, tolerance, error, steps, time."""
    head = ["ends and effects", "cells", "tolerance", "own error", "steps", "time (s)"]
    lines: list[latex.Row] = []
    for name, entry in runs.items():
        lines.append(latex.titled(prose_latex(entry.scene.title or name), name, entry.fault))
        lines += [] if entry.run is None else [_bench_cells(entry, entry.run)]
    caption = "Chains on a bench: what acts on each, and the largest error of its observables."
    return latex.table("benches", caption, "L{62mm}rlllr", head, lines)


def _bench_cells(entry: SceneRun, run: xr.Dataset) -> list[str]:
    attrs, scene = run.attrs, entry.scene
    warning = "" if entry.within_tolerance else " (TOO LARGE)"
    return [
        latex.escape(effects(scene.own_bench, scene.losses)),
        f"${attrs['sites']}$",
        latex.scientific(scene.target.tolerance),
        latex.scientific(float(attrs["error_estimate"])) + warning,
        f"${attrs['steps']}$",
        latex.scientific(float(attrs["seconds"] + attrs["planning_seconds"])),
    ]


def balance_table(runs: Mapping[str, SceneRun]) -> str:
    """Return the table of energy balances: final values of each run, and the largest defect."""
    head = ["chain", "energy gained", "work", "heat", "defect", "allowed"]
    lines = []
    for name, entry in runs.items():
        if entry.run is not None and "work" in entry.run:
            run = entry.run
            gained = run["energy"] - run["energy"][0]
            defect = float(abs(gained - run["work"] + run["heat"]).max())
            ends = (float(each[-1]) for each in (gained, run["work"], run["heat"]))
            final_values = (*(latex.scientific(end, 4) for end in ends), latex.scientific(defect))
            allowed = latex.scientific(3.0 * float(run.attrs["error_estimate"]))
            lines.append([rf"\texttt{{{latex.escape(name)}}}", *final_values, allowed])
    caption = (
        "Energy balance at the end of each chain; defect: the largest of gained $-$ work $+$ heat "
        "at any time; allowed: three times the run's own error."
    )
    return latex.table("balance", caption, "lrrrrr", head, lines)


def effects(bench: Bench, losses: Losses | None = None) -> str:
    """Return the ends of a bench chain and its effects (losses, forces, bath, defects) in words.

    >>> effects(Bench(8, ("fixed", "free"), energy=True), Losses(site=0.1))
    'ends: fixed, free; losses of cells'
    """
    ends = ", ".join(end if isinstance(end, str) else "moved" for end in bench.ends)
    acts = {push.kind for push in bench.forces}
    acting: dict[str, object] = {
        "losses of cells": losses and losses.site is not None,
        "dashpots": losses and losses.bond is not None,
        **{f"{kind}s": kind in acts for kind in FORCE_TABLES},
        "a bath": bench.noise,
        "defects": bench.masses or bench.springs,
    }
    return "; ".join([f"ends: {ends}", *(name for name, given in acting.items() if given)])


def effect_table(costs: Mapping[str, EffectCost]) -> str:
    """Return the table of each effect's cost: per cell and stage, and per run to a tolerance."""
    head = ["effect", "operations", "time (ns)", r"share (\%)"]
    for tolerance in TOLERANCES:
        head += [f"error to {latex.scientific(tolerance)}", "(s)"]
    rows = []
    for name, cost in costs.items():
        numbers = f"${cost.operations}$", f"${1e9 * cost.seconds:.2f}$", f"${100 * cost.share:.0f}$"
        runs = map(latex.scientific, chain.from_iterable(cost.runs))
        rows.append([latex.escape(name), *numbers, *runs])
    caption = (
        rf"Cost of each effect on the $\beta$ chain of {CELLS} cells: operations and time for "
        "a cell and stage, share of the core's multiply-adds; own error and time of a run to each "
        "tolerance."
    )
    return latex.table("effects", caption, "lrrr" + "lr" * len(TOLERANCES), head, rows)


def bench_laws(runs: Mapping[str, SceneRun], struck: Sequence[tuple[float, float]]) -> str:
    """Return the table of laws known for bench chains: known value, measured value and error."""
    lines = []
    fput = runs.get("fput_1955")
    if fput is not None and fput.run is not None:
        recurrence = mode_return(fput.run)
        when = latex.uncertain(recurrence.periods, recurrence.reading / 2)
        lines.append(["first return of mode 1 (FPUT, 32 springs), in periods", "147", *when])
        own = fput.run.attrs["error_estimate"] / float(fput.run.mode_energy[0, 0])
        share = latex.uncertain(100 * recurrence.share, 100 * float(own))
        lines.append([r"energy of mode 1 then (\%)", "98", *share])
    for slope, error in struck:
        measured = latex.uncertain(slope, error)
        lines.append(["exponent of the speed of struck grains in the velocity", "$1/5$", *measured])
    head = ["quantity", "known", "measured", "own error"]
    caption = (
        "Known numbers of these chains. Own error: half the time between readings, the run's "
        "estimate, the standard error of the fit."
    )
    return latex.table("laws", caption, "llll", head, lines)


DRAWN = {
    "mode_energy": mode_energies,
    "sensor": sensor_readings,
    "crest_law": crest_track,
    "strain": lambda run: PICTURES["snapshots"].part(placed(run)),
}
"""Variable of a run -> the picture of it; the first variable that the run has is drawn."""


def bench_figures(runs: Mapping[str, SceneRun]) -> Iterator[tuple[str, Figure]]:
    """Yield the name and figure of each run that succeeded, drawn by the first match in `DRAWN`."""
    for name, entry in runs.items():
        if entry.run is not None:
            draw = next(draw for variable, draw in DRAWN.items() if variable in entry.run.variables)
            yield f"bench_{name}", draw(LabelledArrays.of(entry.run)).figure()


def bench_pictures(runs: Mapping[str, SceneRun]) -> str:
    """Return the LaTeX that includes the figures of `bench_figures`."""
    return "\n".join(
        latex.picture_latex(f"bench_{name}", f"{prose_latex(entry.scene.title)}.", "H")
        for name, entry in runs.items()
        if entry.run is not None
    )

"""What the report shows of chains on a bench: what acts on each, how exactly, and what it took."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import xarray as xr
from matplotlib.figure import Figure

from longwave.reports.formulas.typed import prose_latex
from longwave.reports.latex import (
    Row,
    escape,
    picture_latex,
    scientific,
    table,
    titled,
    uncertain,
)
from longwave.reports.pictures.bench_plotting import mode_energies, sensor_readings
from longwave.reports.pictures.drawing import crest_track
from longwave.reports.pictures.plotting import PICTURES
from longwave.reports.pictures.run_data import placed
from longwave.reports.studies.bench_laws import mode_return
from longwave.reports.studies.effects import CELLS, TOLERANCES, EffectCost
from longwave.reports.studies.lattice_runs import SceneRun
from longwave.scenes.description.bench import ACTING, Bench
from longwave.scenes.description.losses import Losses
from longwave.support.labelled_arrays import LabelledArrays


def bench_table(runs: Mapping[str, SceneRun]) -> str:
    """Each chain: its ends and what acts on it, its size, tolerance, estimate, steps and time."""
    head = ["ends and effects", "cells", "tolerance", "own error", "steps", "time (s)"]
    lines: list[Row] = []
    for name, found in runs.items():
        lines.append(titled(prose_latex(found.scene.title or name), name, found.fault))
        lines += [] if found.run is None else [_bench_cells(found, found.run)]
    caption = "Chains on a bench: what acts on each, and the largest error of what is watched."
    return table("benches", caption, "L{62mm}rlllr", head, lines)


def _bench_cells(found: SceneRun, run: xr.Dataset) -> list[str]:
    told = run.attrs
    return [
        escape(effects(found.scene.own_bench, found.scene.losses)),
        f"${told['sites']}$",
        scientific(found.scene.target.tolerance),
        scientific(float(told["error_estimate"])) + ("" if found.kept else " (TOO LARGE)"),
        f"${told['steps']}$",
        scientific(float(told["seconds"] + told["planning_seconds"])),
    ]


def balance_table(runs: Mapping[str, SceneRun]) -> str:
    """The energy balance at the end of each chain that was followed, and its largest defect."""
    head = ["chain", "energy gained", "work", "heat", "defect", "allowed"]
    lines = []
    for name, found in runs.items():
        if found.run is not None and "work" in found.run:
            run = found.run
            gained = run["energy"] - run["energy"][0]
            defect = float(abs(gained - run["work"] + run["heat"]).max())
            ends = (float(each[-1]) for each in (gained, run["work"], run["heat"]))
            told = (*(scientific(end, 4) for end in ends), scientific(defect))
            allowed = scientific(3.0 * float(run.attrs["error_estimate"]))
            lines.append([rf"\texttt{{{escape(name)}}}", *told, allowed])
    caption = (
        "Energy balance at the end of each chain; defect: the largest of gained $-$ work $+$ heat "
        "at any time; allowed: three times the run's own error."
    )
    return table("balance", caption, "lrrrrr", head, lines)


def effects(bench: Bench, losses: Losses | None = None) -> str:
    """What acts on a chain, in words.

    >>> effects(Bench(8, ("fixed", "free"), energy=True), Losses(site=0.1))
    'ends: fixed, free; losses of cells'
    """
    ends = ", ".join(end if isinstance(end, str) else "moved" for end in bench.ends)
    acts = {push.kind for push in bench.forces}
    acting: dict[str, object] = {
        "losses of cells": losses and losses.site is not None,
        "dashpots": losses and losses.bond is not None,
        **{f"{kind}s": kind in acts for kind in ACTING},
        "a bath": bench.noise,
        "defects": bench.masses or bench.springs,
    }
    return "; ".join([f"ends: {ends}", *(name for name, given in acting.items() if given)])


def effect_table(costs: Mapping[str, EffectCost]) -> str:
    """Each effect: what it costs a cell and stage, and a run with it to each tolerance."""
    head = ["effect", "operations", "time (ns)", r"share (\%)"]
    for tolerance in TOLERANCES:
        head += [f"error to {scientific(tolerance)}", "(s)"]
    rows = [
        [
            escape(name),
            f"${cost.operations}$",
            f"${1e9 * cost.seconds:.2f}$",
            f"${100 * cost.share:.0f}$",
            *(cell for run in cost.runs for cell in map(scientific, run)),
        ]
        for name, cost in costs.items()
    ]
    caption = (
        rf"Cost of each effect on the $\beta$ chain of {CELLS} cells: operations and time for "
        "a cell and stage, share of the core's multiply-adds; own error and time of a run to each "
        "tolerance."
    )
    return table("effects", caption, "lrrr" + "lr" * len(TOLERANCES), head, rows)


def bench_laws(runs: Mapping[str, SceneRun], struck: Sequence[tuple[float, float]]) -> str:
    """What is known of these chains, and what the runs give, in a table."""
    lines = []
    fput = runs.get("fput_1955")
    if fput is not None and fput.run is not None:
        found = mode_return(fput.run)
        when = uncertain(found.periods, found.reading / 2)
        lines.append(["first return of mode 1 (FPUT, 32 springs), in periods", "147", *when])
        own = fput.run.attrs["error_estimate"] / float(fput.run.mode_energy[0, 0])
        share = uncertain(100 * found.share, 100 * float(own))
        lines.append([r"energy of mode 1 then (\%)", "98", *share])
    for slope, error in struck:
        told = uncertain(slope, error)
        lines.append(["exponent of the speed of struck grains in the velocity", "$1/5$", *told])
    head = ["quantity", "known", "measured", "own error"]
    caption = (
        "Known numbers of these chains. Own error: half the time between readings, the run's "
        "estimate, the standard error of the fit."
    )
    return table("laws", caption, "llll", head, lines)


DRAWN = {
    "mode_energy": mode_energies,
    "sensor": sensor_readings,
    "crest_law": crest_track,
    "strain": lambda run: PICTURES["snapshots"].part(placed(run)),
}
"""What is drawn of a run that holds a variable: modes, readings, a crest with its law, a wave."""


def bench_figures(runs: Mapping[str, SceneRun]) -> Iterator[tuple[str, Figure]]:
    """Each figure under its name, of what ran: what `DRAWN` has first of it."""
    for name, found in runs.items():
        if found.run is not None:
            draw = next(draw for held, draw in DRAWN.items() if held in found.run.variables)
            yield f"bench_{name}", draw(LabelledArrays.of(found.run)).figure()


def bench_pictures(runs: Mapping[str, SceneRun]) -> str:
    """The figures in LaTeX."""
    return "\n".join(
        picture_latex(f"bench_{name}", f"{prose_latex(found.scene.title)}.", "H")
        for name, found in runs.items()
        if found.run is not None
    )

"""What the report shows of chains on a bench: what acts on each, how exactly, and what it took."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import xarray as xr
from matplotlib.figure import Figure

from longwave.reports.latex import (
    duration,
    escape,
    picture_latex,
    scientific,
    table,
    titled_rows,
)
from longwave.reports.pictures.bench_plotting import mode_energies, sensor_readings
from longwave.reports.pictures.drawing import crest_track
from longwave.reports.pictures.plotting import PICTURES
from longwave.reports.pictures.run_data import placed
from longwave.reports.studies.bench_laws import mode_return
from longwave.reports.studies.effects import TOLERANCES, EffectCost
from longwave.reports.studies.lattice_runs import SceneRun
from longwave.scenes.bench import Bench


def bench_table(runs: Mapping[str, SceneRun]) -> str:
    """Each chain: its ends and what acts on it, its size, tolerance, estimate, steps and time."""
    head = ["what acts", "cells", "tolerance", "estimate", "steps", "time"]
    lines = [
        line
        for name, found in runs.items()
        for line in titled_rows(
            found.scene.title or name,
            name,
            f"did not run: {found.fault}" if found.run is None else _bench_cells(found, found.run),
        )
    ]
    return table("L{62mm}rlllr", head, lines)


def _bench_cells(found: SceneRun, run: xr.Dataset) -> list[str]:
    told = run.attrs
    return [
        escape(effects(Bench.of_json(found.scene.bench), found.scene.losses)),
        f"${told['sites']}$",
        scientific(found.scene.target.tolerance),
        scientific(float(told["error_estimate"])) + ("" if found.kept else " (TOO LARGE)"),
        f"${told['steps']}$",
        duration(float(told["seconds"] + told["planning_seconds"])),
    ]


def balance_table(runs: Mapping[str, SceneRun]) -> str:
    """The energy balance at the end of each chain that was followed, and its largest defect."""
    head = ["chain", "gained", "work", "heat", "gained $-$ work $+$ heat", "at most"]
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
    return table("lrrrrr", head, lines)


def effects(bench: Bench, losses: str = "") -> str:
    """What acts on a chain, in words.

    >>> effects(Bench(8, ("fixed", "free"), energy=True), '{"site": 0.1}')
    'ends: fixed, free; losses of cells'
    """
    ends = ", ".join(end if isinstance(end, str) else "moved" for end in bench.ends)
    acting = {
        "losses of cells": '"site"' in losses,
        "dashpots": '"bond"' in losses,
        "forces": bench.forces,
        "a bath": bench.noise,
        "defects": bench.masses or bench.springs,
    }
    return "; ".join([f"ends: {ends}", *(name for name, given in acting.items() if given)])


def effect_table(costs: Mapping[str, EffectCost]) -> str:
    """Each effect: what it costs a cell and stage, and a run with it to each tolerance."""
    head = ["effect", "operations", "ns", "of the core's"]
    for tolerance in TOLERANCES:
        head += [f"to {scientific(tolerance)}", "time"]
    rows = [
        [
            escape(name),
            f"${cost.operations}$",
            f"${1e9 * cost.seconds:.2f}$",
            escape(f"{cost.share:.0%}"),
            *(cell for error, taken in cost.runs for cell in (scientific(error), duration(taken))),
        ]
        for name, cost in costs.items()
    ]
    return table("lrrr" + "lr" * len(TOLERANCES), head, rows)


def bench_laws(runs: Mapping[str, SceneRun], struck: Sequence[tuple[float, float]]) -> str:
    """What is known of these chains, and what the runs give, in a table."""
    lines = []
    fput = runs.get("fput_1955")
    if fput is not None and fput.run is not None:
        found = mode_return(fput.run)
        when = rf"${found.periods:.1f}\pm {found.reading / 2:.1f}$ periods"
        lines.append(["first return of mode 1 (FPUT, 32 springs)", "about 147 periods", when])
        lines.append(["energy of mode 1 then", "98 \\%", f"{found.share * 100:.1f} \\%"])
    for slope, error in struck:
        told = rf"${slope:.7f}\pm {error:.7f}$"
        lines.append(["exponent of the speed of struck grains in the velocity", "$1/5$", told])
    return table("lll", ["what", "known", "measured"], lines)


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
            yield f"bench_{name}", draw(found.run).figure()


def bench_pictures(runs: Mapping[str, SceneRun]) -> str:
    """The figures in LaTeX."""
    return "\n".join(
        picture_latex(f"bench_{name}", f"{escape(found.scene.title)}.")
        for name, found in runs.items()
        if found.run is not None
    )

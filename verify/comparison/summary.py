"""What is printed of a run: its table of errors, and one line each on cost, trust and blow-up."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import xarray as xr
from rich.console import Console
from rich.table import Table

from verify.comparison.scene import Scene
from verify.comparison.trust import TOLERANCE

COLUMNS = {
    "error": "relative error",
    "error_far_field": "against far field",
    "time_step_error": "time step / eps",
    "domain_error": "domain / eps",
}


def print_summary(dataset: xr.Dataset, scene: Scene, console: Console) -> None:
    """Print a run's errors, its cost, what can be trusted of it, and a blow-up if there was one."""
    shown = {name: title for name, title in COLUMNS.items() if name in dataset}
    if shown:
        table = Table("t", *shown.values(), title=dataset.attrs["title"])
        for index, t in enumerate(dataset["time"].values):
            table.add_row(f"{t:g}", *(f"{float(dataset[name][index]):.3g}" for name in shown))
        console.print(table)
    for line in summary_lines(dataset, scene):
        console.print(line, markup=False, soft_wrap=True)


def summary_lines(dataset: xr.Dataset, scene: Scene) -> Iterator[str]:
    """The lines below the table."""
    yield _cost(dataset)
    if "trust_rate" in dataset.attrs:
        yield _trust(dataset.attrs, scene)
    if "unfinished" in dataset.attrs:
        yield f"unfinished: {dataset.attrs['unfinished']}"
    if dataset.attrs["blow_up"]:
        yield f"{dataset.attrs['blow_up']}; {dataset.sizes['time']} snapshots before it are kept"


def _trust(found: Mapping[str, Any], scene: Scene) -> str:
    """Whether the periodic background is stable, and until when rounding stays small if not."""
    if found["trust_rate"] == 0.0:
        return "background: periodic and stable"
    if math.isnan(found["trust_rate"]):
        return "background: periodic, its crests too far apart for its stability to be computed"
    last = scene.t0 + found["trust_horizon"]
    verdict = "before" if scene.end <= last else "after that, and is not to be trusted there"
    return (
        f"background: periodic and unstable; the fastest perturbation grows like "
        f"exp({found['trust_rate']:.3g} t), rounding reaches {scene.tolerance or TOLERANCE:g} eps "
        f"{found['trust_horizon']:.3g} after t0, at t = {last:.3g}; "
        f"the scene ends {verdict}"
    )


def _cost(dataset: xr.Dataset) -> str:
    """The cost line: what was done, how exact it is, what it took, and what more would take."""
    cost = dataset.attrs
    line = (
        f"{cost['engine']}, {cost['scheme']}: {cost['steps']} steps, {cost['sites']} sites, "
        f"{cost['force_evaluations']} force evaluations a site, {cost['seconds']:.2f} s"
    )
    if "step_limit" in cost:
        line += f" (step limit {cost['step_limit']:.3g})"
    return line + (_accuracy(cost) if "error_estimate" in cost else "")


def _accuracy(cost: Mapping[str, Any]) -> str:
    """Estimate against tolerance, planning, and the next decade if the tolerance was met."""
    line = (
        f"; error estimate {cost['error_estimate']:.2g} of {cost['tolerance']:g} allowed, "
        f"planned in {cost['planning_seconds']:.2f} s"
    )
    if "next_decade" not in cost:
        return line
    dear = cost["next_decade"]
    return (
        f"{line}; an estimate of "
        f"{cost['error_estimate'] / 10:.2g} would take {dear:.2g} times as long, "
        f"{dear * cost['seconds']:.2g} s"
    )

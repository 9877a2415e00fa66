"""``longwave run``: run a scene and print its errors, or the one in a run's file, and compare."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table

from longwave.runs.run_file import load_run, names_a_run, scene_of_run, strain_fault
from longwave.runs.run_output import (
    OutputCheckpoint,
    check_run_output,
    fail_or_save_elsewhere,
    save_anywhere,
    store_messages,
)
from longwave.runs.run_store import RunStore
from longwave.runs.sweep_scene import changed_scene
from longwave.scenes.description.bench import OF_MEANS
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.methods import record_scene
from longwave.scenes.engines.recorders import Variables
from longwave.scenes.engines.run_record import RunRecord, UnfinishedRun, error_unit
from longwave.scenes.starts.background_growth import USUAL_TOLERANCE
from longwave.support.command_line import fail, fail_for_memory
from longwave.support.console import plain_console, print_json, print_lines, progress_bar
from longwave.support.interruption import interrupted, keeping

if TYPE_CHECKING:
    import xarray as xr


def run_and_print(
    source: str,
    program: str,
    *,
    tolerance: float | None = None,
    engine: str | None = None,
    changes: Mapping[str, Any] | None = None,
    output: str | None = None,
    store: str | None = None,
    force: bool = False,
    json_wanted: bool = False,
) -> int:
    """Run one scene, or the scene in a run's file again; print errors and cost, write it if asked.

    ``tolerance``, ``engine`` and the fields in ``changes`` stand in the place of the scene's; the
    run is written to ``output`` and kept in the ``store``.

    Exit status 0, 1 if the run blew up, could not be written or has other bits than in its file, 2
    for bad input, told in one line, and 130 after Ctrl-C, which ``program`` tells: what was
    recorded until then is printed and written, too. More than 5 s are announced.
    """
    kept = None
    try:
        check_run_output(output, force)
        if names_a_run(source):
            said = ", ".join(f"{field}={value}" for field, value in (changes or {}).items())
            given = {"tolerance": tolerance, "engine": engine, "set": said, "store": store}
            kept = _finished_run(source, given)
            scene = scene_of_run(kept)
        else:
            scene = changed_scene(source, changes or {}, tolerance, engine)
    except (ValueError, OSError) as error:
        return fail(error)
    checkpoint = OutputCheckpoint(output, store)
    try:
        wanted = "" if scene.tolerance is None else f" to {scene.tolerance:g}"
        work = f"{scene.name}{wanted}" if kept is None else f"{source} again"
        with checkpoint.kept(scene):
            run = _run_with_bar(scene, store, work)
    except KeyboardInterrupt as stop:
        if kept is not None:
            return interrupted(program, checkpoint.left(f"{source} is as it was"))
        if not isinstance(stop, UnfinishedRun):
            return interrupted(program, checkpoint.left("nothing was recorded yet"))
        where = _keep_unfinished(stop.record, scene, output, force, json_wanted)
        count = f"{len(stop.record.reached)} snapshots are kept{where}"
        return interrupted(program, checkpoint.left(count, written=bool(where)))
    except (ValueError, OSError) as error:
        return fail_or_save_elsewhere(error)
    except MemoryError as error:
        return fail_for_memory(error)
    status = checkpoint.settle(lambda: run.dataset, force)
    if kept is not None:
        differs = _compare_and_print(source, kept, run.dataset, json_wanted)
        return status or differs
    _print_run(run, scene, json_wanted)
    return status or int(bool(run.attrs["blow_up"]))


def _keep_unfinished(
    record: RunRecord, scene: Scene, output: str | None, force: bool, json_wanted: bool
) -> str:
    """Write what was recorded, if that is asked for, and print it; in words where it is kept."""
    with keeping():
        is_written = output is not None and not save_anywhere(record.dataset, output, force)
        _print_run(record, scene, json_wanted)
    return f" in {output}" if is_written else ""


def _finished_run(source: str, changed: Mapping[str, object]) -> xr.Dataset:
    """The run in the file; ValueError for options that a repetition cannot have."""
    for name, given in changed.items():
        if given not in (None, ""):
            raise ValueError(
                f"--{name} must not be given with a run, got {given} (it is run as it was)"
            )
    run = load_run(source)
    if "unfinished" in run.attrs:
        raise ValueError(
            f"run must have come to its end to be repeated, got {source}, unfinished: "
            f"{run.attrs['unfinished']} (run its scene)"
        )
    if fault := strain_fault(run):
        print(f"{source}: {fault}", file=sys.stderr)
    return run


def _compare_and_print(source: str, kept: xr.Dataset, made: xr.Dataset, json_wanted: bool) -> int:
    """Tell what differs in a run that was made again; 1 if its bits do."""
    from longwave.runs.repeated_run import compare_runs

    found = compare_runs(kept, made)
    first, *further = found.lines()
    if json_wanted:
        print_json({"run": source, "same_bits": found.is_same, "differences": [first, *further]})
    else:
        print_lines(plain_console(), [f"{source}: {first}", *further])
    return 0 if found.is_same else 1


def _run_with_bar(scene: Scene, store: str | None, work: str) -> RunRecord:
    """Run a scene, or find its run in the store, with a bar where there is a terminal."""
    with progress_bar(scene.name, work) as bar:
        if store is None:
            return record_scene(scene, *bar)
        with store_messages():
            run = RunStore(store).run(scene, *bar)
    variables: Variables = {
        str(name): (tuple(map(str, value.dims)), value.values, dict(value.attrs))
        for name, value in run.variables.items()
    }
    record = RunRecord(scene, (), tuple(run["time"].values), variables, dict(run.attrs))
    record.dataset = run
    return record


COLUMNS = {
    "slow_time": "T",
    "sup_error": "sup error / {unit}",
    "error": "relative error",
    "error_far_field": "against far field",
    "time_step_error": "time step / {unit}",
    "domain_error": "domain / {unit}",
    "sideband_size": "sidebands / carrier",
    "sideband_theory": "in theory",
    "energy": "energy",
    "work": "work",
    "heat": "heat",
}
"""The columns of a run's table, of the variables that it has; errors are told in a unit."""


MOST_SENSORS = 8
"""Sensors of which is told what they read."""


def _print_run(run: RunRecord, scene: Scene, json_wanted: bool) -> None:
    if json_wanted:
        print_json(run_data(run, scene))
    else:
        print_summary(run, scene, plain_console())


def run_data(run: RunRecord, scene: Scene) -> dict[str, Any]:
    """What is told of a run as tables, numbers and texts; arrays over sites are in its file."""
    numbers = {
        name: {"values": values, "units": told.get("units", ""), "what": told.get("long_name", "")}
        for name, (over, values, told) in run.variables.items()
        if over in (("time",), ("time", "sensor"), ("sensor",))
    }
    return {
        "name": scene.name,
        "scene": scene.document(),
        "times": run.reached,
        "variables": numbers,
        "attributes": run.attrs,
    }


def print_summary(run: RunRecord, scene: Scene, console: Console) -> None:
    """Print a run's errors, what was derived, its cost, what can be trusted of it, and a blow-up if
    there was one."""
    unit = error_unit(run.attrs.get("power", 1))
    held = {name for name, (over, _, _) in run.variables.items() if over == ("time",)}
    columns = {name: t.format(unit=unit) for name, t in COLUMNS.items() if name in held}
    print_lines(console, [scene.title or scene.name])
    if columns:
        table = Table("t", *columns.values())
        for t, *row in zip(run.reached, *map(run.values, columns), strict=True):
            if scene.bench and t not in scene.snapshots:
                continue
            table.add_row(f"{t:g}", *(f"{value:.3g}" for value in row))
        console.print(table)
    print_lines(console, summary_lines(run, scene))


def summary_lines(run: RunRecord, scene: Scene) -> Iterator[str]:
    """The lines below the table."""
    told = run.attrs
    if "equation" in told:
        yield f"{scene.lattice}, eps = {scene.eps:g}, {scene.order} order; {told['equation']}"
    if "verdict" in told:
        yield str(told["verdict"])
    yield _cost(told)
    if "peak" in run.variables:
        yield from _pulse(run)
    for name in run.variables:
        if name.startswith("sensor_") and not name.endswith(OF_MEANS):
            yield from _readings(run, name)
    if "trust_rate" in told:
        yield _trust(told, scene)
    if "unfinished" in told:
        yield f"unfinished: {told['unfinished']}"
    if told["blow_up"]:
        yield f"{told['blow_up']}; {len(run.reached)} snapshots before it are kept"


def _pulse(run: RunRecord) -> Iterator[str]:
    """What disorder left of a wave."""
    peak, energy, delay = (
        f"{run.values(name)[-1]:.4g} +- {run.values(name + '_error')[-1]:.1g}"
        for name in ("peak", "energy", "delay")
    )
    unknown = np.isnan(run.values("energy")[-1])
    held = "" if unknown else f" and energy {energy}"
    yield f"at the end: largest force {peak}{held} of the start's, {delay} sites late"
    if unknown:
        yield "no energy is told: the lattice has none, or the wave goes on beyond half_width"
    if "effective_speed" in run.attrs:
        yield f"very long waves: {run.attrs['effective_speed']:.6g} of the ordered lattice's speed"


def _readings(run: RunRecord, name: str) -> Iterator[str]:
    """The largest values that the first sensors read, and when."""
    for place, site in list(enumerate(run.values("sensor")))[:MOST_SENSORS]:
        values = run.values(name)[:, place].reshape(len(run.reached), -1)
        when, part = divmod(int(np.argmax(np.abs(values))), values.shape[1])
        bar = run.variables.get(f"{name}_error")
        told = "" if bar is None else f" +- {bar[1][when, place].ravel()[part]:.1g}"
        read = f"{values[when, part]:.6g}{told} at t = {run.reached[when]:g}"
        yield f"cell {site}: {name.removeprefix('sensor_')} at most {read}"


def _trust(found: Mapping[str, Any], scene: Scene) -> str:
    """Whether the periodic background is stable, and until when rounding stays small if not."""
    if found["trust_rate"] == 0.0:
        return "background: periodic and stable"
    if math.isnan(found["trust_rate"]):
        return "background: periodic, its crests too far apart for its stability to be computed"
    last, allowed = scene.t0 + found["trust_horizon"], scene.tolerance or USUAL_TOLERANCE
    verdict = "before" if scene.end <= last else "after that, and is not to be trusted there"
    return (
        f"background: periodic and unstable; the fastest perturbation grows like "
        f"exp({found['trust_rate']:.3g} t), rounding reaches {allowed:g} eps "
        f"{found['trust_horizon']:.3g} after t0, at t = {last:.3g}; "
        f"the scene ends {verdict}"
    )


def _cost(cost: Mapping[str, Any]) -> str:
    """The cost line: what was done, how exact it is, what it took, and what more would take."""
    line = (
        f"{cost['engine']}, {cost['scheme']}: {cost['steps']} steps, {cost['sites']} sites, "
        f"{cost['force_evaluations']} force evaluations a site, {cost['seconds']:.2f} s"
    )
    if "runs" in cost:
        line += f"; means of {cost['runs']} runs"
    if "step_limit" in cost:
        line += f" (step limit {cost['step_limit']:.3g})"
    if "error_estimate" in cost:
        line += _accuracy(cost)
    drift = cost.get("energy_drift")
    return line if drift is None else f"{line}; energy kept to {drift:.1g}"


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

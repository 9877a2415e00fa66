"""``longwave run``: run a scene and print its errors, or repeat the run in a file and compare."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table

from longwave.runs import run_output
from longwave.runs.run_file import load_run, names_a_run, scene_of_run, strain_fault
from longwave.runs.run_store import RunStore
from longwave.runs.sweep_scene import changed_scene
from longwave.scenes.description.bench import MEAN_SUFFIXES
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
    """Run a scene, or repeat the run in a file; print errors and cost; return the exit status.

    ``tolerance``, ``engine`` and the fields in ``changes`` replace those of the scene. The run is
    written to ``output`` and saved in ``store``, if given. A run expected to take more than 5 s is
    announced.

    The status is 0; 1 if the run blew up, could not be written, or differs from the one in the
    file; 2 for bad input, with a message in one line; 130 after Ctrl-C. In the last case the
    snapshots so far are printed and written.
    """
    stored_run = None
    try:
        run_output.check_run_output(output, force)
        if names_a_run(source):
            typed = ", ".join(f"{field}={value}" for field, value in (changes or {}).items())
            options = {"tolerance": tolerance, "engine": engine, "set": typed, "store": store}
            stored_run = _load_finished(source, options)
            scene = scene_of_run(stored_run)
        else:
            scene = changed_scene(source, changes or {}, tolerance, engine)
    except (ValueError, OSError) as error:
        return fail(error)
    checkpoint = run_output.OutputCheckpoint(output, store)
    try:
        tolerance_text = "" if scene.tolerance is None else f" to {scene.tolerance:g}"
        work = f"{scene.name}{tolerance_text}" if stored_run is None else f"{source} again"
        with checkpoint.checkpointed(scene):
            run = _run_with_bar(scene, store, work)
    except KeyboardInterrupt as stop:
        if stored_run is not None:
            return interrupted(program, checkpoint.interrupt_message(f"{source} is unchanged"))
        if not isinstance(stop, UnfinishedRun):
            return interrupted(program, checkpoint.interrupt_message("nothing was recorded yet"))
        location = _save_unfinished(stop.record, scene, output, force, json_wanted)
        count = f"{len(stop.record.reached)} snapshots are kept{location}"
        return interrupted(program, checkpoint.interrupt_message(count, bool(location)))
    except (ValueError, OSError) as error:
        return run_output.fail_or_save_elsewhere(error)
    except MemoryError as error:
        return fail_for_memory(error)
    status = checkpoint.settle(lambda: run.dataset, force)
    if stored_run is not None:
        differs = _compare_and_print(source, stored_run, run.dataset, json_wanted)
        return status or differs
    _print_run(run, scene, json_wanted)
    return status or int(bool(run.attrs["blow_up"]))


def _save_unfinished(
    record: RunRecord, scene: Scene, output: str | None, force: bool, json_wanted: bool
) -> str:
    """Print an interrupted run; return " in OUTPUT" if it was written to ``output``, else ""."""
    with keeping():
        is_written = output is not None and not run_output.save_anywhere(
            record.dataset, output, force
        )
        _print_run(record, scene, json_wanted)
    return f" in {output}" if is_written else ""


def _load_finished(source: str, options: Mapping[str, object]) -> xr.Dataset:
    """Load a run to repeat; raise ValueError if it is unfinished or ``options`` would change it."""
    for name, value in options.items():
        if value not in (None, ""):
            raise ValueError(f"--{name} must not be given with a run, got {value} (leave it out)")
    run = load_run(source)
    if "unfinished" in run.attrs:
        got = f"{source}, unfinished: {run.attrs['unfinished']} (run its scene)"
        raise ValueError(f"run must be finished to be repeated, got {got}")
    if fault := strain_fault(run):
        print(f"{source}: {fault}", file=sys.stderr)
    return run


def _compare_and_print(
    source: str, stored_run: xr.Dataset, repeated_run: xr.Dataset, json_wanted: bool
) -> int:
    """Print the differences between a run and its repetition; return 1 if their bits differ."""
    from longwave.runs.repeated_run import compare_runs

    comparison = compare_runs(stored_run, repeated_run)
    first, *other_lines = comparison.lines()
    if json_wanted:
        differences = [first, *other_lines]
        print_json({"run": source, "same_bits": comparison.is_same, "differences": differences})
    else:
        print_lines(plain_console(), [f"{source}: {first}", *other_lines])
    return 0 if comparison.is_same else 1


def _run_with_bar(scene: Scene, store: str | None, work: str) -> RunRecord:
    """Run a scene, or load its run from ``store``, with a bar; ``work`` names the run in notes."""
    with progress_bar(scene.name, work) as bar:
        if store is None:
            return record_scene(scene, *bar)
        with run_output.store_messages():
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
"""Variable of a run -> heading of its column in the table; ``unit`` is the unit of errors."""


MAX_SENSORS = 8
"""Largest number of sensors whose readings are printed."""


def _print_run(run: RunRecord, scene: Scene, json_wanted: bool) -> None:
    if json_wanted:
        print_json(run_data(run, scene))
    else:
        print_summary(run, scene, plain_console())


def run_data(run: RunRecord, scene: Scene) -> dict[str, Any]:
    """Return a run as JSON-ready data; arrays over sites are only in its file."""
    numbers = {
        name: {"values": v, "units": attrs.get("units", ""), "what": attrs.get("long_name", "")}
        for name, (dims, v, attrs) in run.variables.items()
        if dims in (("time",), ("time", "sensor"), ("sensor",))
    }
    return {
        "name": scene.name,
        "scene": scene.document(),
        "times": run.reached,
        "variables": numbers,
        "attributes": run.attrs,
    }


def print_summary(run: RunRecord, scene: Scene, console: Console) -> None:
    """Print a run: errors over time, equation, cost, reliability, and a blow-up if any."""
    unit = error_unit(run.attrs.get("power", 1))
    over_time = {name for name, (dims, _, _) in run.variables.items() if dims == ("time",)}
    columns = {n: heading.format(unit=unit) for n, heading in COLUMNS.items() if n in over_time}
    print_lines(console, [scene.title or scene.name])
    if columns:
        table = Table("t", *columns.values())
        for time, *row in zip(run.reached, *map(run.values, columns), strict=True):
            if not scene.bench or time in scene.snapshots:
                table.add_row(f"{time:g}", *(f"{value:.3g}" for value in row))
        console.print(table)
    print_lines(console, summary_lines(run, scene))


def summary_lines(run: RunRecord, scene: Scene) -> Iterator[str]:
    """Yield the lines that are printed below a run's table: equation, cost, readings, stability."""
    attrs = run.attrs
    if "equation" in attrs:
        yield f"{scene.lattice}, eps = {scene.eps:g}, {scene.order} order; {attrs['equation']}"
    if "verdict" in attrs:
        yield str(attrs["verdict"])
    yield _cost_line(attrs)
    if "peak" in run.variables:
        yield from _disorder_lines(run)
    for name in run.variables:
        if name.startswith("sensor_") and not name.endswith(MEAN_SUFFIXES):
            yield from _reading_lines(run, name)
    if "trust_rate" in attrs:
        yield _background_line(attrs, scene)
    if "unfinished" in attrs:
        yield f"unfinished: {attrs['unfinished']}"
    if attrs["blow_up"]:
        yield f"{attrs['blow_up']}; {len(run.reached)} snapshots before it are kept"


def _disorder_lines(run: RunRecord) -> Iterator[str]:
    """Yield lines on how disorder changed a wave: its peak force, energy and delay at the end."""
    peak, energy, delay = (
        f"{run.values(name)[-1]:.4g} +- {run.values(name + '_error')[-1]:.1g}"
        for name in ("peak", "energy", "delay")
    )
    unknown = np.isnan(run.values("energy")[-1])
    energy_text = "" if unknown else f" and energy {energy}"
    yield f"at the end: largest force {peak}{energy_text} of the start's, {delay} sites late"
    if unknown:
        yield "energy: not measured; the lattice has none, or the wave extends beyond half_width"
    if "effective_speed" in run.attrs:
        yield f"very long waves: {run.attrs['effective_speed']:.6g} of the ordered lattice's speed"


def _reading_lines(run: RunRecord, name: str) -> Iterator[str]:
    """Yield a line for each of the first sensors: its largest reading and the time of that."""
    errors = run.variables.get(f"{name}_error")
    for index, site in list(enumerate(run.values("sensor")))[:MAX_SENSORS]:
        values = run.values(name)[:, index].reshape(len(run.reached), -1)
        row, column = divmod(int(np.argmax(np.abs(values))), values.shape[1])
        reading = f"{values[row, column]:.6g}"
        if errors is not None:
            reading += f" +- {errors[1][row, index].ravel()[column]:.1g}"
        quantity, time = name.removeprefix("sensor_"), run.reached[row]
        yield f"cell {site}: {quantity} at most {reading} at t = {time:g}"


def _background_line(attrs: Mapping[str, Any], scene: Scene) -> str:
    """Return a line on the stability of a periodic background and the growth of rounding."""
    if attrs["trust_rate"] == 0.0:
        return "background: periodic and stable"
    if math.isnan(attrs["trust_rate"]):
        return "background: periodic, its crests too far apart for its stability to be computed"
    last, allowed = scene.t0 + attrs["trust_horizon"], scene.tolerance or USUAL_TOLERANCE
    verdict = "before" if scene.end <= last else "after that, where it is not reliable"
    return (
        f"background: periodic and unstable; the fastest perturbation grows like "
        f"exp({attrs['trust_rate']:.3g} t), rounding reaches {allowed:g} eps "
        f"{attrs['trust_horizon']:.3g} after t0, at t = {last:.3g}; "
        f"the scene ends {verdict}"
    )


def _cost_line(attrs: Mapping[str, Any]) -> str:
    """Return the line on engine, steps, sites, time taken and accuracy."""
    line = (
        f"{attrs['engine']}, {attrs['scheme']}: {attrs['steps']} steps, {attrs['sites']} sites, "
        f"{attrs['force_evaluations']} force evaluations a site, {attrs['seconds']:.2f} s"
    )
    if "runs" in attrs:
        line += f"; means of {attrs['runs']} runs"
    if "step_limit" in attrs:
        line += f" (step limit {attrs['step_limit']:.3g})"
    if "error_estimate" in attrs:
        line += _accuracy_text(attrs)
    drift = attrs.get("energy_drift")
    return line if drift is None else f"{line}; energy kept to {drift:.1g}"


def _accuracy_text(attrs: Mapping[str, Any]) -> str:
    """Return the error estimate and the tolerance, and the cost of a tenfold smaller estimate."""
    line = (
        f"; error estimate {attrs['error_estimate']:.2g} of {attrs['tolerance']:g} allowed, "
        f"planned in {attrs['planning_seconds']:.2f} s"
    )
    if (factor := attrs.get("next_decade")) is None:
        return line
    smaller, seconds = attrs["error_estimate"] / 10, factor * attrs["seconds"]
    cost = f"{factor:.2g} times as long, {seconds:.2g} s"
    return f"{line}; an estimate of {smaller:.2g} would take {cost}"

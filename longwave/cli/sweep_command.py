"""``longwave sweep SWEEP.toml``: run its cells, print their statuses, write their numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from longwave.runs.run_file import SWEPT, open_run
from longwave.runs.run_output import check_run_output, store_messages
from longwave.runs.run_pack import DONE, NUMBERS
from longwave.runs.run_store import RunStore
from longwave.runs.sweep import SweepState, run_with_progress
from longwave.runs.sweep_cost import SweepCost, expected_sweep_cost
from longwave.runs.sweep_file import Sweep, load_sweep
from longwave.runs.sweep_scene import changed_scene
from longwave.runs.sweep_workers import check_workers, sweep_workers
from longwave.support.command_line import BROKEN, fail
from longwave.support.console import plain_console, print_json, print_lines, progress_bar
from longwave.support.interruption import interrupted
from longwave.support.processes import LocalWorkers, Workers
from longwave.support.request_limits import check_request, current_limits, duration

if TYPE_CHECKING:
    import xarray as xr

    from longwave.runs.sampled_sweep import ObservedNumber


def sweep_and_print(
    source: str,
    program: str,
    *,
    processes: int | None = None,
    scheduler: str | None = None,
    store: str | None = None,
    output: str | None = None,
    force: bool = False,
    samples: int | None = None,
    seed: int | None = None,
    changes: Mapping[str, Any] | None = None,
    json_wanted: bool = False,
) -> int:
    """Run a sweep, print a summary, and write its data set to ``output``; return the exit status.

    ``changes`` replace fields of its scene that do not vary. With ``samples``, ``source`` is a
    scene, which is run at that many samples of its measured constants; its observables are printed
    with their intervals. Runs are saved in the folder ``store``. A sweep that
    is expected to take more than 5 s is announced, and the time left is printed every 30 s.

    The status is 0; 1 if a cell did not finish or a result could not be written; 2 for bad input;
    130 after Ctrl-C. Finished cells are then in the store, and the same command runs the others.
    """
    state = SweepState(0)
    try:
        with store_messages():
            check_workers(processes, scheduler)
            check_run_output(output, force=True)
            with progress_bar("reading", "reading the sweep"):
                sweep = _load(source, samples, seed, changes or {})
                state.cells = len(sweep)
                output = output or f"{sweep.name}.nc"
                check_run_output(output, force=True)
                _check_overwriting(sweep, Path(output), force)
                run_store = _store_for(sweep, store, output)
                stored_keys = run_store.stored_runs()
                expected = expected_sweep_cost(sweep, run_store, stored_keys)
            with sweep_workers(processes, scheduler) as workers:
                state.workers = workers.count
                _run_with_bar(sweep, run_store, workers, state, expected, stored_keys)
            dataset, numbers = _write_results(sweep, run_store, output, samples is not None)
    except KeyboardInterrupt:
        return interrupted(program, _saved_text(state))
    except OSError as error:
        if not state.stored + state.done:
            return fail(error)
        fail(f"{error.filename or output}: {error.strerror or error} ({_saved_text(state)})")
        return BROKEN
    except ValueError as error:
        return fail(error)
    if json_wanted:
        paths = {"output": output, "store": str(run_store.folder)}
        print_json(sweep_data(sweep, dataset, state, numbers) | paths)
    else:
        lines = [*summary_lines(sweep, dataset, state), *(number.text() for number in numbers)]
        print_lines(plain_console(), [*lines, f"written: {output}; runs: {run_store.folder}"])
    return 0 if bool((dataset["status"] == DONE).all()) else 1


def _store_for(sweep: Sweep, folder: str | None, output: str) -> RunStore:
    """Return the store of a sweep's runs, in ``folder`` or by default in NAME.store."""
    store = RunStore(Path(folder or f"{sweep.name}.store"))
    if Path(output).resolve() == store.folder.resolve():
        got = f"{output} for both (rename one)"
        raise ValueError(f"--output must differ from the folder --store, got {got}")
    return store


def _load(source: str, samples: int | None, seed: int | None, changes: Mapping[str, Any]) -> Sweep:
    """Load the sweep, or build it from a scene and a number of samples."""
    if samples is None and seed is not None:
        got = f"{seed} alone (a sweep's file has its seed)"
        raise ValueError(f"--seed must be given with --samples, got {got}")
    if samples is None:
        return load_sweep(source, changes)
    from longwave.runs.sampled_sweep import sampled_sweep

    return sampled_sweep(changed_scene(source, changes), samples, seed or 0)


def _write_results(
    sweep: Sweep, store: RunStore, output: str, sampled: bool
) -> tuple[xr.Dataset, list[ObservedNumber]]:
    """Write the data set; return it and the observable numbers of a sampled scene."""
    from longwave.runs.sampled_sweep import write_samples
    from longwave.runs.sweep_dataset import write_sweep

    if sampled:
        return write_samples(sweep, store, output)
    return write_sweep(sweep, store, output), []


def _saved_text(state: SweepState) -> str:
    saved = state.stored + state.done
    return f"{saved} of {state.cells} cells are saved; repeat the command for the rest"


def _check_overwriting(sweep: Sweep, output: Path, force: bool) -> None:
    """Raise ValueError if the output file exists and is not a result of this sweep."""
    if force or not output.exists():
        return
    existing = ""
    with suppress(ValueError, OSError), open_run(output) as older:
        existing = str(older.attrs.get(SWEPT, ""))
    if existing != sweep.json():
        got = f"{output}, another file (take another name, or --force)"
        raise ValueError(f"--output must be a new file or a result of this sweep, got {got}")


def _run_with_bar(
    sweep: Sweep,
    store: RunStore,
    workers: Workers,
    state: SweepState,
    expected: SweepCost,
    stored_keys: Container[str],
) -> None:
    """Announce and run the sweep; raise OverBudgetError if its expected cost exceeds the limits."""
    is_local = isinstance(workers, LocalWorkers)
    cost = expected.on_workers(workers.count, share_memory=is_local)
    work = f"{sweep.name}, {expected.description},"
    too_large = is_local and cost.memory_bytes > current_limits().memory_bytes
    fewer = "fewer --processes, " if too_large else ""
    check_request(work, cost, f"take {fewer}fewer or cheaper cells")
    label = work.removesuffix(",")
    with progress_bar(sweep.name, label, clock=perf_counter) as progress:
        progress[1](cost.seconds)
        state.expected = expected.seconds_by_cell
        run_with_progress(sweep, store, workers, state, stored_keys, progress)


def sweep_data(
    sweep: Sweep, dataset: xr.Dataset, state: SweepState, numbers: list[ObservedNumber]
) -> dict[str, Any]:
    """Return JSON-ready data: the cells with the swept values, and the observed ``numbers``."""
    columns = {
        str(name): dataset[name].values.ravel().tolist()
        for name in ("status", "message", *NUMBERS)
        if name in dataset and dataset[name].size == len(sweep)
    }
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    cells = [{"set": sweep.values(cell), **row} for cell, row in enumerate(rows)]
    return {
        "name": sweep.name,
        "title": sweep.title,
        "dimensions": {dimension.name: dimension.size for dimension in sweep.dimensions},
        "run_now": state.done,
        "seconds": state.seconds,
        "cells": cells,
        "observed": {
            number.name: dict(zip(("low", "median", "high"), number.ends, strict=True))
            for number in numbers
        },
    }


def summary_lines(sweep: Sweep, dataset: xr.Dataset, state: SweepState) -> Iterator[str]:
    """Yield the lines that summarise a sweep's results."""
    if sweep.title:
        yield sweep.title
    counts = Counter(dataset["status"].values.ravel().tolist())
    statuses = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    sizes = " x ".join(f"{dimension.size} {dimension.name}" for dimension in sweep.dimensions)
    yield f"{len(sweep)} cells ({sizes}): {statuses}"
    if state.done:
        verb = "was" if state.done == 1 else "were"
        workers = "1 worker" if state.workers == 1 else f"{state.workers} workers"
        yield f"{state.done} {verb} run now by {workers}, {duration(state.seconds)} in all"
    errors = dataset["error"].values
    if np.any(np.isfinite(errors)):
        least, most = (f"{end(errors):.3g}" for end in (np.nanmin, np.nanmax))
        line = f"relative error {least}" + (f" to {most}" if most != least else "")
        own = dataset["own_error"].values
        if np.any(np.isfinite(own)):
            line += f", the runs' own part at most {np.nanmax(own):.2g}"
        yield line
    faults = dataset["message"].values[dataset["status"].values != DONE]
    if faults.size:
        yield f"first fault: {faults.ravel()[0]}"

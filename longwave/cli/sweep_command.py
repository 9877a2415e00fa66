"""``longwave sweep SWEEP.toml``: run its cells, print how they ended, write their numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterator, Mapping
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from longwave.runs.run_file import SWEPT, open_run
from longwave.runs.run_output import check_run_output, store_messages
from longwave.runs.run_pack import DONE, NUMBERS
from longwave.runs.run_store import RunStore
from longwave.runs.sweep import SweepState, run_shown
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

    from longwave.runs.sampled_sweep import Observed


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
    """Run a sweep, print how its cells ended, and write its data set to ``output``.

    ``changes`` are other values for fields of its scene that do not vary. With ``samples`` the
    ``source`` is a scene, which is run at so many draws of its measured constants; its observables
    are printed with their intervals. Runs are kept in the folder ``store``. Exit status 0, 1 if a
    cell did not come to its end or could not be written, 2 for bad input, told in one line, and 130
    after Ctrl-C, which ``program`` tells: what was done is in the store then, and the same command
    goes on with what is missing. More than 5 s are announced, and every 30 s what is left.
    """
    told = SweepState(0)
    try:
        with store_messages():
            check_workers(processes, scheduler)
            check_run_output(output, force=True)
            _check_samples(samples, seed)
            with progress_bar("reading", "reading the sweep"):
                sweep = _asked(source, samples, seed, changes or {})
                told.cells = len(sweep)
                output = output or f"{sweep.name}.nc"
                check_run_output(output, force=True)
                _check_overwriting(sweep, Path(output), force)
                kept = _store_of(sweep, store, output)
                held = kept.held()
                expected = expected_sweep_cost(sweep, kept, held)
            with sweep_workers(processes, scheduler) as workers:
                told.workers = workers.count
                _run_with_bar(sweep, kept, workers, told, expected, held)
            found, seen = _written(sweep, kept, output, samples is not None)
    except KeyboardInterrupt:
        return interrupted(program, _kept(told))
    except OSError as error:
        if not told.found + told.done:
            return fail(error)
        fail(f"{error.filename or output}: {error.strerror or error} ({_kept(told)})")
        return BROKEN
    except ValueError as error:
        return fail(error)
    if json_wanted:
        places = {"output": output, "store": str(kept.folder)}
        print_json(sweep_data(sweep, found, told, seen) | places)
    else:
        lines = [*summary_lines(sweep, found, told), *(one.text() for one in seen)]
        print_lines(plain_console(), [*lines, f"written: {output}; runs: {kept.folder}"])
    return 0 if bool((found["status"] == DONE).all()) else 1


def _store_of(sweep: Sweep, folder: str | None, output: str) -> RunStore:
    """The store of a sweep's runs, in the ``folder`` or one of its own."""
    kept = RunStore(Path(folder or f"{sweep.name}.store"))
    if Path(output).resolve() == Path(kept.folder).resolve():
        raise ValueError(
            f"--output must not be the --store, a folder, got {output} for both (take another name)"
        )
    return kept


def _check_samples(samples: int | None, seed: int | None) -> None:
    if seed is not None and samples is None:
        raise ValueError(
            f"--seed must be given with --samples, got {seed} alone (a sweep's is in its file)"
        )


def _asked(source: str, samples: int | None, seed: int | None, changes: Mapping[str, Any]) -> Sweep:
    """The sweep, or the sampled scene."""
    if samples is None:
        return load_sweep(source, changes)
    from longwave.runs.sampled_sweep import sampled_sweep

    return sampled_sweep(changed_scene(source, changes), samples, seed or 0)


def _written(
    sweep: Sweep, store: RunStore, output: str, sampled: bool
) -> tuple[xr.Dataset, list[Observed]]:
    """The data set that is written, and what is seen of a sampled scene."""
    from longwave.runs.sampled_sweep import write_samples
    from longwave.runs.sweep_dataset import write_sweep

    if sampled:
        return write_samples(sweep, store, output)
    return write_sweep(sweep, store, output), []


def _kept(told: SweepState) -> str:
    kept = told.found + told.done
    return f"{kept} of {told.cells} cells are kept; again goes on with the rest"


def _check_overwriting(sweep: Sweep, output: Path, force: bool) -> None:
    """Refuse to write over what is no result of this sweep, before anything is run."""
    if force or not output.exists():
        return
    held = ""
    try:
        with open_run(output) as older:
            held = str(older.attrs.get(SWEPT, ""))
    except (ValueError, OSError):
        pass
    if held != sweep.json():
        raise ValueError(
            f"--output must name no file but an earlier result of this sweep, got {output} "
            "(take another name, or --force)"
        )


def _run_with_bar(
    sweep: Sweep,
    store: RunStore,
    workers: Workers,
    told: SweepState,
    expected: SweepCost,
    held: Container[str],
) -> None:
    """Run it, announced; OverBudgetError if it is expected to be beyond the limits."""
    here = isinstance(workers, LocalWorkers)
    cost = expected.by(workers.count, together=here)
    work = f"{sweep.name}, {expected.words},"
    too_large = here and cost.memory_bytes > current_limits().memory_bytes
    fewer = "fewer --processes, " if too_large else ""
    check_request(work, cost, f"take {fewer}fewer or cheaper cells")
    shown = work.removesuffix(",")
    with progress_bar(sweep.name, shown, clock=perf_counter) as progress:
        progress[1](cost.seconds)
        told.expected = expected.each
        run_shown(sweep, store, workers, told, held, progress)


def sweep_data(
    sweep: Sweep, found: xr.Dataset, told: SweepState, seen: list[Observed]
) -> dict[str, Any]:
    """What a sweep came to as tables, numbers and texts: its cells, with what was swept."""
    columns = {
        str(name): found[name].values.ravel().tolist()
        for name in ("status", "message", *NUMBERS)
        if name in found and found[name].size == len(sweep)
    }
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    cells = [{"set": sweep.values(place), **row} for place, row in enumerate(rows)]
    return {
        "name": sweep.name,
        "title": sweep.title,
        "dimensions": {dimension.name: dimension.size for dimension in sweep.dimensions},
        "run_now": told.done,
        "seconds": told.seconds,
        "cells": cells,
        "observed": {
            one.name: dict(zip(("low", "median", "high"), one.ends, strict=True)) for one in seen
        },
    }


def summary_lines(sweep: Sweep, found: xr.Dataset, told: SweepState) -> Iterator[str]:
    """What a sweep came to, in lines."""
    if sweep.title:
        yield sweep.title
    counts = Counter(found["status"].values.ravel().tolist())
    ended = ", ".join(f"{count} {status}" for status, count in counts.most_common())
    sizes = " x ".join(f"{d.size} {d.name}" for d in sweep.dimensions)
    yield f"{len(sweep)} cells ({sizes}): {ended}"
    if told.done:
        were = "was" if told.done == 1 else "were"
        workers = "1 worker" if told.workers == 1 else f"{told.workers} workers"
        yield f"{told.done} {were} run now by {workers}, {duration(told.seconds)} in all"
    errors = found["error"].values
    if np.any(np.isfinite(errors)):
        least, most = (f"{end(errors):.3g}" for end in (np.nanmin, np.nanmax))
        line = f"relative error {least}" + (f" to {most}" if most != least else "")
        own = found["own_error"].values
        known = np.any(np.isfinite(own))
        yield f"{line}, the runs' own part at most {np.nanmax(own):.2g}" if known else line
    faults = found["message"].values[found["status"].values != DONE]
    if faults.size:
        yield f"first fault: {faults.ravel()[0]}"

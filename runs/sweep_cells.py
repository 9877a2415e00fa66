"""Running a batch of sweep cells in a worker process, and packing the results."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from time import perf_counter, process_time
from typing import TYPE_CHECKING

import numpy as np

from longwave.runs.own_error import own_error_at
from longwave.runs.run_pack import (
    BLOWN_UP,
    DONE,
    FAILED,
    NUMBERS,
    OPTIONAL,
    REFUSED,
    CellRecord,
    pack_content,
    write_pack,
)
from longwave.runs.run_store import RunStore, UnsavedRunError, runs_its_sources
from longwave.runs.store_packs import new_pack
from longwave.runs.sweep_cost import expected_cell_cost
from longwave.runs.sweep_workers import check_code
from longwave.support.atomic_file import not_stale
from longwave.support.compiled.cores import keep_to_one_core
from longwave.support.request_limits import (
    Cancelled,
    OverBudgetError,
    RequestLimits,
    request_limits,
)

if TYPE_CHECKING:
    import xarray as xr

    from longwave.scenes.description.scene import Scene

MAX_ESTIMATED = 5
"""Largest number of cells of a batch whose cost is estimated, which takes 5 ms each."""

MIN_FILE_SECONDS = 10.0
"""Expected seconds of a run above which it is stored in its own file, with checkpoints."""


@dataclass(frozen=True)
class Cell:
    """One cell to run: its number in the sweep, its scene and the scene's key."""

    number: int
    key: str
    scene: Scene


@dataclass(frozen=True)
class Batch:
    """Results of a batch: the status of each cell and the times summed over the cells.

    ``pack`` is the content of a pack with the runs, if the worker does not share the store's
    folder.
    """

    statuses: Sequence[str]
    seconds: float
    processor_seconds: float
    whole_processor_seconds: float
    first_fault: str = ""
    pack: bytes | None = None
    expected: float = 0.0
    """Estimated seconds of all cells of the batch."""


class WorkerStopped(BaseException):
    """Raised in a worker that is asked to stop; a BaseException, so that no handler swallows it."""


def run_cells(
    cells: Sequence[Cell],
    folder: Path,
    token: str,
    limits: RequestLimits | None = None,
    code: Mapping[str, str] | None = None,
) -> Batch:
    """Run the cells one after the other and write one pack of them into the store ``folder``.

    An error of a cell, or an excess over the ``limits``, becomes its record. A worker that is asked
    to stop packs the finished cells. ``token`` is the name of a file by which a worker on another
    machine recognises the store. Raises ValueError if the worker's code is not ``code``, that
    of the cells' keys.
    """
    if code is not None:
        check_code(code)
    keep_to_one_core()
    start = process_time()
    store = RunStore(folder) if not_stale((folder / token).is_file) else None
    records: list[CellRecord] = []
    seconds = processor = expected = 0.0
    pack = None
    estimated = Random(cells[0].number).sample(cells, min(MAX_ESTIMATED, len(cells)))
    limited = request_limits(limits.memory_bytes, limits.seconds) if limits else nullcontext()
    try:
        with _stop_on_sigterm(), limited:
            for cell in cells:
                wall_start, processor_start = perf_counter(), process_time()
                if cell in estimated:
                    with suppress(ValueError):  # equations derived here are cached for the run
                        cost = expected_cell_cost(cell.scene)
                        expected += cost.seconds * len(cells) / len(estimated)
                records.append(run_cell(cell, store))
                seconds += perf_counter() - wall_start
                processor += process_time() - processor_start
    finally:
        if records and store is not None:
            write_pack(new_pack(folder), records)
        elif records:
            pack = pack_content(records)
    statuses = [record.status for record in records]
    faults = (record.message for record in records if record.status in (REFUSED, FAILED))
    total_processor = process_time() - start
    return Batch(statuses, seconds, processor, total_processor, next(faults, ""), pack, expected)


@contextmanager
def _stop_on_sigterm() -> Iterator[None]:
    """Raise WorkerStopped within the context when the process receives SIGTERM.

    If it is raised in a callback from C, such as numba's compiler, Python discards it silently; the
    process is then killed shortly after.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        raise WorkerStopped

    previous, hook = signal.signal(signal.SIGTERM, stop), sys.unraisablehook
    sys.unraisablehook = lambda unraisable: (
        None if unraisable.exc_type is WorkerStopped else hook(unraisable)
    )
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)
        sys.unraisablehook = hook


def run_cell(cell: Cell, store: RunStore | None = None) -> CellRecord:
    """Run one cell; an error becomes its record.

    A run that is expected to take long is saved in the ``store`` and left out of the record. If it
    cannot be saved there, the record has it.
    """
    from longwave.runs.run_file import load_run
    from longwave.scenes.engines import scene_run

    in_own_file = False

    def check_duration(seconds: float) -> None:
        if store is not None and seconds >= MIN_FILE_SECONDS:
            raise Cancelled

    try:
        try:
            run = scene_run.run(cell.scene, announce=check_duration)
        except Cancelled:
            assert store is not None
            in_own_file = True
            run = load_run(store.fetch(cell.scene), follow=False)
    except UnsavedRunError as error:
        run, in_own_file = error.run, False
    except OverBudgetError as error:  # the next attempt may have higher limits
        return CellRecord(cell.key, FAILED, _one_line(error))
    except ValueError as error:
        # `fetch` also raises ValueError if sources changed, which is no fault of the scene.
        sources_changed = in_own_file and not runs_its_sources()
        return CellRecord(cell.key, FAILED if sources_changed else REFUSED, _one_line(error))
    except Exception as error:  # the sweep continues, and the next attempt may succeed
        return CellRecord(cell.key, FAILED, _one_line(f"{type(error).__name__}: {error}"))
    record = record_of(cell.key, cell.scene, run)
    return replace(record, run=None) if in_own_file else record


def record_of(key: str, scene: Scene, run: xr.Dataset) -> CellRecord:
    """Return the record of a scene's finished run."""
    blow_up = str(run.attrs.get("blow_up", ""))
    return CellRecord(key, BLOWN_UP if blow_up else DONE, blow_up, numbers_of(scene, run), run)


def numbers_of(scene: Scene, run: xr.Dataset) -> Mapping[str, float]:
    """Return a cell's `NUMBERS`: from its run's attributes, and the largest error over time.

    ``own_error`` is the numerical error at the time of the largest error.
    """
    numbers = {name: run.attrs[name] for name in NUMBERS if name in run.attrs}
    numbers |= {name: run.variables[name].values for name in OPTIONAL if name in run.variables}
    for name in (name for name in ("error", "error_curve") if name in run.variables):
        values = np.asarray(run.variables[name].values, dtype=np.float64)
        if not np.isnan(values).all():
            index = int(np.nanargmax(values))
            numbers["error"] = float(values[index])
            if "own_error" not in numbers:
                numbers["own_error"] = own_error_at(run, scene, name, index)
            break
    return {name: float(value) for name, value in numbers.items()}


def _one_line(error: object) -> str:
    """Return the error message in one line of at most 500 characters."""
    return " ".join(str(error).split())[:500]

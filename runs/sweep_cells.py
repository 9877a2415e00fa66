"""The cells of a sweep in a worker process: run one after the other, and packed."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
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
from longwave.runs.run_store import RunStore, UnkeptRunError, runs_its_sources
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

MOST_JUDGED = 5
"""Cells of a batch by which it is told what was expected of it: that takes 5 ms of a cell."""

LONG = 10.0
"""Seconds from which on a cell is a run of its own in the store, with checkpoints."""


@dataclass(frozen=True)
class Cell:
    """A cell to be run: its number in the sweep, its scene and that scene's key."""

    number: int
    key: str
    scene: Scene


@dataclass(frozen=True)
class Batch:
    """What a worker did: how the cells ended, and how long they took themselves.

    ``pack`` is the content of the pack of their runs where the worker does not see the store.
    """

    statuses: Sequence[str]
    seconds: float
    processor_seconds: float
    whole_processor_seconds: float
    first_fault: str = ""
    pack: bytes | None = None
    expected: float = 0.0
    """Seconds that the cells were estimated to take."""


class StoppedWorker(BaseException):
    """The worker is to end; what catches every Exception does not catch this."""


def run_cells(
    cells: Sequence[Cell],
    folder: Path,
    token: str,
    limits: RequestLimits | None = None,
    code: Mapping[str, str] | None = None,
) -> Batch:
    """Run the cells one after the other and write one pack of them into the store ``folder``.

    What a cell raises is its record, as is that it would take more than the ``limits``. A worker
    that is told to end packs what it has. ``token`` is the name of a file by which a worker on
    another machine knows the store. Raises ValueError if it has not the ``code`` of the keys.
    """
    if code is not None:
        check_code(code)
    keep_to_one_core()
    begun = process_time()
    store = RunStore(folder) if not_stale((folder / token).is_file) else None
    found: list[CellRecord] = []
    seconds = processor = expected = 0.0
    pack = None
    judged = Random(cells[0].number).sample(cells, min(MOST_JUDGED, len(cells)))
    try:
        with _ending(), _limited(limits):
            for cell in cells:
                clock, spent = perf_counter(), process_time()
                if cell in judged:
                    expected += _expected_seconds(cell) * len(cells) / len(judged)
                found.append(run_cell(cell, store))
                seconds += perf_counter() - clock
                processor += process_time() - spent
    finally:
        if found:
            if store is not None:
                write_pack(new_pack(folder), found)
            else:
                pack = pack_content(found)
    statuses = [record.status for record in found]
    faults = (record.message for record in found if record.status in (REFUSED, FAILED))
    whole = process_time() - begun
    return Batch(statuses, seconds, processor, whole, next(faults, ""), pack, expected)


def _expected_seconds(cell: Cell) -> float:
    """What `expected_sweep_cost` counts for it; what it derives for that is kept for the run."""
    try:
        return expected_cell_cost(cell.scene).seconds
    except ValueError:
        return 0.0


def _limited(limits: RequestLimits | None) -> AbstractContextManager[object]:
    if limits is None:
        return nullcontext()
    return request_limits(limits.memory_bytes, limits.seconds)


@contextmanager
def _ending() -> Iterator[None]:
    """Raise StoppedWorker in the body when the process is told to end.

    Where it is raised in what is called from C, as numba compiles, it is lost without a word: the
    process is killed a moment later.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        raise StoppedWorker

    before, hook = signal.signal(signal.SIGTERM, stop), sys.unraisablehook
    sys.unraisablehook = lambda lost: None if lost.exc_type is StoppedWorker else hook(lost)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
        sys.unraisablehook = hook


def run_cell(cell: Cell, store: RunStore | None = None) -> CellRecord:
    """Run one cell; what it raises is told in its record.

    What is expected to take long is kept in the ``store`` instead of the record; in both if it
    cannot be written there as a file of its own.
    """

    from longwave.runs.run_file import load_run
    from longwave.scenes.engines import scene_run

    alone = False

    def told(seconds: float) -> None:
        if store is not None and seconds >= LONG:
            raise Cancelled

    try:
        try:
            run = scene_run.run(cell.scene, announce=told)
        except Cancelled:
            assert store is not None
            alone = True
            run = load_run(store.fetch(cell.scene), follow=False)
    except UnkeptRunError as error:
        run, alone = error.run, False
    except OverBudgetError as error:  # the next attempt may be allowed more
        return CellRecord(cell.key, FAILED, _line(error))
    except ValueError as error:
        changed = alone and not runs_its_sources()  # which the store refuses, and not the scene
        return CellRecord(cell.key, FAILED if changed else REFUSED, _line(error))
    except Exception as error:  # the sweep goes on, and the next attempt may succeed
        return CellRecord(cell.key, FAILED, _line(f"{type(error).__name__}: {error}"))
    record = record_of(cell.key, cell.scene, run)
    return replace(record, run=None) if alone else record


def record_of(key: str, scene: Scene, run: xr.Dataset) -> CellRecord:
    """The record of the scene's run, which came to an end."""
    blown = str(run.attrs.get("blow_up", ""))
    return CellRecord(key, BLOWN_UP if blown else DONE, blown, numbers_of(scene, run), run)


def numbers_of(scene: Scene, run: xr.Dataset) -> Mapping[str, float]:
    """What a cell is told by: attributes of its run, and its largest error with its own error."""
    found = {name: run.attrs[name] for name in NUMBERS if name in run.attrs}
    found |= {name: run.variables[name].values for name in OPTIONAL if name in run.variables}
    for name in ("error", "error_curve"):
        if name in run.variables:
            values = np.asarray(run.variables[name].values, dtype=np.float64)
            if values.size and not np.all(np.isnan(values)):
                place = int(np.nanargmax(values))
                found["error"] = float(values[place])
                if "own_error" not in found:
                    found["own_error"] = own_error_at(run, scene, name, place)
                break
    return {name: float(value) for name, value in found.items()}


def _line(error: object) -> str:
    """The error in one line of at most 500 characters."""
    return " ".join(str(error).split())[:500]

"""Running a sweep: batches of cells go to workers, packs of finished cells into a store."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import chain, islice
from pathlib import Path
from typing import TYPE_CHECKING

from longwave.runs.run_pack import FAILED, REFUSED, CellRecord, write_pack
from longwave.runs.run_store import RunStore
from longwave.runs.store_packs import MERGED_COUNT, PACKS, merge_packs, new_pack
from longwave.runs.sweep_cells import Batch, Cell, run_cells
from longwave.runs.sweep_workers import process_code
from longwave.support.atomic_file import write_atomically
from longwave.support.command_line import one_line
from longwave.support.processes import Call, Job, LostProcess, Workers, in_turn
from longwave.support.request_limits import current_limits
from longwave.support.sealed_file import write_sealed

if TYPE_CHECKING:
    from longwave.runs.sweep_file import Sweep

MIN_BATCH_SECONDS, MAX_BATCH_SECONDS = 0.3, 3.0
"""Least and largest duration of a batch, whose pack costs 10 ms. Batches are short towards the end,
so that all workers finish together."""

BATCHES_LEFT = 4
"""Number of batches per worker into which the remaining cells are divided, if long enough."""

MAX_QUEUED = 2
"""Number of batches assigned to a worker, the current one included, so that it never waits."""

RECENT_BATCHES = 5
"""Number of batches per worker that determine the recent pace. In `SweepState.seconds_left` their
mean cost counts as much as the estimated costs of this many cells."""

MAX_LOST_WORKERS = 3
"""Number of lost workers after which a cell that runs alone is recorded as failed."""

SweepProgress = Callable[["SweepState"], None]


@dataclass
class SweepState:
    """Progress of a sweep: numbers of cells in all, stored before, done now, and with a fault.

    ``seconds`` and ``processor_seconds`` sum over the cells; ``worker_seconds`` is the processor
    time of the workers, overhead included. ``first_fault`` is the message of the first cell with a
    fault.
    """

    cells: int
    workers: int = 1
    stored: int = 0
    done: int = 0
    faults: int = 0
    seconds: float = 0.0
    processor_seconds: float = 0.0
    worker_seconds: float = 0.0
    first_fault: str = ""
    pace: float = 0.0
    """Running mean of the seconds per cell."""
    expected: Mapping[int, float] = field(default_factory=dict)
    """Estimated seconds by cell number, for the cells whose cost was estimated (`SweepCost`)."""
    next_number: int = 0
    """Number after the last cell that was done."""
    batches: int = 0
    recent: tuple[float, float, float] = 0.0, 0.0, 0.0
    """Weighted sums over recent batches: cells, estimated seconds and measured seconds. The first
    batch of each worker, which loads code, is left out."""

    @property
    def seconds_left(self) -> float:
        """Estimated seconds until the end, from expected costs or the recent pace; 0 at first."""
        cells_left = self.cells - self.stored - self.done
        cells, expected, taken = self.recent
        if not expected:
            return cells_left * self.pace / self.workers
        unfinished = [
            seconds for cell, seconds in self.expected.items() if cell >= self.next_number
        ]
        count = len(unfinished) + RECENT_BATCHES
        mean_expected = (sum(unfinished) + RECENT_BATCHES * expected / cells) / count
        return cells_left * mean_expected * taken / expected / self.workers

    def count(self, batch: Batch, next_number: int) -> None:
        """Add a finished batch of cells, all with numbers below ``next_number``."""
        self.done += len(batch.statuses)
        self.faults += sum(status in (REFUSED, FAILED) for status in batch.statuses)
        self.seconds += batch.seconds
        self.processor_seconds += batch.processor_seconds
        self.worker_seconds += batch.whole_processor_seconds
        self.first_fault = self.first_fault or batch.first_fault
        self.next_number = max(self.next_number, next_number)
        self.batches += 1
        if self.batches > self.workers:
            weight = 1.0 - 1.0 / (RECENT_BATCHES * self.workers)
            latest = len(batch.statuses), batch.expected, batch.seconds
            cells, expected, taken = (
                weight * old + new for old, new in zip(self.recent, latest, strict=True)
            )
            self.recent = cells, expected, taken
        mean = batch.seconds / len(batch.statuses)
        self.pace = 0.5 * (self.pace + mean) if self.pace else mean


def run_sweep(
    sweep: Sweep,
    store: RunStore,
    workers: Workers,
    progress: SweepProgress = lambda _: None,
    state: SweepState | None = None,
    stored_keys: Container[str] | None = None,
) -> SweepState:
    """Run the cells of a sweep that the store does not have, and save their runs in the store.

    Cells with a fault are recorded and the sweep continues; they are run again only if they may
    succeed then. The current request limits apply to each cell. ``progress`` is called after each
    batch with the ``state``, which is returned. ``stored_keys`` is `RunStore.stored_runs`, if the
    caller has it already. Raises OSError if the store cannot be written, and passes on Ctrl-C;
    finished cells are saved in both cases.
    """
    state = SweepState(len(sweep), workers.count) if state is None else state
    stored_keys = store.stored_runs() if stored_keys is None else stored_keys
    missing = _missing_cells(sweep, store, stored_keys, state)
    first = next(missing, None)
    if first is not None:  # a complete store need not be writable
        (store.folder / PACKS).mkdir(parents=True, exist_ok=True)
        with _store_token(store.folder) as token:
            _Dispatch(store, workers, state, progress, token).run(chain([first], missing))
    return state


def run_with_progress(
    sweep: Sweep,
    store: RunStore,
    workers: Workers,
    state: SweepState,
    stored_keys: Container[str],
    displays: tuple[Callable[[float], object], Callable[[float], object] | None],
) -> None:
    """Run a sweep; call the ``displays`` with the finished fraction and the seconds left."""
    advance, show_seconds_left = displays

    def show(state: SweepState) -> None:
        advance((state.stored + state.done) / state.cells)
        if show_seconds_left is not None and any(state.recent):
            show_seconds_left(state.seconds_left)

    run_sweep(sweep, store, workers, show, state, stored_keys)


def _missing_cells(
    sweep: Sweep, store: RunStore, stored_keys: Container[str], state: SweepState
) -> Iterator[Cell]:
    """Yield the cells that the store does not have, in order; cells with equal scenes only once.

    All other cells are counted in ``state``, those without an admissible scene as faults.
    """
    requested: set[str] = set()
    for number in range(len(sweep)):
        try:
            scene = sweep.scene(number)
        except ValueError as error:
            state.first_fault = state.first_fault or str(error)
            state.faults += 1
            state.stored += 1
            continue
        key = store.key(scene)
        if key in requested or key in stored_keys:
            state.stored += 1
        else:
            requested.add(key)
            yield Cell(number, key, scene)


@contextmanager
def _store_token(folder: Path) -> Iterator[str]:
    """Create a temporary file in the store's folder, by which workers see whether they share it."""
    name = f".{uuid.uuid4().hex}.sweep"
    write_atomically(folder / name, lambda draft: draft.write_bytes(b""), durable=False)
    try:
        yield name
    finally:
        (folder / name).unlink(missing_ok=True)


@dataclass
class _Dispatch:
    """Dispatch of a sweep's cells to the workers, and collection of the results."""

    store: RunStore
    workers: Workers
    state: SweepState
    progress: SweepProgress
    token: str
    sent: int = 0
    """Number of cells that workers are processing."""
    unmerged: int = 0
    """Number of packs written since the last merge."""

    def run(self, missing: Iterator[Cell]) -> None:
        """Run the cells in batches; then run each cell of a batch that lost its worker alone."""
        suspects: list[Cell] = []
        for cells, call in in_turn(self._batches(missing), self.workers, ahead=MAX_QUEUED):
            if not self._take(cells, call):
                suspects += cells
        for cell in suspects:
            self._run_alone(cell)

    def _batches(self, missing: Iterator[Cell]) -> Iterator[tuple[tuple[Cell, ...], Job]]:
        while cells := tuple(islice(missing, self._size())):
            yield self._batch(cells)

    def _batch(self, cells: tuple[Cell, ...]) -> tuple[tuple[Cell, ...], Job]:
        self.sent += len(cells)
        folder = self.store.folder.absolute()
        return cells, Job(run_cells, (cells, folder, self.token, current_limits(), process_code()))

    def _size(self) -> int:
        """Return the number of cells in the next batch."""
        pace = self.state.pace
        if not pace:
            return 1
        unsent = self.state.cells - self.state.stored - self.state.done - self.sent
        seconds = unsent * pace / (BATCHES_LEFT * self.workers.count)
        return max(1, int(min(max(seconds, MIN_BATCH_SECONDS), MAX_BATCH_SECONDS) / pace))

    def _take(self, cells: tuple[Cell, ...], call: Call) -> bool:
        """Save the results of ``cells`` from ``call``; return False if its worker was lost."""
        self.sent -= len(cells)
        try:
            batch = call.result()
            if not isinstance(batch, Batch):
                raise TypeError(f"a worker must return a Batch, got {type(batch).__name__}")
        except LostProcess:
            return False
        except (ValueError, OSError):
            raise
        except Exception as error:
            raise ValueError(
                f"workers must run cells, got {type(error).__name__}: {one_line(error)[:200]} "
                "(check that the scheduler runs and that workers have this longwave)"
            ) from error
        if batch.pack is not None:
            write_sealed(new_pack(self.store.folder), batch.pack, force=False)
        self.unmerged += 1
        if self.unmerged >= MERGED_COUNT:
            with suppress(OSError):  # such as a full disk: unmerged packs work as well
                merge_packs(self.store.folder)
            self.unmerged = 0
        self.state.count(batch, cells[-1].number + 1)
        self.progress(self.state)
        return True

    def _run_alone(self, cell: Cell) -> None:
        """Run a suspect cell alone; record it as failed if it loses its worker several times."""
        for _ in range(MAX_LOST_WORKERS):
            ((cells, call),) = in_turn([self._batch((cell,))], self.workers)
            if self._take(cells, call):
                return
        message = f"its worker process ended {MAX_LOST_WORKERS} times (killed, or out of memory)"
        write_pack(new_pack(self.store.folder), [CellRecord(cell.key, FAILED, message)])
        self.state.count(Batch([FAILED], 0.0, 0.0, 0.0, message), cell.number + 1)

"""Running a sweep: batches of its cells to workers, packs of what is done into a store."""

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
from longwave.runs.store_packs import FAN, PACKS, merge_packs, new_pack
from longwave.runs.sweep_cells import Batch, Cell, run_cells
from longwave.runs.sweep_workers import code_here
from longwave.support.atomic_file import write_atomically
from longwave.support.command_line import one_line
from longwave.support.processes import Call, Job, LostProcess, Workers, in_turn
from longwave.support.request_limits import current_limits
from longwave.support.sealed_file import write_sealed

if TYPE_CHECKING:
    from longwave.runs.sweep_file import Sweep

LEAST_SECONDS, MOST_SECONDS = 0.3, 3.0
"""Seconds of a batch: its pack costs 10 ms. Towards the end they are short, so that all workers
are done together."""

SHARE = 4
"""A worker's next batch is at most this part of what there is left for it."""

AHEAD = 2
"""Batches that a worker has, with the one that it is doing: it never waits for the next."""

LATE = 5
"""Batches of each worker by which the pace is told. What they held counts as so many of the cells
that were looked at beforehand, where the cells that are left are judged by those among them."""

MOST_LOSSES = 3
"""Workers that a cell may lose, alone, before it is taken to be why."""

Tell = Callable[["SweepState"], None]


@dataclass
class SweepState:
    """How far a sweep is: cells in all, found as settled, done now, and those with a fault.

    ``seconds``, ``processor_seconds``: of the cells themselves; ``worker_seconds`` of the processor
    with all that the workers did. ``first_fault`` is what the first cell with a fault was told.
    """

    cells: int
    workers: int = 1
    found: int = 0
    done: int = 0
    faults: int = 0
    seconds: float = 0.0
    processor_seconds: float = 0.0
    worker_seconds: float = 0.0
    first_fault: str = ""
    pace: float = 0.0
    """Seconds of a cell, of late."""
    expected: Mapping[int, float] = field(default_factory=dict)
    """Seconds that cells were estimated to take, of those looked at by number (`SweepCost`)."""
    beyond: int = 0
    """The number after that of the last cell that was done."""
    batches: int = 0
    late: tuple[float, float, float] = 0.0, 0.0, 0.0
    """Cells, seconds expected and taken in batches of late, after each worker's first, which loads
    code."""

    @property
    def seconds_left(self) -> float:
        """An estimate by what cells took beside what was expected of them; 0 before there are any.

        Where nothing was expected it is by the cells that were done of late.
        """
        left = self.cells - self.found - self.done
        cells, expected, taken = self.late
        if not expected:
            return left * self.pace / self.workers
        ahead = [seconds for number, seconds in self.expected.items() if number >= self.beyond]
        each = (sum(ahead) + LATE * expected / cells) / (len(ahead) + LATE)
        return left * each * taken / expected / self.workers

    def count(self, batch: Batch, beyond: int) -> None:
        """Take in what a worker did of the cells before the number ``beyond``."""
        self.done += len(batch.statuses)
        self.faults += sum(status in (REFUSED, FAILED) for status in batch.statuses)
        self.seconds += batch.seconds
        self.processor_seconds += batch.processor_seconds
        self.worker_seconds += batch.whole_processor_seconds
        self.first_fault = self.first_fault or batch.first_fault
        self.beyond = max(self.beyond, beyond)
        self.batches += 1
        if self.batches > self.workers:
            kept = 1.0 - 1.0 / (LATE * self.workers)
            new = len(batch.statuses), batch.expected, batch.seconds
            cells, expected, taken = (kept * a + b for a, b in zip(self.late, new, strict=True))
            self.late = cells, expected, taken
        mean = batch.seconds / len(batch.statuses)
        self.pace = 0.5 * (self.pace + mean) if self.pace else mean


def run_sweep(
    sweep: Sweep,
    store: RunStore,
    workers: Workers,
    progress: Tell = lambda _: None,
    state: SweepState | None = None,
    held: Container[str] | None = None,
) -> SweepState:
    """Run what the store does not hold of a sweep; all that comes to an end is in the store.

    Cells with a fault are recorded and the sweep goes on; they are run again only if they may
    succeed then. The limits that hold here hold for each cell. ``progress`` is told now and then
    how far it is, in the ``state`` that is returned. ``held`` is `RunStore.held`, if that was asked
    already. Raises OSError if the store cannot be written, and passes on Ctrl-C; what was
    done is kept then, too.
    """
    state = SweepState(len(sweep), workers.count) if state is None else state
    missing = _missing(sweep, store, store.held() if held is None else held, state)
    first = next(missing, None)
    if first is not None:  # a store that holds all of it need not be writable
        (store.folder / PACKS).mkdir(parents=True, exist_ok=True)
        with _token(store.folder) as token:
            march = _March(store, workers, state, progress, token)
            march.run(chain([first], missing))
    return state


def run_shown(
    sweep: Sweep,
    store: RunStore,
    workers: Workers,
    state: SweepState,
    held: Container[str],
    shown: tuple[Callable[[float], object], Callable[[float], object] | None],
) -> None:
    """`run_sweep`, of which the share that is done and the seconds that are left are ``shown``."""
    advance, tell = shown

    def show(state: SweepState) -> None:
        advance((state.found + state.done) / state.cells)
        if tell is not None and any(state.late):
            tell(state.seconds_left)

    run_sweep(sweep, store, workers, show, state, held)


def _missing(
    sweep: Sweep, store: RunStore, held: Container[str], state: SweepState
) -> Iterator[Cell]:
    """The cells that the store does not hold, as they are asked for; of cells with one scene the
    first."""
    given: set[str] = set()
    for number in range(len(sweep)):
        try:
            scene = sweep.scene(number)
        except ValueError as error:
            state.first_fault = state.first_fault or str(error)
            state.faults += 1
            state.found += 1
            continue
        key = store.key(scene)
        if key in given or key in held:
            state.found += 1
        else:
            given.add(key)
            yield Cell(number, key, scene)


@contextmanager
def _token(folder: Path) -> Iterator[str]:
    """A file by which workers see whether the store's folder is theirs, too."""
    name = f".{uuid.uuid4().hex}.sweep"
    write_atomically(folder / name, lambda draft: draft.write_bytes(b""), durable=False)
    try:
        yield name
    finally:
        (folder / name).unlink(missing_ok=True)


@dataclass
class _March:
    """The cells on their way through the workers."""

    store: RunStore
    workers: Workers
    state: SweepState
    progress: Tell
    token: str
    sent: int = 0
    """Cells that workers have."""
    unmerged: int = 0
    """Packs that were written since packs were merged."""

    def run(self, missing: Iterator[Cell]) -> None:
        """Run the cells in batches, and at last those that lost a worker, each alone."""
        suspects: list[Cell] = []
        for cells, call in in_turn(self._batches(missing), self.workers, ahead=AHEAD):
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
        return cells, Job(run_cells, (cells, folder, self.token, current_limits(), code_here()))

    def _size(self) -> int:
        """Cells of the next batch."""
        pace = self.state.pace
        if not pace:
            return 1
        unsent = self.state.cells - self.state.found - self.state.done - self.sent
        fair = unsent * pace / (SHARE * self.workers.count)
        return max(1, int(min(max(fair, LEAST_SECONDS), MOST_SECONDS) / pace))

    def _take(self, cells: tuple[Cell, ...], call: Call) -> bool:
        """Take in what a batch came to; whether it did not lose its worker."""
        self.sent -= len(cells)
        try:
            batch = call.result()
            if not isinstance(batch, Batch):
                raise TypeError(f"a batch must have come of them, got {type(batch).__name__}")
        except LostProcess:
            return False
        except (ValueError, OSError):
            raise
        except Exception as error:
            raise ValueError(
                f"workers must run cells, got {type(error).__name__}: {one_line(error)[:200]} "
                "(a cluster needs its scheduler, and everywhere the longwave of this machine)"
            ) from error
        if batch.pack is not None:
            write_sealed(new_pack(self.store.folder), batch.pack, force=False)
        self.unmerged += 1
        if self.unmerged >= FAN:
            with suppress(OSError):  # such as a full disk: they serve as they are
                merge_packs(self.store.folder)
            self.unmerged = 0
        self.state.count(batch, cells[-1].number + 1)
        self.progress(self.state)
        return True

    def _run_alone(self, cell: Cell) -> None:
        """Run a cell that may be why its worker was lost, some times, and give it up then."""
        for _ in range(MOST_LOSSES):
            ((cells, call),) = in_turn([self._batch((cell,))], self.workers)
            if self._take(cells, call):
                return
        told = f"its worker process ended {MOST_LOSSES} times (killed, or out of memory)"
        write_pack(new_pack(self.store.folder), [CellRecord(cell.key, FAILED, told)])
        self.state.count(Batch([FAILED], 0.0, 0.0, 0.0, told), cell.number + 1)

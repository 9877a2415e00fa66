"""Processes that each request the same runs of a store in a `FailingFolder`.

Reads one `SharedStore` for each line of JSON, and answers with the reports of its processes.
"""

from __future__ import annotations

import json
import logging
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

import longwave.runs.run_file
from longwave.runs.run_file import file_content
from longwave.runs.run_store import RunStore, check_sources
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import scene_run
from longwave.support.sealed_file import LOG, write_sealed
from tests.runs.unfinished_scenes import chain
from tests.support.failing_folder import FailingFolder

TINY = {"snapshots": [0, 2], "domain": "ring", "step": 0.5, "sites": 192, "compared": 20}


def scenes(count: int) -> list[Scene]:
    """Return tiny scenes, all different."""
    return [
        chain("tiny", observables=["strain"], eps=0.1 + 1e-5 * number, **TINY)
        for number in range(count)
    ]


@dataclass
class Report:
    """Report of one process at its end."""

    computed: list[int]
    """Numbers of the runs that it computed."""
    messages: list[str]
    """Warnings of its store, and the error that ended it."""


@dataclass
class SharedStore:
    """A store's folder, and how its processes use it."""

    folder: str
    runs: int
    locks: list[str]
    """Kind of lock of each process; see `FailingFolder`."""
    links: bool = True
    real: bool = False
    """Whether each run is computed. If not, the first one stands for all, for faster writing."""

    def ask(self) -> list[Report]:
        """Let forks of this process request all runs at once; return their reports."""
        check_sources()  # once, and not in each of them
        first = scene_run.run(scenes(1)[0])
        content = file_content(first)
        forks, ends, (gate, opened) = [], [], os.pipe()
        for number in range(len(self.locks)):
            end, start = os.pipe()
            forks.append(os.fork())
            if forks[-1] == 0:
                os.close(opened)
                os.read(gate, 1)  # until all are there
                report = self._want(number, first, content)
                os.write(start, json.dumps(vars(report)).encode())
                os._exit(0)
            os.close(start)
            ends.append(end)
        os.close(opened)
        os.close(gate)
        reports = [Report(**json.loads(_all_of(end))) for end in ends]
        for fork in forks:
            os.waitpid(fork, 0)
        return reports

    def _want(self, number: int, first: xr.Dataset, content: bytes) -> Report:
        """Fetch all runs, and write a new file into the folder after each of them."""
        report, requested, run = Report([], []), scenes(self.runs), scene_run.run
        handler = logging.Handler(logging.WARNING)
        handler.emit = lambda record: report.messages.append(record.getMessage())  # type: ignore
        LOG.addHandler(handler)

        def counted(scene: Scene, *rest: Any) -> xr.Dataset:
            report.computed.append(requested.index(scene))
            return run(scene, *rest) if self.real else first

        scene_run.run = counted
        if not self.real:
            longwave.runs.run_file.file_content = lambda _: content
        store = RunStore(self.folder)
        view = FailingFolder(self.folder, number, locks=self.locks[number], links=self.links)
        try:
            with view.seen():
                for index, scene in enumerate(requested):
                    store.fetch(scene)
                    new = Path(self.folder) / f"{number}-{index}.new"
                    write_sealed(new, str(index).encode(), force=False)
        except Exception as error:
            report.messages.append(f"{type(error).__name__}: {error}")
        return report


def _all_of(end: int) -> bytes:
    with open(end, "rb") as stream:
        return stream.read()


if __name__ == "__main__":
    for line in sys.stdin:
        print(
            json.dumps([vars(message) for message in SharedStore(**json.loads(line)).ask()]),
            flush=True,
        )

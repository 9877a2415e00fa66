"""Processes that want the same runs of a store in a `FailingFolder`, each of them all.

Reads `SharedStore` after `SharedStore` as lines of JSON, and answers each by what its processes
said.
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
    """Tiny scenes, all different."""
    return [
        chain("tiny", observables=["strain"], eps=0.1 + 1e-5 * number, **TINY)
        for number in range(count)
    ]


@dataclass
class Said:
    """What one of the processes says at its end."""

    made: list[int]
    """The runs that it made, by number."""
    told: list[str]
    """The warnings of its store, and the error that ended it."""


@dataclass
class SharedStore:
    """The store of a folder, and what is wanted of it."""

    folder: str
    runs: int
    locks: list[str]
    """Those of each process; see `FailingFolder`."""
    links: bool = True
    real: bool = False
    """Whether each run is made, or the first stands for all: more is written in a second then."""

    def ask(self) -> list[Said]:
        """Have forks of this process want all runs at once."""
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
                said = self._want(number, first, content)
                os.write(start, json.dumps(vars(said)).encode())
                os._exit(0)
            os.close(start)
            ends.append(end)
        os.close(opened)
        os.close(gate)
        said = [Said(**json.loads(_all_of(end))) for end in ends]
        for fork in forks:
            os.waitpid(fork, 0)
        return said

    def _want(self, number: int, first: xr.Dataset, content: bytes) -> Said:
        """Fetch all runs, and put a new file into the folder after each of them."""
        said, wanted, run = Said([], []), scenes(self.runs), scene_run.run
        handler = logging.Handler(logging.WARNING)
        handler.emit = lambda record: said.told.append(record.getMessage())  # type: ignore
        LOG.addHandler(handler)

        def counted(scene: Scene, *rest: Any) -> xr.Dataset:
            said.made.append(wanted.index(scene))
            return run(scene, *rest) if self.real else first

        scene_run.run = counted
        if not self.real:
            longwave.runs.run_file.file_content = lambda _: content
        store = RunStore(self.folder)
        view = FailingFolder(self.folder, number, locks=self.locks[number], links=self.links)
        try:
            with view.seen():
                for count, scene in enumerate(wanted):
                    store.fetch(scene)
                    new = Path(self.folder) / f"{number}-{count}.new"
                    write_sealed(new, str(count).encode(), force=False)
        except Exception as error:
            said.told.append(f"{type(error).__name__}: {error}")
        return said


def _all_of(end: int) -> bytes:
    with open(end, "rb") as stream:
        return stream.read()


if __name__ == "__main__":
    for line in sys.stdin:
        print(
            json.dumps([vars(said) for said in SharedStore(**json.loads(line)).ask()]), flush=True
        )

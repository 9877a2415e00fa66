"""A process with warm imports that fetches scenes from stores in forks, which can be killed.

It reads lines ``fetch SCENE FOLDER LEAST``, ``write SCENE FOLDER LEAST`` and ``keep SCENE FOLDER``,
which it answers with the fork's process number, and ``wait NUMBER``, which it answers with the exit
status.
"""

from __future__ import annotations

import os
import sys
import time
import traceback
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from tempfile import TemporaryDirectory

import xarray as xr

import longwave.runs.run_file
from longwave.cli.scene_command import run_and_print
from longwave.runs import run_output
from longwave.runs.run_store import RunStore
from tests.runs.unfinished_scenes import SCENES


def fetch(name: str, folder: str, least: str) -> int:
    try:
        RunStore(Path(folder), least=float(least), share=1e9).fetch(SCENES[name])
    except BaseException:
        traceback.print_exc()
        return 1
    return 0


def write(name: str, folder: str, least: str) -> int:
    """Run ``longwave run SCENE.toml --output FOLDER/out.nc``."""
    run_output.CHECKPOINT_PACE = float(least), 1e9
    scene = Path(folder) / "scene.toml"
    scene.write_text(SCENES[name].toml(), encoding="utf-8")
    output = str(Path(folder) / "out.nc")
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere), redirect_stderr(nowhere):
        return run_and_print(str(scene), "longwave run", output=output)


def keep(name: str, folder: str) -> int:
    """Save a large file in the store repeatedly, so that most of the time goes into writing."""
    content = memoryview(bytes(range(256)) * 80_000)
    longwave.runs.run_file.file_content = lambda _: content
    for _ in range(1000):
        RunStore(folder).keep(SCENES[name], xr.Dataset())
    return 0


def answer(*words: str) -> object:
    if words[0] == "wait":
        return os.waitstatus_to_exitcode(os.waitpid(int(words[1]), 0)[1])
    number = os.fork()
    if number == 0:
        os._exit({"fetch": fetch, "write": write, "keep": keep}[words[0]](*words[1:]))
    return number


def main(names: list[str]) -> None:
    with TemporaryDirectory() as folder:
        for name in names:
            begun = time.perf_counter()
            RunStore(Path(folder) / "first").fetch(SCENES[name])
            RunStore(Path(folder) / "second").fetch(SCENES[name])
            print(0.5 * (time.perf_counter() - begun), flush=True)
    for line in sys.stdin:
        print(answer(*line.rstrip("\n").split("\t")), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])

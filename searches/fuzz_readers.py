"""Fuzzing of the readers of users' files, guided by coverage (atheris, which is optional).

The fuzzer's bytes choose the changes that `fuzz_inputs.py` makes; a reader may raise ValueError and
nothing else.  Of what it finds, atheris leaves the bytes in a file crash-...; given again, they
repeat it.

    python -m searches.fuzz_readers [-max_total_time=60] [-runs=100000] [FILE]
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

try:
    import atheris
except ImportError:
    sys.exit("searches/fuzz_readers.py needs atheris (pip install atheris)")

with atheris.instrument_imports(
    include=[
        *("longwave.derive", "longwave.scenes"),
        "longwave.runs",
    ]
):
    from longwave.cli.certificates import read_certificates
    from longwave.derive.lattice_file import read_lattice
    from longwave.runs.run_file import load_run, scene_of_run
    from longwave.scenes.description.named_scenes import load_scene
    from longwave.scenes.fits.force_data import read_force
    from longwave.verify.problem_file import problem_texts

from searches.fuzz_inputs import KINDS

READERS: dict[str, Callable[[Path], Any]] = {
    "scene": lambda path: load_scene(str(path)),
    "lattice scene": lambda path: load_scene(str(path)),
    "lattice": read_lattice,
    "force law": read_force,
    "problem": problem_texts,
    "certificate": read_certificates,
    "run file": lambda path: scene_of_run(load_run(path)),
}

FOLDER = Path(tempfile.mkdtemp(prefix="longwave-readers-"))


class ByteRandom(Random):
    """Random numbers that are the fuzzer's bytes, and 0 behind them."""

    def __init__(self, content: bytes) -> None:
        super().__init__(0)
        self.left = content

    def getrandbits(self, k: int, /) -> int:
        """Return the next ``k`` bits."""
        size = -(-k // 8)
        taken, self.left = self.left[:size], self.left[size:]
        return int.from_bytes(taken.ljust(size, b"\0"), "big") >> (8 * size - k)

    def random(self) -> float:
        """Return a number of 0 .. 1."""
        return self.getrandbits(53) / 2**53


def read_one(content: bytes) -> None:
    """Let a reader read what these bytes choose."""
    draw = ByteRandom(content)
    kind = draw.choice(list(READERS))
    (name, text), *_ = KINDS[kind](draw).files.items()
    path = FOLDER / name
    path.write_bytes(text)
    try:
        READERS[kind](path)
    except ValueError as error:
        if "\n" in str(error).partition("\n    ")[0]:
            raise RuntimeError("an error of several lines") from error


if __name__ == "__main__":
    for make in KINDS.values():
        make(Random(0))  # seeds are made before anything is measured
    atheris.Setup(sys.argv, read_one)
    atheris.Fuzz()

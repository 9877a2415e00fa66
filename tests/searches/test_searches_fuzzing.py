"""A small part of what `searches/fuzzing.py` does at length, and the faults that it must see."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from longwave.cli.certificates import read_certificates
from longwave.derive.lattice_file import read_lattice
from longwave.runs.run_file import load_run, scene_of_run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.fits.force_data import read_force
from longwave.verify.problem_file import problem_texts
from searches import fuzz_server
from searches.fuzz_inputs import KINDS, FuzzCase

HOUSE = Path(__file__).parents[2]


def fuzzed(*words: str) -> subprocess.CompletedProcess[str]:
    """The fuzzer's end, in a process without the test's threads."""
    return subprocess.run(
        [sys.executable, "searches/fuzzing.py", *words],
        cwd=HOUSE,
        env=os.environ | {"PYTHONPATH": str(HOUSE)},
        capture_output=True,
        text=True,
        check=False,
    )


READERS = {
    "scene": load_scene,
    "lattice scene": load_scene,
    "lattice": lambda path: read_lattice(Path(path)),
    "force law": read_force,
    "problem": lambda path: problem_texts(Path(path)),
    "certificate": lambda path: read_certificates(Path(path)),
    "run file": lambda path: scene_of_run(load_run(path)),
}


@pytest.mark.parametrize(
    "kind",
    [
        *("scene", "lattice scene", "lattice", "force law", "problem"),
        *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("certificate", "run file")),
    ],
)
@settings(max_examples=20)
@given(draw=st.randoms(use_true_random=False))
def test_a_reader_refuses_with_an_error_of_its_own(
    kind: str, draw: Random, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Nothing but ValueError, and what it says is one line."""
    (name, content), *_ = KINDS[kind](draw).files.items()
    path = tmp_path_factory.mktemp("fuzz") / name
    path.write_bytes(content)
    said = ""
    try:
        READERS[kind](str(path))
    except ValueError as error:
        said = str(error)
    assert "\n" not in said.split("\n    ")[0]


@pytest.mark.slow
def test_hostile_inputs_end_within_their_limits(tmp_path: Path) -> None:
    done = fuzzed("--count", "100", "--seed", "20261122", "--keep", str(tmp_path))
    assert done.returncode == 0, done.stdout + done.stderr


def good(_: list[str]) -> int:
    Path("out.nc").write_text("as told")
    print("done")
    return 0


def announced(_: list[str]) -> int:
    print("work: about 20 s (Ctrl-C stops it)", file=sys.stderr, flush=True)
    try:
        busy(_)
    except KeyboardInterrupt:
        print("longwave: interrupted", file=sys.stderr)
    return 130


def busy(_: list[str]) -> int:
    while True:
        pass


def deaf(words: list[str]) -> int:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return announced(words)


def waiting(_: list[str]) -> int:
    time.sleep(60)
    return 0


def raising(_: list[str]) -> int:
    raise TypeError("what nobody foresaw")


def dying(_: list[str]) -> int:
    os.kill(os.getpid(), signal.SIGTERM)
    return 0


def greedy(_: list[str]) -> int:
    held = bytearray(b"x") * 150_000_000
    time.sleep(2)
    return len(held) * 0


def strange(_: list[str]) -> int:
    print("\x1b[31mred")
    return 3


def wordy(_: list[str]) -> int:
    print("error: " + "x" * 1000, file=sys.stderr)
    print("and more", file=sys.stderr)
    return 2


def untidy(_: list[str]) -> int:
    for name in ("../beside", "left", "in.toml"):
        Path(name).write_text("here")
    return 0


FAULTS = {
    good: set(),
    announced: set(),
    busy: {"slow"},
    deaf: {"Ctrl-C"},
    waiting: {"hangs"},
    raising: {"traceback"},
    dying: {"died"},
    greedy: {"memory"},
    strange: {"signs", "status"},
    wordy: {"long", "lines"},
    untidy: {"left behind", "overwritten", "wrote elsewhere"},
}


@pytest.mark.slow
@pytest.mark.parametrize("command", FAULTS, ids=lambda command: command.__name__)
def test_every_fault_is_seen(
    command: Callable[[list[str]], int], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in {
        "SECONDS": 1.5,
        "MEGABYTES": 100.0,
        "AFTER_ANNOUNCEMENT": 0.05,
        "END_SECONDS": 0.2,
        "STILL": 0.5,
    }.items():
        monkeypatch.setattr(fuzz_server, name, value)
    case = FuzzCase("test", ("run", "in.toml", "--output", "out.nc"), {"in.toml": b"eps = 1"})
    with fuzz_server.FuzzServer(command) as server:
        ending = server.ending(case)
    assert ending.kinds == FAULTS[command], ending
    assert ending.announced == (command in (announced, deaf))

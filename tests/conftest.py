"""Settings shared by all tests: fixed seeds, no display, floating-point traps on."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from tests.process_state import changed, process_state

settings.register_profile(
    "longwave",
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("longwave")


PATIENCE = 600.0
"""Seconds that end a test that hangs, and none that a loaded machine makes wait."""


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same in every run."""
    return np.random.default_rng(20260101)


@pytest.fixture(autouse=True)
def _floating_point_traps() -> Iterator[None]:
    """Overflow, division by zero and NaN raise in NumPy instead of passing silently."""
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        yield


@pytest.fixture(autouse=True)
def _process_left_as_it_was() -> Iterator[None]:
    """A test puts back what it changes of its process: no outcome depends on those before it."""
    before = process_state()
    yield
    assert not changed(before, process_state())


@pytest.fixture
def dask_cluster() -> Iterator[Any]:
    """Two Dask workers of one thread each, on this machine alone."""
    distributed = pytest.importorskip("distributed")
    ours = dict(os.environ)  # which its nannies change
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        host="127.0.0.1",
        dashboard_address="127.0.0.1:0",
    ) as cluster:
        yield cluster
    os.environ.clear()
    os.environ.update(ours)


@dataclass(frozen=True)
class Stopped:
    """A command after Ctrl-C: what it announced, what it said then, and the seconds of a processor
    that it took to its end."""

    status: int
    announced: str
    out: str
    errors: str
    seconds: float


def spent() -> float:
    """Seconds of a processor of all children that have ended."""
    usage = os.times()
    return usage.children_user + usage.children_system


def spent_by(process: int) -> float:
    """Those of a running process and of its children, dead and alive; 0 if there is none."""
    try:
        stat = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2]
        children = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8")
    except OSError:
        return 0.0
    own = sum(map(int, stat.split()[11:15])) / os.sysconf("SC_CLK_TCK")
    return own + sum(spent_by(int(child)) for child in children.split())


@pytest.fixture
def press_ctrl_c() -> Callable[..., Stopped]:
    """``press_ctrl_c(words, seconds)``: ``python -m words``, stopped after its first line, when it
    has taken so many more seconds of a processor: on a loaded machine it is as far then. Another
    ``number`` is of another signal."""

    def stopped(words: list[str], seconds: float, number: int = signal.SIGINT) -> Stopped:
        running = subprocess.Popen(
            [sys.executable, "-m", *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=Path(__file__).parents[1],
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        assert running.stderr is not None
        try:
            announced = running.stderr.readline()
            while re.search("(so far|left) .Ctrl-C", announced):  # a loaded machine has to say so
                announced = running.stderr.readline()
            before, end = spent_by(running.pid), time.monotonic() + PATIENCE
            while running.poll() is None and time.monotonic() < end:
                if spent_by(running.pid) >= before + seconds:
                    break
                time.sleep(0.02)
            begun = spent() + spent_by(running.pid)
            running.send_signal(number)
            out, errors = running.communicate(timeout=PATIENCE)
        finally:
            running.kill()
        return Stopped(running.returncode, announced, out, errors, spent() - begun)

    return stopped


@pytest.fixture
def interrupt() -> Callable[[list[str], float, Path], Stopped | None]:
    """``interrupt(words, seconds, folder)``: stopped after so long; None if it had ended by then.

    The terminal sends the signal to all processes of a command; so does this.
    """

    def stopped(words: list[str], seconds: float, folder: Path) -> Stopped | None:
        running = subprocess.Popen(
            [sys.executable, "-m", *words],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        )
        try:
            running.communicate(timeout=seconds)
            return None
        except subprocess.TimeoutExpired:
            begun = spent() + spent_by(running.pid)
            os.killpg(running.pid, signal.SIGINT)
            out, errors = running.communicate(timeout=PATIENCE)
        finally:
            running.kill()
        return Stopped(running.returncode, "", out, errors, spent() - begun)

    return stopped

"""Catches: a run whose records Ctrl-C loses, or one that claims an estimate nobody measured."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from verify.lattice.restart import load_run

HOUSE = Path(__file__).parents[3]

LONG = """
wave = "soliton_sech"
eps = 0.05
t0 = 0
snapshots = [0, 1, 3e6]
observables = ["strain"]
[parameters]
A = 1
[lattice]
K2 = 1
K4 = 1
[scheme]
step = 0.5
[domain]
kind = "window"
sites = 4096
compared = 100
"""


@pytest.mark.slow
def test_ctrl_c_keeps_the_snapshots_recorded(tmp_path: Path) -> None:
    scene, output = tmp_path / "long.toml", tmp_path / "run.nc"
    scene.write_text(LONG)
    running = subprocess.Popen(
        [sys.executable, "-m", "verify", "run", str(scene), "--output", str(output)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=HOUSE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert running.stderr is not None
    try:
        announced = running.stderr.readline()
        time.sleep(8.0)
        running.send_signal(signal.SIGINT)
        begun = time.perf_counter()
        out, errors = running.communicate(timeout=30)
    finally:
        running.kill()
    assert time.perf_counter() - begun < 4.0
    assert running.returncode == 130
    assert announced.startswith("long: about ")
    assert errors.splitlines() == [
        f"python -m verify run: interrupted (2 snapshots are kept in {output})"
    ]
    assert "unfinished: Ctrl-C after t = " in out
    run = load_run(output)
    assert list(run["time"].values) == [0.0, 1.0]
    assert run["strain"].shape == (2, 201)
    assert "error_estimate" not in run.attrs

"""Catches: a run whose snapshots Ctrl-C loses, or that has an estimate nobody measured."""

import signal
from pathlib import Path
from typing import Any

import pytest

from longwave.runs import load_run

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
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_ctrl_c_keeps_the_snapshots_recorded(
    number: int, status: int, tmp_path: Path, press_ctrl_c: Any
) -> None:
    """SIGTERM, with which a cluster ends a long job, does the same."""
    scene, output = tmp_path / "long.toml", tmp_path / "run.nc"
    scene.write_text(LONG)
    done = press_ctrl_c(["longwave", "run", str(scene), "--output", str(output)], 8.0, number)
    assert done.seconds < 4.0
    assert done.status == status
    assert done.announced.startswith("long: about ")
    assert done.errors.splitlines() == [
        f"longwave run: interrupted (2 snapshots are kept in {output}; repeat the command with "
        "--force to resume)"
    ]
    assert "unfinished: Ctrl-C after t = " in done.out
    run = load_run(output)
    assert list(run["time"].values) == [0.0, 1.0]
    assert run["strain"].shape == (2, 201)
    assert "error_estimate" not in run.attrs

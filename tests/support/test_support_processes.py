"""Jobs in processes: results under their keys, progress rises to 1, failures reach the caller."""

import subprocess
import sys
from contextlib import suppress
from dataclasses import replace
from math import sqrt
from pathlib import Path

import pytest

from longwave.reports.studies.measured_runs import scene_job
from longwave.scenes.chain import run
from longwave.scenes.named_scenes import load_scene
from longwave.scenes.scene import Scene
from longwave.support.processes import Job, OutOfTime, pool_context, run_jobs, time_limit

SHORT = replace(
    load_scene("rational_2_eps_0.05"),
    snapshots=(-10000.0, -9999.0),
    observables=("strain",),
)


def test_results_come_back_under_their_keys_with_rising_progress() -> None:
    """Catches results mixed up by the order of the work, which is the longest first."""
    longer = replace(SHORT, snapshots=(-10000.0, -9995.0))
    jobs = {"short": scene_job(SHORT), "root": Job(sqrt, (2.25,), 0.1), "long": scene_job(longer)}
    assert jobs["long"].weight > jobs["short"].weight
    shares: list[float] = []
    found = run_jobs(jobs, 2, shares.append)
    assert list(found) == ["short", "root", "long"]
    assert found["root"] == 1.5
    assert [float(found[name].time[-1]) for name in ("short", "long")] == [-9999.0, -9995.0]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert (found["short"]["strain"].values == run(SHORT)["strain"].values).all()


def test_a_failing_job_raises_here() -> None:
    wrong: Scene = replace(SHORT, wave="no_such_wave")
    with pytest.raises(ValueError, match="no_such_wave"):
        run_jobs({"wrong": scene_job(wrong)}, 1, lambda share: None)


def test_at_least_one_worker() -> None:
    with pytest.raises(ValueError, match="workers must be at least 1, got 0"):
        run_jobs({"short": scene_job(SHORT)}, 0, lambda share: None)


def test_what_loses_the_limit_does_not_get_away_with_it() -> None:
    def loses_it() -> None:
        with suppress(OutOfTime):  # as a finalizer does
            while True:
                pass

    with pytest.raises(OutOfTime), time_limit(0.05, passing=True):
        loses_it()


ENDED = """
import os
from concurrent.futures import ProcessPoolExecutor
from longwave.support.processes import ignore_interrupt, pool_context
if __name__ == "__main__":
    pool = ProcessPoolExecutor(1, pool_context(), ignore_interrupt)
    pool.submit(abs, -1).result()
    for worker in pool._processes.values():
        worker.kill()
    os._exit(130)
"""


def test_a_command_ended_over_its_pool_leaves_no_warning(tmp_path: Path) -> None:
    script = tmp_path / "ended.py"
    script.write_text(ENDED)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (130, "")


def test_workers_warn_as_ever() -> None:
    before = sys.warnoptions[:]
    pool_context()
    assert sys.warnoptions == before

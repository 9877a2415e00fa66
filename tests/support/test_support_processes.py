"""Jobs in processes: results, progress, failures, limits; killed processes and commands."""

import gc
import os
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from math import sqrt
from pathlib import Path

import pytest

from longwave.reports.studies.measured_runs import scene_job
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.support.processes import (
    Cancelled,
    Job,
    LocalWorkers,
    LostProcess,
    OutOfTime,
    as_ended,
    in_order,
    run_apart,
    run_jobs,
    run_program,
    time_limit,
)
from tests.support.process_jobs import endless, killed, sleeping

SHORT = replace(
    load_scene("rational_2_eps_0.05"),
    snapshots=(-10000.0, -9999.0),
    observables=("strain",),
)


@pytest.mark.slow
def test_results_come_back_under_their_keys_with_rising_progress() -> None:
    """Catches: results mixed up by the order of the work, the longest job first."""
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


def test_code_that_swallows_the_limit_is_still_stopped() -> None:
    def loses_it() -> None:
        with suppress(OutOfTime):  # as a finalizer does
            while True:
                pass

    with pytest.raises(OutOfTime), time_limit(0.05, passing=True):
        loses_it()


ENDED = """
import os
from longwave.support.processes import Job, LocalWorkers
if __name__ == "__main__":
    workers = LocalWorkers(1)
    workers.submit(Job(abs, (-1,)))
    assert [call.value for call in workers.ended(60.0)] == [1]
    workers._workers[0].process.kill()
    os._exit(130)
"""


def test_a_command_ended_over_its_pool_leaves_no_warning(tmp_path: Path) -> None:
    script = tmp_path / "ended.py"
    script.write_text(ENDED)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (130, "")


def is_there(process: int) -> bool:
    """Return whether a process exists and is not a zombie."""
    try:
        status = Path(f"/proc/{process}/stat").read_text("ascii")
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.parametrize("apart", [False, True])
def test_a_lost_process_costs_its_own_job_alone(apart: bool) -> None:
    jobs = [Job(sqrt, (4.0,)), Job(killed), Job(sqrt, (9.0,)), Job(sqrt, (-1.0,))]
    ended = dict(as_ended(enumerate(jobs), LocalWorkers(1, isolated=apart)))
    assert [ended[place].value for place in (0, 2)] == [2.0, 3.0]
    assert isinstance(ended[1].error, LostProcess)
    assert isinstance(ended[3].error, ValueError)


def test_queued_jobs_of_a_lost_process_go_to_another() -> None:
    workers, found = LocalWorkers(1), []
    try:
        calls = [workers.submit(job) for job in (Job(killed), Job(sqrt, (4.0,)))]
        while len(found) < 2:
            found += workers.ended(60.0)
    finally:
        workers.stop()
    assert found == calls
    assert (type(calls[0].error), calls[1].value) == (LostProcess, 2.0)


@pytest.mark.slow
def test_past_its_seconds_a_job_is_killed_with_what_it_started(tmp_path: Path) -> None:
    call = run_apart(Job(sleeping, (tmp_path / "number", 100.0), seconds=4.0))
    assert isinstance(call.error, OutOfTime)
    program = int((tmp_path / "number").read_text())
    wait_until(lambda: not is_there(program))


def test_past_its_seconds_a_job_is_killed_and_its_process_replaced() -> None:
    jobs = [Job(time.sleep, (1000.0,), seconds=0.5), Job(sqrt, (4.0,))]
    ended = dict(as_ended(enumerate(jobs), LocalWorkers(1)))
    assert (type(ended[0].error), ended[1].value) == (OutOfTime, 2.0)


def test_a_program_returns_its_output_or_is_killed(tmp_path: Path) -> None:
    command = ["sh", "-c", "pwd; echo wrong >&2; exit 3"]
    assert run_program(command, tmp_path, 60.0) == (3, f"{tmp_path}\nwrong\n")
    with pytest.raises(OutOfTime):
        run_program(["sleep", "100"], tmp_path, 0.2)


def test_memory_is_limited() -> None:
    """Catches: a limit of which the process's own thread takes a part."""
    fits, swells = (
        run_apart(Job(lambda size: len(bytearray(size)), (size,), memory=10**8))
        for size in (95 * 10**6, 10**9)  # what a process frees it may take again
    )
    assert fits.error is None
    assert isinstance(swells.error, MemoryError)


def test_messages_survive_a_lost_process() -> None:
    def tells(tell: Callable[[str], None]) -> None:
        tell("first")
        tell("second")
        killed()

    call = run_apart(Job(tells, tells=True))
    assert (call.message, type(call.error)) == ("second", LostProcess)


def test_a_job_gives_way_to_the_next() -> None:
    workers = LocalWorkers(1)
    try:
        older = workers.submit(Job(endless, tells=True, gives_way=True))
        wait_until(lambda: not workers.ended(0.0) and older.message == 0.5)
        newest = workers.submit(Job(sqrt, (4.0,)))
        ended = workers.ended(60.0)
        while newest not in ended:
            ended += workers.ended(60.0)
    finally:
        workers.stop()
    assert ended == [older, newest]
    assert isinstance(older.error, Cancelled)
    assert newest.value == 2.0


def test_results_keep_the_order_of_their_jobs() -> None:
    jobs = [Job(time.sleep, (0.3,)), Job(abs, (-1,)), Job(abs, (-2,))]
    assert list(in_order(jobs, LocalWorkers(2, isolated=True))) == [None, 1, 2]


def test_an_error_contains_its_traceback() -> None:
    def fails() -> None:
        raise ValueError("wrong")

    call = run_apart(Job(fails))
    assert isinstance(call.error, ValueError)
    assert "in fails" in call.error.__notes__[0]


def test_an_unpicklable_result_is_an_error() -> None:
    call = run_apart(Job(lambda: lambda: None))
    assert isinstance(call.error, RuntimeError)


PARENT = """
import sys
from pathlib import Path
from longwave.support.processes import Job, LocalWorkers
from tests.support.process_jobs import sleeping
if __name__ == "__main__":
    workers = [LocalWorkers(1), LocalWorkers(1, isolated=True), LocalWorkers(1, isolated=True)]
    for place, one in enumerate(workers):
        one.submit(Job(sleeping, (Path(sys.argv[1]) / str(place), 100.0)))
    workers[0].ended(100.0)
"""


def test_processes_and_what_they_started_end_with_a_command_that_is_killed(tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    house = str(Path(__file__).parents[2])
    given = [sys.executable, str(script), str(tmp_path)]
    files = [tmp_path / str(place) for place in range(3)]
    with subprocess.Popen(given, env={**os.environ, "PYTHONPATH": house}) as command:
        wait_until(lambda: all(file.exists() for file in files))
        command.kill()
    programs = [int(file.read_text()) for file in files]
    wait_until(lambda: not any(map(is_there, programs)))


class Garbage:
    """Object in a cycle, freed only by a collection, that reports its end."""

    def __init__(self, file: Path) -> None:
        self.file, self.me = file, self

    def __del__(self) -> None:
        self.file.write_text(str(os.getpid()), encoding="utf-8")


def test_a_fork_does_not_collect_its_parents_garbage(tmp_path: Path) -> None:
    """Catches: a fork that closes a cluster's client, waiting for a thread that it lacks."""
    file = tmp_path / "ended"
    gc.disable()
    try:
        Garbage(file)
        (found,) = in_order([Job(gc.collect)], LocalWorkers(1, isolated=True))
        assert isinstance(found, int)
        assert not file.exists()
    finally:
        gc.enable()
    gc.collect()
    assert file.read_text(encoding="utf-8") == str(os.getpid())


def test_a_process_takes_no_standard_library_from_the_folder_it_starts_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a planted module that runs in every process of a sweep."""
    (tmp_path / "pickle.py").write_text("open('planted', 'w').close()\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    workers = LocalWorkers(1)
    try:
        workers.submit(Job(len, ("abc",)))
        (call,) = workers.ended(60.0)
    finally:
        workers.stop()
    assert call.value == 3
    assert not (tmp_path / "planted").exists()
    assert "PYTHONSAFEPATH" not in os.environ

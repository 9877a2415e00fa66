"""Statements decided on a local Dask cluster, one of whose workers is killed."""

import os
import signal
from typing import Any

import pytest

from longwave.cli import statements
from longwave.support.dask_cluster import _outcome
from longwave.support.processes import Job
from longwave.verify.problem_file import StatedProblem
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.typed_statement import Statement
from longwave.verify.verdict import Outcome

KDV = "u_t + 6*u*u_x + u_xxx"


def soliton(speed: int) -> Statement:
    solution = f"u = 2*k**2*sech(k*(x - {speed}*k**2*t))**2"
    return read_statement([KDV], [solution], "k: k>0", "")


def job(statement: Statement, limit: float) -> Job:
    given = (statement, limit, 0.0)
    return Job(
        statements._decide_in_worker,
        given,
        tells=True,
        seconds=limit + 1.0,
        memory=statements.MOST_MEMORY,
    )


@pytest.mark.slow
def test_a_cluster_job_keeps_the_limit_of_its_statement() -> None:
    _, found, error = _outcome(job(soliton(4), 0.01))
    assert error is None
    assert found.outcome is Outcome.UNDECIDED
    assert "no verdict within 0.01 s" in found.detail


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning:distributed", "ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_cluster_gives_every_verdict_though_a_worker_is_killed(dask_cluster: Any) -> None:
    speeds = [4, 2, 4, 3, 4, 5]
    problems = [StatedProblem(soliton(speed)) for speed in speeds]
    verdicts = statements._decide_here_or_on_cluster(
        problems, 60.0, 0.0, dask_cluster.scheduler_address
    )
    found = [next(verdicts)]
    os.kill(dask_cluster.workers[0].process.process.pid, signal.SIGKILL)
    found += verdicts
    assert sorted(place for place, _ in found) == list(range(len(speeds)))
    for place, verdict in found:
        assert verdict.outcome is (Outcome.PROVED if speeds[place] == 4 else Outcome.REFUTED)
    proved = next(verdict for place, verdict in found if place == 0)
    assert proved.certificates


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning:distributed", "ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_workers_that_prove_by_another_code_are_refused(
    dask_cluster: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(statements, "source_digest", lambda module: "of other sources")
    problems = [StatedProblem(soliton(4))]
    with pytest.raises(ValueError, match="sources and packages of this machine, got other ones on"):
        statements._decide_here_or_on_cluster(problems, 60.0, 0.0, dask_cluster.scheduler_address)

"""Catches: an answer of a hostile worker that ends the command, or takes more than a line."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from queue import SimpleQueue
from types import SimpleNamespace
from typing import Any

import pytest

from longwave.support.dask_cluster import DaskWorkers, _connected, _outcome
from longwave.support.processes import Job, OutOfTime

distributed = pytest.importorskip("distributed")


class Answers:
    """Client of a cluster whose workers return these answers."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def nthreads(self) -> dict[str, int]:
        return {"tcp://somewhere:1": 1}

    def submit(self, *_: Any, **__: Any) -> Any:
        def result() -> Any:
            if isinstance(self.answer, BaseException):
                raise self.answer
            return self.answer

        return SimpleNamespace(add_done_callback=lambda done: done(None), result=result)


def workers_of(client: Any) -> DaskWorkers:
    made = object.__new__(DaskWorkers)
    made._client, made._futures, made._answered = client, {}, SimpleQueue()
    made._looked, made._are_gone, made.count = 0.0, False, 1
    return made


@pytest.mark.parametrize(
    "answer",
    [None, 3, (1, 2), (None, 1, SystemExit(0)), (None, 1, KeyboardInterrupt()), SystemExit(0)],
)
def test_an_invalid_answer_is_the_jobs_error(answer: Any) -> None:
    """An error raised here must not end the process, as SystemExit would."""
    workers = workers_of(Answers(answer))
    workers.submit(Job(len, ("",)))
    (call,) = workers.ended(1.0)
    assert isinstance(call.error, TypeError)
    assert "a worker must answer with an outcome, got" in str(call.error)


def test_a_scheduler_lost_during_the_count_fails_every_call() -> None:
    """A lost scheduler caused a traceback when the count noticed it."""
    client = Answers((None, 1, None))
    workers = workers_of(client)
    workers.submit(Job(len, ("",)))
    lost = OSError("Timed out trying to connect")
    client.nthreads = lambda: (_ for _ in ()).throw(lost)  # type: ignore[method-assign]
    (call,) = workers.ended(1.0)
    assert call.error is lost


def test_workers_import_nothing_from_their_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a planted module that runs in the process of a job with limits."""
    for name in ("pickle.py", "longwave.py"):
        (tmp_path / name).write_text("open('planted', 'w').close()\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    assert _outcome(Job(len, ("abc",), seconds=60.0))[1:] == (3, None)
    assert not (tmp_path / "planted").exists()


def test_valid_outcomes_are_returned_unchanged() -> None:
    for error in (None, ValueError("a reason"), OutOfTime()):
        workers = workers_of(Answers(("told", 3, error)))
        workers.submit(Job(len, ("",)))
        (call,) = workers.ended(1.0)
        assert (call.message, call.value, call.error) == ("told", 3, error)


def test_workers_that_do_not_report_their_code_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    closed: list[Any] = []
    client = SimpleNamespace(close=lambda **_: closed.append(1))
    monkeypatch.setattr("longwave.support.dask_cluster._connected", lambda *_: client)

    def check(_: Any) -> None:
        raise TypeError("'int' object is not\nsubscriptable")

    with pytest.raises(ValueError, match=r"^--scheduler must have workers that report[^\n]*$"):
        DaskWorkers("tcp://127.0.0.1:1", "", check)
    assert closed


def test_encryption_without_certificates_is_reported() -> None:
    with pytest.raises(ValueError, match=r"^--scheduler must be the address[^\n]*tls[^\n]*$"):
        _connected("tls://127.0.0.1:9", "")


@pytest.mark.slow
def test_a_cluster_can_use_tls(tmp_path: Path) -> None:
    """With the certificates that Dask's own configuration names."""
    from dask import config
    from distributed.security import Security

    key, certificate = tmp_path / "key.pem", tmp_path / "certificate.pem"
    words = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1"]
    words += ["-subj", "/CN=longwave", "-keyout", str(key), "-out", str(certificate)]
    subprocess.run(words, check=True, capture_output=True)
    tls = {"distributed.comm.tls.ca-file": str(certificate)}
    for role in ("client", "scheduler", "worker"):
        tls |= {f"distributed.comm.tls.{role}.key": str(key)}
        tls |= {f"distributed.comm.tls.{role}.cert": str(certificate)}
    ours = dict(os.environ)
    with config.set(tls):
        cluster = distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, protocol="tls://",
            security=Security(), dashboard_address="127.0.0.1:0",
        )  # fmt: skip
        with cluster:
            assert cluster.scheduler_address.startswith("tls://")
            client = _connected(cluster.scheduler_address, "longwave:__version__")
            assert client.submit(len, "four").result() == 4
            client.close()
    os.environ.clear()
    os.environ.update(ours)

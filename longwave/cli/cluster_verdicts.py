"""Statements decided on a Dask cluster: each in an interpreter of its own beside the worker.

A worker has threads, and may be no parent by `multiprocessing`'s rules; a new interpreter has the
limits of `longwave prove` itself, and ends by them if the worker is killed.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from longwave.support.compiled.source_digest import all_sources, text_digest
from longwave.support.dask_cluster import connect
from longwave.verify.problem_file import StatedProblem
from longwave.verify.proof.statement_verdict import StatementVerdict, undecided
from longwave.verify.proof.typed_statement import Statement

BEGINNING = 60.0
"""Seconds for the interpreter to begin and to end, beyond the limit of its statement."""


def decided_on_cluster(
    problems: Sequence[StatedProblem], limit: float, hinting: float, scheduler: str
) -> Iterator[tuple[int, StatementVerdict]]:
    """As `cli.statements.decided`, on the workers of a cluster.

    A statement whose worker is lost is decided again by another; one that loses several is
    undecided. Raises ValueError where the cluster does not answer, and where a worker would decide
    by another code than this process.
    """
    client = connect(scheduler, f"{__name__}:{proof_digest.__name__}")
    try:
        for worker, digest in client.run(proof_digest).items():
            if digest != proof_digest():
                raise ValueError(
                    "--scheduler must be of workers that prove by the sources and packages of "
                    f"this machine, got other ones on {worker} (install the same there, or start "
                    "it again where sources changed)"
                )
        from distributed import KilledWorker, as_completed

        sent = {
            client.submit(decide_apart, problem.statement, limit, hinting, pure=False): place
            for place, problem in enumerate(problems)
        }
        for future in as_completed(list(sent), loop=client.loop):
            place = sent[future]
            try:
                yield place, future.result()
            except KilledWorker:
                why = "the cluster lost several workers that were to decide it"
                yield place, undecided(problems[place].statement, why)
            except Exception as error:  # its scheduler is lost, say; what is decided is told
                why = f"the cluster ended before it was decided ({type(error).__name__})"
                yield place, undecided(problems[place].statement, why)
    finally:
        client.close()


def proof_digest() -> str:
    """The digest (hexadecimal) of the sources and versions that a verdict follows from."""
    return text_digest(all_sources(("longwave.cli.statements",)))


def decide_apart(statement: Statement, limit: float, hinting: float) -> StatementVerdict:
    """The verdict on a statement, by a new interpreter that ends at the limits."""
    house = str(Path(__file__).absolute().parents[3])
    paths = [house, *filter(None, [os.environ.get("PYTHONPATH")])]
    try:
        done = subprocess.run(
            [sys.executable, "-m", __name__],
            input=pickle.dumps((statement, limit, hinting)),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            timeout=limit + BEGINNING,
            check=True,
        )
        verdict: StatementVerdict = pickle.loads(done.stdout)
    except (subprocess.SubprocessError, pickle.UnpicklingError, EOFError) as error:
        return undecided(statement, f"the process broke off ({type(error).__name__})")
    return verdict


def main() -> None:
    """Read a statement with its limits, decide it, and write the verdict."""
    from longwave.cli.statements import decided

    statement, limit, hinting = pickle.load(sys.stdin.buffer)
    for _, verdict in decided([StatedProblem(statement)], limit, 1, hinting):
        sys.stdout.buffer.write(pickle.dumps(verdict))


if __name__ == "__main__":
    main()

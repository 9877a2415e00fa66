"""Whether a worker runs the code that the keys of its cells are of."""

from __future__ import annotations

import socket
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

from longwave.runs.run_store import code_that_matters
from longwave.support.provenance import changed_parts, provenance

if TYPE_CHECKING:
    from distributed import Client

DIGEST = "digest"

TOLD = ("code", "versions")
"""Parts of `provenance` that say in what codes differ."""

LONGEST = 200
"""Characters of that."""


@lru_cache
def code_here() -> Mapping[str, str]:
    """What this process computes runs by, and the digest of it that is in their keys."""
    made = provenance()
    return {DIGEST: code_that_matters()} | {name: made[name] for name in TOLD}


def check_code(asked: Mapping[str, str]) -> None:
    """Raise ValueError if this process would make other runs than the keys of ``asked`` say."""
    _check(asked, code_here(), socket.gethostname())


def check_cluster(client: Client) -> None:
    """Raise ValueError if a worker of the cluster would make other runs than this process."""
    for address, there in client.run(code_here).items():
        _check(code_here(), there, address)


def _check(asked: Mapping[str, str], there: Mapping[str, str], where: str) -> None:
    if there[DIGEST] == asked[DIGEST]:
        return
    lines = [line for name in TOLD for line in changed_parts(name, asked[name], there[name])]
    told = "; ".join(lines).replace(", was ", ", here ")
    raise ValueError(
        f"workers must have the longwave and the packages of this machine, whose digest is in the "
        f"keys of runs, got {where} with {told[:LONGEST]} (install the same there, or start again "
        "where sources changed)"
    )

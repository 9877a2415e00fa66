"""A Dask cluster by the address of its scheduler; `dask.distributed` comes with an extra."""

import logging
from pkgutil import resolve_name
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from distributed import Client

CONNECTING = 5.0
"""Seconds in which a scheduler must answer."""


def connect(address: str, needed: str) -> "Client":
    """A client of the cluster, to be closed, whose workers have what is ``needed``, MODULE:NAME.

    Raises ValueError in one line where `dask.distributed` is not installed, where no scheduler
    answers and where a worker has no longwave: it would end by the first task.
    """
    try:
        from distributed import Client
    except ImportError:
        raise ValueError(
            "--scheduler needs dask.distributed, got none (pip install 'longwave[cluster]')"
        ) from None
    try:
        client = Client(address, timeout=CONNECTING, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        why = " ".join(str(error).split())[:100]
        raise ValueError(
            f"--scheduler must be the address of a Dask scheduler that answers within "
            f"{CONNECTING:g} s, got {address[:100]}: {why} (such as tcp://127.0.0.1:8786)"
        ) from None
    for name in ("client", "utils"):  # where a lost scheduler is a traceback, which callers tell
        logging.getLogger(f"distributed.{name}").setLevel(logging.CRITICAL)
    for worker, found in client.run(resolve_name, needed, on_error="return").items():
        if isinstance(found, Exception):
            client.close()
            raise ValueError(
                f"--scheduler must be of workers that have this longwave, got {worker}: "
                f"{type(found).__name__}: {str(found)[:100]} (install it there)"
            )
    return client

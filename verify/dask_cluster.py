"""A Dask cluster by the address of its scheduler; `dask.distributed` comes with an extra."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from distributed import Client

CONNECTING = 5.0
"""Seconds in which a scheduler must answer."""


def connect(address: str) -> "Client":
    """A client of the cluster, to be closed.

    Raises ValueError in one line where `dask.distributed` is not installed and where no scheduler
    answers.
    """
    try:
        from distributed import Client
    except ImportError:
        raise ValueError(
            "--scheduler needs dask.distributed, got none (pip install 'longwave[cluster]')"
        ) from None
    try:
        return Client(address, timeout=CONNECTING, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        why = " ".join(str(error).split())[:100]
        raise ValueError(
            f"--scheduler must be the address of a Dask scheduler that answers within "
            f"{CONNECTING:g} s, got {address[:100]}: {why} (such as tcp://127.0.0.1:8786)"
        ) from None

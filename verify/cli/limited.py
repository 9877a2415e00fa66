"""Work under a limit of time and memory: the last line of defence against hostile input.

The checker counts before it works (`verify.proof.checker.limits`); this ends what would slip
through, in a process of its own.
"""

from __future__ import annotations

import contextlib
import os
import signal
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from verify.proof import CertificateError

SECONDS, BYTES = 5, 500_000_000


def limited(work: Callable[[], str]) -> str:
    """What ``work`` returns; its CertificateError, or one that says that it took too much.

    Where processes cannot be forked, ``work`` is done without limits.
    """
    if not hasattr(os, "fork"):
        return work()
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # threads elsewhere; the child has one
        child = os.fork()
    if child == 0:
        os.close(reading)
        _work_and_exit(work, writing)
    os.close(writing)
    with os.fdopen(reading, encoding="utf-8") as pipe:
        text = pipe.read()
    _, status = os.waitpid(child, 0)
    if os.WIFEXITED(status) and os.WEXITSTATUS(status) == 0:
        return text
    raise CertificateError(text or f"it took more than {SECONDS} s or {BYTES // 10**6} MB")


def _work_and_exit(work: Callable[[], str], writing: int) -> NoReturn:
    status, text = 1, ""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # where FLINT says that memory is short
        _set_limits()
        text = work()
        status = 0
    except CertificateError as error:
        text = str(error)
    except BaseException:
        text = ""
    finally:
        with contextlib.suppress(OSError), os.fdopen(writing, "w", encoding="utf-8") as pipe:
            pipe.write(text)
        os._exit(status)


def _set_limits() -> None:
    import resource  # where there is fork

    signal.signal(signal.SIGXCPU, signal.SIG_DFL)
    with contextlib.suppress(OSError, ValueError):
        usage = resource.getrusage(resource.RUSAGE_SELF)
        used = int(usage.ru_utime + usage.ru_stime)
        resource.setrlimit(resource.RLIMIT_CPU, (used + SECONDS, used + SECONDS + 1))
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + BYTES
        resource.setrlimit(resource.RLIMIT_AS, (most, most))

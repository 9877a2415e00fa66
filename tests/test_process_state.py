"""The watch over what tests leave behind."""

import locale
import os
import resource
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import mpmath
import numpy as np
import pytest

from longwave.support.compiled import cores
from tests.process_state import changed, process_state

Patch = pytest.MonkeyPatch


CHANGES: dict[str, Callable[[Patch], Any]] = {
    "environment: LONGWAVE_LEFT": lambda patch: patch.setenv("LONGWAVE_LEFT", "1"),
    "environment: PATH": lambda patch: patch.delenv("PATH"),
    "folder": lambda patch: patch.chdir(Path(os.sep)),
    "arguments": lambda patch: patch.setattr(sys, "argv", ["longwave"]),
    "import path": lambda patch: patch.setattr(sys, "path", ["elsewhere", *sys.path]),
    "exception hooks": lambda patch: patch.setattr(sys, "excepthook", print),
    "mpmath's precision": lambda patch: patch.setattr(mpmath.mp, "dps", 40),
    "usable cores": lambda patch: patch.setattr(cores, "is_worker", lambda: True),
    "Matplotlib's settings: font.size": lambda patch: patch.setitem(mpl.rcParams, "font.size", 23),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_that_is_left_is_named(name: str, monkeypatch: Patch) -> None:
    monkeypatch.setattr(cores, "_alone", False)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1}, raising=False)
    before = process_state()
    with monkeypatch.context() as patch:
        CHANGES[name](patch)
        assert changed(before, process_state()) == [name]
    assert changed(before, process_state()) == []


def test_signals_traps_limits_and_the_locale_are_looked_at(monkeypatch: Patch) -> None:
    before = process_state()
    kept = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    file_size = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        assert changed(before, process_state()) == ["signal handlers: SIGTERM"]
        resource.setrlimit(resource.RLIMIT_FSIZE, (10**9, file_size[1]))
        assert "limits: RLIMIT_FSIZE" in changed(before, process_state())
    finally:
        signal.signal(signal.SIGTERM, kept)
        resource.setrlimit(resource.RLIMIT_FSIZE, file_size)
    with np.errstate(under="raise"), np.printoptions(precision=3):
        expected = ["NumPy's floating-point traps: under", "NumPy's printing: precision"]
        assert changed(before, process_state()) == expected
    monkeypatch.setattr(locale, "setlocale", lambda _: "another")
    assert changed(before, process_state()) == ["locale"]

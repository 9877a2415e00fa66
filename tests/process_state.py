"""What is one in a process, which no test may leave changed: the next test would meet it."""

import locale
import os
import resource
import signal
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

LIMITS = ("RLIMIT_AS", "RLIMIT_CORE", "RLIMIT_CPU", "RLIMIT_FSIZE", "RLIMIT_NOFILE", "RLIMIT_STACK")

SIGNALS = {number.name: number for number in signal.Signals}

State = Mapping[str, object]


def environment() -> State:
    """The variables but for the name of the running test, and what Panel notes on its import."""
    others = {"PYTEST_CURRENT_TEST", "_PYVIZ_COMMS_INSTALLED"}
    return {name: value for name, value in os.environ.items() if name not in others}


ALWAYS: Mapping[str, Callable[[], object]] = {
    "environment": environment,
    "folder": os.getcwd,
    "arguments": lambda: list(sys.argv),
    "import path": lambda: list(sys.path),
    "recursion limit": sys.getrecursionlimit,
    "digits of an integer": sys.get_int_max_str_digits,
    "exception hooks": lambda: (sys.excepthook, threading.excepthook),
    "signal handlers": lambda: {name: signal.getsignal(n) for name, n in SIGNALS.items()},
    "limits": lambda: {name: resource.getrlimit(getattr(resource, name)) for name in LIMITS},
    "locale": lambda: locale.setlocale(locale.LC_ALL),
    "NumPy's floating-point traps": np.geterr,
    "NumPy's printing": np.get_printoptions,
}

OF_MODULES: Mapping[str, tuple[str, Callable[[Any], object]]] = {
    "mpmath's precision": ("mpmath", lambda module: (module.mp.prec, module.iv.prec)),
    "usable cores": ("longwave.support.compiled.cores", lambda module: module.usable_cores()),
    "Matplotlib's settings": ("matplotlib", lambda module: dict(dict.items(module.rcParams))),
    "open figures": ("matplotlib._pylab_helpers", lambda module: list(module.Gcf.figs)),
}
"""What is looked at where the module was imported before the test. Warning filters are not here:
pytest puts them back itself."""


def process_state() -> State:
    """All of it, by name."""
    state = {name: found() for name, found in ALWAYS.items()}
    for name, (module, found) in OF_MODULES.items():
        if module in sys.modules:
            state[name] = found(sys.modules[module])
    return state


def changed(before: State, after: State) -> list[str]:
    """The names of what is another; of what has parts, with those of the parts."""
    told = []
    for name in [name for name in before if before[name] != after[name]]:
        one, other = before[name], after[name]
        if isinstance(one, dict) and isinstance(other, dict):
            parts = [k for k in one.keys() | other.keys() if one.get(k, told) != other.get(k, told)]
            name = f"{name}: {', '.join(sorted(parts))}"
        told.append(name)
    return told

"""The files that a request passes on its way, found by following calls.

    python tools/walks.py

A walk goes from the call that a user makes to the call in it that takes longest, from there to the
longest in that one, and so on. Printed are the walk's files in their order, how many they are, and
how often it comes back to a file that it had left.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

import longwave

HOUSE = Path(__file__).resolve().parents[1]

SCENES = ("rational_2_eps_0.05", "rogue_cn_k_0.5_long", "toda_soliton", "square_lump")
STATEMENTS = (
    ("u_t + 6*u*u_x + u_xxx", "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", ""),
    ("u_t + 6*u*u_x + u_xxx", "u = 3*k**2*sech(k*(x - 4*k**2*t))**2", ""),
    ("u_t + c*u_x", "u = exp(x - b*t)", "c"),
)
FORMS = {"rational_2": {}, "rogue_cn": {"k": 0.5}}


class Call:
    """All calls of a function from one place of the walk: their seconds, and what they call."""

    def __init__(self, name: str) -> None:
        self.name, self.seconds = name, 0.0
        self.inner: dict[str, Call] = {}


def followed(ask: Callable[[], Any]) -> Call:
    """Return the calls of this package's functions by a request that was made before."""
    ask()
    top = Call("")
    open_calls: list[tuple[Call, float]] = []
    files: dict[str, str] = {}

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            outer = open_calls[-1][0] if open_calls else top
            path = frame.f_code.co_filename
            if path not in files:
                place = Path(path).resolve()
                files[path] = str(place.relative_to(HOUSE)) if HOUSE in place.parents else ""
            inner = outer
            if files[path] and ".venv" not in files[path]:
                name = f"{files[path]}:{frame.f_code.co_name}"
                inner = outer.inner.setdefault(name, Call(name))
            open_calls.append((inner, time.perf_counter()))
        elif event == "return" and open_calls:
            inner, begun = open_calls.pop()
            outer = open_calls[-1][0] if open_calls else top
            inner.seconds += (time.perf_counter() - begun) * (inner is not outer)

    sys.setprofile(note)
    try:
        ask()
    finally:
        sys.setprofile(None)
    return top


def longest_walk(call: Call) -> list[str]:
    """Return the files on the way through the longest calls, each as often as it is entered."""
    files: list[str] = []
    while call.inner:
        call = max(call.inner.values(), key=lambda inner: inner.seconds)
        file = call.name.partition(":")[0]
        if not files or files[-1] != file:
            files.append(file)
    return files


def requests() -> dict[str, Callable[[], Any]]:
    """Return the requests by name."""
    found: dict[str, Callable[[], Any]] = {}
    for name in SCENES:
        scene = longwave.load_scene(name)
        found[f"scene {name} to its Dataset"] = partial(longwave.run, scene)
    for equation, solution, solve in STATEMENTS:
        decide = partial(longwave.prove, equation, solution, solve=solve)
        found[f"text {solution!r} to its verdict"] = decide
    normal_form, X = longwave.mkdv_normal_form(K2=1, K4=1), np.linspace(-3.0, 3.0, 1001)
    for name, parameters in FORMS.items():
        wave = longwave.Wave(longwave.closed_form(name), normal_form, **parameters)
        found[f"form {name} to an array"] = partial(wave, X, 0.1)
    return found


def main() -> int:
    """Print the walks."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {0})  # no second thread, which would not be followed
    for name, ask in requests().items():
        files = longest_walk(followed(ask))
        returns = sum(file in files[:place] for place, file in enumerate(files))
        print(f"{name}: {len(set(files))} files, {returns} returns\n    {' > '.join(files)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

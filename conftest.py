"""What pytest looks for where."""

import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from _pytest.doctest import DoctestModule

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: idle threads spin, one a worker


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """Look for no garbage while all that is made stays, and afterwards seldom and never through it.

    The modules, the tests and their parameters are 770 000 objects: that took 4 s of 14. Formulas
    are trees of small objects, of which hardly any are garbage: looking took a sixth of a proof.
    """
    gc.disable()
    found = yield
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)
    gc.enable()
    return found


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path: Path) -> Iterator[None]:
    """Import no module for examples that it does not have: most have none."""
    found = yield
    if file_path.suffix != ".py" or ">>>" in file_path.read_text(encoding="utf-8"):
        return found
    return [one for one in found if not isinstance(one, DoctestModule)]

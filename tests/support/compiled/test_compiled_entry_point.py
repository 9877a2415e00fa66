"""Catches: a kernel that reads what it was not given, and numba where nothing needs it."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core.errors import NumbaError

from longwave.solutions.run.linear_phase import _fill
from longwave.support.compiled import entry_point
from longwave.support.compiled.jit import njit

HOUSE = Path(__file__).parents[3]


@njit(inner=True)
def _sum(first: float, second: float | None) -> float:
    return first if second is None else first + second


@njit(cache=True, error_model="numpy")
def _total(values: Any, weights: Any, shift: Any, steps: Any, *constants: Any) -> float:
    found = shift * weights[1] + steps + _sum(*constants)
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            found += values[i, j]
    return found


GRID = np.arange(6.0).reshape(2, 3)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((GRID, (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID, (1.0, 2.0), 0.5, 3, 0.0, 4.0), 23.0),
        ((GRID, (1.0, 2.0), np.float64(0.5), np.int64(3), 0.0, None), 19.0),
        ((GRID.T, (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((np.ones((4, 6))[::2, ::3], (1.0, 2.0), 0.5, 3, 0.0, None), 8.0),
        ((GRID.astype(int), (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID.astype(np.float32), (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID.astype(complex).real, (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID.view(np.dtype("f8").newbyteorder("=")), (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID, (1.0, 2.0), 1, 3, 0.0, None), 20.0),
        ((GRID, (1.0, 2.0), 0.5, True, 0.0, None), 17.0),
    ],
)
def test_arguments_of_all_kinds_are_read_as_what_they_are(
    arguments: tuple[Any, ...], expected: float
) -> None:
    """Twice: when it is compiled and when it is there."""
    assert _total(*arguments) == expected
    assert _total(*arguments) == expected


def test_arrays_that_may_not_be_written_are_another_type() -> None:
    frozen = GRID.copy()
    frozen.flags.writeable = False
    assert _total(frozen, (1.0, 2.0), 0.5, 3, 0.0, None) == 19.0


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        (GRID, (1.0, 2.0), 0.5),
        (GRID, (1.0, 2.0), "0.5", 3, 1.0, None),
        (GRID.tolist(), (1.0, 2.0), 0.5, 3, 1.0, None),
        (GRID, (1.0, 2.0), 0.5, 10**30, 1.0, None),
    ],
)
def test_what_no_kernel_takes_is_refused(arguments: tuple[Any, ...]) -> None:
    _total(GRID, (1.0, 2.0), 0.5, 3, 1.0, None)
    with pytest.raises((TypeError, ValueError, OverflowError, NumbaError)):
        _total(*arguments)


def test_a_wrong_number_of_dimensions_is_no_entry() -> None:
    """It would read past the end."""
    point = (1.0, 0.0, 0.0)
    _fill(point, point, point, np.zeros(3), np.zeros(3), np.zeros((4, 3)))
    with pytest.raises(Exception, match=r"(?s)No implementation|index|getitem"):
        _fill(point, point, point, np.zeros(3), np.zeros(3), np.zeros(4))


def test_another_interpreter_or_layout_leaves_it_to_numba(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(entry_point, "fields_are_known", lambda: False)

    @njit(cache=True)
    def double(x: float) -> float:
        return 2.0 * x

    assert double(2.0) == 4.0
    assert not double._entries


WARM = """
import sys
import numpy as np
from longwave.lattice.kernels.nystroem import advance_nystroem
from longwave.solutions.run.linear_phase import LinearPhase
found = LinearPhase(2, -6, 3)(np.array([1.0]), np.array([1.0]))
assert found[0, 0] == -1.0, found
print(*sorted({"numba", "sympy", "scipy"} & set(sys.modules)))
"""


def test_a_kernel_that_is_there_needs_no_numba() -> None:
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", WARM], capture_output=True, text=True, cwd=HOUSE, check=True
        )
    assert done.stdout.split() == []

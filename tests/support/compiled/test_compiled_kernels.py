"""Catches: a kernel that reads beyond its arguments, and numba imported where nothing needs it."""

import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numba.core.errors import NumbaError

from longwave.solutions.run.linear_phase import _fill
from longwave.support.compiled.jit import njit
from longwave.support.compiled.kernel_folder import CacheFolder

HOUSE = Path(__file__).parents[3]


@njit()
def _sum(first: float, second: float | None) -> float:
    return first if second is None else first + second


@njit(cache=True)
def _total(out: Any, values: Any, weights: Any, shift: Any, steps: Any, *constants: Any) -> None:
    out[0] = shift * weights[1] + steps + _sum(*constants)
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            out[0] += values[i, j]


def total(*arguments: Any) -> float:
    out = np.zeros(1)
    _total(out, *arguments)
    return float(out[0])


GRID = np.arange(6.0).reshape(2, 3)


def frozen(array: np.ndarray) -> np.ndarray:
    array = array.copy()
    array.flags.writeable = False
    return array


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((GRID, (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID, (1.0, 2.0), 0.5, 3, 0.0, 4.0), 23.0),
        ((GRID, (1.0, 2.0), np.float64(0.5), np.int64(3), 0.0, None), 19.0),
        ((GRID, (np.int32(1), np.float64(2.0)), 0.5, np.int8(3), 0.0, None), 19.0),
        ((GRID.T, (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((np.ones((4, 6))[::2, ::3], (1.0, 2.0), 0.5, 3, 0.0, None), 8.0),
        ((np.ones((4, 6))[::-2, ::3], (1.0, 2.0), 0.5, 3, 0.0, None), 8.0),
        ((np.ones((0, 6)), (1.0, 2.0), 0.5, 3, 0.0, None), 4.0),
        ((GRID.astype(int), (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID.astype(np.float32), (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID.astype(complex).real, (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID.view(np.dtype("f8").newbyteorder("=")), (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((frozen(GRID), (1.0, 2.0), 0.5, 3, 0.0, None), 19.0),
        ((GRID, (1.0, 2.0), 1, 3, 0.0, None), 20.0),
    ],
)
def test_arguments_of_all_types_are_read_correctly(
    arguments: tuple[Any, ...], expected: float
) -> None:
    """Called twice: when it is compiled and when it is cached."""
    assert total(*arguments) == expected
    assert total(*arguments) == expected


@pytest.mark.parametrize(
    "arguments",
    [
        (),
        (GRID, (1.0, 2.0), 0.5),
        (GRID, (1.0, 2.0), "0.5", 3, 1.0, None),
        (GRID, (1.0, 2.0), 0.5, True, 1.0, None),
        (GRID, (1.0, 2.0), 0.5j, 3, 1.0, None),
        (GRID, (1.0, 2.0), np.float32(0.5), 3, 1.0, None),
        (GRID.tolist(), (1.0, 2.0), 0.5, 3, 1.0, None),
        (GRID.astype(">f8"), (1.0, 2.0), 0.5, 3, 1.0, None),
        (GRID, (1.0, 2.0), 0.5, 2**63, 1.0, None),
    ],
)
def test_unsupported_arguments_are_refused(arguments: tuple[Any, ...]) -> None:
    total(GRID, (1.0, 2.0), 0.5, 3, 1.0, None)
    with pytest.raises((TypeError, ValueError, NumbaError)):
        total(*arguments)


def test_another_number_of_dimensions_is_another_kernel() -> None:
    """The kernel would read past the end."""
    point = (1.0, 0.0, 0.0)
    _fill(point, point, point, np.zeros(3), np.zeros(3), np.zeros((4, 3)))
    with pytest.raises(Exception, match=r"(?s)No implementation|index|getitem"):
        _fill(point, point, point, np.zeros(3), np.zeros(3), np.zeros(4))


def test_a_read_only_array_is_another_type() -> None:
    total(GRID, (1.0, 2.0), 0.5, 3, 0.0, None)
    with pytest.raises(NumbaError, match="readonly"):
        _total(frozen(np.zeros(1)), GRID, (1.0, 2.0), 0.5, 3, 0.0, None)


def test_arrays_of_one_row_have_the_type_of_others() -> None:
    """They are in Fortran order as well, and the kernel would be compiled twice."""
    arguments = (1.0, 2.0), 0.5, 3, 0.0, None
    total(GRID, *arguments)
    known = len(_total._entries)
    assert total(GRID[:1], *arguments) == 7.0
    assert len(_total._entries) == known


def test_a_kernel_returns_nothing_and_creates_no_arrays() -> None:
    @njit(cache=True)
    def double(x: float) -> float:
        return 2.0 * x

    @njit(cache=True)
    def copied(x: Any, out: Any) -> None:
        space = x + 1.0
        for i in range(x.size):
            out[i] = space[i]

    with pytest.raises(TypeError, match="must return nothing to be cached"):
        double(2.0)
    with pytest.raises(TypeError, match="pass them as arguments"):
        copied(np.zeros(3), np.zeros(3))


def test_an_exception_of_a_kernel_is_reported() -> None:
    @njit(cache=True)
    def halted(out: Any) -> None:
        if out[0] < 0.0:
            raise ValueError
        out[0] += 1.0

    out = np.zeros(1)
    halted(out)
    assert out[0] == 1.0
    out[0] = -1.0
    with pytest.raises(RuntimeError, match="halted must raise nothing"):
        halted(out)


WARM = """
import sys
import numpy as np
from longwave.lattice.kernels.nystroem import advance_nystroem
from longwave.solutions.run.linear_phase import LinearPhase
found = LinearPhase(2, -6, 3)(np.array([1.0]), np.array([1.0]))
assert found[0, 0] == -1.0, found
y, s, row = np.zeros((3, 4))
advance_nystroem(y, s, (row, np.zeros((4, 4)), row, row), 0.1, 2, 1.0, None, 1.0)
print(*sorted({"numba", "sympy", "scipy"} & set(sys.modules)))
"""


def test_a_cached_kernel_needs_no_numba() -> None:
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", WARM], capture_output=True, text=True, cwd=HOUSE, check=True
        )
    assert done.stdout.split() == []


def test_a_cached_file_is_not_read_for_changed_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: results of an earlier source used after the source has changed."""
    CacheFolder(tmp_path).write("name", b"kept")
    assert CacheFolder(tmp_path).read("name") == b"kept"
    (tmp_path / "young.py").touch()
    monkeypatch.setitem(sys.modules, "young", ModuleType("young"))
    assert CacheFolder(tmp_path, (("young", tmp_path / "young.py"),)).read("name") is None

"""The blocked vector kernel is the plain one, for all constants and at every seam.

Catches also: arcs that overlap too little, lose a site, or round otherwise than one core does.
"""

import multiprocessing
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from longwave import derive
from longwave.lattice.kernels import blocked, plain
from longwave.lattice.model import Array, Model
from longwave.lattice.schemes import (
    BLANES_MOAN_6,
    KAHAN_LI_8,
    REDUCED_PHASE_6,
    SCHEMES,
    STOERMER_VERLET,
    Composition,
    Splitting,
)
from longwave.lattice.stepper import advance
from longwave.solutions import Wave, closed_form
from longwave.support.compiled import cores

SPLITTINGS = [scheme for scheme in SCHEMES if isinstance(scheme, Splitting | Composition)]


@pytest.mark.parametrize("K3", [0.0, 0.3])
@pytest.mark.parametrize("K4", [0.0, -0.7, 1.0])
@pytest.mark.parametrize(
    ("size", "steps"), [(4096, 9), (4608, 4), (3648, 9), (3872, 1), (1032, 4), (120, 5)]
)
def test_blocked_equals_plain(K3: float, K4: float, size: int, steps: int) -> None:
    random = np.random.default_rng(1)
    y, s = 0.1 * random.standard_normal((2, size))
    u, v = y.copy(), s.copy()
    drifts, kicks = 0.3 * BLANES_MOAN_6.drifts, 0.3 * BLANES_MOAN_6.kicks
    constants = Model(4.0, K3, K4).kernel
    assert blocked.fits(size, kicks.size)
    plain.advance_plain(y, s, drifts, kicks, steps, *constants)
    blocked.advance_blocked(u, v, drifts, kicks, steps, *constants)
    np.testing.assert_allclose(u, y, atol=1e-13)
    np.testing.assert_allclose(v, s, atol=1e-13)


@pytest.mark.parametrize("splitting", SPLITTINGS, ids=lambda splitting: splitting.name)
def test_every_splitting_is_advanced_by_either_kernel(
    splitting: Splitting | Composition, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A number of stages that is odd, one, or does not divide the stages of a passage."""
    constants = Model(1.0, 0.2, 0.9)
    ends = []
    for admitted in (True, False):
        y, s = 0.1 * np.random.default_rng(4).standard_normal((2, 1200))
        if not admitted:
            monkeypatch.setattr(blocked, "fits", lambda *_: False)
        advance(splitting, y, s, 0.2, 61, constants)
        ends.append((y, s))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=2e-13)


def test_engine_agrees_with_dop853() -> None:
    """Y2 about its crest at eps = 0.05, to 1e-8 eps: an integrator that shares no line with it."""
    eps, size, duration = 0.05, 512, 40.0
    wave = Wave(closed_form("rational_2"), derive.mkdv_normal_form(4, 1))
    value = wave.at(np.arange(size) - size // 2, 0.0, eps)
    y, s = eps * value.Y, eps**4 * value.Y_T - 2.0 * eps**2 * value.Y_X

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        strain, velocity = np.split(state, 2)
        force = strain * (4.0 + strain**2)
        bend = np.roll(force, 1) - 2.0 * force + np.roll(force, -1)
        return np.concatenate([velocity, bend])

    start = np.concatenate([y, s])
    solved = solve_ivp(rate, (0.0, duration), start, "DOP853", rtol=1e-13, atol=1e-15)
    advance(BLANES_MOAN_6, y, s, duration / 200, 200, Model(4.0, 0.0, 1.0))
    assert np.abs(y - solved.y[:size, -1]).max() < 1e-8 * eps


def test_odd_ring_falls_back() -> None:
    random = np.random.default_rng(2)
    y, s = 0.1 * random.standard_normal((2, 61))
    begin = y.copy(), s.copy()
    constants = Model(4.0, 0.0, 1.0)
    advance(BLANES_MOAN_6, y, s, 0.1, 7, constants)
    advance(BLANES_MOAN_6, y, s, -0.1, 7, constants)
    np.testing.assert_allclose(y, begin[0], atol=1e-13)
    np.testing.assert_allclose(s, begin[1], atol=1e-13)


def advanced(size: int, steps: int) -> Iterator[Array]:
    """Rings advanced by a scheme with an odd number of stages; K3 and K4, or K4 alone."""
    for model in (Model(1.3, 0.3, -0.7), Model(1.3, 0.0, 0.9)):
        ring = 0.1 * np.random.default_rng(6).standard_normal((2, size))
        drifts, kicks = 0.2 * REDUCED_PHASE_6.drifts, 0.2 * REDUCED_PHASE_6.kicks
        blocked.advance_blocked(*ring, drifts, kicks, steps, *model.kernel)
        yield ring


OTHER_WAY = """
import sys
import numpy as np
from longwave.lattice.kernels import blocked
from tests.lattice.test_lattice_blocked import advanced
np.save(sys.argv[1], list(advanced(*map(int, sys.argv[2:]))))
print(blocked.why_plain())
"""


@pytest.mark.parametrize(
    ("setting", "size", "steps", "ulps", "why"),
    [
        pytest.param(
            *("LONGWAVE_PLAIN_KERNELS", 4160, 21, 0, "LONGWAVE_PLAIN_KERNELS is set"),
            marks=pytest.mark.slow,  # compiles them for 10 s
        ),
        ("NUMBA_DISABLE_JIT", 112, 2, 64, "numba's compiler is switched off"),
    ],
)
def test_plain_loops_take_the_place_of_vector_code(
    setting: str, size: int, steps: int, ulps: int, why: str, tmp_path: Path
) -> None:
    """To the bit, but for multiply-adds without the compiler: they round twice."""
    assert not blocked.why_plain()
    file = tmp_path / "rings.npy"
    done = subprocess.run(
        [sys.executable, "-c", OTHER_WAY, str(file), str(size), str(steps)],
        env={**os.environ, setting: "1", "PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == why
    for ring, other in zip(advanced(size, steps), np.load(file), strict=True):
        assert np.abs(ring - other).max() <= ulps * np.spacing(0.1)


@pytest.mark.parametrize("scheme", [REDUCED_PHASE_6, KAHAN_LI_8, STOERMER_VERLET])
@pytest.mark.parametrize("size", [blocked.LEAST_SITES, blocked.LEAST_SITES + 3 * blocked.LANES])
@pytest.mark.parametrize("steps", [0, 1, blocked.MEETING, 2 * blocked.MEETING + 3])
def test_two_cores_give_the_bits_of_one(scheme: Splitting, size: int, steps: int) -> None:
    y, s = 0.05 * np.random.default_rng(3).standard_normal((2, size))
    u, v = y.copy(), s.copy()
    work = 0.2 * scheme.drifts, 0.2 * scheme.kicks, steps, *Model(4.0, 0.2, 1.0).kernel
    blocked.advance_blocked(y, s, *work)
    blocked.advance_on_two_cores(u, v, *work)
    np.testing.assert_array_equal(u, y)
    np.testing.assert_array_equal(v, s)


def test_a_worker_process_leaves_the_other_core_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cores.os, "sched_getaffinity", lambda _: {0, 1}, raising=False)
    assert blocked.pays(blocked.LEAST_SITES)
    assert not blocked.pays(blocked.LEAST_SITES - 1)
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: object())
    assert not blocked.pays(blocked.LEAST_SITES)


def test_one_core_is_not_divided(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cores.os, "sched_getaffinity", lambda _: {0}, raising=False)
    assert not blocked.pays(blocked.LEAST_SITES)

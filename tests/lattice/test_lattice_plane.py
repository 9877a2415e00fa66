"""The two-dimensional kernel against NumPy, and `integrate` on planes."""

import numpy as np
import pytest

from longwave.lattice import State, integrate
from longwave.lattice.kernels import reference, ring_kernel
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.kernels.streams import rows_of, stage_plan
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice
from longwave.lattice.schemes import BLANES_MOAN_6, REDUCED_PHASE_6, STOERMER_VERLET, DriftKick
from tests.lattice.random_lattices import random_lattice, smooth_or_rough
from tests.lattice.random_lattices import reference as exact_run
from tests.lattice.test_numeric_lattice import numbers

SQUARE = numbers("square")


def relative_difference(
    chain: NumericLattice, shape: tuple[int, ...], size: float, scheme: DriftKick, steps: int = 3
) -> float:
    """Return the relative difference between the kernel and NumPy."""
    random = np.random.default_rng(4)
    f, v = size * random.standard_normal((2, len(chain.fields), *shape))
    g, w = f.copy(), v.copy()
    h = 0.3 / chain.highest_frequency(chain.rest_slopes())
    weights = scheme.drifts * h, scheme.kicks * h
    RingKernel(chain, *shape).advance(f, v, *weights, steps)
    reference.advance_splitting(chain.acceleration, g, w, *weights, steps)
    return max(
        float(np.max(np.abs(one - other)) / np.max(np.abs(other)))
        for one, other in ((f, g), (v, w))
    )


@pytest.mark.parametrize(
    "shape", [(1, 1), (1, 9), (9, 1), (2, 30), (5, 3), (16, 16), (40, 50), (64, 17), (7, 200)]
)
@pytest.mark.parametrize("scheme", [REDUCED_PHASE_6, BLANES_MOAN_6, STOERMER_VERLET])
def test_the_kernel_agrees_with_numpy_on_rings_of_any_shape(
    shape: tuple[int, ...], scheme: DriftKick
) -> None:
    assert relative_difference(SQUARE, shape, 0.1, scheme) < 1e-14


@pytest.mark.parametrize("seed", range(8))
def test_the_kernel_takes_any_lattice(seed: int) -> None:
    random = np.random.default_rng(seed)
    chain = random_lattice(random, 0.1, axes=2)
    assert (
        relative_difference(chain, tuple(random.integers(1, 40, 2)), 0.01, REDUCED_PHASE_6) < 1e-12
    )


@pytest.mark.slow
def test_the_kernel_takes_very_many_lattices() -> None:
    for seed in range(100, 130):
        random = np.random.default_rng(seed)
        chain = random_lattice(random, 0.1, axes=2)
        shape = tuple(random.integers(1, 60, 2))
        assert relative_difference(chain, shape, 0.01, REDUCED_PHASE_6) < 1e-12, seed


def test_two_cores_give_the_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    random = np.random.default_rng(1)
    f, v = 0.1 * random.standard_normal((2, 1, 61, 40))
    found = []
    monkeypatch.setattr(ring_kernel, "MIN_SHARED_VALUES", 1)
    monkeypatch.setattr(ring_kernel, "MIN_SHARED_WORK", 1)
    for count in (1, 2):
        monkeypatch.setattr(ring_kernel, "usable_cores", lambda count=count: count)
        one, other = f.copy(), v.copy()
        scheme, kernel = REDUCED_PHASE_6, RingKernel(SQUARE, 61, 40)
        kernel.advance(one, other, scheme.drifts / 9, scheme.kicks / 9, 7)
        assert len(kernel._arcs) == count
        found.append((one, other))
    np.testing.assert_array_equal(found[0], found[1])


def test_absent_terms_are_absent() -> None:
    """Springs without quadratic and cubic parts, and an axis without springs."""
    straight = NumericLattice("plain", ("u",), (1.0,), (SQUARE.bonds[0],))
    whole, half = stage_plan(SQUARE)[0], stage_plan(straight)[0]
    assert (whole.operations, half.operations) == (13, 7)
    assert (rows_of(whole).left, rows_of(half).left) == (1, 0)


def shortfall(seed: int) -> float | None:
    """Return the true error over the estimate of a random plane lattice; None if it is refused."""
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-2, 1)
    chain = random_lattice(random, size, 2)
    shape = tuple(random.integers(3, 9, 2))
    fastest = chain.highest_frequency(chain.rest_slopes())
    width, fields = random.choice([0.7, 1.2, np.inf]), len(chain.fields)
    f = smooth_or_rough(random, size, fields, shape, width)
    v = fastest * smooth_or_rough(random, size, fields, shape, width) * random.choice([0, 0.3])
    times = np.cumsum(10.0 ** random.uniform(-0.5, 1.3, int(random.integers(1, 3)))) / fastest
    tolerance = size * 10.0 ** random.uniform(-8, -2.5)
    exact = exact_run(chain, f, v, times)
    if exact is None:
        return None
    try:
        run = integrate(chain, State(0.0, f, v), times, tolerance)
    except ValueError as refusal:
        if not str(refusal).startswith(("times must end", "tolerance must satisfy")):
            raise
        return None
    assert run.error_estimate <= tolerance
    pairs = zip(run.f, exact, strict=True)
    wrong = [np.array(chain.stretches(one)) - chain.stretches(other) for one, other in pairs]
    known = 1e-10 * np.max(np.abs(exact))
    return float(np.max(np.abs(wrong)) / (run.error_estimate + known))


def test_estimates_bound_the_error_in_two_dimensions() -> None:
    found = [ratio for ratio in map(shortfall, range(6)) if ratio is not None]
    assert len(found) > 3
    assert max(found) <= 1.0


@pytest.mark.slow
def test_estimates_bound_the_error_in_two_dimensions_at_length() -> None:
    found = [ratio for ratio in map(shortfall, range(1000, 1024)) if ratio is not None]
    assert len(found) > 17
    assert max(found) <= 1.0


@pytest.mark.parametrize("cells", [(3, 2), (-3, 1), (2, -3), (0, 3)])
def test_stages_stay_as_far_apart_as_springs_reach(cells: tuple[int, int]) -> None:
    """Two stages share a pass over the rows only if a ring is tall enough."""
    here, back = (0, 0), (-cells[0], -cells[1])
    far = NumericBond(
        (Entry(cells, 1.0, 0), Entry(here, -1.0, 0)),
        (Entry(here, 1.0, 0), Entry(back, -1.0, 0)),
        SQUARE.bonds[0].force,
    )
    chain = NumericLattice("far", ("u",), (1.0,), (*SQUARE.bonds, far))
    assert relative_difference(chain, (120, 21), 0.05, REDUCED_PHASE_6) < 1e-13

"""Compiled kernels of chains against `NumericLattice.acceleration`.

Catches: a stencil that is read wrongly, a value that is not carried long enough, invalid rows at
the seam, code that rounds differently in lanes, terms computed although absent.
"""

import multiprocessing
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from longwave.derive import LATTICES
from longwave.lattice.force_program import ForceProgram
from longwave.lattice.kernels import ring_kernel
from longwave.lattice.kernels.reference import advance_splitting
from longwave.lattice.kernels.ring_kernel import MAX_STEPS_APART, MIN_SHARED_VALUES, RingKernel
from longwave.lattice.kernels.row_code import passage_text
from longwave.lattice.kernels.streams import stage_plan
from longwave.lattice.numeric_lattice import (
    Array,
    Entry,
    NumericBond,
    NumericLattice,
    numeric_lattice,
)
from longwave.lattice.schemes import (
    BLANES_MOAN_6,
    REDUCED_PHASE_6,
    STOERMER_VERLET,
    SUZUKI_UMENO_8,
    Splitting,
)
from longwave.support.compiled import cores
from searches.random_chains import random_chain
from tests.lattice.random_lattices import random_lattice
from tests.lattice.test_lattice_disordered import varied
from tests.lattice.test_numeric_lattice import DISPLACED, numbers

CHAINS = sorted({*DISPLACED, "fput_strain", "next_nearest"} - {"square", "fput", "mass_dimer"})


def accelerations(lattice: NumericLattice, f: Array) -> Array:
    """Return the accelerations by the kernel: one kick of 1 without drift, from rest."""
    f, v = f.copy(), np.zeros_like(f)
    RingKernel(lattice, f.shape[1]).advance_stages(f, v, np.zeros(1), np.ones(1), 1)
    return v


def advance_chain(
    lattice: NumericLattice, f: Array, v: Array, drifts: Array, kicks: Array, steps: int
) -> None:
    """Advance by a kernel built for the chain."""
    RingKernel(lattice, f.shape[1]).advance(f, v, drifts, kicks, steps)


def rounded(lattice: NumericLattice, f: Array) -> float:
    """Return the size of the terms added to an acceleration."""
    weights = [
        sum(abs(entry.weight) for entry in (*bond.stretch, *bond.action)) for bond in lattice.bonds
    ]
    found = 0.0
    for bond, stretch, weight in zip(lattice.bonds, lattice.stretches(f), weights, strict=True):
        force = max(np.abs(bond.force(stretch)).max(), bond.force.largest_summand(stretch))
        stiff = np.abs(bond.force.slope(stretch)).max() * np.abs(f).max()
        powers = ForceProgram(tuple(map(abs, bond.force.coefficients)))(np.abs(stretch)).max()
        found += weight * max(force, stiff, powers if bond.force.coefficients else 0.0)
    return float(found / min(lattice.masses))


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 140))
def test_forces_are_the_declared_ones(seed: int, size: int) -> None:
    random = np.random.default_rng(seed)
    lattice = random_chain(random, 1.0, reach=4)
    f = 0.3 * random.standard_normal((len(lattice.fields), size))
    apart = np.abs(accelerations(lattice, f) - lattice.acceleration(f)).max()
    assert apart <= 4e-15 * rounded(lattice, f)


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize(("size", "steps"), [(1, 2), (2, 2), (7, 3), (33, 5), (1032, 3), (4100, 9)])
def test_many_stages_equal_single_stages(name: str, size: int, steps: int) -> None:
    lattice, random = numbers(name), np.random.default_rng(size)
    f, v = 0.01 * random.standard_normal((2, len(lattice.fields), size))
    g, w = f.copy(), v.copy()
    scheme = (STOERMER_VERLET, BLANES_MOAN_6, SUZUKI_UMENO_8)[steps % 3]
    step = 0.3 / lattice.highest_frequency(lattice.rest_slopes())
    weights = step * scheme.drifts, step * scheme.kicks
    advance_chain(lattice, f, v, *weights, steps)
    advance_splitting(lattice.acceleration, g, w, *weights, steps)
    np.testing.assert_allclose(f, g, rtol=0, atol=1e-14)
    np.testing.assert_allclose(v, w, rtol=0, atol=1e-14 / step)


@pytest.mark.parametrize("name", ["next_nearest", "dimer", "klein_gordon", "granular"])
def test_lanes_blocks_and_passes_change_no_bit(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lattice = numbers(name)
    start = 0.01 * np.random.default_rng(5).standard_normal((2, len(lattice.fields), 2603))
    weights = 0.1 * BLANES_MOAN_6.drifts, 0.1 * BLANES_MOAN_6.kicks
    found = []
    for least, stages in ((32, 28), (32, 5), (32, 1), (10**6, 28)):
        monkeypatch.setattr(ring_kernel, "MIN_LANED_CELLS", least)
        monkeypatch.setattr(ring_kernel, "MAX_STAGES", stages)
        f, v = start.copy()
        advance_chain(lattice, f, v, *weights, 4)
        found.append((f, v))
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])


@pytest.fixture
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cores.os, "sched_getaffinity", lambda _: {0, 1}, raising=False)
    monkeypatch.setattr(cores, "_alone", False)


def shared_chains() -> list[NumericLattice]:
    """Chains with a reach of one and two cells, two fields, and deviations from cell to cell."""
    chains = [numbers(name) for name in ("fput_strain", "next_nearest", "dimer")]
    return [*chains, varied(chains[0], "mass", 0.1, MIN_SHARED_VALUES + 27)]


@pytest.mark.parametrize("lattice", shared_chains(), ids=lambda lattice: lattice.name)
@pytest.mark.parametrize("scheme", [REDUCED_PHASE_6, STOERMER_VERLET])
@pytest.mark.parametrize("steps", [0, 1, MAX_STEPS_APART, 2 * MAX_STEPS_APART + 3])
def test_two_cores_give_the_bits_of_one(
    lattice: NumericLattice,
    scheme: Splitting,
    steps: int,
    two_cores: None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    size, fields = MIN_SHARED_VALUES + 27, len(lattice.fields)
    start = 0.01 * np.random.default_rng(3).standard_normal((2, fields, size))
    step = 0.3 / lattice.highest_frequency(lattice.rest_slopes())
    ends = []
    for least in (MIN_SHARED_VALUES, 10 * size):
        monkeypatch.setattr(ring_kernel, "MIN_SHARED_VALUES", least)
        kernel, ring = RingKernel(lattice, size), start.copy()
        kernel.advance(*ring, step * scheme.drifts, step * scheme.kicks, steps)
        ends.append(ring)
        assert steps == 0 or len(kernel._arcs) == (2 if least == MIN_SHARED_VALUES else 1)
    np.testing.assert_array_equal(*ends)


def test_a_worker_process_leaves_the_other_core_alone(
    two_cores: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel, short = (RingKernel(numbers("fput"), MIN_SHARED_VALUES - less) for less in (0, 1))
    assert kernel._stages_between(14) > 0
    assert short._stages_between(14) == 0
    monkeypatch.setattr(multiprocessing, "parent_process", lambda: object())
    assert kernel._stages_between(14) == 0


def test_one_core_uses_one_arc(two_cores: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cores.os, "sched_getaffinity", lambda _: {0}, raising=False)
    assert RingKernel(numbers("fput"), MIN_SHARED_VALUES)._stages_between(14) == 0


def test_cores_compute_few_cells_twice() -> None:
    """With a reach of 4 cells and 200 stages per step, at most a fifth are computed twice."""
    kernel = RingKernel(random_chain(np.random.default_rng(0), 1.0, reach=4), MIN_SHARED_VALUES)
    flow = kernel._flow
    for period in (14, 200, 10**4):
        doubled = 2 * kernel._stages_between(period) * (flow.skew + flow.below)
        assert doubled <= 0.2 * MIN_SHARED_VALUES


def test_reused_memory_changes_no_bit() -> None:
    lattice, size = numbers("next_nearest"), 1031
    kernel = RingKernel(lattice, size)
    for seed, scheme in enumerate((BLANES_MOAN_6, STOERMER_VERLET, SUZUKI_UMENO_8, BLANES_MOAN_6)):
        ring = 0.01 * np.random.default_rng(seed).standard_normal((2, 1, size))
        anew = ring.copy()
        weights = 0.1 * scheme.drifts, 0.1 * scheme.kicks
        kernel.advance(*ring, *weights, 5)
        advance_chain(lattice, *anew, *weights, 5)
        np.testing.assert_array_equal(ring, anew)


def test_a_wrong_stencil_is_detected() -> None:
    """The tests above must fail for code generated from another lattice."""
    lattice, f = numbers("dimer"), 0.1 * np.random.default_rng(2).standard_normal((2, 40))
    bond = lattice.bonds[1]
    moved = replace(bond, stretch=(Entry((2,), 1.0, 0), *bond.stretch[1:]))
    heavier = replace(bond, action=(replace(bond.action[0], weight=2.0), *bond.action[1:]))
    shifted = replace(bond, offset=1e-3)
    for wrong in (moved, heavier, shifted):
        found = accelerations(replace(lattice, bonds=(lattice.bonds[0], wrong)), f)
        assert np.abs(found - lattice.acceleration(f)).max() > 1e-3


COUNTS = {
    ("fput_strain", (1, 0, 0)): 4, ("fput_strain", (1, 0, 1)): 6, ("fput_strain", (1, 1, 1)): 7,
    ("fput", (1, 0, 0)): 4, ("fput", (1, 0, 1)): 6, ("fput", (1, 1, 0)): 6,
    ("mass_dimer", (1, 0, 0)): 8, ("mass_dimer", (1, 0, 1)): 12, ("next_nearest", (1, 0, 1)): 11,
}  # fmt: skip
"""Drift 1; stretch 1; force 0, 2 or 3; difference 1 or 2; kick 1: for each field or bond."""


@pytest.mark.parametrize(("name", "constants"), COUNTS)
def test_absent_terms_are_not_computed(name: str, constants: tuple[int, int, int]) -> None:
    given_ = dict(zip(("K2", "K3", "K4"), constants, strict=True))
    more = {"L2": 1, "L3": 0, "L4": constants[2], "m1": 1, "m2": 2}
    wanted = {str(symbol) for symbol in LATTICES[name].constants}
    lattice = numeric_lattice(
        LATTICES[name], {k: v for k, v in (given_ | more).items() if k in wanted}
    )
    flow, values = stage_plan(lattice)
    assert flow.operations == COUNTS[name, constants]
    text = passage_text(flow, 8, 1, 256, len(values))
    body = text[text.index('@"stages_1"') : text.index('@"passages"')]
    found = sum(body.count(word) for word in ("fmul ", "fadd ", "fsub ", "call "))
    assert found - len(flow.kicked) == flow.operations  # a kick's factor is no row's work


def test_one_machine_code_serves_all_constants() -> None:
    lattice = LATTICES["dimer"]
    names = [str(symbol) for symbol in lattice.constants]
    random = np.random.default_rng(1)
    flows = {
        stage_plan(numeric_lattice(lattice, dict(zip(names, row, strict=True)), (slope,)))[0]
        for row, slope in zip(
            random.uniform(1, 2, (5, len(names))).tolist(), (1, 2, 3, 4, 5), strict=True
        )
    }
    assert len(flows) == 1


def test_fields_without_forces_drift() -> None:
    spring = numbers("beta_fput").bonds[0]
    lattice = NumericLattice("loose", ("u", "v"), (1.0, 2.0), (spring,))
    f, v = np.zeros((2, 40)), np.ones((2, 40))
    advance_chain(lattice, f, v, *(0.5 * part for part in (np.ones(2), np.ones(1))), 3)
    np.testing.assert_allclose(f, 3.0)
    np.testing.assert_array_equal(v, 1.0)


def test_a_constant_stretch_is_a_constant_force() -> None:
    bond = NumericBond((), (Entry((0,), 1.0, 0),), ForceProgram((2.0, 1.0)), 0.5)
    here = NumericBond((Entry((0,), 1.0, 0),), (Entry((0,), -1.0, 0),), ForceProgram((1.0,)))
    lattice = NumericLattice("pulled", ("u",), (1.0,), (here, bond))
    for size in (3, 50):
        np.testing.assert_allclose(accelerations(lattice, np.zeros((1, size))), 1.25)


def test_a_lattice_of_three_dimensions_is_refused() -> None:
    lattice = random_lattice(np.random.default_rng(0), 1.0, axes=3)
    with pytest.raises(ValueError, match="lattice must be a chain or a plane"):
        stage_plan(lattice)


@pytest.mark.parametrize("spoil", [np.float32, np.asfortranarray])
def test_rings_with_another_memory_layout_are_refused(spoil: Callable[[Array], Array]) -> None:
    ring = spoil(np.zeros((3, 2)))
    with pytest.raises(ValueError, match="f must be contiguous doubles"):
        RingKernel(numbers("beta_fput"), 2).advance(ring, ring, np.zeros(2), np.ones(1), 1)

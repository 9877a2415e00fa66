"""Catches: a cell left at rest although a force acts on it, or a result with other bits."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from longwave.derive import LATTICES
from longwave.lattice import SiteForce, State, driven_chain
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.kernels import ring_kernel
from longwave.lattice.kernels.active_cells import shortest_arc
from longwave.lattice.kernels.ring_kernel import RingKernel
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.lattice.schemes import KAHAN_LI_8, MCLACHLAN_4, DriftKick
from longwave.scenes.description.time_functions import time_function
from searches.random_chains import random_chain

CELLS = 203


@pytest.fixture
def searched(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """Search for moving cells in every call, and list the number of cells of each arc advanced."""
    arcs: list[int] = []
    found = RingKernel._moving_arc

    def recorded(kernel: RingKernel, *given: Any) -> Any:
        arc = found(kernel, *given)
        arcs.append(0 if arc is None else arc[0]._count)
        return arc

    monkeypatch.setattr(ring_kernel, "RESTING_MARGIN", 16)
    monkeypatch.setattr(ring_kernel, "MIN_SEARCHED_WORK", 1)
    monkeypatch.setattr(RingKernel, "_moving_arc", recorded)
    return arcs


def advanced(
    lattice: NumericLattice, scheme: DriftKick, start: np.ndarray, steps: int, share: float
) -> np.ndarray:
    """Return fields and velocities after steps of 0.05; arcs are at most ``share`` of the ring."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ring_kernel, "ALONE_FRACTION", share)
        dynamics, ring = Dynamics(lattice), lattice.with_walls(State(0.0, *start.copy()))
        for turn in range(3):  # the arc of one call serves the next
            dynamics.advance(scheme, ring.f, ring.v, 0.05, steps, 0.05 * steps * turn)
    return np.array([ring.f, ring.v])


def numbers(name: str) -> NumericLattice:
    lattice = LATTICES[name]
    return numeric_lattice(lattice, {str(symbol): 1 for symbol in lattice.constants})


PUSH = time_function("push", "cos(9*t/10)/10")
SHAKE = time_function("displacement of a wall", "0.05*sin(13*t/10)")
GRAINS = numeric_lattice(LATTICES["granular"], {"A": 1, "d": 0})
PRESSED = numeric_lattice(LATTICES["granular"], {"A": 1, "d": 0.37})

CHAINS = {
    "struck grains": driven_chain(GRAINS, CELLS, left="free", right="fixed"),
    "grains on a ring": GRAINS,
    "pressed grains": PRESSED,
    "pushed": driven_chain(
        numbers("beta_fput"),
        CELLS,
        left="fixed",
        right="fixed",
        losses=[0.1],
        forces=[SiteForce(25, PUSH)],
    ),
    "shaken": driven_chain(numbers("beta_fput"), CELLS, left=SHAKE, right="free"),
    "shaken at the right": driven_chain(numbers("alpha_fput"), CELLS, left="fixed", right=SHAKE),
    "dimer": numbers("dimer"),
    "next-nearest": numbers("next_nearest"),
    "strains": numbers("fput_strain"),
    "Toda": numbers("toda"),
}


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.parametrize("steps", [1, 9])
@pytest.mark.parametrize("cell", [0, 40, 202])
def test_cells_at_rest_are_left_alone_and_no_bit_changes(
    name: str, steps: int, cell: int, searched: list[int]
) -> None:
    lattice = CHAINS[name]
    start = np.zeros((2, len(lattice.fields), CELLS))
    start[1, :, cell] = 0.3
    for scheme in (MCLACHLAN_4, KAHAN_LI_8):
        searched.clear()
        active = advanced(lattice, scheme, start, steps, 0.5)
        assert 0 < searched[0] < CELLS
        np.testing.assert_array_equal(active, advanced(lattice, scheme, start, steps, 0.0))


@pytest.mark.parametrize("name", ["pushed", "shaken", "shaken at the right"])
def test_what_is_moved_from_outside_moves_a_chain_at_rest(name: str, searched: list[int]) -> None:
    start = np.zeros((2, 1, CELLS))
    active = advanced(CHAINS[name], MCLACHLAN_4, start, 9, 0.5)
    assert 0 < max(searched) < CELLS
    assert np.any(active)
    np.testing.assert_array_equal(active, advanced(CHAINS[name], MCLACHLAN_4, start, 9, 0.0))


def test_a_chain_at_rest_stays_so(searched: list[int]) -> None:
    assert not np.any(advanced(GRAINS, MCLACHLAN_4, np.zeros((2, 1, CELLS)), 9, 0.5))


@given(
    seed=st.integers(0, 2**32),
    parts=st.lists(st.tuples(st.integers(0, CELLS), st.integers(1, 30)), max_size=3),
    steps=st.integers(1, 20),
)
@settings(max_examples=25, deadline=None)
def test_any_chain_and_any_moving_cells(
    seed: int, parts: list[tuple[int, int]], steps: int
) -> None:
    random = np.random.default_rng(seed)
    lattice = random_chain(random, 0.1, reach=2)
    start = np.zeros((2, len(lattice.fields), CELLS))
    for first, count in parts:
        cells = np.arange(first, first + count) % CELLS
        start[:, :, cells] = 0.01 * random.standard_normal((2, len(lattice.fields), count))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ring_kernel, "RESTING_MARGIN", 16)
        patch.setattr(ring_kernel, "MIN_SEARCHED_WORK", 1)
        active, whole = (advanced(lattice, MCLACHLAN_4, start, steps, share) for share in (0.5, 0))
    np.testing.assert_array_equal(active, whole)


@given(st.lists(st.booleans(), min_size=1, max_size=30))
def test_the_shortest_arc_has_all_cells(cells: list[bool]) -> None:
    first, past = shortest_arc(np.array(cells))
    size, inside = len(cells), {place % len(cells) for place in range(first, past)}
    assert {place for place in range(size) if cells[place]} <= inside
    others = [
        length
        for length in range(past - first)
        for begin in range(size)
        if all((place - begin) % size < length for place in range(size) if cells[place])
    ]
    assert not others or not any(cells)

"""Catches: work, heat or power of the wrong cell, end or sign, and integrals of a reduced order."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from longwave.derive import LATTICES
from longwave.lattice import DrivenChain, SiteForce, State, driven_chain, energy_balance
from longwave.lattice.energy_balance import EnergyBalance, Flow
from longwave.lattice.force_program import ForceProgram
from longwave.lattice.integration import CellEngine, StateComparison
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice, numeric_lattice
from longwave.lattice.refine import refine
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.scenes.description.time_functions import time_function

Array = NDArray[np.float64]

BETA = numeric_lattice(LATTICES["beta_fput"], {"K2": 1, "K4": 2})
shake = time_function("displacement of a wall", "0.3*sin(13*t/10)")
push = time_function("force", "0.3*cos(9*t/10)")


def _bond(reach: int, *coefficients: float) -> NumericBond:
    stretch = Entry((reach,), 1.0, 0), Entry((0,), -1.0, 0)
    action = Entry((-reach,), -1.0, 0), Entry((0,), 1.0, 0)
    return NumericBond(stretch, action, ForceProgram(coefficients))


NEXT_NEAREST = NumericLattice(
    "next_nearest", ("u",), (1.0,), (_bond(1, 1.0, 0.2), _bond(2, 0.3, 0.0, 0.5))
)


def power(made: DrivenChain, cuts: list[int], t: float = 0.7) -> tuple[Flow, Array, Array]:
    """Return the power for random fields and velocities, and these, on the whole ring."""
    shape = len(made.fields), 1, made.deviations.shape[1]
    f, v = 0.3 * np.random.default_rng(5).standard_normal((2, *shape))
    found, _ = energy_balance.power(made, f, v, np.array([t]), cuts)
    return Flow(*np.split(found[:, 0], np.cumsum([len(made.drivers), 1]))), f[:, 0], v[:, 0]


def test_walls_and_forces_do_work_and_dashpots_dissipate_it() -> None:
    forces = [SiteForce(3, push)]
    made = driven_chain(BETA, 9, left=shake, right="free", losses=0.2, dashpots=0.1, forces=forces)
    found, f, v = power(made, [])
    wall, speed = 0.3 * np.sin(1.3 * 0.7), 0.39 * np.cos(1.3 * 0.7)
    stretch, rate = f[0, 0] - wall, v[0, 0] - speed
    pull = stretch + 2.0 * stretch**3 + 0.1 * rate
    assert made.drivers == ("left wall", "force 1")
    assert found.work == pytest.approx([-pull * speed, 0.3 * np.cos(0.63) * v[0, 3]], rel=1e-13)
    rates = np.diff(np.append(speed, v[0, :9]))
    assert found.heat[0] == pytest.approx(0.2 * v[0, :9] @ v[0, :9] + 0.1 * rates @ rates)


@pytest.mark.parametrize("ends", [("free", shake), ("fixed", "fixed"), (shake, "free")])
def test_power_goes_through_all_bonds_over_a_cut(ends: tuple[Any, Any]) -> None:
    made = driven_chain(NEXT_NEAREST, 9, left=ends[0], right=ends[1], dashpots=[0.1, 0.2])
    cuts = [2, 5]
    found, f, v = power(made, cuts)
    (u,), (s,) = f, v

    def sent(cell: int, reach: int) -> float:
        stretch, rate = u[cell + reach] - u[cell], s[cell + reach] - s[cell]
        pull = stretch + 0.2 * stretch**2 + 0.1 * rate
        if reach == 2:
            pull = 0.3 * stretch + 0.5 * stretch**3 + 0.2 * rate
        return float(-pull * (s[cell] + s[cell + reach]) / 2.0)

    exact = [sent(cut, 1) + sent(cut, 2) + sent(cut - 1, 2) for cut in cuts]
    assert found.through == pytest.approx(exact, rel=1e-12)


def test_power_goes_from_the_last_field_of_a_cell_to_the_first_of_the_next() -> None:
    lattice = LATTICES["mass_dimer"]
    dimer = numeric_lattice(lattice, {str(symbol): 1 for symbol in lattice.constants})
    found, f, v = power(driven_chain(dimer, 6, left="free", right="fixed"), [2, 5])
    for cut, through in zip((2, 5), found.through, strict=True):
        stretch = f[0, cut + 1] - f[1, cut]
        pull = stretch + stretch**2 + stretch**3
        assert through == pytest.approx(-pull * (v[0, cut + 1] + v[1, cut]) / 2.0, rel=1e-12)


def test_integrals_are_of_order_8_whatever_the_scheme() -> None:
    """Two modes of a linear chain, followed exactly."""
    lattice = numeric_lattice(LATTICES["alpha_fput"], {"K2": 1, "K3": 0})
    made = driven_chain(lattice, 7, left="fixed", right="fixed")
    wavenumber = np.pi * np.array([[2], [5]]) / 8
    shapes, speed = np.sin(wavenumber * np.arange(1, 9)), 2.0 * np.sin(wavenumber[:, 0] / 2.0)

    def state(t: float) -> State:
        f, v = np.cos(speed * t) @ shapes, -(speed * np.sin(speed * t)) @ shapes
        return State(t, f[np.newaxis], v[np.newaxis])

    def right_of_cell_3(t: float) -> float:
        """Return the energy right of cell 3, with half of the cut bond's.

        The middle does not move.
        """
        now = state(t)
        squares = np.diff(now.f[0, 3:]) ** 2
        return float(now.v[0, 4:] @ now.v[0, 4:] + squares.sum() - squares[0] / 2.0) / 2.0

    exact, errors = right_of_cell_3(12.8) - right_of_cell_3(0.0), []
    for steps in (16, 32):
        balance = EnergyBalance(made, [3], state(0.0))
        for t in np.linspace(0.0, 12.8, steps + 1):
            balance.follow(state(t))
        balance.settle()
        errors.append(abs(balance.total.through[0] - exact))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(8.0, abs=0.5)
    assert errors[1] < 1e-6 * abs(exact)


@pytest.mark.parametrize("ends", [("free", "fixed"), ("free", "free"), (shake, "fixed")])
def test_energy_includes_that_of_compressed_grains(ends: tuple[Any, Any]) -> None:
    """Grains push off from free ends; a wall works against their force at rest."""
    grains = numeric_lattice(LATTICES["granular"], {"A": 1, "d": 1})
    made = driven_chain(grains, 6, left=ends[0], right=ends[1])
    start = made.with_walls(State(0.0, *np.zeros((2, 1, 6))))
    cuts = () if made.exchanges_energy else None

    def energies(state: State, balance: EnergyBalance | None) -> Array:
        done = 0.0 if balance is None else balance.total.work.sum()
        return np.array([made.energy(*state.arrays), done])

    times = np.array([0.0, 3.0])
    engine = CellEngine(made, start, times, REDUCED_PHASE_6, StateComparison(energies), cuts=cuts)
    found = refine(engine, 1e-5)
    assert found.trial.values is not None
    (before, _), (after, done) = found.trial.values
    assert np.abs(found.trial.payload[2]).max() > 0.05
    assert after - before == pytest.approx(done, abs=2e-5)

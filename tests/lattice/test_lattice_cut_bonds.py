"""Catches: a cut bond that still acts, in forces, ranges, steps, energies or derivatives."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from longwave.derive.lattice_file import lattice_of
from longwave.lattice import DrivenChain, State, driven_chain, integrate
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.lattice.sensitivities import Sensor, VariedChain
from longwave.lattice.time_integral import Integral
from longwave.scenes.description.time_functions import time_function
from searches.driven_chains import (
    DrivenCase,
    attacked_by_pushing,
    balance_share,
    exact_end,
    true_error,
)

Array = NDArray[np.float64]
END = 8.0


def lattice(force: str, **tables: Any) -> NumericLattice:
    """Return a chain in displacements with these springs and further ones."""
    near = {"between": ["u[n]", "u[n+1]"], "force": force}
    springs = [near, *tables.pop("spring", [])]
    return numeric_lattice(lattice_of({"fields": ["u"], "spring": springs, **tables}, "own"), {})


def wall(velocity: float) -> Any:
    """Return a wall's displacement with that velocity, starting at 0."""
    return Integral.of(time_function("wall", f"{velocity}"), 0.0, END)


def rest(cells: int) -> State:
    return State(0.0, *np.zeros((2, 1, cells)))


LAWS = {
    "power law": lattice("-(1 - x)**1.4"),
    "Lennard-Jones": lattice("2*((1/(1 + x))**7 - (1/(1 + x))**13)"),
    "Toda": lattice("exp(x) - 1"),
    "quartic": lattice("x + 30*x**3"),
    "tied to its place": lattice("x", site=[{"field": "u", "force": "0.2*x + 30*x**3"}]),
    "next nearest": lattice(
        "-(1 - x)**1.4", spring=[{"between": ["u[n]", "u[n+2]"], "force": "-0.3*(2 - x)**1.4"}]
    ),
}
AT_REST = [name for name in LAWS if name not in ("power law", "next nearest")]
"""Force laws that vanish at rest."""


@pytest.mark.parametrize(
    ("law", "place"),
    [
        ("power law", "left"),
        *(pytest.param(law, "left", marks=pytest.mark.slow) for law in LAWS if law != "power law"),
        *(pytest.param(law, "right", marks=pytest.mark.slow) for law in LAWS),
        *(pytest.param(law, "before a free end", marks=pytest.mark.slow) for law in AT_REST),
    ],
)
def test_a_wall_may_go_further_than_a_bond_is_long(law: str, place: str) -> None:
    ends: tuple[Any, Any] = ("fixed", wall(-0.25)) if place == "right" else (wall(0.25), "fixed")
    ends = (ends[0], "free") if place == "before a free end" else ends
    chain = driven_chain(LAWS[law], 12, left=ends[0], right=ends[1])
    case = DrivenCase(law, chain, ends, rest(12), END, 1e-6)
    run, exact = integrate(chain, case.state, [END], 1e-6), exact_end(case)
    assert np.isfinite(exact[0]).all()
    assert true_error(case, run, exact[0]) < run.error_estimate <= 1e-6
    assert run.cost.steps < 2000
    if place != "left":
        assert balance_share(case, exact) < 1.0


def test_cut_bonds_have_no_stretch_and_no_energy() -> None:
    """The bond between both walls, and a bond left out, would be past their pole."""
    chain = driven_chain(
        LAWS["power law"], 24, left=wall(0.25), right="fixed", spring_factors={11: 0.0}
    )
    moved = np.zeros((1, 24))
    moved[0, 12:] = 1.5
    held = chain.with_walls(State(6.0, moved, np.zeros((1, 24))))
    [stretch], [force] = chain.stretches(held.f), chain.forces(held.f)
    cut = chain.bond_shares[0] == 0.0
    assert np.flatnonzero(cut).tolist() == [11, 24]  # and that from wall to wall
    assert not stretch[cut].any()
    assert not force[cut].any()
    least, most = Dynamics(chain).ranges(held)[0]
    assert (least, most) == (stretch[~cut].min(), stretch[~cut].max())
    assert np.isfinite(chain.energy(held.f, held.v))


def test_halves_of_a_cut_chain_may_separate() -> None:
    for law in ("Toda", "Lennard-Jones", "quartic"):
        lone = driven_chain(LAWS[law], 8, left="free", right="free")
        chain = driven_chain(LAWS[law], 16, left="free", right="free", spring_factors={7: 0.0})
        v = np.repeat([-0.5, 0.5], 8)[np.newaxis]
        state = State(0.0, np.zeros((1, 16)), v)
        run = integrate(chain, state, [END], 1e-8)
        half = integrate(lone, State(0.0, np.zeros((1, 8)), v[:, :8]), [END], 1e-8)
        assert np.abs(run.f[-1][:, :8] - half.f[-1]).max() < 1e-7


def test_derivatives_leave_out_cut_bonds() -> None:
    chain = driven_chain(LAWS["power law"], 12, left=wall(0.25), right="fixed")
    read = VariedChain(chain, ()).readings(
        rest(12), np.array([END]), 0.05, [Sensor("displacement", 0, cell) for cell in range(12)]
    )
    run = integrate(chain, rest(12), [END], 1e-9)
    assert np.abs(read[0, :, 0] - run.f[-1, 0]).max() < 1e-8


@pytest.mark.slow
def test_the_search_detects_a_bond_that_is_not_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    found = attacked_by_pushing(11)
    assert found is not None
    assert not found.refusals
    monkeypatch.setattr(DrivenChain, "_cuts", [None])
    found = attacked_by_pushing(11)
    assert found is not None
    assert found.refusals

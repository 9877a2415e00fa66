"""Catches: a kind of force that only some of run, balance, order and derivatives know; a pole or a
jump in time that is run for minutes before it is refused."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from longwave.derive import LATTICES
from longwave.derive.lattice_file import time_formula
from longwave.lattice import DrivenChain, SiteForce, State, driven_chain, integrate
from longwave.lattice.energy_balance import EnergyBalance
from longwave.lattice.force_program import ForceProgram, program_of
from longwave.lattice.integration import CellEngine, StateComparison
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.lattice.outer_forces import shortest_time_scale
from longwave.lattice.schemes import KAHAN_LI_8, REDUCED_PHASE_6, STOERMER_VERLET, Scheme
from longwave.lattice.sensitivities import FreeParameter, Sensor, VariedChain
from longwave.scenes.description.time_functions import time_function

Array = NDArray[np.float64]

BETA = numeric_lattice(LATTICES["beta_fput"], {"K2": 1, "K4": 2})
K = time_function("pull", "-0.5 - 0.3*cos(2*t)")
CELLS, END = 9, 8.0


@dataclass(frozen=True)
class SitePull(SiteForce):
    """``k(t) (u + u^3)`` on a cell."""

    @property
    def law(self) -> ForceProgram:
        """Return a law of two terms, so that it has a unit."""
        return ForceProgram((2.0, 0.0, 2.0))


@dataclass(frozen=True)
class Shaken(SiteForce):
    """Inertial force on all cells of a shaken table."""

    def shares(self, masses: Array) -> Array:
        """Return shares proportional to mass."""
        return -masses


class RootPull(SitePull):
    """``k(t) sqrt(1/4 - u)`` on a cell, and no force on the other cells, which are further away."""

    @property
    def law(self) -> ForceProgram:
        """Return a law that is nan beyond 1/4."""
        return program_of(time_formula("law", "(1/4 - t)**(1/2)"))


def pulled_chain() -> DrivenChain:
    """Return a chain with a wall, a free end, a pull, a force by mass, a heavy cell and losses."""
    forces = [SitePull(3, K), Shaken(0, time_function("base", "0.2*sin(t)"))]
    return driven_chain(
        BETA, CELLS, left="fixed", right="free", losses=0.1, dashpots=0.05, forces=forces,
        mass_factors={3: 2.0},
    )  # fmt: skip


def start() -> State:
    """Return small random displacements and velocities."""
    return State(0.0, *(0.2 * np.random.default_rng(3).standard_normal((2, 1, CELLS))))


def exact(state: State) -> tuple[Array, float]:
    """Return the displacements at the end, and the work done until then, by SciPy."""
    masses = np.where(np.arange(CELLS) == 3, 2.0, 1.0)

    def slopes(t: float, y: Array) -> Array:
        u, v = y[:CELLS], y[CELLS : 2 * CELLS]
        x, rate = (np.diff(np.append(0.0, part)) for part in (u, v))
        bond = np.append(x + 2.0 * x**3 + 0.05 * rate, 0.0)
        outer = -masses * 0.2 * np.sin(t)
        outer[3] += (-0.5 - 0.3 * np.cos(2.0 * t)) * 2.0 * (u[3] + u[3] ** 3)
        return np.concatenate([v, (np.diff(bond) - 0.1 * v + outer) / masses, [outer @ v]])

    begin = np.concatenate([state.f[0], state.v[0], [0.0]])
    found = solve_ivp(slopes, (0.0, END), begin, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    return found[:CELLS], float(found[-1])


def test_a_new_kind_of_force_needs_one_class() -> None:
    made, state = pulled_chain(), start()
    run = integrate(made, state, [END], tolerance=1e-8)
    u, work = exact(state)
    assert np.abs(run.f[-1, 0] - u).max() < run.error_estimate <= 1e-8
    held = made.with_walls(state)

    def worked(_: State, balance: EnergyBalance | None) -> Array:
        assert balance is not None
        return np.array([balance.total.work.sum()])

    engine = CellEngine(
        made, held, np.array([END]), REDUCED_PHASE_6, StateComparison(worked), cuts=[]
    )
    trial = engine.run(replace(engine.first(), step=0.05), True)
    assert trial.values is not None
    assert trial.values[0, 0] == pytest.approx(work, abs=1e-8)


def test_a_law_is_evaluated_only_where_its_force_acts() -> None:
    """Catches: 0 times the root of a negative number, which is nan."""
    made = driven_chain(
        BETA, CELLS, left="fixed", right="free", forces=[RootPull(3, time_function("k", "0.01"))]
    )
    far = start()
    far.f[0, 6:] += 0.4
    run = integrate(made, far, [2.0], tolerance=1e-7, judged=lambda f, v, t: f)

    def slopes(_: float, y: Array) -> Array:
        u, v = y[:CELLS], y[CELLS:]
        x = np.diff(np.append(0.0, u))
        pull = np.diff(np.append(x + 2.0 * x**3, 0.0))
        pull[3] += 0.01 * np.sqrt(0.25 - u[3])
        return np.concatenate([v, pull])

    begin = np.concatenate([far.f[0], far.v[0]])
    u = solve_ivp(slopes, (0.0, 2.0), begin, "DOP853", rtol=1e-12, atol=1e-12).y[:CELLS, -1]
    assert np.abs(run.f[-1, 0] - u).max() < run.error_estimate <= 1e-7
    assert np.isfinite(made.outer_forces[0].at(run.f, run.times, np.ones(CELLS))).all()
    times = np.array([2.0])
    read = VariedChain(made, []).readings(far, times, 0.02, [Sensor("displacement", 0, 5)])
    assert read[0, 0, 0] == pytest.approx(u[5], abs=1e-6)


@pytest.mark.parametrize("scheme", [STOERMER_VERLET, KAHAN_LI_8])
def test_schemes_keep_their_order_with_it(scheme: Scheme) -> None:
    made, state = pulled_chain(), start()
    errors = []
    for steps in (24, 48):
        run = integrate(made, state, [END], scheme=scheme, step=END / steps, measure_error=False)
        errors.append(np.abs(run.f[-1, 0] - exact(state)[0]).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(scheme.order, abs=0.4)


def test_its_derivatives_are_those_of_runs() -> None:
    made, state, sensor = pulled_chain(), start(), Sensor("displacement", 0, 5)
    stiffer = FreeParameter((ForceProgram((1.0,)),), (0.0,), (0.0,), (0.0,))
    found = VariedChain(made, [stiffer]).readings(state, np.array([END]), 0.05, [sensor])[0, 0]
    assert found[0] == pytest.approx(exact(state)[0][5], abs=1e-8)
    size, read = 1e-4, []
    for k2 in (1.0 - size, 1.0 + size):
        lattice = numeric_lattice(LATTICES["beta_fput"], {"K2": k2, "K4": 2})
        moved = replace(made, bonds=lattice.bonds)
        read.append(VariedChain(moved, []).readings(state, np.array([END]), 0.05, [sensor])[0, 0])
    assert found[1] == pytest.approx((read[1] - read[0])[0] / (2.0 * size), rel=1e-5)


@pytest.mark.parametrize("text", ["1/(t - 1/3)", "atan(tan(t))", "1/(t - 1/3)**2", "tan(t)"])
def test_poles_and_jumps_in_time_are_refused_at_once(text: str) -> None:
    with pytest.raises(
        ValueError, match=r"without jumps, got one that is not near t = (0\.3|1\.5)"
    ):
        shortest_time_scale([time_function("force", text)], 0.0, 2.0)


@pytest.mark.parametrize("text", ["1/(t*t - 2*t + 10001/10000)", "tanh(10**9*(t - 1))"])
def test_a_steep_drive_is_not_a_jump(text: str) -> None:
    assert shortest_time_scale([time_function("force", text)], 0.0, 2.0)[0] > 1e-10


def test_chains_with_equal_drives_are_equal() -> None:
    made = pulled_chain()
    assert made == pulled_chain()
    assert hash(made) == hash(pulled_chain())
    for other in (
        replace(made, outer_forces=made.outer_forces[1:]),
        replace(made, deviations=made.deviations + 1e-9),
        replace(made, variation=replace(made.variation, damped=(0.2,))),
        made.ordered,
    ):
        assert made != other

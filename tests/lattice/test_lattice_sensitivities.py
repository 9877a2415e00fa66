"""Catches: a run that differs from the kernel's, a derivative that ignores a wall, loss or mass."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from longwave.derive import LATTICES
from longwave.lattice import DrivenChain, SiteForce, State, driven_chain, integrate
from longwave.lattice import sensitivities as room
from longwave.lattice.force_program import ForceProgram, program_of
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.lattice.sensitivities import FreeParameter, Sensor, VariedChain
from longwave.scenes.description.time_functions import time_function

Array = NDArray[np.float64]
TIMES = np.array([0.0, 1.3, 3.0])
STEP = 0.3
WALL = time_function("wall", "0.1*sin(t)")
ENDS: dict[str, tuple[Any, Any]] = {
    "ring": (None, None),
    "fixed": ("fixed", "fixed"),
    "free": ("free", "fixed"),
    "moved": (WALL, "free"),
    "both moved": (WALL, WALL),
}
SENSORS = (
    *(Sensor("displacement", 0, 2), Sensor("velocity", 0, 5)),
    *(Sensor("strain", 0, 7), Sensor("force", 0, 1), Sensor("force", 0, 7)),
)
FPUT = (
    FreeParameter((ForceProgram((1.0,)),), (0.0,), (0.0,), (0.0,)),
    FreeParameter((ForceProgram((0.0, 0.0, 1.0)),), (0.0,), (0.0,), (0.0,)),
    FreeParameter((None,), (0.0,), (1.0,), (0.0,)),
    FreeParameter((None,), (0.0,), (0.0,), (1.0,)),
)


def state(fields: int = 1) -> State:
    return State(0.0, *(0.3 * np.random.default_rng(0).standard_normal((2, fields, 8))))


def fput(values: Array, ends: tuple[Any, Any]) -> DrivenChain:
    K2, K4, site, bond = values.tolist()
    lattice = numeric_lattice(LATTICES["beta_fput"], {"K2": K2, "K4": K4})
    push = SiteForce(3, time_function("push", "0.3*cos(0.9*t)"))
    left, right = ends
    return driven_chain(
        lattice, 8, left=left, right=right, losses=site, dashpots=bond, forces=[push]
    )


def by_differences(read: Any, values: Array) -> Array:
    """Return fourth-order differences, with which exact derivatives must agree."""
    found, size = [], 3e-4
    for unit in np.eye(values.size):
        two, one, back, far = (read(values + n * size * unit) for n in (2, 1, -1, -2))
        found.append((-two + 8 * one - 8 * back + far) / (12 * size))
    return np.stack(found, axis=-1)


@pytest.mark.parametrize("losses", [(0.0, 0.0), (0.2, 0.0), (0.1, 0.05)])
@pytest.mark.parametrize("ends", ENDS)
def test_the_run_agrees_with_the_kernel(ends: str, losses: tuple[float, float]) -> None:
    chain = fput(np.array([1.0, 2.0, *losses]), ENDS[ends])
    run = integrate(chain, state(), TIMES, step=STEP, measure_error=False)
    read = VariedChain(chain, FPUT).readings(state(), TIMES, STEP, SENSORS)[..., 0]
    np.testing.assert_allclose(read[:, 0], run.f[:, 0, 2], atol=3e-14)
    np.testing.assert_allclose(read[:, 1], run.v[:, 0, 5], atol=3e-14)
    stretch = run.f[:, 0, 2] - run.f[:, 0, 1]
    np.testing.assert_allclose(read[:, 3], stretch + 2 * stretch**3, atol=3e-14)
    if ends == "moved":
        np.testing.assert_array_equal(read[:, 4], 0.0)


@pytest.mark.parametrize(("ends", "small"), [*((ends, room.SMALL) for ends in ENDS), ("moved", 0)])
def test_derivatives_agree_with_differences_of_runs(
    ends: str, small: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room, "SMALL", small)
    values = np.array([1.0, 2.0, 0.1, 0.05])

    def read(at: Array) -> Array:
        chain = fput(at, ENDS[ends])
        return VariedChain(chain, []).readings(state(), TIMES, STEP, SENSORS)[..., 0]

    exact = VariedChain(fput(values, ENDS[ends]), FPUT).readings(state(), TIMES, STEP, SENSORS)
    np.testing.assert_allclose(exact[..., 1:], by_differences(read, values), atol=2e-9)
    np.testing.assert_array_equal(exact[..., 0], read(values))


def test_masses_and_several_fields_have_derivatives() -> None:
    """A mass changes not only the response to forces, but also losses and external forces."""
    lattice = LATTICES["mass_dimer"]
    names = [str(symbol) for symbol in lattice.constants]
    values = np.array([1.0 + 0.3 * place for place in range(len(names))])
    sensors = [Sensor("velocity", 1, 2), Sensor("displacement", 0, 5)]

    def chain(at: Array) -> DrivenChain:
        numeric = numeric_lattice(lattice, dict(zip(names, at.tolist(), strict=True)))
        push = SiteForce(3, time_function("push", "0.3*cos(0.9*t)"), 1)
        ends: dict[str, Any] = {"left": WALL, "right": "fixed"}
        return driven_chain(
            numeric, 8, **ends, losses=[0.1, 0.3], dashpots=[0.05, 0.02], forces=[push]
        )

    at = dict(zip(lattice.constants, values.tolist(), strict=True))
    parameters = [
        FreeParameter(
            tuple(program_of(bond.force.diff(s).subs(at)) for bond in lattice.bonds),
            tuple(float(mass.diff(s).subs(at)) for mass in lattice.masses),
            (0.0, 0.0),
            (0.0, 0.0),
        )
        for s in lattice.constants
    ]
    assert any(any(one.masses) for one in parameters)
    exact = VariedChain(chain(values), parameters).readings(state(2), TIMES, STEP, sensors)

    def read(at: Array) -> Array:
        return VariedChain(chain(at), []).readings(state(2), TIMES, STEP, sensors)[..., 0]

    np.testing.assert_allclose(exact[..., 1:], by_differences(read, values), atol=2e-9)


def test_a_loss_of_zero_has_a_derivative() -> None:
    """The series of a drift must not be cut before a term that only the derivative has."""
    K = 0.7
    lattice = numeric_lattice(LATTICES["beta_fput"], {"K2": K, "K4": 0})
    chain = driven_chain(lattice, 2, left="fixed", right="fixed")
    start = State(0.0, np.array([[1.0, 1.0]]), np.zeros((1, 2)))
    found = VariedChain(chain, FPUT[2:]).readings(start, TIMES, 0.1, [Sensor("displacement", 0, 0)])
    rate = np.sqrt(K)
    np.testing.assert_allclose(found[:, 0, 0], np.cos(rate * TIMES), atol=1e-9)
    damped = -0.5 * (TIMES * np.cos(rate * TIMES) - np.sin(rate * TIMES) / rate)
    np.testing.assert_allclose(found[:, 0, 1], damped, atol=1e-9)
    np.testing.assert_allclose(found[:, 0, 2], damped, atol=1e-9)

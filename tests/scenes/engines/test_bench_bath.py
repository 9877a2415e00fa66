"""A chain in a bath, against the exact covariances of a linear one."""

import re
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov

from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.engines import bench_bath
from longwave.scenes.engines.bench_bath import Bath, BrokenRunError, Means
from longwave.scenes.engines.bench_readings import bench_and_chain
from longwave.scenes.engines.scene_run import run

WARM = load_scene("chain_in_a_bath")


def covariance(cells: int, loss: float, temperature: float, t: float) -> np.ndarray:
    """Means and spreads of displacements and velocities of a chain between walls, from rest."""
    springs = 2.0 * np.eye(cells) - np.eye(cells, k=1) - np.eye(cells, k=-1)
    zero, one = np.zeros((cells, cells)), np.eye(cells)
    flow = np.block([[zero, one], [-springs, -loss * one]])
    noise = np.block([[zero, zero], [zero, 2.0 * loss * temperature * one]])
    final, moved = solve_continuous_lyapunov(flow, -noise), expm(flow * t)
    return np.asarray(final - moved @ final @ moved.T)


@pytest.mark.slow
def test_means_and_spreads_are_those_of_a_linear_chain() -> None:
    found = run(
        WARM.changed(
            observables={"energy": True, "sensors": {"sites": [0, 3]}},
            times=[0, 2, 9],
            tolerance=5e-3,
        )
    )
    for place, t in enumerate(found.time.values):
        exact = covariance(8, 0.5, 1e-3, float(t))
        springs = 2.0 * np.eye(8) - np.eye(8, k=1) - np.eye(8, k=-1)
        energy = 0.5 * (np.trace(exact[8:, 8:]) + np.trace(springs @ exact[:8, :8]))
        assert abs(found.energy.values[place] - energy) <= 1.5 * found.energy_error.values[place]
        assert np.all(
            np.abs(found.sensor_displacement[place]) <= 2.0 * found.sensor_displacement_error[place]
        )
        spread = found.sensor_displacement_spread.values[place]
        # A standard deviation from n runs is known to 1 / sqrt(2 n) of itself; three of these.
        near = 3.0 / np.sqrt(2.0 * found.attrs["runs"])
        np.testing.assert_allclose(spread, np.sqrt(np.diag(exact)[[0, 3]]), rtol=near, atol=1e-12)
    assert found.attrs["error_estimate"] <= 5e-3
    assert found.energy_error.values.max() <= found.attrs["error_estimate"]


def test_steps_cost_as_their_square() -> None:
    """A mode decays in an almost cold bath."""
    cold = WARM.changed(
        noise={"temperature": 1e-30}, start={"mode": {"number": 2, "amplitude": 1}}, times=[0, 8]
    )
    costs = []
    for step in (0.2, 0.1, 0.05):
        bath, means = Bath(cold, *bench_and_chain(cold)), Means()
        bath.step = step
        for number in range(2):
            means.add(*bath.pair(number))
        costs.append(float(means.by_steps.max()))
    np.testing.assert_allclose(np.array(costs[:-1]) / costs[1:], 4.0, rtol=0.02)


def test_the_seed_gives_the_same_bits() -> None:
    scene = WARM.changed(tolerance=3e-3, times=[0, 3])
    first, again = run(scene), run(scene)
    other = run(scene.changed(noise={"temperature": 1e-3, "seed": 2}))
    assert np.array_equal(first.energy, again.energy)
    assert not np.array_equal(first.energy, other.energy)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"noise": {"temperature": 0}}, "temperature in [noise] must"),
        ({"noise": {"temperature": "hot"}}, "temperature in [noise] must"),
        ({"noise": {}}, "temperature in [noise] must"),
        ({"noise": {"temperature": 1, "seed": -1}}, "seed in [noise] must"),
        ({"noise": {"heat": 1}}, "keys in [noise] must be known ones, got heat"),
        ({"noise": 3}, "noise must be a table"),
        ({"losses": {"site": 0}}, "site in [losses] must be given with [noise], got 0"),
        ({"losses": {"site": {"u": 0}}}, "site in [losses] must be given with [noise], got"),
        ({"losses": {"site": 1, "bond": 0.1}}, "bond in [losses] must be left out with [noise]"),
        ({"tolerance": 1e-7}, "tolerance must be one that 100000 runs reach, got 1e-07"),
    ],
)
def test_wrong_baths_are_refused(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match="^" + re.escape(message) + ".*$"):
        run(WARM.changed(**changed))


@pytest.mark.parametrize("temperature", [1e4, pytest.param(1e6, marks=pytest.mark.slow)])
def test_a_hot_chain_that_is_bound_does_not_fly_apart(temperature: float) -> None:
    """Catches: a step that does not follow the temperature; means are those of equipartition."""
    hot = WARM.changed(
        lattice="beta_fput",
        constants={"K2": 1, "K4": 1},
        chain={"sites": 2, "left": "fixed", "right": "fixed"},
        noise={"temperature": temperature, "seed": 1},
        observables={"energy": True},
        losses={"site": 2},
        times=[0, 2],
        tolerance=0.4 * temperature,
    )
    found = run(hot)
    energy, error = float(found.energy[-1]), float(found.energy_error[-1])
    assert error <= 0.4 * temperature
    assert abs(energy - 2 * (0.5 + 0.25) * temperature) < error


def test_a_run_that_breaks_down_is_made_again_with_a_shorter_step(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Catches: a bath that does not detect strains beyond those of its first step."""
    monkeypatch.setattr(bench_bath, "HOT_BOND_ENERGY", 0.0)
    hot = WARM.changed(
        lattice="beta_fput",
        constants={"K2": 1, "K4": 1},
        chain={"sites": 2, "left": "fixed", "right": "fixed"},
        noise={"temperature": 1e6, "seed": 1},
        observables={"energy": True},
        times=[0, 3],
        tolerance=3e6,
    )
    bath = Bath(hot, *bench_and_chain(hot))
    first = bath.step
    with pytest.raises(BrokenRunError):
        bath.pair(0)
    assert bath.shorten_step(BrokenRunError(1.0))
    assert bath.step < 0.3 * first
    while bath.shorten_step(None):
        bath.pair(0)
    assert np.isfinite(bath.pair(0)).all()


def test_a_chain_that_flies_apart_is_told_with_the_steps_that_were_tried() -> None:
    soft = WARM.changed(
        constants={"K2": 1, "K3": 1}, noise={"temperature": 1.0, "seed": 1}, tolerance=0.1
    )
    with pytest.raises(
        ValueError, match=r"must end before the chain flies apart, .* steps down to 0\."
    ):
        run(soft)

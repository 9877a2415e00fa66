"""The spectral engine of any lattice against the plain one, and its error estimates."""

from dataclasses import replace

import numpy as np
import pytest

from longwave.lattice import State, integrate
from longwave.lattice.spectral.field_ring import FieldRing
from longwave.lattice.spectral.ring_search import resolving_step
from longwave.lattice.spectral.spectral_integration import FieldRingEngine, spectral_integrate
from tests.lattice.random_lattices import random_lattice, reference, smooth_or_rough
from tests.lattice.test_lattice_any_chain import torn
from tests.lattice.test_numeric_lattice import numbers

REFERENCE = 1e-10
"""Relative error of the reference solution."""


def shortfall(seed: int) -> tuple[str, float]:
    """Return the outcome of a random lattice's ring, and the true error over the estimate."""
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-2, 1)
    axes = int(random.choice([1, 1, 2]))
    chain = random_lattice(random, size, axes)
    sites = tuple(int(n) for n in random.choice([7, 8, 12, 20] if axes == 1 else [7, 8], axes))
    many = int(random.choice([1, 1, 2, 3])) if axes == 1 else 1
    width = random.choice([0.7, 1.2, np.inf])
    counts = tuple(many * n for n in sites)
    fields = len(chain.fields)
    fastest = chain.highest_frequency(chain.rest_slopes())
    f = smooth_or_rough(random, size, fields, counts, width)
    v = smooth_or_rough(random, size, fields, counts, width) * random.choice([0, 0.1, 0.5])
    times = np.cumsum(10.0 ** random.uniform(-0.5, 1.3, int(random.integers(1, 3)))) / fastest
    speed = tuple(random.choice([0.0, 0.3, 1.0]) * fastest * random.uniform(0.2, 0.6, axes))
    tolerance = size * 10.0 ** random.uniform(-8, -2.5)
    ring = FieldRing(1.5, (0.0,) * axes, tuple(map(float, sites)), f, fastest * v)
    lattice_of = (slice(None), *(slice(None, None, many),) * axes)
    exact = reference(chain, f[lattice_of], fastest * v[lattice_of], times)
    if exact is None:
        return "no reference", 0.0
    try:
        run = spectral_integrate(chain, ring, 1.5 + times, tolerance, speed)
    except ValueError as refusal:
        return str(refusal), 0.0
    assert run.error_estimate <= tolerance
    found = np.array([state.f[lattice_of] for state in run.states])
    pairs = zip(found, exact, strict=True)
    misses = [np.array(chain.stretches(one)) - chain.stretches(other) for one, other in pairs]
    error = float(np.max(np.abs(misses)))
    return "told", error / (run.error_estimate + REFERENCE * float(np.max(np.abs(exact))))


def worst(seeds: range) -> tuple[int, float]:
    """Return how many runs had an error estimate, and their largest true error over estimate."""
    found = [shortfall(seed) for seed in seeds]
    told = [ratio for word, ratio in found if word == "told"]
    odd = [word for word, _ in found if word not in ("told", "no reference")]
    assert all(word.startswith(("times must end", "tolerance must")) for word in odd), odd
    return len(told), max(told)


def test_estimates_bound_the_error_on_random_lattices() -> None:
    told, ratio = worst(range(8))
    assert told > 6
    assert ratio <= 1.0


@pytest.mark.slow
def test_estimates_bound_the_error_on_many_lattices() -> None:
    told, ratio = worst(range(3000, 3040))
    assert told > 33
    assert ratio <= 1.0


CHAIN = numbers("dimer")


def packet(points: int, size: float = 0.1) -> FieldRing:
    """Return a long wave that runs to the right of a dimer, on a ring of 80.5 cells."""
    x = 80.5 / points * np.arange(points)
    f = np.repeat(size * np.exp(-(((x - 40.0) / 8.0) ** 2))[None], 2, axis=0)
    return FieldRing(0.0, (0.0,), (80.5,), f, f * 2.0 * (x - 40.0) / 64.0)


def test_a_ring_of_real_circumference_agrees_with_a_long_chain() -> None:
    """Compared with a long chain started from the ring's fields at x + n, far from its ends."""
    run = spectral_integrate(CHAIN, state := packet(160), [5.0, 25.0], 1e-6, speed=0.6)
    cells = 0.37 + np.arange(-80, 80)
    exact = reference(CHAIN, state.at(cells), state.velocities_at(cells), [5.0, 25.0])
    assert exact is not None
    inner = slice(45, -45)
    for found, fields in zip(run.states, exact, strict=True):
        misses = zip(CHAIN.stretches(found.at(cells)), CHAIN.stretches(fields), strict=True)
        miss = np.array([np.abs(one - other)[inner] for one, other in misses])
        assert np.max(miss) <= run.error_estimate <= 1e-6


def test_a_run_of_length_zero_returns_the_start() -> None:
    run = spectral_integrate(CHAIN, state := packet(160), [state.t], 1e-6, 0.6)
    [found] = run.states
    np.testing.assert_allclose(found.at(cells := np.arange(80.0)), state.at(cells), atol=1e-6)


def test_the_tolerance_is_that_of_the_judged_quantity() -> None:
    places = np.linspace(0.0, 80.0, 33)

    def strain(ring: FieldRing) -> np.ndarray:
        return ring.at(places)[1] - ring.at(places)[0]

    run, exact = (
        spectral_integrate(CHAIN, packet(160), [30.0], tolerance, 0.6, judged=strain)
        for tolerance in (1e-5, 1e-9)
    )
    error = np.max(np.abs(strain(run.states[0]) - strain(exact.states[0])))
    assert error <= run.error_estimate <= 1e-5
    assert run.cost.steps < exact.cost.steps


def test_points_are_as_many_as_the_wave_needs() -> None:
    """A long wave given with many points is run with few, and steep data with more."""
    many = spectral_integrate(CHAIN, packet(1024), [10.0], 1e-4, 0.6)
    assert many.states[0].counts[0] < 256
    run = spectral_integrate(CHAIN, packet(32), [10.0], 1e-6, 0.6)
    assert run.states[0].counts[0] > 40


def test_a_control_run_has_more_points_than_the_fewest() -> None:
    """A wave that a quarter of the fewest points resolves is sampled more densely, too."""
    state = packet(16)
    long = replace(state, f=np.cos(2 * np.pi * np.arange(16) / 16) * np.ones((2, 1)), v=0 * state.v)
    search = FieldRingEngine(CHAIN, long.sampled((96,)), np.array([1.0]), (0.6,), 1e-2)
    first = search.run(search.first(), False)
    control = search.run(search.control(search.first(), search.kinds), True)
    fewest, more = (trial.payload[1][0]["f"].shape[1] for trial in (first, control))
    assert fewest == 8
    assert more == 10


def test_a_frame_that_moves_with_the_wave_takes_longer_steps() -> None:
    x = 120.5 / 128 * np.arange(128)
    u = 0.5 / np.cosh((x - 60.0) / 6.0)
    state = FieldRing(0.0, (0.0,), (120.5,), u[None], (u * np.tanh((x - 60.0) / 6.0) / 6.0)[None])
    with_it, still = (
        spectral_integrate(numbers("beta_fput"), state, [100.0], 1e-5, speed)
        for speed in (1.0, 0.0)
    )
    assert np.max(np.abs(with_it.states[0].at(x) - still.states[0].at(x))) < 2e-5
    assert with_it.cost.steps < 0.5 * still.cost.steps


def test_a_force_that_becomes_undefined_is_refused() -> None:
    """A chain is stretched until its force is undefined."""
    chain = torn("granular")
    x = np.arange(16.0)
    pulled = FieldRing(0.0, (0.0,), (16.0,), 0.4 * np.cos(np.pi * x / 2)[None], 0 * x[None])
    hard = replace(pulled, v=3.0 * np.sin(np.pi * x / 2)[None])
    with pytest.raises(ValueError, match="times must end before the fields of granular run away"):
        spectral_integrate(chain, hard, [20.0], 1e-4)
    with pytest.raises(ValueError, match="state must stretch the bonds of granular to where"):
        spectral_integrate(chain, replace(pulled, f=4 * pulled.f), [20.0], 1e-4)


@pytest.mark.parametrize(
    ("changed", "options", "message"),
    [
        ({"f": np.zeros((1, 8))}, {}, r"state.f must have the shape \(fields, \*cells\) of 2"),
        ({"v": np.zeros((2, 7))}, {}, r"state.v must have the shape .* got \(2, 7\)"),
        ({"f": np.full((2, 160), np.nan)}, {}, "state.f must be finite, got nan at index"),
        ({"circumferences": (-1.0,)}, {}, "circumference must satisfy 0 < circumference < inf"),
        ({"left": (0.0, 0.0)}, {}, "state.left and state.circumferences must have 1 entries"),
        ({}, {"tolerance": 0.0}, "tolerance must satisfy 0 < tolerance < inf, got 0.0"),
        ({}, {"speed": (1.0, 0.0)}, "speed must have one finite entry for each of 1 axes"),
        ({}, {"times": [2.0, 1.0]}, "times must increase from state.t = 0 on, got 1 at index 1"),
        ({}, {"tolerance": 1e-17}, "tolerance must satisfy tolerance >= "),
    ],
)
def test_invalid_arguments_are_refused(
    changed: dict[str, object], options: dict[str, object], message: str
) -> None:
    given: dict[str, object] = {"times": [3.0], "tolerance": 1e-5, **options}
    state = replace(packet(160), **changed)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=message) as caught:
        spectral_integrate(CHAIN, state, **given)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def spread_shortfall(seed: int) -> float | None:
    """Return the true error over the estimate of a steep crest on many lattices; None if refused.

    Steps that do not resolve how it passes the sites would make all of them run alike.
    """
    random = np.random.default_rng(seed)
    chain = numbers(str(random.choice(["beta_fput", "toda", "fput", "granular"])))
    sites, many = int(random.choice([48, 64])), int(random.choice([4, 5, 6]))
    width, height = random.uniform(1.2, 4.0), random.uniform(0.05, 0.6)
    x = np.arange(sites * many) / many - sites / 2
    u = height * np.exp(-((x / width) ** 2))[None]
    v = random.uniform(0.9, 1.1) * 2.0 * x / width**2 * u
    tolerance, end = height * 10.0 ** random.uniform(-6, -2), 10.0 ** random.uniform(1, 2.3)
    ring = FieldRing(0.0, (0.0,), (float(sites),), u, v)
    if random.random() < 0.5:
        ring = replace(ring.sampled((int(1.37 * sites * many),)))
    speed = random.uniform(0.9, 1.2)
    try:
        run = spectral_integrate(chain, ring, [end], tolerance, speed)
        cells = [ring.sampled((sites * many,)).f[:, j::many] for j in range(many)]
        speeds = [ring.sampled((sites * many,)).v[:, j::many] for j in range(many)]
        found = run.states[0].sampled((sites * many,)).f
        misses = []
        for j, (f, s) in enumerate(zip(cells, speeds, strict=True)):
            exact = integrate(chain, State(0.0, f, s), [end], 1e-4 * tolerance).f[0]
            miss = np.array(chain.stretches(found[:, j::many])) - chain.stretches(exact)
            misses.append(float(np.max(np.abs(miss))))
    except ValueError as refusal:
        if not str(refusal).startswith(("times must end", "tolerance must", "state must stretch")):
            raise
        return None
    return max(misses) / (run.error_estimate + 1e-4 * tolerance)


def test_estimates_include_the_spread_of_lattices_on_a_ring() -> None:
    found = [ratio for ratio in map(spread_shortfall, range(2, 5)) if ratio is not None]
    assert len(found) > 1
    assert max(found) <= 1.0


@pytest.mark.slow
def test_estimates_include_the_spread_of_many_lattices_on_a_ring() -> None:
    found = [ratio for ratio in map(spread_shortfall, range(100, 114)) if ratio is not None]
    assert len(found) > 8
    assert max(found) <= 1.0


def test_a_short_crest_is_run_with_steps_that_resolve_the_sites() -> None:
    """A wider crest, however long its steps, has the same energy on all lattices of its ring."""
    x = np.arange(240) / 5.0 - 24.0
    steps = []
    for width in (1.3, 4.0):
        u = 0.4 * np.exp(-((x / width) ** 2))[None]
        ring = FieldRing(0.0, (0.0,), (48.0,), u, 2.0 * x / width**2 * u)
        steps.append(spectral_integrate(numbers("beta_fput"), ring, [12.0], 4e-3, 1.0).step)
    assert steps[0] <= resolving_step(1.0) < steps[1]

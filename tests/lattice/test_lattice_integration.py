"""Catches: an estimate below the error, a time that is missed, a blow-up that is not detected."""

import math
import tracemalloc
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from longwave import lattice
from longwave.lattice import Composition, Model, State, Trajectory, integrate
from longwave.lattice.model import Array
from longwave.lattice.schemes import KAHAN_LI_8, RK4, SCHEMES
from longwave.reports.studies.doubledouble_ring import advance_doubled, doubled


def reference(model: Model, state: State, times: Array, largest: float) -> Array:
    """Return strains at the times by double-double steps a twentieth of the stable step."""
    strains = np.linspace(-largest, largest, 101)
    highest = 2.0 * math.sqrt(max(float(np.abs(model.stiffness(strains)).max()), model.K2))
    y, s, t, rows = doubled(state.f[0]), doubled(state.v[0]), state.t, []
    for end in times:
        steps = max(1, math.ceil((end - t) * highest / 0.12))
        advance_doubled(KAHAN_LI_8, y, s, (end - t) / steps, steps, model)
        rows.append(y.sum(axis=-1))
        t = end
    return np.array(rows)


def random_case(seed: int) -> tuple[Model, State, Array, float]:
    """Return a random model, state, times and tolerance, over their whole ranges."""
    random = np.random.default_rng(seed)
    K2, a = 10.0 ** random.uniform(-2, 2), 10.0 ** random.uniform(-2, 1)
    K3 = random.choice([0, 1, 1]) * random.uniform(-1, 1) * K2 / a
    K4 = random.choice([0, 1, 1]) * random.uniform(-1, 1) * K2 / a**2
    highest, size = 2.0 * math.sqrt(K2), int(random.choice([3, 4, 7, 16, 33, 64, 128, 200]))
    y = a * random.choice([0, 0.1, 0.3, 0.5]) * random.standard_normal(size)
    s = a * random.choice([0, 0.1, 0.3, 0.5]) * random.standard_normal(size) * highest
    t0, duration = random.choice([0.0, -3.7, 1000.0]), 10.0 ** random.uniform(-1, 2) / highest
    times = t0 + np.sort(random.uniform(0, duration, random.choice([1, 2, 5])))
    tolerance = 10.0 ** random.uniform(-9, -3) * random.choice([a, 1.0])
    model = Model(float(K2), float(K3), float(K4))
    return model, State(t0, y[None], s[None]), times, float(tolerance)


def shortfall(seed: int) -> float | None:
    """Return the true error in units of the estimate; None if the run is refused."""
    model, state, times, tolerance = random_case(seed)
    try:
        run = integrate(model.lattice, state, times, tolerance)
    except ValueError as refusal:
        if not str(refusal).startswith(("times must end", "tolerance must satisfy")):
            raise
        return None
    assert run.error_estimate <= tolerance
    largest = max(np.abs(run.f).max(), np.abs(state.f).max())
    error = np.abs(run.f[:, 0] - reference(model, state, times, float(largest))).max()
    return float(error) / max(run.error_estimate, 1e-300)


def test_estimates_bound_the_error_on_random_models_and_states() -> None:
    found = [shortfall(seed) for seed in (2878, *range(30))]
    told = [ratio for ratio in found if ratio is not None]
    assert len(told) > 22
    assert max(told) <= 1.0


@pytest.mark.slow
def test_estimates_bound_the_error_at_length() -> None:
    found = [shortfall(seed) for seed in range(1000, 1800)]
    told = [ratio for ratio in found if ratio is not None]
    assert len(told) > 530
    assert max(told) <= 1.0


def modes(state: State, K2: float, t: float) -> tuple[Array, Array]:
    """Return the linear ring at time ``t`` by its normal modes."""
    y, s = np.fft.fft(state.f[0]), np.fft.fft(state.v[0])
    w = 2.0 * math.sqrt(K2) * np.abs(np.sin(np.pi * np.arange(state.size) / state.size))
    turn = w * (t - state.t)
    held = np.where(w > 0.0, np.sin(turn) / np.where(w > 0.0, w, 1.0), t - state.t)
    return np.fft.ifft(y * np.cos(turn) + s * held).real, np.fft.ifft(
        s * np.cos(turn) - y * w * np.sin(turn)
    ).real


@pytest.mark.parametrize("scheme", SCHEMES, ids=lambda scheme: scheme.name)
@pytest.mark.parametrize("size", [3, 64])
def test_a_linear_chain_follows_its_normal_modes(scheme: lattice.Scheme, size: int) -> None:
    random = np.random.default_rng(size)
    state = State(2.0, *random.standard_normal((2, 1, size)))
    times, tolerance = [2.0, 5.5, 20.0], 1e-4 if scheme.order < 6 else 1e-8
    run = integrate(Model(1.7, 0.0, 0.0).lattice, state, times, tolerance, scheme=scheme)
    for place, t in enumerate(times):
        y, s = modes(state, 1.7, t)
        assert np.abs(run.f[place] - y).max() <= run.error_estimate <= tolerance
        assert np.abs(run.v[place] - s).max() <= 10.0 * tolerance
    np.testing.assert_array_equal(run.f[0], state.f)


ROUGH = State(0.0, *0.4 * np.random.default_rng(8).standard_normal((2, 1, 64)))
ROUGH.v -= ROUGH.v.mean()
MODEL = Model(1.0, 0.3, 1.0)
CHAIN = MODEL.lattice


def test_the_energy_is_conserved_as_accurately_as_the_strain() -> None:
    run = integrate(CHAIN, ROUGH, [10.0, 30.0], 1e-9)
    before = MODEL.energy(ROUGH)
    for f, v in zip(run.f, run.v, strict=True):
        assert MODEL.energy(State(0.0, f, v)) == pytest.approx(before, rel=1e-8)


def test_integrating_back_leads_to_the_start() -> None:
    there = integrate(CHAIN, ROUGH, [12.0], 1e-10)
    turned = State(0.0, there.f[0], -there.v[0])
    back = integrate(CHAIN, turned, [12.0], 1e-10)
    np.testing.assert_allclose(back.f[0], ROUGH.f, rtol=0, atol=1e-7)
    np.testing.assert_allclose(back.v[0], -ROUGH.v, rtol=0, atol=1e-7)


def test_tighter_tolerances_agree_within_their_estimates() -> None:
    runs = [integrate(CHAIN, ROUGH, [5.0, 15.0], 10.0**-k) for k in (3, 5, 7, 9)]
    for coarse, fine in pairwise(runs):
        change = np.abs(coarse.f - fine.f).max()
        assert change <= coarse.error_estimate + fine.error_estimate
        assert coarse.cost.force_evaluations < fine.cost.force_evaluations


def test_a_ring_that_begins_elsewhere_is_the_same_ring() -> None:
    """Sites are stored at n mod size: a state that begins at 10 returns its sites in order."""
    moved = State(0.0, np.roll(ROUGH.f, 10), np.roll(ROUGH.v, 10), left=10)
    plain, other = (integrate(CHAIN, state, [3.0], 1e-8) for state in (ROUGH, moved))
    np.testing.assert_allclose(other.f, plain.f, rtol=0, atol=2e-8)


def test_the_state_is_unchanged_and_may_have_integers() -> None:
    state = State(0.0, np.array([[0, 1, 0, -1]]), np.zeros((1, 4), dtype=int))
    integrate(CHAIN, state, 1.0, 1e-6)
    assert state.f.tolist() == [[0, 1, 0, -1]]
    integrate(CHAIN, State(0, [[0, 1, 0, -1]], [[0] * 4]), 1, 1e-6)  # type: ignore[arg-type]


def stated(**settings: object) -> Trajectory:
    return integrate(CHAIN, ROUGH, [10.0], **settings)  # type: ignore[arg-type]


def test_a_given_step_is_used_and_its_error_is_measured() -> None:
    exact = integrate(CHAIN, ROUGH, [10.0], 1e-10).f
    for scheme, step in ((RK4, 0.05), (RK4, 0.01), (KAHAN_LI_8, 0.4)):
        run = stated(scheme=scheme, step=step)
        error = np.abs(run.f - exact).max()
        assert 0.05 * run.error_estimate < error <= run.error_estimate
        assert (run.scheme, run.step, run.cost.steps) == (scheme.name, step, round(10 / step))
        bare = stated(scheme=scheme, step=step, measure_error=False)
        assert math.isnan(bare.error_estimate)
        np.testing.assert_array_equal(bare.f, run.f)


def test_the_error_of_a_step_that_the_times_shorten_is_measured_too() -> None:
    """Steps of 0.6 and of half of it both give one step of 0.25 between two times."""
    times = np.arange(0.25, 4.1, 0.25)
    exact = integrate(CHAIN, ROUGH, times, 1e-9).f
    run = integrate(CHAIN, ROUGH, times, scheme=RK4, step=0.6)
    assert run.cost.steps == times.size
    assert 1e-5 < np.abs(run.f - exact).max() <= run.error_estimate


def test_a_blow_up_is_reported_with_its_time() -> None:
    """y'' = D(y - y^3) from beyond the barrier reaches infinity soon."""
    soft = Model(1.0, 0.0, -1.0).lattice
    state = State(0.0, np.array([[3.0, -3.0, 3.0, -3.0]]), np.zeros((1, 4)))
    told = r"times must end before the lattice blows up, got 5 \(blow-up: .* at t = 0\.\d+, site"
    with pytest.raises(ValueError, match=told):
        integrate(soft, state, [0.1, 5.0], 1e-6)
    with pytest.raises(ValueError, match=told):
        integrate(soft, state, [0.1, 5.0], step=0.01)
    before = integrate(soft, state, [0.06], 1e-6)
    assert before.error_estimate <= 1e-6


def test_strains_without_waves_are_no_blow_up() -> None:
    """V'' < 0 somewhere: disturbances grow there, and the ring goes on."""
    model, state = Model(1.0, 0.0, 1.0), replace(ROUGH, f=1.5 * ROUGH.f)
    soft = Model(1.0, 2.5, 1.7)
    assert soft.stiffness(state.f).min() < 0.0
    assert integrate(soft.lattice, state, [2.0], 1e-7).error_estimate <= 1e-7
    assert integrate(model.lattice, state, [2.0], 1e-7).error_estimate <= 1e-7


def test_a_tolerance_below_rounding_is_refused() -> None:
    with pytest.raises(ValueError, match=r"tolerance must satisfy tolerance >= .* got 1e-16"):
        integrate(CHAIN, ROUGH, [10.0], 1e-16)


def test_rounding_amplified_by_chaos_is_reported() -> None:
    """Neighbouring strains separate like exp(0.2 t) here: 1e-16 has become 1e-7."""
    wild = replace(ROUGH, f=2.5 * ROUGH.f, v=2.5 * ROUGH.v)
    with pytest.raises(ValueError, match=r"got 1e-09 \(neighbouring states of the lattice part"):
        integrate(CHAIN, wild, [100.0], 1e-9)


WRONG = {
    "either tolerance or step must be given, got tolerance None and step None": {},
    "either tolerance or step must be given, got tolerance 0.1 and step 0.1": {
        "tolerance": 0.1,
        "step": 0.1,
    },
    "tolerance must satisfy 0 < tolerance < inf, got -1": {"tolerance": -1.0},
    "tolerance must satisfy 0 < tolerance < inf, got nan": {"tolerance": math.nan},
    "step must satisfy 0 < step < inf, got 0": {"step": 0.0},
    "step must satisfy 0 < step < inf, got '0.1'": {"step": "0.1"},
    "step must satisfy step <= ": {"step": 5.0},
    "wrong must satisfy the conditions of order 4": {
        "tolerance": 0.1,
        "scheme": Composition("wrong", 4, ("1",), ""),
    },
}


@pytest.mark.parametrize("message", WRONG)
def test_invalid_arguments_are_refused_in_one_line(message: str) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        stated(**WRONG[message])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("times", "message"),
    [
        ([], "times must be one or more finite numbers"),
        ("soon", "every time must be a real number, got 'soon'"),
        ([[1.0]], "times must be one or more finite numbers"),
        (np.ones((3, 3)), "times must be one or more finite numbers"),
        ([1.0, math.inf], "every time must be finite"),
        ([-1.0, 2.0], r"times must increase from state.t = 0 on, got -1 at index 0"),
        ([1.0, 3.0, 2.0], r"times must increase from state.t = 0 on, got 2 at index 2"),
        ([1.0, 1.0], r"times must increase from state.t = 0 on, got 1 at index 1"),
    ],
)
def test_wrong_times_are_refused(times: list[float], message: str) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        integrate(CHAIN, ROUGH, times, 1e-3)
    assert "\n" not in str(caught.value)


def test_forces_that_overflow_are_refused() -> None:
    with pytest.raises(ValueError, match=r"state must have .* finite, got a stretch of"):
        integrate(Model(1.0, 1e300, 1e300).lattice, replace(ROUGH, f=1e10 * ROUGH.f), [1.0], 1e-3)


def test_far_from_zero_each_time_is_returned_once() -> None:
    """Of 10 steps in 160 at t = 1e17 most end at the same number."""
    far = replace(ROUGH, t=1e17)
    run = integrate(CHAIN, far, [1e17 + 16, 1e17 + 32], step=0.5)
    near = integrate(CHAIN, ROUGH, [16.0, 32.0], step=0.5)
    np.testing.assert_array_equal(run.f, near.f)


def test_a_ring_at_rest_stays() -> None:
    run = integrate(CHAIN, State(0.0, np.zeros((1, 16)), np.zeros((1, 16))), [1.0, 1e3], 1e-9)
    assert not run.f.any()
    assert not run.v.any()


def test_the_package_exports_its_names() -> None:
    assert all(getattr(lattice, noun) is not None for noun in lattice.__all__)


def test_a_large_ring_takes_few_bytes_a_site() -> None:
    """Catches: every run of the search stored whole, 331 bytes per site. Its state alone has 16."""
    sites = 2**20
    wave = 0.1 * np.cos(np.arange(sites) * (2.0 * np.pi / 64))[np.newaxis]
    state = State(0.0, wave, np.zeros((1, sites)))
    small = State(0.0, wave[:, :64].copy(), np.zeros((1, 64)))
    integrate(Model(1.0, 0.0, 1.0).lattice, small, [1.0], tolerance=1e-4)  # imports
    tracemalloc.start()
    try:
        found = integrate(Model(1.0, 0.0, 1.0).lattice, state, [20.0], tolerance=1e-4)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert found.error_estimate <= 1e-4
    assert peak < 140 * sites

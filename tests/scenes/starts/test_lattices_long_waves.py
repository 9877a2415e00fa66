"""Long waves on lattices: initial data, compared quantities, first correction, measured rates."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy import Integer, Rational

from longwave.derive import LATTICES, Reduction, Scaling, SlowVariable, reduce
from longwave.derive.symbols import c
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.scenes.convergence import fitted_rate, scene_convergence
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.rate_cases import rate_cases
from longwave.scenes.starts import first_correction
from longwave.scenes.starts.computed_soliton import ComputedSoliton
from longwave.scenes.starts.fourier_interval import FourierInterval
from longwave.scenes.starts.jet_polynomial import JetPolynomial
from longwave.scenes.starts.lattice_derivation import derivation, lattice_wave, wave_of
from longwave.scenes.starts.long_wave_data import LongWaveData, wave_ends
from longwave.scenes.starts.long_wave_numbers import long_wave
from longwave.solutions import Wave, closed_form
from searches.soak_scenes import soak_scene

FAST = {"1": "leading", "4b": "leading"}
"""Cases measured in every test run, at three eps."""


def scene_of(name: str, at: float = 0.1, order: str = "slaved") -> Scene:
    return rate_cases()[name].scene.changed(eps=at, order=order)


def data_of(name: str, at: float = 0.1, order: str = "slaved") -> LongWaveData:
    found = lattice_wave(scene_of(name, at, order))
    assert isinstance(found, LongWaveData)
    return found


def reduction_of(name: str) -> Reduction:
    found = derivation(scene_of(name)).source
    assert isinstance(found, Reduction)
    return found


@pytest.mark.parametrize(("name", "order"), FAST.items())
def test_lattice_comes_near_the_wave_at_the_rate_of_its_row(name: str, order: str) -> None:
    study = scene_convergence(scene_of(name, order=order), rate_cases()[name].eps[1:])
    for found in study.points:
        assert found.discretisation < 0.01 * found.error
    assert study.rate.value == pytest.approx(study.theory, abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("name", rate_cases())
def test_measured_rates(name: str) -> None:
    case = rate_cases()[name]
    for order in case.orders:
        study = case.study(order)
        assert study.reached, (order, study.rate)
        for found in study.points:
            assert found.discretisation < 0.05 * found.error


def test_the_next_order_is_two_powers_better() -> None:
    scene = scene_of("2", order="corrected").changed(slow_times=(0.0, 0.5))
    found = scene_convergence(scene, (0.2, 0.14, 0.1))
    assert found.rate.value == pytest.approx(6.0, abs=0.25)


def test_a_narrow_wave_is_sampled_finely_and_one_too_narrow_refused() -> None:
    """Catches: a wrong correction of a narrow wave, sampled as coarsely as a broad one."""
    cells, found = np.arange(60.0, 141.0), []
    reduction, wave = reduction_of("2"), wave_of(scene_of("2"))
    for half in (24.0, 72.0):
        data = long_wave(reduction, {}, wave, 0.1, "corrected", interval=(-half, half))
        data.start(0.0)
        found.append(data.strain(cells, 100.0))
    change = np.abs(found[0] - data_of("2").strain(cells, 100.0)).max()
    assert found[0] == pytest.approx(found[1], abs=1e-5 * change)
    data = long_wave(reduction, {}, wave, 0.1, "corrected", interval=(-9e3, 9e3))
    data.start(0.0)
    with pytest.raises(ValueError, match="interval must be shorter"):
        data.strain(np.arange(3.0), 1.0)


@pytest.mark.parametrize("index", [108, pytest.param(798, marks=pytest.mark.slow)])
def test_rejected_steps_do_not_count_among_the_modes_of_a_wave(
    index: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: the modes of a rejected step taken for the wave's, which asked for 6144 points."""
    monkeypatch.setattr(first_correction, "MAX_POINTS", first_correction.FIRST_POINTS)
    scene = soak_scene(1, index)
    wave = lattice_wave(scene)
    times = scene.lattice_times(derivation(scene).slow)
    wave.start(times[0])
    assert np.all(np.isfinite(wave.strain(np.arange(9.0), times[-1])))


@pytest.mark.slow
def test_a_sharp_wave_has_its_correction() -> None:
    """Catches: a limit of 6144 points, since the correction needs 12288."""
    scene = soak_scene(21, 56)
    wave = lattice_wave(scene)
    times = scene.lattice_times(derivation(scene).slow)
    wave.start(times[0])
    assert np.all(np.isfinite(wave.strain(np.arange(9.0), times[-1])))


def test_a_wave_without_width_is_refused_for_its_correction() -> None:
    scene = load_scene("toda_soliton").changed(order="corrected", parameters={"kappa": 1e50})
    with pytest.raises(ValueError, match=r"^wave must be wide enough for its correction"):
        lattice_wave(scene)


def residual(data: LongWaveData, t: float) -> float:
    """Return the largest difference between the theory's and the lattice's acceleration."""
    low, high = data.support(t)
    cells = np.arange(math.floor(low), math.ceil(high) + 1)
    ring, h = data.ring(cells, t), 1e-3 / data.eps
    before, after = (data.state(cells, t + d)[1] for d in (-h, h))
    gap = (after - before) / (2 * h) - ring.lattice.acceleration(ring.f)
    return float(np.max(np.abs(gap[:, 4:-4])))


@pytest.mark.parametrize("name", ["6a", "6d"])
def test_slaved_fields_meet_the_equations_of_motion(name: str) -> None:
    """The residual falls with eps to the order of the reduction, or of the bonds' forces without
    slaved fields."""
    for order, power in (("slaved", 6), ("leading", 1)):
        found = [residual(data_of(name, at, order), 1.0 / at**3) for at in (0.2, 0.1)]
        least = power + reduction_of(name).scaling.amplitude
        assert math.log2(found[0] / found[1]) > least - 0.4, order
        assert order == "slaved" or math.log2(found[0] / found[1]) < least + 0.4


@pytest.mark.parametrize("name", ["1", "4b", "6c"])
def test_velocity_is_the_fields_time_derivative(name: str) -> None:
    """They agree up to terms beyond the reduced equation.

    Displacements are compared by strains, since their constant is free at each time.
    """
    data, h = data_of(name), 0.05
    cells = np.arange(-300, 301)
    slope = (data.strain(cells, 7.0 + h) - data.strain(cells, 7.0 - h)) / (2 * h)
    velocity = data.state(cells, 7.0)[1]
    if data.numbers.is_displacement:
        velocity, slope = np.diff(velocity), slope[:, :-1]
    assert slope == pytest.approx(velocity, abs=1e-4 * np.abs(velocity).max())


def test_mean_strain_makes_the_displacement_of_a_soliton_periodic() -> None:
    data = data_of("6a")
    low, high = data.support(0.0)
    cells = np.arange(math.floor(2 * low), math.ceil(2 * high))
    ring = data.ring(cells, 0.0)
    assert abs(ring.mean_strain[0]) > 1e-3
    strain = data.quantity_values(ring.f, ring.mean_strain)
    assert strain == pytest.approx(data.strain(cells, 0.0), abs=1e-12)
    assert np.abs(strain[:, -1]).max() < 1e-9
    stretches = ring.lattice.stretches(ring.f)
    assert sum(stretches) == pytest.approx(strain[0], abs=1e-12)


def test_mean_strain_is_that_of_the_cells_of_the_ring() -> None:
    """Catches: one cell too many or too few, which a wave that has ended does not show."""
    numeric = LATTICES["fput"].with_values({k: Rational(1) for k in ("K2", "K3", "K4")})
    reduction = reduce(numeric, Scaling(1))
    wave = Wave(closed_form("kdv_cnoidal"), reduction.normal_form(), kappa=1, k=Rational(4, 5))
    data = long_wave(reduction, {}, wave, 0.2, "slaved", numeric)
    cells = np.arange(-7, 16)
    ring, strain = data.ring(cells, 0.0), data.strain(cells, 0.0)
    assert ring.mean_strain[0] == pytest.approx(strain.mean(), rel=1e-12)
    assert data.quantity_values(ring.f, ring.mean_strain) == pytest.approx(strain, abs=1e-13)


def test_forces_with_eps_and_no_polynomials_are_those_that_run() -> None:
    gardner = data_of("3", 0.2, "leading")
    assert gardner.lattice.bonds[0].force.coefficients == pytest.approx((1.0, 0.1, 1.0))
    toda = LATTICES["toda"].with_values({"a": Rational(1), "b": Rational(1)})
    reduction = reduce(toda, Scaling(1))
    wave = Wave(closed_form("kdv_soliton"), reduction.normal_form(), kappa=1)
    data = long_wave(reduction, {}, wave, 0.2, "slaved", toda)
    stretch = np.array([0.3])
    assert data.lattice.bonds[0].force(stretch) == pytest.approx(np.expm1(stretch))


def test_numbers_apart_from_the_lattice_give_the_same_data() -> None:
    symbolic = reduce(LATTICES["fput_strain"])
    numbers = {"K2": 1, "K3": 0, "K4": 1}
    wave = long_wave(symbolic, numbers, wave_of(scene_of("1")), 0.1, "slaved")
    cells = np.linspace(-50.0, 50.0, 41)
    for one, other in zip(wave.state(cells, 3.0), data_of("1").state(cells, 3.0), strict=True):
        assert one == pytest.approx(other, rel=1e-12)
    assert wave.lattice == numeric_lattice(LATTICES["fput_strain"], numbers)


def test_what_data_refuse() -> None:
    reduction, wave = reduction_of("1"), wave_of(scene_of("1"))
    lattice = derivation(scene_of("1")).lattice
    leading = reduce(lattice, reduction.scaling, 5)
    with pytest.raises(ValueError, match=r"no correction was derived through eps\^5"):
        long_wave(leading, {}, wave, 0.1, "corrected")
    ended = replace(reduce(lattice), corrections={}, obstruction=(2, leading.pde.flow))
    with pytest.raises(ValueError, match=r"reduction to a one-way equation ends at eps\^2"):
        long_wave(ended, {}, wave, 0.1, "corrected")
    with pytest.raises(ValueError, match="start must be called before"):
        data_of("1", 0.1, "corrected").strain(np.arange(3), 0.0)
    rational = Wave(closed_form("rational_1"), reduction.normal_form())
    with pytest.raises(ValueError, match="interval must be given"):
        long_wave(reduction, {}, rational, 0.1, "corrected")


def test_computed_soliton_solves_its_equation() -> None:
    """It also equals the closed form if there is one."""
    soliton = wave_of(scene_of("5d"))
    assert isinstance(soliton, ComputedSoliton)
    X = np.linspace(-8.0, 8.0, 300)
    jets = soliton.jets(X, 0.7, 5)
    rest = 0.5 * 3 * jets[0] ** 2 * jets[1] - jets[5] / 180 - soliton.speed * jets[1]
    assert np.abs(rest).max() < 1e-8 * np.abs(jets[5]).max() / 180
    assert np.abs(jets[0]).max() > 0.1
    kdv, closed = reduction_of("2"), wave_of(scene_of("2"))
    computed = ComputedSoliton(kdv, 4.0 / 24)
    assert computed.jets(X, 0.3, 2) == pytest.approx(closed.jets(X, 0.3, 2), abs=1e-10)
    W = computed.antiderivative(X, 0.3)
    assert W - W[0] == pytest.approx(
        closed.antiderivative(X, 0.3) - closed.antiderivative(X[:1], 0.3), abs=1e-10
    )
    with pytest.raises(ValueError, match="take another sign"):
        ComputedSoliton(kdv, -1.0)
    with pytest.raises(ValueError, match="parameters of computed_soliton must be speed, got none"):
        wave_of(scene_of("5d").changed(parameters={}))
    with pytest.raises(ValueError, match="order must be leading or slaved with the wave computed"):
        wave_of(scene_of("5d", order="corrected"))


def test_polynomials_of_jets() -> None:
    polynomial = JetPolynomial(((2.0, ((0, 2), (1, 1))), (3.0, ((2, 1),))))
    jets = np.array([[2.0], [5.0], [7.0]])
    assert polynomial(jets) == 61.0
    assert np.concatenate(polynomial.variation(jets)).tolist() == [40.0, 8.0, 3.0]
    assert (polynomial.highest, polynomial.linear) == (2, {2: 3.0})


def test_fourier_interval() -> None:
    space = FourierInterval((-2.0, 6.0), 96, repeats=True)
    rate = 2 * np.pi / 8.0
    modes = space.modes(1.0 + np.sin(3 * rate * space.X))
    X = np.array([-2.3, 0.7, 11.1])
    expected = [1.0 + np.sin(3 * rate * X), 3 * rate * np.cos(3 * rate * X)]
    assert space.jets(modes, X, 1) == pytest.approx(np.array(expected), abs=1e-12)
    W = space.antiderivative(modes, X)
    assert np.diff(W) == pytest.approx(np.diff(X - np.cos(3 * rate * X) / (3 * rate)), abs=1e-12)


ALONG = (SlowVariable("X", 1, (1, 0), c), SlowVariable("Z", 2, (0, 1), Integer(0)))


@pytest.mark.parametrize(
    ("form", "parameters", "constants"),
    [
        ("kp_line_soliton", {"kappa": 1, "q": Rational(1, 2)}, {"K2": 1, "H2": 1}),
        ("kp_line_soliton", {"kappa": 1, "q": Rational(1, 2)}, {"K2": 2, "H2": 3}),
    ],
)
def test_waves_of_kp_meet_the_square_lattice(
    form: str, parameters: dict[str, Any], constants: dict[str, int]
) -> None:
    """Catches: a wrong W_T or W_Z; the residual is two powers beyond the reduced equation."""
    values = {"K3": 1, "K4": 0, "H3": 1, "H4": 0, **constants}
    square = LATTICES["square"].with_values({k: Rational(v) for k, v in values.items()})
    reduction = reduce(square, Scaling(1, ALONG))
    wave = Wave(closed_form(form), reduction.normal_form(), **parameters)
    cells = np.stack(np.meshgrid(np.arange(-40.0, 40.0), np.arange(-5.0, 6.0), indexing="ij"))
    found = []
    for eps in (0.2, 0.1):
        data, h = long_wave(reduction, {}, wave, eps), 1e-3 / eps
        ring = data.ring(cells, 0.0)
        assert ring.mean_strain[0] > 0.0 == ring.mean_strain[1]
        strain = data.quantity_values(ring.f, ring.mean_strain)
        assert strain[:, :-1] == pytest.approx(data.strain(cells, 0.0)[:, :-1], abs=1e-12)
        before, after = (data.state(cells, d)[1] for d in (-h, h))
        gap = (after - before) / (2 * h) - ring.lattice.acceleration(ring.f)
        found.append(np.abs(gap[:, 2:-2, 2:-2]).max())
    assert math.log2(found[0] / found[1]) > 6.6
    with pytest.raises(ValueError, match="no correction was derived"):
        long_wave(reduction, {}, wave, 0.1, "corrected")


def test_ends_of_a_wave() -> None:
    low, high = wave_ends(lambda X: 1.0 / np.cosh(X))
    assert -30.0 < low < -5.0 < 5.0 < high < 30.0
    assert wave_ends(np.tanh)[1] < 30.0
    assert wave_ends(lambda X: 1.0 / (1.0 + X**2))[0] == -math.inf


def test_fitted_rate() -> None:
    cubic = fitted_rate([0.1, 0.2, 0.4, 0.8], [1e-3, 8e-3, 64e-3, 512e-3])
    assert (cubic.value, cubic.low, cubic.high) == pytest.approx((3.0, 3.0, 3.0), abs=1e-9)
    blurred = fitted_rate([0.1, 0.2, 0.4], [1.0, 2.0, 4.0], [0.1, 0.0, 0.0])
    assert blurred.low < 0.9 < 1.1 < blurred.high


@settings(deadline=None)
@given(
    power=st.integers(1, 8),
    drift=st.floats(-3.0, 3.0),
    later=st.integers(1, 2),
    ratio=st.floats(0.6, 0.85),
)
def test_the_interval_holds_the_limit_of_a_rate_that_drifts(
    power: int, drift: float, later: int, ratio: float
) -> None:
    """For errors eps^p (1 + d eps^q), q = 1 or 2, the slope at these eps differs from p."""
    eps = 0.2 * ratio ** np.arange(4)
    rate = fitted_rate(list(eps), list(eps**power * np.exp(drift * eps**later)))
    assert rate.holds(power)


def test_a_rate_that_is_not_the_theorys_is_not_held() -> None:
    assert not fitted_rate([0.1, 0.14, 0.2], [0.01, 0.0196, 0.04]).holds(3)


def test_fitted_rate_needs_errors() -> None:
    with pytest.raises(ValueError, match="errors must be at least 3"):
        fitted_rate([0.1, 0.2], [1.0, 2.0])
    with pytest.raises(ValueError, match="errors must be finite and > 0"):
        fitted_rate([0.1, 0.2, 0.4], [0.0, 1.0, 2.0])

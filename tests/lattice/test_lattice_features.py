"""Catches: a bump of a force law, a pulse of a drive or of a wall, a corner under a fast carrier
that both of two compared runs step over; a chain at rest whose last digits nothing changes."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from longwave.derive import LATTICES
from longwave.derive.lattice_file import time_formula
from longwave.lattice import DrivenChain, SiteForce, State, driven_chain, integrate
from longwave.lattice.drive_steps import drive_steps
from longwave.lattice.force_features import find_feature
from longwave.lattice.force_program import ForceProgram, force_program, program_of
from longwave.lattice.integration import CellEngine
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice, numeric_lattice
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.lattice.time_integral import Integral
from longwave.scenes.description.time_functions import time_function
from searches.feature_judge import Family, Member, answer, judge, reference

Array = NDArray[np.float64]

BETA = numeric_lattice(LATTICES["beta_fput"], {"K2": 1, "K4": 2})
BUMP = "t + 117.6*exp(-((t - 0.0384)/0.00017)**2)"


def bench_and_chain(law: str) -> NumericLattice:
    """A chain whose springs have the law, written in t."""
    formula = time_formula("force", law)
    stretch = (Entry((1,), 1.0, 0), Entry((0,), -1.0, 0))
    action = (Entry((0,), 1.0, 0), Entry((-1,), -1.0, 0))
    return NumericLattice(
        "bumpy", ("u",), (1.0,), (NumericBond(stretch, action, force_program(formula)),)
    )


def at_rest(cells: int) -> State:
    return State(0.0, *np.zeros((2, 1, cells)))


@pytest.mark.slow
def test_a_bump_of_a_force_is_not_stepped_over() -> None:
    made = driven_chain(bench_and_chain(BUMP), 2, left="free", right="free")
    state = at_rest(2)
    state.v[0, 0] = 0.3
    run = integrate(made, state, [3.0], tolerance=5.65e-5)
    assert run.f[-1, 0, 0] > 0.5  # 0.355 where it is stepped over

    def slopes(_: float, y: Array) -> Array:
        x = y[1] - y[0]
        force = x + 117.6 * np.exp(-(((x - 0.0384) / 1.7e-4) ** 2))
        return np.array([y[2], y[3], force, -force])

    exact = solve_ivp(
        slopes, (0.0, 3.0), [0.0, 0.0, 0.3, 0.0], "DOP853", rtol=1e-10, atol=1e-11, max_step=1e-4
    ).y[:2, -1]
    assert np.abs(run.f[-1, 0] - exact).max() < run.error_estimate <= 5.65e-5


@pytest.mark.parametrize(
    ("law", "low", "high"),
    [(BUMP, 1e-5, 3e-4), ("t + tanh(t*1000 - 200)/10", 5e-4, 5e-3), ("exp(t)", np.inf, np.inf)],
)
def test_the_width_of_a_feature_is_found(law: str, low: float, high: float) -> None:
    assert (
        low <= find_feature(program_of(time_formula("force", law)), -0.5, 0.5, 1e-8).width <= high
    )


def test_a_law_with_a_corner_is_treated_as_contacts_are() -> None:
    law = program_of(time_formula("force", "t + sqrt((t - 1/5)**2 + 1/10**16)"))
    found = find_feature(law, -0.5, 0.5, 1e-8)
    assert found.turns
    assert found.width == np.inf


@pytest.mark.parametrize("place", [-0.31234, 0.0384, 0.2])
def test_slopes_between_the_places_looked_at_are_enclosed(place: float) -> None:
    law = program_of(time_formula("force", f"t + exp(-((t - {place})/0.00001)**2)"))
    steepest = law.steepest_between(-0.5, 0.5, 1.0)
    assert steepest == pytest.approx(np.sqrt(2.0 / np.e) * 1e5, rel=0.15)
    assert ForceProgram((1.0, 0.0, 1.0)).steepest_between(-1.0, 1.0, 4.0) == 4.0


def test_slopes_of_polynomials_are_enclosed() -> None:
    law = ForceProgram((1.0, -3.0, 0.5, 2.0))
    low = np.linspace(-2.0, 1.9, 40)
    least, most = law.slope_enclosed(low, low + 0.1)
    for share in np.linspace(0.0, 1.0, 11):
        slope = law.slope(low + 0.1 * share)
        assert np.all((least <= slope + 1e-12) & (slope <= most + 1e-12))


def test_a_short_pulse_of_a_walls_velocity_moves_it() -> None:
    text = "5000*exp(-((t - 777.17)/0.00001)**2)"
    moved = Integral.of(time_function("left", text), 0.0, 1000.0)
    size = 5000 * 1e-5 * np.sqrt(np.pi)
    assert float(moved(np.array(1000.0))) == pytest.approx(size, rel=1e-9)
    made = driven_chain(BETA, 3, left=moved, right="fixed")
    run = integrate(made, at_rest(3), [800.0], tolerance=1e-4)

    def slopes(_: float, y: Array) -> Array:
        x = np.diff([size, *y[:3], 0.0])
        return np.concatenate([y[3:], np.diff(x + 2.0 * x**3)])

    exact = solve_ivp(slopes, (777.17, 800.0), np.zeros(6), "DOP853", rtol=1e-11, atol=1e-12)
    assert np.abs(run.f[-1, 0] - exact.y[:3, -1]).max() < run.error_estimate <= 1e-4
    assert run.cost.steps < 20_000


@pytest.mark.slow  # the reference is compiled first
@pytest.mark.parametrize("seed", [0, 3])
def test_the_error_of_a_corner_under_a_fast_carrier_is_known(seed: int) -> None:
    random = np.random.default_rng(seed)
    member = Member(Family("force", "corner", 2, 5.0, 30.0, 0.0, 0.0, False), random.random(4))
    member.genes[2] = 1.0
    assert judge(member).kind == "sound"


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["force", "velocity", "displacement"])
def test_what_pushes_and_pulls_at_once_is_seen(kind: str) -> None:
    """A wiggle gives no momentum, and its integral shows nothing of it."""
    family = Family(kind, "wiggle", 3, 5.0, 0.0, 0.0, 1.0, False)
    assert judge(Member(family, np.array([0.371, 0.7, 0.9, 0.6]))).kind == "sound"


@pytest.mark.parametrize("width", [2e-4, 1e-3, 8e-3, 4e-2])
@pytest.mark.parametrize("is_wall", [False, True])
@pytest.mark.parametrize("place", [2.3565868, 2.86261483, 3.6248231])
def test_steps_see_what_has_no_integral(width: float, is_wall: bool, place: float) -> None:
    """Panels on which a wiggle hid were taken for smooth: a wall's gave errors of 112 estimates."""
    text = f"0.05*exp(-((t - {place})/{width})**2)*sin(3*(t - {place})/{width}) + 0.1*sin(1.5*t)"
    value = time_function("left", text)
    drive = Integral.of(value, 0.0, 5.0) if is_wall else value
    stops = drive_steps([drive], 0.0, 5.0, 0.4, REDUCED_PHASE_6, 4e-8)[0].stops
    near = stops[np.abs(stops - place) < 3.0 * width]
    assert near.size > 3
    assert np.diff(near).max() < 2.0 * width


@pytest.mark.parametrize(("height", "width"), [(0.00251, 1e-6), (1.456e-5, 2.124e-5), (1e-9, 1e-4)])
def test_what_is_short_and_gives_nothing_costs_a_few_steps(height: float, width: float) -> None:
    """All steps were as short as it, for hours, where its integral was no matter."""
    text = f"{height}*exp(-((t - 13.5)/{width})**2)*sin(3*(t - 13.5)/{width})"
    drive = time_function("value", text)
    found, within = drive_steps([drive], 0.0, 15.0, 0.4, REDUCED_PHASE_6, 1e-3)
    assert found.step >= 0.2
    assert 3 < found.stops.size < 100
    assert within == np.inf


@pytest.mark.slow
@pytest.mark.parametrize("place", [0.4641467, 0.5906537])
def test_a_wall_whose_velocity_swings_is_followed(place: float) -> None:
    family = Family("velocity", "wiggle", 4, 5.0, 1.5, 0.0, 1.0, False)
    member = Member(family, np.array([place, 0.5073559, 0.3605443, 0.4860659]))
    assert np.abs(answer(member)[0] - reference(member, 1e-12)).max() < 0.1 * answer(member)[1]


def test_a_run_that_broke_down_says_nothing_of_the_next() -> None:
    """Last digits were changed by what its fields had become: every run with that broke down."""
    family = Family("law", "wiggle", 2, 5.0, 0.0, 0.0, 1.0, False)
    genes = np.array([0.1933048538487302, 0.2699874503273933, 1.0, 0.5113523306679055])
    found, estimate = answer(Member(family, genes))
    assert found == pytest.approx([-0.08785532063, -0.18941776927], abs=1e-10)  # DOP853 at 1e-12
    assert estimate < 1e-8


def test_a_refusal_names_what_asks_for_short_steps() -> None:
    engine = engine_of(driven_chain(BETA, 4, left="free", right="free"), 20.0)
    engine._note_admitted(1.0, 1e-50, np.inf)  # broke down
    engine._note_admitted(0.1, 1.0, 1e-9)
    assert "forces of beta_fput must change slowly enough" in engine.told_dear(1e9, 1e-6)
    engine._note_admitted(0.01, 1.0, 0.5)
    assert "tolerance must be one that" in engine.told_dear(1e9, 1e-6)
    engine._note_admitted(0.001, 1e-12, np.inf)
    assert "times must end before strains run away" in engine.told_dear(1e9, 1e-6)


def test_a_sharp_corner_that_no_run_follows_is_named() -> None:
    """It was told as strains that run away, on a chain that swings quietly."""
    family = Family("law", "corner", 3, 5.0, 1.5, 0.0, 1.0, False)
    genes = np.array([0.34502074388020887, 0.299194535700599, 1.0, 0.5415984747492062])
    with pytest.raises(ValueError, match="forces of chain must change slowly enough"):
        answer(Member(family, genes))


def engine_of(made: DrivenChain, end: float) -> CellEngine:
    return CellEngine(made, made.held(at_rest(4)), np.array([end]), REDUCED_PHASE_6)


def test_last_digits_of_a_chain_at_rest_are_changed() -> None:
    """Zeros times a factor stay zeros: rounding of a driven chain was taken to be none."""
    wall = time_function("left", "2*sin(1.5*t)")
    engine = engine_of(driven_chain(BETA, 4, left=wall, right="free"), 30.0)
    choices = replace(engine.first(), step=0.05)
    values = [engine.run(one, False).values for one in (choices, replace(choices, nudged=True))]
    assert values[0] is not None
    assert values[1] is not None
    assert np.abs(values[0] - values[1]).max() > 1e-14


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-8, 1e-6])
def test_rounding_of_a_chain_driven_from_rest_is_told(tolerance: float) -> None:
    """It comes to far more than these tolerances until then, whatever the step."""
    made = driven_chain(BETA, 4, left=time_function("left", "2*sin(1.5*t)"), right="free")
    with pytest.raises(ValueError, match="rounding comes to that much"):
        integrate(made, at_rest(4), [50.0], tolerance, judged=lambda f, v, t: f)


def test_smooth_drives_take_no_stops() -> None:
    for text in ("cos(7*t/10)", "sin(200*t)", "exp(-((t - 9)/5)**2)", "t", "1"):
        drive = SiteForce(0, time_function("value", text))
        engine = engine_of(driven_chain(BETA, 4, forces=[drive]), 20.0)
        assert engine._stops.size == 2, text


@pytest.mark.slow
@pytest.mark.parametrize(("free", "quartic"), [(True, 0.0), (False, 1.0)])
@pytest.mark.parametrize("tolerance", [2.5e-7, 1e-6])
def test_a_low_bump_that_steps_pass_is_followed(
    free: bool, quartic: float, tolerance: float
) -> None:
    """Twelve points on each panel gave its integral, and two runs that passed it agreed."""
    family = Family("law", "bump", 2, 5.0, 0.0, 0.0, quartic, free)
    member = Member(family, np.array([0.0, 0.0, 0.0, (np.log10(tolerance) + 9.0) / 6.0]))
    vars(member).update(place=0.1557369, width=0.01202, height=9.25e-6)
    assert np.abs(answer(member)[0] - reference(member, 1e-12)).max() < 0.1 * tolerance


def test_an_exponent_far_from_its_pulse_is_not_rounded() -> None:
    """Runs were refused for the rounding of (x - c)**2/w**2, of which there is nothing left."""
    law = program_of(time_formula("force", "t + 1.4*exp(-((t - 0.13)/0.0001)**2)"))
    assert law.largest_summand(np.linspace(-0.3, 0.3, 65)) < 1.0

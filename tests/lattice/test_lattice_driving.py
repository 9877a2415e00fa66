"""Catches: an end, a loss or a force that acts wrongly or late, and a reduced order."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from longwave.derive import LATTICES
from longwave.lattice import (
    DrivenChain,
    SiteForce,
    State,
    Trajectory,
    driven_chain,
    integrate,
)
from longwave.lattice.numeric_lattice import NumericLattice, numeric_lattice
from longwave.lattice.schemes import KAHAN_LI_8, REDUCED_PHASE_6, RK4, STOERMER_VERLET, Scheme
from longwave.lattice.time_integral import Integral
from longwave.scenes.description.time_functions import time_function
from searches.driven_chains import DrivenCase, exact_state

Array = NDArray[np.float64]

BETA = numeric_lattice(LATTICES["beta_fput"], {"K2": 1, "K4": 2})
LINEAR = numeric_lattice(LATTICES["alpha_fput"], {"K2": 1, "K3": 0})
STRAIN = numeric_lattice(LATTICES["fput_strain"], {"K2": 1, "K3": 0, "K4": 2})


def push(t: Array) -> Array:
    """Return a force that begins at once."""
    return 0.3 * np.cos(0.9 * t)


shake = time_function("displacement of a wall", "0.05*sin(13*t/10)")


def chain(name: str) -> NumericLattice:
    """Return a lattice of the catalogue whose constants are small whole numbers."""
    lattice = LATTICES[name]
    return numeric_lattice(lattice, {str(symbol): 1 for symbol in lattice.constants})


def start(lattice: NumericLattice, cells: int) -> State:
    """Return small random displacements and velocities."""
    f, v = 0.1 * np.random.default_rng(3).standard_normal((2, len(lattice.fields), cells))
    return State(0.0, f, v)


def error(made: DrivenChain, ends: tuple[Any, Any], state: State, run: Trajectory) -> float:
    """Return the largest error of the displacements at the last time."""
    case = DrivenCase(made.name, made, ends, state, float(run.times[-1]), 1e-7)
    return float(np.abs(run.f[-1] - exact_state(case)[0]).max())


ENDS: list[tuple[Any, Any]] = [
    (None, None),
    ("fixed", "fixed"),
    ("free", "fixed"),
    (shake, "fixed"),
    (shake, shake),
]


@pytest.mark.parametrize(("ends", "cells"), [*((ends, 64) for ends in ENDS), (ENDS[2], 9)])
def test_every_effect_agrees_with_scipy(ends: tuple[Any, Any], cells: int) -> None:
    force = SiteForce(3, push)
    for losses, forces in ((0.0, [force]), (0.03, [force]), (0.1, [])):
        made = driven_chain(BETA, cells, left=ends[0], right=ends[1], losses=losses, forces=forces)
        state = start(BETA, cells)
        run = integrate(made, state, [6.0], tolerance=1e-7)
        assert run.f.shape == (1, 1, cells)
        assert error(made, ends, state, run) < run.error_estimate <= 1e-7


@pytest.mark.parametrize(("ends", "cells"), [*((ends, 64) for ends in ENDS), (ENDS[2], 9)])
def test_dashpots_agree_with_scipy(ends: tuple[Any, Any], cells: int) -> None:
    for dashpot, losses in ((0.05, 0.0), (1.0, 0.1)):
        made = driven_chain(
            BETA, cells, left=ends[0], right=ends[1], losses=losses, dashpots=dashpot
        )
        state = start(BETA, cells)
        run = integrate(made, state, [4.0], tolerance=1e-7)
        assert error(made, ends, state, run) < run.error_estimate <= 1e-7


def test_a_ring_of_strains_has_the_losses_of_its_displacements() -> None:
    """This includes dashpots, which spread strains as springs do."""
    constants = {"K2": 1, "K3": 1, "K4": 1}
    u, v = 0.05 * np.random.default_rng(3).standard_normal((2, 1, 40))
    stretched = [np.roll(values, -1, axis=1) - values for values in (u, v)]
    found = []
    for name, state in (("fput", (u, v)), ("fput_strain", stretched)):
        lattice = numeric_lattice(LATTICES[name], constants)
        made = driven_chain(lattice, 40, losses=0.07, dashpots=0.2)
        found.append(integrate(made, State(0.0, *state), [3.0, 9.0], 1e-9))
    displacements, strains = found
    for fields, rates in ((displacements.f, strains.f), (displacements.v, strains.v)):
        assert np.abs(np.roll(fields, -1, axis=2) - fields - rates).max() < 1e-8


def test_a_wall_with_dashpots_needs_a_slope() -> None:
    made = driven_chain(BETA, 8, left=np.sin, right="fixed", dashpots=0.1)
    with pytest.raises(ValueError, match="must have a slope, its velocity, got a bare function"):
        integrate(made, start(BETA, 8), [1.0], 1e-3)


@pytest.mark.parametrize("name", ["mass_dimer", "local_resonators", "toda", "klein_gordon"])
def test_fields_have_losses_and_walls_of_their_own(name: str) -> None:
    lattice = chain(name)
    losses = [0.02 * (place + 1) for place in range(len(lattice.fields))]
    force = SiteForce(3, push, len(lattice.fields) - 1)
    for ends in ((None, None), ("fixed", shake)):
        made = driven_chain(lattice, 40, left=ends[0], right=ends[1], losses=losses, forces=[force])
        state = start(lattice, 40)
        run = integrate(made, state, [4.0], tolerance=1e-7)
        assert error(made, ends, state, run) < run.error_estimate <= 1e-7


def driven_by_all(cells: int) -> DrivenChain:
    """Return a chain with a moving wall, defects, losses, dashpots and a force."""
    return driven_chain(
        BETA,
        cells,
        left=Integral.of(shake, 0.0, 8.0),
        right="fixed",
        losses=0.2,
        dashpots=0.1,
        forces=[SiteForce(3, push)],
        mass_factors={0: 2.0, 3: 5.0},
        spring_factors={-1: 2.0, 7: 0.5},
    )


@pytest.mark.parametrize("scheme", [STOERMER_VERLET, REDUCED_PHASE_6, KAHAN_LI_8])
def test_schemes_keep_their_order(scheme: Scheme) -> None:
    made = driven_by_all(40)
    state, ends = start(BETA, 40), 8.0
    exact = integrate(made, state, [ends], tolerance=1e-12).f
    errors = []
    for steps in (24, 48) if scheme.order > 2 else (48, 96):
        run = integrate(made, state, [ends], scheme=scheme, step=ends / steps, measure_error=False)
        errors.append(np.abs(run.f - exact).max())
    rate = np.log2(errors[0] / errors[1])
    assert rate == pytest.approx(scheme.order, abs=0.4)


def modal_chain(cells: int, rate: float, site: int, frequency: float, t: float) -> Array:
    """Return a linear chain between fixed walls, driven from rest by cos(frequency t) at a site."""
    n = np.arange(1, cells + 1)
    shapes = np.sqrt(2.0 / (cells + 1)) * np.sin(np.pi * np.outer(n, n) / (cells + 1))
    omega = 2.0 * np.sin(np.pi * n / (2 * cells + 2))
    response = shapes[site] / (omega**2 - frequency**2 + 1j * rate * frequency)
    steady = response * np.exp(1j * frequency * t)
    turn = np.sqrt(omega**2 - rate**2 / 4.0)
    cosine = -response.real
    sine = (frequency * response.imag + rate / 2.0 * cosine) / turn
    own = np.exp(-rate * t / 2.0) * (cosine * np.cos(turn * t) + sine * np.sin(turn * t))
    return np.asarray(shapes @ (steady.real + own))


def test_a_linear_driven_chain_agrees_with_its_modes() -> None:
    lattice = numeric_lattice(LATTICES["alpha_fput"], {"K2": 1, "K3": 0})
    force = SiteForce(5, lambda t: np.cos(0.7 * t))
    made = driven_chain(lattice, 24, left="fixed", right="fixed", losses=0.05, forces=[force])
    times = [5.0, 40.0, 150.0]
    run = integrate(made, State(0.0, *np.zeros((2, 1, 24))), times, tolerance=1e-10)
    exact = [modal_chain(24, 0.05, 5, 0.7, t) for t in times]
    assert np.abs(run.f[:, 0] - exact).max() < 1e-10


def test_a_wall_with_a_velocity_moves_by_its_integral() -> None:
    """A linear chain responds to ``cos(0.7 t) - 1`` as its modes do."""
    lattice = numeric_lattice(LATTICES["alpha_fput"], {"K2": 1, "K3": 0})
    velocity = time_function("velocity", "-0.7*sin(7*t/10)")
    made = driven_chain(
        lattice, 24, left=Integral.of(velocity, 0.0, 40.0), right="fixed", losses=0.05
    )
    times = [5.0, 20.0, 40.0]
    run = integrate(made, State(0.0, *np.zeros((2, 1, 24))), times, tolerance=1e-10)
    exact = [modal_chain(24, 0.05, 0, 0.7, t) - modal_chain(24, 0.05, 0, 0.0, t) for t in times]
    assert np.abs(run.f[:, 0] - exact).max() < 1e-10


def test_a_linear_chain_with_defects_agrees_with_its_modes() -> None:
    lattice = numeric_lattice(LATTICES["alpha_fput"], {"K2": 1, "K3": 0})
    masses, springs = np.ones(16), np.ones(17)
    masses[[0, 9]], springs[[0, 5, 16]] = (3.0, 0.2), (0.5, 4.0, 2.0)
    made = driven_chain(
        lattice,
        16,
        left="fixed",
        right="fixed",
        mass_factors={0: 3.0, 9: 0.2},
        spring_factors={-1: 0.5, 4: [4.0], 15: 2.0},
    )
    stiffness = np.diag(springs[1:] + springs[:-1])
    stiffness -= np.diag(springs[1:-1], 1) + np.diag(springs[1:-1], -1)
    root = np.sqrt(masses)
    squares, shapes = np.linalg.eigh(stiffness / np.outer(root, root))
    state, omega = start(lattice, 16), np.sqrt(squares)
    assert made.highest_frequency(made.rest_slopes()) > omega.max()
    f, v = (shapes.T @ (root * part[0]) for part in state.arrays)
    times = np.array([10.0, 60.0])
    turned = np.cos(np.outer(times, omega)) * f + np.sin(np.outer(times, omega)) / omega * v
    run = integrate(made, state, times, tolerance=1e-10)
    assert np.abs(run.f[:, 0] - turned @ shapes.T / root).max() < 1e-10
    energy = made.energy(*made.with_walls(state).arrays)
    assert energy == pytest.approx(0.5 * np.sum(v**2 + squares * f**2), rel=1e-12)


def test_light_masses_and_stiff_bonds_have_the_fastest_waves() -> None:
    """A single light mass oscillates at sqrt(2 / m), two masses with a stiff bond at sqrt(2 K)."""
    defects = ({"mass_factors": {3: 0.1}}, 20.0), ({"spring_factors": {3: 8.0}}, 16.0)
    for given, square in defects:
        made = driven_chain(BETA, 8, left="fixed", right="fixed", **given)  # type: ignore[arg-type]
        assert made.highest_frequency(made.rest_slopes()) > np.sqrt(square)


@pytest.mark.parametrize(
    ("name", "losses"),
    [
        ("beta_fput", 0.1),
        *(
            pytest.param(name, losses, marks=pytest.mark.slow)
            for name in ("mass_dimer", "klein_gordon")
            for losses in (0.0, 0.1)
        ),
    ],
)
def test_defects_agree_with_scipy(name: str, losses: float) -> None:
    lattice = chain(name)
    fields, bonds = len(lattice.fields), len(lattice.bonds)
    masses = {0: [2.0, 0.3][:fields], 5: [0.2, 4.0][:fields], 11: [3.0, 0.5][:fields]}
    springs = {0: [3.0, 0.2][:bonds], 8: [0.1, 2.0][:bonds]}
    for ends in ((None, None), ("free", "free"), (shake, "fixed")):
        for dashpot in (0.0, 0.3):
            made = driven_chain(
                lattice,
                12,
                left=ends[0],
                right=ends[1],
                losses=[losses, 0.0][:fields],
                dashpots=dashpot,
                forces=[SiteForce(5, push)],
                mass_factors=masses,
                spring_factors=springs,
            )
            state = start(lattice, 12)
            run = integrate(made, state, [3.0], tolerance=1e-7)
            case = DrivenCase(name, made, ends, state, 3.0, 1e-7, 1.0, masses, springs)
            assert np.abs(run.f[-1] - exact_state(case)[0]).max() < run.error_estimate <= 1e-7


def test_the_first_mode_of_1955_returns() -> None:
    lattice = numeric_lattice(LATTICES["alpha_fput"], {"K2": 1, "K3": 0.25})
    made = driven_chain(lattice, 31, left="fixed", right="fixed")
    n = np.arange(1, 32)
    mode, period = np.sin(np.pi * n / 32), np.pi / np.sin(np.pi / 64)
    times = period * np.array([70.0, 145.5, 146.0, 146.5, 147.0, 147.5])
    run = integrate(made, State(0.0, mode[None], np.zeros((1, 31))), times, tolerance=1e-5)
    speed = 2.0 * np.sin(np.pi / 64)
    energy = (run.v[:, 0] @ mode) ** 2 + (speed * run.f[:, 0] @ mode) ** 2
    share = energy / (speed * mode @ mode) ** 2
    assert share[0] < 0.5
    assert share[1:].max() == pytest.approx(0.981, abs=1e-3) == share[3]


def energies(made: DrivenChain, run: Any) -> Array:
    """Return the energy of the moving cells and of the bonds to the walls, at all times."""
    return np.array(
        [
            made.energy(*made.with_walls(State(t, f, v)).arrays)
            for t, f, v in zip(run.times, run.f, run.v, strict=True)
        ]
    )


@pytest.mark.parametrize("end", ["fixed", "free"])
def test_energy_is_conserved_or_decreases_by_losses(end: str) -> None:
    times, state = np.linspace(0.0, 4.0, 81), start(BETA, 12)
    kept = driven_chain(BETA, 12, left="free", right=end)
    lossy = driven_chain(BETA, 12, left="free", right=end, losses=0.3)
    found = energies(kept, integrate(kept, state, times, tolerance=1e-9))
    assert np.ptp(found) < 1e-8 * found[0]
    run = integrate(lossy, state, times, tolerance=1e-9)
    heat = 0.3 * np.sum(run.v[:, 0] ** 2, axis=1)
    lost = np.sum((heat[:-2:2] + 4.0 * heat[1:-1:2] + heat[2::2]) * 0.05 / 3.0)
    found = energies(lossy, run)
    assert found[0] - found[-1] == pytest.approx(lost, rel=1e-5)
    assert lost > 0.5 * found[0]


def test_a_free_chain_drifts_away_unstretched() -> None:
    made = driven_chain(BETA, 20, left="free", right="free")
    run = integrate(made, State(0.0, np.zeros((1, 20)), np.ones((1, 20))), [500.0], 1e-9)
    np.testing.assert_allclose(run.f, 500.0, rtol=1e-13)


REFUSED: list[tuple[Callable[[], object], str]] = [
    (lambda: driven_chain(BETA, 1, left="fixed", right="fixed"), "cells must be at least 2, got 1"),
    (lambda: driven_chain(BETA, 8, left="fixed"), "left must be .*give both ends"),
    (lambda: driven_chain(BETA, 8, left="loose", right="fixed"), "left must be .* got 'loose'"),  # type: ignore[arg-type]
    (lambda: driven_chain(BETA, 8, losses=-1.0), "losses must be a rate of 0 or more"),
    (lambda: driven_chain(BETA, 8, losses=[0.1, 0.1]), "losses must be .*there are u"),
    (lambda: driven_chain(BETA, 8, forces=[SiteForce(8, push)]), "site of a force must be 0 to 7"),
    (lambda: driven_chain(BETA, 8, forces=[SiteForce(0, push, 1)]), "field of a force must be"),
    (
        lambda: driven_chain(BETA, 8, mass_factors={8: 2.0}),
        "mass factors must be within the chain, got 8",
    ),
    (lambda: driven_chain(BETA, 8, mass_factors={1: 0.0}), "mass factors must be > 0"),
    (
        lambda: driven_chain(BETA, 8, spring_factors={9: 2.0}),
        "spring factors must be within .* got 9",
    ),
    (
        lambda: driven_chain(BETA, 8, spring_factors={1: [1, 2]}),
        "must be >= 0, one number or 1, got",
    ),
    (
        lambda: driven_chain(STRAIN, 8, mass_factors={1: 2.0}),
        "need a chain of displacements, got fput_strain",
    ),
    (
        lambda: driven_chain(STRAIN, 8, left="fixed", right="fixed"),
        "need a chain of displacements, got fput_strain",
    ),
    (
        lambda: integrate(driven_chain(BETA, 8), start(BETA, 9), [1.0], 1e-3),
        "state must have the 8 cells of the lattice, got 9",
    ),
    (
        lambda: integrate(
            driven_chain(BETA, 8, losses=0.1), start(BETA, 8), [1.0], step=0.1, scheme=RK4
        ),
        "a chain with ends, losses or forces needs a splitting scheme, got rk4",
    ),
    (
        lambda: integrate(
            driven_chain(BETA, 8, left=lambda t: 1.0 / (t - t), right="free"),
            start(BETA, 8),
            [1.0],
            1e-3,
        ),
        "a force or displacement in time must be finite",
    ),
]


@pytest.mark.parametrize("case", REFUSED, ids=[text for _, text in REFUSED])
def test_invalid_arguments_are_refused(case: tuple[Callable[[], object], str]) -> None:
    ask, text = case
    with np.errstate(all="ignore"), pytest.raises(ValueError, match=text) as caught:
        ask()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("width", [1.0, 0.03, 0.001])
def test_a_short_push_is_not_missed(width: float) -> None:
    """Two runs with steps longer than a push would agree that there was none."""
    force = SiteForce(3, lambda t: 0.1 / width * np.exp(-(((t - 5.3) / width) ** 2)))
    made = driven_chain(BETA, 8, left="free", right="free", forces=[force])
    run = integrate(made, State(0.0, *np.zeros((2, 1, 8))), [12.0], tolerance=1e-6)
    assert run.v.sum() == pytest.approx(0.1 * np.sqrt(np.pi), abs=1e-6)


@pytest.mark.parametrize(
    "push",
    [
        "5*exp(-((t - 1234.5073)/w)**2)",
        "sin(t) + 1/(1 + ((t - 1234.5073)/w)**2)",
        "tanh((t - 3.1)/w) - tanh((t - 3.1 - w)/w)",
    ],
)
@pytest.mark.parametrize("width", ["1e-4", "1e-6"])
def test_a_push_between_the_sampled_times_is_found(push: str, width: str) -> None:
    value = time_function("value", push.replace("w", width))
    made = driven_chain(BETA, 8, left="free", right="free", forces=[SiteForce(3, value)])
    assert 0.5 < made.driven_within(0.0, 2000.0) / float(width) < 10.0


@pytest.mark.parametrize(
    "text",
    [
        *("sin(3*t)*t", "cos(t)**2", "exp(-((t - 1)/3)**2)", "t**3 - t**2", "t**(-3)", "t**(-2)"),
        *("tan(t/10)", "sqrt(t**2 + 1)", "cosh(t) - t*sinh(t/3)", "(t**2 + 1)**(-3/2)", "2**t"),
        "atan(5*t)*tanh(t)*asinh(t)",
    ],
)
def test_formulas_are_enclosed(text: str) -> None:
    random = np.random.default_rng(5)
    low = random.uniform(-6.0, 6.0, 300)
    high = low + 10.0 ** random.uniform(-4.0, 1.0, 300)
    value = time_function("value", text)
    with np.errstate(all="ignore"):
        least, most = value.enclosed(low, high)  # type: ignore[attr-defined]
        seen = np.array([value(low + share * (high - low)) for share in np.linspace(0, 1, 201)])
        spare = 1e-9 * np.abs(seen)
    assert np.all((seen >= least - spare) & (seen <= most + spare))
    tight = high - low < 1e-3
    ratio = np.median((most - least)[tight] / np.ptp(seen[:, tight], axis=0))
    assert ratio < 3.0


def test_strong_losses_can_be_run() -> None:
    made = driven_chain(BETA, 4, left="fixed", right="fixed", losses=1e4)
    run = integrate(made, State(0.0, np.zeros((1, 4)), np.ones((1, 4))), [1.0], tolerance=1e-9)
    np.testing.assert_allclose(run.f[-1], 1e-4, rtol=1e-3)


def test_a_fast_push_is_resolved() -> None:
    made = driven_chain(BETA, 8, forces=[SiteForce(3, lambda t: 1e3 * np.sin(1e4 * t))])
    run = integrate(made, State(0.0, *np.zeros((2, 1, 8))), [1.0], tolerance=1e-6)
    exact = 1e3 * (1.0 - np.cos(1e4)) / 1e4  # what a free mass gets: waves have no time to answer
    assert run.v.sum() == pytest.approx(exact, abs=1e-6)


def test_losses_of_a_declared_lattice_are_refused() -> None:
    lossy = LATTICES["beta_fput"].with_losses(site="1/10")
    with pytest.raises(ValueError, match="lattice must have no losses of its own to be run, got"):
        numeric_lattice(lossy, {"K2": 1, "K4": 2})


def corner(at: float) -> Callable[[Array], Array]:
    return time_function("force", f"((t - {at})**2 + 1/10**14)**(1/2)")


@pytest.mark.parametrize("seed", [1, 5, 13, 17, 25, 28])
def test_the_error_of_a_force_with_a_corner_is_known(seed: int) -> None:
    """With an assumed order of 6, errors were 1.14 of the estimate, and runs were refused."""
    random = np.random.default_rng(seed)
    at, tolerance = float(random.uniform(1, 9)), 10 ** random.uniform(-5, -3)
    push = SiteForce(0, corner(at))
    made = driven_chain(LINEAR, 2, left="fixed", right="fixed", forces=[push])
    rest = State(0.0, *np.zeros((2, 1, 2)))
    run = integrate(made, rest, [10.0], tolerance=tolerance)
    exact = exact_state(DrivenCase("corner", made, ("fixed", "fixed"), rest, 10.0, tolerance))
    assert np.abs(run.f[-1] - exact[0]).max() < run.error_estimate <= tolerance


def test_corners_are_distinguished_from_fast_drives() -> None:
    for text, turns in (
        ("sin(100*t)", False),
        ("exp(-((t - 5)/0.01)**2)", False),
        ("t", False),
        ("1", False),
        ("((t - 5)**2 + 1/10**14)**(1/2)", True),
        ("tanh(1000000*(t - 5))*(t - 5)", True),
    ):
        drive = SiteForce(0, time_function("force", text))
        made = driven_chain(LINEAR, 2, left="fixed", right="fixed", forces=[drive])
        assert made.drive_within(0.0, 10.0)[1] == turns, text

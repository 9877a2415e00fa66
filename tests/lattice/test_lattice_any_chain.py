"""Integration of arbitrary lattices by `integrate`.

Catches: an estimate below the error, a lattice or state that does not fit, a blow-up that is
missed.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from sympy import Rational

from longwave.derive.symbols import x
from longwave.lattice import integrate
from longwave.lattice.blow_up import find_blow_up
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.force_program import ForceProgram, force_program
from longwave.lattice.model import Array, Model
from longwave.lattice.numeric_lattice import Entry, NumericBond, NumericLattice
from longwave.lattice.schemes import KAHAN_LI_8, RK4
from longwave.lattice.spectral.field_ring import FieldRing
from longwave.lattice.state import State
from searches.random_chains import EstimateVerdict, judge
from tests.lattice.test_numeric_lattice import numbers


def judged(seeds: range) -> list[EstimateVerdict]:
    found = [judge(seed) for seed in seeds]
    wrong = [
        seed for seed, verdict in zip(seeds, found, strict=True) if verdict.kind == "too small"
    ]
    assert not wrong
    return found


def test_estimates_bound_the_error_on_random_chains() -> None:
    assert sum(verdict.kind == "sound" for verdict in judged(range(8))) > 4


@pytest.mark.slow
def test_estimates_bound_the_error_on_random_chains_at_length() -> None:
    assert sum(verdict.kind == "sound" for verdict in judged(range(1000, 1012))) > 8


def test_infinite_stretches_have_an_infinite_frequency_and_size() -> None:
    """A run with too long a step may end in infinite stretches, which must not raise an error."""
    dynamics = Dynamics(numbers("dimer"))
    for broken in ((-np.inf, np.inf), (np.nan, np.nan), (-1.5e308, 1.5e308)):
        ranges = np.array([broken, (0.0, 1.0), (0.0, 1.0), broken])
        assert dynamics.highest_frequency(ranges) == np.inf == dynamics.largest(ranges)


def test_slopes_whose_sum_overflows_have_an_infinite_frequency() -> None:
    """3 y^2 = 9.4e307 is finite, four times that overflows."""
    ranges = np.array([(-5.6e153, 5.6e153), (-5.6e153, 5.6e153)])
    assert Dynamics(Model(1.0, 0.0, 1.0).lattice).highest_frequency(ranges) == np.inf


def test_runs_are_concurrent_if_the_kernel_allows_it() -> None:
    lattices = Model(1, 0, 1).lattice, numbers("dimer"), numbers("square")
    assert {Dynamics(lattice).threads(KAHAN_LI_8) for lattice in lattices} == {2}
    assert {Dynamics(lattice).threads(RK4) for lattice in lattices} == {1}


def state(lattice: NumericLattice, size: int = 24) -> State:
    random = np.random.default_rng(4)
    f, v = 0.1 * random.standard_normal((2, len(lattice.fields), size))
    return State(1.0, f, v)


def test_a_linear_dimer_follows_its_waves() -> None:
    """For every wavenumber each branch oscillates with its own frequency."""
    lattice = numbers("dimer")
    lattice = with_forces(lattice, *(ForceProgram((stiffness,)) for stiffness in (1.0, 2.5)))
    start, t = state(lattice, 16), 7.5
    k = 2 * np.pi * np.fft.fftfreq(16)[:, None]
    matrices = lattice.dynamical_matrix(k, (1.0, 2.5))
    squares, modes = np.linalg.eig(matrices)
    turn = np.sqrt(np.maximum(squares.real, 0.0)) * (t - start.t)
    held = np.sinc(turn / np.pi) * (t - start.t)
    shares = [
        np.linalg.solve(modes, np.fft.fft(part).T[..., None])[..., 0] for part in start.arrays
    ]
    spectrum = np.einsum("kij,kj->ik", modes, shares[0] * np.cos(turn) + shares[1] * held)
    exact = np.fft.ifft(spectrum).real
    run = integrate(lattice, start, t, 1e-9, judged=lambda f, v, t: f)
    assert np.abs(run.f[0] - exact).max() <= run.error_estimate <= 1e-9


@pytest.mark.parametrize("name", ["next_nearest", "toda", "square"])
def test_nystroem_schemes_run_on_any_lattice(name: str) -> None:
    lattice = numbers(name)
    shape = (1, 6, 5) if lattice.dimension == 2 else (1, 12)
    f = 0.1 * np.random.default_rng(2).standard_normal(shape)
    start = State(0.0, f, 0.0 * f)
    one = integrate(lattice, start, [0.5, 2.0], 1e-4, scheme=RK4)
    other = integrate(lattice, start, [0.5, 2.0], 1e-8)
    np.testing.assert_allclose(one.f, other.f, rtol=0, atol=1e-3)
    np.testing.assert_array_equal(start.f, f)
    assert (
        lattice.energy(f, 0.0 * f)
        == pytest.approx(lattice.energy(other.f[1], other.v[1]), rel=1e-6)
        or name == "next_nearest"
    )


def test_the_strain_lattice_equals_the_model() -> None:
    y, s = 0.2 * np.random.default_rng(3).standard_normal((2, 64))
    one = integrate(Model(1.0, 0.25, 1.0).lattice, State(0.0, y[None], s[None]), [1.0, 9.0], 1e-9)
    other = integrate(numbers("fput_strain"), State(0.0, y[None], s[None]), [1.0, 9.0], 1e-9)
    np.testing.assert_allclose(other.f[:, 0], one.f[:, 0], rtol=0, atol=2e-9)
    assert other.error_estimate == pytest.approx(one.error_estimate, rel=0.5)


def test_the_user_chooses_what_is_judged() -> None:
    """The sum of all displacements drifts; stretches show neither it nor its error."""
    lattice = numbers("fput")
    start = state(lattice)
    start.f += 1e3
    middle = integrate(lattice, start, 20.0, 1e-8, judged=lambda f, v, t: f[:, 3:5] - f[:, 4:6])
    assert middle.error_estimate <= 1e-8
    with pytest.raises(ValueError, match="tolerance must satisfy tolerance >= "):
        integrate(lattice, start, 20.0, 1e-12)


def test_states_that_do_not_fit_the_lattice_are_refused() -> None:
    lattice, ring = numbers("dimer"), np.zeros((2, 8))
    for wrong, message in (
        (State(0.0, ring[:1], ring[:1]), r"state.f must have the shape .* got \(1, 8\)"),
        (State(0.0, ring, ring[:, 1:]), r"state.v must have the shape .* got \(2, 7\)"),
        (
            State(0.0, ring, ring + np.inf),
            r"state.v must be finite, got inf at index \(0, 0\)",
        ),
        (State(0.0, ring[0], ring[0]), r"state.f must have the shape .* got \(8,\)"),
        (FieldRing(0.0, (0.0,), (8.0,), ring, ring), "state must be a State, got a FieldRing"),
    ):
        with pytest.raises(ValueError, match=message):
            integrate(lattice, wrong, 1.0, 1e-3)  # type: ignore[call-overload]


def torn(name: str) -> NumericLattice:
    """Return a chain whose force is nan where its bonds are stretched by more than 1."""
    smooth = force_program(-((1 - x) ** Rational(3, 2)))
    lattice = numbers(name)
    return replace(lattice, bonds=tuple(replace(bond, force=smooth) for bond in lattice.bonds))


def test_a_stretch_without_a_force_is_reported() -> None:
    v = np.zeros((1, 16))
    v[0, 3] = 50.0
    with pytest.raises(ValueError, match="times must end before the lattice blows up"):
        integrate(torn("granular"), State(0.0, 0 * v, v), 5.0, 1e-6)


@pytest.mark.parametrize(("seed", "struck"), [(1, True), (2, True), (3, False), (4, False)])
def test_estimates_hold_when_contacts_open_and_close(seed: int, struck: bool) -> None:
    """Schemes of high order have a low one where contacts open.

    The estimate must account for it.
    """
    random, lattice = np.random.default_rng(seed), numbers("granular")
    v = 2.0 * random.standard_normal((1, 16))
    if struck:
        v = np.zeros((1, 16))
        v[0, 3] = 5.0
    run = integrate(lattice, State(0.0, 0 * v, v), [4.0], 1e-6)

    def slope(_: float, held: Array) -> Array:
        f, v = held.reshape(2, 16)
        force = -(np.maximum(1.0 - np.append(np.diff(f), f[0] - f[-1]), 0.0) ** 1.5)
        assert force.size == 16
        return np.concatenate([v, force - np.roll(force, 1)])

    held, tight = np.concatenate([0 * v[0], v[0]]), {"rtol": 1e-11, "atol": 1e-12}
    found = solve_ivp(slope, (0.0, 4.0), held, method="DOP853", max_step=0.01, **tight)
    exact = found.y[:16, -1]
    stretches = [np.append(np.diff(f), f[0] - f[-1]) for f in (run.f[0, 0], exact)]
    assert stretches[1].max() > 1.0
    assert np.abs(stretches[0] - stretches[1]).max() < run.error_estimate <= 1e-6


def with_forces(lattice: NumericLattice, *forces: ForceProgram) -> NumericLattice:
    pairs = zip(lattice.bonds, forces, strict=True)
    return replace(lattice, bonds=tuple(replace(bond, force=force) for bond, force in pairs))


def seen(lattice: NumericLattice, f: Array, amplitude: float | None = 0.1) -> str:
    found = find_blow_up(lattice, State(2.0, f, 0 * f), amplitude)
    return "" if found is None else f"{found.criterion} @ {found.site}"


def test_unstable_bonds_are_detected_as_a_blow_up() -> None:
    lattice, f = numbers("beta_fput"), np.zeros((1, 12))
    soft = with_forces(lattice, ForceProgram((1.0, 0.0, -1.0)))
    assert seen(soft, f) == ""
    f[0, 5:] = 0.9
    assert seen(soft, f) == "a bond is stretched to where waves grow @ 4"
    assert seen(soft, f, None) == ""
    assert seen(lattice, 100 * f) == "the largest stretch has grown 100-fold @ 4"
    f[0, 7] = np.nan
    assert seen(lattice, f, None) == "the fields are not finite @ 7"


def test_a_bond_stabilised_by_another_is_sound() -> None:
    """A bond with a negative slope is stabilised by another: one slope does not decide."""
    chain = numbers("klein_gordon")
    tie = chain.bonds[1].force
    lattice = with_forces(chain, ForceProgram((-0.2,)), tie)
    assert seen(lattice, np.zeros((1, 9))) == ""
    heavier = with_forces(chain, ForceProgram((-0.3,)), tie)
    assert seen(heavier, np.zeros((1, 9))).startswith("a bond is stretched")


@pytest.mark.parametrize(("K3", "K4"), [(0.0, 0.0), (0.5, -0.3), (-0.4, 0.0), (0.2, 0.7)])
def test_the_highest_frequency_is_attained_at_some_strain(K3: float, K4: float) -> None:
    lattice = with_forces(numbers("fput_strain"), ForceProgram((1.0, K3, K4)))
    y = np.random.default_rng(0).uniform(-1.5, 1.0, 50)
    dynamics = Dynamics(lattice)
    found = dynamics.highest_frequency(dynamics.ranges(State(0.0, y[None], y[None])))
    every = Model(1.0, K3, K4).stiffness(np.linspace(y.min(), y.max(), 4001))
    assert found == pytest.approx(2.0 * np.sqrt(np.abs(every).max()), rel=1e-3)


def test_a_single_site_oscillates() -> None:
    tie = NumericBond((Entry((0,), 1.0, 0),), (Entry((0,), -1.0, 0),), ForceProgram((4.0,)))
    lattice = NumericLattice("site", ("u",), (1.0,), (tie,))
    run = integrate(lattice, State(0.0, np.ones((1, 1)), np.zeros((1, 1))), 3.0, 1e-10)
    assert run.f[0, 0, 0] == pytest.approx(np.cos(6.0), abs=run.error_estimate)

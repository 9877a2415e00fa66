"""Catches: a run that continues with NaN, or reports the wrong site."""

import numpy as np
import pytest

from longwave.lattice.blow_up import find_blow_up
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.model import Model
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.lattice.state import State
from longwave.lattice.stepper import FixedDomain, Stepper

SOFT = Model(1.0, 0.0, -1.0).lattice


def state(value: float) -> State:
    """Return a state of sites -3 .. 4 with ``value`` at site 2."""
    made = State(7.5, np.full((1, 8), 0.1), np.zeros((1, 8)), left=-3)
    made.store(np.array([2]), np.array([value]), np.array([0.0]))
    return made


@pytest.mark.parametrize(
    ("value", "criterion"),
    [
        (np.nan, "not finite"),
        (-np.inf, "not finite"),
        (0.58, "a bond is stretched to where waves grow"),
        (1e200, "a bond is stretched beyond its force"),
    ],
)
def test_criterion_time_and_site_are_reported(value: float, criterion: str) -> None:
    found = find_blow_up(SOFT, state(value), 0.1)
    assert found is not None
    assert criterion in found.criterion
    assert (found.t, found.site) == (7.5, 2)
    assert str(found).endswith("at t = 7.5, site 2")


def test_runaway_strain_on_a_hard_lattice() -> None:
    found = find_blow_up(Model(1.0, 0.0, 1.0).lattice, state(10.1), 0.1)
    assert found is not None
    assert "100-fold" in found.criterion


def test_a_sound_state_passes() -> None:
    assert find_blow_up(SOFT, state(0.57), 0.1) is None


def test_a_velocity_that_is_not_finite_is_detected() -> None:
    broken = state(0.2)
    broken.v[0, 0] = np.nan
    found = find_blow_up(SOFT, broken, 0.1)
    assert found is not None
    assert found.site == 0


@pytest.mark.parametrize("K3", [-0.9, 0.0, 0.9])
@pytest.mark.parametrize("K4", [-0.3, 0.0, 0.26, 0.3])
def test_the_quick_check_of_ranges_agrees_with_all_sites(K3: float, K4: float) -> None:
    """Catches: a soft strain between the extremes, or at one of them, that is missed."""
    constants = Model(1.0, K3, K4)
    for least, most in ((-0.5, 0.2), (-2.0, 0.5), (-0.5, 2.0), (-2.0, 2.0), (0.9, 2.0)):
        strains = np.linspace(least, most, 4001)
        made = State(0.0, strains[None], np.zeros((1, strains.size)))
        soft = bool((constants.stiffness(strains) <= 0.0).any())
        dynamics = Dynamics(constants.lattice)
        found = dynamics.find_blow_up(made, dynamics.ranges(made), 1.0)
        assert (found is not None) == soft


def test_undone_steps_do_not_change_the_ranges() -> None:
    """Catches: ranges that include strains of a chunk that was undone."""
    lattice, sites = Model(1.0, 0.0, -1.0).lattice, 64
    y = 0.5 * np.sin(2.0 * np.pi * np.arange(sites) / sites)[np.newaxis]
    state = State(0.0, y, y.copy())

    class Calmed(FixedDomain):
        """Ring that is set to rest at each stop."""

        def fade(self, state: State) -> None:
            state.f *= 0.0
            state.v *= 0.0

    calm = Stepper(state, REDUCED_PHASE_6, lattice, Calmed(state), 0.05, 0.6, 80)
    list(calm.stops([4.0]))  # four units of time, together, lead beyond 4
    assert calm.blow_up is None
    assert np.abs(calm.ranges).max() < 1.0

"""Catches: runs that grow, blow up without a message, lose bits or go on beyond their horizon.

Each case is judged by its own bound; runs that must fail it are tested as well.
"""

import math
from functools import cache

import numpy as np
import pytest

from longwave.lattice.schemes import KAHAN_LI_8, RK4, STOERMER_VERLET
from longwave.lattice.stepper import advance
from longwave.reports.studies import hard_cases
from longwave.reports.studies.hard_cases import (
    HARD_CASES,
    HardCase,
    hard_case_jobs,
    run_hard_case,
)
from longwave.reports.studies.travelling_waves import travelling_wave
from longwave.support.processes import Job

FAST = [name for name, case in HARD_CASES.items() if not case.slow]
SLOW = [name for name, case in HARD_CASES.items() if case.slow]

found_of = cache(run_hard_case)


@pytest.mark.parametrize("name", FAST)
def test_hard_case(name: str) -> None:
    found = found_of(name)
    assert found.passed, f"{found.what}: {found.criterion}: {found.measured} > {found.bound}"


@pytest.mark.slow
@pytest.mark.parametrize("name", SLOW)
def test_long_hard_case(name: str) -> None:
    found = run_hard_case(name)
    assert found.passed, f"{found.what}: {found.criterion}: {found.measured} > {found.bound}"


def test_the_error_message_states_the_limit() -> None:
    message = found_of("step_limit").message
    assert message.startswith("step must satisfy step <= 0.707106")
    assert "(linear stability limit of rk4 at the zone boundary" in message


def test_the_blow_up_message_states_time_site_and_criterion() -> None:
    message = found_of("soft_lattice").message
    assert message.startswith(
        "blow-up: a bond is stretched to where waves grow at t = 65, site -635, 4 sites"
    )


def test_nan_does_not_pass() -> None:
    assert not HardCase("", "", 1.0, math.nan).passed


def test_the_cases_are_jobs_in_the_order_in_which_they_are_declared() -> None:
    assert list(hard_case_jobs(full=True)) == [("hard", name) for name in HARD_CASES]
    assert list(hard_case_jobs(full=False)) == [("hard", name) for name in FAST]
    assert hard_case_jobs(full=True)["hard", "cn_growth"] == Job(run_hard_case, ("cn_growth",), 1.0)
    assert len(HARD_CASES) == 14


def test_a_scheme_that_is_not_symplectic_fails_the_energy_case() -> None:
    bound = HARD_CASES["energy_drift_short"].bound
    assert hard_cases.drift(RK4, 0.1, 50_000) > 2.0 * bound
    assert hard_cases.drift(STOERMER_VERLET, 0.2, 50_000) < bound


def test_an_unstable_wave_fails_the_noise_case() -> None:
    """The measure of the sn and dn cases sees the growth of the cn wave."""
    wave = travelling_wave(*hard_cases.CN)
    n = np.arange(float(16 * wave.period))
    noise = 1e-6 * wave.eps * np.random.default_rng(7).standard_normal(n.size)
    y, s = wave.strain(n) + noise, wave.velocity(n)
    first, _ = wave.shape_deviation(y, 0.0)
    advance(KAHAN_LI_8, y[None], s[None], 0.5, 8000, wave.constants.lattice)
    later, _ = wave.shape_deviation(y, 4000.0)
    assert later > 2.0 * HARD_CASES["stable_sn"].bound * first


def test_a_shifted_wave_has_its_shape() -> None:
    wave = travelling_wave("wave_dn", 0.7, 27, 1, 1)
    n = np.arange(float(8 * wave.period))
    deviation, shift = wave.shape_deviation(wave.strain(n - 12.3), 12.0)
    assert shift == pytest.approx(12.3 - 12.0 * wave.speed, abs=1e-10)
    assert deviation < 1e-15

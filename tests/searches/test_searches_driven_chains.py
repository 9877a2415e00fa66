"""Catches: a search that calls a wrong run right, and an estimate that is too small."""

from dataclasses import replace

import numpy as np
import pytest

from longwave.lattice import integrate
from searches.driven_chains import attacked, drawn, true_error


@pytest.mark.parametrize("seed", [1, 5, 8, 19])
def test_estimates_of_driven_chains_are_honest(seed: int) -> None:
    share, text = attacked(seed)
    assert np.isnan(share) or share < 1.0, text


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 140))
def test_estimates_of_many_driven_chains_are_honest(seed: int) -> None:
    share, text = attacked(seed)
    assert np.isnan(share) or share < 1.0, text


def test_a_force_that_is_felt_late_is_found() -> None:
    case = drawn(19)
    run = integrate(case.chain, case.state, [case.end], case.tolerance)
    assert true_error(case, run) < run.error_estimate
    force, *others = case.chain.outer_forces
    late = replace(force, value=lambda t: force.value(t - 0.01))
    wrong = replace(case, chain=replace(case.chain, outer_forces=(late, *others)))
    assert true_error(wrong, run) > run.error_estimate

"""Catches: a search that calls a wrong run right, and an estimate that is too small."""

from dataclasses import replace
from typing import Any

import pytest

from longwave.lattice import DrivenChain, energy_balance, integrate
from searches.driven_chains import (
    attacked,
    balance_error,
    balanced,
    drawn,
    exact_end,
    exact_state,
    true_error,
)


@pytest.mark.parametrize(
    "seed", [3, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (12, 17, 53))]
)
def test_estimates_of_driven_chains_are_honest(seed: int) -> None:
    *shares, text = attacked(seed)
    assert not any(share >= 1.0 for share in shares), f"{shares}; {text}"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 114))
def test_estimates_of_many_driven_chains_are_honest(seed: int) -> None:
    *shares, text = attacked(seed)
    assert not any(share >= 1.0 for share in shares), f"{shares}; {text}"


def test_a_force_that_is_felt_late_is_found() -> None:
    case = drawn(8)
    run = integrate(case.chain, case.state, [case.end], case.tolerance)
    assert true_error(case, run, exact_state(case)) < run.error_estimate
    force, *others = case.chain.outer_forces
    late = replace(force, value=lambda t: force.value(t - 0.01))
    wrong = replace(case, chain=replace(case.chain, outer_forces=(late, *others)))
    assert true_error(wrong, run, exact_state(wrong)) > run.error_estimate


def test_heat_that_is_wrong_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    case = drawn(8)
    exact, found = exact_end(case), balanced(case, 1e-4)
    assert found.trial.values is not None
    heat = found.trial.values[-1, 2]
    assert heat > 1e-3
    assert balance_error(case, found, exact) < found.error
    power = energy_balance.power

    def cold(chain: DrivenChain, *asked: Any) -> tuple[Any, Any]:
        flows, acceleration = power(chain, *asked)
        flows[-1] *= 0.99
        return flows, acceleration

    monkeypatch.setattr(energy_balance, "power", cold)
    wrong = balanced(case, 1e-4)
    assert balance_error(case, wrong, (exact[0], exact[1] * [1.0, 0.99])) > wrong.error

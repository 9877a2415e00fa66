"""The hard cases that must stay stable, as a table. Adding one is one function and one entry."""

from collections.abc import Sequence

from verify.study import cases_background, cases_rounding, cases_stability
from verify.study.hard_case import Case, HardCase

HARD_CASES = (
    Case(
        "step_limit",
        "a step past the linear stability limit is refused; limit told against limit observed",
        1e-3,
        cases_stability.step_limit,
    ),
    Case(
        "soft_lattice",
        "blow-up where K2 + 3 K4 y^2 changes sign: steps off the double-double run's",
        1.0,
        cases_stability.soft_lattice,
    ),
    Case(
        "zone_boundary_noise",
        "growth of k = pi noise of 1e-12 on a dn wave over t = 10^4, at 0.99 of the step limit",
        10.0,
        cases_stability.zone_boundary_noise,
    ),
    Case(
        "wrong_feed",
        "moves of the window until a feed wrong by 0.1 % stops the run",
        1.0,
        cases_stability.wrong_feed,
    ),
    Case(
        "cn_growth",
        "unstable cn wave: growth rate of the seeded mode, relative to Floquet theory's",
        0.01,
        cases_background.cn_growth,
    ),
    Case(
        "cn_horizon",
        "unstable cn wave: time until rounding reaches 1e-4 eps, relative to the horizon told",
        0.35,
        cases_background.cn_horizon,
        slow=True,
    ),
    Case(
        "stable_sn",
        "stable sn wave: growth of noise over t = 10^4, shifts removed",
        2.0,
        cases_background.stable_sn,
    ),
    Case(
        "stable_dn",
        "stable dn wave: growth of noise over t = 10^4, shifts removed",
        2.0,
        cases_background.stable_dn,
    ),
    Case(
        "energy_drift_short",
        "energy error of Stoermer-Verlet over 10^6 steps, last tenth over first",
        3.0,
        cases_rounding.energy_drift_short,
    ),
    Case(
        "energy_drift",
        "energy error of the symplectic schemes over 10^6 steps, last tenth over first",
        3.0,
        cases_rounding.energy_drift,
        slow=True,
    ),
    Case(
        "rounding_growth",
        "exponent of the rounding error of the energy in t",
        0.75,
        cases_rounding.rounding_growth,
    ),
    Case(
        "rounding_floor",
        "double against double-double at t = 500, sup of y/eps",
        1e-12,
        cases_rounding.rounding_floor,
    ),
    Case(
        "time_reversal",
        "run forwards, turn the velocities, run again: sup of y/eps",
        1e-12,
        cases_rounding.time_reversal,
    ),
    Case(
        "restart",
        "values that differ by a bit after a restart from a snapshot",
        0.0,
        cases_rounding.restart,
    ),
)


def hard_case(name: str) -> Case:
    """The case of that name; ValueError lists the known ones."""
    for case in HARD_CASES:
        if case.name == name:
            return case
    known = ", ".join(case.name for case in HARD_CASES)
    raise ValueError(f"name must be a hard case, got {name!r} (one of {known})")


def run_hard_cases(cases: Sequence[Case] = HARD_CASES) -> list[HardCase]:
    """Run the cases, in order."""
    return [case.run() for case in cases]

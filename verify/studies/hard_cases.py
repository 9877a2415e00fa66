"""The hard cases that must stay stable, as a table. Adding one is one function and one entry."""

from collections.abc import Sequence

from verify.studies import cases_background, cases_rounding, cases_stability
from verify.studies.hard_case import HardCase, HardCaseResult

HARD_CASES = (
    HardCase(
        "step_limit",
        "each scheme with a step $10^{-6}$ past its linear stability limit",
        "relative difference of the limit told and the one observed (infinite unless refused)",
        1e-3,
        cases_stability.step_limit,
    ),
    HardCase(
        "soft_lattice",
        "a wave that crosses $V''=0$: the lattice goes soft",
        "steps between the time told and a double-double run's",
        1.0,
        cases_stability.soft_lattice,
    ),
    HardCase(
        "zone_boundary_noise",
        "noise at the zone boundary on a dn wave, 0.99 of the step limit, to $t=10^4$",
        "factor by which it grows",
        10.0,
        cases_stability.zone_boundary_noise,
    ),
    HardCase(
        "wrong_feed",
        "a window fed with a far field that is wrong by 0.1 %",
        "moves of the window until the run stops",
        1.0,
        cases_stability.wrong_feed,
    ),
    HardCase(
        "cn_growth",
        "unstable cn wave, its fastest mode seeded",
        "relative difference of its growth rate and Floquet theory's",
        0.01,
        cases_background.cn_growth,
    ),
    HardCase(
        "cn_horizon",
        "unstable cn wave, rounding alone",
        "relative difference of the time at which $10^{-4}eps$ is lost and the horizon told",
        0.35,
        cases_background.cn_horizon,
        slow=True,
    ),
    HardCase(
        "stable_sn",
        "stable sn wave with noise, to $t=10^4$",
        "factor by which it grows, shifts removed",
        2.0,
        cases_background.stable_sn,
    ),
    HardCase(
        "stable_dn",
        "stable dn wave with noise, to $t=10^4$",
        "factor by which it grows, shifts removed",
        2.0,
        cases_background.stable_dn,
    ),
    HardCase(
        "energy_drift_short",
        "Stoermer-Verlet, $10^6$ steps",
        "energy error of the last tenth over that of the first (16 for a drift)",
        3.0,
        cases_rounding.energy_drift_short,
    ),
    HardCase(
        "energy_drift",
        "every symplectic scheme, $10^6$ steps",
        "energy error of the last tenth over that of the first (16 for a drift)",
        3.0,
        cases_rounding.energy_drift,
        slow=True,
    ),
    HardCase(
        "rounding_growth",
        "rounding of the energy, 30000 steps",
        "exponent of its growth in $t$ (1/2 unbiased, 1 biased)",
        0.75,
        cases_rounding.rounding_growth,
    ),
    HardCase(
        "rounding_floor",
        "double against double-double, to $t=500$",
        "largest difference of $y/eps$",
        1e-12,
        cases_rounding.rounding_floor,
    ),
    HardCase(
        "time_reversal",
        "a run forwards, velocities turned, and again",
        "largest difference of $y/eps$ to the start",
        1e-12,
        cases_rounding.time_reversal,
    ),
    HardCase(
        "restart",
        "a restart from a snapshot",
        "values that differ by a bit",
        0.0,
        cases_rounding.restart,
    ),
)


def hard_case(name: str) -> HardCase:
    """The case of that name; ValueError lists the known ones."""
    for case in HARD_CASES:
        if case.name == name:
            return case
    known = ", ".join(case.name for case in HARD_CASES)
    raise ValueError(f"name must be a hard case, got {name!r} (one of {known})")


def run_hard_cases(cases: Sequence[HardCase] = HARD_CASES) -> list[HardCaseResult]:
    """Run the cases, in order."""
    return [case.run() for case in cases]

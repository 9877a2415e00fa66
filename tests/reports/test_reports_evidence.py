"""Evidence and claims: numbers from known runs, verdicts that follow the numbers."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from reports import claims
from reports.claims import CONFIRMED, DEPENDS, NOT_CONFIRMED, Claim
from reports.evidence import RK4_STEP, Evidence, report_scenes, rk4_name
from verify.lattice import Scene

SCENES = report_scenes()


def fake_run(scene: Scene, top: float, when: float = 0.0) -> xr.Dataset:
    """A run whose error is `top` at time `when` and falls away from it; amplitude 2 eps."""
    times = np.array(scene.snapshots)
    curve_time = np.unique(np.append(np.linspace(scene.t0, scene.end, 9), when))
    curve = top / (1 + np.abs(curve_time - when))
    site = np.arange(-1, 2)
    crest = scene.eps * np.array([0.0, 2.0, 0.0])
    rows = np.tile(crest, (len(times), 1))
    return xr.Dataset(
        {
            "error": ("time", np.full(len(times), top)),
            "error_far_field": ("time", np.full(len(times), top / 2)),
            "time_step_error": ("time", np.full(len(times), 3e-4)),
            "domain_error": ("time", np.full(len(times), 1e-4)),
            "error_curve": ("curve_time", curve),
            "strain": (("time", "site"), 0.9 * rows),
            "analytic": (("time", "site"), rows),
            "background": (("time", "site"), 0.0 * rows),
        },
        {"time": times, "curve_time": curve_time, "site": site},
    )


def evidence(tops: Mapping[str, float], when: float = 0.0) -> Evidence:
    runs = {name: fake_run(scene, tops.get(name, 0.1), when) for name, scene in SCENES.items()}
    return Evidence(runs, SCENES)


def test_step_and_domain_add_up_over_the_errors_own_denominator() -> None:
    """Catches the denominator left out: 4e-4 of y/eps over an amplitude of 2 is 2e-4."""
    number = evidence({}).relative_error("rational_2_eps_0.05", 0.0)
    assert number.value == pytest.approx(0.1)
    assert number.error == pytest.approx(2e-4)


def test_a_missing_domain_error_is_not_counted() -> None:
    runs = {"rational_2_eps_0.05": fake_run(SCENES["rational_2_eps_0.05"], 0.1)}
    bare = {name: run.drop_vars("domain_error") for name, run in runs.items()}
    number = Evidence(bare, SCENES).relative_error("rational_2_eps_0.05", 0.0)
    assert number.error == pytest.approx(1.5e-4)


def test_the_largest_error_and_its_time() -> None:
    number, time = evidence({}, when=-700.0).largest_error("rational_2_eps_0.05")
    assert (number.value, time) == (0.1, -700.0)


def test_peaks_are_in_units_of_eps() -> None:
    lattice, wave = evidence({}).peaks("rogue_cn_k_0.5", 0.0)
    assert lattice.value == pytest.approx(1.8)
    assert lattice.error == pytest.approx(4e-4)
    assert wave == pytest.approx(2.0)


def test_the_rk4_variant_changes_scheme_and_step_only() -> None:
    base, variant = SCENES["rational_2_eps_0.05"], SCENES[rk4_name(2)]
    assert (variant.scheme, variant.step) == ("rk4", RK4_STEP)
    assert replace(
        variant, scheme=base.scheme, step=base.step, observables=base.observables
    ) == replace(base)


def test_every_claim_has_text_and_a_known_verdict() -> None:
    found = claims.all_claims(evidence({}))
    assert len(found) == len(claims.CLAIMS)
    for claim in found:
        assert isinstance(claim, Claim)
        assert claim.statement
        assert claim.measured
        assert claim.verdict in (CONFIRMED, NOT_CONFIRMED, DEPENDS)


@pytest.mark.parametrize(
    ("accurate", "rk4", "expected"),
    [(0.15, 0.15, CONFIRMED), (0.15, 0.25, DEPENDS), (0.25, 0.3, NOT_CONFIRMED)],
)
def test_the_20_percent_claim_follows_the_numbers(
    accurate: float, rk4: float, expected: str
) -> None:
    tops = {"rational_3_eps_0.05": accurate, rk4_name(3): rk4}
    assert claims.error_stays_below_20_percent(evidence(tops)).verdict == expected


@pytest.mark.parametrize(
    ("errors", "expected"), [((3, 2, 1), CONFIRMED), ((1, 2, 3), NOT_CONFIRMED)]
)
def test_the_breather_claim_follows_the_numbers(
    errors: tuple[float, float, float], expected: str
) -> None:
    names = [f"breather_sn_k_{modulus}" for modulus in claims.BREATHER_MODULI]
    tops = dict(zip(names, errors, strict=True))
    assert claims.breather_error_falls_with_k(evidence(tops)).verdict == expected


def test_around_the_largest_amplitude() -> None:
    assert claims.error_peaks_with_the_wave(evidence({})).verdict == CONFIRMED
    assert claims.error_peaks_with_the_wave(evidence({}, -4000.0)).verdict == NOT_CONFIRMED


def test_the_order_claim_depends_when_only_the_top_is_higher() -> None:
    higher = {name: 0.2 for name in SCENES if name.startswith("rational_3")}
    assert claims.error_grows_with_the_order(evidence(higher)).verdict == CONFIRMED
    assert claims.error_grows_with_the_order(evidence({})).verdict == NOT_CONFIRMED


def test_the_peaks_are_exact() -> None:
    claim = claims.peaks_of_the_waves(evidence({}))
    assert claim.verdict == CONFIRMED
    assert "$Y_2=5$, $Y_3=7$" in claim.measured
    assert "$3 k$" in claim.measured

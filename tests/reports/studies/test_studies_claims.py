"""Measured runs and claims: numbers from known runs, verdicts that follow the numbers."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from longwave.reports.studies import claims
from longwave.reports.studies.claims import Ruling
from longwave.reports.studies.measured_runs import (
    PARTS,
    RK4_STEP,
    SPLIT,
    MeasuredRuns,
    report_scenes,
    rk4_name,
)
from longwave.scenes.description.scene import Scene

SCENES = report_scenes()


def fake_run(scene: Scene, top: float, when: float = 0.0) -> xr.Dataset:
    """Return a run of amplitude 2 eps whose error is largest, `top`, at time `when`."""
    times = np.array(scene.snapshots)
    curve_time = np.unique(np.append(np.linspace(scene.t0, scene.end, 9), when))
    curve = top / (1 + np.abs(curve_time - when))
    site = np.arange(-1, 2)
    crest = scene.eps * np.array([0.0, 2.0, 0.0])
    rows = np.tile(crest, (len(times), 1))
    shares = zip(PARTS, (2, 4, 8), strict=True)
    parts = {f"error_{name}": ("time", np.full(len(times), top / part)) for name, part in shares}
    return xr.Dataset(
        {
            **parts,
            "shift": ("time", np.full(len(times), -0.4)),
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


def evidence(tops: Mapping[str, float], when: float = 0.0) -> MeasuredRuns:
    runs = {name: fake_run(scene, tops.get(name, 0.1), when) for name, scene in SCENES.items()}
    return MeasuredRuns(runs, SCENES)


def test_step_and_domain_add_up_twice_over_the_errors_own_denominator() -> None:
    """Catches the denominator left out: 4e-4 of y/eps over an amplitude of 2 is 2e-4."""
    number = evidence({}).relative_error("rational_2_eps_0.05", 0.0)
    assert number.value == pytest.approx(0.1)
    assert number.error == pytest.approx(4e-4)


def test_a_missing_domain_error_is_not_counted() -> None:
    runs = {"rational_2_eps_0.05": fake_run(SCENES["rational_2_eps_0.05"], 0.1)}
    bare = {name: run.drop_vars("domain_error") for name, run in runs.items()}
    number = MeasuredRuns(bare, SCENES).relative_error("rational_2_eps_0.05", 0.0)
    assert number.error == pytest.approx(3e-4)


def test_the_largest_error_and_its_time() -> None:
    number, time = evidence({}, when=-700.0).largest_error("rational_2_eps_0.05")
    assert (number.value, time) == (0.1, -700.0)


def test_peaks_are_in_units_of_eps() -> None:
    lattice, wave = evidence({}).peaks("rogue_cn_k_0.5", 0.0)
    assert lattice.value == pytest.approx(1.8)
    assert lattice.error == pytest.approx(8e-4)
    assert wave == pytest.approx(2.0)


def test_a_split_carries_the_runs_own_error() -> None:
    """Catches the parts' error taken for the shift's: 8e-4 of y/eps with slopes of 2 a site."""
    parts = evidence({}).split(SPLIT, 0.0)
    assert parts["shift"] == pytest.approx((-0.4, 8e-4 / 2.0))
    assert parts["position"] == pytest.approx((0.1 / 2, 4e-4))


def test_the_claim_states_the_shift_of_the_wave() -> None:
    found = claims.peak_of_the_error(evidence({}))
    values = {item.of.split(", ")[-1]: item.value for item in found.measurements}
    assert values["the lattice's wave is shifted by sites"] == -0.4
    assert values["part by position"] == pytest.approx(0.1 / 2)
    assert values["part by shape"] == pytest.approx(0.1 / 8)


def test_the_rk4_variant_changes_scheme_and_step_only() -> None:
    base, variant = SCENES["rational_2_eps_0.05"], SCENES[rk4_name(2)]
    stated = variant.discretisation
    assert (stated.scheme, stated.step) == ("rk4", RK4_STEP)
    assert replace(variant, numerics=base.numerics, observables=base.observables) == base


@pytest.mark.slow
def test_every_claim_has_a_name_a_statement_and_numbers() -> None:
    found = claims.all_claims(evidence({}))
    assert len({claim.name for claim in found}) == len(found) == 15
    for claim in found:
        assert claim.statement.count("$") % 2 == 0
        assert claim.measurements
        assert all(math.isfinite(item.value) for item in claim.measurements)


@pytest.mark.parametrize(
    ("accurate", "rk4", "expected"),
    [
        (0.15, 0.15, Ruling.CONFIRMED),
        (0.15, 0.25, Ruling.DEPENDS),
        (0.25, 0.3, Ruling.NOT_CONFIRMED),
    ],
)
def test_the_20_percent_claim_follows_the_numbers(
    accurate: float, rk4: float, expected: Ruling
) -> None:
    tops = {"rational_3_eps_0.05": accurate, rk4_name(3): rk4}
    assert claims.twenty_percent(evidence(tops)).ruling is expected


@pytest.mark.parametrize(
    ("errors", "expected"), [((3, 2, 1), Ruling.CONFIRMED), ((1, 2, 3), Ruling.NOT_CONFIRMED)]
)
def test_the_breather_claim_follows_the_numbers(
    errors: tuple[float, float, float], expected: Ruling
) -> None:
    names = [f"breather_sn_k_{modulus}" for modulus in claims.BREATHER_MODULI]
    tops = dict(zip(names, errors, strict=True))
    assert claims.breather_and_modulus(evidence(tops)).ruling is expected


def test_around_the_largest_amplitude() -> None:
    near, far = evidence({}), evidence({}, -4000.0)
    assert claims.peak_of_the_error(near).ruling is Ruling.CONFIRMED
    assert claims.peak_of_the_error(far).ruling is Ruling.NOT_CONFIRMED


def test_the_order_claim_depends_when_only_the_top_is_higher() -> None:
    higher = {name: 0.2 for name in SCENES if name.startswith("rational_3")}
    found = claims.error_against_order(evidence(higher))
    assert found.ruling is Ruling.CONFIRMED
    equal = claims.error_against_order(evidence({}))
    assert equal.ruling is Ruling.NOT_CONFIRMED


def test_the_peaks_are_exact() -> None:
    found = claims.peaks(evidence({}))
    assert found.ruling is Ruling.CONFIRMED
    assert [item.value for item in found.measurements] == [5, 7, 9, 11, 13, 15, 17]


def test_the_waves_vanish_in_space_and_not_in_time() -> None:
    """mathematics of the tau functions: extrema at distance 4 from the background remain."""
    assert claims.localised_in_space(evidence({})).ruling is Ruling.CONFIRMED
    found = claims.localised_in_time(evidence({}))
    assert found.ruling is Ruling.NOT_CONFIRMED
    assert [item.value for item in found.measurements] == pytest.approx([4, 4], abs=0.01)


def test_the_instability_is_too_slow_to_be_visible() -> None:
    """Catches a rate taken per tau instead of per lattice time."""
    found = claims.modulational_instability(evidence({}))
    growth = [item.value for item in found.measurements]
    assert 1.001 < growth[0] < 1.02
    assert growth[1:] == [1.0, 1.0]
    assert found.ruling is Ruling.NOT_CONFIRMED

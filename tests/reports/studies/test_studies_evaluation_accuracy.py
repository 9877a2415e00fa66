"""Evaluation over the stated domain; the dense table is `longwave verify accuracy`."""

import json
import math
from typing import Any

import pytest
import sympy as sp

from longwave.reports.studies.evaluation_accuracy import DRAWN as DRAWN_CASES
from longwave.reports.studies.evaluation_accuracy import (
    MODULI,
    TIMES,
    Accuracy,
    WaveCase,
    all_cases,
    drawn_cases,
    measure_accuracy,
    wave_names,
    worst_of,
)
from longwave.solutions import CATALOGUE, Wave
from longwave.verify.__main__ import main
from tests.families import WAVES, family


@pytest.mark.parametrize("name", family(wave_names(), quick=(*WAVES, "rational_4")))
def test_a_few_points_of_every_wave(name: str) -> None:
    """At T = 0 and late, from the whole domain of parameters, K2, K4, eps and sites.

    Drawn ones of other equations than mKdV are left to the test of the whole domain.
    """
    cases = [next(all_cases(name))]
    if name not in CATALOGUE.names or name in CATALOGUE.of("mKdV").names:
        cases += drawn_cases(name, 2, seed=2)
    for case in cases:
        accuracy = measure_accuracy(case, times=case.times[::2], per_time=2, grid=201)
        assert accuracy.passed, accuracy


@pytest.mark.slow
@pytest.mark.parametrize("name", wave_names())
def test_the_whole_domain(name: str) -> None:
    worst = worst_of(measure_accuracy(case, per_time=4, grid=201) for case in all_cases(name, 6))
    assert worst.passed, worst


@pytest.mark.parametrize("part", ["Y", "Y_X", "Y_T"])
def test_a_wave_wrong_in_its_last_digits_is_detected(
    part: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    case, at = WaveCase("kink", (("A", sp.Integer(40)),)), Wave.at

    def wrong(wave: Wave, *point: Any) -> Any:
        values = at(wave, *point)
        return values._replace(**{part: getattr(values, part) * (1 + 4e-13)})

    monkeypatch.setattr(Wave, "at", wrong)
    assert not measure_accuracy(case, times=(2960,), grid=201).passed


def test_nan_does_not_pass() -> None:
    assert not Accuracy("kink", 1, (0.0, math.nan, 0.0), "").passed


def test_cases_reach_the_ends_of_the_domain() -> None:
    cases = list(all_cases("breather_sn"))
    assert len(cases) == 3 * len(MODULI) + DRAWN_CASES
    assert str(cases[0]).startswith("k = 1e-08, alpha = 1.571e-08")
    assert str(cases[3 * len(MODULI) - 1]).startswith("k = 1 - 1e-12, alpha = 14.86")
    assert str(list(all_cases("rational_5"))[1]) == "tau_5 = -2.333, tau_9 = 5.5"
    with pytest.raises(ValueError, match="name must be a wave, got 'soliton'"):
        list(all_cases("soliton"))


def test_drawn_cases_reach_the_whole_domain() -> None:
    """Catches a range in the wrong unit: each end is approached by a decade."""
    cases = list(drawn_cases("kink", 200))
    sizes = [(c.parameters[0][1], c.K2, c.K4, c.eps) for c in cases]
    for column, (low, high) in zip(
        zip(*sizes, strict=True), ((-3, 3), (-4, 4), (-4, 4), (-3, -0.3)), strict=True
    ):
        exponents = [math.log10(value) for value in column]
        assert low <= min(exponents) < low + 1
        assert high - 1 < max(exponents) <= high
    assert str(cases[1]).endswith("K2 = 0.0001, K4 = -1e+04, eps = 0.5")
    sites = [abs(math.sqrt(c.K2) * t) for c in cases for t in c.times]
    assert max(sites) == pytest.approx(1e8)
    moduli = [float(c.parameters[0][1]) for c in drawn_cases("wave_cn", 100)]
    assert min(moduli) < 1e-6
    assert max(moduli) > 1 - 1e-9


@pytest.mark.slow
def test_command_prints_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["accuracy", "--only", "rational_1", "--drawn", "1", "--jobs", "1", "--json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)
    assert record["wave"] == "rational_1"
    assert record["points"] == 9 * (len(TIMES) + 3)
    assert max(record["errors"].values()) < 1e-15


def test_command_refuses_what_it_does_not_know(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["accuracy", "--only", "soliton"]) == 2
    assert (
        "--only must be a wave, got soliton (did you mean soliton_dn, " in capsys.readouterr().err
    )

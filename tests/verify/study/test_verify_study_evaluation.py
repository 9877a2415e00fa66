"""Evaluation over the stated domain; the dense table is `python -m verify accuracy`."""

import json
import math

import pytest

from verify.__main__ import main
from verify.study import evaluation
from verify.study.evaluation import Accuracy, measure, worst_of
from verify.study.evaluation_cases import MODULI, Case, all_cases, wave_names

SPARSE = [
    pytest.param(case, id=f"{case.name}-{case}")
    for name in wave_names()
    for case in list(all_cases(name))[:: 1 if name in ("soliton_dn", "rogue_cn") else 5]
]


@pytest.mark.parametrize("case", SPARSE)
def test_a_few_points_of_every_wave(case: Case) -> None:
    """Where double is worst at T = 0.37 and T = -1e4."""
    assert measure(case, times=(2960, -80_000_000), per_time=2, grid=401).passed


@pytest.mark.slow
@pytest.mark.parametrize("name", wave_names())
def test_the_whole_domain(name: str) -> None:
    worst = worst_of(measure(case) for case in all_cases(name))
    assert worst.passed, worst


@pytest.mark.parametrize(
    ("case", "t"),
    [(Case("rogue_cn", (("k", MODULI[-1]),)), 0), (Case("rational_3"), 80_000_000)],
    ids=lambda value: getattr(value, "name", None),
)
def test_double_is_seen_to_fail(case: Case, t: int) -> None:
    """The measurement notices what double-double is there for."""
    assert not measure(case, times=(t,), per_time=3, precision="double").passed
    assert measure(case, times=(t,), per_time=3).passed


def test_nan_does_not_pass() -> None:
    assert not Accuracy("kink", ("double",), 1, (0.0, math.nan, 0.0), "").passed


def test_cases_reach_the_ends_of_the_domain() -> None:
    cases = list(all_cases("breather_sn"))
    assert len(cases) == 3 * len(MODULI)
    assert str(cases[0]).startswith("k = 1e-08, alpha = 1.571e-08")
    assert str(cases[-1]).startswith("k = 1 - 1e-12, alpha = 14.86")
    assert str(list(all_cases("rational_5"))[1]) == "tau_5 = -2.333, tau_9 = 5.5"
    with pytest.raises(ValueError, match="name must be a wave, got 'soliton'"):
        list(all_cases("soliton"))


def test_command_prints_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["accuracy", "--only", "kink", "--jobs", "1", "--json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)
    assert record["wave"] == "kink"
    assert record["points"] == 3 * 9 * len(evaluation.TIMES)
    assert max(record["errors"].values()) < 3e-15


def test_command_refuses_what_it_does_not_know(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["accuracy", "--only", "soliton"]) == 2
    assert "--only must be a wave, got soliton (one of rational_1" in capsys.readouterr().err

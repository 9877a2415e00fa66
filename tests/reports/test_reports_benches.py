"""Catches: an effect that the table does not name, a chain that is left out, a wrong estimate."""

from dataclasses import replace

import pytest

from longwave.reports.latex import scientific, uncertain
from longwave.reports.sections.benches import (
    balance_table,
    bench_figures,
    bench_laws,
    bench_pictures,
    bench_table,
    effect_table,
    effects,
)
from longwave.reports.studies.bench_laws import mode_return, struck_exponent
from longwave.reports.studies.effects import TOLERANCES, EffectCost, effect_cost
from longwave.reports.studies.lattice_runs import SceneRun, scene_run
from longwave.scenes.description.bench import Bench, Noise, Push
from longwave.scenes.description.losses import Losses


@pytest.fixture(scope="module")
def found() -> SceneRun:
    return scene_run("driven_chain")


def test_the_table_states_each_effect_and_its_cost(found: SceneRun) -> None:
    assert found.within_tolerance
    assert found.run is not None
    text = bench_table({"driven_chain": found})
    attributes = found.run.attrs
    assert "ends: fixed, fixed; losses of cells; forces" in text
    assert "(\\texttt{driven\\_chain})" in text
    for part in (
        f"${attributes['steps']}$",
        scientific(1e-10),
        scientific(attributes["error_estimate"]),
    ):
        assert part in text
    assert scientific(attributes["seconds"] + attributes["planning_seconds"]) in text
    late = SceneRun(found.scene, found.run.assign_attrs(error_estimate=1e-3))
    assert "TOO LARGE" in bench_table({"driven_chain": late})


def test_the_balance_of_energy_is_stated(found: SceneRun) -> None:
    assert found.run is not None
    text = balance_table({"driven_chain": found, "other": replace(found, run=None)})
    heat = found.run["heat"]
    for value in (found.run["work"][-1], heat[-1], found.run["energy"][-1]):
        assert scientific(float(value), 4) in text
    assert text.count("texttt") == 1
    assert text.count(r"\label{tab:balance}") == 1
    off = SceneRun(found.scene, found.run.assign(heat=heat + 0.25))
    assert scientific(0.25) in balance_table({"driven_chain": off})


def test_a_chain_that_did_not_run_says_why_and_has_no_picture(found: SceneRun) -> None:
    runs = {"driven_chain": found, "other": replace(found, run=None, fault="times must end")}
    assert "did not run: times must end" in bench_table(runs)
    assert [name for name, _ in bench_figures(runs)] == ["bench_driven_chain"]
    assert bench_pictures(runs).count("includegraphics") == 1


def test_every_effect_has_a_name() -> None:
    ends = {"displacement": "sin(t)"}, "free"
    bench = Bench(8, ends, (), (Push(0, "t"),), noise=Noise(1.0), energy=True)
    losses = Losses(site=(("u", 0.1),), bond=0.2)
    words = "ends: moved, free; losses of cells; dashpots; forces; a bath"
    assert effects(bench, losses) == words


def test_the_cost_of_an_effect_is_stated_at_every_tolerance() -> None:
    text = effect_table({"a force": EffectCost(8, 3.1e-10, 0.81, ((1e-7, 0.02), (1e-11, 0.07)))})
    for entry in ("a force", "$8$", "$0.31$", "$81$", scientific(1e-11), scientific(0.07)):
        assert entry in text


def test_an_effect_adds_operations_and_is_run_to_its_tolerances() -> None:
    alone, damped = effect_cost("none"), effect_cost("losses of cells")
    assert alone.operations < damped.operations
    for cost in (alone, damped):
        assert cost.seconds > 0.0
        assert cost.share > 0.0
        for (error, _), tolerance in zip(cost.runs, TOLERANCES, strict=True):
            assert 0.0 < error <= tolerance


@pytest.mark.slow
def test_what_is_known_of_chains_is_measured() -> None:
    found = scene_run("fput_1955")
    assert found.run is not None
    back = mode_return(found.run)
    assert back.periods == pytest.approx(146.4, abs=0.2)
    assert back.share == pytest.approx(0.981, abs=0.002)
    exponent, error = struck_exponent()
    assert abs(exponent - 0.2) < 3.0 * error < 1e-5
    text = bench_laws({"fput_1955": found}, [(exponent, error)])
    assert " & ".join(uncertain(exponent, error)) in text
    assert " & ".join(uncertain(back.periods, back.reading / 2)) in text
    own = found.run.attrs["error_estimate"] / float(found.run.mode_energy[0, 0])
    assert " & ".join(uncertain(100 * back.share, 100 * own)) in text

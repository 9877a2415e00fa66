"""Catches: a sweep that starts though it takes days, or an estimate without the cost of forces."""

from pathlib import Path
from typing import Any

import pytest

from longwave.__main__ import main
from longwave.runs import sweep_cells, sweep_cost
from longwave.runs.run_store import RunStore
from longwave.runs.sweep_cells import Cell, run_cells
from longwave.runs.sweep_cost import expected_sweep_cost
from longwave.runs.sweep_file import Sweep, sweep_of
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.engines.methods import expected_cost
from longwave.support.request_limits import ExpectedCost, RequestLimits

SWEEP = """
[scene]
wave = "soliton_sech"
eps = 0.1
t0 = 0
snapshots = [10]
observables = ["strain"]
parameters = {{ A = 1 }}
lattice = {{ K2 = 1, K4 = 1 }}
scheme = {{ step = {step} }}
domain = {{ kind = "ring", sites = {sites}, compared = 100 }}
[grid]
lattice.K4 = {{ from = 1, to = 2, count = {count} }}
"""


def requested(folder: Path, **changes: Any) -> str:
    path = folder / "asked.toml"
    path.write_text(SWEEP.format(**({"step": 0.5, "sites": 4096, "count": 3} | changes)))
    return str(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"step": 1e-7}, "asked, 3 cells, must take at most 60 min, got about"),
        ({"sites": 400_000_000}, "asked, 3 cells, must fit"),
        ({"step": 1e-3, "count": 100_000}, "asked, 100000 cells, estimated from"),
    ],
)
def test_an_expensive_sweep_is_refused_before_it_starts(
    changes: dict[str, Any],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["sweep", requested(tmp_path, **changes), "--processes", "1"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert message in error
    assert "or cheaper cells, or raise --max-" in error
    assert not list(tmp_path.rglob("*.h5"))


def test_memory_is_summed_over_concurrent_cells(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["sweep", requested(tmp_path), "--max-memory", "700M", "--processes", "3"]
    assert main(words) == 2
    assert "must fit 700 MB, got about 9" in capsys.readouterr().err


def costing(monkeypatch: pytest.MonkeyPatch, seconds: dict[float, float]) -> None:
    """Make the cost of a cell depend on its K4."""
    monkeypatch.setattr(
        sweep_cost,
        "expected_cell_cost",
        lambda scene: ExpectedCost(seconds[dict(scene.constants)["K4"]], 7.0),
    )


def sweep(**grid: list[float]) -> Sweep:
    return sweep_of({"scene": "gardner_soliton", "grid": grid})


def test_stored_cells_cost_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    costing(monkeypatch, {1.0: 3.0, 2.0: 50.0})
    requested = sweep(**{"constants.K4": [1.0, 2.0]})
    store = RunStore(tmp_path)
    whole = expected_sweep_cost(requested, store, ())
    assert (whole.sampled, whole.missing, whole.seconds) == (2, 2, 53.0)
    assert whole.on_workers(2, share_memory=True) == ExpectedCost(28.0, 14.0)
    assert whole.on_workers(2, share_memory=False) == ExpectedCost(28.0, 7.0)
    rest = expected_sweep_cost(requested, store, {store.key(requested.scene(1))})
    assert (rest.missing, rest.seconds) == (1, 3.0)
    assert rest.on_workers(2, share_memory=True).memory_bytes == 7.0


def test_a_large_sweep_is_estimated_from_a_sample(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep_cost, "FREE_SAMPLING_SECONDS", 1e9)
    monkeypatch.setattr(sweep_cost, "MAX_SAMPLING_SECONDS", 1e9)
    costing(monkeypatch, {1.0: 0.0, 2.0: 2.0})
    eps = [0.1 + 1e-6 * i for i in range(200_000)]
    found = expected_sweep_cost(
        sweep(eps=eps, **{"constants.K4": [1.0, 2.0]}), RunStore(tmp_path), ()
    )
    assert found.sampled == 200
    assert found.description == "400000 cells, estimated from 200 of them"
    assert found.seconds == pytest.approx(4e5, rel=0.2)


def test_an_exponential_force_costs_more_than_a_polynomial() -> None:
    toda, alpha = (
        load_scene(name).changed(observables=["strain", "momentum"])  # on rings
        for name in ("toda_soliton", "alpha_fput_soliton")
    )
    stiff = toda.changed(constants={"a": 1, "b": 99})
    # the same cells and steps; a stiff one takes more of these
    assert expected_cost(toda).steps == pytest.approx(expected_cost(alpha).steps, rel=0.1)
    toda_runs, alpha_runs = (one.seconds - one.once for one in map(expected_cost, (toda, alpha)))
    assert toda_runs > 1.5 * alpha_runs
    assert expected_cost(stiff).seconds > 10.0


def test_a_cell_that_failed_at_a_limit_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweep_cells, "keep_to_one_core", lambda: None)
    scene = load_scene("alpha_fput_soliton")
    cell = Cell(0, "key", scene)
    (tmp_path / "packs").mkdir()
    (tmp_path / "mark").touch()
    batch = run_cells([cell], tmp_path, "mark", RequestLimits(1e6, 1.0))
    assert batch.statuses == ["failed"]
    assert "must fit 1 MB, got about" in batch.first_fault
    assert cell.key not in RunStore(tmp_path).stored_runs()

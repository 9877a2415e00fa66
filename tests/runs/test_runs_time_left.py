"""Catches: a sweep with minutes left that reports seconds or hours."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import pytest

from longwave.runs import sweep_cells
from longwave.runs.run_pack import DONE, CellRecord
from longwave.runs.sweep import SweepState
from longwave.runs.sweep_cells import Batch, Cell, run_cells
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.engines.sideband_growth import growth_plan
from longwave.support.request_limits import ExpectedCost

LOADING = 8.0
"""Seconds of a worker's first batch beside its cells."""


def ratios(
    expected: Sequence[float],
    taken: Sequence[float],
    ends: Sequence[int],
    looked_at: Sequence[int],
) -> Iterator[float]:
    """Return estimated over true remaining time, from the second batch to the last tenth.

    Batches end before the cells ``ends``.
    """
    state = SweepState(len(taken), expected={number: expected[number] for number in looked_at})
    for first, end in pairwise((0, *ends)):
        seconds = sum(taken[first:end]) + (0.0 if first else LOADING)
        result = Batch([DONE] * (end - first), seconds, seconds, seconds)
        state.count(Batch(**vars(result) | {"expected": sum(expected[first:end])}), end)
        left = sum(taken[end:])
        if first and left > 0.1 * sum(taken):
            yield state.seconds_left / left
    assert state.seconds_left == 0.0


CELLS = 120
ENDS = (1, 2, 4, 8, *range(14, CELLS, 6), CELLS)


@pytest.mark.parametrize(
    ("expected", "taken"),
    [
        ([1.0] * CELLS, [0.1] * CELLS),
        # by chance more of the cheap ones were looked at
        ([0.2, 3.0, 0.2] * 40, [0.3, 2.0, 0.4] * 40),
        # the dear come first, and take less than was expected; the cheap more
        ([3.0] * 20 + [0.3] * 100, [2.0] * 20 + [0.45] * 100),
        ([0.3] * 100 + [3.0] * 20, [0.45] * 100 + [2.0] * 20),
    ],
    ids=["even", "in turn", "dear first", "dear last"],
)
def test_the_time_left_is_estimated_within_a_factor_of_two(
    expected: list[float], taken: list[float]
) -> None:
    looked_at = [3, 10, 30, 42, 60, 76, 84, 99, 105, 110, 117]
    found = list(ratios(expected, taken, ENDS, looked_at))
    assert len(found) > 10
    assert 0.5 < min(found) <= max(found) < 2.0, found


def test_stored_cells_ahead_add_no_time() -> None:
    """The second half of a hundred cells is stored; the sweep reaches it after the first half."""
    looked_at = {number: 1.0 if number < 50 else 0.0 for number in range(0, 100, 5)}
    state = SweepState(100, expected=looked_at)
    for end in (10, 20):
        state.count(Batch([DONE] * 10, 20.0, 20.0, 20.0, expected=10.0), end)
    assert state.seconds_left == pytest.approx(60.0, rel=0.4)


def test_workers_share_what_is_left() -> None:
    state = SweepState(12, workers=2, expected=dict.fromkeys(range(12), 1.0))
    for end in (1, 2):
        state.count(Batch([DONE], 9.0, 9.0, 9.0, expected=1.0), end)
    assert not any(state.recent)
    for end in (3, 4):
        state.count(Batch([DONE], 3.0, 3.0, 3.0, expected=1.0), end)
    assert state.seconds_left == pytest.approx(8 * 3.0 / 2)


def test_a_batch_is_estimated_from_some_of_its_cells_before_they_run(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Derivations of the estimate are cached for the run of the same cell only."""
    met: list[str] = []

    def cost(_: object) -> ExpectedCost:
        met.append("judged")
        return ExpectedCost(2.0)

    def run(cell: Cell, _: object) -> CellRecord:
        met.append("run")
        return CellRecord(cell.key, DONE)

    monkeypatch.setattr(sweep_cells, "keep_to_one_core", lambda: None)
    monkeypatch.setattr(sweep_cells, "expected_cell_cost", cost)
    monkeypatch.setattr(sweep_cells, "run_cell", run)
    scene = load_scene("gardner_soliton")
    cells = [Cell(number, str(number), scene) for number in range(20)]
    batch = run_cells(cells, tmp_path, "elsewhere")
    assert batch.expected == pytest.approx(40.0)
    assert met.count("judged") == sweep_cells.MAX_ESTIMATED
    assert all(later == "run" for one, later in pairwise(met) if one == "judged")


def test_a_growth_rate_is_planned_once_for_its_cost_and_its_run() -> None:
    from longwave.runs.sweep_file import load_sweep

    growth = load_sweep("growth_over_k")
    assert growth_plan(growth.scene(0)) is growth_plan(growth.scene(0))

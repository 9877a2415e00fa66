"""Sweeps in one process: saving, resuming, recording of errors, and results."""

import ctypes
import errno
import signal
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from longwave.cli import scene_command
from longwave.cli.scene_command import run_and_print
from longwave.runs import run_pack, run_store, sweep_cells
from longwave.runs.run_file import load_run
from longwave.runs.run_pack import CellRecord, load_row, read_pack, write_pack
from longwave.runs.run_store import RunStore
from longwave.runs.store_packs import pack_index
from longwave.runs.sweep import MAX_LOST_WORKERS, SweepState, run_sweep, run_with_progress
from longwave.runs.sweep_cells import Cell, numbers_of, run_cells
from longwave.runs.sweep_cost import expected_sweep_cost
from longwave.runs.sweep_dataset import cell_run, sweep_dataset, write_sweep
from longwave.runs.sweep_file import Sweep, sweep_of
from longwave.runs.sweep_workers import process_code
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.engines import scene_run
from longwave.support.compiled import cores
from longwave.support.processes import Call, Job, LostProcess
from tests.runs.unfinished_scenes import bits

SMALL = {
    "wave": "soliton_sech",
    "eps": 0.1,
    "t0": 0,
    "snapshots": [0, 5],
    "curve_points": 3,
    "lattice": {"K2": 1, "K4": 1},
    "parameters": {"A": 1},
    "scheme": {"step": 0.5},
    "domain": {"kind": "window", "sites": 1024, "compared": 20},
}


@pytest.fixture(autouse=True)
def _cores() -> Iterator[None]:
    """Keep cells from limiting this process to one core."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(cores, "_alone", False)
        yield


class HereWorkers:
    """Workers that run calls at once in this process; ``lose`` selects cells that lose their
    worker."""

    count = 2

    def __init__(self, lose: Callable[[list[Cell]], bool] = lambda _: False) -> None:
        self.lose, self.cells = lose, 0
        self.calls: list[Call] = []

    def submit(self, job: Job) -> Call:
        call = Call(job)
        self.calls.append(call)
        if self.lose(job.arguments[0]):
            call.error = LostProcess("gone")
        else:
            self.cells += len(job.arguments[0])
            try:
                call.value = job.run(lambda _: None)
            except Exception as error:
                call.error = error
        return call

    def ended(self, seconds: float) -> list[Call]:
        found, self.calls = self.calls, []
        return found

    def stop(self) -> None:
        pass


def small_sweep(**varied: Any) -> Sweep:
    return sweep_of({"scene": SMALL, "grid": varied or {"eps": [0.1, 0.2], "parameters.A": [1, 2]}})


@pytest.fixture
def store(tmp_path: Path) -> RunStore:
    return RunStore(tmp_path / "store")


def test_a_sweep_has_the_bits_of_its_runs(store: RunStore) -> None:
    sweep = small_sweep()
    state = run_sweep(sweep, store, HereWorkers())
    assert (state.done, state.stored, state.faults) == (4, 0, 0)
    found = sweep_dataset(sweep, store)
    assert found.sizes == {"eps": 2, "A": 2, "time": 2, "site": 41, "curve_time": 3}
    assert found.status.values.tolist() == [["done"] * 2] * 2
    for cell, (i, j) in enumerate(np.ndindex(2, 2)):
        run = scene_run.run(sweep.scene(cell))
        xr.testing.assert_identical(
            cell_run(sweep, store, eps=i, A=j).drop_attrs(deep=False), run.drop_attrs(deep=False)
        )
        row = found.isel(eps=i, A=j)
        np.testing.assert_array_equal(row.strain.values, run.strain.values)
        assert float(row.error) == float(run.error.max())
        assert int(row.steps) == run.attrs["steps"]
        assert float(row.eps) == (0.1, 0.2)[i]


def test_attributes_are_restored(store: RunStore) -> None:
    sweep = small_sweep(eps=[0.1])
    run_sweep(sweep, store, HereWorkers())
    saved_item = cell_run(sweep, store, eps=0).attrs
    run = scene_run.run(sweep.scene(0)).attrs
    timed = {"seconds", "planning_seconds"}
    assert {k: v for k, v in saved_item.items() if k not in timed} == {
        k: v for k, v in run.items() if k not in timed
    }


def test_fields_are_read_lazily(store: RunStore, monkeypatch: pytest.MonkeyPatch) -> None:
    from longwave.runs import sweep_fields

    sweep = small_sweep()
    run_sweep(sweep, store, HereWorkers())
    read: list[str] = []
    rows = sweep_fields._read_rows

    def counted(field: str, places: Any) -> Any:
        read.append(field)
        return rows(field, places)

    monkeypatch.setattr(sweep_fields, "_read_rows", counted)
    found = sweep_dataset(sweep, store)
    assert "strain" not in read
    part = found.strain.isel(eps=1, A=slice(None), site=[0, 20])
    assert "strain" not in read
    whole = np.stack([scene_run.run(sweep.scene(cell)).strain.values for cell in (2, 3)])
    np.testing.assert_array_equal(part.values, whole[..., [0, 20]])
    assert "strain" in read
    every = found.strain.values
    np.testing.assert_array_equal(every[1], whole)
    np.testing.assert_array_equal(found.strain[::-1, 0, -1].values, every[::-1, 0, -1])
    assert float(found.strain[1, 0, -1, 20]) == every[1, 0, -1, 20]


LATTICE = {
    "lattice": "toda",
    "wave": "kdv_soliton",
    "eps": 0.2,
    "slow_times": [0, 0.1],
    "half_width": 6,
    "constants": {"a": 1, "b": 1},
    "parameters": {"kappa": 1},
}
TO_TOLERANCE = {k: v for k, v in SMALL.items() if k != "scheme"} | {"domain": {"compared": 20}}
MEASURED = {"observables": ["strain", "time_step_error", "domain_error"]}
KINDS: dict[str, tuple[dict[str, Any], str, list[float]]] = {
    "a lattice": (LATTICE, "tolerance", [1e-2, 1e-9]),
    "snapshots": (TO_TOLERANCE, "tolerance", [1e-2, 1e-9]),
    "a curve": (TO_TOLERANCE | {"observables": ["error_curve"]}, "tolerance", [1e-2, 1e-9]),
    "stated steps": (SMALL | MEASURED, "scheme.step", [1.0, 0.1]),
    "stated steps of order two": (
        SMALL | MEASURED | {"scheme": {"name": "stoermer_verlet", "step": 1}},
        "scheme.step",
        [0.5, 0.05],
    ),
    "their curve": (
        SMALL | {"observables": ["error_curve", "time_step_error"]},
        "scheme.step",
        [1.0, 0.1],
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_errors_of_cells_have_their_own_error(kind: str, store: RunStore) -> None:
    """They include the error of a much finer run, scaled to ``error`` as the strains are."""
    scene, field, values = KINDS[kind]
    sweep = sweep_of({"scene": scene, "grid": {field: values}})
    run_sweep(sweep, store, HereWorkers())
    found = sweep_dataset(sweep, store)
    (coarse, fine), (own, finer) = found.error.values, found.own_error.values
    assert 0.0 < finer < 0.1 * own
    assert abs(coarse - fine) <= own
    measured = [found[name][0, -1] for name in ("time_step_error", "domain_error") if name in found]
    output = float(2.0 * sum(measured) if measured else found.error_estimate[0])
    seen = {} if scene is LATTICE else {"observables": ["strain"]}
    run = scene_run.run(sweep_of({"scene": scene | seen, "grid": {field: values}}).scene(0))
    apart = float(abs(run.strain - run.analytic).max())
    unit = scene["eps"] ** (2 if scene is LATTICE else 1)
    assert own / coarse == pytest.approx(unit * output / apart, rel=0.01)
    assert found.own_error.attrs["units"] == found.error.attrs["units"]


def test_a_run_without_a_measured_error_has_no_own_error(store: RunStore) -> None:
    run_sweep(small_sweep(eps=[0.1]), store, HereWorkers())
    record = pack_index(store.folder).table.record(0)
    assert record.numbers["error"] > 0.0
    assert np.isnan(record.numbers["own_error"])


def test_stored_cells_are_not_run_again(store: RunStore) -> None:
    run_sweep(small_sweep(eps=[0.1, 0.2]), store, HereWorkers())
    store.keep(small_sweep(eps=[0.3]).scene(0), scene_run.run(small_sweep(eps=[0.3]).scene(0)))
    workers = HereWorkers()
    sweep = small_sweep(eps=[0.1, 0.3, 0.4, 0.2])
    state = run_sweep(sweep, store, workers)
    assert (workers.cells, state.stored, state.done) == (1, 3, 1)
    assert sweep_dataset(sweep, store).status.values.tolist() == ["done"] * 4
    again = HereWorkers()
    run_sweep(sweep, store, again)
    assert again.cells == 0


def test_the_finished_share_and_the_seconds_left_are_reported(store: RunStore) -> None:
    sweep, shares, left = small_sweep(eps=[0.1, 0.2, 0.3, 0.4]), list[float](), list[float]()
    stored_values = store.stored_runs()
    state = SweepState(
        len(sweep), expected=expected_sweep_cost(sweep, store, stored_values).seconds_by_cell
    )
    run_with_progress(
        sweep, store, HereWorkers(), state, stored_values, (shares.append, left.append)
    )
    assert shares[-1] == 1.0
    assert shares == sorted(shares)
    assert left[-1] == 0.0
    assert len(left) < len(shares) or left[0] > 0.0
    run_with_progress(
        sweep, RunStore(store.folder / "b"), HereWorkers(), state, (), (shares.append, None)
    )


def test_cells_with_one_scene_are_run_once(store: RunStore) -> None:
    workers = HereWorkers()
    sweep = sweep_of({"scene": SMALL, "list": {"eps": [0.1, 0.2, 0.1, 0.1], "t0": [0, 0, 0, 0.0]}})
    assert expected_sweep_cost(sweep, store, ()).missing == 2
    state = run_sweep(sweep, store, workers)
    assert (workers.cells, state.stored, state.done) == (2, 2, 2)
    errors = sweep_dataset(sweep, store).error.values
    assert errors[0] == errors[2] == errors[3] != errors[1]


def test_a_run_is_read_though_an_attempt_failed_before(store: RunStore) -> None:
    """As if a process was killed after it saved a long run's file and before it wrote its pack."""
    sweep = small_sweep(eps=[0.1])
    key = store.key(sweep.scene(0))
    (store.folder / "packs").mkdir(parents=True)
    write_pack(store.folder / "packs" / "0.h5", [CellRecord(key, "failed", "no room")])
    store.fetch(sweep.scene(0))
    workers = HereWorkers()
    run_sweep(sweep, store, workers)
    found = sweep_dataset(sweep, store)
    assert (workers.cells, found.status.item(), found.message.item()) == (0, "done", "")
    assert found.error.item() > 0


def test_a_complete_store_is_not_written(store: RunStore) -> None:
    """So a read-only store works."""
    sweep = small_sweep()
    run_sweep(sweep, store, HereWorkers())
    before = store.folder.stat().st_mtime_ns
    run_sweep(sweep, store, HereWorkers())
    assert store.folder.stat().st_mtime_ns == before


@pytest.mark.parametrize("kind", ["grid", "list", "random"])
def test_swept_fields_named_like_numbers_of_cells_get_a_prefix(
    kind: str, store: RunStore, tmp_path: Path
) -> None:
    varied: dict[str, Any] = {"domain.sites": [1024, 2048], "domain.compared": [20, 30]}
    if kind == "random":
        varied = {"count": 2, "seed": 1, "domain.sites": {"choose": [1024]}}
    sweep = sweep_of({"scene": SMALL, kind: varied})
    run_sweep(sweep, store, HereWorkers())
    found = write_sweep(sweep, store, tmp_path / "sweep.nc")
    assert found.domain_sites.attrs["field"] == "domain.sites"
    np.testing.assert_array_equal(
        found.sites, xr.broadcast(found.sites, found.domain_sites)[1].transpose(*found.sites.dims)
    )


def test_a_run_is_found_by_the_command_and_by_the_store(
    store: RunStore,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Both return all of its bits; a damaged pack is ignored."""
    text = small_sweep(eps=[0.1]).scene(0).changed(name="small").toml()
    (tmp_path / "small.toml").write_text(text, encoding="utf-8")
    sweep = sweep_of({"scene": "small.toml", "grid": {"eps": [0.1, 0.2]}}, folder=tmp_path)
    scene = load_scene(str(tmp_path / "small.toml"))
    whole = bits(scene_run.run(scene))
    run_sweep(sweep, store, HereWorkers())
    monkeypatch.setattr(scene_run, "run", None)
    monkeypatch.setattr(scene_command, "record_scene", None)
    path, saved_item = str(tmp_path / "small.toml"), str(store.folder)
    assert run_and_print(path, "longwave run", store=saved_item) == 0
    output = capsys.readouterr()
    stored_values = pack_index(store.folder).get(store.key(scene))
    assert stored_values is not None
    assert stored_values[1] is not None
    pack = stored_values[1].path
    assert output.err == f"small: found in {pack}, not run again\n"
    assert "10 steps, 1024 sites" in output.out
    assert store.find(scene) is None
    assert bits(store.run(scene)) == whole
    path = store.fetch(scene)
    assert bits(load_run(path)) == whole
    assert store.find(scene) == path
    pack.write_bytes(pack.read_bytes()[:-1])
    path.unlink()
    with pytest.raises(TypeError):
        store.run(scene)


RUN = scene_run.run


def test_a_cell_that_fails_is_recorded_and_the_others_go_on(
    store: RunStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(scene: Any, **output: Any) -> xr.Dataset:
        if scene.eps == 0.4:
            raise MemoryError("no room")
        return RUN(scene, **output)

    monkeypatch.setattr(scene_run, "run", run)
    sweep = small_sweep(eps=[0.1, -1, 0.4, 0.2], **{"parameters.A": [1, -2]})
    state = run_sweep(sweep, store, HereWorkers())
    found = sweep_dataset(sweep, store)
    assert found.status.values.tolist() == [
        ["done", "refused"],
        ["refused", "refused"],
        ["failed", "failed"],
        ["done", "refused"],
    ]
    assert state.faults == 6
    assert "A must satisfy" in str(found.message.values[0, 1])
    assert str(found.message.values[1, 0]).startswith("eps must satisfy eps > 0, got -1")
    assert found.message.values[2, 0] == "MemoryError: no room"
    assert np.isnan(found.error.values).tolist() == [
        [False, True],
        [True, True],
        [True, True],
        [False, True],
    ]
    monkeypatch.undo()
    again = HereWorkers()
    run_sweep(sweep, store, again)
    assert again.cells == 2
    assert sweep_dataset(sweep, store).status.values[2, 0] == "done"


def test_cells_not_yet_run_are_missing(store: RunStore) -> None:
    run_sweep(small_sweep(eps=[0.1]), store, HereWorkers())
    found = sweep_dataset(small_sweep(eps=[0.1, 0.2]), store)
    assert found.status.values.tolist() == ["done", "missing"]
    assert np.isnan(found.strain.values[1]).all()
    with pytest.raises(ValueError, match="must have a run, got none: missing"):
        cell_run(small_sweep(eps=[0.1, 0.2]), store, eps=1)


def test_fields_of_different_shapes_are_left_to_each_run(store: RunStore) -> None:
    sweep = small_sweep(**{"domain.compared": [20, 30], "snapshots": [[0, 5], [0, 4]]})
    run_sweep(sweep, store, HereWorkers())
    found = sweep_dataset(sweep, store)
    assert "strain" not in found
    assert found.cell_time.values[0].tolist() == [[0, 5], [0, 4]]
    assert found.snapshots.values.tolist() == ["[0, 5]", "[0, 4]"]
    assert cell_run(sweep, store, compared=1, snapshots=0).sizes["site"] == 61


def test_fields_missing_in_some_runs_are_left_to_each_run(store: RunStore) -> None:
    sweep = small_sweep(observables=[["strain"], ["strain", "error_curve"]])
    run_sweep(sweep, store, HereWorkers())
    found = sweep_dataset(sweep, store).load()
    assert "strain" in found
    assert "error_curve" not in found
    assert "error_curve" in cell_run(sweep, store, observables=1)


def test_a_worker_with_other_code_is_refused(store: RunStore, tmp_path: Path) -> None:
    """The key of its runs would be wrong; the message names versions and folders that differ."""
    (cell,) = [Cell(0, "key", small_sweep(eps=[0.1]).scene(0))]
    run_cells([cell], tmp_path, "", None, process_code())
    here = dict(process_code())
    other = {name: text.replace("numpy ", "numpy 0.") for name, text in here.items()}
    with pytest.raises(ValueError, match=r"^workers must have .* versions: numpy .*, here numpy 0"):
        run_cells([cell], tmp_path, "", None, other | {"digest": "another"})
    assert not list(tmp_path.rglob("*.h5"))


def test_an_error_of_a_worker_ends_the_sweep_in_one_line(store: RunStore) -> None:
    class Old(HereWorkers):
        def submit(self, job: Job) -> Call:
            return super().submit(replace(job, arguments=(*job.arguments, "more")))

    with pytest.raises(ValueError, match=r"^workers must run cells, got TypeError: .*longwave"):
        run_sweep(small_sweep(eps=[0.1]), store, Old())


def test_cells_of_lost_workers_are_run_again(store: RunStore) -> None:
    lost: list[float] = []

    def once(cells: list[Cell]) -> bool:
        for cell in cells:
            if cell.scene.eps not in lost:
                lost.append(cell.scene.eps)
                return True
        return False

    sweep = small_sweep(eps=[0.1, 0.2, 0.3])
    state = run_sweep(sweep, store, HereWorkers(once))
    assert state.done == 3
    assert sweep_dataset(sweep, store).status.values.tolist() == ["done"] * 3


def test_a_cell_that_kills_its_workers_is_given_up(store: RunStore) -> None:
    killed: list[int] = []

    def deadly(cells: list[Cell]) -> bool:
        if any(cell.scene.eps == 0.2 for cell in cells):
            killed.append(len(cells))
            return True
        return False

    sweep = small_sweep(eps=[0.1, 0.2, 0.3])
    run_sweep(sweep, store, HereWorkers(deadly))
    found = sweep_dataset(sweep, store)
    assert found.status.values.tolist() == ["done", "failed", "done"]
    assert "its worker process ended 3 times" in str(found.message.values[1])
    assert killed[1:] == [1] * MAX_LOST_WORKERS


def _run_long(
    scene: Any, progress: Any = None, announce: Callable[[float], None] | None = None
) -> xr.Dataset:
    """Run a scene; announce one with eps = 0.2 as a long run."""
    if announce is not None:
        announce(100.0 if scene.eps == 0.2 else 1.0)
    return RUN(scene)


def test_long_cells_have_files_of_their_own(
    store: RunStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_run, "run", _run_long)
    sweep = small_sweep(eps=[0.1, 0.2])
    run_sweep(sweep, store, HereWorkers())
    assert [store.find(sweep.scene(cell)) is None for cell in (0, 1)] == [True, False]
    found = sweep_dataset(sweep, store)
    np.testing.assert_array_equal(
        found.strain.values[1], scene_run.run(sweep.scene(1)).strain.values
    )


def test_a_long_run_that_is_damaged_or_missing_is_computed_again(
    store: RunStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_run, "run", _run_long)
    sweep = small_sweep(eps=[0.1, 0.2])
    run_sweep(sweep, store, HereWorkers())
    path = store.path(sweep.scene(1))
    path.write_bytes(path.read_bytes()[:1000])
    workers = HereWorkers()
    run_sweep(sweep, store, workers)
    assert workers.cells == 1
    path.unlink()
    monkeypatch.undo()  # a faster machine: the run goes into a pack
    run_sweep(sweep, store, HereWorkers())
    run_sweep(sweep, store, workers)
    assert workers.cells == 1
    assert bits(cell_run(sweep, store, eps=1)) == bits(scene_run.run(sweep.scene(1)))


def test_a_long_run_that_cannot_be_saved_goes_into_the_pack(
    store: RunStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, run: xr.Dataset) -> Path:
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    monkeypatch.setattr(scene_run, "run", _run_long)
    monkeypatch.setattr(run_store, "_save", full)
    sweep = small_sweep(eps=[0.2])
    assert run_sweep(sweep, store, HereWorkers()).faults == 0
    assert bits(cell_run(sweep, store, eps=0)) == bits(scene_run.run(sweep.scene(0)))


def test_a_cell_refused_for_changed_sources_is_tried_again(
    store: RunStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene_run, "run", _run_long)
    for module in (run_store, sweep_cells):
        monkeypatch.setattr(module, "runs_its_sources", lambda: False)
    sweep = small_sweep(eps=[0.2])
    run_sweep(sweep, store, HereWorkers())
    found = sweep_dataset(sweep, store)
    assert "sources must not change" in found.message.item()
    monkeypatch.undo()
    run_sweep(sweep, store, HereWorkers())
    assert sweep_dataset(sweep, store).status.item() == "done"


def test_a_pack_keeps_bits_and_separates_layouts(tmp_path: Path) -> None:
    values = np.array([[np.nan, -0.0, 5e-324], [np.inf, 1 / 3, -np.inf]])
    runs = [
        xr.Dataset({"a": (("x", "y"), values * s)}, {"x": [1, 2]}, {"n": s, "t": "é", "l": [1, 2]})
        for s in (1.0, 2.0)
    ]
    other = xr.Dataset({"a": ("x", np.arange(2000.0))})
    records = [CellRecord("k1", "done", "", {"error": 0.5}, runs[0])]
    records += [CellRecord("k2", "done", "", {}, other), CellRecord("k3", "refused", "no")]
    records += [CellRecord("k4", "done", "", {}, runs[1])]
    write_pack(tmp_path / "a.h5", records)
    table = read_pack(tmp_path / "a.h5")
    found = {key.decode(): place for place, key in enumerate(table.key)}
    for key, run in (("k1", runs[0]), ("k2", other), ("k4", runs[1])):
        place = found[key]
        loaded = load_row(tmp_path / "a.h5", int(table.group[place]), int(table.row[place]))
        xr.testing.assert_identical(loaded, run)
        assert loaded.a.values.tobytes() == run.a.values.tobytes()
    refused = table.record(found["k3"])
    assert (refused.key, refused.status, refused.message) == ("k3", "refused", "no")
    assert table.row[found["k3"]] == -1
    assert table.record(found["k1"]).numbers["error"] == 0.5


def test_a_pack_keeps_a_number_that_only_some_of_its_cells_have(tmp_path: Path) -> None:
    some = {"error": 0.5, "last_peak": 0.25, "growth_rate": 3.0}
    write_pack(
        tmp_path / "a.h5",
        [CellRecord("k1", "done", "", some), CellRecord("k2", "done", "", {"error": 0.25})],
    )
    table = read_pack(tmp_path / "a.h5")
    first, second = (table.record(place).numbers for place in range(2))
    assert {name: first[name] for name in some} == some
    assert np.isnan([second["last_peak"], second["growth_rate"]]).all()
    assert "last_delay" not in first


def test_the_error_of_a_cell_is_the_largest_without_nan() -> None:
    """A run that blew up, or has no wave at some times, has NaN there."""
    scene = load_scene("toda_soliton")
    for values, largest in (([np.nan, 0.5, 0.25], 0.5), ([0.125, np.nan], 0.125)):
        run = xr.Dataset({"error": ("time", values)}, attrs={"own_error": 0.0})
        assert numbers_of(scene, run)["error"] == largest
    assert "error" not in numbers_of(scene, xr.Dataset({"error": ("time", [np.nan])}))


def test_a_pack_without_a_number_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Such as a pack from before that number was introduced."""
    fewer = {name: output for name, output in run_pack.NUMBERS.items() if name != "own_error"}
    with monkeypatch.context() as before:
        before.setattr(run_pack, "NUMBERS", fewer)
        write_pack(tmp_path / "a.h5", [CellRecord("k", "done", "", {"error": 0.5})])
    record = read_pack(tmp_path / "a.h5").record(0)
    assert record.numbers["error"] == 0.5
    assert np.isnan(record.numbers.get("own_error", np.nan))


def test_a_damaged_pack_is_ignored(store: RunStore) -> None:
    sweep = small_sweep(eps=[0.1])
    run_sweep(sweep, store, HereWorkers())
    (pack,) = (store.folder / "packs").rglob("*.h5")
    content = pack.read_bytes()
    for broken in (content[: len(content) // 2], b"", bytes([content[300] ^ 1])):
        pack.write_bytes(broken)
        assert len(pack_index(store.folder)) == 0
    middle = len(content) // 2
    pack.write_bytes(content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :])
    assert len(pack_index(store.folder)) == 0


def test_the_written_data_set_is_plain(store: RunStore, tmp_path: Path) -> None:
    sweep = small_sweep()
    run_sweep(sweep, store, HereWorkers())
    written = write_sweep(sweep, store, tmp_path / "out.nc")
    with xr.open_dataset(tmp_path / "out.nc", engine="h5netcdf") as read:
        np.testing.assert_array_equal(read.error.values, written.error.values)
        assert read.status.values.tolist() == written.status.values.tolist()
        assert read.A.attrs["field"] == "parameters.A"
        assert read.error.attrs["long_name"]


def test_a_coordinate_of_texts_stays_a_coordinate(store: RunStore) -> None:
    """Catches: texts compared as if they could be NaN, which raises an error."""
    tables = {"scene": "dimer_peregrine", "set": {"tolerance": 0.1}, "grid": {"eps": [0.2, 0.25]}}
    sweep = sweep_of(tables)
    run_sweep(sweep, store, HereWorkers())
    found = sweep_dataset(sweep, store)
    assert found.quantity.values.tolist() == ["v[n] - u[n]", "u[n+1] - v[n]"]


def test_a_folder_among_the_packs_is_passed_over(store: RunStore) -> None:
    (store.folder / "packs" / "x.h5").mkdir(parents=True)
    assert len(pack_index(store.folder)) == 0


def test_no_other_file_is_left_in_the_store(store: RunStore) -> None:
    run_sweep(small_sweep(eps=[0.1]), store, HereWorkers())
    names = [path.name for path in store.folder.rglob("*") if path.is_file()]
    assert len(names) == 1
    assert names[0].endswith(".h5")


def test_a_worker_stopped_inside_a_c_callback_prints_nothing() -> None:
    """As in numba's compiler, which calls Python: the exception is discarded there with a
    traceback."""
    called: list[int] = []

    def told_to_end() -> None:
        called.append(1)
        signal.raise_signal(signal.SIGTERM)

    with sweep_cells._stop_on_sigterm():
        ctypes.CFUNCTYPE(None)(told_to_end)()
    assert called
